#!/usr/bin/env python3
"""docs/registers.md from the control table in include/cds55xx/control_table.h. Prints the document."""
import re

ROW = re.compile(r"X\((\w+),\s*(\w+),\s*(\d),\s*(\w+),\s*(\w+),\s*(\w+),\s*(\w+),\s*(\w+)\)")


def main():
    text = open("include/cds55xx/control_table.h").read()
    print("# Registers\n")
    print("The control table of a CDS55xx as library and console name it (`CDS_REG_ID`, `ID`). Words are")
    print("low byte first. Initial: factory value (EEPROM) or value at power-up (RAM). Written by")
    print("`make docs` from `include/cds55xx/control_table.h`.\n")
    print("| address | name | bytes | access | area | initial | range |")
    print("|---|---|---|---|---|---|---|")
    for name, address, width, access, area, initial, lowest, highest in ROW.findall(text):
        access = {"NO": "-", "RD": "read", "RW": "read, write"}[access]
        span = f"{int(lowest, 0)} to {int(highest, 0)}"
        print(f"| {address} | `{name}` | {width} | {access} | {area} | {int(initial, 0)} | {span} |")


if __name__ == "__main__":
    main()
