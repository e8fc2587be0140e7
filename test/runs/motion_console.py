# SPDX-License-Identifier: MIT
"""What the suites of the group "Motion:" of the console share: boards, lines that store motions, and runs."""
import pathlib
import subprocess
import tempfile
import unittest

import boards

from simulator import ROOT, SIM, controller

# Boards with the commands of this group.
FULL = [name for name in boards.CONSOLES if boards.BOARDS[name].profile == "full"]
MOVING = boards.WITH_MOTION  # the firmware of all of them has the same motions: most tests run on the first one

# A chip with 256 KB of flash, whose firmware names poses and edits steps, and a chip with 128 KB.
TWO_BOARDS = boards.WITH_MOTION_BY_SIZE

# With the factory's return delay, 2 us, a servo may answer before the controller listens, while the PC sends.
SLOWER = "".join(f"write {n} RETURN_DELAY 10\n" for n in (1, 2, 3))
READY = "echo off\n" + SLOWER + "group 1 2 3\ntorque 254 on\n"


def turned(servo, units, ms=300):
    """A hand turns an output whose torque is off."""
    return f"@load {servo} {units}\n@wait {ms}\n@load {servo} 0\n@wait 100\n"


SWING = "pose set stand 150 150 150\npose set low 120 130 140\n"
WALKING = (SWING + "sequence walk new low 0.5s dwell 0.3s\nsequence walk add stand 0.4s\n"
           "sequence walk add low 300ms pass\nsequence walk add stand 0.3s\n")
SWEEP = ("pose set a 60 60 60\npose set b 240 240 240\nsequence sweep new a 2s\nsequence sweep add b 2s\n")
LOW = "@expect servo 1 PRESENT_POSITION 406..412\n@expect servo 2 PRESENT_POSITION 440..446\n"
STAND = "@expect servo 1-3 PRESENT_POSITION 508..515\n"


class Motion(unittest.TestCase):
    def run_on(self, script, board="atmega128", *options):
        run = controller(READY + script, board, "1-3", *options)
        self.assertEqual(run.status, 0, run.output[-3000:])
        return run

    def typed(self, script, keys, board="atmega128", servos="1-3"):
        """What the console says to a program that types `keys`, (line, time behind it in us), after the
        lines of `script`."""
        program = "".join(f"text {line}\nwait 600000\n" for line in script.splitlines())
        program += "rest\n" + "".join(f"{line}\nwait {us}\nrest\n" for line, us in keys)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "pc.txt")
            path.write_text(program)
            done = subprocess.run([SIM, "firmware", ROOT / f"build/{board}/controller.elf", "--board", board,
                                   "--servos", servos, "--host", path],
                                  stdout=subprocess.PIPE, text=True, check=True)
        heard = [bytes.fromhex("".join(line.split()[4:])).decode()
                 for line in done.stdout.splitlines() if line.startswith("heard")]
        return "".join(heard[1:])
