#!/usr/bin/env python3
"""Frama-C Eva proves that the analysed sources have no run-time error: no access out of bounds, no
invalid pointer, no signed overflow, no uninitialised read, no wrong shift or division.

usage: eva.py [NAME ...]   (names of ANALYSES; default: all)

Each analysis begins at a function of test/eva/*.c, which calls the sources with unknown arguments.
The machine is an AVR: int and pointers have 16 bits (test/eva/machdep.ml). Inline assembler is
ignored, so each __asm__ in an analysed source must have an empty text.

An alarm is a possible error that Eva could not exclude. test/eva/explained.tsv lists the alarms that
are known to be none: file, function, kind, number of alarms, reason. The check fails if an alarm is
not on the list, if the list has an alarm that did not come, if a path of an analysis ends in a
certain error, or if an analysis does not come to its end.
"""
import collections
import csv
import pathlib
import re
import subprocess
import sys
import time

OUT = pathlib.Path("build/eva")
EXPLAINED = pathlib.Path("test/eva/explained.tsv")
INCLUDES = ["include", "src/core", "test/eva"]

# Keeps the states of different paths apart, also across calls: slow but exact.
SPLIT = ["-eva-interprocedural-splits", "-eva-split-limit", "300",
         "-eva-partition-history", "1", "-eva-interprocedural-history"]
PACKET = ["-eva-precision", "3", "-eva-slevel", "20000", "-eva-min-loop-unroll", "52",
          "-eva-domains", "octagon,equality", *SPLIT]

# name: the entry point is eva_<name>; its file in test/eva; the analysed sources; options
ANALYSES = {
    "ring": ("ring.c", [], []),
    "parser": ("parser.c", ["src/core/parser.c"], []),
    "packet_whole": ("packet.c", ["src/core/packet.c"], PACKET),
    "packet_step": ("packet.c", ["src/core/packet.c"], PACKET),
    "packet_sync_add": ("packet.c", ["src/core/packet.c"],
                        [*PACKET, "-eva-partition-history", "2"]),
    "link": ("link.c", [], ["-eva-precision", "2", *SPLIT[:3]]),  # link.c includes src/core/link.c
    "bus": ("bus.c", ["src/core/%s.c" % name for name in ("bus", "link", "parser", "packet", "rest")],
            ["-eva-precision", "3", *SPLIT]),
}


def command(name, report):
    entry, sources, options = ANALYSES[name]
    flags = " ".join("-I" + folder for folder in INCLUDES)
    return ["frama-c", "-load-script", "test/eva/machdep.ml", "-machdep", "avr",
            "-cpp-extra-args=%s -include test/eva/machdep.h" % flags,
            "-no-asm-contracts", "-warn-invalid-pointer", "-eva", "-eva-no-print", *options,
            "-main", "eva_" + name, "test/eva/" + entry, *sources,
            "-then", "-report-csv", str(report), "-report-no-proven"]


def fail(text):
    sys.exit("eva: " + text)


def check_assembler(sources):
    """Eva ignores inline assembler: that is right only while its text is empty."""
    for path in sources:
        for text in re.findall(r"__asm__\s*(?:__volatile__|volatile)?\s*\(([^:)]*)", path.read_text()):
            if text.strip() != '""':
                fail("%s: __asm__ with instructions, which Eva ignores: replace them under __FRAMAC__" % path)


def explained():
    """{(file, function, kind): number of alarms} of the list."""
    lines = [line for line in EXPLAINED.read_text().splitlines() if line and not line.startswith("#")]
    alarms = {}
    for line in lines:
        fields = line.split("\t")
        if len(fields) != 5 or not fields[4].strip():
            fail("%s: not file, function, kind, number, reason: %s" % (EXPLAINED, line))
        alarms[tuple(fields[:3])] = int(fields[3])
    return alarms


def analyse(name):
    """Runs one analysis; returns its alarms as {(file, function, kind): [text]}."""
    report, log = OUT / (name + ".csv"), OUT / (name + ".log")
    report.unlink(missing_ok=True)
    began = time.monotonic()
    with log.open("w") as out:
        status = subprocess.run(command(name, report), stdout=out, stderr=subprocess.STDOUT).returncode
    text = log.read_text()
    reached = re.search(r"\((?:out of \d+)\): (\d+)% coverage\.\s*In these functions, "
                        r"(\d+) statements reached \(out of (\d+)\)", text)
    if status or not reached or not report.exists():
        fail("%s: Frama-C has failed, see %s" % (name, log))
    alarms = collections.defaultdict(list)
    for row in csv.DictReader(report.open(), delimiter="\t"):
        path = "%s/%s" % (row["directory"], row["file"])
        where = "%s:%s" % (path, row["line"])
        alarms[path, row["function"], row["property kind"]].append(
            "%s: %s: %s (%s): %s" % (where, row["function"], row["property kind"], row["status"], row["property"]))
    ends = "NON TERMINATING" not in text
    print("  %-16s %3d alarms, %s of %s statements reached, %3.0f s" % (
        name, sum(map(len, alarms.values())), reached[2], reached[3], time.monotonic() - began), flush=True)
    if not ends:
        fail("%s: the entry point does not return: see %s" % (name, log))
    return alarms


def main():
    names = sys.argv[1:] or list(ANALYSES)
    for name in names:
        if name not in ANALYSES:
            fail("no analysis '%s'; there are: %s" % (name, " ".join(ANALYSES)))
    OUT.mkdir(parents=True, exist_ok=True)
    check_assembler([*pathlib.Path("include").rglob("*.h"), *pathlib.Path("src/core").rglob("*.[ch]")])
    found = collections.defaultdict(set)
    for name in names:
        for key, texts in analyse(name).items():
            found[key].update(texts)
    listed, wrong = explained(), 0
    for key, texts in sorted(found.items()):
        if len(texts) > listed.get(key, 0):
            wrong += 1
            print("%d of these alarms are explained in %s:" % (listed.get(key, 0), EXPLAINED))
            print("\n".join("  " + text for text in sorted(texts)))
    if names == list(ANALYSES):
        for key, count in sorted(listed.items()):
            if len(found.get(key, ())) < count:
                wrong += 1
                print("%s: %s: listed %d, came %d: take it off the list" % (
                    EXPLAINED, " ".join(key), count, len(found.get(key, ()))))
    if wrong:
        sys.exit(1)


main()
