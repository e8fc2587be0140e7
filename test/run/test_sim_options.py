"""The simulator's command line and board files: what is out of range ends with one line and status 2."""
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


class Refusal(unittest.TestCase):
    def assert_refused(self, done, pattern):
        """One line on stderr that matches, nothing on stdout, status 2."""
        self.assertEqual((done.returncode, done.stdout), (2, ""), done)
        self.assertRegex(done.stderr, rf"\A[^\n]*{pattern}[^\n]*\n\Z")


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


if __name__ == "__main__":
    unittest.main()
