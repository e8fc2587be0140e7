#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""docs/registers.md from the control table in include/cds55xx/control_table.h. Prints the document."""
import re

UNIT = re.compile(r"\[CDS_REG_(\w+)\] = CDS_UNIT_(\w+),")
UNITS = {"NUMBER": "-", "MDEG": "mdeg", "MARGIN_MDEG": "mdeg", "MRPM": "mRPM",
         "SIGNED_MRPM": "mRPM, + CCW", "CPCT": "0.01 %", "SIGNED_CPCT": "0.01 %, + CCW",
         "MV": "mV", "CELSIUS": "°C", "US": "µs", "BPS": "bit/s"}
ROW = re.compile(r"X\((\w+),\s*(\w+),\s*(\d),\s*(\w+),\s*(\w+),\s*(\w+),\s*(\w+),\s*(\w+)\)")


def rows():
    """(name, address, width, access, area, initial, lowest, highest, unit) of each register."""
    text = open("include/cds55xx/control_table.h").read()
    units = dict(UNIT.findall(open("src/core/wire/units.c").read()))
    for name, address, width, access, area, initial, lowest, highest in ROW.findall(text):
        yield (name, address, int(width), access, area, int(initial, 0), int(lowest, 0), int(highest, 0),
               units.get(name, "NUMBER"))


def main():
    print("# Registers\n")
    print("The control table of a CDS55xx with the names of library and console (`CDS_REG_ID`, `ID`). Words are")
    print("low byte first. Initial: factory value (EEPROM) or value at power-up (RAM). Unit: the unit that")
    print("`units.h` converts to. `make docs` writes this page from `include/cds55xx/control_table.h`.\n")
    print("| address | name | bytes | access | area | initial | range | unit |")
    print("|---|---|---|---|---|---|---|---|")
    for name, address, width, access, area, initial, lowest, highest, unit in rows():
        access = {"NO": "-", "RD": "read", "RW": "read, write"}[access]
        print(f"| {address} | `{name}` | {width} | {access} | {area} | {initial} | {lowest} to {highest} "
              f"| {UNITS[unit]} |")


if __name__ == "__main__":
    main()
