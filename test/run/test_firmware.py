"""The firmware and programs linked with the library, in the simulator."""
import re
import unittest

from simulator import ROOT, Run, controller

BOARDS = ["atmega128", "arduino-mega"]


class Console(unittest.TestCase):
    def expect(self, script, status=0, servos="1", board="atmega128"):
        run = controller(script, board, servos, "--echo")
        self.assertEqual(run.status, status, run.output)
        return run.output

    def test_an_absent_servo_is_an_error_and_the_console_goes_on(self):
        output = self.expect("! ping 99\nping 1\n")
        self.assertIn("error 2: no reply by the deadline", output)

    def test_an_error_reply_fails_the_run(self):
        self.assertIn("reply-was-error", self.expect("ping 99\n", status=1))

    def test_an_expected_error_that_does_not_come_fails_the_run(self):
        self.expect("! ping 1\n", status=1)

    def test_two_servos_with_one_id_collide(self):
        output = self.expect("@servos 7,7\n! read 7 PRESENT_POSITION\n", status=1)
        self.assertIn("collision", output)

    def test_a_mute_servo_still_answers_ping(self):
        self.expect("write 1 STATUS_RETURN_LEVEL 0\n! write 1 LED 1\n! read 1 LED\nping 1\n")

    def test_read_only_register_and_locked_servo_are_range_errors(self):
        output = self.expect("! write 1 PRESENT_POSITION 1\nwrite 1 LOCK 1\n! write 1 PUNCH 1\n"
                             "@power off\n! ping 1\n@power on\nwrite 1 PUNCH 1\n")
        self.assertEqual(output.count("error 21: servo: range error"), 2)

    def test_goal_outside_the_limits_is_an_angle_error(self):
        output = self.expect("write 1 CCW_ANGLE_LIMIT 511\n! write 1 GOAL_POSITION 512\n")
        self.assertIn("error 23: servo: angle limit error", output)

    def test_action_without_a_registered_write_is_an_instruction_error(self):
        self.assertIn("error 20: servo: instruction error", self.expect("! action 1\n"))

    def test_low_supply_is_a_warning_and_ok(self):
        output = self.expect("write 1 MIN_VOLTAGE 130\n@wait 5\nping 1\n")
        self.assertIn("warning: input voltage\nok", output)

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
    def test_readme_program_moves_two_servos(self):
        for board in BOARDS:
            run = Run(f"build/{board}/examples/two_servos.elf", "--seconds", "3.5", board=board,
                      servos="1,2")
            self.assertEqual(run.status, 0, run.output)
            self.assertEqual([packet for _, _, packet in run.packets],
                             ["FF FF FE 04 03 18 01 E1",
                              "FF FF FE 0E 83 1E 04 01 C8 00 00 02 02 20 03 00 02 5C",
                              "FF FF FE 0E 83 1E 04 01 20 03 00 02 02 C8 00 00 02 5C",
                              "FF FF FE 0E 83 1E 04 01 C8 00 00 02 02 20 03 00 02 5C"])

    def test_readme_shows_that_very_program(self):
        source = (ROOT / "examples/two_servos.c").read_text().split("*/\n", 1)[1].strip()
        self.assertIn(source, (ROOT / "README.md").read_text())

    def test_the_main_loop_turns_while_a_servo_is_absent(self):
        run = Run("build/atmega128/program/absent.elf", "--host", "stdout", "--seconds", "1")
        said = re.search(r"turns (\d+) submit_us (\d+) us (\d+) result (\d+)", run.output)
        self.assertTrue(said, run.output)
        turns, submit_us, us, result = map(int, said.groups())
        # READ: 8 bytes out, 8 back, 10 us each; return delay 2 us; margin 100 us
        deadline_us = 16 * 10 + 2 + 100
        self.assertEqual(result, 2)  # CDS_TIMEOUT
        self.assertGreaterEqual(us, deadline_us)
        self.assertLess(us, deadline_us + submit_us + 20)
        self.assertLess(submit_us, 60)  # it did not even wait for its own packet to leave
        self.assertGreater(turns, 20)


if __name__ == "__main__":
    unittest.main()
