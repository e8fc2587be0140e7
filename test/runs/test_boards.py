# SPDX-License-Identifier: MIT
"""The firmware of every board on its own wiring, and three buses at once."""
# needs: $(CONSOLE_ELFS) build/arduino-uno/controller.elf $(TEST_BOARDS:%=build/%/controller.elf)
# needs: $(patsubst %,build/%/firmware/soak.elf,atmega128 arbotix $(TEST_BOARDS)) build/arduino-mega/firmware/three_buses.elf
import os
import pathlib
import re
import subprocess
import shutil
import tempfile
import unittest

import boards
from simulator import ROOT, Run, call, controller
from test_manual import manual_packets

# Adapters: wirings that no board of boards/ has.
ADAPTERS = ["test/boards/adapter", "test/boards/adapter-echo"]
# test_manual.py and test_firmware.py run atmega128 and arduino-mega.
CONSOLES = [name for name in boards.CONSOLES if name not in ("atmega128", "arduino-mega")] + ADAPTERS


class Boards(unittest.TestCase):
    def test_board_of_a_small_chip_has_the_profiles_of_make(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            path.joinpath("board.h").touch()
            for mcu, profiles in (("atmega644p", ["bridge", "console"]), ("atmega1284p", ["bridge", "console", "full"])):
                path.joinpath("board.mk").write_text(f"MCU := {mcu}\n")
                board = boards.read_board(path)
                self.assertEqual((board.profile, board.profiles), (profiles[-1], profiles))

    def test_all_packets_of_the_manual(self):
        for board in CONSOLES:
            run = controller((ROOT / "examples/manual.script").read_text(), board)
            self.assertEqual(run.status, 0, run.output)
            self.assertEqual([packet[1:] for packet in run.packets], manual_packets(), board)

    def test_a_thousand_pings_break_no_rule(self):
        for board in CONSOLES:
            run = controller("".join(f"ping {1 + n % 3}\n" for n in range(1000)), board, "1-3")
            self.assertEqual(run.status, 0, run.output)
            self.assertIn("rules:   none broken", run.output)
            self.assertEqual(len(run.packets), 2000)

    def test_tied_pins_work_without_return_delay(self):
        script = "".join(f"ping {1 + n % 3}\nread {1 + n % 3} 0 50\n" for n in range(300))
        run = controller("write 254 RETURN_DELAY 0\n" + script, "arbotix", "1-3")
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        self.assertEqual(len(run.packets), 1201)

    def test_adapter_works_at_a_return_delay_of_2_us_and_not_at_0(self):
        script = "".join(f"ping {1 + n % 3}\nread {1 + n % 3} 0 50\n" for n in range(300))
        for board in ADAPTERS:
            run = controller("write 254 RETURN_DELAY 1\n" + script, board, "1-3")
            self.assertEqual(run.status, 0, run.output)
            self.assertIn("rules:   none broken", run.output)
            self.assertEqual(len(run.packets), 1201)
            run = controller("write 254 RETURN_DELAY 0\nping 1\n", board, "1-3")
            self.assertIn("BROKEN:  two-drivers, 1 times", run.output)

    def test_the_firmware_of_an_arduino_uno_is_the_readme_program(self):
        run = Run("build/arduino-uno/controller.elf", "--seconds", "2.5", board="arduino-uno",
                  servos="1,2")
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        self.assertEqual([packet for _, _, packet in run.packets],
                         ["FF FF FE 04 03 18 01 E1",
                          "FF FF FE 0E 83 1E 04 01 C8 00 00 02 02 20 03 00 02 5C",
                          "FF FF FE 0E 83 1E 04 01 20 03 00 02 02 C8 00 00 02 5C"])


class NewBoard(unittest.TestCase):
    """Mistakes in the two files of a board of one's own: what the first error says."""

    def header(self, board, chip, pattern="", text="", source="examples/two_servos.c", before=0, stops=True, std="gnu99"):
        """The error of `source` for `board`, where in board.h `text` is put for `pattern`. `before`: how many errors of the
        preprocessor come first. stops: the compiler stops after the error."""
        original = (ROOT / f"boards/{board}/board.h").read_text()
        changed = re.sub(pattern, text, original)
        self.assertTrue(changed != original or not pattern, pattern)
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "board.h").write_text(changed)
            status, output = call(
                "avr-gcc", f"-mmcu={chip}", "-DF_CPU=16000000UL", f"-std={std}", "-Os", "-Wall",
                "-Wextra", "-pedantic", "-x", "c++" if "++" in std else "c", "-Iinclude", "-Isrc/controller", f"-I{folder}", "-c", source, "-o",
                "/dev/null", cwd=ROOT)
        self.assertNotIn("warning: ", output)
        errors = re.findall(r" error: (?:#error )?(.*)", output)
        self.assertEqual(status != 0, bool(errors), output)
        if errors and stops:
            self.assertEqual(len(errors), before + 2, output)
            self.assertIn("the compiler stops here: correct the error above", errors[-1])
            self.assertNotIn(" note: ", output if not before else "")
        return errors[before] if errors else ""

    def test_a_good_header_has_no_error(self):
        for board, chip in [("cm510", "atmega2561"), ("arduino-mega", "atmega2560"),
                            ("arduino-uno", "atmega328p"), ("arbotix", "atmega644p"),
                            ("cm510", "atmega1281"), ("arduino-uno", "atmega168")]:
            for std in ["gnu99", "gnu++11"]:
                self.assertEqual(self.header(board, chip, std=std), "")

    def test_one_error_in_c_and_cpp(self):
        for std in ["gnu99", "gnu++11"]:
            self.assertEqual(self.header("cm510", "atmega2561", r"(HOST_USART +)\d", r"\g<1>0", std=std),
                             "board.h: the host link and a bus have the same USART, 0")

    def test_port_in_quotes_and_value_in_parentheses_are_one_error(self):
        for std in ["gnu99", "gnu++11"]:
            for pattern, value, message in [
                    ("BUS0_RXD_PORT", "'E'", "BOARD_BUS0_RXD is on port 'E' bit 0; use a port of atmega2561"),
                    ("BUS0_RXD_PORT", "(E)", "BOARD_BUS0_RXD_PORT is a register, or between parentheses; write the letter"),
                    ("BUS0_RX_ENABLE_BIT", "(3)", "BOARD_BUS0_RX_ENABLE_BIT is a register, or between parentheses; write a bit from 0 to 7"),
                    ("BUS0_USART", "(0)", "bus 0 has USART (0), but "), ("HOST_USART", "(1)", "the host link has USART (1), but "),
                    ("BUS0_WIRING", "(TIED)", "the wiring of bus 0 is (TIED); use TWO_ENABLES"),
                    ("BUS_COUNT", "(1)", "BOARD_BUS_COUNT is missing or not 1 to 3"),
                    ("CLOCK_TIMER", "(1)", "the clock has timer (1), but ")]:
                self.assertIn(f"board.h: {message}", self.header(
                    "cm510", "atmega2561", rf"({pattern} +)\w+", rf"\g<1>{value}", std=std))

    def test_string_has_errors_of_the_preprocessor_before(self):
        for name, value, before in [("RXD_PORT", '"E"', 3), ("RXD_BIT", "'0'", 2)]:
            self.assertIn("board.h: BOARD_BUS0_RXD is on port ", self.header(
                "cm510", "atmega2561", rf"(BUS0_{name} +)\w", rf"\g<1>{value}", before=before))

    def test_what_is_missing_is_named(self):
        for board, chip, macros in [
                ("cm510", "atmega2561", ["BUS_COUNT", "BUS0_USART"] + [
                    f"BUS0_{pin}_{end}" for pin in ["RXD", "TXD", "TX_ENABLE", "RX_ENABLE"]
                    for end in ["PORT", "BIT"]]),
                ("arduino-uno", "atmega328p", ["BUS0_ENABLE_PORT", "BUS0_ENABLE_BIT",
                                               "CLOCK_TIMER"]),
                ("arduino-mega", "atmega2560", ["BUS1_USART", "BUS1_RX_ENABLE_PORT", "BUS2_USART",
                                                "BUS2_TXD_BIT"]),
                ("arbotix", "atmega644p", ["BUS0_TXD_PORT"])]:
            for macro in macros:
                for line in ["", f"#define BOARD_{macro}\n"]:  # without a value
                    self.assertRegex(self.header(board, chip, rf"#define BOARD_{macro} .*\n", line),
                                     rf'^"?board\.h: BOARD_{macro} is missing\b')

    def test_wiring_and_host_usart_without_a_value_are_named(self):
        for macro in ["BUS0_WIRING", "HOST_USART"]:
            self.assertRegex(self.header("cm510", "atmega2561", rf"(#define BOARD_{macro}) .*\n", r"\1\n"),
                             rf'^"?board\.h: BOARD_{macro} has no value; ')

    def test_count_of_buses_out_of_range_is_named(self):
        for count in ["0", "4", "one", "1x"]:
            self.assertEqual(self.header("cm510", "atmega2561", r"(BUS_COUNT +)1", rf"\g<1>{count}"),
                             '"board.h: BOARD_BUS_COUNT is missing or not 1 to 3"')

    def test_pin_out_of_range_is_named(self):
        for board, chip, pin in [("arduino-uno", "atmega328p", "BUS0_ENABLE"), ("cm510", "atmega2561", "BUS0_RXD"),
                                 ("arduino-mega", "atmega2560", "BUS2_TXD")]:
            port = (ROOT / f"boards/{board}/board.h").read_text().split(f"{pin}_PORT")[1].split()[0]
            for bit in "8", "9", "x", "10":
                self.assertEqual(self.header(board, chip, rf"({pin}_BIT +)\d", rf"\g<1>{bit}"),
                                 f"board.h: BOARD_{pin} is on port {port} bit {bit}; use a port of {chip}, a capital "
                                 "letter, and a bit from 0 to 7")
        self.assertEqual(self.header("arduino-uno", "atmega328p", r"(BUS0_ENABLE_BIT +)\d", r"\g<1>7"), "")

    def test_port_that_the_chip_lacks_is_named(self):
        for pin in ["RXD", "TXD", "TX_ENABLE", "RX_ENABLE"]:
            for port in "e", "I", "H", "'E'":  # atmega1281 has A to G
                self.assertIn(f"board.h: BOARD_BUS0_{pin} is on port {port} bit ", self.header(
                    "cm510", "atmega1281", rf"(BUS0_{pin}_PORT +)\w", rf"\g<1>{port}"))

    def test_pins_of_another_usart_are_named_with_right_ones(self):
        """Pins by data sheet: each USART of each chip. A second list beside usart_pins.h, which is what is tested."""
        first_on_d = ["atmega168", "atmega168p", "atmega328", "atmega328p"]
        two_on_d = ["atmega164p", "atmega324p", "atmega644p", "atmega1284", "atmega1284p"]
        e_and_d = ["atmega64", "atmega128", "at90can64", "at90can128", "atmega1281", "atmega2561"]
        all_four = ["atmega640", "atmega1280", "atmega2560"]
        chips = dict.fromkeys([*first_on_d, "atmega644"], ["D0"]) | dict.fromkeys(two_on_d, ["D0", "D2"]) | \
            dict.fromkeys(e_and_d, ["E0", "D2"]) | dict.fromkeys(all_four, ["E0", "D2", "H0", "J0"])
        listed = re.findall(r"_MCUS := (at.*)", (ROOT / "mk/library.mk").read_text())
        self.assertEqual(sorted(chips), sorted(" ".join(listed[:3]).split()))
        for chip, usarts in chips.items():
            for usart, (port, bit) in enumerate(usarts):
                board = (f"USART {usart}", f"RXD_PORT {port}", f"RXD_BIT {bit}", f"TXD_PORT {port}", f"TXD_BIT {int(bit) + 1}")
                right = "#define BOARD_BUS_COUNT 1\n#define BOARD_BUS0_WIRING TIED\n#define BOARD_CLOCK_TIMER 1\n" + \
                    "".join(f"#define BOARD_BUS0_{line}\n" for line in board)
                self.assertEqual(self.header("arbotix", chip, r"(?s).*", right), "", chip)
                self.assertEqual(
                    self.header("arbotix", chip, r"(?s).*", right.replace("RXD_BIT", "RXD_BIT 5 //")),
                    f"board.h: bus 0 has RXD on port {port} bit 5 and TXD on port {port} bit {int(bit) + 1}; USART {usart} of "
                    f"{chip} has RXD on port {port} bit {bit} and TXD on port {port} bit {int(bit) + 1}")
                self.assertIn(f"has RXD on port {port} bit {bit} and TXD on port C bit ", self.header(
                    "arbotix", chip, r"(?s).*", right.replace("TXD_PORT", "TXD_PORT C //")))

    def test_enable_on_another_pin_of_the_bus_is_named(self):
        for board, chip, enable, key, bit in [
                ("cm510", "atmega2561", "TX_ENABLE", "RXD", 0), ("cm510", "atmega2561", "TX_ENABLE", "TXD", 1),
                ("cm510", "atmega2561", "RX_ENABLE", "RXD", 0), ("cm510", "atmega2561", "RX_ENABLE", "TXD", 1),
                ("arduino-uno", "atmega328p", "ENABLE", "RXD", 0), ("arduino-uno", "atmega328p", "ENABLE", "TXD", 1)]:
            self.assertRegex(
                self.header(board, chip, rf"(BUS0_{enable}_BIT +)\d", rf"\g<1>{bit}"),
                f"board.h: BOARD_BUS0_{enable} is on port [DE] bit {bit}, the pin of BOARD_BUS0_{key}; use another pin")
        self.assertIn("BOARD_BUS0_TX_ENABLE and BOARD_BUS0_RX_ENABLE are both on port E bit 3; use two pins, or the wiring "
                      "ONE_ENABLE", self.header("cm510", "atmega2561", r"(BUS0_TX_ENABLE_BIT +)\d", r"\g<1>3"))

    def move(self, board, chip, pin, port, bit):
        """The error if an enable is on this pin."""
        return self.header(board, chip, rf"({pin}_PORT +)\w(\n.*{pin}_BIT +)\d", rf"\g<1>{port}\g<2>{bit}")

    def test_enable_on_a_pin_of_another_bus_is_named(self):
        for pin, port, bit, owner in [
                ("BUS0_TX_ENABLE", "D", 3, "BUS0_TXD"), ("BUS1_TX_ENABLE", "D", 2, "BUS0_RXD"),
                ("BUS2_RX_ENABLE", "D", 3, "BUS0_TXD"), ("BUS1_RX_ENABLE", "A", 0, "BUS0_TX_ENABLE"),
                ("BUS2_TX_ENABLE", "A", 1, "BUS0_RX_ENABLE"), ("BUS2_RX_ENABLE", "A", 2, "BUS1_TX_ENABLE"),
                ("BUS2_TX_ENABLE", "A", 3, "BUS1_RX_ENABLE")]:
            self.assertEqual(self.move("arduino-mega", "atmega2560", f"BOARD_{pin}", port, bit),
                             f"board.h: BOARD_{pin} is on port {port} bit {bit}, the pin of BOARD_{owner}; use another pin")
        for later in "12":  # the pins of USART1 are those of a bus that comes later
            for bit, key in (2, "RXD"), (3, "TXD"):
                text = (ROOT / "boards/arduino-mega/board.h").read_text()
                text = re.sub(rf"BUS([0{later}])(?=_)", lambda match: "BUS" + ("0" if match[1] != "0" else later), text)
                text = re.sub(r"(BUS0_RX_ENABLE_PORT +)A(\n.*BUS0_RX_ENABLE_BIT +)\d", rf"\g<1>D\g<2>{bit}", text)
                self.assertEqual(self.header("arduino-mega", "atmega2560", r"(?s)\A.+", text),
                                 f"board.h: BOARD_BUS0_RX_ENABLE is on port D bit {bit}, the pin of BOARD_BUS{later}_{key}; use "
                                 "another pin")
                text = text.replace("COUNT 3", f"COUNT {later}")  # leaves out the later bus
                self.assertEqual(self.header("arduino-mega", "atmega2560", r"(?s)\A.+", text), "")
        # A left out bus, and an enable that the wiring lacks, are ignored.
        self.assertEqual(self.header("arduino-mega", "atmega2560", r"(?s)COUNT 3(.*BUS0_TX_ENABLE_BIT +)0",
                                     r"COUNT 1\g<1>2"), "")
        self.assertEqual(self.header("arduino-mega", "atmega2560", r"(?s)(COUNT 3\n)(.*BUS1_TX_ENABLE_BIT +)2",
                                     r"\1#define BOARD_BUS0_WIRING ADAPTER\n\g<2>0"), "")

    def test_enable_of_a_later_bus_on_one_enable_is_named(self):
        for bus in 0, 1:
            self.assertIn(f"is on port C bit 2, the pin of BOARD_BUS{bus}_ENABLE; use another pin", self.header(
                "arduino-mega", "atmega2560", r"(?s)(COUNT 3\n)(.*BUS2_TX_ENABLE_PORT) A(.*BUS2_TX_ENABLE_BIT +)4",
                rf"\1#define BOARD_BUS{bus}_WIRING ONE_ENABLE\n#define BOARD_BUS{bus}_ENABLE_PORT C\n"
                rf"#define BOARD_BUS{bus}_ENABLE_BIT 2\n\2 C\g<3>2"))

    def test_enable_on_a_pin_of_the_host_link_is_named(self):
        for board, chip, port, bits in [("cm510", "atmega2561", "D", "23"), ("arduino-mega", "atmega2560", "E", "01"),
                                        ("atmega1284p", "atmega1284p", "D", "01")]:
            for bit, owner in zip(bits, ["RXD", "TXD"]):
                for enable in ["TX_ENABLE", "RX_ENABLE"]:
                    pin = f"BOARD_BUS0_{enable}"
                    self.assertEqual(self.move(board, chip, pin, port, bit),
                                     f"board.h: {pin} is on port {port} bit {bit}, the pin of {owner} of the host link; use "
                                     "another pin")

    def test_enable_on_a_port_out_of_reach_of_sbi_is_named(self):
        """Ports at 0x40 and above, by data sheet."""
        high = dict.fromkeys(["atmega64", "atmega128"], "FG") | dict.fromkeys(["atmega640", "atmega1280", "atmega2560"], "HJKL")
        for chip, low in [("atmega128", "ABCE"), ("atmega64", "ABCE"), ("atmega2561", "ABCFG"), ("at90can128", "ABCFG"),
                          ("atmega1284p", "ABC"), ("atmega2560", "ABCFG"), ("atmega640", "C"), ("atmega1280", "C")]:
            for port in low + high.get(chip, ""):
                error = self.move("atmega128", chip, "BOARD_BUS0_TX_ENABLE", port, 4)
                self.assertEqual(error, "" if port in low else f"board.h: BOARD_BUS0_TX_ENABLE is on port {port} bit 4; use a "
                                 "port whose registers lie below 0x40, as A to E")

    def test_usart_with_two_uses_is_named(self):
        self.assertIn("the host link and a bus have the same USART, 0", self.header(
            "cm510", "atmega2561", r"(HOST_USART +)\d", r"\g<1>0"))
        for usart in "123":
            self.assertIn("the host link and a bus have the same USART, ", self.header(
                "arduino-mega", "atmega2560", r"(HOST_USART +)\d", rf"\g<1>{usart}"))
        self.assertIn("two buses have the same USART", self.header("arduino-mega", "atmega2560", (
            r"(?s)BUS1_USART.*BUS1_TX_ENABLE_PORT"), "BUS1_USART 1\n#define BOARD_BUS1_RXD_PORT D\n"
            "#define BOARD_BUS1_RXD_BIT 2\n#define BOARD_BUS1_TXD_PORT D\n#define BOARD_BUS1_TXD_BIT 3\n"
            "#define BOARD_BUS1_TX_ENABLE_PORT"))

    def test_what_a_chip_lacks_is_named(self):
        self.assertIn("this chip is not supported: registers of its USART have no digit",
                      self.header("arduino-uno", "atmega32"))
        self.assertEqual("board.h: bus 0 has USART 2, but atmega2561 has no USART of this number; is this the board.h of "
                         "another chip?", self.header("cm510", "atmega2561", r"(BUS0_USART +)0", r"\g<1>2"))
        self.assertIn("board.h: the host link has USART 2, but atmega2561 has no USART of this number",
                      self.header("cm510", "atmega2561", r"(HOST_USART +)1", r"\g<1>2"))
        self.assertEqual("board.h: the wiring of bus 0 is THREE_ENABLES; use TWO_ENABLES, ONE_ENABLE, TIED, ADAPTER or "
                         "ADAPTER_ECHO", self.header("cm510", "atmega2561", "TWO_ENABLES", "THREE_ENABLES"))
        for board, timer, chip, has in [
                ("arduino-uno", 2, "atmega168p", "1"), ("arduino-uno", 0, "atmega328p", "1"), ("arduino-uno", 3, "atmega328p", "1"),
                ("arduino-uno", 2, "atmega1284p", "1 or 3"), ("cm510", 2, "atmega2561", "1, 3, 4 or 5"),
                ("atmega128", 2, "atmega128", "1")]:
            message = self.header(board, chip, "TIMER 1", f"TIMER {timer}")
            self.assertEqual(message, f"board.h: the clock has timer {timer}, but {chip} has no 16-bit timer of this number; use {has}")
        self.assertIn("the clock has timer 3; on atmega128 use 1", self.header("atmega128", "atmega128", "TIMER 1", "TIMER 3"))
        self.assertEqual(self.header("cm510", "atmega2561", "TIMER 1", "TIMER 3"), "")

    def test_a_console_without_a_host_link_is_named(self):
        self.assertIn("the console wants BOARD_HOST_USART and _BAUD in board.h; or name a FIRMWARE",
                      self.header("arduino-uno", "atmega328p", source="src/controller/avr/serial.c", stops=False))


class Transactions(unittest.TestCase):
    """What soak.c says on each wiring."""
    WIRINGS = ["atmega128", "arbotix", "test/boards/adapter", "test/boards/adapter-echo"]
    ECHOES = {"arbotix", "test/boards/adapter-echo"}

    def figures(self, board, *options):
        run = Run(f"build/{board.rsplit('/', 1)[-1]}/firmware/soak.elf", "--host", "stdout",
                  "--seconds", "5", *options, board=board, servos="1-3")
        self.assertEqual(run.status, 0, run.output)
        return {name: int(number) for name, number in
                re.findall(r"^(\w+) (\d+)$", run.output, re.M)}

    def test_a_thousand_transactions_go_well_on_every_wiring(self):
        for board in self.WIRINGS:
            figure = self.figures(board)
            self.assertEqual(figure["good"], 200, board)
            self.assertEqual(figure["txd_output"], board != "arbotix", board)
            self.assertEqual(figure["sent"], 801, board)
            self.assertEqual(figure["ok"], 801, board)
            for name in ["timeouts", "corrupt", "refuted", "foreign", "framing_errors", "overruns",
                         "echo_errors"]:
                self.assertEqual(figure[name], 0, (board, name))

    def test_each_own_byte_that_comes_back_changed_is_counted(self):
        for board in self.WIRINGS:
            figure = self.figures(board, "--fault", "flip in every 4 3")
            self.assertEqual(figure["echo_errors"], figure["sent"] if board in self.ECHOES else 0,
                             board)

    def test_nothing_is_sent_into_a_line_that_babbles(self):
        for board in self.WIRINGS:
            figure = self.figures(board, "--fault", "babble 0x55")
            self.assertEqual((figure["sent"], figure["unsent"]), (0, 801), board)


class SeveralBuses(unittest.TestCase):
    """Two and three buses at once, a servo on each: test/firmware/library/three_buses.c."""

    def simulate(self, return_delay, length, buses, *options):
        """What the program says of each bus; delay in register units, READs of so many bytes."""
        with tempfile.NamedTemporaryFile() as eeprom:
            eeprom.write(bytes([return_delay, length, buses]) + b"\xff" * 4093)
            eeprom.flush()
            run = Run("build/arduino-mega/firmware/three_buses.elf", "--servos", "1:2", "--servos",
                      "2:3", "--eeprom", eeprom.name, "--host", "stdout", "--seconds", "3", *options,
                      board="arduino-mega")
        said = re.split(r"^bus \d$", run.output.split("\ntime:")[0], flags=re.M)[1:]
        self.assertEqual(len(said), buses, run.output)
        run.buses = [{name: int(n) for name, n in re.findall(r"^(\w+) (\d+)$", text, re.M)}
                     for text in said]
        for bus in run.buses:
            self.assert_reconciled(bus)
        return run

    def assert_reconciled(self, bus):
        self.assertEqual(bus["sent"] + bus["unsent"], bus["reads"])
        self.assertEqual(bus["sent"], bus["ok"] + bus["timeouts"] + bus["corrupt"])
        self.assertEqual(bus["ok"], bus["good"] + bus["refused"])
        self.assertEqual(bus["foreign"], 0)

    def assert_well(self, bus):
        self.assertEqual(bus["ok"], bus["sent"])
        for name in ("refused", "timeouts", "corrupt", "refuted", "framing", "overruns", "overflows"):
            self.assertEqual(bus[name], 0, name)

    def assert_undisturbed(self, run, number):
        """Nothing failed, and it counts what its wire saw; a WRITE to all came before."""
        bus = run.buses[number]
        self.assert_well(bus)
        seen = re.findall(rf"^ *\d+ bus{number} (->in|<-out): FF FF (\S\S) [^(]*\(LEN:\d+\)$",
                          run.transcript, re.M)
        self.assertEqual(seen.count(("->in", "FE")), 1)
        sent = [(way, who) for way, who in seen if way == "->in" and who != "FE"]
        replies = [(way, who) for way, who in seen if way == "<-out"]
        self.assertEqual(set(sent + replies), {("->in", f"{number + 1:02}"),
                                               ("<-out", f"{number + 1:02}")})
        self.assertEqual(len(sent), bus["sent"])
        self.assertEqual(len(replies), bus["ok"])

    def test_short_reads_at_a_return_delay_of_10_us_lose_nothing(self):
        """160 cycles: two handlers of the other buses may come before the one that turns around."""
        for buses in [2, 3]:
            for length in [1, 2, 11]:
                run = self.simulate(5, length, buses)
                self.assertEqual(run.status, 0, run.output)
                for number, bus in enumerate(run.buses):
                    self.assert_undisturbed(run, number)
                    self.assertGreater(bus["ok"], 700)

    def test_long_reads_may_lose_bytes_and_never_unnoticed(self):
        """Three whole tables at once ask for more receive handlers than there are cycles."""
        for delay in [1, 50]:
            self.simulate(delay, 40, 3)

    def test_two_buses_go_on_undisturbed_while_the_third_is_dead(self):
        # At the factory's return delay the handlers of one bus may hold up the turnaround of another.
        clean = self.simulate(5, 2, 3)
        for fault in ["1:stuck low", "1:stuck high", "1:brownout 2 5000"]:
            run = self.simulate(5, 2, 3, "--fault", fault)
            self.assertEqual(run.status, 0, run.output)
            for number in (0, 2):
                bus, before = run.buses[number], clean.buses[number]
                self.assert_undisturbed(run, number)
                self.assertGreater(bus["ok"], before["ok"], fault)  # nobody else's work to do
                self.assertLess(bus["longest_us"], before["longest_us"] + 200, fault)
            self.assertEqual(run.buses[1]["ok"], 0, fault)
            self.assertGreater(run.buses[1]["reads"], 100, fault)

    def test_two_buses_go_on_undisturbed_while_the_third_babbles(self):
        for what in ["0x55", "headers", "random"]:
            run = self.simulate(5, 2, 3, "--fault", f"1:babble {what}")
            self.assertEqual(run.status, 0, run.output)
            for number in (0, 2):
                self.assert_undisturbed(run, number)
                self.assertGreater(run.buses[number]["ok"], 500, what)
            self.assertEqual((run.buses[1]["sent"], run.buses[1]["ok"]), (0, 0), what)

    def test_port_of_the_enables_changes_with_interrupts_off(self):
        """All six are on PORTA: read, changed and written back it would lose what a handler did."""
        code = subprocess.check_output(
            ["avr-objdump", "-d", ROOT / "build/arduino-mega/firmware/three_buses.elf"], text=True)
        lines = [line.split("\t")[2:] for line in code.splitlines() if line.count("\t") >= 2]
        written = [at for at, words in enumerate(lines) if words[0].strip() == "out"
                   and words[1].startswith("0x02,")]
        self.assertGreater(len(written), 3)
        for at in written:
            before = [words[0].strip() for words in lines[at - 6:at]]
            self.assertIn("cli", before, lines[at - 6:at + 1])
            self.assertNotIn("sts", before[before.index("cli"):])  # of SREG, or to elsewhere

    def test_a_bus_that_flips_bits_fails_alone(self):
        run = self.simulate(25, 2, 3, "--fault", "1:noise 500")
        self.assertEqual(run.status, 0, run.output)
        for number in (0, 2):
            self.assert_well(run.buses[number])
        noisy = run.buses[1]
        self.assertGreater(noisy["timeouts"] + noisy["corrupt"], 50)
        self.assertGreater(noisy["ok"], 200)


if __name__ == "__main__":
    unittest.main()
