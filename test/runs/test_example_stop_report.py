# SPDX-License-Identifier: MIT
"""examples/stop_report.h tells why a program has stopped: copies of examples with a mistake, or with trouble on the way."""
# needs: build/lib/libcds55xx-atmega128.a
import pathlib
import tempfile
import unittest

from simulator import ROOT, Run, call

LIMIT = "the limits of the servo do not permit this"
TROUBLE = """        if (robot.cycle.counters.periods == 300)
            cds_servos_inhibit(&robot.servos, &robot.servos.states[1], CDS_INHIBIT_STOPPED);
        if (robot.cycle.counters.periods == 320)
            cds_servos_release_all(&robot.servos);
"""


class StopReport(unittest.TestCase):
    def reported(self, example, old, new, seconds="4"):
        """What a copy of the example with `new` in place of `old` prints."""
        text = (ROOT / f"examples/{example}.c").read_text()
        self.assertEqual(text.count(old), 1)
        with tempfile.TemporaryDirectory() as folder:
            source, elf = (pathlib.Path(folder) / f"{example}{end}" for end in (".c", ".elf"))
            source.write_text(text.replace(old, new))
            self.assertEqual(call("avr-gcc", "-mmcu=atmega128", "-DF_CPU=16000000UL", "-std=gnu99", "-Os", "-flto",
                                  "-Wall", "-Wextra", "-Werror", "-Wl,--relax", "-Wl,--gc-sections", "-Iinclude",
                                  "-Iboards/atmega128", "-Iexamples", source, "build/lib/libcds55xx-atmega128.a", "-o",
                                  elf, cwd=ROOT), (0, ""))
            return Run(elf, "--host", "stdout", "--seconds", seconds, servos="1-3").output

    def test_angle_of_a_key_frame_beyond_the_limits_is_named(self):
        said = self.reported("keyframes", "{80, 0, 45}", "{80, 0, 95}")
        self.assertIn(f"\nstep 2: joint 2, wrist: {LIMIT}\n", "\n" + said)

    def test_key_frame_that_is_too_fast_is_named_with_its_time(self):
        said = self.reported("keyframes", "{{80, 0, 45}, 1000,", "{{80, 0, 45}, 100,")
        self.assertRegex("\n" + said, rf"\nstep 2: joint [02], (base|wrist): {LIMIT}, it needs \d+ ms\n")

    def test_key_frame_with_a_time_out_of_range_is_named(self):
        said = self.reported("keyframes", "-45}, 1500,", "-45}, 0,")
        self.assertIn("\nstep 3: argument out of range\n", "\n" + said)

    def test_row_of_the_table_out_of_range_is_named(self):
        said = self.reported("timed_move", "CDS_REVERSED, 150000,", "CDS_REVERSED, 350000,", seconds="1")
        self.assertIn("\njoint 1 of the table, or an ID: out of range\n", "\n" + said)

    def test_start_with_a_period_out_of_range_is_told(self):
        said = self.reported("timed_move", "    cds_robot_start(", "    robot.period_us = 100;\n    cds_robot_start(",
                             seconds="1")
        self.assertIn("\nnot started: argument out of range\n", "\n" + said)

    def test_move_that_is_too_fast_is_told_with_its_time(self):
        said = self.reported("timed_move", ".time_ms = 1500", ".time_ms = 150")
        self.assertRegex("\n" + said, rf"\nmotion: joint 0, left: {LIMIT}, it needs \d+ ms\n")

    def test_move_that_ends_early_ends_the_program(self):
        said = self.reported("timed_move", "        if (robot.state != CDS_ROBOT_RUNNING",
                             TROUBLE + "        if (robot.state != CDS_ROBOT_RUNNING")
        self.assertIn("\nmotion: joint 1, right: the servo may not be driven\n", "\n" + said)


if __name__ == "__main__":
    unittest.main()
