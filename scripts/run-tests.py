#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs test programs, a line each, and adds up their tests; the last line is `N passed, N failed`.

usage: run-tests.py [--avr-board BOARD] [--jobs N] [--times FILE] [--skipped TEXT] PROGRAM...
An .elf is a Unity suite for the AVR and runs in the simulator ($SIM); a .py is a Python unittest; a
.test.js is a suite of Node's test runner; anything else is a Unity suite for this machine. A program
that ends without its closing line, or with a bad exit status, counts as a failed test. Its output is
shown if it failed. TEXT tells which suites are not run, and how to run them.
FILE keeps what each program took; the longest begin first, so that no core waits for one at the end.
Ctrl-C and SIGTERM kill the programs that run, and end with status 130.
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
import threading
import time

UNITY = re.compile(r"^(\d+) Tests (\d+) Failures (\d+) Ignored", re.M)
UNITTEST = re.compile(r"^Ran (\d+) tests? in", re.M)
UNITTEST_BAD = re.compile(r"^(?:FAILED|OK) \((.*)\)", re.M)
NODE = re.compile(r"^# tests (\d+)\n(?:# .*\n)*?# pass (\d+)$", re.M)
BAD_COUNT = re.compile(r"(?:failures|errors|skipped)=(\d+)")
TIMEOUT_S = 900  # only a suite that hangs takes so long, on a busy machine too
UNKNOWN_S = {".py": 30, ".elf": 5, ".js": 20, "": 1}  # taken for the time of a program that has not run yet
# The make that runs this is not the programs' concern.
ENVIRONMENT = {name: value for name, value in os.environ.items()
               if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}


def command_of(program, board):
    if program.endswith(".elf"):
        return ["AVR", [os.environ["SIM"], "firmware", program, "--board", board, "--servos",
                        "none", "--host", "stdout", "--seconds", "60"]]
    if program.endswith(".py"):
        return ["runs", [sys.executable, program]]
    if program.endswith(".js"):
        return ["panel", ["node", "--test", "--test-reporter=tap", program]]
    return ["host", [program]]


def count(program, output, status):
    """(passed, failed) by the last summary that the program printed, and by how it ended."""
    of_python = program.endswith(".py")
    if program.endswith(".js"):
        summary = NODE.search(output)
        passed, total = (int(summary[2]), int(summary[1])) if summary else (0, 1)
        return passed, max(total - passed, int(status != 0 or total == 0))
    summary = list((UNITTEST if of_python else UNITY).finditer(output))
    if not summary:
        return 0, 1
    total = int(summary[-1][1])
    if of_python:
        bad = UNITTEST_BAD.search(output, summary[-1].end())
        failed = sum(map(int, BAD_COUNT.findall(bad[1]))) if bad else 0
    else:
        failed = int(summary[-1][2]) + int(summary[-1][3])
    if status != 0 and failed == 0 or total == 0:
        failed += 1
    return max(total - failed, 0), failed


def name_of(program):
    return os.path.basename(program).split(".")[0]


def kill_group(process):
    """Kills the process and all that it has started."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


class Programs:
    """Starts programs, each in a process group of its own, and can kill all that run."""

    def __init__(self, board):
        self.board = board
        self.running = {}  # program: process, or None while it is started
        self.stopped = False
        self.killed = []  # names

    def stop(self, *_):
        """Handler of signals: kills what runs. It raises nothing, since an exception at a random place
        may leave a lock of the pool locked. A thread that starts a program at this moment finds
        `stopped` set."""
        if not self.stopped:
            self.killed = sorted(map(name_of, list(self.running)))
        self.stopped = True
        for process in filter(None, list(self.running.values())):
            kill_group(process)

    def run(self, program):
        """(where, output, passed, failed, seconds), or None once stopped. The output goes to a file, not a pipe, and the
        process group ends with the program: a process that a test leaves behind delays no suite."""
        if self.stopped:
            return None
        where, command = command_of(program, self.board)
        start = time.monotonic()
        self.running[program] = None
        with tempfile.TemporaryFile() as output:
            try:
                process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT,
                                           stdin=subprocess.DEVNULL, env=ENVIRONMENT,
                                           start_new_session=True)
            except OSError as error:
                del self.running[program]
                return where, str(error), 0, 1, 0
            self.running[program] = process
            if self.stopped:
                kill_group(process)
            limit = threading.Timer(TIMEOUT_S, kill_group, [process])
            limit.start()
            status = process.wait()
            limit.cancel()
            seconds = time.monotonic() - start
            if seconds >= TIMEOUT_S:
                output.write(b"\ntimed out")
            kill_group(process)
            del self.running[program]
            output.seek(0)
            text = output.read().decode(errors="replace")
        return None if self.stopped else (where, text, *count(program, text, status), seconds)


def read_times(path):
    """{program: seconds} of the latest runs."""
    text = path.read_text(errors="replace") if path and path.exists() else ""
    return {name: float(seconds) for name, seconds in re.findall(r"^(.+)\t(\d+(?:\.\d+)?)$", text, re.M)}


class Totals:
    """Prints a line for each program that has ended, and adds up."""

    def __init__(self, program_count):
        self.program_count = program_count
        self.ended = self.passed = self.failed = 0

    def add(self, program, where, output, passed, failed, seconds):
        self.ended += 1
        self.passed += passed
        self.failed += failed
        width = len(str(self.program_count))
        print(f"  {self.ended:>{width}}/{self.program_count} {where:<6}{name_of(program):<28}"
              f"{passed:>4} passed{failed:>4} failed {seconds:7.1f} s", flush=True)
        if failed:
            print(output, flush=True)


def run_all(names, programs, totals, times, jobs):
    """Runs the programs side by side. Returns false if the user has interrupted it."""
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        runs = {pool.submit(programs.run, name): name for name in names}
        left = set(runs)
        while left:
            # A signal that comes right before a wait does not end it: hence the timeout.
            ended, left = concurrent.futures.wait(left, 1, concurrent.futures.FIRST_COMPLETED)
            for run in filter(concurrent.futures.Future.result, ended):
                totals.add(runs[run], *run.result())
                times[runs[run]] = run.result()[-1]
    if programs.stopped:
        print(f"\ninterrupted: {totals.ended} of {totals.program_count} suites have ended; "
              f"killed: {', '.join(programs.killed) or 'none'}", flush=True)
    return not programs.stopped


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--avr-board", default="arduino-mega")
    parser.add_argument("--jobs", type=int, default=2 * os.cpu_count())  # some wait for real time
    parser.add_argument("--times", type=pathlib.Path)
    parser.add_argument("--skipped", default="")
    parser.add_argument("programs", nargs="+")
    arguments = parser.parse_args()
    programs = Programs(arguments.avr_board)
    for number in [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]:
        if signal.getsignal(number) != signal.SIG_IGN:  # as under nohup
            signal.signal(number, programs.stop)
    times = read_times(arguments.times)
    names = sorted(arguments.programs, reverse=True, key=lambda program: times.get(
        program, UNKNOWN_S[os.path.splitext(program)[1]]))
    totals = Totals(len(names))
    whole = run_all(names, programs, totals, times, arguments.jobs)
    if arguments.times:
        arguments.times.write_text("".join(f"{name}\t{seconds:.1f}\n" for name, seconds in times.items()))
    if not whole:
        return 130
    if arguments.skipped:
        print(f"\nskipped: {arguments.skipped}")
    print(f"\n{totals.passed} passed, {totals.failed} failed")
    return 1 if totals.failed or not totals.passed else 0


if __name__ == "__main__":
    sys.exit(main())
