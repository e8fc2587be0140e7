"""Runs the simulator for the tests of whole runs."""
import os
import pathlib
import re
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIM = ROOT / "build/host/cds55xx-sim"
PACKET = re.compile(r"^\s*(\d+)(?: bus\d)? (->in|<-out): ((?:[0-9A-F]{2} ?)+)\(LEN:(\d{3})\)")


LONG = os.environ.get("TEST_LONG") == "1"  # make test-long


def call(*command, **options):
    """(exit status, all output) of a command."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          stdin=subprocess.DEVNULL, **options)
    return done.returncode, done.stdout


class Run:
    """One run: .status, .output, and .packets as (cycle, "->in" or "<-out", "FF FF ...")."""

    def __init__(self, elf, *options, board="atmega128", servos="1", script=None):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            transcript = folder / "transcript.txt"
            command = [SIM, "firmware", ROOT / elf, "--board", board, "--servos", servos,
                       "--transcript", transcript, *options]
            if script is not None:
                (folder / "script").write_text(script)
                command += ["--script", folder / "script"]
            done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  stdin=subprocess.DEVNULL, cwd=ROOT)
            self.status = done.returncode
            self.output = done.stdout.decode(errors="replace")
            self.transcript = transcript.read_text() if transcript.exists() else ""
        self.packets = [(int(m[1]), m[2], m[3].strip())
                        for m in map(PACKET.match, self.transcript.splitlines()) if m]


def controller(script, board="atmega128", servos="1", *options):
    """The firmware with a console script; `board` may be a folder too."""
    name = board.rsplit("/", 1)[-1]
    return Run(f"build/{name}/controller.elf", *options, board=board, servos=servos, script=script)
