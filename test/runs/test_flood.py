# SPDX-License-Identifier: MIT
"""300 000 random bytes, or READs of all servos, at 1 Mbps on the host link while a cycle of 18 servos
runs at 250 Hz with a return delay of 6 us. test/firmware/library/flood.c is the firmware with that
cycle."""
# needs: $(patsubst %,build/%/firmware/flood.elf,$(HOST_BOARDS))
import pathlib
import re
import subprocess
import tempfile
import unittest

import boards
from client import BROADCAST, READ, WRITE, packet
from simulator import LONG, PACKET, ROOT, SIM

DEVICE, HOST_BAUD, LINK_LOSS_MS, BUS_SENT, HOST_OVERFLOWS = 253, 0x04, 0x0A, 0x18, 0x3C
RETURN_DELAY = 0x05
MHZ = 16
PERIOD_US = 4000
COUNTERS = HOST_OVERFLOWS + 2 - BUS_SENT
NAMES = ("sent retried ok timeouts corrupt line_busy malformed stale_replies duplicate_replies "
         "unexpected_packets framing_errors overruns ring_overflows echo_errors packets "
         "host_malformed silent gaps host_overflows").split()
FLOOD = "flood 300000"
BYTE = 160  # cycles
SERVOS = range(1, 19)


class Run:
    """.counters as the device has them at the end; .late_us of each period's goals, from the first
    grid of periods; .reads and .replies on the wire."""

    def __init__(self, board, during):
        lines = ["say " + packet(BROADCAST, WRITE, [RETURN_DELAY, 3]).hex(" "), "wait 10000",
                 "say " + packet(DEVICE, WRITE, [HOST_BAUD, 1]).hex(" "), "hear 6", "wait 6000",
                 "baud 1000000", "wait 10000", during, "wait 500000",
                 "say " + packet(DEVICE, READ, [BUS_SENT, COUNTERS]).hex(" "), f"hear {COUNTERS + 6}"]
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "pc").write_text("\n".join(lines) + "\n")
            done = subprocess.run(
                [SIM, "firmware", ROOT / f"build/{board}/firmware/flood.elf", "--board", board,
                 "--servos", "1-18", "--host", folder / "pc", "--transcript", folder / "transcript"],
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=200)
            wire = (folder / "transcript").read_text().splitlines()
        wire = [match for match in map(PACKET.match, wire) if match]
        self.status, self.output = done.returncode, done.stdout
        heard = [line.split() for line in self.output.splitlines() if line.startswith("heard")]
        said = [line.split() for line in self.output.splitlines() if line.startswith("said")]
        raw = bytes.fromhex("".join(heard[-1][4:]))
        words = [int.from_bytes(raw[at:at + 2], "little") for at in range(5, 5 + COUNTERS, 2)]
        self.counters = dict(zip(NAMES, words))
        broadcasts = sum(match[3].startswith("FF FF FE") for match in wire)
        ends = [int(match[1]) + int(match[4]) * BYTE for match in wire]
        goals, before = zip(*[(int(match[1]), end) for match, end in zip(wire[1:], ends)
                              if re.match("FF FF FE .. 83", match[3])])
        goals, before = goals[10:], before[10:] # the goals before the host sends anything
        self.seconds = (goals[-1] - goals[0]) / MHZ / 1e6
        self.periods = len(goals)
        self.late_us = [(cycle - goals[0]) / MHZ - PERIOD_US * period
                        for period, cycle in enumerate(goals)]
        # the same, from the end of the last packet on the wire if that is later
        due = [goals[0] + min(self.late_us) * MHZ + PERIOD_US * MHZ * i for i in range(len(goals))]
        self.late_on_free_line_us = [(goal - max(due, end)) / MHZ
                                     for goal, due, end in zip(goals, due, before)]
        self.sent = sum(match[2] == "->in" for match in wire)
        # packets sent when the host asked for the counters, and when it had them
        self.asked, self.told = (sum(match[2] == "->in" and int(match[1]) <= int(cycle)
                                     for match in wire) for cycle in (said[-1][2], heard[-1][1]))
        self.reads = self.sent - broadcasts
        self.replies = len(wire) - self.sent


class Flood(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        every = boards.with_profile("console")
        cls.runs = {(board, during): Run(board, during)
                    for board in (every if LONG else ["atmega128", "arbotix"])
                    for during in ("wait 3000000", FLOOD + " 7")}

    def test_flood_loses_nothing_on_the_bus(self):
        for which, run in self.runs.items():
            with self.subTest(which):
                self.assertEqual(run.status, 0, run.output)  # no rule of the wire broken
                self.assertIn(run.reads - run.replies, (0, 1))  # the last one may be cut
                for name in NAMES[:14]:
                    if name not in ("sent", "ok"):
                        self.assertEqual(run.counters[name], 0, name)
                self.assertLessEqual(run.counters["sent"] - run.counters["ok"], 1)
                self.assertLessEqual(run.asked, run.counters["sent"])
                self.assertLessEqual(run.counters["sent"], run.told)

    def test_flood_misses_no_period_and_delays_no_goal(self):
        for which, run in self.runs.items():
            with self.subTest(which):
                self.assertEqual(run.periods, round(run.seconds * 1e6 / PERIOD_US) + 1)
                # the seeds 1 to 12, run by hand on each board: 419 us at the most
                self.assertLess(max(run.late_us) - min(run.late_us), 450)

    def test_reads_of_the_host_delay_no_goal_beyond_its_bound(self):
        """Each READ shows the permit settings of a servo; LINK_LOSS_MS makes the robot know them all."""
        for board in boards.with_profile("console"):
            for registers, gap_us in ([6, 4], 900), ([0, 17], 300), ([0, 50], 1700):
                reads = ["say " + packet(DEVICE, WRITE, [LINK_LOSS_MS, 0x60, 0xEA]).hex(" ")]
                reads += [f"say {packet(servo, READ, registers).hex(' ')}\nwait {gap_us}"
                          for servo in SERVOS]
                run = Run(board, "\n".join(reads))
                with self.subTest(board=board, registers=registers):
                    self.assertEqual(run.status, 0, run.output)
                    self.assertLess(max(run.late_on_free_line_us), 800)

    def test_flood_leaves_time_for_feedback(self):
        for quiet, loud in self.pairs():
            self.assertGreater(loud.reads, 0.7 * quiet.reads)

    def test_flood_counts_its_gaps(self):
        for quiet, loud in self.pairs():
            self.assertEqual((quiet.counters["gaps"], quiet.counters["host_malformed"]), (0, 0))
            self.assertGreater(loud.counters["gaps"], 100)
            self.assertGreaterEqual(loud.counters["gaps"], loud.counters["host_overflows"])

    def pairs(self):
        runs = list(self.runs.values())
        return zip(runs[::2], runs[1::2])


if __name__ == "__main__":
    unittest.main()
