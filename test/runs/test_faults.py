# SPDX-License-Identifier: MIT
"""The firmware on a wire with faults: each command ends, the run ends, the console stays usable, and
no rule is broken, for the controller is innocent. The faults themselves: test/sim/test_faults.c."""
# needs: $(patsubst %,build/%/controller.elf,atmega128 arduino-mega)
import re
import subprocess
import unittest

from simulator import ROOT, SIM, controller

BOARDS = ["atmega128", "arduino-mega"]
PONG = ["FF FF 01 02 01 FB", "FF FF 01 02 00 FC"]


class Faults(unittest.TestCase):
    def passes(self, script, *options, servos="1"):
        """On both boards; returns the output of the last one."""
        for board in BOARDS:
            run = controller(script, board, servos, "--echo", *options)
            self.assertEqual(run.status, 0, run.output)
            self.assertIn("rules:   none broken", run.output)
            self.assertNotIn("faults:  acted 0 times", run.output)
        return run

    def errors(self, run):
        """The console's replies, in order: 0 for ok, else the number of the error."""
        return [int(m[1] or 0) for m in re.finditer(r"^(?:ok|error (\d+): .*)$", run.output, re.M)]

    def test_flipped_bit_of_a_reply_is_noticed_and_next_ping_is_good(self):
        script = "".join(f"@fault flip out 1 {byte} {bit}\n! ping 1\nping 1\n"
                         for byte in range(6) for bit in range(10) if (byte, bit) != (5, 9))
        errors = self.errors(self.passes(script))
        self.assertEqual(len(errors), 118)
        self.assertTrue(set(errors[0::2]) <= {2, 3}, errors)
        self.assertEqual(set(errors[1::2]), {0})

    def test_flipped_bit_of_an_instruction_is_a_checksum_error(self):
        run = self.passes("@fault flip in 1 4 3\n! write 1 LED 1\nread 1 LED\n")
        self.assertIn("error 22: servo 1: checksum error", run.output)
        self.assertIn("LED = 0", run.output)

    def test_lost_and_inserted_bytes_are_noticed(self):
        script = "".join(f"@fault lose out 1 {byte}\n! ping 1\nping 1\n" for byte in range(6))
        script += "".join(f"@fault insert out 1 {byte} 0x55\n! ping 1\nping 1\n"
                          for byte in range(2, 6))
        self.passes(script)

    def test_any_number_of_header_bytes_is_harmless(self):
        self.passes("@fault insert out 1 0 255\n" * 40 + "ping 1\nping 1\n")

    def test_line_stuck_low_or_high_is_silence_and_works_when_freed(self):
        for level in ["low", "high"]:
            run = self.passes(f"@fault stuck {level}\n! ping 1\n! ping 1\n@fault stuck off\n"
                              "ping 1\nping 1\n")
            self.assertEqual(self.errors(run)[:2], [9, 9] if level == "low" else [2, 2], run.output)
            if level == "low":  # nothing was said into it
                self.assertEqual(run.transcript.count("->in"), 2)

    def test_a_line_that_is_stuck_for_a_while_frees_itself(self):
        self.passes("@fault stuck low 20\n! ping 1\n@wait 20\nping 1\n")

    def test_the_console_goes_on_while_a_servo_babbles(self):
        for what in ["headers", "random", "0x00", "0x01"]:
            run = self.passes(f"@fault babble {what}\n! ping 1\nversion\n! read 1 LED\n"
                              "@fault babble off\n@wait 1\nping 1\nping 1\n")
            self.assertEqual(self.errors(run)[0:3:2], [9, 9], run.output)
            self.assertEqual(run.transcript.count("->in"), 2)  # those after the babble

    def test_late_reply_is_taken_for_no_request(self):
        """700 us is the deadline itself: there the phase of the main loop decides."""
        run = self.passes("@fault delay out 1 800\n! read 1 LED\n@wait 5\nread 2 ID\n"
                          "@fault delay out 1 710\n! read 1 LED\nread 2 ID\n", servos="1,2")
        self.assertEqual(self.errors(run), [2, 0, 2, 0])
        self.assertEqual(run.output.count("ID = 2"), 2)

    def test_reply_that_meets_the_next_packet_breaks_no_rule(self):
        met = 0
        for us in range(12500, 15000, 25):  # when the error is printed, and the next packet begins
            run = controller(f"@fault delay out 1 {us}\n! ping 1\nread 2 ID\n", "atmega128", "1,2")
            met += run.status
            broken = re.findall(r"BROKEN:  (\S+),", run.output)
            self.assertEqual(broken, ["reply-was-error"] * run.status, run.output)
        self.assertGreater(met, 2)

    def test_a_reply_of_another_id_is_not_taken(self):
        run = self.passes("@fault id out 1 2\n! ping 1\nping 1\n", servos="1,2")
        self.assertIn(self.errors(run)[0], [2, 3])

    def test_a_wrong_length_is_not_taken(self):
        script = "".join(f"@fault length out 1 {n}\n! read 1 GOAL_POSITION\n@wait 1\nping 1\n"
                         for n in [0, 1, 2, 3, 5, 100, 254, 255])
        self.passes(script)

    def test_with_an_echo_transactions_are_as_before(self):
        # 40 us: the receive handler takes the echo of the last byte before TXC is served
        run = self.passes("write 1 RETURN_DELAY 20\n@fault echo on\nping 1\n"
                          "read 1 GOAL_POSITION\nwrite 1 LED 1\nread 1 LED\n")
        self.assertEqual([packet for _, _, packet in run.packets[2:4]], PONG)
        self.assertIn("GOAL_POSITION = 512\nok", run.output)
        self.assertIn("LED = 1\nok", run.output)

    def test_after_a_brown_out_torque_is_off_and_the_servo_answers(self):
        run = self.passes("write 1 TORQUE_ENABLE 1\n@fault brownout 1 50\n! ping 1\n@wait 50\n"
                          "read 1 TORQUE_ENABLE\n")
        self.assertIn("TORQUE_ENABLE = 0", run.output)

    def test_a_servo_that_dies_amid_its_reply_is_a_timeout(self):
        script = "".join(f"@fault cut out 1 {n}\n! ping 1\nping 1\n" for n in range(6))
        errors = self.errors(self.passes(script))
        self.assertEqual(set(errors[1::2]), {0})
        self.assertTrue(set(errors[0::2]) <= {2, 3}, errors)

    def test_a_servo_at_another_rate_is_not_there(self):
        run = self.passes("@fault baud 1 3\n! ping 1\n! ping 1\nping 2\n", servos="1,2")
        self.assertEqual(self.errors(run), [2, 2, 0])

    def test_twins_are_noticed_at_offsets_of_a_bit_and_more(self):
        script = "".join(f"@fault delay out 2 {us}\n! read 7 PRESENT_POSITION\n@wait 5\n"
                         for us in [1, 2, 5, 9, 11, 25, 59])
        self.passes(script, "--allow-duplicates", servos="7,7")

    def test_noise_ends_in_errors_or_replies_console_continues(self):
        script = ("@fault noise 3000\n" + "ping 1\n" * 300 + "@fault noise 0\nping 1\n")
        run = controller(script, "atmega128", "1", "--echo", "--seed", "3")
        self.assertEqual(run.status, 1)
        self.assertRegex(run.output, r"BROKEN:  reply-was-error, \d+ times")
        self.assertEqual(run.output.count("BROKEN"), 1, run.output)
        errors = self.errors(run)
        self.assertEqual(len(errors), 301)
        self.assertGreater(sum(e == 0 for e in errors), 100)
        self.assertGreater(sum(e != 0 for e in errors), 20)

    def test_one_seed_is_one_run(self):
        script = "@fault noise 3000\n@fault babble random\n@wait 20\n"
        runs = [controller(script, "atmega128", "1", "--seed", seed) for seed in "112"]
        self.assertEqual(runs[0].transcript, runs[1].transcript)
        self.assertNotEqual(runs[0].transcript, runs[2].transcript)


class Orders(unittest.TestCase):
    def test_faults_on_the_command_line_hold_from_the_start(self):
        run = controller("! ping 1\n! ping 2\n@wait 1\nping 2\n", "atmega128", "1,2", "--echo",
                         "--fault", "lose out 1 0", "--fault", "brownout 2 30")
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("faults:  acted 2 times; 0 of 2 orders came to nothing", run.output)

    def test_an_order_for_a_servo_that_is_not_there_is_refused(self):
        run = controller("ping 1\n", "atmega128", "1", "--fault", "baud 9 3")
        self.assertEqual(run.status, 2, run.output)
        self.assertEqual(run.output, '--fault "baud 9 3": no servo has that ID; a fault takes the IDs of this moment\n')

    def test_a_bad_order_in_a_script_is_refused_before_anything_runs(self):
        run = controller("ping 1\n@fault flip in 1\n")
        self.assertEqual(run.status, 2, run.output)
        self.assertRegex(run.output, r"script:2: flip in\|out PACKET BYTE BIT \[BIT\]")

    def test_a_bus_without_firmware_has_faults_too(self):
        path = ROOT / "build/faults_on_a_bus.script"
        path.write_text("@fault id out 1 9\n@send FF FF 01 02 01 FB\n"
                        "@expect packet out FF FF 09 02 00 F4\n@fault lose in 1 5\n"
                        "@send FF FF 01 02 01 FB\n@expect silence 2\n")
        done = subprocess.run([SIM, "bus", "--servos", "1", "--script", path, "--fault",
                               "turnaround 1 50"], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=60)
        path.unlink()
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("faults:  acted 3 times; 0 of 3 orders", done.stdout)


if __name__ == "__main__":
    unittest.main()
