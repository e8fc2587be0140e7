# SPDX-License-Identifier: MIT
"""`pose ... in TIME` of the console: all joints arrive together, in each profile."""
# needs: $(CONSOLE_ELFS)
import csv
import pathlib
import tempfile
import unittest

import boards
from simulator import controller

JOINTS = 18
ARRIVED = 4  # steps
START = "echo off\n" + "".join(f"write {n} RETURN_DELAY 10\n" for n in range(1, JOINTS + 1)) + "torque 254 on\n"
GROUP = "group " + " ".join(str(n) for n in range(1, JOINTS + 1)) + "\n"


def pose(angles, rest):
    return "pose " + " ".join(str(angle) for angle in angles) + f" {rest}\n"


def rows_of(script, board):
    """(run, rows of the table of goals and positions)"""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "motion.csv")
        run = controller(START + GROUP + script, board, f"1-{JOINTS}", "--echo", "--csv", path)
        with open(path) as file:
            return run, [{name.removeprefix("bus0_"): value for name, value in row.items()}
                         for row in csv.DictReader(file)]


class Pose(unittest.TestCase):
    def test_joints_arrive_together(self):
        """Joints of long and short ways end their way within 150 ms of each other."""
        angles = [150 - 5 * n if n % 2 else 150 + 4 * n for n in range(1, JOINTS + 1)]
        goals = [round(angle * 1023 / 300) for angle in angles]
        for board in boards.CONSOLES:
            with self.subTest(board):
                run, rows = rows_of(pose(angles, "in 1.2s") + "@wait 2500\n", board)
                self.assertEqual(run.status, 0, run.output)
                arrivals = []
                for joint, goal in enumerate(goals, 1):
                    at = [abs(int(row[f"present_{joint}"]) - goal) <= ARRIVED for row in rows]
                    self.assertTrue(at[-1], f"joint {joint}")
                    arrivals.append(float(rows[at.index(True)]["time_ms"]))
                # a joint of a short way is near its goal sooner
                self.assertLess(max(arrivals) - min(arrivals[4:]), 150)

    def test_a_servo_in_endless_turn_is_refused(self):
        """It would turn for ever at the speed of the move."""
        for board in boards.CONSOLES:
            with self.subTest(board):
                run, rows = rows_of("scan\nturn 1 0\ntorque 1 on\ngroup 1\n! pose 90 in 2s\n"
                                    "@expect text error 47:\n@expect servo 1 MOVING_SPEED 0\n", board)
                self.assertEqual(run.status, 0, run.output)

    def test_a_new_pose_takes_the_place_of_the_one_under_way(self):
        """Goals change without a jump, and the joints end at the new pose."""
        for board in boards.WITH_MOTION:
            with self.subTest(board):
                run, rows = rows_of(pose([90] * JOINTS, "in 2s") + "@wait 1000\n"
                                    + pose([200] * JOINTS, "in 1.5s") + "@wait 2500\n", board)
                self.assertEqual(run.status, 0, run.output)
                goals = [int(row["goal_1"]) for row in rows]
                steps = [abs(after - before) for before, after in zip(goals, goals[1:])]
                self.assertLessEqual(max(steps), 6)  # 4 ms at 62 rpm are 5 steps
                self.assertEqual(goals[-1], 682)

    def test_only_a_timed_pose_replaces_a_motion_under_way(self):
        for board in boards.WITH_MOTION:
            with self.subTest(board):
                run, _ = rows_of(pose([90] * JOINTS, "in 1s") + "! " + pose([100] * JOINTS, "at 20rpm")
                                 + "@expect text error 58: a motion is under way\n"
                                 + "@wait 1500\n" + pose([100] * JOINTS, "at 20rpm"), board)
                self.assertEqual(run.status, 0, run.output)

    def test_nothing_else_sets_goals_of_a_motion(self):
        """Packets of the console; test_permit.c has those of every source. Torque off passes."""
        refused = ["write 1 GOAL_POSITION 5", "write 254 MOVING_SPEED 5", "sync GOAL_POSITION 2 1:0,1",
                   "regwrite 2 GOAL_POSITION 5", "action", "set 3 GOAL_POSITION 5deg", "reset 4"]
        for board in boards.WITH_MOTION:
            with self.subTest(board):
                lines = "".join(f"! {line}\n@expect text error 14: \n"
                                for line in refused)
                run, _ = rows_of(pose([90] * JOINTS, "in 2s") + lines + "led 1 on\ntorque 7 off\n"
                                 "@expect servo 7 torque off\n@wait 2500\nwrite 1 GOAL_POSITION 400\n", board)
                self.assertEqual(run.status, 0, run.output)

    def test_the_cycle_ends_with_the_motion_unless_a_user_began_it(self):
        for board in boards.WITH_MOTION:
            with self.subTest(board):
                run, _ = rows_of(pose([140] * JOINTS, "in 300ms") + "@wait 600\n! cycle\n"
                                 + "@expect text error 44\ncycle every 4ms\n"
                                 + pose([150] * JOINTS, "in 300ms") + "@wait 600\ncycle\ncycle off\n", board)
                self.assertEqual(run.status, 0, run.output)

    def test_servo_in_endless_turn_takes_no_pose(self):
        for board in boards.CONSOLES:
            with self.subTest(board):
                run = controller("group 1 2\nturn 1 0\ntorque 1 on\n! pose 90 90 in 2s\n@expect text error 47\n"
                                 "! pose 90 90 at 20rpm\n@expect text error 47\n@wait 200\n@expect servo 1 PRESENT_SPEED 0\n",
                                 board, "1,2", "--echo")
                self.assertEqual(run.status, 0, run.output)

    def test_a_stop_ends_the_motion(self):
        for board in boards.CONSOLES:
            with self.subTest(board):
                run, rows = rows_of(pose([60] * JOINTS, "in 2s") + "@wait 500\nstop\n@wait 1000\n"
                                    "@expect servo 1-18 torque off\n! " + pose([60] * JOINTS, "in 2s")
                                    + "@expect text error 54\nrelease\n", board)
                self.assertEqual(run.status, 0, run.output)
                self.assertGreater(int(rows[-1]["present_1"]), 230)


if __name__ == "__main__":
    unittest.main()
