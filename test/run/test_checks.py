"""The project's own checks notice what they are for."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from simulator import ROOT, SIM


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
                   env={**os.environ, **environment})

    def test_an_unknown_board_lists_those_there_are(self):
        status, output = self.make("lib", "BOARD=toaster")
        self.assertNotEqual(status, 0)
        self.assertIn("no board 'toaster'; BOARD= one of: arbotix arduino-mega arduino-uno atmega128 cm510", output)

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
        flash = self.make("flash", "-n")[1]
        self.assertIn("avrdude -p atmega128 -c usbasp -P usb  -U flash:w:build/atmega128/controller.hex:i",
                      flash)
        self.assertIn("(fuse M103C): make fuses first", flash)
        self.assertIn("efuse:w:0xff:m", self.make("fuses", "-n")[1])
        self.assertIn("avrdude -p atmega2560 -c wiring -P /dev/ttyUSB7 -D -U flash:w:",
                      self.make("flash", "-n", "BOARD=arduino-mega", "PORT=/dev/ttyUSB7")[1])
        status, output = self.make("fuses", "BOARD=arduino-mega")
        self.assertNotEqual(status, 0)
        self.assertIn("right as shipped", output)

    def test_a_firmware_over_budget_fails_the_size_check(self):
        elf = ROOT / "build/atmega128/controller.elf"
        self.assertEqual(run(ROOT / "scripts/size.py", elf, "24576", "3072")[0], 0)
        for limits in [("100", "3072"), ("24576", "100")]:
            status, output = run(ROOT / "scripts/size.py", elf, *limits)
            self.assertEqual(status, 1)
            self.assertIn("OVER BUDGET", output)


class Readme(unittest.TestCase):
    def test_a_program_outside_the_tree_builds_and_runs_with_its_command_line(self):
        """The command line of "Link the library", word for word but for the folder."""
        text = (ROOT / "README.md").read_text()
        command = re.search(r"```sh\n(avr-gcc (?:.*\\\n)*.*)\n```", text)[1]
        with tempfile.TemporaryDirectory() as folder:
            shutil.copy(ROOT / "examples/two_servos.c", f"{folder}/robot.c")
            command = command.replace("robot.c", f"{folder}/robot.c")
            command = command.replace("robot.elf", f"{folder}/robot.elf")
            self.assertEqual(run("sh", "-c", command, cwd=ROOT), (0, ""))
            status, output = run(SIM, "firmware", f"{folder}/robot.elf", "--board", "atmega128",
                                 "--servos", "1,2", "--seconds", "2.5")
        self.assertEqual(status, 0, output)
        self.assertIn("3 packets in, 0 out, 0 damaged", output)

    def test_unoptimised_programs_are_refused_with_the_remedy(self):
        status, output = run("avr-gcc", "-mmcu=atmega128", "-DF_CPU=16000000UL", "-O0", "-Iinclude",
                             "-Isrc/avr", "-Iboards/atmega128", "-c", "examples/two_servos.c", "-o",
                             "/dev/null", cwd=ROOT)
        self.assertNotEqual(status, 0)
        self.assertIn("compile with -Os", output)

    def test_all_headers_compile_as_cpp(self):
        headers = sorted(p.relative_to(ROOT / "include") for p in (ROOT / "include").rglob("*.h"))
        source = "".join(f'#include "{h}"\n' for h in headers) + '#include "cds55xx_avr.h"\n' + """
            static struct cds_bus bus;
            CDS_AVR_BUS(bus, 0)
            CDS_AVR_CLOCK()
            """
        done = subprocess.run(
            ["avr-g++", "-mmcu=atmega2560", "-DF_CPU=16000000UL", "-Os", "-std=gnu++11", "-Wall",
             "-Werror", "-Iinclude", "-Isrc/avr", "-Iboards/arduino-mega", "-x", "c++", "-c", "-",
             "-o", "/dev/null"], input=source, text=True, cwd=ROOT, stderr=subprocess.PIPE)
        self.assertEqual((done.returncode, done.stderr), (0, ""))


class Turnaround(unittest.TestCase):
    def test_the_transmit_complete_vector_turns_the_line_around_first(self):
        """The enables before anything is saved; and no more than was written by hand."""
        rest = ["push", "ldi", "sts", "ldi", "sts", "pop", "reti"]
        for board, vector, turns in [("atmega128", "32", ["cbi", "sbi"] + rest),
                                     ("arduino-mega", "38", ["cbi", "sbi"] + rest),
                                     ("cm510", "27", ["cbi", "sbi"] + rest),
                                     ("arduino-uno", "20", ["cbi"] + rest)]:
            code = run("avr-objdump", "-d", "--no-show-raw-insn",
                       ROOT / f"build/{board}/controller.elf")[1]
            body = re.search(rf"<__vector_{vector}>:\n((?:.+\n)+)", code)[1]
            self.assertEqual(re.findall(r":\s+([a-z]+)", body), turns, body)


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
