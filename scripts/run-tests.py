#!/usr/bin/env python3
"""Runs test programs, a line each, and adds up their tests; the last line is `N passed, N failed`.

usage: run-tests.py [--avr-board BOARD] [--jobs N] PROGRAM...
An .elf is a Unity suite for the AVR and runs in the simulator ($SIM); a .py is a Python unittest;
anything else is a Unity suite for this machine. A program that ends without Unity's or unittest's
closing line, or with a bad exit status, counts as a failed test. Its output is shown if it failed.
"""
import argparse
import concurrent.futures
import os
import re
import signal
import subprocess
import sys
import tempfile
import time

UNITY = re.compile(r"^(\d+) Tests (\d+) Failures (\d+) Ignored", re.M)
UNITTEST = re.compile(r"^Ran (\d+) tests? in", re.M)
UNITTEST_BAD = re.compile(r"^FAILED \((.*)\)", re.M)
TIMEOUT_S = 300
# The make that runs this is none of the programs' business: one that calls make must not talk to it.
ENVIRONMENT = {name: value for name, value in os.environ.items()
               if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}


def command_of(program, board):
    if program.endswith(".elf"):
        return ["AVR", [os.environ["SIM"], "firmware", program, "--board", board, "--servos",
                        "none", "--host", "stdout", "--seconds", "60"]]
    if program.endswith(".py"):
        return ["runs", [sys.executable, program]]
    return ["host", [program]]


def count(output, status):
    """(passed, failed) by what the program printed and how it ended."""
    unity, unittest = UNITY.search(output), UNITTEST.search(output)
    if unity:
        total, failed = int(unity[1]), int(unity[2]) + int(unity[3])
    elif unittest:
        bad = UNITTEST_BAD.search(output)
        numbers = re.findall(r"(?:failures|errors|skipped)=(\d+)", bad[1]) if bad else []
        total, failed = int(unittest[1]), sum(map(int, numbers))
        skipped = re.search(r"^OK \(skipped=(\d+)\)", output, re.M)
        failed += int(skipped[1]) if skipped else 0
    else:
        return 0, 1
    if status != 0 and failed == 0 or total == 0:
        failed += 1
    return max(total - failed, 0), failed


def run(program, board):
    """Its output goes to a file, not a pipe, and its process group ends with it: what a test may
    have left running cannot hold up the others."""
    where, command = command_of(program, board)
    start = time.monotonic()
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT,
                                   stdin=subprocess.DEVNULL, env=ENVIRONMENT,
                                   start_new_session=True)
        try:
            status = process.wait(TIMEOUT_S)
        except subprocess.TimeoutExpired:
            output.write(b"\ntimed out")
            status = 1
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        output.seek(0)
        text = output.read().decode(errors="replace")
    return where, program, text, *count(text, status), time.monotonic() - start


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--avr-board", default="arduino-mega")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("programs", nargs="+")
    arguments = parser.parse_args()
    passed = failed = 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for result in pool.map(lambda p: run(p, arguments.avr_board), arguments.programs):
            where, program, output, good, bad, seconds = result
            passed, failed = passed + good, failed + bad
            name = os.path.basename(program).rsplit(".", 1)[0]
            print(f"  {where:<5}{name:<28}{good:>4} passed{bad:>4} failed {seconds:7.1f} s", flush=True)
            if bad:
                print(output, flush=True)
    print(f"\n{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
