# SPDX-License-Identifier: MIT
"""Random packets at the permit, compared with a model of three servos; `make fuzz` runs more of them."""
# needs: build/host/test/permit_random
import subprocess
import unittest

from simulator import LONG, ROOT


class Permit(unittest.TestCase):
    def test_random_packets_keep_the_rules_of_the_model(self):
        for seed in ("1", "2", "3", "4"):
            with self.subTest(seed):
                done = subprocess.run([ROOT / "build/host/test/permit_random", "500000" if LONG else "50000", seed],
                                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                self.assertEqual(done.returncode, 0, done.stdout[-3000:])


if __name__ == "__main__":
    unittest.main()
