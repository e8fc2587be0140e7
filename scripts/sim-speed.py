#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How fast the simulator is on this machine, in times of real time: a line for each kind of run.

usage: sim-speed.py SIM BUSY_ELF
"""
import re
import subprocess
import sys
import tempfile
import time

SERVOS = range(1, 19)


def packet(servo, instruction, *parameters):
    body = [servo, len(parameters) + 2, instruction, *parameters]
    return " ".join(f"{byte:02X}" for byte in [0xFF, 0xFF, *body, ~sum(body) & 0xFF])


def saturated(rounds):
    """Ten times goals to all servos, then the whole table of each, and so on."""
    yield "@send " + packet(0xFE, 3, 0x18, 1)
    for n in range(rounds):
        goals = [byte for servo in SERVOS for byte in (servo, n * 5 & 0xFF, n * 5 >> 8 & 3, 0, 0)]
        yield from ["@send " + packet(0xFE, 0x83, 0x1E, 4, *goals)] * 10
        for servo in SERVOS:
            yield "@send " + packet(servo, 2, 0, 50)
            yield f"@expect packet out FF FF {servo:02X} 34" + " .." * 52


def main():
    sim, busy = sys.argv[1:]
    on_board = ["firmware", busy, "--board", "atmega128", "--host", "stdout"]
    with tempfile.NamedTemporaryFile("w", suffix=".script") as script:
        script.write("\n".join(saturated(300)) + "\n")
        script.flush()
        runs = [("idle bus, 18 servos, no AVR", 1000,
                 ["bus", "--servos", "1-18", "--seconds", "3000"]),
                ("saturated bus, 18 servos, no AVR", 20,
                 ["bus", "--servos", "1-18", "--script", script.name]),
                ("ATmega128, busy bus, 18 servos", 1, [*on_board, "--servos", "1-18", "--seconds", "10"]),
                ("ATmega128, busy bus, 50 servos", 1, [*on_board, "--servos", "1-50", "--seconds", "10"])]
        print(f"{'times real time':36}{'wanted':>8}{'is':>10}{'wire busy':>12}")
        for name, wanted, options in runs:
            start = time.perf_counter()
            done = subprocess.run([sim, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                  text=True)
            if done.returncode:
                sys.exit(f"{name}: {done.stdout}{done.stderr}")
            speed = float(re.search(r"time: +([\d.]+) s", done.stdout)[1]) / (time.perf_counter() - start)
            wire = re.search(r"wire busy ([\d.]+ %)", done.stdout)[1]
            print(f"{name:36}{wanted:>8}{speed:>10.1f}{wire:>12}", flush=True)


if __name__ == "__main__":
    main()
