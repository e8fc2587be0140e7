# SPDX-License-Identifier: MIT
"""Sessions that are typed into a terminal of tmux, and what its screen shows after each step.

A pane of tmux is the terminal of the console: the firmware runs in the simulator in real time, behind a pty. A step
waits for the text that it must bring, not for a time. What the screen shows depends on no time: the servos stand still.
"""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
SIZE = ("-x", "160", "-y", "150")
PATIENCE_S = 120  # for a machine with other work; no step of a good run comes near
# Left, Right and the other keys have their names in tmux; these have names that readers know.
TMUX_KEYS = {"Backspace": "BSpace", "Ctrl-C": "C-c", "Ctrl-X": "C-x", "Del": "DC", **{
    key: key for key in ("Enter", "Tab", "Left", "Right", "Up", "Down", "Home", "End")}}


class Tmux:
    """The console of a simulated board in a pane of a tmux server of its own."""

    def __init__(self, board, servos):
        if not shutil.which("tmux"):
            raise SystemExit("tmux is not there, in which docs/console.md types its sessions: scripts/deps.sh docs")
        self.folder = tempfile.TemporaryDirectory()
        self.simulator = subprocess.Popen(
            [ROOT / "build/host/cds55xx-sim", "firmware", ROOT / f"build/{board}/controller.elf", "--board", board,
             "--servos", servos, "--host", "pty"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            stdin=subprocess.DEVNULL)
        pty = self.simulator.stdout.readline().decode().strip()
        self.tmux("-f", "/dev/null", "new-session", "-d", *SIZE,
                  f"stty raw -echo; cat {pty} & exec cat >{pty}")

    def tmux(self, *arguments):
        environment = {**os.environ, "TERM": "xterm", "LC_ALL": "C.UTF-8"}
        environment.pop("TMUX", None)
        return subprocess.run(["tmux", "-S", f"{self.folder.name}/socket", *arguments], check=True, text=True,
                              env=environment, stdout=subprocess.PIPE).stdout

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.simulator.send_signal(signal.SIGINT)
        self.tmux("kill-server")
        self.simulator.communicate(timeout=PATIENCE_S)
        self.folder.cleanup()

    def rows(self):
        """The rows of the screen, down to the last one with text."""
        return [row.rstrip() for row in self.tmux("capture-pane", "-p").rstrip("\n").split("\n")]

    def type(self, keys):
        """`keys`: text, and names of keys in brackets: "to[Tab]"."""
        for name, text in re.findall(r"\[([\w-]+)\]|([^\[]+)", keys):
            self.tmux("send-keys", *((TMUX_KEYS[name],) if name else ("-l", "--", text)))

    def wait(self, expected, begin):
        """The rows from `begin` on, as soon as they match to their end."""
        end = time.monotonic() + PATIENCE_S
        while not re.search(rf"(?:{expected})\Z", "\n".join(rows := self.rows()[begin:])):
            if time.monotonic() > end:
                raise SystemExit(f"no {expected!r} on the terminal:\n" + "\n".join(rows))
            time.sleep(0.02)  # between two looks
        return rows


def lines(*typed, prompt=">"):
    """Steps that type whole lines, each of which ends with a prompt again."""
    return [(f"{line}[Enter]", rf"(ok|error \d+: [^\n]*(\n[^>\n][^\n]*)*)\n{prompt}") for line in typed]


def screens(steps, board="arduino-mega", servos="1-3"):
    """Types steps (keys, what the rows end with then). For each: its keys, and the rows from that line on in which it
    was typed."""
    with Tmux(board, servos) as tmux:
        tmux.type("[Enter]bus[Enter]")  # Enter shows the prompt
        tmux.wait(r"bps\nok\n>", 0)
        begin = len(tmux.rows()) - 1
        for keys, expected in steps:
            tmux.type(keys)
            rows = tmux.wait(expected, begin)
            yield keys, [re.sub(r"\d+ lines, \d+ answers missing", "N lines, M answers missing", row) for row in rows]
            if rows[-1] == ">":
                begin += len(rows) - 1


def steps_shown(steps, servos="1-3"):
    """For a document: each step as `typed: KEYS` and the rows of the screen."""
    return "\n".join("\n".join([f"typed: {keys}", *rows, ""]) for keys, rows in screens(steps, servos=servos))


def lines_shown(typed, servos="1-3"):
    """For a document: what the screen shows in the end."""
    return "".join(row + "\n" for _, rows in screens(lines(*typed), servos=servos) for row in rows[:-1])
