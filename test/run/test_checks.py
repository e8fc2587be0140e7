"""The project's own checks notice what they are for."""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from simulator import ROOT


def run(*command, **options):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          stdin=subprocess.DEVNULL, timeout=120, **options)
    return done.returncode, done.stdout


class Layering(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        for name in ["include", "src", "sim", "boards", "examples"]:
            shutil.copytree(ROOT / name, self.root / name)

    def tearDown(self):
        self.folder.cleanup()

    def breach(self, file, line):
        with open(self.root / file, "a") as source:
            source.write(line + "\n")
        status, output = run(sys.executable, ROOT / "scripts/layering.py", self.root)
        self.assertEqual(status, 1, output)
        self.assertIn(file, output)

    def test_the_tree_as_it_is_passes(self):
        self.assertEqual(run(sys.executable, ROOT / "scripts/layering.py", self.root), (0, ""))

    def test_core_must_not_include_an_avr_header(self):
        self.breach("src/core/bus.c", "#include <avr/io.h>")

    def test_core_must_not_know_a_register_or_the_clock(self):
        self.breach("src/core/link.c", "int x = UCSR1B;")
        self.breach("include/cds55xx/bus.h", "#define X (F_CPU / 8)")

    def test_core_must_not_know_a_board(self):
        self.breach("src/core/bus.c", '#include "board.h"')

    def test_controller_must_not_know_a_register(self):
        self.breach("src/controller/console.c", "int x = UCSR0A;")

    def test_avr_port_includes_no_more_of_the_core_than_the_seam(self):
        self.breach("src/avr/usart.c", '#include "cds55xx/bus.h"')

    def test_simulator_includes_nothing_of_the_library(self):
        self.breach("sim/codec.c", '#include "cds55xx/packet.h"')
        self.breach("sim/servo.c", '#include "../include/cds55xx/packet.h"')

    def test_boards_hold_no_code(self):
        self.breach("boards/atmega128/board.h", "static inline int f(void) { return 1; }")

    def test_only_packet_h_says_what_a_header_is(self):
        self.breach("src/core/parser.c", "#define HEADER 0xFF")


class Build(unittest.TestCase):
    def make(self, *arguments, **environment):
        return run("make", "-C", ROOT, "--no-print-directory", *arguments,
                   env={**os.environ, "MAKEFLAGS": "", **environment})

    def test_an_unknown_board_lists_those_there_are(self):
        status, output = self.make("lib", "BOARD=toaster")
        self.assertNotEqual(status, 0)
        self.assertIn("no board 'toaster'; BOARD= one of: arduino-mega atmega128", output)

    def test_help_has_a_line_for_every_target(self):
        _, output = self.make("help")
        for target in ["demo", "test", "deps", "lib", "firmware", "size", "flash", "fuses", "check"]:
            self.assertIn(f"make {target} ", output)

    def test_what_is_missing_is_named_and_not_installed(self):
        with tempfile.TemporaryDirectory() as empty:
            status, output = self.make("deps", f"UNITY={empty}/unity", "DEPS=no")
            self.assertNotEqual(status, 0)
            self.assertIn(f"missing Unity in {empty}/unity (make deps fetches it)", output)
            self.assertEqual(os.listdir(empty), [])

    def test_touching_a_header_makes_the_library_out_of_date(self):
        self.assertEqual(self.make("lib")[0], 0)
        header = ROOT / "include/cds55xx/link.h"
        before = header.stat()
        status, output = self.make("lib", "-n", "-W", "include/cds55xx/link.h")
        self.assertEqual((status, header.stat().st_mtime), (0, before.st_mtime))
        self.assertIn("bus.o", output)

    def test_flash_and_fuses_are_avrdude_command_lines_with_the_boards_data(self):
        self.assertIn("avrdude -p atmega128 -c usbasp -P usb -U flash:w:build/atmega128/controller.hex:i",
                      self.make("flash", "-n")[1])
        self.assertIn("efuse:w:0xff:m", self.make("fuses", "-n")[1])

    def test_a_firmware_over_budget_fails_the_size_check(self):
        elf = ROOT / "build/atmega128/controller.elf"
        self.assertEqual(run(ROOT / "scripts/size.py", elf, "24576", "3072")[0], 0)
        for limits in [("100", "3072"), ("24576", "100")]:
            status, output = run(ROOT / "scripts/size.py", elf, *limits)
            self.assertEqual(status, 1)
            self.assertIn("OVER BUDGET", output)


class Readme(unittest.TestCase):
    def test_what_it_quotes_of_commands_is_what_they_print(self):
        self.assertEqual(run(ROOT / "scripts/readme.py", "--check", cwd=ROOT), (0, ""))


class Runner(unittest.TestCase):
    """run-tests.py takes nothing for passed that did not say so."""

    def outcome(self, body):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "suite"
            program.write_text("#!/bin/sh\n" + body)
            program.chmod(0o755)
            status, output = run(ROOT / "scripts/run-tests.py", program)
            return status, output.strip().splitlines()[-1]

    def test_a_passing_suite(self):
        self.assertEqual(self.outcome("echo '3 Tests 0 Failures 0 Ignored'"), (0, "3 passed, 0 failed"))

    def test_a_failing_suite(self):
        self.assertEqual(self.outcome("echo '3 Tests 1 Failures 0 Ignored'; exit 1"),
                         (1, "2 passed, 1 failed"))

    def test_ignored_tests_have_not_passed(self):
        self.assertEqual(self.outcome("echo '3 Tests 0 Failures 2 Ignored'"), (1, "1 passed, 2 failed"))

    def test_a_crash_after_the_summary(self):
        self.assertEqual(self.outcome("echo '3 Tests 0 Failures 0 Ignored'; exit 139")[0], 1)

    def test_silence_is_a_failure(self):
        self.assertEqual(self.outcome("exit 0"), (1, "0 passed, 1 failed"))

    def test_no_tests_is_a_failure(self):
        self.assertEqual(self.outcome("echo '0 Tests 0 Failures 0 Ignored'")[0], 1)


if __name__ == "__main__":
    unittest.main()
