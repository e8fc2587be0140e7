#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The cycle with 50 servos at 250 Hz on an ATmega128, test/firmware/library/cycle50.c, measured.

usage: cycle.py SECONDS     of simulated time; shows how far it is, prints the figures, and fails if
                            a promise was broken
"""
import pathlib
import re
import subprocess
import sys
import tempfile

from simulator import PACKET, ROOT, SIM

ELF = ROOT / "build/atmega128/firmware/cycle50.elf"
SERVOS = 50
MHZ = 16  # cycles in a microsecond
PERIOD_US = 4000
BYTE_US = 10
READS = 3  # in each period; what is left of it has room for no more
SAFE_READS = 2  # ... with limits of all servos and the health check
FEEDBACK_REPLY = 17  # bytes
SERVOS_REPLY_US = 2  # the factory's return delay, twice register 0x05

NEVER = ["missed", "refused", "unsent", "dropped", "failed", "timeouts", "corrupt", "malformed",
         "unexpected_packets", "framing_errors", "overruns", "ring_overflows"]


class Cycle:
    """One run of so many seconds, with limits of all servos and the health check or without: .figure
    as the program says them, and what the simulator saw."""

    def __init__(self, seconds, progress=None, safe=False):
        self.seconds, self.safe = seconds, safe
        self.reads, self.busy = (SAFE_READS, 75) if safe else (READS, 80)
        elf = ELF.with_name("cycle50_safe.elf") if safe else ELF
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "eeprom").write_bytes(seconds.to_bytes(2, "little") + b"\xff" * 4094)
            command = [SIM, "firmware", elf, "--board", "atmega128", "--servos", f"1-{SERVOS}",
                       "--host", "stdout", "--seconds", str(seconds + 10), "--eeprom",
                       folder / "eeprom", "--transcript", folder / "transcript", "--mark", "B0"]
            self.run(command, progress)
            with open(folder / "transcript") as transcript:
                self.read(transcript)
        self.figure = {name: int(number) for name, number in
                       re.findall(r"^(\w+) (\d+)$", self.output, re.M)}
        summary = re.search(r"wire busy ([\d.]+) %.*^cpu: +([\d.]+) % in interrupt handlers.*"
                            r"^mark: +PB0 high ([\d.]+) %", self.output, re.M | re.S)
        self.wire, self.handlers, self.calls = map(float, summary.groups())

    def run(self, command, progress):
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                              stdin=subprocess.DEVNULL, text=True) as process:
            lines = []
            for line in process.stdout:
                lines.append(line)
                if progress and line == ".\n":
                    progress(lines.count(".\n"))
        self.status, self.output = process.returncode, "".join(lines)

    def read(self, transcript):
        """Counts the packets, and notes when which goals went out and how soon replies came."""
        self.sent = self.replies = 0
        self.goals, self.turnarounds, self.damaged = [], set(), []
        self.answered = []
        asked = None
        for line in transcript:
            match = PACKET.match(line)
            if "no packet" in line or not match:
                self.damaged.append(line)
                continue
            cycle, size = int(match[1]), int(match[4])
            if match[2] == "->in":
                self.sent += 1
                asked = cycle + size * BYTE_US * MHZ
                if match[3].startswith("FF FF FE FE 83"):
                    self.goals.append((cycle, bytes.fromhex(match[3])))
            else:
                if size == FEEDBACK_REPLY:
                    self.replies += 1
                    self.answered.append(int(match[3][6:8], 16))
                self.turnarounds.add((cycle - asked) / MHZ)

    @staticmethod
    def wave(number):
        """The positions of all servos that the program commits together."""
        waves = [(4 * number + 20 * i) % 1024 for i in range(SERVOS)]
        return [256 + (1023 - w if w & 512 else w) for w in waves]

    def jitter_us(self):
        """Of the goals; the first go out when the program has set them, outside its main loop."""
        phases = [cycle / MHZ - n * PERIOD_US for n, (cycle, _) in enumerate(self.goals)]
        return max(phases[1:]) - min(phases[1:])

    def torn(self):
        """Periods whose goals were not all of one commit."""
        return sum(self.wave(number % 65536) !=
                   [packet[8 + 5 * i] | packet[9 + 5 * i] << 8 for i in range(SERVOS)]
                   for number, (_, packet) in enumerate(self.goals))

    def promises(self):
        """(what, whether it was kept)"""
        figure, periods = self.figure, self.seconds * 1000000 // PERIOD_US
        yield "the run is good", self.status == 0
        yield "no rule of the wire broken", "rules:   none broken" in self.output
        for name in NEVER:
            yield f"{name} 0", figure[name] == 0
        yield "no damaged packet", not self.damaged
        yield f"{periods} periods", figure["periods"] == periods == len(self.goals)
        yield "all goals of a period of one commit", self.torn() == 0
        yield "goals on time to 100 us", self.jitter_us() < 100
        yield f"{self.reads} READs a period", figure["reads"] >= self.reads * (periods - 1)
        yield "every servo in its turn", self.answered == [
            1 + n % SERVOS for n in range(len(self.answered))]
        yield "feedback not older than a turn", (
            figure["oldest_us"] < (SERVOS / self.reads + 1) * PERIOD_US)
        # 16 bits each
        yield "sent as on the wire", figure["sent"] == self.sent % 65536
        if self.safe:
            yield "all servos prepared", figure["prepared"] == SERVOS
            yield "no alarm", figure["alarms"] == 0
        else:
            yield "sent: torque, goals, READs", self.sent == 1 + periods + figure["reads"]
        yield "all ended well", figure["ok"] == figure["sent"]
        yield "a reply to each READ", self.replies == figure["reads"]
        yield "replies at the stated return delay", self.turnarounds == {SERVOS_REPLY_US}
        yield "utilisation as on the wire", abs(
            figure["utilisation_permille"] / 10 - self.wire) < 1
        yield f"utilisation above {self.busy} %", figure["utilisation_permille"] > 10 * self.busy
        yield "a tenth of the CPU left", self.handlers + self.calls < 90

    def broken(self):
        return [what for what, kept in self.promises() if not kept]

    def table(self):
        figure = self.figure
        return "\n".join(f"  {name:<38}{value}" for name, value in [
            ("servos, periods of 4 ms, missed",
             f"{SERVOS}, {figure['periods']}, {figure['missed']}"),
            ("packets sent, replies, lost bytes",
             f"{self.sent}, {self.replies}, {sum(figure[n] for n in NEVER[5:])}"),
            ("return delay of the servos", f"{figure['return_delay_us']} us"),
            ("goals on the wire to within", f"{self.jitter_us():.0f} us"),
            ("oldest feedback", f"{figure['oldest_us'] / 1000:.1f} ms"),
            ("bus utilisation", f"{figure['utilisation_permille'] / 10:.1f} % by the cycle's own "
             f"count, wire busy {self.wire:.1f} %"),
            ("CPU: interrupt handlers", f"{self.handlers:.1f} %"),
            ("CPU: calls of the library", f"{self.calls:.1f} %"),
            ("CPU: left to the robot", f"{100 - self.handlers - self.calls:.1f} %"),
        ])


def main():
    seconds = int(sys.argv[1])

    def progress(done):
        end = "\r" if sys.stdout.isatty() else "\n"
        if end == "\r" or done % 10 == 0:
            print(f"  {done} of {seconds} s simulated", end=end, flush=True)

    print(f"{SERVOS} servos at 250 Hz on atmega128, {seconds} s:", flush=True)
    cycle = Cycle(seconds, progress)
    print(cycle.table())
    broken = cycle.broken()
    print("\n".join(f"BROKEN: {what}" for what in broken) or "every promise kept")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
