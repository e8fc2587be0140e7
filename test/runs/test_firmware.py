# SPDX-License-Identifier: MIT
"""The firmware and programs linked with the library, in the simulator."""
# needs: $(patsubst %,build/%/controller.elf,atmega128 arduino-mega) $(patsubst %,build/%/examples/two_servos.elf,atmega128 arduino-mega)
# needs: $(BOARDS:%=build/%/examples/two_joints.elf) $(patsubst %,build/atmega128/examples/%.elf,timed_move keyframes)
# needs: $(patsubst %,build/atmega128/firmware/%.elf,absent clock line_errors slow_handler)
import csv
import pathlib
import re
import tempfile
import unittest

import boards
from simulator import LONG, ROOT, Run, controller

BOARDS = ["atmega128", "arduino-mega"]


class Console(unittest.TestCase):
    def expect(self, script, status=0, servos="1", board="atmega128"):
        run = controller(script, board, servos, "--echo")
        self.assertEqual(run.status, status, run.output)
        return run.output

    def test_an_absent_servo_is_an_error_and_the_console_goes_on(self):
        output = self.expect("! ping 99\nping 1\n")
        self.assertIn("error 2: servo 99: no reply by the deadline", output)

    def test_an_error_reply_fails_the_run(self):
        self.assertIn("reply-was-error", self.expect("ping 99\n", status=1))

    def test_an_expected_error_that_does_not_come_fails_the_run(self):
        self.expect("! ping 1\n", status=1)

    def test_mute_servo_answers_ping_and_is_awaited_only_then(self):
        output = self.expect("write 1 STATUS_RETURN_LEVEL 0\nwrite 1 LED 1\n! read 1 LED\nping 1\n"
                             "@expect servo 1 LED 1 within 0\n")
        self.assertEqual(output.count("->in:"), 3) # the READ is not even sent

    def test_read_only_register_and_locked_servo_are_range_errors(self):
        output = self.expect("! write 1 PRESENT_POSITION 1\nwrite 1 LOCK 1\n! write 1 PUNCH 1\n"
                             "@power off\n! ping 1\n@power on\nwrite 1 PUNCH 1\n")
        self.assertEqual(output.count("error 21: servo 1: range error"), 2)

    def test_goal_outside_the_limits_is_an_angle_error(self):
        output = self.expect("write 1 CCW_ANGLE_LIMIT 511\n! write 1 GOAL_POSITION 512\n")
        self.assertIn("error 23: servo 1: angle limit error", output)

    def test_action_without_registered_write_is_an_instruction_error(self):
        self.assertIn("error 20: servo 1: instruction error", self.expect("! action 1\n"))

    def test_low_supply_is_a_warning_and_ok(self):
        output = self.expect("write 1 MIN_VOLTAGE 130\n@wait 5\nping 1\n")
        self.assertIn("warning: input voltage; compare PRESENT_VOLTAGE, MIN_VOLTAGE, MAX_VOLTAGE; mend supply or limits, then 'clear'\nok", output)

    def test_broadcast_ping_finds_a_lone_servo(self):
        self.assertIn("id 17", self.expect("ping 254\n", servos="17"))

    def test_a_whole_table_is_read(self):
        output = self.expect("read 1 0 50\n")
        self.assertIn("0x00: 00 01 01 01 01 01 00 00\n0x08: FF 03 00 50 3C A0 FF 03\n"
                      "0x10: 02 25 04 00 00 00 00 00\n", output)

    def test_sync_write_to_50_servos_moves_them_all(self):
        goals = " ".join(f"{n}:{n},2" for n in range(50))
        reads = "".join(f"read {n} GOAL_POSITION\n" for n in range(50))
        output = self.expect(f"sync GOAL_POSITION 2 {goals}\n{reads}", servos="0-49")
        self.assertEqual(re.findall(r"GOAL_POSITION = (\d+)", output),
                         [str(512 + n) for n in range(50)])

    def test_every_command_on_every_board(self):
        script = ("help\nversion\nping 1\nread 1 ID\nwrite 1 LED 1\nregwrite 1 LED 0\naction 1\n"
                  "sync LED 1 1:1\nreset 1\n")
        for board in BOARDS:
            self.assertIn(f"cds55xx 0.1.0 {board}\nok", self.expect(script, board=board))


class Programs(unittest.TestCase):
    def test_two_servos_program_sends_goals(self):
        for board in BOARDS:
            run = Run(f"build/{board}/examples/two_servos.elf", "--seconds", "3.5", board=board,
                      servos="1,2")
            self.assertEqual(run.status, 0, run.output)
            self.assertEqual([packet for _, _, packet in run.packets],
                             ["FF FF FE 04 03 18 01 E1",
                              "FF FF FE 0E 83 1E 04 01 C8 00 00 02 02 20 03 00 02 5C",
                              "FF FF FE 0E 83 1E 04 01 20 03 00 02 02 C8 00 00 02 5C",
                              "FF FF FE 0E 83 1E 04 01 C8 00 00 02 02 20 03 00 02 5C"])

    def test_readme_program_moves_two_joints(self):
        for board in boards.ALL:
            with self.subTest(board), tempfile.TemporaryDirectory() as folder:
                table = pathlib.Path(folder) / "motion.csv"
                run = Run(f"build/{board}/examples/two_joints.elf", "--seconds", "3.5", "--csv", table,
                          board=board, servos="1,2")
                self.assertEqual(run.status, 0, run.output)
                self.assertIn("rules:   none broken", run.output)
                rows = list(csv.DictReader(table.read_text().replace("bus0_", "").splitlines()))
                left, right = ([int(row[f"present_{servo}"]) for row in rows] for servo in (1, 2))
                # 60 degrees to both sides of the middle, in opposite directions
                self.assertLess(abs(min(left) - 307), 4)
                self.assertLess(abs(max(left) - 716), 4)
                self.assertLess(max(abs(a + b - 1023) for a, b in zip(left, right)), 8)

    def test_readme_shows_that_very_program(self):
        source = (ROOT / "examples/two_joints.c").read_text().rsplit("*/\n", 1)[1].strip()
        self.assertIn(source, (ROOT / "README.md").read_text())

    def test_timed_moves_of_two_joints_arrive_together(self):
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder) / "motion.csv"
            run = Run("build/atmega128/examples/timed_move.elf", "--seconds", "6", "--csv", table,
                      board="atmega128", servos="1,2")
            rows = list(csv.DictReader(table.read_text().replace("bus0_", "").splitlines()))
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        left, right = ([int(row[f"present_{servo}"]) for row in rows] for servo in (1, 2))
        # 60 degrees of the left joint and 30 of the right one, which is reversed, to both sides
        for places, ends in [(left, (307, 716)), (right, (409, 614))]:
            self.assertLess(abs(min(places) - ends[0]), 4)
            self.assertLess(abs(max(places) - ends[1]), 4)
        way = [(a - 307 - 2 * (614 - b)) for a, b in zip(left, right)][len(left) // 2:]
        self.assertLess(max(map(abs, way)), 12)  # half the way each, at any time

    def test_keyframes_come_in_turn_and_again(self):
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder) / "motion.csv"
            run = Run("build/atmega128/examples/keyframes.elf", "--seconds", "13", "--csv", table, servos="1-3")
            rows = list(csv.DictReader(table.read_text().splitlines()))
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        goals = [tuple(int(row[f"goal_{servo}"]) for servo in (1, 2, 3)) for row in rows]
        frames = [(512, 512, 512), (648, 409, 512), (784, 512, 665), (375, 307, 358)]  # 3.41 steps a degree
        seen, places = [], []
        for place, goal in enumerate(goals):
            for number, frame in enumerate(frames):
                if all(abs(a - b) <= 3 for a, b in zip(goal, frame)) and seen[-1:] != [number]:
                    seen.append(number)
                    places.append(place)
        self.assertEqual(seen[:6], [0, 1, 2, 3, 0, 1])
        near = [goal for goal in goals[places[1]:places[2]] if abs(goal[0] - frames[1][0]) <= 3]
        self.assertLess(len(near), 15)  # periods of 4 ms: this one is passed; with a stop there are more than 30
        self.assertEqual(goals[places[2] + 25], goals[places[2] + 125])  # this one is held
        # from the first rest to that of the next run: the times of all frames, rests included
        rests = [goals.index(frames[2]), goals.index(frames[2], places[4])]
        self.assertAlmostEqual((rests[1] - rests[0]) * 4, 6000, delta=40)

    def test_motion_page_shows_the_timed_move_program(self):
        text = (ROOT / "examples/timed_move.c").read_text()
        source = text[text.index("#include"):].strip()
        self.assertIn(source, (ROOT / "docs/motion.md").read_text())

    def test_example_tells_why_it_has_stopped(self):
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder) / "script"
            script.write_text("@wait 1500\n@power 2 off\n@wait 1500\n")
            for example in "keyframes", "timed_move":
                run = Run(f"build/atmega128/examples/{example}.elf", "--echo", servos="1-3", script=script.read_text())
                self.assertRegex(run.output, r"\nservo 2 \(joint 1, (elbow|right)\): offline\n", run.output)
        for echo in [], ["--echo"]: # packets leave while the line is printed
            run = Run("build/atmega128/examples/keyframes.elf", "--host", "stdout", "--seconds", "3", *echo, servos="1,3")
            self.assertRegex(run.output, r"(?m)^servo 2 \(joint 1, elbow\): no reply$")

    def test_motion_page_shows_the_table_of_keyframes(self):
        text = (ROOT / "examples/keyframes.c").read_text()
        self.assertIn(re.search(r"static const struct frame .*?;\n", text, re.S)[0], (ROOT / "docs/motion.md").read_text())

    def figures(self, program, servos="none"):
        """What a program of test/firmware/library/ says; the run must break no rule but those given."""
        run = Run(f"build/atmega128/firmware/{program}.elf", "--host", "stdout", "--seconds", "20",
                  servos=servos)
        return run, {name: int(number) for name, number in
                     re.findall(r"^(\w+) (\d+)$", run.output, re.M)}

    def test_the_main_loop_turns_while_a_servo_is_absent(self):
        run, figure = self.figures("absent")
        # READ: 8 bytes out, 8 back, 10 us each; return delay 2 us; margin 100 us
        deadline_us = 16 * 10 + 2 + 100
        self.assertEqual(run.status, 0, run.output)
        self.assertEqual(figure["result"], 2)  # CDS_TIMEOUT
        self.assertGreaterEqual(figure["us"], deadline_us)
        self.assertLess(figure["us"], deadline_us + figure["submit_us"] + 20)
        self.assertLess(figure["submit_us"], 8 * 10)  # not even its own packet was waited for
        self.assertGreater(figure["turns"], 20)

    def test_clock_never_jumps_and_timers_expire_in_time(self):
        run, figure = self.figures("clock")
        self.assertEqual(run.status, 0, run.output)
        self.assertEqual(figure["wrong"], 0)
        self.assertGreater(figure["readings"], 10000)
        self.assertEqual(figure["alarms"], 0)
        self.assertEqual(figure["sums"], 0)
        self.assertEqual(figure["laps"], 0)

    def test_damaged_and_lost_bytes_are_counted_and_never_a_reply(self):
        run, figure = self.figures("line_errors", servos="1")
        self.assertEqual(figure["whole"], 0, run.output)
        self.assertEqual(figure["paused"], 3)  # CDS_CORRUPT
        self.assertGreaterEqual(figure["overruns"], 1)
        self.assertEqual(figure["slower"], 0)
        self.assertEqual(figure["mismatch"], 3)
        self.assertGreaterEqual(figure["framing_errors"], 1)
        self.assertEqual(re.findall(r"BROKEN: *([a-z-]+)", run.output), ["overrun"])

    def test_a_stale_transmit_complete_never_releases_the_driver(self):
        run, figure = self.figures("slow_handler", servos="1-3")
        self.assertEqual(run.status, 0, run.output)
        self.assertEqual(figure["result"], 0)
        self.assertEqual(len(run.packets), 500)
        gap = max(b[0] - a[0] for a, b in zip(run.packets, run.packets[1:]))
        self.assertGreater(gap, 9 * 160 * 2)  # there were gaps within the packets


class Soak(unittest.TestCase):
    """Ordinary traffic at the factory return delay, at ever other phases of clock and main loop."""

    def soak(self, board):
        script = "".join(f"ping {1 + n % 3}\nread {1 + n % 3} {n % 49} {1 + n % 2}\n"
                         for n in range(3000))
        run = controller(script, board, "1-3")
        self.assertEqual(run.status, 0, run.output)
        self.assertEqual(len(run.packets), 12000)

    def test_no_reply_is_lost(self):
        for board in ["atmega128", "arduino-mega"] if LONG else ["atmega128"]:
            with self.subTest(board):
                self.soak(board)


if __name__ == "__main__":
    unittest.main()
