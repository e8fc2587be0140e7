# SPDX-License-Identifier: MIT
"""Torque off for all, servos that lose their state, alarms and soft limits, test/firmware/library/safety.c, as
wire and servos see them."""
# needs: $(patsubst %,build/%/firmware/safety.elf,$(HOST_BOARDS))
import collections
import re
import unittest

import boards
from simulator import Run

# Servos by board: the program has 50 on a chip with 8 KB of RAM or more, else 18.
LARGE = re.compile(r"atmega(640|128[014]|256[01])")
SERVOS = {name: 50 if LARGE.match(boards.BOARDS[name].mcu) else 18 for name in boards.HOSTED}
MHZ = 16  # cycles in a microsecond
PERIOD_US = 4000
HEALTH_US = 1000000
BEGIN_MS = 400  # of what is measured
BOUND_US = 20000  # beyond the period of the state check: it gives way to the cycle
# goals, when a servo is dropped; of 50, they may have waited behind the transaction that reported it
LATE_US = {18: 300, 50: 800}
ALL_LATE_US = 1200  # ... when all are judged
BROADCASTS_US = 2000  # from the first to the third: all that a cycle of 50 drops between them

OK, TIMEOUT, LIMIT, INHIBITED = 0, 2, 11, 12  # enum cds_result
OFF, SILENT = 1, 3  # enum cds_torque_off_outcome
ONLINE, OFFLINE, RETURNED = 1, 2, 3  # enum cds_presence
LOST, STOPPED = 1, 2  # CDS_INHIBIT_*
BROADCAST = 0xFE
PING, READ, WRITE, SYNC_WRITE = 1, 2, 3, 0x83
TORQUE_ENABLE, LED, GOAL_POSITION, REGISTERED = 0x18, 0x19, 0x1E, 0x2C

Packet = collections.namedtuple("Packet", "us id instruction address data")


class Safety(unittest.TestCase):
    def run_script(self, script, board="atmega128", servos=None):
        """`sent` is all the controller said, `said` what each line of the PC was answered."""
        run = Run(f"build/{board}/firmware/safety.elf", "--echo", board=board,
                  servos=f"1-{servos or SERVOS[board]}", script="".join(line + "\n" for line in script))
        run.output = re.sub(r"^ +\d+ (?:bus0 )?(?:->in|<-out).*\n", "", run.output, flags=re.M)
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("rules:   none broken", run.output)
        run.sent = []
        for cycle, way, text in run.packets:
            packet = bytes.fromhex(text)
            if way == "->in" and len(packet) > 3 and len(packet) == packet[3] + 4:  # else the run ended in it
                run.sent.append(Packet(cycle / MHZ, packet[2], packet[4], packet[5], packet[6:-1]))
        run.said = [[(name, int(number)) for name, number in re.findall(r"^(\w+) (\d+)$", part, re.M)]
                    for part in re.split(r"^> .*$", run.output, flags=re.M)[1:]]
        return run

    @staticmethod
    def goals_of(packet):
        """The IDs that a SYNC WRITE of goals tells something."""
        return set(packet.data[1::5])

    # ---- torque off for all ----

    def check_stop(self, board):
        servos, dead = SERVOS[board], 5
        run = self.run_script([
            "c 400", f"b {BROADCAST} 24 1", "w 1000", "@wait 300", "g 700", "@wait 100",
            f"@power {dead} off", "s", "@wait 100",
            "o", f"@expect servo 1-4 torque off", f"@expect servo {dead + 1}-{servos} torque off",
            "g 500", f"b {BROADCAST} 24 1", "d 3 30 800", "b 3 24 1", "y 1 1 2 2", "p 3",
            f"b {BROADCAST} 25 1", "r", "@wait 20",
            f"b {BROADCAST} 24 1", "g 500", "@wait 1000",
            "@expect servo 1-4 PRESENT_POSITION 495..505"], board)
        stop, told = run.said[5], [packet for packet in run.sent
                                   if packet[1:] == (BROADCAST, WRITE, TORQUE_ENABLE, b"\0")]
        first = run.sent.index(told[0])
        release = next(at for at, packet in enumerate(run.sent)
                       if packet[1:] == (BROADCAST, WRITE, LED, b"\1"))
        self.assertEqual(run.sent[first:first + 3], told)  # three, nothing between, no other
        self.assertEqual(run.sent[first + 3:first + 6],
                         [packet for packet in run.sent if packet[1:] == (BROADCAST, WRITE, REGISTERED, b"\0")])
        self.check_silence_behind(run.sent[first + 6:release], servos, dead)
        # in the order in which they were submitted: PING 1, torque on, an urgent goal, PING 3
        self.assertEqual([value for name, value in stop if name == "waiting"], [OK, INHIBITED, INHIBITED, OK])
        self.assertIn((3, PING), [packet[1:3] for packet in run.sent[first + 3:release]])
        self.assertEqual([value for name, value in stop if name == "outcome"],
                         [SILENT if 1 + i == dead else OFF for i in range(servos)])
        self.assertEqual(stop[:2], [("result", TIMEOUT), ("broadcasts", 3)])
        refused = [value for part in run.said[7:11] for name, value in part if name == "submitted"]
        self.assertEqual(refused, [INHIBITED] * 4)
        self.assertEqual(run.said[6][0], ("taken", 0))
        self.assertLess(told[2].us - told[0].us, BROADCASTS_US)
        return run.sent, first

    def check_silence_behind(self, sent, servos, dead):
        """What is sent behind the broadcasts until the release: reads, and torque off."""
        reads, offs = collections.Counter(), collections.Counter()
        for packet in sent:
            if packet.instruction == WRITE:
                self.assertEqual((packet.address, packet.data), (TORQUE_ENABLE, b"\0"))
                offs[packet.id] += 1
            else:
                self.assertIn(packet.instruction, (PING, READ))
                reads[packet.id] += packet.address == TORQUE_ENABLE
        self.assertEqual(offs, {dead: 2})
        self.assertEqual([reads[1 + i] > 0 for i in range(servos)], [True] * servos)
        self.assertGreaterEqual(reads[dead], 3)

    def test_torque_off_for_all_amid_cycle_and_queue_on_every_board(self):
        for board in boards.HOSTED:
            with self.subTest(board):
                self.check_stop(board)

    # ---- servos that lose their state ----

    def brown_outs(self, board, faults):
        """`faults`: (ms since the start, servo, ms without power), and perhaps at which byte of the
        next packet. The events of each servo as (us, inhibits, presence), and the run."""
        lines = ["c 400", f"b {BROADCAST} 24 1", "w 1000", f"@at {BEGIN_MS}", "z"]
        for at, servo, ms, *byte in faults:
            lines += [f"@at {at}", f"@fault unplug in 1 {byte[0]} {servo} {ms}" if byte else
                      f"@fault brownout {servo} {ms}"]
        last = max(fault[0] + fault[2] for fault in faults)
        victims = sorted(fault[1] for fault in faults)
        whole = [servo for servo in range(1, SERVOS[board] + 1) if servo not in victims]
        lines += [f"@at {last + 1200}", "n", "e", "g 700", "@wait 1000"]
        lines += [f"@expect servo {servo} {what}" for servo in victims
                  for what in ("TORQUE_ENABLE 0", "torque off", "PRESENT_POSITION 395..405")]
        lines += [f"@expect servo {servo} PRESENT_POSITION 695..705" for servo in whole]
        lines += [f"b {victims[0]} 24 1", f"r {victims[0]}", f"b {victims[0]} 24 1", "g 600",
                  "@wait 1000", f"@expect servo {victims[0]} PRESENT_POSITION 595..605",
                  f"@expect servo {victims[1]} torque off"]
        run = self.run_script(lines, board)
        self.assertEqual([run.said[7][0][1], run.said[9][0][1]], [INHIBITED, OK])
        events = collections.defaultdict(list)
        words = [value for _, value in run.said[5]]
        for us, servo, inhibits, presence in zip(*[iter(words)] * 4):
            events[servo].append((us, inhibits, presence))
        return events, run

    def check_brown_outs(self, board, faults):
        events, run = self.brown_outs(board, faults)
        counters = dict(run.said[4])
        self.assertEqual(sorted(events), sorted(fault[1] for fault in faults))
        lost_us = {}
        for at, servo, ms, *_ in faults:
            told = f"{board}: servo {servo}, {ms} ms from {at}: {events[servo]}"
            us, inhibits, presence = events[servo][-1]
            self.assertEqual((inhibits, presence), (LOST, ONLINE), told)
            self.assertTrue(1000 * at <= us <= 1000 * (at + ms) + HEALTH_US + BOUND_US, told)
            self.assertEqual([event[1:] for event in events[servo][:-1]],
                             [(0, OFFLINE), (0, RETURNED)] if len(events[servo]) > 1 else [], told)
            if ms >= 300:
                self.assertEqual(len(events[servo]), 3, told)
            lost_us[servo] = us
        for name, number in (("missed", 0), ("unsent", 0), ("dropped", len(faults)), ("corrupt", 0),
                             ("line_busy", 0), ("overruns", 0)):
            self.assertEqual(counters[name], number, name)
        goals = [packet for packet in run.sent if packet.instruction == SYNC_WRITE
                 and BEGIN_MS * 1000 < packet.us < BEGIN_MS * 1000 + counters["periods"] * PERIOD_US]
        self.assertAlmostEqual(len(goals), counters["periods"], delta=1)
        self.assertLess(self.late_us(goals), LATE_US[SERVOS[board]])
        self.check_goals(goals, lost_us, SERVOS[board])

    @staticmethod
    def late_us(goals):
        phases = [packet.us - n * PERIOD_US for n, packet in enumerate(goals)]
        return max(phases) - min(phases)

    def check_goals(self, goals, lost_us, servos):
        """Goals of all but those that are known to be lost, every period."""
        offset_us = 1000  # the program's clock begins later than the simulator's
        for packet in goals:
            gone = {servo for servo, us in lost_us.items() if packet.us > us + offset_us}
            there = {servo for servo in range(1, servos + 1)
                     if packet.us < lost_us.get(servo, 1e9) - PERIOD_US}
            self.assertFalse(self.goals_of(packet) & gone)
            self.assertLessEqual(there, self.goals_of(packet))

    def test_all_judged_anew_amid_a_cycle_of_50_cost_no_period(self):
        run = self.run_script(["c 400", f"b {BROADCAST} 24 1", f"@at {BEGIN_MS}", "z"]
                              + ["r", "@wait 17"] * 40 + ["n"], "arduino-mega")
        counters = dict(run.said[-1])
        self.assertEqual((counters["missed"], counters["unsent"], counters["dropped"]), (0, 0, 0))
        self.assertGreater(counters["periods"], 160)
        self.assertLess(self.late_us([packet for packet in run.sent if packet.instruction == SYNC_WRITE
                                      and packet.us > BEGIN_MS * 1000]), ALL_LATE_US)

    # Between two transactions, at any moment of a period, and amid a packet.

    def test_brown_outs_of_1_to_500_ms_in_a_cycle_of_18(self):
        self.check_brown_outs("atmega128", [
            (600, 3, 1), (607, 18, 2), (631, 1, 4), (653, 9, 20), (754, 12, 70), (901, 7, 300),
            (1203, 5, 1, 5), (1211, 10, 5, 0)])

    def test_brown_outs_of_1_to_500_ms_in_a_cycle_of_50(self):
        self.check_brown_outs("arduino-mega", [
            (600, 50, 1), (602, 17, 1), (605, 33, 3), (611, 2, 10), (673, 25, 50), (790, 41, 100),
            (897, 1, 200), (1001, 26, 500), (1502, 14, 1, 7), (1507, 48, 500, 3)])

    # ---- alarms ----

    def test_alarms_stay_until_they_are_acknowledged(self):
        run = self.run_script([
            "p 3", "q 3", "@supply 3 5.5 over 5", "@wait 100", "p 3", "p 4", "q 3", "q 4",
            "@supply 3 12 over 5", "@wait 100", "p 3", "q 3", "a 4", "q 3", "a 3", "p 3", "q 3"])
        latched = [tuple(value for _, value in part) for part in run.said
                   if part and part[0][0] == "latched"]
        voltage = 1  # CDS_ERROR_*; of the servo, and of all
        self.assertEqual(latched, [(0, 0), (voltage, voltage), (0, voltage), (voltage, voltage),
                                   (voltage, voltage), (0, 0)])
        self.assertEqual([part for part in run.said if part and part[0][0] == "alarms"],
                         [[("alarms", 0)], [("alarms", voltage)]])

    # ---- soft limits ----

    # What is said, and whether it may go out: goal and speed of servo 1 in position mode, of servo 2
    # in endless turn, where bit 10 of the speed is its direction.
    LIMITED = [
        ("l 1 300 700 200", None), ("l 2 0 1023 200", None),
        ("y 300 100 900 100", LIMIT), ("t 1 8 2", OK),  # a speed: in which mode?
        ("d 1 30 500", LIMIT), ("v 1 500 0", LIMIT), ("v 1 500 201", LIMIT),
        ("d 1 32 200", OK), ("d 1 32 201", LIMIT), ("d 1 32 0", LIMIT), ("d 1 32 1023", LIMIT),
        ("d 1 30 500", LIMIT),  # a goal without its speed
        ("v 1 300 200", OK), ("v 1 700 200", OK), ("v 1 299 200", LIMIT), ("v 1 701 200", LIMIT),
        ("b 1 30 1", LIMIT), ("b 1 32 1", LIMIT),  # half of a word
        (f"d {BROADCAST} 30 299", LIMIT), (f"d {BROADCAST} 32 201", LIMIT),
        ("y 300 100 900 100", OK), ("y 299 100 900 100", LIMIT), ("y 300 100 900 201", LIMIT),
        ("y 300 0 900 100", LIMIT),
        ("d 1 6 0", OK), ("d 1 8 0", LIMIT),  # endless turn knows no goal
        ("d 2 6 0", LIMIT), ("d 2 32 200", OK),  # the speed it holds would turn it
        ("d 2 6 0", LIMIT), ("t 2 6 4", OK), ("t 2 30 4", OK),  # it counts when it was read
        ("d 2 6 0", OK), ("d 2 8 0", OK),
        ("d 2 32 200", OK), ("d 2 32 1224", OK), ("d 2 32 0", OK), ("d 2 32 1024", OK),
        ("d 2 32 201", LIMIT), ("d 2 32 1225", LIMIT), ("d 2 32 2047", LIMIT),
    ]

    def test_beyond_a_soft_limit_nothing_is_on_the_wire(self):
        lines = []
        for line, _ in self.LIMITED:
            lines += ["n", line]
        run = self.run_script(lines + ["n", "@expect servo 1 GOAL_POSITION 300",
                                       "@expect servo 1 MOVING_SPEED 100",
                                       "@expect servo 1 CCW_ANGLE_LIMIT 1023",
                                       "@expect servo 2 MOVING_SPEED 1024"])
        admitted = 0
        for n, (line, wanted) in enumerate(self.LIMITED):
            counters, said = dict(run.said[2 * n]), dict(run.said[2 * n + 1])
            after = dict(run.said[2 * n + 2])
            if wanted is not None:
                self.assertEqual(said["submitted"], wanted, line)
            self.assertEqual(after["sent"] - counters["sent"], wanted == OK, line)
            self.assertEqual(after["ok"] - counters["ok"], wanted == OK, line)
            admitted += wanted == OK
        # and by the servos' own count; the first packet is the return delay
        self.assertEqual(len(run.sent), 1 + admitted)
        self.assertIn(f"bus 0:   {1 + admitted} packets in", run.output)

    def test_a_cycle_takes_no_goal_beyond_a_limit(self):
        run = self.run_script([
            "c 400", f"b {BROADCAST} 24 1", "t 3 8 2", "l 3 0 600 1023", "l 4 0 1023 299", "@wait 50", "n",
            "g 700", "@wait 1000", "@expect servo 3-4 PRESENT_POSITION 395..405",
            "@expect servo 1-2 PRESENT_POSITION 695..705"])
        self.assertEqual(run.said[6][0], ("taken", SERVOS["atmega128"] - 2))
        self.assertEqual(dict(run.said[5])["dropped"], 1)  # servo 4: its speed is beyond the limit
        goals = [packet for packet in run.sent if packet.instruction == SYNC_WRITE]
        for packet in goals:
            blocks = [packet.data[1 + at:6 + at] for at in range(0, len(packet.data) - 1, 5)]
            self.assertFalse(any(block[0] == 3 and block[1:3] != b"\x90\x01" for block in blocks))
        self.assertNotIn(4, self.goals_of(goals[-1]))
        self.assertIn(3, self.goals_of(goals[-1]))


if __name__ == "__main__":
    unittest.main()
