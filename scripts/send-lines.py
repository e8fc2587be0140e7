#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Sends the lines of a file to the console, each after the reply to the line before: poses and sequences of another
robot (docs/motion.md), or a backup of servos. Ends at the first error. The file may be what a terminal has shown:
prompts and `ok` are left out. `make install` installs this program as cds55xx-send-lines.

    scripts/send-lines.py /dev/ttyUSB0 poses.txt [BAUD]    BAUD: 115200 if not given; of the CM-510 57600"""
import getpass
import grp
import os
import pathlib
import re
import select
import sys
import termios
import tty

PATIENCE_S = 10  # longer than the console takes for a line
RATE = 115200


def refusal(path, error):
    """What is wrong with a port that cannot be opened, and the remedy."""
    if isinstance(error, FileNotFoundError):
        return f"{path} does not exist; plug the board in, or name its port"
    if isinstance(error, PermissionError):
        try:
            user, group = getpass.getuser(), grp.getgrgid(os.stat(path).st_gid).gr_name
        except (KeyError, OSError):
            user, group = "$USER", "dialout"
        return f"{path} may not be opened by {user}; sudo usermod -aG {group} {user}, and log in again"
    return f"{path}: {error}; name the serial port of the controller"


def open_port(path, rate):
    speed = getattr(termios, f"B{rate}", None)
    if not speed:
        sys.exit(f"{rate} is no usual rate; name one such as 57600, 115200 or 1000000")
    try:
        port = os.open(path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(port)
        attributes = termios.tcgetattr(port)
        attributes[4] = attributes[5] = speed
        termios.tcsetattr(port, termios.TCSANOW, attributes)
    except (OSError, termios.error) as error:
        sys.exit(refusal(path, error))
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
    except (OSError, UnicodeDecodeError) as error:
        sys.exit(f"{file}: {error}; name a text file with lines of the console")
    port = open_port(path, rate)
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
