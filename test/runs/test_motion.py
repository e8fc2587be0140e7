# SPDX-License-Identifier: MIT
"""Timed moves of simulated servos: the joints arrive with their last goals, and goals are on the curves."""
# needs: $(patsubst %,build/atmega128/firmware/%.elf,motion curves)
import csv
import pathlib
import sys
import tempfile
import unittest

from simulator import ROOT, Run

sys.path.append(str(ROOT / "scripts"))
import motion_pictures

JOINTS = 18
MOVES = 12
ARRIVED = 3  # steps: the compliance margin of a servo is 2
QUIET = 60  # periods without a new goal: a move is over


def columns(path):
    """Goals and positions of all joints, a row for each period."""
    with open(path) as file:
        rows = list(csv.DictReader(file))
    return [[[int(row[f"{what}_{joint}"]) for joint in range(1, JOINTS + 1)] for row in rows]
            for what in ("goal", "present")]


def moves(goals):
    """(first row, last row) in which goals change, for each move."""
    changed = [row for row in range(1, len(goals)) if goals[row] != goals[row - 1]]
    found = []
    for row in changed:
        if found and row - found[-1][1] < QUIET:
            found[-1][1] = row
        else:
            found.append([row, row])
    return found


class Motion(unittest.TestCase):
    def test_joints_arrive_within_a_period_of_their_last_goals(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "motion.csv")
            run = Run("build/atmega128/firmware/motion.elf", "--csv", path, "--seconds", "60",
                      "--host", "stdout", servos=f"1-{JOINTS}")
            self.assertEqual(run.status, 0, run.output)
            self.assertIn(f"good {MOVES}\nmissed 0\n", run.output)
            goals, present = columns(path)
        found = moves(goals)
        self.assertEqual(len(found), MOVES)
        for first, last in found:
            for joint, (is_at, goal) in enumerate(zip(present[last + 1], goals[last]), 1):
                self.assertLessEqual(abs(is_at - goal), ARRIVED, f"joint {joint} in row {last}")
                self.assertNotEqual(present[first - 1], present[last])


class Curves(unittest.TestCase):
    """The moves of test/firmware/library/curves.c beside their formulas in real numbers."""

    @classmethod
    def setUpClass(cls):
        goals, positions, cls.moves, _ = motion_pictures.run("build/atmega128/firmware/curves.elf", 1)
        cls.goals, cls.positions = [row[0] for row in goals], [row[0] for row in positions]

    def rows_of(self, number, ideal):
        """Goals of a move from the first one on, and 0.2 s behind the last one."""
        first, last = self.moves[number]
        row = motion_pictures.first_goal(self.goals, first, ideal)
        return self.goals[row:last + 50]

    def test_goals_are_within_a_step_of_their_curve(self):
        self.assertEqual(len(self.moves), len(motion_pictures.MOVES))
        for number, (title, _, ideal, _, _) in enumerate(motion_pictures.MOVES):
            if ideal and title != motion_pictures.ONE_GOAL:
                with self.subTest(title):
                    end = motion_pictures.end_of(number)
                    for n, goal in enumerate(self.rows_of(number, ideal)):
                        self.assertLessEqual(abs(goal - ideal(min(n * 0.004, end))), 1, f"goal {n}")

    def test_no_goal_jumps(self):
        """The fastest joint goes 3.3 steps in a period."""
        for (title, *_), (first, last) in zip(motion_pictures.MOVES, self.moves):
            goals = self.goals[first - 5:last + 50]
            jumps = [abs(b - a) for a, b in zip(goals, goals[1:])]
            with self.subTest(title):
                self.assertTrue(max(jumps) <= 4 or (title == motion_pictures.ONE_GOAL and sorted(jumps)[-2] == 0))

    def test_a_pause_holds_the_joint_and_the_move_ends(self):
        goals = self.rows_of(6, motion_pictures.JERK)
        self.assertEqual(len(set(goals[180:200])), 1)  # it paused after 0.4 s and resumes after 0.8 s
        self.assertLess(goals[180], motion_pictures.GOAL)
        self.assertEqual(goals[-1], motion_pictures.GOAL)

    def test_an_abort_ends_the_move_on_its_way(self):
        goals = self.rows_of(7, motion_pictures.JERK)
        self.assertLess(goals[-1], motion_pictures.GOAL)
        for n in range(len(goals) - 1):
            self.assertIn(goals[n + 1] - goals[n], range(0, 4))  # it never turns back


if __name__ == "__main__":
    unittest.main()
