"""A short run of what `make fuzz` does at length."""
import subprocess
import unittest

from simulator import ROOT


class Fuzz(unittest.TestCase):
    def test_noise_and_damage(self):
        for seed in ("11", "12"):
            done = subprocess.run([ROOT / "build/host/test/fuzz", "1000000", "100000", seed],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                  timeout=200)
            self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
