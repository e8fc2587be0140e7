#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What a board's two files lack, and values of macros of this project that are no word, all of it in one line; prints
nothing if there are none. Other macros of board.h are the user's own, and may have any value.
make asks it about BOARD_DIR and BOARD before it compiles. The compiler checks the values (cds55xx/avr/board_check.h).

usage: board.py FOLDER [PROGRAM.c]

PROGRAM.c: what runs on the board, if board.mk names no FIRMWARE.
"""
import pathlib
import re
import sys

# Macros of board.h that compiler or simulator read.
READ = re.compile(r"BOARD_(BUS_COUNT|CLOCK_TIMER|HOST_USART|HOST_BAUD|"
                  r"BUS\d_(USART|WIRING|((RX|TX)D|((RX|TX)_)?ENABLE)_(PORT|BIT)))")
PINS = {"TWO_ENABLES": ["RXD", "TXD", "TX_ENABLE", "RX_ENABLE"], "ONE_ENABLE": ["RXD", "TXD", "ENABLE"],
        "TIED": ["RXD", "TXD"], "ADAPTER": ["RXD", "TXD"], "ADAPTER_ECHO": ["RXD", "TXD"]}


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
    if not has_firmware:
        wanted += ["BOARD_HOST_USART", "BOARD_HOST_BAUD"]
    missing = [name for name in wanted if name not in macros]
    if "BOARD_HOST_USART" in missing:
        missing.append("or, without a host link, FIRMWARE in board.mk")
    return missing


def complaint(folder, program):
    if not folder.is_dir():
        return f"{folder} is no folder"
    absent = [name for name in ["board.mk", "board.h"] if not (folder / name).is_file()]
    if absent:
        return f"{folder} lacks {' and '.join(absent)}"
    fields = values(folder / "board.mk", r"^[ \t]*(\w+)[ \t]*[:?]?=[ \t]*([^\s#].*)$")
    has_firmware = bool(program) or "FIRMWARE" in fields
    macros = values(folder / "board.h", r"^[ \t]*#[ \t]*define[ \t]+(BOARD_\w+)[ \t]+(\S+)")
    parts = [f"{name}: {', '.join(missing)}" for name, missing in
             [("board.mk", [] if "MCU" in fields else ["MCU"]),
              ("board.h", missing_in_header(macros, has_firmware))] if missing]
    if parts:
        return f"{folder} lacks {'; '.join(parts)}"
    # The compiler would report each use of such a value.
    return ", ".join(f"{folder}/board.h: {name} is {value}; use a number, a letter or a word, without quotes"
                     for name, value in macros.items() if READ.fullmatch(name) and not re.fullmatch(r"\w+", value))


if __name__ == "__main__":
    found = complaint(pathlib.Path(sys.argv[1]), sys.argv[2:])
    if found:
        print(found + " (CONTRIBUTING.md, Add a board)")
