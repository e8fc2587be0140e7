#!/usr/bin/env python3
"""What the flash of a firmware is made of: bytes by folder and file, as the linked ELF's debug information
has them. An instruction belongs to the file of its source line, also where a function was copied into
its caller; a table, to the file that defines it, and stands in the second column, too. The rest is of no
file: the vectors, start-up code, libgcc and avr-libc, and tables that the compiler made. All of it together
is what avr-size says. How small xz packs it shows how much it repeats itself: what writing the same program
more densely could gain at the very most.

usage: size-map.py ELF
"""
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
BEFORE = "vectors and start-up"


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
    """(address, bytes, file) of each that has a size; the file is None where it is not known."""
    for line in output("avr-nm", "--line-numbers", "--print-size", elf).splitlines():
        symbol, _, place = line.partition("\t")
        words = symbol.split()
        if len(words) == 4:
            yield int(words[0], 16), int(words[1], 16), file_of(place.rpartition(":")[0])


def files_of_code(elf, start, size):
    """The file of each word from `start` on."""
    asked = "\n".join(hex(address) for address in range(start, start + size, 2))
    lines = output("avr-addr2line", "-e", elf, input=asked).splitlines()
    return [file_of(line.rpartition(":")[0]) for line in lines]


def counted(elf):
    """Bytes of flash by file, and how many of them are tables."""
    found = sections(elf)
    owners = {}
    for name, (start, size) in found.items():
        for address in range(start, start + size):
            owners[address] = BEFORE if name == ".text" else ELSEWHERE
    for address, size, file in symbols(elf):
        for byte in range(address, address + size):
            if byte in owners:
                owners[byte] = file or ELSEWHERE
    tables = collections.Counter(owners.values())
    start, size = found[".text"]
    for word, file in enumerate(files_of_code(elf, start, size)):
        for byte in (start + 2 * word, start + 2 * word + 1) if file else ():
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
