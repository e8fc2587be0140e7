# SPDX-License-Identifier: MIT
"""examples/hexapod: the tripods walk in turn, no goal jumps, and a servo that fails stops all."""
# needs: $(filter %/hexapod.elf,$(EXAMPLES))
import csv
import pathlib
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import boards
from simulator import LONG, ROOT, Run

SERVOS = 18
GOALS, TORQUE_OFF = "FF FF FE 5E 83 1E 04", "FF FF FE 04 03 18 00 E2"
FASTEST = 743  # register units: 45 RPM, rounded, the limit of all joints
STEPS = 1023 / 300 * 45 * 6 * 0.004  # in a period at that speed
STEP_ROWS = 250  # a step of the gait takes 1 s
WALKS = range(600, 1300)  # rows in which the gait runs at full swing
LEGS = [(1 + 3 * leg, 1 if leg < 3 else -1) for leg in range(6)]  # first servo, side
REST = [512, 614, 512]  # coxa, femur and tibia on the right side
LARGE_BOARDS = [board for board in boards.ALL if board != "arduino-uno"]  # 2 KB of RAM are too few


class Hexapod(unittest.TestCase):
    def runs(self, *options, board="atmega128", seconds="8", script=None):
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder) / "motion.csv"
            run = Run(f"build/{board}/examples/hexapod.elf", "--seconds", seconds, "--csv", table,
                      *options, board=board, servos=f"1-{SERVOS}", script=script)
            rows = list(csv.DictReader(table.read_text().replace("bus0_", "").splitlines()))
            run.picture = self.picture(table) if len(rows) > 1300 else None
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        run.sent = [packet for _, way, packet in run.packets if way == "->in"]
        goals = [bytes.fromhex(packet)[7:-1] for packet in run.sent if packet.startswith(GOALS)]
        run.goals = [packet for packet in goals if len(packet) == 5 * SERVOS]  # the end may cut the last one
        run.lifts, run.swings = ([[side * (int(row[f"goal_{first + joint}"]) - 512) - (REST[joint] - 512)
                                   for first, side in LEGS] for row in rows] for joint in (1, 0))
        run.rows = rows
        return run

    def picture(self, table):
        svg = table.with_suffix(".svg")
        subprocess.run([ROOT / "scripts/hexapod_picture.py", table, svg], check=True)
        return svg.read_text()

    def check_picture(self, text):
        """Small enough for a README, without a script, and every value of its animation has its time."""
        self.assertLess(len(text), 100_000)
        self.assertNotIn("script", text)
        moving = [part for part in ElementTree.fromstring(text).iter() if "animate" in part.tag]
        self.assertGreater(len(moving), 6 * 5)  # of each leg: the line, its colour, two dots
        for part in moving:
            values, times = (len(part.get(name, "").split(";")) for name in ("values", "keyTimes"))
            self.assertIn((values, part.get("calcMode")), [(51, "linear"), (times, "discrete")])

    def check_walk(self, run):
        """The legs of a tripod do the same; the other tripod does it half a step later."""
        for row in WALKS:
            for tripod in ((0, 2, 4), (1, 3, 5)):
                for leg in tripod[1:]:
                    for moves in (run.lifts, run.swings):
                        self.assertLessEqual(abs(moves[row][leg] - moves[row][tripod[0]]), 1)
            for leg in range(5):
                for moves in (run.lifts, run.swings):
                    self.assertLessEqual(abs(moves[row][leg] - moves[row + STEP_ROWS // 2][leg + 1]), 1)
            lifted = [leg for leg in range(6) if run.lifts[row][leg] > 1]
            self.assertIn(lifted, [[], [0, 2, 4], [1, 3, 5]])
            self.assertLessEqual(max(run.lifts[row]), 85)
        self.assertGreater(max(lifts[0] for lifts in run.lifts), 80)
        self.assertGreater(max(swings[0] for swings in run.swings), 66)

    def check_goals(self, run):
        """The first goals are where the servos are; none jumps, and no speed is 0 or above the limit."""
        last = [int(run.rows[0][f"present_{servo}"]) for servo in range(1, SERVOS + 1)]
        for packet in run.goals:
            for servo in range(SERVOS):
                goal, speed = (packet[5 * servo + i] + 256 * packet[5 * servo + i + 1] for i in (1, 3))
                self.assertLessEqual(abs(goal - last[servo]), STEPS + 1)
                self.assertTrue(0 < speed <= FASTEST, speed)
                last[servo] = goal
        return last

    def test_tripods_walk_in_turn_then_the_robot_stands(self):
        for board in LARGE_BOARDS if LONG else ["atmega128"]:
            with self.subTest(board):
                run = self.runs(board=board)
                self.assertGreater(len(run.goals), 1500)
                self.check_walk(run)
                last = self.check_goals(run)
                self.check_picture(run.picture)
                self.assertEqual(last, [512 + side * (rest - 512) for _, side in LEGS for rest in REST])
                for servo, goal in enumerate(last, 1):
                    self.assertLessEqual(abs(int(run.rows[-1][f"present_{servo}"]) - goal), 3)
                self.assertNotIn(TORQUE_OFF, run.sent)

    def test_a_servo_without_power_stops_the_walk(self):
        self.check_stop(self.runs("--fault", "unplug in 3000 0 8 60000", "--rules", "warn", seconds="5"))

    def test_a_blocked_leg_stops_the_walk(self):
        """The servo reports an overload."""
        self.check_stop(self.runs(seconds="5", script="@at 3000\n@block 8 on\n@wait 1500\n"))

    def check_stop(self, run):
        self.assertIn(TORQUE_OFF, run.sent)
        behind = run.sent[run.sent.index(TORQUE_OFF):]
        self.assertEqual(behind.count(TORQUE_OFF), 3)
        self.assertFalse([packet for packet in behind if packet.startswith(GOALS)])


if __name__ == "__main__":
    unittest.main()
