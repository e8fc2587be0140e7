# SPDX-License-Identifier: MIT
"""Noise and damage at random; `make fuzz` runs it at length."""
# needs: build/host/test/fuzz
import subprocess
import unittest

from simulator import LONG, ROOT

PACKETS, LINES = (200000, 20000) if LONG else (50000, 5000)  # for each of two seeds


class Fuzz(unittest.TestCase):
    def test_noise_and_damage(self):
        for seed in ("11", "12"):
            done = subprocess.run([ROOT / "build/host/test/fuzz", str(PACKETS), str(LINES), seed],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
