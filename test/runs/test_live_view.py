# SPDX-License-Identifier: MIT
"""The live table of the servos (--follow) on a terminal, beside other output."""
# needs: build/atmega128/controller.elf
import fcntl
import os
import pathlib
import pty
import re
import struct
import subprocess
import tempfile
import termios
import unittest

from simulator import PATIENCE_S, SIM, Process

ROWS, COLUMNS = 60, 100


def screen(data):
    """The lines that a terminal shows which has received these bytes."""
    lines, row, column = [[]], 0, 0
    for move, control, char in re.findall(r"\x1b\[(\d*)([ABJK])|(.)", data, re.S):
        steps = int(move or 1)
        if control in "AB" and control:
            row = max(0, row - steps) if control == "A" else row + steps
        elif control:
            del lines[row][column:]
            del lines[row + 1 if control == "J" else len(lines):]
        elif char == "\n":
            row += 1
        elif char == "\r":
            column = 0
        else:
            line = lines[row]
            line.extend(" " * (column - len(line)))
            line[column:column + 1] = char
            column += 1
        lines.extend([] for _ in range(row + 1 - len(lines)))
    return ["".join(line).rstrip() for line in lines]


class Terminal(unittest.TestCase):
    def run_on_terminal(self, *command):
        """What a terminal shows after the command has ended on it."""
        master, slave = pty.openpty()
        self.addCleanup(os.close, master)
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", ROWS, COLUMNS, 0, 0))
        process = subprocess.Popen([SIM, *map(str, command)], stdin=slave, stdout=slave, stderr=slave)
        os.close(slave)
        data = b""
        try:
            while block := os.read(master, 4096):
                data += block
        except OSError:  # the other end is closed
            pass
        self.assertEqual(process.wait(PATIENCE_S), 0, data)
        return data.decode()

    def follow(self, script):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "script"
            path.write_text(script)
            return screen(self.run_on_terminal("bus", "--servos", "1-2", "--follow", "--script", path))

    def test_header_has_units(self):
        lines = self.follow("@supply 1 7.4\n@wait 5\n")
        at = lines.index("bus  ID   goal present speed load supply temp  torque LED  errors")
        self.assertEqual(lines[at + 1], "           deg     deg   RPM    %      V    C")
        self.assertEqual(lines[at + 2], "  0   1  150.1   150.1   0.0    0    7.4   32  off")

    def test_printed_lines_stand_above_the_table(self):
        lines = self.follow("@wait 5\n" + "@print hey\n" * 3 + "@wait 5\n")
        at = lines.index("hey")
        self.assertEqual(lines[at:at + 4], ["hey", "hey", "hey", "0.01 s"])
        self.assertEqual(sum("errors" in line for line in lines), 1)

    def test_poke_on_the_terminal_of_the_table_erases_it_first(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "poke"
            with Process("bus", "--servos", "1", "--pty", "--poke", path):
                answer = self.run_on_terminal("poke", path, "load 1")
        below = "12.34 s\n\rbus  ID\n\r  0   1\r\x1b[2A"
        self.assertEqual(screen(below + answer), ["all servos: load 1", "ok", ""])


if __name__ == "__main__":
    unittest.main()
