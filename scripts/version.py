#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The version of the tree. Prints it; other scripts import version()."""
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[1]


def version():
    return re.search(r'CDS_VERSION "(.*)"', (ROOT / "include/cds55xx/version.h").read_text())[1]


if __name__ == "__main__":
    print(version())
