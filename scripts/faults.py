#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs every row of build/host/faults on every board it applies to, --jobs at a time. Prints a line for
each row.

usage: faults.py [--part N/M] [--seed N] [--jobs N] [--out FILE] [--docs] [ROW...]

--docs: renews the table in docs/internals/faults.md from FILE; runs nothing.
--part 1/20: runs the first of 20 parts into which --seed divides the injections.

Writes FILE (build/faults.tsv), a row for each fault:
  injections, failures
  undetected     injections in which the library took a value that no servo sent
  misunderstood  injections in which a servo carried out a damaged packet
  lost           good transactions lost while a servo waited for missing bytes of a damaged packet
  late_us        latest end of a call after its deadline
`undetected` and `misunderstood` that the test did not predict or allow count as failures. Exit status 1
if there are failures.
"""
import argparse
import collections
import csv
import concurrent.futures
import os
import pathlib
import subprocess
import sys
import threading
import time

import blocks
from make_list import make_list

TOOL = "build/host/faults"
COLUMNS = "fault what injections failures undetected misunderstood lost late_us".split()
ELF = {"F14": "build/{}/controller.elf"}
OTHERS = "build/{}/firmware/transactions.elf"


class Row:
    def __init__(self, name, what, boards):
        self.name, self.what = name, what
        self.boards = boards
        self.figures = [0, 0, 0, 0, 0, 0.0]
        self.failures = []  # texts
        self.open = len(self.boards)
        self.seconds = 0.0
        self.progress = {}

    def add(self, figures):
        self.figures = [a + b for a, b in zip(self.figures[:-1], map(int, figures[:-1]))] + \
                       [max(self.figures[-1], float(figures[-1]))]


def rows(names):
    listed = subprocess.run([TOOL, "--list"], stdout=subprocess.PIPE, text=True, check=True).stdout
    boards = make_list("list-faults-boards")
    cells = [line.split("\t") for line in listed.splitlines()]
    found = [Row(name, what, only.split() or boards) for name, only, what in cells]
    return [row for row in found if not names or row.name in names]


class Display:
    """Prints a line for each finished row. On a terminal the last line shows the rows that run."""

    def __init__(self):
        self.lock, self.running = threading.Lock(), collections.OrderedDict()
        self.tty = sys.stdout.isatty()

    def say(self, row, board, done, total):
        with self.lock:
            self.running[(row.name, board)] = (done, total)
            if self.tty:
                text = ", ".join(f"{n} {b} {d}/{t}" for (n, b), (d, t) in self.running.items())
                print("\r\033[K  " + text[:110], end="", flush=True)

    def end(self, row, board):
        with self.lock:
            self.running.pop((row.name, board), None)
            if row.open:
                return
            injections, failures = row.figures[0], max(row.figures[1], len(row.failures) > 0)
            start = "\r\033[K" if self.tty else ""
            print(f"{start}  {row.name:12}{row.what[:62]:64}{injections:>7} injections"
                  f"{failures:>5} failures{row.seconds:7.1f} s", flush=True)
            for failure in row.failures:
                print("      " + failure, flush=True)


def run(row, board, arguments, display):
    elf = ELF.get(row.name.split("-")[0], OTHERS).format(board)
    parts = arguments.part.split("/")
    start = time.monotonic()
    process = subprocess.Popen([TOOL, row.name, board, elf, *parts, arguments.seed],
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    done = False
    for line in process.stdout:
        words = line.rstrip("\n").split("\t")
        if words[0] == "progress":
            display.say(row, board, *words[1:])
        elif words[0] == "done":
            row.add(words[1:])
            done = True
        else:
            row.failures.append(f"{board}: {words[-1]}")
    if process.wait() and not row.failures or not done:
        row.failures.append(f"{board}: ended with status {process.returncode}")
    row.seconds += time.monotonic() - start
    row.open -= 1
    display.end(row, board)


def write(path, done):
    with open(path, "w") as out:
        print(*COLUMNS, sep="\t", file=out)
        for row in done:
            *figures, late_us = row.figures
            figures[1] = max(figures[1], len(row.failures) > 0)
            print(row.name, row.what, *map(int, figures), f"{late_us:.1f}", sep="\t", file=out)


def document(path, docs=pathlib.Path("docs/internals/faults.md")):
    with open(path) as file:
        done = list(csv.DictReader(file, delimiter="\t"))
    missing = {row.name for row in rows([])} - {row["fault"] for row in done}
    if missing:
        sys.exit(f"{path} lacks {', '.join(sorted(missing))}: run make faults-docs")
    columns = ["fault", "what", "injections", "failures", "undetected", "misunderstood", "lost"]
    lines = [f"| {' | '.join(columns)} |", "|" + "---|" * len(columns)]
    lines += [f"| {' | '.join(row[column] for column in columns)} |" for row in done]
    blocks.renew(docs, {"make faults": "\n".join(lines)})


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--part", default="1/1")
    parser.add_argument("--seed", default="0")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--out", default="build/faults.tsv")
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("rows", nargs="*")
    arguments = parser.parse_args()
    if arguments.docs:
        document(arguments.out)
        return 0
    done = rows(arguments.rows)
    display = Display()
    start = time.monotonic()
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        work = [pool.submit(run, row, board, arguments, display)
                for row in done for board in row.boards]
    for one in work:
        one.result()
    write(arguments.out, done)
    injections = sum(row.figures[0] for row in done)
    failures = sum(max(row.figures[1], len(row.failures) > 0) for row in done)
    print(f"\n{injections} injections, {failures} failures, "
          f"{time.monotonic() - start:.0f} s; {arguments.out}")
    return 1 if failures or not injections else 0


if __name__ == "__main__":
    sys.exit(main())
