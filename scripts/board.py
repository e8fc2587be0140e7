#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What a board's two files lack, names in them that are typing errors, and values of macros of this project that are no word, all
of it in one line; prints nothing if there are none. Other macros of board.h are the user's own, and may have any value.
make asks it about BOARD_DIR and BOARD before it compiles. The compiler checks the values (cds55xx/avr/board_check.h).

usage: board.py FOLDER [PROGRAM.c]

PROGRAM.c: what runs on the board, if board.mk names no FIRMWARE.
"""
import difflib
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]

PINS = {"TWO_ENABLES": ["RXD", "TXD", "TX_ENABLE", "RX_ENABLE"], "ONE_ENABLE": ["RXD", "TXD", "ENABLE"],
        "TIED": ["RXD", "TXD"], "ADAPTER": ["RXD", "TXD"], "ADAPTER_ECHO": ["RXD", "TXD"]}
HOST = ["BOARD_HOST_USART", "BOARD_HOST_BAUD"]
# Macros of board.h that compiler or simulator read.
READ = ["BOARD_BUS_COUNT", "BOARD_CLOCK_TIMER", *HOST, "BOARD_MCU", "BOARD_F_CPU",
        *(f"BOARD_BUS{bus}_{key}" for bus in range(3) for key in [
            "USART", "WIRING",
            *(f"{pin}_{end}" for pin in ["RXD", "TXD", "TX_ENABLE", "RX_ENABLE", "ENABLE"] for end in ["PORT", "BIT"])])]
# How similar a macro of board.h is to one of READ if it is a typing error, and not a macro of the user's own: from 0 to 1. Names that
# begin with BOARD_BUSn_ are not the user's, so any similarity will do.
TYPING_ERROR = 0.9

# Values that avr/io.h defines, or that the data sheet has, in place of the letter or digit in them: (end of the macro, value).
NAMES = [("_PORT", r"(?:PORT|DDR|PIN|P)([A-L])[0-7]?"), ("_BIT", r"(?:PORT|DD|PIN|P)[A-L]([0-7])"),
         ("_USART", r"(?:USART|UART|UDR)([0-3])"), ("_TIMER", r"(?:TIMER|TCNT|TC)([0-5])")]


def values(path, pattern):
    return dict(re.findall(pattern, path.read_text(), re.M))


def of_bus(macros, bus):
    """The macros that bus number `bus` needs."""
    wiring = macros.get(f"BOARD_BUS{bus}_WIRING", "TWO_ENABLES")
    yield f"BOARD_BUS{bus}_USART"
    for pin in PINS.get(wiring, PINS["TIED"]):
        yield f"BOARD_BUS{bus}_{pin}_PORT"
        yield f"BOARD_BUS{bus}_{pin}_BIT"


def missing_in_header(macros, has_firmware):
    count = macros.get("BOARD_BUS_COUNT", "1")
    wanted = ["BOARD_BUS_COUNT"]
    for bus in range(int(count) if count in "123" else 1):
        wanted += of_bus(macros, bus)
    wanted.append("BOARD_CLOCK_TIMER")
    if not has_firmware or any(name in macros for name in HOST):
        wanted += HOST
    missing = [name for name in wanted if name not in macros]
    if "BOARD_HOST_USART" in missing and not has_firmware:
        missing.append("or, without a host link, FIRMWARE in board.mk")
    return missing


def misspelt(folder):
    """Yields (file, name, the name that is meant or None). A macro of board.h that is like none of READ is the user's own, and so is
    a variable of board.mk that the file itself uses."""
    header, chip = (folder / name for name in ["board.h", "board.mk"])
    for name in re.findall(r"^[ \t]*#[ \t]*define[ \t]+(BOARD_\w+)", header.read_text(), re.M | re.I):
        bus = re.match(r"BOARD_BUS\d_", name)
        candidates = [known for known in READ if not bus or known.startswith(bus[0])]
        similar = difflib.get_close_matches(name.upper(), candidates, 1, 0.6 if bus else TYPING_ERROR)
        if name not in READ and (bus or similar):
            yield header, name, similar[0] if similar else None
    fields = re.search(r"^BOARD_FIELDS := (.*)$", (ROOT / "mk/avr.mk").read_text(), re.M)[1].split()
    text = chip.read_text()
    for name in dict.fromkeys(re.findall(r"^[ \t]*(?:export[ \t]+|override[ \t]+)*([\w-]+)[ \t]*[:?+!]*=", text, re.M)):
        if name not in fields and not re.search(rf"\$[({{]{name}[)}}]", text):
            yield chip, name, next(iter(difflib.get_close_matches(name.upper(), fields, 1)), None)


def told(file, name, meant):
    advice = f"did you mean {meant}?" if meant else "remove this line, which has no effect"
    return f"{file}: {name} is unknown; {advice}"


def wrong_value(name, value):
    """What is wrong with the value of a macro of READ, or None. The compiler would report each use of such a value."""
    if not re.fullmatch(r"\w+", value):
        return "use a number, a letter or a word, without quotes"
    found = [match[1] for end, pattern in NAMES if name.endswith(end) and (match := re.fullmatch(pattern, value))]
    if found:
        return f"write {found[0]}"
    if re.fullmatch(r"(PORT|DDR|PIN)[A-L]", value):
        return "write a number"
    return None


def complaint(folder, program):
    if not folder.is_dir():
        return f"{folder} is no folder"
    absent = [name for name in ["board.mk", "board.h"] if not (folder / name).is_file()]
    if absent:
        return f"{folder} lacks {' and '.join(absent)}"
    fields = values(folder / "board.mk", r"^[ \t]*(\w+)[ \t]*[:?]?=[ \t]*([^\s#].*)$")
    has_firmware = bool(program) or "FIRMWARE" in fields
    macros = values(folder / "board.h", r"^[ \t]*#[ \t]*define[ \t]+(BOARD_\w+)[ \t]+(\S+)")
    unknown = list(misspelt(folder))
    # The right name of a typing error is not missing, too.
    given = {**macros, **{meant: "" for file, _, meant in unknown if file.name == "board.h"}}
    lacks = [("board.mk", [] if "MCU" in {*fields, *(meant for _, _, meant in unknown)} else ["MCU"]),
             ("board.h", missing_in_header(given, has_firmware))]
    parts = [told(*row) for row in unknown]
    if any(missing for _, missing in lacks):
        parts.append(f"{folder} lacks " + "; ".join(f"{name}: {', '.join(missing)}" for name, missing in lacks if missing))
    if not parts:
        wrong = {name: wrong_value(name, value) for name, value in macros.items() if name in READ}
        parts = [f"{folder}/board.h: {name} is {macros[name]}; {advice}" for name, advice in wrong.items() if advice]
    return ", ".join(parts)


if __name__ == "__main__":
    found = complaint(pathlib.Path(sys.argv[1]), sys.argv[2:])
    if found:
        print(found + " (docs/linking.md, A board of your own)")
