#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Frama-C Eva shows that the analysed sources have no run-time error: no access out of bounds, no
invalid pointer, no signed overflow, no uninitialised read, no wrong shift or division.

usage: eva.py [NAME ...]   (names of ANALYSES; default: all)

Each analysis begins at the function eva_<name> of test/eva/driver.c, which calls the sources with
unknown arguments. The machine is an AVR: int and pointers have 16 bits (test/eva/machdep.ml). Eva
ignores inline assembler, so each __asm__ in an analysed source must have an empty text.

Runs as many analyses at a time as there are cores. Prints the alarms of each. Fails on any alarm, if an entry point does not return, or if an
analysis reaches fewer statements than its row of ANALYSES demands. The analyses of the bus begin at
states that an invariant allows; test/core/bus/bus_random.c checks that invariant before and after each
poll.
"""
import collections
import concurrent.futures
import csv
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

OUT = pathlib.Path("build/eva")
DRIVER = "test/eva/driver.c"
SPLIT = ["-eva-interprocedural-splits", "-eva-split-limit", "300"]
BUS_SOURCES = ["test/eva/parser_contract.c", "src/core/wire/link.c",
               *sorted(str(path) for path in pathlib.Path("src/core/bus").glob("*.c"))]
BUS = [*SPLIT, "-eva-ilevel", "64", "-eva-min-loop-unroll", "4", "-eva-domains", "symbolic-locations",
       "-eva-slevel-function", "insert:20,cancel:20"]
PARSER = ["src/core/wire/parser.c"]
PACKET = ["-eva-precision", "3", "-eva-slevel", "20000", "-eva-min-loop-unroll", "52",
          "-eva-domains", "octagon,equality", *SPLIT, "-eva-partition-history", "1",
          "-eva-interprocedural-history"]

# name: sources, flags of the preprocessor, options of Eva, statements that it must reach at least
ANALYSES = {
    "ring": ([], "", [], 60),
    "find": (PARSER, "-Dvolatile=", [], 105),
    "find_error": (PARSER, "-Dvolatile=", [*SPLIT, "-eva-slevel", "100", "-eva-split-return", "full"], 55),
    "take": (PARSER, "-Dvolatile=", [*SPLIT, "-eva-slevel", "2000", "-eva-min-loop-unroll", "58",
                                     "-eva-split-return", "full"], 110),
    "packet_whole": (["src/core/wire/packet.c"], "", PACKET, 220),
    "packet_step": (["src/core/wire/packet.c"], "", PACKET, 110),
    "packet_sync_add": (["src/core/wire/packet.c"], "", [*PACKET, "-eva-partition-history", "2"], 105),
    "link": (["src/core/wire/link.c"], "-Dvolatile=", ["-eva-precision", "2", *SPLIT], 170),
    "idle": (BUS_SOURCES, "", BUS, 950),
    "awaiting": (BUS_SOURCES, "", BUS, 740),
    "receiving": (BUS_SOURCES, "", BUS, 740),
    "calls": (BUS_SOURCES, "", BUS, 760),
    "steps": (BUS_SOURCES, "", BUS, 740),
}


class Failed(Exception):
    pass


def fail(text):
    sys.exit("eva: " + text)


def check_assembler(paths):
    """Eva ignores inline assembler: that is right only while its text is empty."""
    for path in paths:
        for text in re.findall(r"__asm__\s*(?:__volatile__|volatile)?\s*\(([^:)]*)", path.read_text()):
            if text.strip() != '""':
                fail("%s: __asm__ with instructions, which Eva ignores" % path)


def analyse(name):
    """Runs one analysis. Returns its report and the number of its alarms."""
    sources, flags, options, least = ANALYSES[name]
    report, log = OUT / (name + ".csv"), OUT / (name + ".log")
    report.unlink(missing_ok=True)
    # Frama-C compiles the script where it stands, so each analysis has its own.
    folder = OUT / name
    folder.mkdir(exist_ok=True)
    script = shutil.copy("test/eva/machdep.ml", folder)
    command = ["frama-c", "-load-script", script, "-machdep", "avr",
               "-cpp-extra-args=-Iinclude -Isrc/core -Itest/eva -include test/eva/machdep.h " + flags,
               "-kernel-warn-key", "typing:implicit-function-declaration=abort",
               "-no-asm-contracts", "-warn-invalid-pointer", "-eva", "-eva-no-print", *options,
               "-main", "eva_" + name, DRIVER, *sources,
               "-then", "-report-csv", str(report), "-report-no-proven"]
    began = time.monotonic()
    with log.open("w") as out:
        status = subprocess.run(command, stdout=out, stderr=subprocess.STDOUT).returncode
    text = log.read_text()
    reached = re.search(r"(\d+) statements reached \(out of (\d+)\)", text)
    if status or not reached or not report.exists():
        raise Failed("%s: Frama-C has failed, see %s" % (name, log))
    if "NON TERMINATING" in text:
        raise Failed("%s: the entry point does not return, see %s" % (name, log))
    alarms = collections.defaultdict(list)
    for row in csv.DictReader(report.open(), delimiter="\t"):
        path = "%s/%s" % (row["directory"], row["file"])
        alarms[path].append("%s:%s: %s: %s (%s): %s" % (
            path, row["line"], row["function"], row["property kind"], row["status"], row["property"]))
    if int(reached[1]) < least:
        raise Failed("%s: %s statements reached, at least %d are expected" % (name, reached[1], least))
    alarm_count = sum(map(len, alarms.values()))
    shown = "  %-16s %3d alarms, %4s of %4s statements reached, %3.0f s\n" % (
        name, alarm_count, reached[1], reached[2], time.monotonic() - began)
    for path in sorted(alarms):
        shown += "".join("    %s\n" % alarm for alarm in alarms[path])
    return shown, alarm_count


def main():
    names = sys.argv[1:] or list(ANALYSES)
    for name in names:
        if name not in ANALYSES:
            fail("no analysis '%s'; there are: %s" % (name, " ".join(ANALYSES)))
    OUT.mkdir(parents=True, exist_ok=True)
    # The port, include/cds55xx/avr, is not analysed.
    check_assembler([*pathlib.Path("include/cds55xx").glob("*.h"), *pathlib.Path("src/core").rglob("*.[ch]")])
    alarms = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        try:
            for shown, alarm_count in pool.map(analyse, names):
                print(shown, end="", flush=True)
                alarms += alarm_count
        except Failed as error:
            pool.shutdown(cancel_futures=True)
            fail(str(error))
    print("eva: %d analyses, %d alarms" % (len(names), alarms))
    sys.exit(alarms > 0)


main()
