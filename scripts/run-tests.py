#!/usr/bin/env python3
"""Runs test programs, a line each, and adds up their tests; the last line is `N passed, N failed`.

usage: run-tests.py [--avr-board BOARD] [--jobs N] [--times FILE] PROGRAM...
An .elf is a Unity suite for the AVR and runs in the simulator ($SIM); a .py is a Python unittest;
anything else is a Unity suite for this machine. A program that ends without Unity's or unittest's
closing line, or with a bad exit status, counts as a failed test. Its output is shown if it failed.
FILE keeps what each program took; the longest begin first, so that no core waits for one at the end.
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

UNITY = re.compile(r"^(\d+) Tests (\d+) Failures (\d+) Ignored", re.M)
UNITTEST = re.compile(r"^Ran (\d+) tests? in", re.M)
UNITTEST_BAD = re.compile(r"^(?:FAILED|OK) \((.*)\)", re.M)
TIMEOUT_S = 900  # only a suite that hangs takes so long, on a busy machine too
UNKNOWN_S = {".py": 30, ".elf": 5, "": 1}  # taken for the time of a program that has not run yet
# The make that runs this is not the programs' concern.
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


def read_times(path):
    """{program: seconds} of the latest runs."""
    lines = path.read_text().splitlines() if path and path.exists() else []
    return {name: float(seconds) for name, _, seconds in (line.partition("\t") for line in lines)}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--avr-board", default="arduino-mega")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() + 1)  # some wait for real time
    parser.add_argument("--times", type=pathlib.Path)
    parser.add_argument("programs", nargs="+")
    arguments = parser.parse_args()
    times = read_times(arguments.times)
    programs = sorted(arguments.programs, reverse=True, key=lambda program: times.get(
        program, UNKNOWN_S[os.path.splitext(program)[1]]))
    passed = failed = 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        runs = [pool.submit(run, program, arguments.avr_board) for program in programs]
        for done in concurrent.futures.as_completed(runs):
            where, program, output, good, bad, seconds = done.result()
            passed, failed = passed + good, failed + bad
            times[program] = seconds
            name = os.path.basename(program).rsplit(".", 1)[0]
            print(f"  {where:<5}{name:<28}{good:>4} passed{bad:>4} failed {seconds:7.1f} s", flush=True)
            if bad:
                print(output, flush=True)
    if arguments.times:
        arguments.times.write_text("".join(f"{name}\t{seconds:.1f}\n" for name, seconds in times.items()))
    print(f"\n{passed} passed, {failed} failed")
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
