#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Packs the files of a folder in a ZIP. The same files give the same bytes.

usage: pack.py OUT.zip FOLDER NAME    the ZIP has one folder, NAME
"""
import pathlib
import sys
import zipfile

DATE = (2026, 1, 1, 0, 0, 0)


def pack(out, name, files):
    """Writes the ZIP `out` with one folder, `name`. files: {path in this folder: bytes}"""
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in sorted(files.items()):
            entry = zipfile.ZipInfo(f"{name}/{path}", DATE)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)


def main(out, folder, name):
    folder = pathlib.Path(folder)
    pack(out, name, {path.relative_to(folder).as_posix(): path.read_bytes()
                     for path in folder.rglob("*") if path.is_file()})


if __name__ == "__main__":
    main(*sys.argv[1:])
