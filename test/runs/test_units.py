# SPDX-License-Identifier: MIT
"""A simulated servo driven and read in units: what it is told is what it does."""
# needs: build/atmega128/firmware/units.elf
import re
import unittest

from simulator import Run

STEP_MDEG = 300000 / 1023


class Units(unittest.TestCase):
    def test_goal_speed_and_direction_arrive_as_asked(self):
        run = Run("build/atmega128/firmware/units.elf", "--host", "stdout", "--seconds", "10")
        self.assertEqual(run.status, 0, run.output)
        self.assertNotIn("result", run.output)
        told = {name: [int(value) for value in re.findall(rf"^{name} (-?\d+)$", run.output, re.M)]
                for name in ["mdeg", "mrpm", "mV", "celsius"]}
        self.assertEqual([len(values) for values in told.values()], [2, 2, 2, 2], run.output)
        self.assertAlmostEqual(told["mdeg"][0], 180000, delta=3 * STEP_MDEG)  # the margin is 2
        self.assertEqual(told["mrpm"][0], 0)
        self.assertAlmostEqual(told["mrpm"][1], -20000, delta=1000)
        turned = told["mdeg"][0] - told["mdeg"][1]  # in a second, from a stand
        self.assertAlmostEqual(turned, 120000, delta=4000)
        self.assertTrue(all(9000 <= mV <= 13000 for mV in told["mV"]), told)
        self.assertTrue(all(20 <= celsius <= 60 for celsius in told["celsius"]), told)


if __name__ == "__main__":
    unittest.main()
