#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Flash and static RAM of firmwares beside their budgets (-: what the chip has, less STACK bytes of RAM), and the RAM of the chip that is left to the
stack; exit 1 when one is over.

usage: size.py ELF FLASH_MAX RAM_MAX [ELF FLASH_MAX RAM_MAX ...] [--note ELF ...] [--too-large NAME ...]
Those after --note are shown without a budget; those after --too-large do not fit their chip and are not built.
X.over beside X.elf has the bytes by which its link did not fit (scripts/link.sh).
"""
import pathlib
import re
import struct
import subprocess
import sys

NOTE = ".note.gnu.avr.deviceinfo"
NOTE_HEAD = 16 # bytes before flash start and size, RAM start and size
STACK = 640


def sizes(elf):
    """(flash, ram) in bytes: .text + .data, .data + .bss + .noinit"""
    sections = {}
    for line in subprocess.check_output(["avr-size", "-A", elf], text=True).splitlines():
        words = line.split()
        if len(words) == 3 and words[1].isdigit():
            sections[words[0]] = int(words[1])
    data = sections.get(".data", 0)
    return (sections.get(".text", 0) + data,
            data + sections.get(".bss", 0) + sections.get(".noinit", 0))


def chip_of(elf):
    """(flash, RAM) in bytes, as avr-gcc's start-up code has noted them."""
    text = subprocess.check_output(["avr-objdump", "-s", "-j", NOTE, elf], text=True)
    words = re.findall(r"^ [0-9a-f]+ ((?:[0-9a-f]+ ){1,4}) ", text, re.M)
    note = bytes.fromhex("".join(words).replace(" ", ""))
    return struct.unpack_from("<4I", note, NOTE_HEAD)[1::2]


def absence(elf):
    """Why the ELF is not there, or not up to date; else None."""
    over = pathlib.Path(elf).with_suffix(".over")
    if over.exists():
        return f"does not fit, {over.read_text().strip()} bytes over"
    return None if pathlib.Path(elf).exists() else "is not built"


def split(arguments, option):
    at = arguments.index(option) if option in arguments else len(arguments)
    return arguments[:at], arguments[at + 1:]


def main(arguments):
    budgeted, absent = split(arguments, "--too-large")
    budgeted, noted = split(budgeted, "--note")
    rows = [budgeted[i:i + 3] for i in range(0, len(budgeted), 3)]
    failed = []
    print(f"  {'bytes of':<36}{'flash':>8}{'budget':>8}{'RAM':>8}{'budget':>8}{'stack':>8}")
    for elf, *limits in [*rows, *([elf] for elf in noted)]:
        name = f"{elf.replace('build/', ''):<36}"
        if why := absence(elf):
            print(f"  {name}  {why}")
            failed.append(name.strip())
            continue
        flash, ram = sizes(elf)
        chip_flash, chip_ram = chip_of(elf)
        budgets = [chip if limit == "-" else int(limit) for limit, chip in zip(limits, (chip_flash, chip_ram - STACK))]
        verdict = ""
        if any(used > budget for used, budget in zip((flash, ram), budgets)):
            verdict = "  OVER BUDGET"
            failed.append(name.strip())
        flash_max, ram_max = budgets or ("-", "-")
        print(f"  {name}{flash:>8}{flash_max:>8}{ram:>8}{ram_max:>8}{chip_ram - ram:>8}{verdict}")
    for name in absent:
        print(f"  {name:<36}  does not fit the chip")
    if failed:
        print(f"over budget, or not built: {', '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
