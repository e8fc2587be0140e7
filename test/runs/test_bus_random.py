# SPDX-License-Identifier: MIT
"""The bus with its queue: random transactions, compared with a model; `make fuzz` runs more of them."""
# needs: build/host/test/bus_random
import subprocess
import unittest

from simulator import LONG, ROOT


class BusRandom(unittest.TestCase):
    def test_random_transactions_keep_the_rules_of_the_model(self):
        for seed in ("1", "2", "3", "4"):
            done = subprocess.run([ROOT / "build/host/test/bus_random", "500000" if LONG else "50000", seed],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            self.assertEqual(done.returncode, 0, done.stdout[-3000:])


if __name__ == "__main__":
    unittest.main()
