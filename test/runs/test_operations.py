# SPDX-License-Identifier: MIT
"""What looks after several servos at once, test/firmware/library/operations.c, on every board."""
# needs: $(BOARDS:%=build/%/firmware/operations.elf)
import unittest

import boards
from program import Program

# Results: 0 ok, 2 timeout, 7 refused, 10 no reply due, 11 limit, 12 held. A servo of a move: 1000 *
# result + 10 * error bits + armed. State: 10 * why it is held + presence (1 here, 2 away).
SAID = """
written 0, packets 3, goal 522, goal 523, goal 524, goal 525, goal 526, goal 527,
limit 0, moved 7, acted 0, servo 0, servo 7020, servo 1000, moved 0, acted 1, servo 0, servo 0, servo 0,
servos 0, mode 0, set 0, fast 11, speed 0, far 11, alone 11, goal 0, whom 1,
delay 0, known 50, level 0, unread 10, ping 0, level 0, read 0, id 5, wrong 7, alarms 8, alarms 0,
absent 2, absent 2, absent 2, away 1,
held 12, let_go 0, driven 0,
moved 11, acted 0, servo 11000, servo 11000, servo 11000, set 0,
level 0, moved 0, acted 1, servo 0, servo 0, servo 0, moved 12, acted 0, servo 0, servo 12000, servo 1000,
level 0,
begun 0, stopped 2, told 3, outcome 1, outcome 1, outcome 1, outcome 1, outcome 1, outcome 1, outcome 3,
held 12, driven 0,
begun 0, state 11, state 1, state 1, state 1, state 1, state 1, state 2,
begun 0, ended 0, found 1, whom 1
"""
AFTER = ["of_servos", "sent", "ok", "timeouts", "bad"]

TORQUE_OFF, TORQUE_ON = "FF FF FE 04 03 18 00 E2", "04 03 18 01"


class Operations(Program):
    program, SAID, AFTER = "operations", SAID, AFTER

    def check_counters(self, board, run):
        sent = [packet for _, way, packet in run.packets if way == "->in"]
        replies = [packet for _, way, packet in run.packets if way == "<-out"]
        broadcasts = sum(packet.startswith("FF FF FE") for packet in sent)
        self.assertEqual(run.after["sent"], len(sent), board)
        self.assertEqual(run.after["sent"], run.after["ok"] + run.after["timeouts"], board)
        self.assertEqual(run.after["bad"], 0, board)
        self.assertEqual(len(replies), run.after["ok"] - broadcasts - self.mute(sent), board)

    @staticmethod
    def mute(sent):
        """Exchanges that end well without an answer, as the servo's status return level says."""
        level, count = {}, 0
        for packet in map(bytes.fromhex, sent):
            servo, instruction = packet[2], packet[4]
            if packet[4:6] == bytes([3, 0x10]):  # it answers by the new one already
                level[servo] = packet[6]
            if instruction not in (1, 2) and level.get(servo, 2) < 2:
                count += 1
        return count

    def check_wire(self, board, run):
        """What was refused was not sent; three broadcasts, and nothing that drives until release."""
        sent = [packet for _, way, packet in run.packets if way == "->in"]
        to_1 = [packet[15:-3] for packet in sent if packet.startswith(("FF FF 01 05 03", "FF FF 01 07 03"))]
        self.assertEqual(to_1, ["20 00 02", "1E BC 02 00 02"], board)
        first, last = sent.index(TORQUE_OFF), len(sent) - sent[::-1].index(TORQUE_OFF)
        self.assertEqual(sent[first:last], [TORQUE_OFF] * 3, board)
        self.assertEqual(sum(packet[9:20] == TORQUE_ON for packet in sent[last:]), 1, board)

    def test_every_operation_on_every_board(self):
        for board in boards.ALL:
            with self.subTest(board):
                run = self.simulate(board)
                self.check_counters(board, run)
                self.check_wire(board, run)


if __name__ == "__main__":
    unittest.main()
