#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The firmware while its host floods the link at 1 Mbps and a cycle of 18 servos runs at 250 Hz, with a return
delay of 6 us. test/firmware/library/flood.c is the firmware with that cycle.

usage: flood.py BOARD SEEDS    SEEDS such as 1-12 or 3,7: 300 000 random bytes for each seed. Prints the latest
                               goal of each run, and fails if one is later than it may be
"""
import pathlib
import re
import subprocess
import sys
import tempfile

from client import BROADCAST, READ, WRITE, packet
from simulator import PACKET, ROOT, SIM

DEVICE, HOST_BAUD, LINK_LOSS_MS, BUS_SENT, HOST_OVERFLOWS = 253, 0x04, 0x0A, 0x18, 0x3C
RETURN_DELAY = 0x05
MHZ = 16
PERIOD_US = 4000
LIMIT_US = 450  # docs/internals/architecture.md, "The main loop of the firmware"
COUNTERS = HOST_OVERFLOWS + 2 - BUS_SENT
NAMES = ("sent retried ok timeouts corrupt line_busy malformed stale_replies duplicate_replies "
         "unexpected_packets framing_errors overruns ring_overflows echo_errors packets "
         "host_malformed silent gaps host_overflows").split()
BYTE = 160  # cycles


class Run:
    """.counters as the device has them at the end; .late_us of each period's goals, from the first
    grid of periods; .latest_us, the latest goal against the earliest; .reads and .replies on the wire."""

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
        self.latest_us = max(self.late_us) - min(self.late_us)
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


def flooded(board, seed):
    return Run(board, f"flood 300000 {seed}")


def seeds_of(text):
    """The numbers of a list such as 1-3,7; None if it is no such list."""
    if not re.fullmatch(r"\d+(-\d+)?(,\d+(-\d+)?)*", text):
        return None
    seeds = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        seeds += range(int(first), int(last or first) + 1)
    return seeds


def main():
    seeds = seeds_of(sys.argv[2]) if len(sys.argv) == 3 else None
    if not seeds:
        print(__doc__)
        return 2
    board, latest, good = sys.argv[1], 0, True
    print(f"{board}, 300 000 random bytes at 1 Mbps from the host beside a cycle at 250 Hz: the latest goal")
    for seed in seeds:
        run = flooded(board, seed)
        missed = round(run.seconds * 1e6 / PERIOD_US) + 1 - run.periods
        print(f"  seed {seed:<5}{run.latest_us:7.1f} us" + f"   {missed} periods missed" * bool(missed)
              + "   a rule of the wire is broken" * bool(run.status), flush=True)
        latest = max(latest, run.latest_us)
        good = good and not missed and run.status == 0
    print(f"  largest   {latest:7.1f} us   limit {LIMIT_US} us")
    if good and latest <= LIMIT_US:
        return 0
    print("FAILED")
    return 1


if __name__ == "__main__":
    sys.exit(main())
