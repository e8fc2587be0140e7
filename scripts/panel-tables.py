#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The tables of the control panel as JSON: registers, units, errors, findings, commands, registers of the device,
settings, version. They come from the same tables as docs/*.md, and hold only what the page shows: each browser loads
them. Prints the JSON."""
import json
import re

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
MOTION_ERRORS = {*map(str, range(1, 20)), *enum_numbers("src/controller/robot/robot.h", "robot_refusal"),
                 *enum_numbers("src/controller/robot/motion_start.h", "motion_refusal")}

# Errors of a line that only a user types. The page shows the reply to such a line as it is.
TYPED_ERRORS = {"0", "6", "20", "22", "23", *map(str, range(30, 40)), "41", "42", "44", "46", "53", "56", "60"}

# Errors that only the library returns. A motion sends no packet that is too long (6).
LIBRARY_ERRORS = {"1", "4", "6"}

IN_MOTION = "in the view Motion"
IN_CONSOLE = "by the console of the view Packets"

# Remedies that name parts of the page. The page shows them in place of those of the console.
REMEDIES = {
    "5": "use a value within the range",
    "7": "mend the value or address; a locked servo needs its power off",
    "8": "try again",
    "10": f"send “write ID STATUS_RETURN_LEVEL 2” {IN_CONSOLE}",
    "11": "keep within its angle limits and those of the command “limits”",
    "12": "look for heat, overload or lost power, then press “Release”",
    "13": "raise its RETURN_DELAY; the view Board shows the lowest value",
    "40": f"18 servos at most: unplug one, then send “servos forget” {IN_CONSOLE}",
    "43": f"send “cycle off” {IN_CONSOLE}",
    "45": f"choose servos {IN_MOTION}",
    "47": "switch its torque off, then set its CCW_ANGLE_LIMIT above 0 in the view Set-up",
    "48": "press “Search” in the view Set-up",
    "51": "wait a second, then search at six rates",
    "54": "remove the cause, press “Release”, then switch torque on",
    "57": f"give it more time {IN_MOTION}",
    "58": f"wait until it has ended, or press “End” {IN_MOTION}",
    "64": "try again in a second",
    "65": "press “Release”",
    "75": f"press “Store on the board” {IN_MOTION}",
    "78": f"press “Store on the board” {IN_MOTION}",
    "79": f"press “Play” {IN_MOTION}",
    "81": f"press “Play” {IN_MOTION}",
    "83": "torque off, free it; or its power, limits: “Diagnosis” in the view Set-up",
    "84": f"press “Torque on” {IN_MOTION}",
    "89": "leave only the new servo connected, then press “Set up” in the view Set-up",
    "92": f"press “Resume” or “End” {IN_MOTION}",
}


# Findings in the words of an owner of a robot: what it means, and what to do in the page.
FINDINGS = {
    "1": ("the servo answers well; if it behaves badly, count the servos: another one may have the same ID", ""),
    "2": ("the signal wire stays at 0 V, so nothing can be sent",
          "look for a short circuit, a plug turned round, or a board without power"),
    "3": ("a servo or another device sends without a pause", None),
    "4": ("the controller hears its own packets, which its wiring should not allow",
          "compare the wiring with the manual of the board"),
    "6": ("replies come damaged", None),
    "7": ("the controller was too busy and lost bytes",
          "diagnose again"),
    "9": ("no servo answers at any of the six usual rates",
          "check power, plug and wiring; then search at all 255 rates"),
    "10": ("the servo answers, but not at the rate of the bus",
           "set the bus to the rate of the servo, change the servo's rate, then set the bus back"),
    "11": ("no servo has this ID, but others answer",
           "check plug and power of this servo; then press “Search”: it may have another ID"),
    "12": ("the servo answers PING only, so nothing can be read",
           f"send “write ID STATUS_RETURN_LEVEL 2” {IN_CONSOLE}"),
    "13": ("the servo answers later than the controller waits",
           "lower its RETURN_DELAY, or raise the setting return_delay in the view Board"),
    "14": ("the supply of the servo is too low (below MIN_VOLTAGE)", None),
    "15": ("the supply of the servo is too high (above MAX_VOLTAGE)", None),
    "16": ("the servo is too hot (above MAX_TEMPERATURE)", None),
    "18": ("the servo answers before the controller listens",
           f"send “write ID RETURN_DELAY 1” {IN_CONSOLE}; it takes effect although no reply comes"),
    "19": ("its MAX_TORQUE is 0",
           "set MAX_TORQUE in the view Set-up, then switch its power off and on"),
}


# Settings in the words of an owner of a robot; the page shows rates and choices as a list.
SETTINGS = {
    "device_id": "ID of the controller for this page; 254: none",
    "host_baud": "rate of the link to this page; after a change, disconnect and connect at the new rate",
    "bus_baud": "rate of the bus; only servos that have this rate answer",
    "echo": "what a terminal gets after a reset; this page uses 0",
    "link_loss_ms": "if this page is silent so long, link_loss_action follows; 0: never. "
                    "Best: 2000 and link_loss_action 2, unless sequences play without the page",
    "link_loss_action": "with 0 and 1 a movement that has begun goes on, also an endless turn",
    "alarm_report": "when a terminal is told that a servo has an alarm or is offline",
}


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
    for name, _, initial, lowest, highest, unit, what in settings.rows():
        yield {"name": name, "initial": int(initial), "lowest": int(lowest),
               "highest": int(highest), "unit": "" if unit == "-" else unit, "what": SETTINGS.get(name, what)}


def table_of_commands():
    """Each command of a profile. `name`: its first word."""
    found = {}
    for profile in ("full", "console"):
        for heading, usage, what, _, _ in console.commands(profile):
            found.setdefault(usage, {"name": usage.split()[0], "usage": usage, "heading": heading, "what": what})
    return found.values()


def table_of_errors():
    """The profile `full` sends its remedies, `console` does not: one that only `full` has is left out, unless the page has words
    of its own. So are those of TYPED_ERRORS."""
    of_full = open(errors.SOURCES[1]).read().split("#define FULL_ERRORS")[1]
    found = {}
    for source in errors.SOURCES:
        for name, number, text, remedy in errors.rows(source):
            if number in LIBRARY_ERRORS:
                continue
            if number in MOTION_ERRORS:
                found[number] = {"text": text, "remedy": REMEDIES.get(number, remedy)}
            elif number in REMEDIES or (number not in TYPED_ERRORS and f"X({name}," not in of_full):
                found[number] = {"remedy": REMEDIES.get(number, remedy)}
    return found


def table_of_findings():
    found = {}
    for _, number, text, remedy in list(errors.rows(errors.FINDINGS))[1:]:  # 0: nothing found yet
        own_text, own_remedy = FINDINGS.get(number, (text, None))
        found[number] = {"text": own_text, "remedy": remedy if own_remedy is None else own_remedy}
    return found


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
