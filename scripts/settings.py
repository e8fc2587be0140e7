#!/usr/bin/env python3
"""docs/settings.md from the table of settings in src/controller/settings.h. Prints the document."""
import re

TEXT = open("src/controller/settings.h").read().replace("\\\n", " ")
ROW = re.compile(r'X\((\w+),\s*(\d),\s*(\d+),\s*(\d+),\s*(\d+),\s*"([^"]*)",\s*((?:"[^"]*"\s*)+)\)')


def main():
    version = re.search(r"SETTINGS_VERSION = (\d+)", TEXT)[1]
    print("# Settings\n")
    print("What the controller remembers without power, by name (console: `settings NAME VALUE`, `save`) and")
    print("by number. Written by `make docs` from `src/controller/settings.h`; version of the record in the")
    print(f"EEPROM: {version}.\n")
    print("| number | name | bytes | default | range | unit | what |")
    print("|---|---|---|---|---|---|---|")
    for number, row in enumerate(ROW.findall(TEXT)):
        name, size, initial, lowest, highest, unit, what = row
        what = "".join(re.findall(r'"([^"]*)"', what))
        print(f"| {number} | `{name}` | {size} | {initial} | {lowest} to {highest} | {unit} | {what} |")
    print("\nA new value counts at once, but is kept only by `save`: a host baud rate that the PC cannot do is")
    print("gone when the power has been off. `defaults` brings back those above, unsaved.\n")
    print("The EEPROM has two places for a record: version, length, sequence number, the values in this order")
    print("(words low byte first), and a CRC-16 over all of that (CRC-16/MCRF4XX). The older one gives way to")
    print("the new one, whose version is written last: whenever the power goes, the old or the new record is")
    print("whole. If neither is, or only one of another version, the values above hold, and `settings` says so.")


if __name__ == "__main__":
    main()
