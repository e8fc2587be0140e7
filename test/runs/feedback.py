#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Whole-robot feedback over a host link of 1 Mbps: one BULK READ of 18 servos, 8 bytes each, against
18 round trips of a PC that takes 1 ms for each. Times in CPU cycles of the simulator.

usage: feedback.py [BOARD]     prints both, and fails if the BULK READ takes longer than it may
"""
import pathlib
import subprocess
import sys
import tempfile

from client import BROADCAST, PRESENT_POSITION, READ, WRITE, packet
from simulator import ROOT, SIM

SERVOS, BYTES = range(1, 19), 8
MHZ = 16  # cycles in a microsecond
LATENCY_US = 1000
LIMIT_US = 6500
WIRE_US = len(SERVOS) * (8 + 6 + BYTES) * 10 + len(SERVOS) * 2  # packets, and the return delay
DEVICE, HOST_BAUD, BULK_READ = 253, 0x04, 0x92
# The last byte of each BULK READ comes a little later than that of the one before, so that it meets every
# place in a turn of the main loop. A turn takes about 25 us.
BULKS = 16
PAUSE_STEP_US = 2


def say(raw):
    return "say " + raw.hex(" ")


def program():
    size = 6 + BYTES
    bulk = [0] + [byte for servo in SERVOS for byte in (BYTES, servo, PRESENT_POSITION)]
    lines = ["wait 30000",  # a new controller prints a banner
             say(packet(DEVICE, WRITE, [HOST_BAUD, 1])), "hear 6", "wait 6000", "baud 1000000"]
    request = packet(BROADCAST, BULK_READ, bulk)
    for number in range(BULKS):
        lines += [say(request[:-1]), f"wait {10 * len(request) + PAUSE_STEP_US * number}", say(request[-1:]),
                  f"hear {size * len(SERVOS)}", "wait 5000"]
    for servo in SERVOS:
        lines += [say(packet(servo, READ, [PRESENT_POSITION, BYTES])), f"hear {size}",
                  f"wait {LATENCY_US}"]
    return "\n".join(lines) + "\n"


class Feedback:
    """.bulk_us: from the last byte of the request to the last of the reply, the mean of BULKS requests.
    .trips_us: from the first byte of the first request until the program has the last reply. .bulks,
    .trips: the bytes of each BULK READ, and of all round trips."""

    def __init__(self, board="atmega128"):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "pc"
            path.write_text(program())
            done = subprocess.run(
                [SIM, "firmware", ROOT / f"build/{board}/controller.elf", "--board", board,
                 "--servos", f"{SERVOS[0]}-{SERVOS[-1]}", "--host", path], stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT, text=True, timeout=120)
        self.status, self.output = done.returncode, done.stdout
        lines = [line.split() for line in self.output.splitlines()]
        said = [(int(line[1]), int(line[2])) for line in lines if line[0] == "said"]
        heard = [(int(line[2]), bytes.fromhex("".join(line[4:]))) for line in lines
                 if line[0] == "heard"]
        bulks = slice(1, 1 + BULKS)  # the first request sets the rate
        asked = [end for _, end in said[2:2 + 2 * BULKS:2]]
        took = [end - begun for begun, (end, _) in zip(asked, heard[bulks])]
        self.bulk_us = sum(took) / BULKS / MHZ
        self.trips_us = (heard[-1][0] - said[1 + 2 * BULKS][0]) / MHZ + LATENCY_US
        self.bulks = [raw for _, raw in heard[bulks]]
        self.trips = b"".join(raw for _, raw in heard[1 + BULKS:])
        self.is_equal = self.bulks == [self.trips] * BULKS


def main():
    run = Feedback(*sys.argv[1:2])
    good = run.status == 0 and run.is_equal and run.bulk_us <= LIMIT_US
    print(f"feedback of {len(SERVOS)} servos x {BYTES} bytes, host link at 1 Mbps:")
    print(f"  18 READs, a PC with 1 ms latency   {run.trips_us / 1000:7.3f} ms")
    print(f"  one BULK READ, mean of {BULKS}          {run.bulk_us / 1000:7.3f} ms   limit "
          f"{LIMIT_US / 1000} ms; the bus alone {WIRE_US / 1000} ms")
    if run.status:
        print(run.output)
    if not run.is_equal:
        print("the replies differ")
    if not good:
        print("FAILED")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
