# SPDX-License-Identifier: MIT
"""Runs the simulator for the tests of whole runs."""
import functools
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIM = ROOT / "build/host/cds55xx-sim"
PACKET = re.compile(r"^\s*(\d+)(?: bus\d)? (->in|<-out): ((?:[0-9A-F]{2} ?)+)\(LEN:(\d{3})\)")


def is_long(wanted, suite):
    """Whether a suite runs in full length. wanted: "" for none, 1 for all (make test-long), N/M for part N of M (CI)."""
    if not wanted:
        return False
    part, _, parts = wanted.partition("/")
    return zlib.adler32(suite.encode()) % int(parts or 1) == int(part) - 1  # it deals out four parts evenly


LONG = is_long(os.environ.get("TEST_LONG", ""), pathlib.Path(sys.argv[0]).stem)


def call(*command, **options):
    """(exit status, all output) of a command."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          stdin=subprocess.DEVNULL, **options)
    return done.returncode, done.stdout


# Firmware with a console. A new controller is in mode person: it prints a banner and prompts.
CONTROLLERS = ("controller.elf", "console.elf", "full.elf")


@functools.cache
def eeprom_of_program(elf, board):
    """The EEPROM of a controller that starts in mode program. A scenario sends `mode program` itself."""
    with tempfile.TemporaryDirectory() as folder:
        script, eeprom = pathlib.Path(folder, "script"), pathlib.Path(folder, "eeprom")
        script.write_text("save\n")
        status, said = call(SIM, "firmware", elf, "--board", board, "--servos", "1", "--eeprom", eeprom,
                            "--script", script)
        assert status == 0, said
        return eeprom.read_bytes()


def in_mode_program(options, folder):
    """More options of the simulator for a run with a host link: the console prints nothing but replies,
    unless `options` name an EEPROM."""
    options = [str(option) for option in options]
    elf = next((option for option in options if option.endswith(CONTROLLERS)), None)
    if elf is None or "--host" not in options or "--eeprom" in options:
        return []
    eeprom = pathlib.Path(folder, "eeprom-in-mode-program")
    eeprom.write_bytes(eeprom_of_program(elf, options[options.index("--board") + 1]))
    return ["--eeprom", eeprom]


class Run:
    """One run: .status, .output, and .packets as (cycle, "->in" or "<-out", "FF FF ...")."""

    def __init__(self, elf, *options, board="atmega128", servos="1", script=None):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            transcript = folder / "transcript.txt"
            command = [SIM, "firmware", ROOT / elf, "--board", board, "--servos", servos,
                       "--transcript", transcript, *options]
            command += in_mode_program(command[1:], folder)
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


PATIENCE_S = 60  # for what must come: longer than any busy machine takes


def cpu_ticks(process):
    """CPU time that a process has used, in clock ticks."""
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(") ", 1)[1].split()
    return int(fields[11]) + int(fields[12])


def settle(process, seconds=0, step=0.01):
    """Returns when a simulator in real time has read what was written before, and has simulated so
    long. It sleeps only when it has caught up with real time; each sleep is counted. So a busy machine
    makes this take longer and changes nothing else."""
    def sleeps():
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
        return int(re.search(r"^voluntary_ctxt_switches:\s*(\d+)", status, re.M)[1])

    for _ in range(1 + round(seconds / step)):
        before = sleeps()
        time.sleep(step)
        while process.poll() is None and sleeps() < before + 2:
            time.sleep(0.001)


class Process:
    """A simulator with a pty, in real time: .path, and .output and .status once it was ended."""

    def __init__(self, *options, stderr=subprocess.STDOUT):
        self.folder = tempfile.TemporaryDirectory()
        options = [*options, *in_mode_program(options, self.folder.name)]
        self.process = subprocess.Popen([SIM, *options], stdout=subprocess.PIPE, stderr=stderr,
                                        stdin=subprocess.DEVNULL)
        self.output = ""
        self.path = self.process.stdout.readline().decode().strip()

    def end(self, with_signal=signal.SIGTERM):
        self.process.send_signal(with_signal)
        self.output = self.process.stdout.read().decode()
        self.status = self.process.wait(PATIENCE_S)
        return self.output

    def settle(self, seconds=0, step=0.01):
        settle(self.process, seconds, step)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.end(signal.SIGKILL)
        self.process.stdout.close()
        self.folder.cleanup()


def bus(*options, servos="1-18"):
    return Process("bus", "--servos", servos, "--pty", *options)


def wait_until(condition, seconds=PATIENCE_S):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True
