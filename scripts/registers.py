#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""docs/registers.md from the control table in include/cds55xx/control_table.h. Prints the document."""
import re

UNIT = re.compile(r"\[CDS_REG_(\w+)\] = CDS_UNIT_(\w+),")
UNITS = {"NUMBER": "-", "MDEG": "mdeg", "MARGIN_MDEG": "mdeg", "MRPM": "mRPM",
         "SIGNED_MRPM": "mRPM, + CCW", "CPCT": "0.01 %", "SIGNED_CPCT": "0.01 %, + CCW",
         "MV": "mV", "CELSIUS": "°C", "US": "µs", "BPS": "bit/s"}
BIT = re.compile(r"^    CDS_ERROR_(\w+) = 0x([0-9A-F]{2}), +// (?:condition|packet): (.*)$", re.M)
MEANINGS = """
## What the values mean

- `STATUS_RETURN_LEVEL`: 0: the servo answers PING only; 1: PING and READ; 2: every packet but those to all servos.
- `LOCK`: with 1 the servo takes only 0x18 to 0x23, until its power goes off.
- `CW_ANGLE_LIMIT` and `CCW_ANGLE_LIMIT` both 0: endless turn. Then bit 10 of `MOVING_SPEED` is the direction, 1 is clockwise, and speed 0 stops.
- `GOAL_POSITION` and the `PRESENT_...` registers: the initial value 0 is the manual's. A servo with power measures its
  present values; the goal of a simulated servo is at first its present position.
- `MOVING_SPEED` with an angle limit: 0 is as fast as the supply allows.
- `ALARM_LED` and `ALARM_SHUTDOWN`: the sum of the values below. An error blinks the LED while it lasts, if its bit is set in `ALARM_LED`. It
  switches torque off until `TORQUE_ENABLE` is written 1, if its bit is set in `ALARM_SHUTDOWN`; overload lowers the torque instead. So
  `set 1 ALARM_SHUTDOWN 5` switches torque off at a wrong voltage, too.

| value | error | when |
|---|---|---|"""
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
    print(MEANINGS)
    for name, value, when in BIT.findall(open("include/cds55xx/packet.h").read()):
        if name != "NONE_SUCH":
            print(f"| {int(value, 16)} | {name.lower()} | {when} |")


if __name__ == "__main__":
    main()
