#!/usr/bin/env python3
"""docs/settings.md from the table of settings in src/controller/robot/settings.h. Prints the document."""
import re

TEXT = open("src/controller/robot/settings.h").read().replace("\\\n", " ")
ROW = re.compile(r'X\((\w+),\s*(\d),\s*(\d+),\s*(\d+),\s*(\d+),\s*"([^"]*)",\s*((?:"[^"]*"\s*)+)\)')


def main():
    version = re.search(r"SETTINGS_VERSION = (\d+)", TEXT)[1]
    print("# Settings\n")
    print("What the controller remembers without power, by name (console: `settings NAME VALUE`, `save`) and")
    print("by number. Written by `make docs` from `src/controller/robot/settings.h`; version of the record in the")
    print(f"EEPROM: {version}.\n")
    print("| number | name | bytes | default | range | unit | what |")
    print("|---|---|---|---|---|---|---|")
    for number, row in enumerate(ROW.findall(TEXT)):
        name, size, initial, lowest, highest, unit, what = row
        what = "".join(re.findall(r'"([^"]*)"', what))
        print(f"| {number} | `{name}` | {size} | {initial} | {lowest} to {highest} | {unit} | {what} |")
    print("\nA new value counts at once (`host_baud` from 4 ms behind its `ok` on: wait 10 ms before the next byte), but is\nkept only by `save`: a host baud rate that the PC cannot do is")
    print("gone when the power has been off. `defaults` brings back those above, unsaved.\n")
    print("""A saved `host_baud` that no terminal can do is undone with three presses of Enter after a reset, at the
board's own rate: [console.md](console.md#if-the-console-no-longer-answers). `host_baud` is then 255, and `save`
keeps that.

## What an update of the firmware does

The settings outlive an update, if the programmer leaves the EEPROM alone. A boot loader does (`arduino-mega`). An
ISP programmer erases the chip before it writes, and the EEPROM with it, unless the fuse EESAVE is programmed:
`make fuses` programs it on `atmega128`; on other boards note what `settings` says before such an update.

Settings are only ever added, at the end of the table; numbers, sizes and order stay. After a reset `settings`
and `status` say one of these:

| settings at start | the newest record has | this firmware uses |
|---|---|---|
| `as saved` | these settings | all of them |
| `as saved by an older firmware; new ones are defaults` | only the first of these settings | the saved ones, and the defaults of the others |
| `as saved by a newer firmware` | these settings and some that this firmware does not know | those that it knows |
| `as saved, but one was out of range and is its default` | a value that this firmware does not allow | its default, and all others as saved |
| `defaults: ...` | nothing that can be read | the defaults |

After a step back to an older firmware, `save` keeps the settings that only the newer firmware knows, unchanged;
the newer firmware finds them again. `defaults` does not change them either.

## The record

The EEPROM has two places for a record: version, length, sequence number, the values in this order (words low
byte first), and a CRC-16 over all of that (CRC-16/MCRF4XX). The length counts the bytes of the values; a record
that is shorter or longer than the table is read as far as both go. The version says how the values are
arranged; it stays while settings are only added at the end, and a record of another version is not read.

The older record is overwritten by the new one, whose version is written last: whenever the power fails, the old
or the new record is whole.""")


if __name__ == "__main__":
    main()
