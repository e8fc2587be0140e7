# SPDX-License-Identifier: MIT
"""The cycle with 50 servos at 250 Hz, 5 s of it; `make cycle` runs a minute."""
# needs: build/atmega128/firmware/cycle50.elf build/atmega128/firmware/cycle50_safe.elf
import unittest

from cycle import Cycle


class FiftyServos(unittest.TestCase):
    def test_every_promise_is_kept(self):
        cycle = Cycle(5)
        self.assertEqual(cycle.broken(), [], cycle.output)

    def test_safety_costs_no_goal_and_no_read(self):
        cycle = Cycle(5, safe=True)
        self.assertEqual(cycle.broken(), [], cycle.output)


if __name__ == "__main__":
    unittest.main()
