#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Renews what the user documents quote from commands: each block that follows a line `<!-- COMMAND -->`.

usage: readme.py [--check]    --check: changes nothing, exit 1 if a block is out of date
Where COMMAND ends in `: TEXT` only the paragraph that begins with TEXT is quoted.
"""
import os
import pathlib
import re
import subprocess
import sys

BLOCK = re.compile(r"(<!-- (make [^>]*?)(?:: ([^>]*))? -->\n```\n)(.*?)(```\n)", re.S)


def cause_of(done):
    """The last lines of a failed make that are not of make itself."""
    lines = [line for text in (done.stdout, done.stderr) for line in text.splitlines() if line.strip()]
    return "\n".join([line for line in lines if not line.startswith("make")][-3:] or lines or ["no output"])


def output_of(command, start):
    words = command.split()
    words[1:1] = ["-s", "--no-print-directory", f"-j{os.cpu_count()}"]
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"readme.py: {command} failed:\n{cause_of(done)}")
    text = done.stdout
    if start:
        text = text[text.index(start):].split("\n\n")[0].rstrip("\n") + "\n"
    return text


def main(arguments):
    status = 0
    for path in [pathlib.Path("README.md"), *sorted(pathlib.Path("docs").glob("*.md"))]:
        before = path.read_text()
        after = BLOCK.sub(lambda m: m[1] + output_of(m[2], m[3]) + m[5], before)
        if after != before and arguments == ["--check"]:
            print(f"{path} quotes figures that are out of date: run make docs")
            status = 1
        elif after != before:
            path.write_text(after)
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
