# SPDX-License-Identifier: MIT
"""Groups on the simulated wire: test/firmware/library/groups.c, as it is, and with what can happen to it."""
# needs: build/atmega128/firmware/groups.elf
import csv
import pathlib
import re
import tempfile
import unittest

from simulator import Run

OK, PENDING, TIMEOUT, REFUSED = 0, 1, 2, 7
NO, IN_DOUBT = 0, 2
ANGLE = 0x02
REST = 2  # positions that a servo at rest may be off its goal: compliance margin
BYTE_TIME = 160  # cycles
CYCLES_MS = 16000
REGISTERED = "07 04 1E BC 02 84 03"  # LENGTH, REG WRITE, GOAL_POSITION, 700, 900: of the second move
ACTION = "FF FF FE 02 05 FA"


def said(output):
    """[{name: number, ...}, ...] of each operation; "servos" of a move: {ID: (result, error, armed)}."""
    operations, servo = [], None
    for name, number in re.findall(r"^(\w+) (\d+)$", output, re.M):
        if name in ("write_result", "read_result", "move_result"):
            operations.append({"servos": {}})
        if name == "servo":
            servo = operations[-1]["servos"].setdefault(int(number), [])
        elif name.startswith("servo_"):
            servo.append(int(number))
        else:
            operations[-1][name] = int(number)
    return operations


class Groups(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.clean = Run("build/atmega128/firmware/groups.elf", "--host", "stdout", "--seconds", "5",
                        servos="1-60")

    def run_with(self, *options):
        """As setUpClass, with more; (operations, positions of each servo every 4 ms)."""
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder) / "motion.csv"
            run = Run("build/atmega128/firmware/groups.elf", "--host", "stdout", "--seconds", "5",
                      "--csv", table, *options, servos="1-60")
            self.assertEqual(run.status, 0, run.output)
            with table.open() as lines:
                rows = list(csv.DictReader(lines))
        self.assertIn("rules:   none broken", run.output)
        self.packets = [(cycle, packet) for cycle, way, packet in run.packets if way == "->in"]
        self.replies = [packet for _, way, packet in run.packets if way == "<-out"]
        return said(run.output), rows

    def starts(self, rows, after_cycle):
        """{ID: time in ms when it first is further from where it was at that cycle than it is at rest}"""
        before = [row for row in rows if float(row["time_ms"]) * CYCLES_MS <= after_cycle][-1]
        found = {}
        for row in rows:
            for servo in range(1, 61):
                if (float(row["time_ms"]) > float(before["time_ms"]) and servo not in found
                        and abs(int(row[f"present_{servo}"]) - int(before[f"present_{servo}"])) > REST):
                    found[servo] = float(row["time_ms"])
        return found

    def number_of(self, way, pattern):
        """The number, from 1, of the first packet of the clean run in that direction that matches."""
        packets = [packet for _, direction, packet in self.clean.packets if direction == way]
        return next(n for n, packet in enumerate(packets, 1) if re.match(pattern, packet))

    def last_reply_before(self, pattern):
        """The number of the last reply before the first packet to the servos that matches."""
        replies = 0
        for _, way, packet in self.clean.packets:
            if way == "->in" and re.match(pattern, packet):
                return replies
            replies += way == "<-out"
        raise AssertionError(pattern)

    def test_60_servos_are_two_packets_and_18_with_64_bytes_too(self):
        operations, _ = self.run_with()
        writes = [op for op in operations if "write_result" in op]
        self.assertEqual([(op["write_result"], op["write_packets"]) for op in writes], [(OK, 2)] * 2)
        syncs = [(cycle, bytes.fromhex(packet)) for cycle, packet in self.packets if " 83 1E 04 " in packet]
        self.assertEqual([len(packet) for _, packet in syncs], [258, 58, 63, 43])
        blocks = [(p[7 + 5 * i], p[8 + 5 * i] | p[9 + 5 * i] << 8)
                  for _, p in syncs for i in range((len(p) - 8) // 5)]
        self.assertEqual(blocks, [(i + 1, 400 + i) for i in range(60)] + [(i + 1, 300 + i) for i in range(18)])
        for first, second in (syncs[:2], syncs[2:]):  # nothing between them but the time to build it
            self.assertLess(second[0] - first[0] - len(first[1]) * BYTE_TIME, 0.3 * CYCLES_MS)
        reads = [op for op in operations if "read_result" in op]
        self.assertEqual([(op["read_result"], op["there"]) for op in reads], [(OK, 60), (OK, 18), (OK, 3)])
        for op, servos in zip(reads, (60, 18, 3)):  # the first was read first; 162 us each on the wire
            self.assertTrue(162 * (servos - 1) < op["oldest_us"] < 200 * servos, op)

    def test_servos_that_take_143_bytes_get_only_the_short_packets(self):
        operations, _ = self.run_with("--fault", "quirk 1-60 sync_write_limit 1")
        reads = [op for op in operations if "read_result" in op]
        self.assertEqual([op["there"] for op in reads], [10, 18, 3])

    def test_one_refuses_and_none_moves(self):
        operations, rows = self.run_with()
        move = [op for op in operations if "move_result" in op][0]
        self.assertEqual((move["move_result"], move["acted"]), (REFUSED, 0))
        self.assertEqual(move["servos"], {2: [REFUSED, ANGLE, NO], 3: [PENDING, 0, NO]})
        first = next(cycle for cycle, packet in self.packets if " 07 04 1E 01 02 " in packet)
        second = next(cycle for cycle, packet in self.packets if REGISTERED in packet)
        between = [packet for cycle, packet in self.packets if first <= cycle < second]
        self.assertNotIn(ACTION, between)
        self.assertIn("FF FF 01 04 03 2C 00 CB", between)
        self.assertGreater(second - first, 20 * CYCLES_MS)  # time for five periods of theirs
        for row in rows:
            if first < float(row["time_ms"]) * CYCLES_MS < second:
                for servo in (1, 2, 3):
                    self.assertEqual(int(row[f"goal_{servo}"]), 299 + servo)
                    self.assertAlmostEqual(int(row[f"present_{servo}"]), 299 + servo, delta=REST)

    def test_verified_all_start_in_the_same_control_period(self):
        operations, rows = self.run_with()
        move = [op for op in operations if "move_result" in op][1]
        self.assertEqual(move, {"move_result": OK, "acted": 1, "servos": {}})
        action = next(cycle for cycle, packet in self.packets if packet == ACTION)
        goals = [[row[f"goal_{servo}"] for servo in range(1, 19)] for row in rows
                 if abs(float(row["time_ms"]) * CYCLES_MS - action) < 40 * CYCLES_MS]
        self.assertEqual(goals[0], [str(299 + servo) for servo in range(1, 19)])
        changed = next(number for number, row in enumerate(goals) if row != goals[0])
        self.assertEqual(goals[changed], ["700"] * 18)
        starts = self.starts(rows, action)
        self.assertEqual(sorted(starts), list(range(1, 19)))
        self.assertLess(max(starts.values()) - min(starts.values()), 2 * 4)  # it slowly leaves its rest
        kinds = [packet.split()[4] for _, packet in self.packets]
        self.assertEqual(kinds[-18 * 3 - 1:], ["04"] * 18 + ["02"] * 18 + ["05"] + ["02"] * 18)

    def assert_called_off(self, operations, rows, servo, result, armed):
        """The second move; all but this one are disarmed by their own word."""
        move = [op for op in operations if "move_result" in op][1]
        self.assertEqual((move["move_result"], move["acted"]), (result, 0))
        self.assertEqual(move["servos"][servo], [result, 0, armed])
        self.assertEqual({state[2] for at, state in move["servos"].items() if at != servo} - {NO}, set())
        self.assertNotIn(ACTION, [packet for _, packet in self.packets])
        began = next(cycle for cycle, packet in self.packets if REGISTERED in packet)
        self.assertEqual(set(self.starts(rows, began)) - {servo}, set())

    def test_power_lost_for_a_moment_between_reg_write_and_action(self):
        """Behind the answer to its REG WRITE: it is there again, and knows nothing of a move."""
        reply = self.last_reply_before("FF FF 06 " + REGISTERED)
        operations, rows = self.run_with("--fault", f"cut out {reply} 6")
        self.assert_called_off(operations, rows, 5, REFUSED, NO)

    def test_power_lost_for_long_between_reg_write_and_action(self):
        """A servo that is silent for a second after power-up is in doubt until it answers."""
        reply = self.last_reply_before("FF FF 06 " + REGISTERED)
        operations, rows = self.run_with("--fault", f"cut out {reply} 6",
                                         "--fault", "quirk 5 silent_after_power_up 1")
        self.assert_called_off(operations, rows, 5, TIMEOUT, IN_DOUBT)
        asked = [packet for _, packet in self.packets if packet == "FF FF 05 04 03 2C 00 C7"]
        self.assertEqual(len(asked), 3)

    def test_action_that_is_lost_leaves_none_armed(self):
        number = self.number_of("->in", ACTION)
        operations, rows = self.run_with("--fault", f"lose in {number} 4")
        move = [op for op in operations if "move_result" in op][1]
        self.assertEqual((move["move_result"], move["acted"]), (REFUSED, 1))
        self.assertEqual(move["servos"], {servo: [REFUSED, 0, NO] for servo in range(1, 19)})
        action = next(cycle for cycle, way, packet in self.clean.packets if packet == ACTION)
        self.assertEqual(self.starts(rows, action), {})
        self.assertEqual(self.replies[-1], "FF FF 12 03 00 00 EA")  # READ of 0x2C of servo 18: 0


if __name__ == "__main__":
    unittest.main()
