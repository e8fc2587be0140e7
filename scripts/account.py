#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Where the cycles of the benchmark go: the worst case of each figure by function, as the
simulated CPU runs it (--steps). Inlined code counts for the function that contains it.

usage: account.py [--docs [--check]]    --docs: renews the tables of docs/internals/performance.md
                                        --check: changes nothing, exit 1 if one is stale
"""
import bisect
import collections
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import blocks
from measure import BYTE, CALL, DELAYS, MHZ, POLL, RETURN_DELAY, ROOT, WHOLE, Run

sys.path.insert(0, str(ROOT / "test/runs"))
import feedback

DOCS = ROOT / "docs/internals/performance.md"
HANDLER = re.compile(r"__vector_\d+|__vectors")
COPY = re.compile(r"\.(constprop|lto_priv|part).*")  # suffix that gcc gives to a copy of a function
MARGIN = 100 * MHZ  # CDS_REPLY_MARGIN_US


class Program:
    """A program of the benchmark, run as bench.py does."""

    def __init__(self, elf, *options, seconds=None, **more):
        self.elf, self.options, self.seconds, self.more = elf, options, seconds, more
        self.run = Run(elf, *options, *self.until(seconds), **more)
        names = subprocess.run(["avr-nm", "-n", ROOT / f"build/{self.run.board}/{elf}.elf"],
                               stdout=subprocess.PIPE, text=True, check=True).stdout
        words = [line.split() for line in names.splitlines()]
        self.functions = [(int(word[0], 16), word[-1]) for word in words if word[1] in "tT"]
        self.starts = [start for start, _ in self.functions]

    def until(self, seconds):
        """The options that end a run; a run that has an end of its own gets none."""
        return ("--seconds", f"{seconds:.6f}") if self.seconds else ()

    def function(self, address):
        name = self.functions[bisect.bisect_right(self.starts, address) - 1][1]
        return "handlers" if HANDLER.fullmatch(name) else COPY.sub("", name)

    def cycles(self, start, end):
        """{function: cycles} from cycle `start` to before `end`."""
        with tempfile.TemporaryDirectory() as folder:
            times = pathlib.Path(folder) / "times"
            Run(self.elf, *self.options, *self.until(end / (MHZ * 1e6) + 0.001), "--steps", f"{start}-{end}",
                keep=times, **self.more)
            steps = [tuple(map(int, line.split()[1:])) for line in times.read_text().splitlines()
                     if line.startswith("step ")]
        spent = collections.Counter()
        for (at, address), (then, _) in zip(steps, [*steps[1:], (end, 0)]):
            spent[self.function(address)] += min(then, end) - at
        if steps:
            spent["(begun before)"] += steps[0][0] - start
        return +spent


def without_handlers(span):
    return span[0] - span[1]


def reads():
    program = Program("benchmark/read", "--stamp", "B", seconds=2)
    run = program.run
    _, begun, took, n = max((took - RETURN_DELAY * n, begun, took, n)
                            for n, (took, _, begun) in
                               enumerate(run.spans(WHOLE)[DELAYS:2 * DELAYS], 1))  # of 2 bytes
    first, last = next(sent[:2] for sent in run.sent if sent[0] >= begun)
    heard = last + RETURN_DELAY * n + 8 * BYTE
    yield "`read_overhead_2`: call to first start bit", program.cycles(begun, first)
    yield ("`read_overhead_2`: end of the last stop bit of the reply to outcome known",
           program.cycles(heard, begun + took))
    took, _, begun = max(run.spans(CALL), key=without_handlers)
    yield "`enqueue`", program.cycles(begun, begun + took)


def syncs():
    program = Program("benchmark/sync", "--stamp", "B", seconds=2, servos="1-18", eeprom=[18])
    begun = program.run.spans(CALL)[-1][2]
    first = next(sent[0] for sent in program.run.sent if sent[0] >= begun)
    yield "`sync18`: call to first start bit", program.cycles(begun, first)


def longest_gap(sent):
    """From the end of a reply of 14 bytes to the beginning of the next READ."""
    gaps = [(last + RETURN_DELAY + 14 * BYTE, first)
            for (_, last, *_), (first, *_) in zip(sent, sent[1:])]
    return max(gaps, key=lambda gap: gap[1] - gap[0])


def groups():
    program = Program("benchmark/group", "--stamp", "B", seconds=2, servos="1-18", eeprom=[18])
    sent = [one for one in program.run.sent if one[2] == 8][:18]
    yield ("`group18`: last stop bit of a reply to the next start bit, the longest of 17",
           program.cycles(*longest_gap(sent)))


def absents():
    program = Program("benchmark/absent", "--stamp", "B", seconds=2)
    took, _, begun = program.run.spans(WHOLE)[0]
    due = begun + 16 * BYTE + RETURN_DELAY + MARGIN
    yield ("`absent_us`: beyond the bytes, return delay and margin",
           program.cycles(due, begun + took))


def polls():
    program = Program("benchmark/polls", "--stamp", "B", "--rules", "warn", seconds=120,
                      servos="1-50")
    took, _, begun = max(program.run.spans(POLL), key=without_handlers)
    yield "`poll_max`, with no fault", program.cycles(begun, begun + took)


def bulks():
    with tempfile.NamedTemporaryFile("w", suffix=".pc") as said:
        said.write(feedback.program())
        said.flush()
        program = Program("controller", "--host", said.name, servos="1-18")
        asked = [one for one in program.run.sent if one[2] == 8][:18]
        words = [line.split() for line in program.run.output.splitlines()]
        request = int([line for line in words if line[:1] == ["said"]][2][2])
        answered = int([line for line in words if line[:1] == ["heard"]][1][2])
        heard = asked[-1][1] + RETURN_DELAY + 14 * BYTE
        yield ("`bulk18`: last byte of the request to the first READ",
               program.cycles(request, asked[0][0]))
        yield ("`bulk18`: last stop bit of a reply to the next start bit, the longest of 17",
               program.cycles(*longest_gap(asked)))
        yield ("`bulk18`: last stop bit of the last reply to that of the last status packet",
               program.cycles(heard, answered))


JOBS = (reads, syncs, groups, absents, polls, bulks)


def tables():
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = list(pool.map(lambda job: list(job()), JOBS))
    for job in jobs:
        for title, spent in job:
            parts = ", ".join(f"{name if name == 'handlers' else f'`{name}`'} {cycles}"
                              for name, cycles in spent.most_common())
            yield f"| {title} | {sum(spent.values())} | {parts} |"


def sizes(elf, whole):
    """The tables of make size-map; for the larger program only the folders."""
    text = subprocess.run(["scripts/size-map.py", elf], stdout=subprocess.PIPE, text=True, check=True,
                          cwd=ROOT).stdout
    return "\n".join(line for line in text.splitlines()
                     if whole or not re.match(r" *[\d-]+ +[\d-]+    ", line))


def account():
    """The cycles by function, and the flash by file."""
    rows = "\n".join(tables())
    return (f"| from, to | cycles | of them |\n|---|---|---|\n{rows}",
            f"```\n{sizes('build/atmega644p/benchmark/min.elf', True)}\n```\n\n```\n"
            f"{sizes('build/atmega128/controller.elf', False)}\n```")


def main(arguments):
    cycles, flash = account()
    if "--docs" not in arguments:
        print(f"{cycles}\n\n{flash}")
        return 0
    return blocks.renew(DOCS, {"make bench-account": cycles, "make size-map": flash}, "--check" in arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
