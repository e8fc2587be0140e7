#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What the library costs, measured in the simulator (measure.py), beside the limits and goals of
test/benchmark/rows.tsv. Exact cycle counts: two runs agree to the digit.

usage: bench.py [--only ROW,...] [--program NAME=ELF]... [--jobs N] [--out FILE]
       bench.py --again N/M --seed S     runs every Mth job again, after FILE was written; S shifts which.
                               Exit 1 if a row differs from FILE
       bench.py --scaling      how the cost grows with the servos: build/bench-scaling.tsv and .svg
       bench.py --docs [--check]    renews the tables of README.md and docs/internals/performance.md
                               from FILE, runs nothing. --check: changes nothing, exit 1 if one is stale

Writes FILE (build/bench.tsv), prints it as a table; exit 1 when a limit is exceeded or a run went
wrong. --only runs what these rows need: isr_* then come of the program for them alone, of all programs
otherwise. --program: another ELF in place of a program, as in benchmark/read=build/atmega128/x.elf.
"""
import argparse
import concurrent.futures
import csv
import fractions
import os
import subprocess
import sys

import blocks
from measure import JOBS, MHZ, ROOT, Run, Wrong, scaling_points, worst

ROWS = ROOT / "test/benchmark/rows.tsv"
COLUMNS = "name board value unit sense limit wanted goal floor".split()


def records(path):
    with open(path) as file:
        return list(csv.DictReader(file, delimiter="\t"))


def measured(jobs, count):
    """Rows, and what went wrong."""
    with concurrent.futures.ThreadPoolExecutor(count) as pool:
        work = {name: pool.submit(JOBS[name]) for name in jobs}
    results, wrong = [], []
    for name, job in work.items():
        try:
            results.append(job.result())
        except Wrong as error:
            wrong.append(f"{name}: {error}")
    return worst(results), wrong


def number(text):
    return None if text == "-" else fractions.Fraction(text)


def shown(value, unit):
    """Cycles, bytes, ... as they are; shares and ratios to two and four places."""
    if value is None:
        return "-"
    places = {"ratio": 4, "%": 2, "us": 4, "cycles": 2, "reads": 2}.get(unit, 0)
    text = f"{float(value):.{places}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def exceeds(row, value, bound):
    """Unknown is beyond any bound."""
    bound = number(row[bound])
    if bound is None:
        return False
    if value is None:
        return True
    return value < bound if row["sense"] == "min" else value > bound


def verdict(row, value):
    """`wanted`: the limit that was asked for, where the value beside it is the nearest so far."""
    return ("OVER THE LIMIT" if exceeds(row, value, "limit") else
            f"wanted: {row['wanted']}" if exceeds(row, value, "wanted") else
            "" if exceeds(row, value, "goal") or row["goal"] == "-" else "goal")


def write(path, rows, values):
    with open(path, "w") as out:
        print(*COLUMNS, sep="\t", file=out)
        for row in rows:
            row = {**row, "value": shown(values.get(row["name"]), row["unit"])}
            print(*(row[column] for column in COLUMNS), sep="\t", file=out)


def table(rows, values):
    print(f"  {'':26}{'board':14}{'value':>11} {'unit':10}{'limit':>8}{'goal':>8}{'floor':>8}")
    for row in rows:
        value = values.get(row["name"])
        sign = "" if row["sense"] == "max" else " at least"
        print(f"  {row['name']:26}{row['board']:14}{shown(value, row['unit']):>11} {row['unit']:10}"
              f"{row['limit']:>8}{row['goal']:>8}{row['floor']:>8}{sign}  {verdict(row, value)}"
              .rstrip())


def bench(arguments):
    rows = records(ROWS)
    if arguments.only:
        names = arguments.only.split(",")
        unknown = set(names) - {row["name"] for row in rows}
        if unknown:
            sys.exit(f"bench.py: there is no row {', '.join(sorted(unknown))}")
        rows = [row for row in rows if row["name"] in names]
    wanted = {row["job"] for row in rows}
    jobs = [name for name in JOBS if name in wanted or "all" in wanted]
    values, wrong = measured(jobs, arguments.jobs)
    write(arguments.out, rows, values)
    table(rows, values)
    for text in wrong:
        print("FAILED: " + text)
    over = [row["name"] for row in rows if exceeds(row, values.get(row["name"]), "limit")]
    if over:
        print("over the limit: " + " ".join(over))
    return 1 if over or wrong else 0


def again(arguments):
    """Rows of job `all` are the worst of all jobs, so they are left out."""
    part, parts = map(int, arguments.again.split("/"))
    jobs = list(JOBS)[(part - 1 + arguments.seed) % parts::parts]
    values, wrong = measured(jobs, arguments.jobs)
    before = {row["name"]: row["value"] for row in records(arguments.out)}
    rows = [row for row in records(ROWS) if row["job"] in jobs]
    for row in rows:
        value = shown(values.get(row["name"]), row["unit"])
        if value != before[row["name"]]:
            wrong.append(f"{row['name']}: {before[row['name']]}, then {value}")
    for text in wrong:
        print("FAILED: " + text)
    print(f"{len(rows)} rows measured again, {len(wrong)} differ")
    return 1 if wrong or not rows else 0


# ---- how the cost grows -----------------------------------------------------------------------------

SERVOS = (1, 5, 10, 20, 30, 50)
SCALING = ROOT / "build/bench-scaling.tsv"


def measure_scaling(count):
    """{(name, servos): (cycles, floor)}"""
    with concurrent.futures.ThreadPoolExecutor(count) as pool:
        work = {(name, servos): pool.submit(point, servos)
                for name, point in scaling_points.items() for servos in SERVOS}
    try:
        return {key: one.result() for key, one in work.items()}
    except Wrong as error:
        sys.exit(f"FAILED: {error}")


def scaling(arguments):
    points = measure_scaling(arguments.jobs)
    with open(SCALING, "w") as out:
        print("name", "servos", "value", "unit", "floor", sep="\t", file=out)
        for (name, servos), figures in points.items():
            value, floor = (shown(cycles / fractions.Fraction(MHZ), "us") for cycles in figures)
            print(name, servos, value, "us", floor, sep="\t", file=out)
    print(SCALING.read_text(), end="")
    svg = SCALING.with_suffix(".svg")
    return subprocess.run(["gnuplot", "-e", f"table='{SCALING}'; output_file='{svg}'",
                           ROOT / "scripts/bench.gp"]).returncode


# ---- docs -------------------------------------------------------------------------------------------

DOC_COLUMNS = ("board", "value", "limit", "wanted", "goal", "floor")

def table_of(done, what, columns):
    lines = ["| | what | " + " | ".join(columns) + " |", "|---|---|" + "---|" * len(columns)]
    for row in done:
        least = "≥ " if row["sense"] == "min" else ""
        bold = "**" if exceeds(row, number(row["value"]), "limit") else ""
        cells = {**row, "value": f"{bold}{row['value']} {row['unit']}{bold}",
                 **{bound: row[bound] if row[bound] == "-" else least + row[bound]
                    for bound in ("limit", "wanted", "goal")}}
        lines.append(f"| `{row['name']}` | {what[row['name']]} | "
                     + " | ".join(cells[column] for column in columns) + " |")
    return "\n".join(lines)


# The rows of README: what a user gets, and the best of the published AVR drivers on this bench
# (docs/internals/performance.md, "Other drivers").
FOR_USERS = {
    "read_overhead_2": ("READ of 2 bytes, beyond its bytes and the return delay",
                        "190 cycles, USB2AX, which waits for the reply"),
    "sync18": ("SYNC WRITE of 18 goals, call to last stop bit; the bytes alone take 15680",
               "15724 cycles, USB2AX"),
    "irq_off_max": ("longest time with interrupts off", "53 cycles, DynamixelAX12 of matt769"),
    "absent_us": ("READ of an absent servo, until the program knows", "1090 us, USB2AX"),
    "min_flash": ("smallest program: PING, READ, WRITE, SYNC WRITE", "1576 bytes, DynamixelAX12 of matt769"),
}


def table_for_users(done):
    lines = ["| | here | best published driver |", "|---|---|---|"]
    for row in done:
        if row["name"] in FOR_USERS:
            what, best = FOR_USERS[row["name"]]
            lines.append(f"| {what} | {row['value']} {row['unit']} | {best} |")
    return "\n".join(lines)


def document(arguments):
    what = {row["name"]: row["what"] for row in records(ROWS)}
    done = records(arguments.out)
    tables = {"docs/internals/performance.md": table_of(done, what, DOC_COLUMNS), "README.md": table_for_users(done)}
    return max([blocks.renew(ROOT / path, {"make bench": table}, arguments.check) for path, table in tables.items()])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--only", default="")
    parser.add_argument("--program", action="append", default=[])
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--out", default=str(ROOT / "build/bench.tsv"))
    parser.add_argument("--again", default="")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--scaling", action="store_true")
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("--check", action="store_true")
    arguments = parser.parse_args()
    Run.programs = dict(one.split("=", 1) for one in arguments.program)
    return (again if arguments.again else scaling if arguments.scaling else document if arguments.docs else bench)(arguments)


if __name__ == "__main__":
    sys.exit(main())
