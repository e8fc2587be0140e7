# SPDX-License-Identifier: MIT
"""The simulator's command line and board files: what is out of range ends with one line and status 2."""
# needs: build/atmega128/controller.elf
import pathlib
import re
import subprocess
import tempfile
import unittest

from simulator import ROOT, SIM

ELF = ROOT / "build/atmega128/controller.elf"


def simulate(*options):
    """.returncode, .stdout and .stderr of a run."""
    return subprocess.run([SIM, *options], capture_output=True, text=True, timeout=60, cwd=ROOT,
                          stdin=subprocess.DEVNULL)


class Version(unittest.TestCase):
    def test_version_is_that_of_the_tree(self):
        version = subprocess.run([ROOT / "scripts/version.py"], stdout=subprocess.PIPE, text=True).stdout
        self.assertEqual(simulate("--version").stdout, f"cds55xx-sim {version}")


class Refusal(unittest.TestCase):
    def assert_refused(self, done, pattern):
        """One line on stderr that matches, nothing on stdout, status 2."""
        self.assertEqual((done.returncode, done.stdout), (2, ""), done)
        self.assertRegex(done.stderr, rf"\A[^\n]*({pattern})[^\n]*\n\Z")


class Boards(Refusal):
    """A board.h with one other value: the board, the chip and the message all end the run at once."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "board.mk").write_text((ROOT / "boards/atmega128/board.mk").read_text())
        self.wiring = (ROOT / "boards/atmega128/board.h").read_text()

    def run_with(self, key, value):
        text, count = re.subn(rf"(#define {key} +)\S+", rf"\g<1>{value}", self.wiring)
        self.assertEqual(count, 1)
        (self.folder / "board.h").write_text(text)
        return simulate("firmware", ELF, "--board", self.folder, "--seconds", "0.01",
                        "--rules", "warn")

    def test_bus_count_out_of_range_is_refused(self):
        for count in ["0", "4", "200", "4294967295", "4294967296"]:
            self.assert_refused(self.run_with("BOARD_BUS_COUNT", count),
                                rf'BOARD_BUS_COUNT: "{count}" is not valid: use .* from 1 to 3')

    def test_usart_out_of_range_is_refused(self):
        for key in ["BOARD_BUS0_USART", "BOARD_HOST_USART"]:
            for usart in ["4", "31", "32", "64", "4294967295", "99999999999999999999"]:
                self.assert_refused(self.run_with(key, usart),
                                    rf'{key}: "{usart}" is not valid: use .* from 0 to 3')

    def test_usart_that_the_chip_lacks_is_refused(self):
        self.assert_refused(self.run_with("BOARD_BUS0_USART", "2"),
                            "atmega128: no USART2: change BOARD_BUSn_USART in board.h")
        self.assert_refused(self.run_with("BOARD_HOST_USART", "3"),
                            "atmega128: no USART3: change BOARD_HOST_USART in board.h")

    def test_pin_that_the_chip_lacks_is_refused(self):
        for key in ["TXD", "RXD", "TX_ENABLE", "RX_ENABLE"]:
            self.assert_refused(self.run_with(f"BOARD_BUS0_{key}_PORT", "L"),
                                r"atmega128: no pin PL\d: change the pin in board.h")

    def test_every_number_with_odd_values_never_crashes(self):
        for key in re.findall(r"#define (BOARD_\w+) +\d", self.wiring):
            for value in ["0", "3", "7", "8", "255", "2000001", "4294967297", "-1", "x"]:
                done = self.run_with(key, value)
                self.assertIn(done.returncode, [0, 1, 2], (key, value, done))


class Numbers(Refusal):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.times = pathlib.Path(folder.name) / "times"

    def firmware(self, *options):
        return simulate("firmware", ELF, "--board", "atmega128", "--seconds", "0.001", *options)

    def test_panes_that_the_plot_lacks_are_refused(self):
        for value in ["", "speeds", "position", "speed,", ",load", "speed load"]:
            self.assert_refused(self.firmware("--plot", "/dev/null", "--panes", value), "--panes is speed, load")
        self.assert_refused(self.firmware("--panes", "speed"), "--panes is for --plot")

    def test_steps_that_are_no_range_are_refused(self):
        for span in ["99999999999999999999-0", "0-99999999999999999999", "18446744073709551616-5",
                     "2000-1000", "5-5", "-5-10", "5--10", "5-+10", " 5-10", "5- 10", "5-10 ",
                     "5", "5-", "-5", "", "0x5-9", "1e3-2e3", "5-10-15"]:
            self.assert_refused(self.firmware("--times", self.times, "--steps", span),
                                f"--steps {re.escape(span)}: .*1000-2000")

    def test_steps_in_order_are_accepted(self):
        for span in ["0-1", "1000-2000", "0-18446744073709551615"]:
            done = self.firmware("--times", self.times, "--steps", span)
            self.assertEqual(done.returncode, 0, done)
        self.assertIn("step 0 0", self.times.read_text())

    def test_numbers_out_of_range_are_refused(self):
        huge = "99999999999999999999"
        for option, values in {
                "--seconds": ["0", "-1", "nan", "inf", "1e7", "1e999", "1e-9", "1e-999", huge, "", " 1", "1s",
                              "0x10"],
                "--seed": ["-1", "4294967296", huge, "", " 1", "+1", "0x1", "1.5"],
                "--gdb": ["-1", "65536", huge, "", " 1", "+1", "0x1"],
                "--servos": ["254", huge, f"1-{huge}", "5-1", "-1", "", "3:1", "1-", f"{huge}:1"],
                "--mark": ["B8", "M0", "B", "B00", "", "B-1"],
                "--stamp": ["M", "", "BB"]}.items():
            for value in values:
                self.assert_refused(self.firmware("--times", self.times, option, value),
                                    "IDs|buses" if option == "--servos" else option)

    def test_fault_numbers_out_of_range_are_refused(self):
        huge = "99999999999999999999"
        for order in [f"flip out {huge} 1 1", "flip out 0 1 1", "flip out 1 259 1",
                      f"turnaround 1 {huge}", "turnaround 5-1 10", f"brownout 1-{huge} 10",
                      f"noise {huge}", "noise -1"]:
            self.assert_refused(self.firmware("--fault", order), "--fault")


class Summary(unittest.TestCase):
    """What the summary says of small firmwares that fail."""
    SCRIPT = "@expect servo 1 torque on within 100\n"
    SENDS = "static const uint8_t ping[] = {0xFF, 0xFF, 2, 2, 1, 0xFA}; for (;;) { bus_send(ping, 6); %s }"

    def run_main(self, body, script=SCRIPT, option="--script"):
        """The output of a firmware with this main(), which has servo 1, and fails. Without a script it runs for 0.1 s."""
        with tempfile.TemporaryDirectory() as folder:
            source, elf, lines = (pathlib.Path(folder) / name for name in ["main.c", "main.elf", "lines.txt"])
            source.write_text('#include "chip.h"\n#include <util/delay.h>\nint main(void) { %s for (;;); }' % body)
            lines.write_text(script)
            subprocess.run(["avr-gcc", "-std=gnu99", "-Os", "-mmcu=atmega128", "-DF_CPU=16000000UL",
                            f"-I{ROOT}/test/firmware/registers", source, "-o", elf], check=True)
            done = simulate("firmware", elf, "--board", "atmega128", "--servos", "1", option, lines if script else "0.1")
        self.assertEqual(done.returncode, 1 if script else 0, done)
        return done.stdout

    def hints(self, *arguments):
        return re.findall("^hint: +(.*)$", self.run_main(*arguments), re.M)

    def test_firmware_without_sei(self):
        self.assertEqual(self.hints(""), ["the firmware never turned interrupts on: sei()", "bus 0: the firmware sent no packet"])

    def test_firmware_without_a_packet(self):
        self.assertEqual(self.hints("sei();"), ["bus 0: the firmware sent no packet"])

    def test_firmware_with_a_slow_main_loop(self):
        self.assertEqual(self.hints("sei();" + self.SENDS % "_delay_ms(3);"), [])
        self.assertRegex(self.hints("sei();" + self.SENDS % "_delay_ms(20);")[0], r"^bus 0: up to 20\.\d ms between two packets")

    def test_program_that_asks_for_a_servo_that_is_not_there(self):
        for times, hints in [(19, 0), (20, 1)]:
            body = self.SENDS.replace("for (;;) {", f"for (int i = 0; i < {times}; i++) {{") % "_delay_ms(1);"
            summary = self.run_main("sei();" + body, "", "--seconds")
            self.assertEqual(summary.count("hint:    the firmware asks for servos that are not there: 2; add them to SERVOS="), hints, summary)

    def test_expected_text_that_never_comes(self):
        self.assertIn("not met; seen: no line of text\n", self.run_main("", "@expect text ready within 10\n"))

    def test_address_that_the_chip_lacks_is_no_jump(self):
        summary = self.run_main("(void)*(volatile uint8_t *)0xF000;")
        self.assertIn("bad-address, 1 times: the firmware used an address beyond the RAM", summary)
        self.assertNotIn("no code", summary)
        self.assertNotIn("hint", summary)

    def test_bytes_of_the_pc_that_are_not_read(self):
        summary = self.run_main("UCSR0A = 1 << U2X0; UBRR0L = 16; UCSR0B = 1 << RXEN0;", "text hello\nhear 1\n", "--host")
        self.assertIn("host:    3 bytes of the PC lost (overrun)", summary)  # of 6


if __name__ == "__main__":
    unittest.main()
