#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The tables of the control panel as JSON: registers, units, errors, findings, commands, registers of the device,
settings, version. They come from the same tables as docs/*.md, and hold only what the page shows: each browser loads
them. Prints the JSON."""
import json
import re
import sys

import console
import device
import errors
import registers
import settings
from version import version

COUNTER = re.compile("BUS_(?!BAUD|STATE)|HOST_(?!BAUD)|BRIDGE_|DELAYS_")

# value = raw * per / of, in the unit of the page.
UNITS = {
    "NUMBER": {"name": "", "per": 1, "of": 1, "digits": 0},
    "MDEG": {"name": "deg", "per": 300, "of": 1023, "digits": 1},
    "MARGIN_MDEG": {"name": "deg", "per": 300, "of": 1023, "digits": 1},
    "MRPM": {"name": "rpm", "per": 62, "of": 1023, "digits": 1},
    "SIGNED_MRPM": {"name": "rpm", "per": 62, "of": 1023, "digits": 1, "signed": True},
    "CPCT": {"name": "%", "per": 100, "of": 1023, "digits": 1},
    "SIGNED_CPCT": {"name": "%", "per": 100, "of": 1023, "digits": 1, "signed": True},
    "MV": {"name": "V", "per": 1, "of": 10, "digits": 1},
    "CELSIUS": {"name": "C", "per": 1, "of": 1, "digits": 0},
    "US": {"name": "us", "per": 2, "of": 1, "digits": 0},
    "BPS": {"name": "bps", "digits": 0},  # 2 000 000 / (raw + 1)
}


def enum_numbers(header, name):
    """Numbers of the enum `name`, as text."""
    return re.findall(r"= (\d+)", re.search(rf"enum {name} {{(.*?)}}", open(header).read(), re.S)[1])


# Errors with which a motion ends: those of the library, which are below 20, and two enums of the controller. The page
# reads their number from MOTION_ERROR. It needs the text of no other error: the console sends it.
MOTION_ERRORS = {*map(str, range(20)), *enum_numbers("src/controller/robot/robot.h", "robot_refusal"),
                 *enum_numbers("src/controller/robot/motion_start.h", "motion_refusal")}

# Remedies of the console name its commands; the page has buttons, in “”.
REMEDIES = {
    "12": "check its power and plug, then press “Release” on its card in the view Robot, or beside Stop",
    "40": "the controller knows 18 servos at most: unplug one, then press “Forget the list” in the view Set-up",
    "84": "press “Torque on” in the view Motion",
}


SEARCH = "scan the bus"  # words of the console in remedies of findings; the page has a button


def table_of_registers():
    for name, address, width, access, area, _, lowest, highest, unit in registers.rows():
        if name.startswith("RESERVED"):
            continue
        yield {"name": name, "address": int(address, 0), "bytes": width, "writable": access == "RW",
               "area": area, "lowest": lowest, "highest": highest, "unit": unit}


def table_of_device():
    """A counter has `what`: what it counts."""
    for name, address, count, access, _, _, unit, what in device.rows():
        row = {"name": name, "address": int(address, 0), "bytes": int(count), "writable": access == "RW",
               "unit": "" if unit == "-" else unit}
        yield {**row, "what": what} if access != "RW" and COUNTER.match(name) else row


def table_of_settings():
    for name, size, initial, lowest, highest, unit, what in settings.rows():
        yield {"name": name, "bytes": int(size), "initial": int(initial), "lowest": int(lowest),
               "highest": int(highest), "unit": "" if unit == "-" else unit, "what": what}


def table_of_commands():
    """Each command, with the profiles that have it. `name`: its first word."""
    found = {}
    for profile in ("full", "console"):
        for heading, usage, what, _, _ in console.commands(profile):
            row = found.setdefault(usage, {"name": usage.split()[0], "usage": usage, "heading": heading,
                                           "what": what, "profiles": []})
            row["profiles"].append(profile)
    return found.values()


def table_of_errors():
    """The profile `full` sends its remedies, `console` does not: a remedy that only `full` has is left out."""
    of_full = open(errors.SOURCES[1]).read().split("#define FULL_ERRORS")[1]
    found = {}
    for source in errors.SOURCES:
        for name, number, text, remedy in errors.rows(source):
            if number in MOTION_ERRORS:
                found[number] = {"text": text, "remedy": REMEDIES.get(number, remedy)}
            elif f"X({name}," not in of_full:
                found[number] = {"remedy": REMEDIES.get(number, remedy)}
    return found


def table_of_findings():
    rows = list(errors.rows(errors.FINDINGS))
    if not any(SEARCH in remedy for *_, remedy in rows):
        sys.exit(f"panel-tables.py: no remedy of a finding says “{SEARCH}” any more: change SEARCH")
    return {number: {"text": text, "remedy": remedy.replace(SEARCH, "press “Search”")}
            for _, number, text, remedy in rows}


def main():
    print(json.dumps({
        "version": version(),
        "units": UNITS,
        "registers": list(table_of_registers()),
        "device": list(table_of_device()),
        "settings": list(table_of_settings()),
        "commands": list(table_of_commands()),
        "errors": table_of_errors(),
        "findings": table_of_findings(),
    }, indent=1))


if __name__ == "__main__":
    main()
