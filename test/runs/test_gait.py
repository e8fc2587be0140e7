# SPDX-License-Identifier: MIT
"""A tripod gait of 18 simulated servos: what leaves on the wire, and what a joint that is stuck does."""
# needs: build/atmega128/firmware/gait.elf
import csv
import pathlib
import tempfile
import unittest

from simulator import Run

ELF = "build/atmega128/firmware/gait.elf"
JOINTS = 18
LEGS = range(0, JOINTS, 3)  # index of the coxa; then femur, tibia
TRIPODS = (0, 6, 12), (3, 9, 15)  # coxas of the legs that step together
RIGHT = (9, 12, 15)
COXA, FEMUR = 512, 400
PERIOD = 250  # of the gait, in periods of the cycle
STEADY = slice(300, 740)  # periods in which the robot walks forwards
TURNING = slice(1050, 1490)
SWING_MIN = 100  # steps of a coxa in the air, in STEADY or TURNING
STEP_MAX = 5.08  # position steps in a period at full speed
LAG_MAX = 20  # steps
ARRIVED = 3  # steps: the compliance margin of a servo is 2
CANCELLED = 8
STALE_MS = 16  # age that feedback of 18 joints reaches at 250 Hz


def columns(path):
    """Goals and positions of all joints, a row for each period."""
    with open(path) as file:
        rows = list(csv.DictReader(file))
    return [[[int(row[f"{what}_{joint}"]) for joint in range(1, JOINTS + 1)] for row in rows]
            for what in ("goal", "present")]


class Gait(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "gait.csv")
            cls.run_ = Run(ELF, "--csv", path, "--seconds", "20", "--host", "stdout", servos="1-18")
            cls.goals, cls.present = columns(path)

    def joint(self, index, part):
        return [row[index] for row in self.goals[part]]

    def test_gait_ends_well_without_missed_periods(self):
        self.assertEqual(self.run_.status, 0, self.run_.output)
        self.assertIn("result 0\njoint 0\nmissed 0\n", self.run_.output)

    def test_legs_of_a_tripod_step_together(self):
        for tripod in TRIPODS:
            lift = self.joint(tripod[0] + 1, STEADY)
            for leg in tripod[1:]:
                self.assertEqual(self.joint(leg + 1, STEADY), lift)

    def test_other_tripod_steps_half_a_period_later(self):
        one, other = (self.joint(tripod[0] + 1, STEADY) for tripod in TRIPODS)
        half = PERIOD // 2
        self.assertLessEqual(max(abs(a - b) for a, b in zip(one, other[half:])), 1)

    def test_feet_of_one_tripod_stand_always(self):
        for row in self.goals[STEADY]:
            self.assertTrue(any(all(row[leg + 1] == FEMUR for leg in tripod) for tripod in TRIPODS))

    def test_coxas_swing_forwards_in_the_air(self):
        for leg in LEGS:
            side = -1 if leg in RIGHT else 1
            self.swings(leg, STEADY, side)
            self.swings(leg, TURNING, -side if leg in RIGHT else side)

    def swings(self, leg, part, direction):
        coxa, femur = self.joint(leg, part), self.joint(leg + 1, part)
        moves = [direction * (after - before)
                 for before, after, lift in zip(coxa, coxa[1:], femur) if lift > FEMUR + 2]
        self.assertGreaterEqual(min(moves), 0)
        self.assertGreater(sum(moves), SWING_MIN)

    def test_goals_do_not_jump_and_servos_follow(self):
        self.assertLess(min(map(min, self.goals)), COXA - 70)
        for before, after in zip(self.goals, self.goals[1:]):
            for a, b in zip(before, after):
                self.assertLessEqual(abs(a - b), STEP_MAX)
        for goals, present in zip(self.goals, self.present):
            self.assertLessEqual(max(abs(a - b) for a, b in zip(goals, present)), LAG_MAX)

    def test_gait_stops_in_the_rest_positions(self):
        rest = [COXA, FEMUR, 600] * 6
        self.assertEqual(self.goals[-1], rest)
        self.assertLessEqual(max(abs(a - b) for a, b in zip(self.present[-1], rest)), ARRIVED)


class Stuck(unittest.TestCase):
    def check(self, order, joint):
        """A swing of 80 steps to both sides takes 500 ms from end to end: the goal is 80 steps away
        within that; then 200 ms, twice the age of feedback, and the way to a standstill."""
        script = f"@at 2000\n{order}\n@expect text stuck {joint} within {500 + 200 + 2 * STALE_MS}\n" \
                 f"@expect servo 1-{JOINTS} torque off within 250\n@expect text torque_off 1 within 10\n" \
                 f"@expect text result {CANCELLED} within 10\n"
        run = Run(ELF, "--seconds", "20", servos="1-18", script=script)
        self.assertEqual(run.status, 0, run.output)

    def test_blocked_coxa_ends_the_gait_in_time(self):
        self.check("@block 4 on", 3)

    def test_overloaded_coxa_ends_the_gait_in_time(self):
        self.check("@load 10 1200", 9)


if __name__ == "__main__":
    unittest.main()
