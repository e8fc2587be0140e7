# SPDX-License-Identifier: MIT
"""The console of a new controller, on an empty EEPROM: banner, prompt and echo for a person. A program switches
them off by `mode program`; its packets are answered in both modes."""
# needs: $(CONSOLE_ELFS) $(PROFILE_ELFS)
import pathlib
import re
import tempfile
import unittest

import boards
from client import PING, WRITE, packet
from simulator import ROOT, Run

VERSION = re.search(r'CDS_VERSION "(.*)"', (ROOT / "include/cds55xx/version.h").read_text())[1]
PROMPT = "\r> "
PING_1, REPLY_1 = packet(1, PING), packet(1, 0)
# Each console: (board, profile).
CONSOLES = [(board, profile) for profile in ("console", "full") for board in boards.with_profile(profile)
            if board in boards.HOSTED]


def banner(board, profile):
    return (f"cds55xx {VERSION} {board}\r\nhelp lists the commands{', Tab completes them' if profile == 'full' else ''}"
            "; Ctrl-X stops all servos\r\n")


def text(line):
    return f"text {line}\nwait 60000\nrest\n"


def say(data, wait_us=60000):
    return f"say {data.hex(' ')}\nwait {wait_us}\nrest\n"


# Within the banner and behind it, in us after a reset. The slowest board listens from 7.5 ms on.
MOMENTS = range(8000, 18000, 700)
START = "wait 100000\nrest\n"

# of the alarm "range", as errors.h has it
REMEDY = "; a value or address is out of its range, read-only, or locked until power-off"


def slow(line):
    """A line whose answer takes up to 1.5 s."""
    return text(line).replace("60000", "1500000")


class Person(unittest.TestCase):
    def heard(self, board, profile, program):
        """What the PC hears at each `rest`, from a controller with an empty EEPROM."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "pc")
            file.write_text(program)
            run = Run(f"build/{board}/{profile}.elf", "--host", file, "--eeprom", pathlib.Path(folder, "eeprom"),
                      board=board, servos="1-3")
        self.assertEqual(run.status, 0, run.output)
        return [bytes.fromhex("".join(line.split()[4:])).decode("latin-1")
                for line in run.output.splitlines() if line.startswith("heard")]

    def each(self, program):
        for board, profile in CONSOLES:
            yield board, profile, self.heard(board, profile, program)

    def test_new_controller_prints_banner_prompt_and_echo(self):
        for board, profile, heard in self.each(START + text("ping 1") + text("") + text("bus")):
            self.assertEqual(heard, [banner(board, profile) + PROMPT, "ping 1\r\nok\r\n" + PROMPT, "\r\n" + PROMPT,
                                     "bus\r\nbus ok at 1000000bps\r\nok\r\n" + PROMPT])

    def test_mode_program_gives_bare_replies(self):
        for board, profile, heard in self.each(START + text("mode program") + text("ping 1") + text("bus")):
            self.assertEqual(heard[1:], ["mode program\r\nok\r\n", "ok\r\n", "bus ok at 1000000bps\r\nok\r\n"],
                             (board, profile))

    def test_mode_echo_has_no_prompt(self):
        for board, profile, heard in self.each(START + text("mode echo") + text("ping 1") + text("echo off") + text("ping 1")):
            self.assertEqual(heard[1:], ["mode echo\r\nok\r\n", "ping 1\r\nok\r\n", "echo off\r\nok\r\n", "ok\r\n"],
                             (board, profile))

    def test_tab_behind_help_leaves_out_what_other_boards_have(self):
        for board, completed in (("atmega128", "\a"), ("arduino-mega", "y ")):
            heard = self.heard(board, "full", START + say(b"help pla\t"))
            self.assertEqual(heard[1], "help pla" + completed, board)

    def test_tab_offers_no_command_of_other_boards(self):
        for board, offers in (("atmega128", False), ("arduino-mega", True)):
            heard = self.heard(board, "full", START + say(b"mo\t"))
            self.assertIn("monitor", heard[1], board)
            self.assertEqual("motion" in heard[1], offers, board)

    def test_tab_offers_stored_names(self):
        store = "".join(map(slow, ["mode program", "scan", "group 1", "pose set right 100", "pose set rest 90",
                                   "sequence wave new rest 1s", "sequence wav2 add rest 1s", "mode person"]))
        for line, completed in (("pose delete ri", "ght "), ("pose r", "\r\nright  rest  "), ("sequence show wav", "\r\nwave  wav2  "),
                                ("sequence wave add re", "st ")):
            for board in ("atmega128", "arduino-mega"):
                heard = self.heard(board, "full", START + store + say(line.encode() + b"\t"))[-1]
                self.assertIn(line + completed, heard, (board, line))

    def test_add_that_begins_a_sequence_says_so(self):
        lines = ["scan", "group 1", "pose set rest 90", "sequence walk add rest 1s", "sequence walk add rest 1s"]
        for board in ("atmega128", "arduino-mega"):
            heard = self.heard(board, "full", START + "".join(map(slow, lines)))
            self.assertIn("a new sequence: there was none of this name", heard[-2])
            self.assertNotIn("a new sequence", heard[-1])

    def test_line_dropped_by_a_key_leaves_a_prompt(self):
        for key in ["03", "15"]:
            for board, profile, heard in self.each(START + f"say 70 69 {key}\nwait 60000\nrest\n" + text("ping 1")):
                if profile == "console" or key == "03": # the profile full deletes the characters in place
                    self.assertEqual(heard[1][-len(PROMPT):], PROMPT, (board, profile, key))
                self.assertEqual(heard[2], "ping 1\r\nok\r\n" + PROMPT, (board, profile, key))

    def test_packet_is_answered_without_a_prompt_behind_it(self):
        program = START + say(PING_1) + say(PING_1) + say(b"pin" + PING_1) + text("ping 1")
        for board, profile, heard in self.each(program):
            reply = REPLY_1.decode("latin-1")
            self.assertEqual(heard[1:], [reply, reply, "pin" + reply, "ping 1\r\nok\r\n" + PROMPT], (board, profile))

    def test_alarm_is_told_after_a_command_not_after_a_packet(self):
        """The servo refuses to have its present position written: a range error."""
        program = START + say(packet(1, WRITE, [0x24, 1])) + text("ping 1")
        for board, profile, heard in self.each(program):
            self.assertEqual(heard[1], packet(1, 0x08).decode("latin-1"), (board, profile))
            remedy = REMEDY if profile == "full" else ""
            self.assertEqual(heard[2].replace(PROMPT, "").split("\r\n"), ["ping 1", "ok", "\ralarm of servo 1: range" + remedy, ""],
                             (board, profile))

    def test_baud_tells_a_person_that_other_servos_are_cut_off(self):
        """On boards with room, how many servos are known at each rate."""
        told = "the bus changed: any servo at the old rate answers after 'bus 1000000bps'\r\n"
        counted = "the bus changed to this rate, 'save' keeps it over power-off; servos of the list here: 1; 'scan' looks for others\r\n"
        lines = (START + text("baud 2 500000").replace("60000", "1000000") + text("mode program")
                 + text("baud 2 250000").replace("60000", "1000000"))
        for board, profile, heard in self.each(lines):
            self.assertEqual(heard[1:2] + heard[3:],
                             ["baud 2 500000\r\nID 2 at 500000bps\r\n" + ("" if profile == "console" else told if board == "atmega1284p" else counted) + "ok\r\n"
                              + PROMPT, "ID 2 at 250000bps\r\nok\r\n"])

    def test_packet_right_after_reset_is_answered_whole(self):
        """At any moment of the banner."""
        program = START + "".join(f"reset power\nwait {moment}\n" + say(PING_1) for moment in MOMENTS)
        for board, profile, heard in self.each(program):
            self.assertEqual(len(heard), 1 + len(MOMENTS))
            around = [said.split(REPLY_1.decode("latin-1")) for said in heard[1:]]
            for parts in around:
                self.assertEqual(len(parts), 2, (board, parts))
                self.assertIn("".join(parts), banner(board, profile) + PROMPT)
            self.assertTrue(any(before for before, _ in around), (board, profile))  # within the banner

    def test_save_keeps_the_mode_over_a_reset(self):
        reset = "reset power\n" + START
        saved = "text save\nwait 500000\nrest\n"
        program = START + text("mode program") + saved + reset + text("ping 1") + text("mode person") + saved + reset
        for board, profile, heard in self.each(program):
            self.assertEqual(heard[2], "ok\r\n", (board, profile))
            self.assertEqual(heard[3:5], ["ok\r\n", "ok\r\n" + PROMPT], (board, profile))  # no banner before the first
            self.assertEqual(heard[6], banner(board, profile) + PROMPT, (board, profile))

    def test_program_that_sends_mode_program_first_finds_its_ok(self):
        """As docs/console.md says, at any moment after the reset, also behind a line that is not ended."""
        program = START + "".join(f"reset external\nwait {moment}\nsay 03\ntext mode program\n"
                                  "wait 100000\nrest\n" + text("ping 1") for moment in MOMENTS)
        for board, profile, heard in self.each(program):
            for said, reply in zip(heard[1::2], heard[2::2]):
                self.assertRegex(said, r"\r\nok\r\n\Z")
                self.assertEqual(reply, "ok\r\n")


if __name__ == "__main__":
    unittest.main()
