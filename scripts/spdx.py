#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Each source file names its licence: one line at its top, behind #! if there is one.

usage: spdx.py [--add]    Prints the files of git that lack the line; exit 1 if there is one. --add: adds it
"""
import pathlib
import subprocess
import sys

TEXT = "SPDX-License-Identifier: MIT"
HASH, STAR = f"# {TEXT}", f"/* {TEXT} */"
LINES = {
    ".c": STAR, ".cpp": STAR, ".h": STAR, ".ino": STAR, ".ld": STAR, ".S": STAR,
    ".cmake": HASH, ".gp": HASH, ".in": HASH, ".mk": HASH, ".pc": HASH, ".properties": HASH, ".py": HASH,
    ".script": HASH, ".sh": HASH, ".yml": HASH, "CMakeLists.txt": HASH, "Doxyfile": HASH, "Makefile": HASH,
    ".ml": f"(* {TEXT} *)", ".1": f'.\\" {TEXT}', ".html": f"<!-- {TEXT} -->", ".js": f"// {TEXT}", ".css": STAR,
}


def line_of(path):
    """The line that the file must have, or None: it is no source."""
    return LINES.get(path.name) or LINES.get(path.suffix)


def files():
    names = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], check=True,
                           stdout=subprocess.PIPE, text=True).stdout.splitlines()
    return [path for path in map(pathlib.Path, names) if path.is_file() and line_of(path)]


def place(path):
    """(lines of the file, where the line belongs, whether it is there)"""
    lines = path.read_text().splitlines(keepends=True)
    first = lines[0] if lines else ""
    at = 1 if first.startswith(("#!", "<!DOCTYPE", "<!doctype")) else 0
    return lines, at, lines[at:at + 1] == [line_of(path) + "\n"]


def main(arguments):
    missing = []
    for path in files():
        lines, at, is_there = place(path)
        if is_there:
            continue
        if arguments == ["--add"]:
            path.write_text("".join(lines[:at] + [line_of(path) + "\n"] + lines[at:]))
        else:
            missing.append(f"{path}: line {at + 1} must be: {line_of(path)}")
    print(*missing, sep="\n", end="\n" if missing else "")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
