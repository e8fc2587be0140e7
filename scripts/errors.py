#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""docs/errors.md from the two tables of errors, include/cds55xx/result.h and
src/controller/console/errors.h, and the findings of include/cds55xx/diagnose.h. Prints the document."""
import re

ROW = re.compile(r'X\((\w+),\s*(\d+),\s*"([^"]*)",\s*"([^"]*)"\)')
SOURCES = ["include/cds55xx/result.h", "src/controller/console/errors.h"]
FINDINGS = "include/cds55xx/diagnose.h"


def rows(path):
    text = open(path).read().replace("\\\n", " ")
    text = re.sub(r'"\s*SERVO_ID\s*"', "ID", text)  # the console prints the number of the servo, if it is known
    text = re.sub(r'"\s*COMMAND_NAME\s*"', "COMMAND", text)
    return [match.groups() for match in ROW.finditer(text)]


def table(sources):
    print("| N | name | text | remedy |")
    print("|---|---|---|---|")
    texts = {}  # of each number, a row
    for source in sources:
        for name, number, text, remedy in rows(source):
            if int(number) in texts:
                raise SystemExit(f"{source}: number {number} is used twice")
            texts[int(number)] = f"| {number} | `{name}` | {text} | {remedy} |"
    for number in sorted(texts):
        print(texts[number])


def main():
    print("# Errors\n")
    print("Results of the library (`enum cds_result`) and errors of the console, which prints")
    print("`error N: text; remedy`. The profile `console` leaves the remedy to this page. `make docs` writes the page")
    print("from the tables in `include/cds55xx/result.h` and `src/controller/console/errors.h`.\n")
    table(SOURCES)
    print("\n## Findings\n")
    print("The results of a diagnosis (`enum cds_finding`), from the table in")
    print(f"`{FINDINGS}`. [diagnose.md](diagnose.md) has the order of the checks.\n")
    table([FINDINGS])


if __name__ == "__main__":
    main()
