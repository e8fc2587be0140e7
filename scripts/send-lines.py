#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
r"""Sends the lines of a file to the console, each after the reply to the line before: poses and sequences of another
robot (docs/motion.md), or a backup of servos. Ends at the first error. The file may be what a terminal has shown:
prompts, `ok` and lines that begin with # are left out. What the console replies to a line is printed behind it. No other
program may have the port open: close picocom first. The console is then in mode program: `mode person` brings the
prompt back. `make install` installs this program as cds55xx-send-lines.

    scripts/send-lines.py [--replies] /dev/ttyUSB0 poses.txt [BAUD]    BAUD: 115200 if not given; of the CM-510 57600

With --replies the lines of each reply, without its `ok`, go to stdout, and the progress goes to stderr. This saves what
the controller stores in a file that this program and the control panel read:

    printf 'pose show\nsequence show\n' | scripts/send-lines.py --replies /dev/ttyUSB0 /dev/stdin > poses.txt

`within MS` at the end of a line is the longest time without a byte of its reply: 10000 if not given, an hour for
`motion wait`. It is not sent."""
import getpass
import grp
import os
import pathlib
import re
import select
import sys
import termios
import tty

PATIENCE_MS = 10000  # longer than the console takes for most lines
LONG_MS = {"motion wait": 3600000}
RATE = 115200
# The reply to an unknown command names it. Each try has a word of its own, which no other line has.
HELLO, HELLO_REPLY = "hello{}", "error 30: 'hello{}'"
HELLO_TRIES, HELLO_MS = 5, 500  # a line that comes while an earlier command still runs may be lost


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


class Console:
    def __init__(self, port):
        self.port = port
        self.received = b""

    def send(self, line):
        os.write(self.port, line.encode() + b"\r")

    def reply(self, within_ms):
        """The line `ok` or `error` of the next reply, and the lines before it. None: no byte within the time."""
        while not (end := re.search(rb"(?:^|\n)(ok|error \d.*)\r\n", self.received)):
            read = select.select([self.port], [], [], within_ms / 1000)[0] and os.read(self.port, 1000)
            if not read:
                return None, ""
            self.received += read
        said, self.received = self.received[:end.start(1)], self.received[end.end():]
        return end[1].decode(), said.decode(errors="replace").replace("\r\n", "\n")

    def ask(self, line, within_ms):
        self.send(line)
        return self.reply(within_ms)

    def begin(self):
        """Ends what another program has left behind: half a line, `monitor`, a search. False: no reply."""
        if not self.ask("\x03mode program", PATIENCE_MS)[0]:
            return False
        for number in range(HELLO_TRIES):
            self.send(HELLO.format(number))
            while (reply := self.reply(HELLO_MS)[0]) and not reply.startswith(HELLO_REPLY.format(number)):
                pass
            if reply:
                return True
        return False


def limited(line):
    """A line without its `within MS`, and the time."""
    command, within = re.fullmatch(r"(.*?)(?:\s+within\s+(\d+))?", line).groups()
    return command, int(within or LONG_MS.get(" ".join(command.split()), PATIENCE_MS))


def main(path, file, rate=RATE, shows_replies=False):
    console = Console(open_port(path, rate))  # first: with both arguments exchanged, the port would be read
    try:
        shown = pathlib.Path(file).read_text().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        sys.exit(f"{file}: {error}; name a text file with lines of the console")
    lines = [line for line in (line.removeprefix(">").strip() for line in shown) if line not in ("", "ok") and line[0] != "#"]
    if not console.begin():
        sys.exit(f"no reply on {path} at {rate} bit/s: is it the console's port, at the right rate? "
                 "Another program on the port, such as picocom, takes the replies: close it")
    for number, line in enumerate(lines, 1):
        command, within_ms = limited(line)
        reply, said = console.ask(command, within_ms)
        result = "; ".join([*(() if shows_replies else said.splitlines()), reply or "no reply"])
        print(f"{number}/{len(lines)} {command}: {result}", file=sys.stderr if shows_replies else sys.stdout)
        if shows_replies:
            print(said, end="")
        if not reply:
            sys.exit(f"{file}: no reply to '{command}' in {within_ms} ms, but the console has replied before it; if it takes longer, "
                     f"write '{command} within MS'; the lines after it were not sent")
        if reply != "ok":
            sys.exit(f"{file}: '{command}' was refused; the lines after it were not sent")


if __name__ == "__main__":
    if "--help" in sys.argv:
        print(__doc__)
        sys.exit()
    arguments = [word for word in sys.argv[1:] if word != "--replies"]
    if len(arguments) not in (2, 3):
        sys.exit(__doc__)
    try:
        main(*arguments, shows_replies="--replies" in sys.argv)
    except KeyboardInterrupt:
        sys.exit("\nstopped by Ctrl-C")
