#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""docs/settings.md from the table of settings in src/controller/robot/settings.h. Prints the document."""
import re

TEXT = open("src/controller/robot/settings.h").read().replace("\\\n", " ")
ROW = re.compile(r'X\((\w+),\s*(\d),\s*(\d+),\s*(\d+),\s*(\d+),\s*"([^"]*)",\s*((?:"[^"]*"\s*)+)\)')


def rows():
    """(name, bytes, default, lowest, highest, unit, what) of each setting, in the order of their numbers."""
    for row in ROW.findall(TEXT):
        yield (*row[:-1], "".join(re.findall(r'"([^"]*)"', row[-1])))


def main():
    version = re.search(r"SETTINGS_VERSION = (\d+)", TEXT)[1]
    print("# Settings\n")
    print("What the controller keeps without power, by name (console: `settings NAME VALUE`, then `save`) and by")
    print("number. `make docs` writes this page from `src/controller/robot/settings.h`. Version of the record in the")
    print(f"EEPROM: {version}.\n")
    print("| number | name | bytes | default | range | unit | what |")
    print("|---|---|---|---|---|---|---|")
    for number, (name, size, initial, lowest, highest, unit, what) in enumerate(rows()):
        print(f"| {number} | `{name}` | {size} | {initial} | {lowest} to {highest} | {unit} | {what} |")
    print("""
- The console also takes the rates in bits per second: `settings bus_baud 500000`.
- A new value is in force at once. A new `host_baud` is in force 4 ms after its `ok`: wait 10 ms before the next byte.
- Only `save` keeps a value. A reset other than power-on keeps `bus_baud`, too ([safety.md](safety.md#resets)). Without `save`,
  a `host_baud` that the PC cannot do is gone after the next power-off.
- `defaults` brings back the defaults above; `save` keeps them.
- `settings autostart NAME [loop] [TIME]` is no row of this table: it names the stored sequence that plays after power-on. It is
  kept at once, without `save`, and `defaults` does not change it. `settings autostart` shows it, `settings autostart off`
  ends it: [motion.md](motion.md#6-without-a-pc).
- A saved `host_baud` that no terminal can do is undone by three presses of Enter after a reset, at the rate of the board:
  [console.md](console.md#if-the-console-no-longer-answers). `host_baud` is then 255, and `save` keeps that.

## What an update of the firmware does

The settings survive an update if the programmer does not erase the EEPROM. A boot loader does not erase it
(`arduino-mega`). An ISP programmer erases the chip with its EEPROM, unless the fuse EESAVE is programmed: `make fuses`
programs it on `atmega128`. On other boards note the output of `settings` before such an update.

New settings are added at the end of the table; numbers, sizes and order stay. After a reset `settings` and `status` print
one of these:

| settings at start | the newest record has | this firmware uses |
|---|---|---|
| `as saved` | these settings | all of them |
| `older firmware; new ones: defaults` | only the first of these settings | the saved ones, and the defaults of the others |
| `saved by a newer firmware` | these settings and some that this firmware does not know | those that it knows |
| `as saved; one out of range: default` | a value that this firmware does not allow | its default, and all others as saved |
| `defaults: ...` | nothing that can be read | the defaults |

After a `save`, `settings` and `status` print its result in place of this text: `saved settings: ...`. In mode `person` they
add `; the present ones are not saved` if the next start has others
(not on `atmega1284p`, nor in the profile `console`).

After a step back to an older firmware, `save` keeps the settings that only the newer firmware knows; the newer firmware
finds them again. `defaults` does not change them either.

## The record

The EEPROM has two places for a record. A record has version, length, sequence number, the values in this order (words
low byte first), and a CRC-16 over all of that (CRC-16/MCRF4XX).

- The length counts the bytes of the values. A record that is shorter or longer than the table is read as far as both go.
- The version says how the values are arranged. It stays while settings are only added at the end. A record of another
  version is not read.
- A new record replaces the older one of the two, and its version is written last. So the old or the new record is whole,
  whenever the power fails.""")


if __name__ == "__main__":
    main()
