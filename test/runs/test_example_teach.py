# SPDX-License-Identifier: MIT
"""examples/teach: what hands teach is what the robot plays, and nothing drives a servo before that."""
# needs: $(filter %/teach.elf,$(EXAMPLES))
import functools
import itertools
import unittest

import boards
from simulator import LONG, ROOT, Run

SERVOS = 3
LED_ON, TORQUE_OFF = "FF FF FE 04 03 19 01 E0", "FF FF FE 04 03 18 00 E2"
READ_POSITION = "04 02 24 02"
GOALS = "FF FF FE 13 83 1E 04"
DWELL = 100  # periods of 4 ms; the poses rest for 125, and the last steps of a curve may have the same goals
LARGE_BOARDS = [board for board in boards.ALL if board != "arduino-uno"]  # 32 KB of flash are too few
SCRIPT = (ROOT / "examples/teach/teach.script").read_text()


def drives(packet):
    """A packet that sets a goal or switches torque on."""
    return packet[12:14] == "83" or packet[12:20] == "03 18 01" or packet[12:17] == "03 1E"


def word(packet, index):
    data = bytes.fromhex(packet)
    return data[index] + 256 * data[index + 1]


@functools.cache
def simulate(script, board, servos):
    return Run(f"build/{board}/examples/teach.elf", board=board, servos=servos, script=script)


class Teach(unittest.TestCase):
    def runs(self, script, board="arduino-mega", servos=f"1-{SERVOS}"):
        run = simulate(script, board, servos)
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        run.sent = [packet for _, way, packet in run.packets if way == "->in"]
        return run

    def learnt(self, run):
        """The poses by the wire: the position that each servo has sent last when the LEDs light up."""
        poses, places, asked = [], {}, None
        for _, way, packet in run.packets:
            if way == "->in":
                asked = int(packet[6:8], 16) if packet[9:20] == READ_POSITION else None
                if packet == LED_ON:
                    poses.append([places[servo] for servo in range(1, SERVOS + 1)])
            elif asked and len(packet) == len("FF FF 01 04 00 00 02 F8"):  # the end may cut the last one
                places[asked] = word(packet, 5)
        return poses

    def rests(self, run):
        """The goals that stay the same for the time of a dwell, in their order."""
        goals = [[word(packet, 8 + 5 * servo) for servo in range(SERVOS)]
                 for packet in run.sent if packet.startswith(GOALS) and len(packet.split()) == 0x13 + 4]
        return [goal for goal, group in itertools.groupby(goals) if len(list(group)) >= DWELL]

    def test_robot_plays_the_poses_that_hands_have_taught(self):
        for board in LARGE_BOARDS if LONG else ["arduino-mega", "arbotix"]:
            with self.subTest(board):
                run = self.runs(SCRIPT, board)
                learnt, rests = self.learnt(run), self.rests(run)
                self.assertEqual(len(learnt), 3)
                self.assertGreaterEqual(len(rests), 4)
                self.assertEqual(rests, (2 * learnt)[:len(rests)])

    def test_nothing_drives_a_servo_before_the_last_pose(self):
        run = self.runs(SCRIPT)
        self.assertEqual(run.sent[:3], [TORQUE_OFF] * 3)
        last = [at for at, packet in enumerate(run.sent) if packet == LED_ON][2]
        self.assertFalse([packet for packet in run.sent[:last] if drives(packet)])
        self.assertTrue([packet for packet in run.sent[last:] if drives(packet)])

    def test_nothing_drives_a_servo_after_a_joint_is_blocked(self):
        run = self.runs(SCRIPT)
        off = max(at for at, packet in enumerate(run.sent) if packet == TORQUE_OFF)
        self.assertGreater(off, 1000)
        behind = run.sent[off:]
        self.assertFalse([packet for packet in behind if drives(packet)])
        self.assertTrue([packet for packet in behind if packet[9:20] == READ_POSITION])  # it learns anew

    def test_pose_that_is_not_turned_is_not_learnt_again(self):
        run = self.runs("@at 1200\n@load 1 200\n@wait 300\n@load 1 0\n@wait 6000\n")
        self.assertEqual(len(self.learnt(run)), 1)

    def test_pose_beyond_the_limits_is_not_learnt(self):
        """90 degrees from the middle are 307 steps."""
        run = self.runs("@at 1200\n@load 1 300\n@wait 1500\n@load 1 0\n@expect servo 1 PRESENT_POSITION 0..200\n"
                        "@wait 3000\n")
        self.assertEqual(self.learnt(run), [])

    def test_robot_without_a_servo_never_moves(self):
        run = self.runs("@at 1200\n@load 1-2 200\n@wait 300\n@load 1-2 0\n@wait 5000\n", servos="1,2")
        self.assertEqual(run.sent.count(LED_ON), 0)
        self.assertFalse([packet for packet in run.sent if drives(packet)])


if __name__ == "__main__":
    unittest.main()
