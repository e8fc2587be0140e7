# SPDX-License-Identifier: MIT
"""The profiles of the firmware that a board has room for, bridge, console and full, on each board with a host link."""
# needs: $(PROFILE_ELFS)
import pathlib
import re
import sys
import tempfile
import unittest

import boards
from client import BROADCAST, PING, READ, WRITE, packet
from simulator import ROOT, Run

sys.path.append(str(ROOT / "scripts"))
import console  # the rows of the commands

# Commands of the profile `console` in the order of `help`, but for diagnose.
COMMANDS = [usage.split()[0] for _, usage, *_ in console.commands("console")]
TORQUE, INHIBIT, DEVICE = 0x18, 0x17, 253


def hex_of(*fields):
    return packet(*fields).hex(" ").upper()


def status(servo, error=0, *data):
    """A status packet, as the host hears it."""
    return packet(servo, error, data).hex()


class Profiles(unittest.TestCase):
    def run_host(self, board, profile, program):
        """What the simulated PC heard, as one hexadecimal string for each `hear`, and the packets on the bus."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "pc")
            file.write_text("wait 20000\n" + program)
            run = Run(f"build/{board}/{profile}.elf", "--host", file, board=board, servos="1-3")
        self.assertEqual(run.status, 0, run.output)
        heard = [line.split()[4:] for line in run.output.splitlines() if line.startswith("heard")]
        return ["".join(bytes_).lower() for bytes_ in heard], [text for _, way, text in run.packets if way == "->in"]

    def test_bridge_passes_packets_and_stops_at_ctrl_x(self):
        torque_on, release = hex_of(1, WRITE, [TORQUE, 1]), hex_of(DEVICE, WRITE, [INHIBIT, 0])
        program = (f"say {hex_of(1, PING)}\nhear 6\n"
                   f"say {torque_on}\nhear 6\n"
                   "text no console listens\nwait 50000\n"
                   "say 18\nwait 200000\n"
                   f"say {hex_of(1, READ, [TORQUE, 1])}\nhear 7\n"
                   f"say {hex_of(DEVICE, READ, [INHIBIT, 1])}\nhear 7\n"
                   f"say {torque_on}\nwait 50000\n"
                   f"say {release}\nhear 6\n"
                   f"say {torque_on}\nhear 6\n")
        for board in boards.with_profile("bridge"):
            with self.subTest(board):
                heard, sent = self.run_host(board, "bridge", program)
                self.assertEqual(heard[:4], [status(1), status(1), status(1, 0, 0), status(DEVICE, 0, 1)])
                self.assertEqual(heard[-1], status(1))
                self.assertEqual(sent.count(torque_on), 2)
                self.assertEqual(sent.count(hex_of(BROADCAST, WRITE, [TORQUE, 0])), 3)

    def test_console_has_all_commands_but_motion_and_diagnose(self):
        for board in boards.with_profile("console"):
            with self.subTest(board):
                heard, _ = self.run_host(board, "console", "text help\nwait 500000\nrest\n"
                                         "text help diagnose\nwait 50000\nrest\ntext diagnose 1\nwait 50000\nrest\n")
                text = bytes.fromhex("".join(heard)).decode()
                self.assertEqual([name for name in re.findall(r"^  (\w+).*: ", text, re.M) if name != "diagnose"], COMMANDS)
                self.assertIn("diagnose [ID|254]: not in this firmware\r\nok\r\n", text)
                self.assertIn("error 55: ", text)

    def test_full_diagnoses(self):
        for board in boards.with_profile("full"):
            with self.subTest(board):
                heard, _ = self.run_host(board, "full", "text diagnose 1\nwait 500000\nrest\n")
                self.assertIn("finding 1: ", bytes.fromhex("".join(heard)).decode())


if __name__ == "__main__":
    unittest.main()
