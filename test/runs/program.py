# SPDX-License-Identifier: MIT
"""Test programs that say what became of each call, run on every board. On a board without a host link
a program writes its numbers to the EEPROM."""
import pathlib
import re
import tempfile
import unittest

import boards
from simulator import Run


def expected(said):
    """(name, lowest, highest) of each line, of "name number, name lowest..highest, ..."."""
    for word in said.split(","):
        name, value = word.split()
        lowest, _, highest = value.partition("..")
        yield name, int(lowest), int(highest or lowest)


class Program(unittest.TestCase):
    """`program` of test/firmware/library/ says what stands in `SAID`, and then the numbers named `AFTER`."""
    program, SAID, AFTER = None, "", []

    def simulate(self, board):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            eeprom = folder / "eeprom"
            host = ["--eeprom", eeprom] if board in boards.UNHOSTED else ["--host", "stdout"]
            run = Run(f"build/{board}/firmware/{self.program}.elf", "--seconds", "30", "--state",
                      folder / "state", "--csv", folder / "csv", "--allow-duplicates", *host,
                      board=board, servos="1-6")
            run.said = self.numbers(eeprom) if board in boards.UNHOSTED else run.output
            run.csv = (folder / "csv").read_text().splitlines()
            run.state = {path.stem: self.kept(path) for path in (folder / "state").iterdir()}
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        self.assertIn("ended by the firmware", run.output)
        run.lines = [(name, int(value)) for name, value in
                     re.findall(r"^(\w+) (-?\d+)$", run.said, re.M)]
        run.after = dict(run.lines[-len(self.AFTER):])
        self.check_said(board, run)
        return run

    @staticmethod
    def kept(path):
        """The bytes of a servo's EEPROM."""
        return bytes.fromhex(path.read_text().split("EEPROM ")[1].split(" CRC")[0])

    def numbers(self, eeprom):
        """What was written there, with the names that other boards say."""
        kept = eeprom.read_bytes()
        text = kept.rstrip(b"\xff").decode()
        self.assertLess(len(text), len(kept), "the EEPROM is full")
        names = [name for name, _, _ in expected(self.SAID)] + self.AFTER
        numbers = text.split()
        self.assertEqual(len(numbers), len(names))
        return "".join(f"{name} {number}\n" for name, number in zip(names, numbers))

    def check_said(self, board, run):
        said = run.lines[:-len(self.AFTER)]
        wanted = list(expected(self.SAID))
        self.assertEqual([name for name, _ in said], [name for name, _, _ in wanted], board)
        for number, ((name, value), (_, lowest, highest)) in enumerate(zip(said, wanted)):
            self.assertTrue(lowest <= value <= highest,
                            f"{board}: line {number + 1}: {name} {value}, not {lowest}..{highest}")
        self.assertEqual(list(run.after), self.AFTER)
