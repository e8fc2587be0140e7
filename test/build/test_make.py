# SPDX-License-Identifier: MIT
"""What make promises: boards and their mistakes, what is missing, flash, fuses and run."""
# needs: build/lib/libcds55xx-atmega128.a build/host/cds55xx-sim
import os
import pathlib
import pty
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/runs"))

from simulator import SIM, Process, call


def copy_build_files(root):
    """What make reads, without the sources."""
    for name in ["mk", "boards", "test/boards", "test/runs", "scripts", "src/avr", "src/controller/avr"]:
        shutil.copytree(ROOT / name, root / name)
    (root / "sim").mkdir()
    (root / "examples").mkdir()
    for name in ["Makefile", "sim/sim.mk", "test/test.mk", "examples/two_servos.c"]:
        shutil.copy(ROOT / name, root / name)


class NewBoard(unittest.TestCase):
    def test_board_mk_with_an_mcu_takes_no_value_of_another_board(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            copy_build_files(root)
            new = root / "boards/new"
            (root / "boards/cm510").rename(new)
            for other in ["atmega128", "atmega1284p", "arbotix", "arduino-mega"]:  # arduino-uno is read before it
                shutil.rmtree(root / "boards" / other)
            text = (new / "board.mk").read_text()
            make = ["make", "-C", root, "-n", "-s", "--no-print-directory"]
            for line, message in [
                    ("", "boards/new lacks board.mk: MCU"), ("MCU :=\n", "boards/new lacks board.mk: MCU"),
                    ("MCU := atmega32\n", "boards/new/board.mk: there is no library for MCU 'atmega32'; MCU := one of: ")]:
                (new / "board.mk").write_text(re.sub(r"^MCU .*\n", line, text, flags=re.M))
                status, output = call(*make, "fuses", "BOARD=new")
                self.assertNotEqual(status, 0)
                self.assertIn(message, output)
            # the others have the defaults, and not the values of arduino-uno
            (new / "board.mk").write_text("MCU := atmega2561\n")
            self.assertEqual(call(*make, "flash", "BOARD=new", "-o", "port", "-o",
                                  "build/new/controller.hex")[1].split(),
                             "scripts/avrdude.sh 'usb' -p atmega2561 -c usbasp -U "
                             "flash:w:build/new/controller.hex:i".split())


class LongSuites(unittest.TestCase):
    def test_missing_suite_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            copy_build_files(root)
            (root / "test/runs/test_flood.py").unlink()
            status, output = call("make", "-C", root, "-s", "--no-print-directory", "help")
            self.assertEqual(status, 2, output)
            self.assertIn("LONG_SUITES of test/test.mk names test/runs/test_flood.py, which does not exist.", output)


class Progress(unittest.TestCase):
    """What a build of 21 files prints."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        root = pathlib.Path(folder.name)
        copy_build_files(root)
        for n in range(21):
            (root / f"file{n}.c").write_text(f"extern int x{n};\n")
        self.command = ["make", "-C", root, "--no-print-directory", "-o", "tools", "-o", "build/arduino-mega/board-checked",
                        *(f"build/arduino-mega/obj/file{n}.o" for n in range(21))]
        self.environment = {**os.environ, "MAKEFLAGS": ""}

    def test_build_output_is_no_terminal_each_tenth_step(self):
        status, output = call(*self.command, env=self.environment)
        self.assertEqual((status, output), (0, "   10  CC       build/arduino-mega/obj/file9.o\n"
                                               "   20  CC       build/arduino-mega/obj/file19.o\n"))

    def test_build_terminal_each_step_overwrites_the_one_before(self):
        ours, theirs = pty.openpty()
        subprocess.run(self.command, env=self.environment, stdout=theirs, stderr=theirs, check=True)
        os.close(theirs)
        with open(ours, "rb", closefd=True, buffering=0) as terminal:
            output = terminal.read(16384).decode()
        self.assertEqual(output, "".join(
            f"\033[K\033[?7l{n + 1:5}  CC       build/arduino-mega/obj/file{n}.o\033[?7h\r" for n in range(21)))

    def test_build_silent_prints_nothing(self):
        self.assertEqual(call(*self.command, "-s", env=self.environment), (0, ""))

    def test_build_verbose_prints_commands(self):
        status, output = call(*self.command, "V=1", env=self.environment)
        self.assertEqual(status, 0, output)
        self.assertEqual(output.count("avr-gcc "), 21)


class Make(unittest.TestCase):
    """make flash, fuses and run, in a copy of the build's files; avrdude is a script that tells its arguments."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        copy_build_files(self.root)
        (self.root / "bin").mkdir()
        self.fake_avrdude('echo "avrdude was called: $*"')

    def fake_avrdude(self, command):
        avrdude = self.root / "bin/avrdude"
        avrdude.write_text(f"#!/bin/sh\n{command}\n")
        avrdude.chmod(0o755)

    def make(self, target, *words, **environment):
        """(status, output) of a make that builds nothing."""
        path = f"{self.root / 'bin'}:{os.environ['PATH']}"
        done = subprocess.run(
            ["make", "-C", self.root, "-s", "--no-print-directory", "-o", "tools", "-o",
             "build/arduino-mega/controller.hex", target, *words], stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env={**os.environ, "PATH": path, "MAKEFLAGS": "", **environment})
        return done.returncode, done.stdout

    def set_fuses(self, line):
        path = self.root / "boards/cm510/board.mk"
        text, count = re.subn(r"^FUSES .*\n", line, path.read_text(), flags=re.M)
        self.assertEqual(count, 1)
        path.write_text(text)

    def test_flash_and_fuses_missing_port_not_started(self):
        for port in ["/dev/ttyNONE", "./ttyNONE", "../ttyNONE", "/dev/none0:/dev/none1"]:
            for target in ["flash", "fuses"]:
                status, output = self.make(target, "BOARD=atmega128", f"PORT={port}")
                self.assertNotEqual(status, 0, output)
                self.assertIn(f"PORT={port} does not exist; plug the board in, or name its port",
                              output)
                self.assertNotIn("avrdude was called", output)

    def test_flash_missing_port_ends_before_the_build(self):
        done = subprocess.run(
            ["make", "-C", self.root, "-j1", "flash", "PORT=/dev/ttyNONE"], text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env={**os.environ, "MAKEFLAGS": ""})
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("PORT=/dev/ttyNONE does not exist", done.stdout)
        self.assertFalse((self.root / "build").exists(), done.stdout)

    def test_flash_port_that_is_no_device_not_started(self):
        (self.root / "file").write_text("")
        for port in ["./file", "./bin"]:
            status, output = self.make("flash", f"PORT={port}")
            self.assertNotEqual(status, 0, output)
            self.assertIn(f"PORT={port} is no device; name the serial port of the board", output)
            self.assertNotIn("avrdude was called", output)

    def test_flash_device_or_name_of_a_port_is_passed_on(self):
        for port in ["/dev/null", "/dev/null:/dev/zero", "usb", "usb:0042", "net:host:1234", "ch340",
                     "usb:serial"]:
            status, output = self.make("flash", f"PORT={port}")
            self.assertEqual(status, 0, output)
            self.assertIn(f"avrdude was called: -P {port} -p atmega2560 -c wiring -D -U "
                          "flash:w:build/arduino-mega/controller.hex:i\n", output)

    def test_flash_failure_of_avrdude_fails_make(self):
        self.fake_avrdude("exit 1")
        self.assertNotEqual(self.make("flash", "PORT=usb")[0], 0)

    def test_flash_avrdude_that_spins_is_ended(self):
        self.fake_avrdude("while :; do sleep 0.1; done")
        status, output = self.make("flash", "PORT=usb", AVRDUDE_LIMIT_S="1")
        self.assertNotEqual(status, 0, output)
        self.assertIn("avrdude is ended after 1 s; ", output)

    def test_fuses_of_each_board_written_or_right_as_shipped(self):
        shipped = [path.parent.name for path in (ROOT / "boards").glob("*/board.mk")
                   if re.search(r"^FUSES +:= as-shipped$", path.read_text(), re.M)]
        self.assertIn("cm510", shipped)
        for board in shipped:
            status, output = self.make("fuses", f"BOARD={board}")
            self.assertEqual(status, 0, output)  # so `make fuses flash` goes on
            self.assertIn(f"the fuses of {board} are right as shipped: nothing to write\n", output)
            self.assertNotIn("avrdude was called", output)
        status, output = self.make("fuses", "BOARD=atmega128")
        self.assertEqual(status, 0, output)
        self.assertIn("avrdude was called: -P usb -p atmega128 -c usbasp -U lfuse:w:0x3f:m -U "
                      "hfuse:w:0xc1:m -U efuse:w:0xff:m\n", output)

    def test_fuses_board_without_fuses_says_not_known(self):
        for line in ["", "FUSES :=\n", "FUSES := as shipped\n"]:
            with self.subTest(line):
                self.setUp()
                self.set_fuses(line)
                status, output = self.make("fuses", "BOARD=cm510")
                self.assertNotEqual(status, 0)
                self.assertIn("the right fuses of cm510 are not known: nothing is written", output)
                self.assertIn("set FUSES in boards/cm510/board.mk", output)
                self.assertNotIn("right as shipped", output)
                self.assertNotIn("avrdude was called", output)

    def test_run_host_baud_is_passed_to_the_simulator(self):
        for words, baud in [([], "board"), (["HOST_BAUD=client"], "client")]:
            status, output = self.make("run", "-n", "-o", "build/arduino-mega/controller.elf", "-o",
                                       "build/host/cds55xx-sim", *words)
            self.assertEqual(status, 0, output)
            self.assertIn(f" --host-baud {baud} ", output)

    def test_run_only_warns_of_breaches_of_the_wire(self):
        status, output = self.make("run", "-n", "-o", "build/arduino-mega/controller.elf", "-o", "build/host/cds55xx-sim")
        self.assertEqual(status, 0, output)
        self.assertIn(" --rules warn ", output)

    def test_run_takes_servos_that_share_an_id(self):
        status, output = self.make("run", "-n", "SERVOS=1,1,1", "-o", "build/arduino-mega/controller.elf", "-o",
                                   "build/host/cds55xx-sim")
        self.assertEqual(status, 0, output)
        self.assertIn(" --servos '1,1,1' --allow-duplicates ", output)

    def test_test_build_with_a_word_runs_suites_of_that_name(self):
        names = "test/build/test_packing.py test/build/test_make.py"
        output = self.make("test-build", "-n", "T=zzz")[1]
        self.assertIn("no suite of test-build has 'zzz' in its name", output)
        suites = self.make("test-build", "-n", "T=packing", f"ALL_BUILD_TESTS={names}")[1].splitlines()[-1]
        self.assertIn("test/build/test_packing.py", suites)
        self.assertNotIn("test/build/test_make.py", suites)

    def test_run_follow_shows_the_live_table(self):
        for words, follows in [([], False), (["FOLLOW=0"], False), (["FOLLOW=1"], True)]:
            status, output = self.make("run", "-n", "-o", "build/arduino-mega/controller.elf", "-o",
                                       "build/host/cds55xx-sim", "-o", "build/arduino-mega/run.eeprom", *words)
            self.assertEqual(status, 0, output)
            self.assertEqual(" --follow" in output, follows)
            self.assertIn(" --poke build/arduino-mega/poke", output)
            self.assertIn("""--poke-hint 'make poke DO="load 1 300"'""", output)
        status, output = self.make("run", "-n", "BOARD=cm510", "-o", "build/cm510/controller.elf", "-o",
                                   "build/host/cds55xx-sim")
        self.assertIn("""--poke-hint 'make poke BOARD=cm510 DO="load 1 300"'""", output)

    def test_panel_keeps_its_eeprom_and_has_a_socket_of_each_port(self):
        saved = self.root / "build/panel.eeprom"
        saved.parent.mkdir(exist_ok=True)
        saved.write_text("poses")
        for port, socket in [("8055", "poke "), ("8056", "poke-8056 ")]:
            output = self.make("panel", "-n", "-W", "sim/panel.script", f"PANEL_PORT={port}", "-o", "build/arduino-mega/controller.elf",
                               "-o", "build/host/cds55xx-sim", "-o", "build/panel/app.js")[1]
            self.assertIn(f" --poke build/arduino-mega/{socket}", output)
            self.assertNotIn("--script", output)

    def test_poke_without_order_or_simulator_says_what_to_do(self):
        for words, message in [([], 'say what to do, as in: make poke DO="load 1 300"'),
                               (["DO=load 1 300"], "no simulator of arduino-mega runs: start one with make run")]:
            status, output = self.make("poke", *words)
            self.assertNotEqual(status, 0)
            self.assertIn(message, output)

    def test_unknown_target_names_make_help(self):
        status, output = self.make("nosuch")
        self.assertEqual(status, 2)
        self.assertIn("there is no target 'nosuch'; 'make help' lists the targets\n", output)

    def test_follow_that_is_no_switch_is_refused(self):
        status, output = self.make("help", "FOLLOW=yes")
        self.assertNotEqual(status, 0)
        self.assertIn("FOLLOW=yes is not known: FOLLOW=1 shows the live table", output)

    def test_poke_passes_the_order_and_returns_its_result(self):
        """The socket is where make run puts it."""
        for name in ["build/host", "build/arduino-mega"]:
            (self.root / name).mkdir(parents=True)
        (self.root / "build/host/cds55xx-sim").symlink_to(SIM)
        with Process("bus", "--servos", "1", "--pty", "--poke", self.root / "build/arduino-mega/poke"):
            self.assertEqual(self.make("poke", "DO=print a 'b' \\ *"), (0, "a 'b' \\ *\nok\n"))
            status, output = self.make("poke", "DO=load 7 300")
            self.assertNotEqual(status, 0)
            self.assertIn("error: there is no servo 7; there: 1\n", output)


class BoardCheck(unittest.TestCase):
    """board_check.h alone, as a program with a Makefile of its own compiles it."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def compile(self, board, pattern, text, mcu, program=""):
        header, count = re.subn(pattern, text, (ROOT / f"boards/{board}/board.h").read_text())
        self.assertNotEqual(count, 0)
        (self.folder / "board.h").write_text(header)
        (self.folder / "program.c").write_text(program or "#include <cds55xx/avr/board_check.h>\nextern int not_empty;\n")
        return call("avr-gcc", "-std=gnu99", f"-mmcu={mcu}", "-DF_CPU=16000000UL", "-Os", "-Wall", "-Wextra", "-Wpedantic",
                    "-fsyntax-only", "-I", self.folder, "-I", ROOT / "include", self.folder / "program.c")

    def assert_one_error(self, message, *arguments):
        status, output = self.compile(*arguments)
        self.assertNotEqual(status, 0)
        self.assertEqual(re.findall(r" error: (.*)", output)[:1], [message])
        self.assertLessEqual(output.count(" error: "), 2, output)  # the other one says that the compiler stops

    def test_register_as_port_or_bit_is_one_error(self):
        for end, value, right in [("PORT", "PORTC", "the letter of the port alone"), ("BIT", "PORTC", "a bit from 0 to 7"),
                                  ("PORT", "(C)", "the letter of the port alone"), ("BIT", "(3)", "a bit from 0 to 7")]:
            self.assert_one_error(f"board.h: BOARD_BUS0_RX_ENABLE_{end} is a register, or between parentheses; write {right}",
                                  "atmega128", rf"(RX_ENABLE_{end} +)\w", rf"\g<1>{value}", "atmega128")

    def test_pin_that_the_port_lacks_is_named(self):
        for board, mcu, port, bit in [("arduino-mega", "atmega2560", "G", 7), ("arduino-mega", "atmega2560", "G", 6),
                                      ("atmega128", "atmega128", "G", 5), ("arduino-uno", "atmega328p", "C", 7)]:
            pattern = r"(BUS0_(?:RX_)?ENABLE_PORT +)\w(\n.*_BIT +)\d"
            self.assert_one_error(f"board.h: BOARD_BUS0_{'' if board == 'arduino-uno' else 'RX_'}ENABLE is on port {port} bit {bit}, "
                                  f"but that port of {mcu} has no pin of this number; use another pin",
                                  board, pattern, rf"\g<1>{port}\g<2>{bit}", mcu)
            if port == "C":  # ports G have addresses that sbi does not reach, so no enable may be there
                self.assertEqual(self.compile(board, pattern, rf"\g<1>{port}\g<2>{bit - 2}", mcu), (0, ""))

    def test_host_link_without_a_rate_is_one_error(self):
        self.assert_one_error('#error "board.h: BOARD_HOST_BAUD is missing; write the rate of the host link, as in 115200"',
                              "atmega128", r".*HOST_BAUD.*\n", "", "atmega128")

    def test_bus_that_the_board_lacks_is_one_error(self):
        program = """
            #include <cds55xx/robot.h>
            #include <cds55xx/avr.h>
            CDS_JOINTS(joints) = {CDS_JOINT(1, CDS_FORWARD, 150000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, "a")};
            CDS_ROBOT(robot, joints);
            CDS_AVR_ROBOT(robot, %d)
            """
        for board, mcu, count in [("atmega128", "atmega128", 1), ("arduino-mega", "atmega2560", 3)]:
            for bus in range(count):
                self.assertEqual(self.compile(board, r"\Z", "", mcu, program % bus), (0, ""))
            self.assert_one_error(f"board.h has no bus {count} for (robot).bus: it has {count} of them, and the first one is bus 0",
                                  board, r"\Z", "", mcu, program % count)


class Build(unittest.TestCase):
    def make(self, *arguments, **environment):
        return call("make", "-C", ROOT, "--no-print-directory", *arguments,
                    env={**os.environ, **environment})

    def test_an_unknown_board_lists_those_there_are(self):
        status, output = self.make("lib", "BOARD=toaster")
        self.assertNotEqual(status, 0)
        boards = sorted(path.parent.name for path in (ROOT / "boards").glob("*/board.mk"))
        self.assertIn(f"no board 'toaster'; BOARD= one of: {' '.join(boards)}", output)

    def assert_refused(self, message, *arguments, **environment):
        status, output = self.make("-n", "firmware", *arguments, **environment)
        self.assertNotEqual(status, 0, output)
        self.assertIn(message, output)

    def assert_one_line(self, message, *arguments):
        status, output = self.make("-n", "firmware", *arguments)
        self.assertNotEqual(status, 0, output)
        self.assertEqual(output.count("\n"), 1, output)
        self.assertIn(message, output)

    def assert_profile(self, profile, *arguments, **environment):
        status, output = self.make("-n", "firmware", *arguments, **environment)
        self.assertEqual(status, 0, output)
        self.assertIn(f"/{profile}.elf build/", output)

    def test_part_of_the_faults_does_not_replace_their_table(self):
        for words, left_out in [(["ROWS=F16"], "ROWS"), (["FAULTS_PART=1/20"], "FAULTS_PART")]:
            status, output = self.make("-n", "faults-docs", *words)
            self.assertNotEqual(status, 0, output)
            self.assertIn(f"make faults-docs renews the whole table: leave out {left_out}.", output)

    def test_board_of_two_words_or_none_is_refused(self):
        for words in ["atmega128 arbotix", "atmega128 toaster", "atmega128 ", ""]:
            self.assert_refused(f"no board '{words}'; BOARD= one of: ", f"BOARD={words}")

    def make_board(self, header="", chip="MCU := atmega644p"):
        """The folder of a board outside the tree: that of atmega128, with these lines of board.h left out."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        board = pathlib.Path(folder.name) / "mine"
        board.mkdir()
        text = (ROOT / "boards/atmega128/board.h").read_text()
        (board / "board.h").write_text(re.sub(rf"^#define BOARD_({header})\b.*\n", "", text, flags=re.M))
        (board / "board.mk").write_text(chip + "\n")
        return board

    def test_firmware_of_a_board_is_the_program_of_board_mk(self):
        board = self.make_board(r"HOST_\w+")
        hexes = {}
        for name in ["a", "b", "a"]:
            source = board.parent / f"{name}.c"
            if not source.exists():
                source.write_text(f'const char volatile text[] = "program {name}";\nint main(void) {{ return text[0]; }}\n')
            (board / "board.mk").write_text(f"MCU := atmega644p\nFIRMWARE := {source}\n")
            status, output = self.make("firmware", f"BOARD_DIR={board}")
            self.assertEqual(status, 0, output)
            content = (ROOT / "build/mine/controller.hex").read_text()
            self.assertEqual(hexes.setdefault(name, content), content)
        self.assertEqual(len(set(hexes.values())), 2)

    def test_board_dir_named_board_has_the_name_of_the_folder_above(self):
        board = self.make_board()
        for name, parts in [("mine", "mine"), ("left-board", "left/board"), ("right-board", "right/board")]:
            folder = shutil.copytree(board, board.parent / "robots" / parts)
            self.assertIn(f"cp build/{name}/console.elf build/{name}/controller.elf\n",
                          self.make("-n", "firmware", f"BOARD_DIR={folder}")[1])

    def test_board_mk_value_with_blanks_or_comment_behind_is_taken(self):
        board = self.make_board()
        for chip in ["MCU := atmega644p # the chip\nF_CPU := 16000000  \nPROFILES := bridge console # both\n"
                     "PROFILE := bridge # small\nPORT := /dev/null # ours", "  MCU ?= atmega644p\nPROFILE ?= bridge\nPORT = /dev/null"]:
            (board / "board.mk").write_text(chip + "\n")
            status, output = self.make("-n", "flash", f"BOARD_DIR={board}")
            self.assertEqual(status, 0, output)
            self.assertIn("cp build/mine/bridge.elf build/mine/controller.elf\n", output)
            self.assertIn("scripts/avrdude.sh '/dev/null' -p atmega644p ", output)
            self.assertIn(" -DF_CPU=16000000UL ", output)

    def test_board_mk_value_that_cannot_be_is_one_line(self):
        board = self.make_board()
        for line, message in [
                ("PROFILE := fulll", "PROFILE is 'fulll'; PROFILE := one of: bridge console"),
                ("PROFILE := full # too large", "PROFILE is 'full'; PROFILE := one of: bridge console"),
                ("PROFILES := bridge ful", "there is no profile 'ful'; PROFILES := some of: bridge console full"),
                ("F_CPU := 8000000", "F_CPU is 8000000; F_CPU := 16000000, which is the only clock that works"),
                ("FIRMWARE := nothere.c", f"FIRMWARE is 'nothere.c', which is no C file; FIRMWARE := its absolute path, or its path from {ROOT}"),
                ("FIRMWARE := README.md", "FIRMWARE is 'README.md', which is no C file"),
                ("FIRMWARE := examples/robot.c examples/two_joints.c", "'examples/robot.c examples/two_joints.c', which is no C file")]:
            (board / "board.mk").write_text(f"MCU := atmega644p\n{line}\n")
            self.assert_one_line(f"{board}/board.mk: {message}" if message[0] != "'" else message, f"BOARD_DIR={board}")

    def test_board_h_with_other_blanks_in_define_is_read(self):
        for define in ["#define\t", "#define  ", " #define ", "# define "]:
            board = self.make_board()
            text = (board / "board.h").read_text()
            (board / "board.h").write_text(text.replace("#define BOARD_BUS0_RXD_BIT ", f"{define}BOARD_BUS0_RXD_BIT "))
            status, output = self.make("-n", "firmware", f"BOARD_DIR={board}")
            self.assertEqual(status, 0, output)

    def test_board_dir_with_an_mcu_builds_flashes_and_runs(self):
        board = self.make_board()
        for target, line in [
                ("firmware", f" -I{board} "),
                ("run", f"--board {board} --servos '1-18'"),
                ("run-example", f"--board {board} --servos '1-18'"),
                ("size", "scripts/size.py build/mine/bridge.elf - - build/mine/console.elf - -   --note  --too-large mine/full.elf"),
                ("examples", "-o build/mine/examples/robot.elf"),
                ("flash", "scripts/avrdude.sh 'usb' -p atmega644p -c usbasp  -U flash:w:build/mine/controller.hex:i")]:
            status, output = self.make("-n", target, f"BOARD_DIR={board}")
            self.assertEqual(status, 0, output)
            self.assertIn(line, output.replace("\\\n", ""))

    def test_run_example_builds_and_runs_a_program_of_the_user(self):
        for left_out in ["", r"HOST_\w+"]:  # a board without a host link needs no FIRMWARE for it
            board = self.make_board(left_out)
            source = board.parent / "hello.c"
            shutil.copy(ROOT / "examples/two_joints.c", source)
            status, output = self.make("run-example", f"EXAMPLE={source}", f"BOARD_DIR={board}", "SERVOS=1-2",
                                       "SECONDS=1")
            self.assertEqual(status, 0, output)
            self.assertIn("rules:   none broken\n", output)
            self.assertIn("picture: build/hello.svg\n", output)
        status, output = self.make("run-example", f"EXAMPLE={source}", "SERVOS=1-2", "SECONDS=1")
        self.assertEqual(status, 0, output)
        source.write_text("int main(void) { return nothing; }\n")
        self.assertIn("hello.c:1:25: error: ", self.make("run-example", f"EXAMPLE={source}")[1])
        for value, message in [("/nowhere/hello.c", "EXAMPLE=/nowhere/hello.c does not exist"),
                               ("/a b/hello.c", "EXAMPLE=/a b/hello.c has a blank"),
                               ("hello", "there is no example 'hello'; EXAMPLE= a C file of yours, or one of: blink ")]:
            self.assertIn(message, self.make("-n", "run-example", f"EXAMPLE={value}")[1])

    def test_board_dir_names_all_that_is_missing_at_once(self):
        board = self.make_board("BUS0_TXD_BIT|CLOCK_TIMER|HOST_BAUD", chip="# nothing")
        self.assert_one_line(f"{board} lacks board.mk: MCU; board.h: BOARD_BUS0_TXD_BIT, BOARD_CLOCK_TIMER, "
                             "BOARD_HOST_BAUD (docs/linking.md, A board of your own)", f"BOARD_DIR={board}")
        board = self.make_board("HOST_USART|HOST_BAUD")
        self.assert_one_line(f"{board} lacks board.h: BOARD_HOST_USART, BOARD_HOST_BAUD, or, without a host link, "
                             "FIRMWARE in board.mk", f"BOARD_DIR={board}")
        (board / "board.h").unlink()
        self.assert_one_line(f"{board} lacks board.h (docs/linking.md", f"BOARD_DIR={board}")
        self.assert_one_line("/nowhere is no folder", "BOARD_DIR=/nowhere")

    def test_board_dir_with_a_quoted_value_is_one_line(self):
        for value in ["'D'", '"D"', "(D)"]:
            board = self.make_board()
            text = (board / "board.h").read_text()
            (board / "board.h").write_text(re.sub(r"(BUS0_RXD_PORT +)D", rf"\g<1>{value}", text))
            self.assert_one_line(f"{board}/board.h: BOARD_BUS0_RXD_PORT is {value}; use a number, a letter or a word, without "
                                 "quotes", f"BOARD_DIR={board}")

    def test_board_dir_macros_of_the_user_may_have_any_value(self):
        board = self.make_board()
        with open(board / "board.h", "a", encoding="utf-8") as header:
            header.write("#define BOARD_LED_MASK (1<<5)\n#define BOARD_NAME \"mine\"\n")
        self.assert_profile("console", f"BOARD_DIR={board}")

    def test_board_dir_with_a_wrong_value_is_the_only_error(self):
        for pattern, text, message in [
                (r"(RX_ENABLE_PORT) D", r"\1 d", "board.h: BOARD_BUS0_RX_ENABLE is on port d bit 7; use a port of atmega644p"),
                (r"(RXD_BIT +)2", r"\g<1>0", "USART 1 of atmega644p has RXD on port D bit 2 and TXD on port D bit 3"),
                (r"\Z", "#define BOARD_BUS0_WIRING TWO\n", "use TWO_ENABLES, ONE_ENABLE, TIED, ADAPTER or ADAPTER_ECHO"),
                *((r"(HOST_BAUD +)\w+", rf"\g<1>{baud}", f"the host link has the rate {baud}; use a rate within 3 % of 2000000 / n")
                  for baud in ["x", "0", "3000000"])]:
            board = self.make_board()
            header = board / "board.h"
            header.write_text(re.sub(pattern, text, header.read_text()))
            shutil.rmtree(ROOT / "build/mine", ignore_errors=True)
            example = ["run-example", f"EXAMPLE={ROOT}/examples/two_joints.c"]
            for words in [["firmware"], ["firmware", "-j2"], example]:
                status, output = self.make(*words, f"BOARD_DIR={board}")
                self.assertNotEqual(status, 0)
                self.assertEqual(output.count(" error: "), 2, output)  # the other one says that the compiler stops
                self.assertIn(message, output)
                self.assertEqual(list((ROOT / "build/mine").rglob("*.o")), [])  # nothing was compiled before
            self.assertIn("cds55xx/avr/board_check.h", self.make("-n", *example, f"BOARD_DIR={board}")[1])
            header.write_text((ROOT / "boards/atmega128/board.h").read_text())  # corrected
            self.assertEqual(self.make("build/mine/board-checked", f"BOARD_DIR={board}"), (0, ""))

    def test_board_dir_with_a_name_of_avr_io_h_names_letter_or_digit(self):
        for pattern, value, remedy in [(r"(RX_ENABLE_PORT) D", "PORTC", "write C"), (r"(RX_ENABLE_PORT) D", "PC3", "write C"),
                                       (r"(RX_ENABLE_BIT)  7", "PC3", "write 3"), (r"(RX_ENABLE_BIT)  7", "DDC3", "write 3"),
                                       (r"(RX_ENABLE_BIT)  7", "PORTC", "write a number"),
                                       (r"(BUS0_USART)  ", "UDR1", "write 1"), (r"(CLOCK_TIMER) 1", "TIMER3", "write 3")]:
            board = self.make_board()
            text = (board / "board.h").read_text()
            (board / "board.h").write_text(re.sub(pattern, rf"\1 {value} //", text))
            name = re.search(r"\w+", pattern.replace("(", "").replace("BUS0_", ""))[0]
            self.assert_one_line(f"{name} is {value}; {remedy} (docs/linking.md", f"BOARD_DIR={board}")

    def test_board_dir_with_a_typing_error_names_what_is_meant(self):
        for line, meant in [("BOARD_BUS0_WIRNG TIED", "did you mean BOARD_BUS0_WIRING?"),
                            ("BOARD_BUS0_RXENABLE_PORT D", "did you mean BOARD_BUS0_RX_ENABLE_PORT?"),
                            ("BOARD_HOST_BUAD 57600", "did you mean BOARD_HOST_BAUD?"),
                            ("board_bus_count 1", None), ("BOARD_BUS3_USART 1", "remove this line, which has no effect")]:
            board = self.make_board()
            with open(board / "board.h", "a", encoding="utf-8") as header:
                header.write(f"#define {line}\n")
            if meant:
                self.assert_one_line(f"{board}/board.h: {line.split()[0]} is unknown; {meant}", f"BOARD_DIR={board}")
            else:
                self.assert_profile("console", f"BOARD_DIR={board}")
        board = self.make_board("HOST_BAUD")  # what is meant is not missing, too
        with open(board / "board.h", "a", encoding="utf-8") as header:
            header.write("#define BOARD_HOST_BUAD 57600\n")
        self.assert_one_line("did you mean BOARD_HOST_BAUD? (docs/linking.md", f"BOARD_DIR={board}")

    def test_board_mk_with_a_typing_error_names_what_is_meant(self):
        for line, message in [("PROGRAMER := avrisp", "PROGRAMER is unknown; did you mean PROGRAMMER?"),
                              ("flash_max = 1000", "flash_max is unknown; did you mean FLASH_MAX?"),
                              ("COLOUR ?= red", "COLOUR is unknown; remove this line, which has no effect"),
                              ("SPEED := 10\nFLASH_FLAGS := -B $(SPEED)", None)]:  # a variable of the user's own
            board = self.make_board(chip=f"MCU := atmega644p\n{line}")
            if message:
                self.assert_one_line(f"{board}/board.mk: {message}", f"BOARD_DIR={board}")
            else:
                self.assert_profile("console", f"BOARD_DIR={board}")
        board = self.make_board(chip="MUC := atmega644p")
        self.assert_one_line(f"{board}/board.mk: MUC is unknown; did you mean MCU? (docs/linking.md", f"BOARD_DIR={board}")

    def test_board_dir_with_half_a_host_link_lacks_the_other_half(self):
        for left_out in ["HOST_BAUD", "HOST_USART"]:
            board = self.make_board(left_out)
            status, output = self.make("-n", "run-example", f"EXAMPLE={ROOT}/examples/two_joints.c", f"BOARD_DIR={board}")
            self.assertNotEqual(status, 0)
            self.assertIn(f"{board} lacks board.h: BOARD_{left_out} (docs/linking.md", output)

    def test_board_dir_that_cannot_be_is_refused(self):
        board = self.make_board()
        self.assert_one_line("leave one of them out", f"BOARD_DIR={board}", "BOARD=cm510")
        self.assert_one_line("BOARD_DIR=/ is no folder of a board; name the folder that has board.mk", "BOARD_DIR=/")
        for chip, message in [("atmega32", "there is no library for MCU 'atmega32'; MCU := one of: at90can128 "),
                              ("atmega328p", "the controller does not fit the RAM of atmega328p; name a program")]:
            (board / "board.mk").write_text(f"MCU := {chip}\n")
            self.assert_one_line(message, f"BOARD_DIR={board}")
        board = board.rename(board.parent / "cm510")
        self.assert_one_line("boards/ has a board 'cm510', too", f"BOARD_DIR={board}")
        for name in ["lib", "host", "adapter", "firmware"]:
            board = board.rename(board.parent / name)
            self.assert_one_line(f"build/{name} has other files than those of a board: give the folder {board} another name",
                                 f"BOARD_DIR={board}")

    def test_path_with_a_character_of_make_or_the_shell(self):
        rows = [(name, "'\"$") for name in ["PREFIX", "DESTDIR", "PORT"]]
        rows += [("BOARD_DIR", "'\"$#:;%&()*?[]{}|<>=\\` "), *((name, "'$#: ") for name in ["ELF", "EXAMPLE", "UNITY"])]
        for name, characters in rows:
            for character in characters:
                path = f"/tmp/a{character}b"
                told = f"{name}={path} has a {character.replace(' ', 'blank')}, which has a meaning in make or the shell; rename "
                self.assert_one_line(told, f"{name}={path}")
        status, output = self.make("-n", "uninstall", PREFIX="/tmp/it's")
        self.assertIn("PREFIX=/tmp/it's has a ', ", output)
        self.assertNotEqual(status, 0)

    def test_servos_for_the_simulator_are_no_shell_words(self):
        self.assert_one_line("SERVOS=1;id has a ;, which has a meaning in make or the shell; leave it out", "SERVOS=1;id")
        self.assert_one_line("SERVOS= names no servo: give IDs, as in SERVOS=1-6", "SERVOS=")
        self.assert_one_line("SERVO= is not known; did you mean SERVOS=1-3?", "SERVO=1-3")
        self.assert_one_line("HOST_BAUD=9600 is not known: give board, its own rate, or client, the rate of the terminal",
                             "HOST_BAUD=9600")

    def test_flash_writes_another_elf(self):
        output = self.make("-n", "flash", "ELF=README.md")[1]
        self.assertIn("avr-objcopy -O ihex -R .eeprom README.md build/arduino-mega/flash.hex", output)
        self.assertIn("-U flash:w:build/arduino-mega/flash.hex:i", output)
        self.assert_one_line("ELF=none.elf does not exist", "ELF=none.elf")

    def test_library_of_an_unknown_chip_lists_those_there_are(self):
        self.assert_one_line("there is no library for 'atmega32'; MCUS= some of: at90can128 ", "MCUS=atmega32")

    def test_no_chip_at_all_lists_those_there_are(self):
        for words in ["", " "]:
            self.assert_one_line("MCUS= names no chip; leave it out, or MCUS= some of: at90can128 ", f"MCUS={words}")

    def test_profile_that_is_not_one_name_is_refused(self):
        for words in ["huge", "full bridge", "full huge", "bridge "]:
            message = f"no profile '{words}'; PROFILE= one of: bridge console full"
            self.assert_refused(message, f"PROFILE={words}")
            self.assert_refused(message, PROFILE=words)

    def test_profile_that_does_not_fit_names_those_that_fit(self):
        message = ("profile 'full' does not fit the flash of arbotix; PROFILE= one of: "
                   "bridge console")
        self.assert_refused(message, "BOARD=arbotix", "PROFILE=full")
        self.assert_refused(message, "BOARD=arbotix", PROFILE="full")

    def test_profile_on_a_board_without_profiles_is_refused(self):
        message = "arduino-uno has no profiles, its firmware is examples/two_servos.c"
        self.assert_refused(message, "BOARD=arduino-uno", "PROFILE=full")
        self.assert_refused(message, "BOARD=arduino-uno", PROFILE="bridge")

    def test_profile_of_command_line_environment_or_board(self):
        self.assert_profile("full")
        self.assert_profile("console", "BOARD=arbotix")
        self.assert_profile("bridge", "PROFILE=bridge")
        self.assert_profile("bridge", PROFILE="bridge")
        self.assert_profile("bridge", "BOARD=arbotix", PROFILE="bridge")
        self.assert_profile("console", "PROFILE=console", PROFILE="bridge")

    def test_profile_of_environment_reaches_a_make_below(self):
        output = self.make("--eval", "below: ; @echo below: $$PROFILE", "below", "BOARD=arbotix",
                           PROFILE="bridge")[1]
        self.assertIn("below: bridge\n", output)

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

    def test_word_that_no_suite_has_is_named(self):
        for words in ["nosuch", "nosuch ring", "ring nosuch"]:
            status, output = self.make("test", f"T={words}")
            self.assertNotEqual(status, 0)
            self.assertIn("no suite has 'nosuch' in its name; make list-tests lists the suites", output)

    def test_list_of_suites_has_each_name_once(self):
        names = self.make("list-tests")[1].split()
        self.assertEqual(names, sorted(set(names)))
        for name in ["test_ring", "test_console", "test_pty", "test_console_commands"]:
            self.assertIn(name, names)

    def test_suite_of_the_core_builds_no_controller(self):
        compiled = re.findall(r" -c (\S+) -o ", self.make("test", "-n", "-B", "T=test_ring")[1])
        self.assertEqual({path for path in compiled if re.search("/test_", path)},
                         {f"{folder}test/core/wire/test_ring{end}" for folder, end in
                          [("", ".c"), ("build/runner/", "_runner.c")]})
        self.assertEqual([path for path in compiled if "controller" in path], [])

    def test_suites_of_several_words_run_together(self):
        last = self.make("test", "-n", "T=test_ring test_link")[1].replace("\\\n", "").splitlines()[-1]
        for name in ["test_ring", "test_link"]:
            self.assertIn(f"build/host/test/{name}", last)

    def test_flash_and_fuses_are_avrdude_lines_with_data_of_board(self):
        flash = self.make("flash", "-n", "BOARD=atmega128")[1]
        self.assertIn("scripts/avrdude.sh 'usb' -p atmega128 -c usbasp  -U "
                      "flash:w:build/atmega128/controller.hex:i", flash)
        self.assertIn("(fuse M103C): make fuses first", flash)
        self.assertIn("efuse:w:0xff:m", self.make("fuses", "-n", "BOARD=atmega128")[1])
        self.assertIn("scripts/avrdude.sh '/dev/ttyUSB7' -p atmega2560 -c wiring -D -U flash:w:",
                      self.make("flash", "-n", "PORT=/dev/ttyUSB7")[1])
        status, output = self.make("fuses")
        self.assertEqual(status, 0, output)
        self.assertIn("right as shipped", output)


if __name__ == "__main__":
    unittest.main()
