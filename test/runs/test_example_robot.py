# SPDX-License-Identifier: MIT
"""examples/robot.c on every board: the robot starts from its present pose, walks, and switches torque off after a
fault."""
# needs: $(BOARDS:%=build/%/examples/robot.elf)
import csv
import pathlib
import re
import tempfile
import unittest

import boards
from simulator import LONG, Run

SERVOS = 12
CYCLES_MS = 16000
TORQUE_ON, TORQUE_OFF = re.compile(r"FF FF .. 04 03 18 01 "), "FF FF FE 04 03 18 00 E2"
FIRST_GOAL = re.compile(r"FF FF .. 07 03 1E ")
GOALS = "FF FF FE 40 83 1E 04"
LIMIT = (300, 724)


class Robot(unittest.TestCase):
    def runs(self, *options, board="atmega128", seconds="4"):
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder) / "motion.csv"
            run = Run(f"build/{board}/examples/robot.elf", "--seconds", seconds, "--csv", table,
                      *options, board=board, servos=f"1-{SERVOS}")
            text = table.read_text().replace("bus0_", "")  # where there are several
            run.rows = list(csv.DictReader(text.splitlines()))
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        run.sent = [(cycle, packet) for cycle, way, packet in run.packets if way == "->in"]
        return run

    def places(self, run, servo):
        return [int(row[f"present_{servo}"]) for row in run.rows]

    def check_lets_go(self, run):
        """Three broadcasts, and nothing that drives a servo behind the first."""
        first = next(at for at, (_, packet) in enumerate(run.sent) if packet == TORQUE_OFF)
        behind = [packet for _, packet in run.sent[first:]]
        self.assertEqual(behind.count(TORQUE_OFF), 3)
        self.assertFalse([packet for packet in behind if packet.startswith(GOALS)])
        looked = {packet[6:8] for packet in behind if packet[9:20] == "04 02 18 01"}
        self.assertEqual(looked, {f"{servo:02X}" for servo in range(1, SERVOS + 1)})
        return run.sent[first][0]

    def test_it_walks_on_every_board(self):
        for board in boards.ALL if LONG else ["atmega128", "arbotix", "arduino-uno"]:
            with self.subTest(board):
                run = self.runs(board=board)
                starts = [cycle for cycle, packet in run.sent if packet.startswith(GOALS)]
                self.assertGreater(len(starts), 400)
                # the first one has all goals judged behind its beginning
                gaps = [b - a for a, b in zip(starts, starts[1:])]
                self.assertLess(max(abs(gap - 4 * CYCLES_MS) for gap in gaps[1:]), 200 * 16)
                for servo in range(1, SERVOS + 1):
                    places = self.places(run, servo)
                    self.assertLess(min(places), 400)
                    self.assertGreater(max(places), 600)
                    self.assertTrue(LIMIT[0] <= min(places) <= max(places) <= LIMIT[1])
                    # 31 RPM are 2.5 positions in 4 ms: nothing jumps, not at the start either
                    self.assertLessEqual(max(abs(b - a) for a, b in zip(places, places[1:])), 4)
                self.assertNotIn(TORQUE_OFF, [packet for _, packet in run.sent])

    def test_torque_is_on_only_when_goals_are_where_the_servos_are(self):
        run = self.runs(seconds="1.2")
        drives = [bytes.fromhex(packet) for _, packet in run.sent
                  if FIRST_GOAL.match(packet) or TORQUE_ON.match(packet) or packet.startswith(GOALS)]
        for i in range(SERVOS):
            goal, torque = drives[i], drives[SERVOS + i]
            self.assertEqual(goal[2:6], bytes([i + 1, 7, 3, 0x1E]))
            self.assertEqual(goal[6] + 256 * goal[7], int(run.rows[0][f"present_{i + 1}"]))
            self.assertEqual(torque[2:7], bytes([i + 1, 4, 3, 0x18, 1]))
        self.assertEqual(drives[2 * SERVOS][4], 0x83)  # goals of the cycle, behind all of these

    def test_a_servo_that_loses_its_power_for_a_moment_stops_all(self):
        for board in ["atmega128", "arbotix"]:
            for ms in (1, 30, 300) if board == "atmega128" else (100,):
                with self.subTest(board, ms=ms):
                    self.check_lets_go(self.runs("--fault", f"unplug in 1000 0 5 {ms}", "--rules",
                                                 "warn", board=board))

    def test_a_servo_that_loses_its_power_for_good_stops_all(self):
        for board in boards.ALL if LONG else ["atmega128", "arbotix"]:
            with self.subTest(board):
                run = self.runs("--fault", "unplug in 1000 0 5 60000", "--rules", "warn", board=board)
                # within two periods of the state check, or a silence or two of its feedback
                self.assertLess(self.check_lets_go(run), 3.5e3 * CYCLES_MS)

    def test_line_held_low_stops_all_when_the_line_is_free(self):
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder, "script")
            script.write_text("@wait 2100\n@fault stuck low\n@wait 5000\n@expect servo 1 torque on\n@fault stuck off\n"
                              f"@wait 1000\n@expect servo 1-{SERVOS} torque off\n")
            for board in ["atmega128", "arbotix"]:
                run = Run(f"build/{board}/examples/robot.elf", "--script", script, "--rules", "warn", "--echo",
                          board=board, servos=f"1-{SERVOS}")
                self.assertEqual(run.status, 0, run.output)
                self.assertIn("line low or disturbed", run.output)

    def test_a_missing_servo_is_found_before_anything_moves(self):
        run = self.runs("--fault", "brownout 7 60000")
        self.check_lets_go(run)
        self.assertFalse([packet for _, packet in run.sent
                          if TORQUE_ON.match(packet) or FIRST_GOAL.match(packet)])


if __name__ == "__main__":
    unittest.main()
