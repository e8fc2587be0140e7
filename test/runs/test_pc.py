# SPDX-License-Identifier: MIT
"""A program of the PC's, `--host FILE`, with the firmware."""
# needs: build/atmega128/controller.elf
import pathlib
import re
import subprocess
import tempfile
import unittest

from simulator import ROOT, SIM, in_mode_program

MHZ = 16


def run(program, *options):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "pc"
        path.write_text(program)
        options = ["firmware", ROOT / "build/atmega128/controller.elf", "--board", "atmega128", "--servos", "1",
                   "--host", path, *options]
        done = subprocess.run([SIM, *options, *in_mode_program(options, folder)],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60)
        return done.returncode, re.sub(r"speed: .*\n", "", done.stdout.replace(str(path), "pc"))


class Program(unittest.TestCase):
    def test_what_it_says_and_hears_and_when(self):
        status, output = run("# a ping\n\nsay FF FF 01 02 01 FB\nhear 6\nwait 100\ntext ping 1\n"
                             "hear 2\nhear 2\n")
        lines = [line.split() for line in output.splitlines() if not line.startswith("text:")]
        self.assertEqual(status, 0, output)
        self.assertEqual(lines[1][3:], "6 FF FF 01 02 00 FC".split())
        said, heard = [[int(word) for word in lines[row][1:3]] for row in (0, 1)]
        frame = 10 * 16000000 / 115200
        self.assertAlmostEqual(said[1] - said[0], 6 * frame, delta=frame / 10)
        self.assertGreater(heard[0], said[1])
        self.assertAlmostEqual(heard[1] - heard[0], 5 * frame, delta=frame / 4)
        self.assertGreaterEqual(int(lines[2][1]), heard[1] + 100 * MHZ)
        self.assertEqual([line[3:] for line in lines[3:5]], [["2", "6F", "6B"], ["2", "0D", "0A"]])

    def test_what_does_not_come_fails_the_run(self):
        status, output = run("say FF FF 02 02 01 FA\nhear 6 within 20\nsay 00\n")
        self.assertEqual(status, 1, output)
        self.assertIn("pc:2: heard 0 bytes, not 6", output)
        self.assertEqual(output.count("said"), 1)

    def test_byte_that_comes_before_the_sleep_is_answered_at_once(self):
        """The end of a line, at each microsecond behind the byte before it: the firmware asks whether
        there is work, and falls asleep. The next interrupt may be 33 ms away. HOST_BAUD of the
        virtual device is 1: 1 Mbps, where a byte takes 10 us."""
        program = "say FF FF FD 04 03 04 01 F6\nhear 6\nwait 6000\nbaud 1000000\nwait 10000\n"
        program += "".join(f"say 70 69 6E 67 20 31\nwait {us}\nsay 0A\nhear 4 within 3\nwait 1000\n"
                          for us in range(1, 400))
        status, output = run(program)
        self.assertEqual(status, 0, output[-1000:])

    def test_stale_reply_is_not_passed_on_as_the_next_one(self):
        """Two READs of a word, of a servo that answers 0.8 to 2 ms late: no reply, since the PC could
        not know to which READ it belongs. A reply 0.7 ms late may be whole when the firmware looks
        whether its deadline is over: it is the reply to its own READ."""
        program = ("say FF FF 01 04 02 1E 02 D8\nsay FF FF 01 04 02 0C 02 EA\n"
                   "hear 1 within 20\n")
        for us in range(800, 2000, 50):
            status, output = run(program, "--fault", f"turnaround 1 {us}")
            self.assertEqual(status, 1, (us, output))
            self.assertIn("pc:3: heard 0 bytes, not 1", output, us)

    def test_another_rate_than_the_boards_is_not_understood(self):
        status, output = run("baud 1000000\nsay FF FF 01 02 01 FB\nhear 6 within 20\n")
        self.assertEqual(status, 1, output)

    def test_a_flood_is_as_long_as_was_said_and_the_same_each_time(self):
        outputs = [run(f"baud 115200\nflood 2000 {seed}\nwait 200000\ntext help\nhear 4\n")
                   for seed in (3, 3, 4)]
        self.assertEqual(outputs[0], outputs[1])
        self.assertNotEqual(outputs[0], outputs[2])
        said = int(outputs[0][1].splitlines()[0].split()[1])
        self.assertAlmostEqual(said / 16e6, 0.2 + 2000 * 10 / 115200, delta=0.01)

    def test_reset_is_told_to_the_firmware(self):
        status, output = run("text status\nhear 16\nreset watchdog\nwait 30000\ntext status\nhear 19\n"
                             "reset external in 5\nwait 40000\ntext status\nhear 19\n")
        self.assertEqual(status, 0, output)
        heard = [bytes.fromhex("".join(line.split()[4:])) for line in output.splitlines()
                 if line.startswith("heard")]
        self.assertEqual(heard, [b"reset by power\r\n", b"reset by watchdog\r\n",
                                 b"reset by external\r\n"])

    def test_bad_lines(self):
        for line in ("shout 1", "say", "say 1G", "hear", "hear 0", "hear 5000", "hear 1 in 5",
                     "wait x", "baud", "flood", "flood 1 x", "wait 1 2",
                     "reset", "reset itself", "reset power in x"):
            status, output = run("wait 1\n" + line + "\n")
            self.assertEqual(status, 2, line)
            self.assertIn("pc:2: ", output, line)


if __name__ == "__main__":
    unittest.main()
