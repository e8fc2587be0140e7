#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What the flash of a firmware is made of: bytes by folder and file, as the linked ELF's debug information
has them. An instruction belongs to the file of its source line, also where a function was copied into
its caller; a table, to the file that defines it, and stands in the second column, too. These are of no
file: the vectors, start-up code, libgcc and avr-libc, and tables that the compiler made. All of it together
is what avr-size says. How small xz packs it is a hint of what writing the same program more densely
could gain.

usage: size-map.py ELF
"""
import bisect
import collections
import lzma
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
RAM = 0x800000  # addresses from here on are not flash: of .data, whose initial values are
OURS = re.compile(r"^(?!/usr/)(?:.*/)?((?:src|include|boards|examples|test)/.*)")
ELSEWHERE = "compiler and C library"
STRINGS = "strings in tables"  # FLASH_TEXT() of messages.h: symbols that the compiler names
BEFORE = "vectors and start-up"
HEADING = re.compile(r"(?:CU: )?(\S+):$")
ROW = re.compile(r"(\S+) +\d+ +(?:0x)?([0-9a-f]+)$")


def output(*command, **options):
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, **options).stdout


def file_of(path):
    """Of ours, by its path in the tree."""
    ours = OURS.search(path)
    return ours[1] if ours else None


def sections(elf):
    """Where .text and .data begin, and their bytes."""
    lines = (line.split() for line in output("avr-size", "-A", "-d", elf).splitlines())
    return {words[0]: (int(words[2]), int(words[1])) for words in lines
            if len(words) == 3 and words[0] in (".text", ".data")}


def symbols(elf):
    """(address, bytes, file, kind) of each that has a size; the file is None where it is not known."""
    for line in output("avr-nm", "--line-numbers", "--print-size", elf).splitlines():
        symbol, _, place = line.partition("\t")
        words = symbol.split()
        if len(words) == 4:
            file = STRINGS if "compound_literal" in words[3] else file_of(place.rpartition(":")[0])
            yield int(words[0], 16), int(words[1], 16), file, words[2]


def lines_of_code(elf):
    """(address, file) of each row of the line table, by address. A row has the file's name; the latest
    heading of that name has its path. What the linker has thrown away stands there at address 0."""
    rows, path, paths = [], "", {}
    for text in output("avr-objdump", "--dwarf=decodedline", elf).splitlines():
        heading, row = HEADING.match(text), ROW.match(text)
        if heading:
            path = heading[1]
            paths[pathlib.PurePath(path).name] = path
        elif row and int(row[2], 16):
            if pathlib.PurePath(path).name != row[1]:
                path = paths.get(row[1], "")
            rows.append((int(row[2], 16), file_of(path)))
    return sorted(rows, key=lambda row: row[0])


def files_of_code(elf, functions):
    """The file of each word of the `functions` (address, bytes), where it is known."""
    rows = lines_of_code(elf)
    starts = [start for start, _ in rows]
    for first, size in functions:
        for address in range(first, first + size, 2):
            row = bisect.bisect_right(starts, address) - 1
            if row >= 0 and starts[row] >= first and rows[row][1]:
                yield address, rows[row][1]


def counted(elf):
    """Bytes of flash by file, and how many of them are tables."""
    found = sections(elf)
    owners, functions = {}, []
    for name, (start, size) in found.items():
        for address in range(start, start + size):
            owners[address] = BEFORE if name == ".text" else ELSEWHERE
    for address, size, file, kind in symbols(elf):
        if kind in "tTW":
            functions.append((address, size))
        for byte in range(address, address + size):
            if byte in owners:
                owners[byte] = file or ELSEWHERE
    tables = collections.Counter(owners.values())
    for word, file in dict(files_of_code(elf, functions)).items():
        for byte in (word, word + 1):
            tables[owners[byte]] -= 1
            owners[byte] = file
    return collections.Counter(owners.values()), tables


def packed(elf):
    """Bytes of flash, as xz packs them."""
    with tempfile.NamedTemporaryFile() as image:
        output("avr-objcopy", "-O", "binary", "-R", ".eeprom", elf, image.name)
        return len(lzma.compress(pathlib.Path(image.name).read_bytes(), preset=9 | lzma.PRESET_EXTREME))


def line(size, tables, name):
    print(f"{size:>8}{tables or '-':>8}  {name}")


def main(elf):
    sizes, tables = counted(elf)
    folders = collections.defaultdict(list)
    for file, size in sizes.most_common():
        folders[file.rpartition("/")[0] or file].append(file)
    print(f"  flash  tables  bytes of {elf}")
    for folder, files in sorted(folders.items(), key=lambda of: -sum(sizes[file] for file in of[1])):
        ours = folder not in files
        line(sum(sizes[file] for file in files), sum(tables[file] for file in files) * ours, folder)
        for file in files if ours else []:
            line(sizes[file], tables[file], "  " + file.rpartition("/")[2])
    line(sum(sizes.values()), 0, "in all")
    print(f"xz packs it into {packed(elf) / 1000:.1f} KB.")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    main(sys.argv[1])
