#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Sends the lines of a file to the console, each after the reply to the line before: poses and sequences of another
robot (docs/motion.md), or a backup of servos. Ends at the first error. The file may be what a terminal has shown:
prompts and `ok` are left out.

    scripts/send-lines.py /dev/ttyUSB0 poses.txt [BAUD]"""
import os
import pathlib
import re
import select
import sys
import termios
import tty

PATIENCE_S = 10  # longer than the console takes for a line
RATE = 115200


def open_port(path, rate):
    port = os.open(path, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(port)
    attributes = termios.tcgetattr(port)
    attributes[4] = attributes[5] = getattr(termios, f"B{rate}")
    termios.tcsetattr(port, termios.TCSANOW, attributes)
    return port


def ask(port, line):
    """What the console replies, up to its line `ok` or `error`."""
    os.write(port, line.encode() + b"\r")
    reply = b""
    while not (end := re.search(rb"(?:^|\n)(ok|error \d.*)\r\n", reply)):
        if not select.select([port], [], [], PATIENCE_S)[0]:
            sys.exit(f"no reply to '{line}': is it the console's port, at the right rate?")
        reply += os.read(port, 1000)
    return end[1].decode()


def main(path, file, rate=RATE):
    try:
        shown = pathlib.Path(file).read_text().splitlines()
        port = open_port(path, rate)
    except (OSError, UnicodeDecodeError, termios.error, AttributeError) as error:
        sys.exit(f"{error}: name the console's port, a file of lines, and a usual rate")
    lines = [line for line in (line.removeprefix(">").strip() for line in shown) if line not in ("", "ok")]
    ask(port, "\x03mode program")
    for number, line in enumerate(lines, 1):
        reply = ask(port, line)
        print(f"{number}/{len(lines)} {line}: {reply}")
        if reply != "ok":
            sys.exit(f"{file}: '{line}' was refused; the lines after it were not sent")


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
