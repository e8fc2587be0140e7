#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Packs the Arduino library: the class of arduino/ and the C sources of the tree, in one ZIP.

usage: arduino.py OUT.zip

The Arduino IDE gives the compiler one include path, src/ of the library, and those of all other
libraries of the sketch. So each #include of a file of ours becomes a path relative to the file that
includes it, and beside CDS55xx.h and cds55xx/ no name of ours can be met by accident.
"""
import os
import pathlib
import posixpath
import re
import sys

from pack import pack
from version import version

ROOT = pathlib.Path(__file__).resolve().parents[1]
NAME = "CDS55xx"

# folder of the tree -> folder of the library; in the order in which an #include is looked up
FOLDERS = {
    "arduino": f"src/{NAME}_internal", # but CDS55xx.h and CDS55xx.cpp: src
    "include": "src",
    "src/core": f"src/{NAME}_internal/core",
    "src/avr": f"src/{NAME}_internal/avr",
    "boards": f"src/{NAME}_internal/boards",
}
SUFFIXES = [".c", ".h", ".cpp", ".S"]
BOARDS = ["arduino-mega", "arduino-uno"]
INCLUDE = re.compile(r'^(\s*#\s*include\s*)(?:"([^"]+)"|<([^>]+)>)', re.M)
# Documents in the folder extras, and a link of a document: [text](target#place).
EXTRAS = ["arduino.md", "errors.md"]
LINK = re.compile(r"\[([^]]*)\]\(([^)#\s]+)(#[^)]*)?\)")


def sources():
    """Tree path -> library path of each source."""
    found = {}
    for folder, to in FOLDERS.items():
        for path in sorted((ROOT / folder).rglob("*")):
            name = path.relative_to(ROOT / folder)
            if path.suffix not in SUFFIXES or folder == "boards" and name.parts[0] not in BOARDS:
                continue
            is_class = folder == "arduino" and path.stem == NAME
            found[path] = pathlib.PurePosixPath("src" if is_class else to, name.as_posix())
    return found


def with_relative_includes(path, places):
    """The text of the source `path`, for its place in the library."""
    def relative(match):
        name = match[2] or match[3]
        for folder in [path.parent, *(ROOT / f for f in FOLDERS)]:
            target = folder / name
            if target in places:
                to = os.path.relpath(places[target], places[path].parent)
                return f'{match[1]}"{to}"'
        if match[2]:
            sys.exit(f"arduino.py: {path.relative_to(ROOT)} includes \"{name}\", which the library lacks")
        return match[0]

    return INCLUDE.sub(relative, path.read_text())


def without_dead_links(text):
    """The text of a document, for extras: a link to a file that the ZIP lacks names the file in the sources."""
    def words(match):
        if match[2] in EXTRAS or ":" in match[2]:
            return match[0]
        path = posixpath.normpath(f"docs/{match[2]}")
        return f"{match[1]} (`{path}` of the sources)"

    return LINK.sub(words, text)


def files():
    """Library path -> text of each file."""
    places = sources()
    texts = {to: with_relative_includes(path, places) for path, to in places.items()}
    for name in ["library.properties", "library.json"]:
        texts[name] = (ROOT / "arduino" / name).read_text().replace("@VERSION@", version())
    texts["keywords.txt"] = (ROOT / "arduino/keywords.txt").read_text()
    for name in EXTRAS:
        texts[f"extras/{name}"] = without_dead_links((ROOT / "docs" / name).read_text())
    texts["LICENSE"] = (ROOT / "LICENSE").read_text()
    for path in sorted((ROOT / "arduino/examples").glob("*/*.ino")):
        texts[path.relative_to(ROOT / "arduino").as_posix()] = path.read_text()
    return {str(to): text for to, text in texts.items()}


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    out = pathlib.Path(sys.argv[1])
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        pack(out, NAME, {name: text.encode() for name, text in files().items()})
    except OSError as error:
        sys.exit(f"arduino.py: {error.filename or out}: {error.strerror}")


if __name__ == "__main__":
    main()
