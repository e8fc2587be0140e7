# SPDX-License-Identifier: MIT
"""The measurements of bench.py: runs programs in the simulator and computes figures from the files
that it writes. Each function of JOBS returns rows of the benchmark, {name: value}."""
import concurrent.futures
import fractions
import functools
import itertools
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import threading

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "test/runs"), str(ROOT / "scripts")]
import boards
from client import BROADCAST, PING, READ, WRITE, packet
from feedback import Feedback
from make_list import make_list
from simulator import PACKET, SIM
from size import sizes

MHZ = 16  # cycles in a microsecond
BYTE = 160  # cycles, at 1 Mbps
RETURN_DELAY = 32  # cycles in a unit of register 0x05; factory value: 1
SYNC_WRITE = 0x83
SYNC_READ = 0x84
DEVICE, HOST_BAUD, REG_RETURN_DELAY, TORQUE, GOAL = 253, 0x04, 0x05, 0x18, 0x1E
STOP = 0x18  # Ctrl-X: it would stop the robot
ANSWERED_US = 620  # time of 8 bytes to the controller, its processing and 56 bytes back
WHOLE, CALL, POLL, SLOW, BUILD, NOTHING = 0, 1, 2, 3, 4, 7  # test/benchmark/benchmark.h
EEPROM_SIZE = {"atmega128": 4096, "arduino-mega": 4096, "arbotix": 2048}
# Vectors of the bus: RX, UDRE, TX of USART1.
VECTORS = {"atmega128": (30, 31, 32), "arduino-mega": (36, 37, 38), "arbotix": (28, 29, 30)}
HEADER = "insert out every 0 0xFF"
HANDLERS = ("isr_rx_max", "isr_udre_max", "isr_txc_max")


class Wrong(Exception):
    """A run did not do what its figures assume, so they are not valid."""


class Figures(dict):
    def __missing__(self, name):
        raise Wrong(f"the program does not print {name}")


class Run:
    """One run of a program.

    figure       {name: number} that the program prints
    sent         (start of the first start bit, end of the last stop bit, bytes, idle cycles, turnaround)
                 of each packet of the controller
    off          longest time with interrupts off, in cycles
    cycles       of the whole run
    in_handlers  cycles of the run in interrupt handlers
    longest      {vector: cycles of its longest handler}
    """

    programs = {}  # --program

    def __init__(self, elf, *options, board="atmega128", servos="1", eeprom=None, good=True,
                 keep=None, talks=True):
        self.board = board.split("/")[-1]
        elf = self.programs.get(elf, f"build/{self.board}/{elf}.elf")
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            command = [SIM, "firmware", ROOT / elf, "--board", board, "--servos", servos, "--times",
                       folder / "times", "--transcript", folder / "transcript", *options]
            if talks and "--host" not in options and "--script" not in options:
                command += ["--host", "stdout"]
            if eeprom is not None:
                kept = bytes(eeprom).ljust(EEPROM_SIZE[self.board], b"\xff")
                (folder / "eeprom").write_bytes(kept)
                command += ["--eeprom", folder / "eeprom"]
            done = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, cwd=ROOT,
                                  stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, text=True,
                                  errors="replace")
            self.what = f"{elf} on {self.board}"
            self.status, self.output = done.returncode, done.stdout
            if done.returncode == 2 or good:
                self.check(done.returncode == 0, "the run failed")
            self.figure = Figures((name, int(number)) for name, number in
                                  re.findall(r"^(\w+) (\d+)$", self.output, re.M))
            self.read((folder / "times").read_text())
            if keep:
                shutil.copy(folder / "times", keep)
            self.transcript = (folder / "transcript").read_text()

    def check(self, kept, what):
        if not kept:
            raise Wrong(f"{self.what}: {what}\n{self.output}")

    def read(self, text):
        self.sent, self.longest, steps = [], {}, {}
        for line in text.splitlines():
            word, *numbers = line.split()
            numbers = tuple(map(int, numbers))
            if word == "sent":
                self.sent.append(numbers[1:])
            elif word == "pin":
                steps.setdefault(numbers[1], []).append(numbers)
            elif word == "handler":
                self.longest[numbers[0]] = numbers[3]
            elif word == "off":
                self.off = numbers[0]
            elif word == "run":
                self.cycles, self.in_handlers = numbers[:2]
        self.steps = steps

    def spans(self, pin):
        """(cycles, cycles in handlers, start) of each time the pin was high. The cycles of the two
        instructions that change the pin do not count."""
        nothing = self.steps[NOTHING]
        mark = nothing[1][0] - nothing[0][0]
        steps = self.steps.get(pin, [])
        self.check(len(steps) > 1, f"no mark {pin}")
        return [(down[0] - up[0] - mark, down[3] - up[3], up[0] + mark)
                for up, down in zip(steps[::2], steps[1::2])]

    def net(self, pin):
        """The longest time that the pin was high, in cycles without handlers."""
        return max(cycles - handlers for cycles, handlers, _ in self.spans(pin))

    def packets(self):
        for match in map(PACKET.match, self.transcript.splitlines()):
            if match:
                yield match[2], bytes.fromhex(match[3])

    def wire(self):
        """(start of the first start bit, sent by the controller, bytes) of each packet on bus 0."""
        for match in map(PACKET.match, self.transcript.splitlines()):
            if match:
                yield int(match[1]), match[2] == "->in", bytes.fromhex(match[3])

    def broken(self, *rules):
        """How often these rules of the wire were broken."""
        return sum(int(times) for name, times in
                   re.findall(r"^(?:BROKEN|WARNING): *([\w-]+), (\d+) times", self.output, re.M)
                   if name in rules)

    def handlers(self, suffix=""):
        """Rows: the longest time of each handler of the bus."""
        return {name + suffix: self.longest.get(vector, 0)
                for name, vector in zip(HANDLERS, VECTORS[self.board])}

    def everywhere(self):
        """Rows that every run on this board contributes to: the handlers, and interrupts off."""
        return {**self.handlers(), "irq_off_max": self.off}


def worst(rows):
    """Merges rows of several runs: the highest value of each row."""
    merged = {}
    for row in rows:
        for name, value in row.items():
            merged[name] = max(value, merged.get(name, value))
    return merged


def side_by_side(measure, inputs):
    """[measure(one) for one in inputs], in parallel: a long job that is the last one uses all cores."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(measure, inputs))


# ---- jobs: each returns rows ------------------------------------------------------------------------

READ_SIZES = (1, 2, 8, 50)  # bytes; as in test/benchmark/read.c
DELAYS = 16  # return delays 2, 4, ... 32 us, each once


def overhead(size, spans):
    """Of 16 READs of `size` bytes, the most cycles besides bytes on the wire and return delay."""
    return max(cycles - (8 + 6 + size) * BYTE - RETURN_DELAY * n
               for n, (cycles, _, _) in enumerate(spans, 1))


def read():
    run = Run("benchmark/read", "--stamp", "B", "--seconds", "2")
    run.check(run.figure["good"] == 4 * DELAYS + 2 * 4 + 64, "not all were good")
    run.check(run.figure["torn"] == 0, "the clock overflowed: another handler ran")
    wholes = run.spans(WHOLE)
    run.check(len(wholes) == 4 * DELAYS, "not 16 READs of each size")
    by_size = {size: wholes[DELAYS * i:DELAYS * (i + 1)] for i, size in enumerate(READ_SIZES)}
    return {**run.everywhere(),
            **{f"read_overhead_{size}": overhead(size, spans) for size, spans in by_size.items()},
            "read_cpu": max(handlers for _, handlers, _ in by_size[2]),
            "enqueue": run.net(CALL),
            "turnaround": max(turned for *_, turned in run.sent)}


def prepared():
    run = Run("benchmark/prepared", "--stamp", "B", "--seconds", "2")
    run.check(run.figure["good"] == DELAYS, "not all were good")
    run.check(run.figure["torn"] == 0, "the clock overflowed: another handler ran")
    run.check(len(run.spans(WHOLE)) == DELAYS, "not 16 READs")
    return {**run.everywhere(), "read_prepared": overhead(2, run.spans(WHOLE))}


def noisy():
    run = Run("benchmark/noisy", "--stamp", "B", "--seconds", "60")
    run.check(run.figure["submits"] == 2 * 4 * 7 * 64, "not all cases")
    run.check(run.figure["ok"] == run.figure["submits"], "not all READs were good")
    return {**run.everywhere(), "enqueue_noisy": run.net(CALL)}


def sync(servos):
    """(longest build, longest time from the call to the last stop bit, run)"""
    run = Run("benchmark/sync", "--stamp", "B", "--seconds", "2", servos=f"1-{servos}", eeprom=[servos])
    run.check(run.figure["good"] == 4, "not all were sent")
    size = 8 + 5 * servos
    packets = [sent for sent in run.sent if sent[2] == size][-4:]
    run.check(all(idle == 0 for *_, idle, _ in packets), "idle bits between the bytes")
    calls = run.spans(CALL)
    run.check(len(calls) == len(packets) == 4, "not four packets")
    return (max(cycles for cycles, _, _ in run.spans(BUILD)),
            max(last - begun
                for (_, _, begun), (_, last, *_) in zip(calls, packets)), run)


def sync18():
    build, cycles, run = sync(18)
    return {**run.everywhere(), "sync18": cycles, "sync18_build": build}


def group(servos):
    """(cycles to read the feedback of all servos, run)"""
    run = Run("benchmark/group", "--stamp", "B", "--seconds", "2", servos=f"1-{servos}", eeprom=[servos])
    run.check(run.figure["good"] == 2, "not all were read")
    return max(cycles for cycles, _, _ in run.spans(WHOLE)), run


READ_8 = (8 + 6 + 8) * BYTE + RETURN_DELAY


def group18():
    cycles, run = group(18)
    return {**run.everywhere(), "group18": fractions.Fraction(cycles, 18) - READ_8}


def absent():
    run = Run("benchmark/absent", "--stamp", "B", "--seconds", "2")
    run.check(run.figure["timeouts"] == 3, "there was an answer")
    whole, = run.spans(WHOLE)
    return {**run.everywhere(), "absent_us": fractions.Fraction(whole[0], MHZ),
            "absent_blocked": max(0, run.net(SLOW) - run.net(CALL)) // MHZ}


POLL_FAULTS = [[], ["flip out every 4 3"], ["flip out every 5 9"], ["noise 3000"], ["babble headers"],
               ["babble random"], [HEADER] * 11, [HEADER] * 20 + ["flip out every 10 9"],
               ["insert out every 14 0xFF"] * 12]


def polls_with(faults):
    options = [word for fault in faults for word in ("--fault", fault)]
    run = Run("benchmark/polls", "--stamp", "B", "--seconds", "120", "--rules", "warn", *options,
              servos="1-50")
    run.check(run.figure["polls"] > 1000, "hardly any poll")
    run.check(run.figure["agains"] > 100, "on_end hardly ever submitted again")
    return {"poll_max": run.net(POLL), **run.everywhere()}


def polls():
    return worst(side_by_side(polls_with, POLL_FAULTS))


def host_traffic(seconds):
    """Yields the script of the host. In the first half of the time it requests 50 bytes of the device
    again and again, as fast as the replies can come: the way to the host is full. In the second half it
    also sends random bytes, without a gap."""
    dice = random.Random(7)
    ask = packet(DEVICE, READ, [0, 50])
    left_us = half_us = 500000 * seconds
    while left_us > -half_us:
        noise = bytes(byte for byte in dice.randbytes(dice.randrange(80)) if byte != STOP)
        said = ask if left_us > 0 else ask + noise
        wait_us = ANSWERED_US if left_us > 0 else 10 * len(said)
        left_us -= wait_us
        yield "say " + said.hex(" ")
        yield f"wait {wait_us}"


def keep_return_delay(folder, n):
    """Sets the return delay of servos 1 to 18 without the controller, which refuses 0."""
    script = folder / "delay.script"
    script.write_text("@send " + packet(BROADCAST, WRITE, [REG_RETURN_DELAY, n]).hex(" ")
                      + f"\n@expect servo 1-18 RETURN_DELAY {n}\n")
    subprocess.run([SIM, "bus", "--servos", "1-18", "--state", folder, "--script", script],
                   cwd=ROOT, stdout=subprocess.DEVNULL, check=True)


# A new controller greets a person; then a program of the PC gets bare replies.
ENTER_MODE_PROGRAM = ["wait 30000", "text mode program", "wait 30000"]
# Sets the host link to 1 Mbps.
FAST_HOST_LINK = ["say " + packet(DEVICE, WRITE, [HOST_BAUD, 1]).hex(" "), "hear 6", "wait 6000", "baud 1000000",
                  "wait 10000"]


def flooded(n, seconds, elf="firmware/flood", board="atmega128"):
    """Runs a firmware while its host sends for `seconds` at 1 Mbps. firmware/flood runs a cycle of 18
    servos; `n`: value of their register 0x05."""
    lines = [*ENTER_MODE_PROGRAM, "say " + packet(1, PING, []).hex(" "), "hear 6", *FAST_HOST_LINK,
             *host_traffic(seconds), "wait 1000"]
    with tempfile.TemporaryDirectory() as folder:
        program = pathlib.Path(folder, "program.pc")
        program.write_text("\n".join(lines) + "\n")
        keep_return_delay(pathlib.Path(folder), n)
        return Run(elf, "--host", program, "--state", folder, board=board, servos="1-18", good=False)


@functools.lru_cache
def run_loaded():
    """(smallest return delay at which no rule is broken, run at that return delay)"""
    for n in range(16):
        run = flooded(n, 1)
        if run.status == 0:
            run = flooded(n, 10)
        if run.status == 0:
            break
    else:
        raise Wrong("firmware/flood: rules of the wire are broken at any return delay")
    run.check(len(run.sent) > 4000, "hardly anything was sent")
    return n, run


LOADED = threading.Lock()  # one job runs run_loaded(), the others wait for its result


# Commands of every kind, with pauses in which the firmware sleeps. With a return delay of 20 us the
# handlers of the host link may delay the release of the driver.
COMMANDS = """write 254 RETURN_DELAY 10
scan
settings link_loss_ms 5000
save
@wait 300
status
@wait 100
read 1 0 50
sync GOAL_POSITION 2 1:1,2 2:2,2 3:3,2
@wait 50
diagnose 1
@wait 50
stop
@wait 200
clear
help
ping 1
@wait 100
"""


def omitted(board):
    """The commands that the firmware of a board leaves out: the profile `console` has no diagnose."""
    found = re.search(r"^PROFILE\s*:=\s*console$", (ROOT / f"boards/{board}/board.mk").read_text(), re.M)
    return ["diagnose"] if found else []


@functools.lru_cache
def examples():
    """{board: its programs of examples/}"""
    found = {}
    for elf in map(pathlib.Path, make_list("list-examples")):
        found.setdefault(elf.parts[1], []).append(elf.stem)
    return found


def off_in(board):
    """The longest time with interrupts off in the firmware and the examples of a board. The firmware runs commands and
    pauses, then two seconds with a host that never stops."""
    if board in boards.UNHOSTED:  # its firmware is an example
        runs = [Run("controller", "--seconds", "3", board=board, servos="1,2", talks=False)]
    else:
        with tempfile.NamedTemporaryFile("w") as script:
            script.write("".join(line for line in COMMANDS.splitlines(True)
                                 if line.split()[0] not in omitted(board)))
            script.flush()
            told = Run("controller", "--script", script.name, board=board, servos="1-18")
        told.check(len(told.sent) > 300, "not all commands were carried out")
        runs = [told, flooded(10, 2, "controller", board)]
    for example in examples()[board]:
        runs.append(Run(f"examples/{example}", "--seconds", "3", board=board, servos="1-18",
                        talks=board != "arduino-uno"))
    for run in runs:
        run.check(run.sent, "nothing was sent")
    return max(run.off for run in runs)


def shipped(name, names):
    examples()  # once, for all
    return {name: max(side_by_side(off_in, names))}


# ---- the constructed worst case of a turnaround, test/benchmark/turnaround.c ----

LOOPS, CALLS, FRAMES, WRITES_EEPROM = range(4)
NOTHING_SENT, ZERO = 255, 128
# test/benchmark/turnaround.c constructs two kinds of cli section, known by the instruction after cli:
# the stack pointer moves (prologue or epilogue of a function), or EEMPE is set. Other cli sections do
# not count, because no packet is sent there: start-up, exit, the section before sleep (busy() is true
# while the bus has a request), and wdr (main switches the watchdog on before its loop).
CLI_STACK, CLI_EEPROM = r"out\s+0x3e,", r"sbi\s+0x1c, 2"
CLI_IDLE = {"_exit", "avr_reset_cause_keep"}
SLEEP_WITHIN = 60  # instructions after cli


def check_cli(elf):
    """Checks that turnaround.c constructs every cli section of the firmware."""
    text = subprocess.run(["avr-objdump", "-d", "--no-show-raw-insn", ROOT / elf], text=True,
                          stdout=subprocess.PIPE, check=True).stdout.splitlines()
    name = ""
    for i, line in enumerate(text):
        behind = text[i + 1] if i + 1 < len(text) else ""
        if found := re.match(r"[0-9a-f]+ <(.*)>:", line):
            name = found[1]
        known = name in CLI_IDLE or name.startswith("__vector_") or \
            re.search(CLI_STACK, behind) or re.search(CLI_EEPROM, behind) or "wdr" in behind or \
            any(re.search(r"\tsleep\b", later) for later in text[i:i + SLEEP_WITHIN])
        if re.search(r"\tcli\b", line) and not known:
            raise Wrong(f"{elf}: test/benchmark/turnaround.c does not construct the cli of {name}")


def turnarounds(activity, real, phases, overflows, sends, writes):
    """[(cycles of the turnaround, moments)] of every combination of these ranges, longest first."""
    ranges = (phases, overflows, sends, writes)
    options = [activity, real]
    for one in ranges:
        options += [one[0] % 256, (one[1] - one[0]) % 256 if len(one) > 1 else 0, len(one)]
    with tempfile.NamedTemporaryFile("w", suffix=".pc") as program:
        program.write("baud 1000000\nwait 1000\nflood 60000000\n")
        program.flush()
        run = Run("benchmark/turnaround", "--host", program.name, "--seconds", "300", eeprom=options)
    moments = list(itertools.product(*ranges))
    run.check(len(run.sent) == len(moments), "not all packets were sent")
    return sorted(((sent[-1], at) for sent, at in zip(run.sent, moments)), reverse=True), run


def about(moment, reach, step=1, low=0, high=255):
    return range(max(low, moment - reach), min(high, moment + reach) + 1, step)


def turnaround_of(activity):
    """(longest turnaround, run) of one activity: a coarse sweep, then finer ones around the longest
    turnaround until it grows no more."""
    none = range(NOTHING_SENT, NOTHING_SENT + 1)
    writes = activity == WRITES_EEPROM
    if writes:
        found, run = turnarounds(activity, 0, range(0, 160, 4), range(ZERO - 120, ZERO + 25, 4), none,
                                 range(20, 200, 6))
    else:
        found, run = turnarounds(activity, 0, range(0, 160, 2), range(ZERO - 120, ZERO + 25, 2),
                                 range(0, 160, 40), range(1))
    worst_of, before = found[0], -1
    starts = [at for _, at in found[:1]] if writes else [at for _, at in found[:8:2]]
    while worst_of[0] > before:
        before = worst_of[0]
        for phase, overflow, send, write in starts:
            if writes:
                again, _ = turnarounds(activity, 1, about(phase, 4, 2), about(overflow, 6, 2), none,
                                       about(write, 5))
            else:
                again, _ = turnarounds(activity, 0, about(phase, 4), about(overflow, 72, 2),
                                       about(send, 20, 10, high=200), range(1))
            worst_of = max(worst_of, again[0])
        starts = [worst_of[1]]
    return worst_of[0], run


def turnaround():
    check_cli(Run.programs.get("controller", "build/atmega128/controller.elf"))
    found = side_by_side(turnaround_of, (LOOPS, CALLS, FRAMES, WRITES_EEPROM))
    _, flood = return_delay_needed()
    return worst([*(run.everywhere() for _, run in found),
                  *({"turnaround_loaded": cycles} for cycles, _ in found),
                  {"turnaround_loaded": max(turned for *_, turned in flood.sent)}])


def return_delay_needed():
    with LOADED:
        return run_loaded()


def loaded():
    n, run = return_delay_needed()
    return {**run.everywhere(), "return_delay_needed": n}


def cycle(servos, seconds, n):
    run = Run("firmware/cycle50", "--mark", "B0", "--seconds", str(seconds + 10),
              servos=f"1-{servos}", eeprom=[seconds, 0, servos, n])
    for name in ["refused", "unsent", "dropped", "failed", "timeouts", "corrupt", "overruns"]:
        run.check(run.figure[name] == 0, name)
    return run


def shares(run, name, seconds):
    """Rows of a cycle that has run for `seconds`."""
    run.check(run.figure["periods"] + run.figure["missed"] == 250 * seconds, "not all periods")
    time = seconds * MHZ * 1000000
    packets = list(run.wire())
    begun = next(at for at, _, raw in packets if raw[4] == SYNC_WRITE)  # the packets before it prepare the servos
    wire = BYTE * sum(len(raw) for at, _, raw in packets if at >= begun)
    calls = int(re.search(r"^mark: .* (\d+) in all$", run.output, re.M)[1])
    return {**run.everywhere(), f"{name}_missed": run.figure["missed"],
            f"{name}_bus": fractions.Fraction(100 * wire, time),
            f"{name}_cpu": fractions.Fraction(100 * (run.in_handlers + calls), time)}


def cycle50(seconds=60):
    n, _ = return_delay_needed()
    run = Run("benchmark/cycle8", "--mark", "B0", "--seconds", str(seconds + 10), servos="1-50",
              eeprom=[seconds, n])
    run.check(run.figure["failed"] == 0 and run.figure["reads"] > 1000 * seconds, "READs failed")
    goals = [first for first, _, size, *_ in run.sent if size == 8 + 5 * 50]
    late = [first - 4000 * MHZ * i for i, first in enumerate(goals)]
    run.check(max(late) - min(late) < 5 * MHZ, "goals are not on time")
    return shares(run, "cycle50", seconds)


def cycle50_11(seconds=60):
    n, _ = return_delay_needed()
    return shares(cycle(50, seconds, n), "cycle50_11", seconds)


# ---- with 50 servos and their limits, as examples/robot.c uses them ----

SAFE = "1-50"


def safe_read():
    run = Run("benchmark/safe_read", "--stamp", "B", "--seconds", "5", servos=SAFE)
    run.check(run.figure["good"] == 1 + DELAYS, "not all were good")
    run.check(run.figure["torn"] == 0, "the clock overflowed: another handler ran")
    run.check(len(run.spans(WHOLE)) == DELAYS, "not 16 READs")
    return {**run.everywhere(), "safe_read_overhead": overhead(2, run.spans(WHOLE))}


def safe_calls():
    run = Run("benchmark/safe_calls", "--stamp", "B", "--seconds", "60", servos=SAFE)
    run.check(run.figure["good"] == 1 and run.figure["wrong"] == 0, "not all ended as they should")
    sent = [raw for _, ours, raw in run.wire() if ours and raw[4] == SYNC_WRITE]
    run.check(run.figure["refused"] == 24, "goals beyond the limits, or ACTION to servos with limits, were not refused")
    run.check(len(sent) == run.figure["left"] == 48, "a SYNC WRITE left that was refused, or none left")
    return {**run.everywhere(), "safe_poll_max": run.net(POLL), "safe_submit_max": run.net(CALL)}


def safe_cycle50(seconds=60):
    n, _ = return_delay_needed()
    run = Run("firmware/cycle50_safe", "--mark", "B0", "--seconds", str(seconds + 10), servos=SAFE,
              eeprom=[seconds, 0, 50, n])
    for name in ["refused", "unsent", "dropped", "failed", "timeouts", "corrupt", "overruns", "alarms"]:
        run.check(run.figure[name] == 0, name)
    run.check(run.figure["prepared"] == 50, "not all servos were prepared")
    looks = sum(ours and raw[4] == READ and raw[5] == 0x18 for _, ours, raw in run.wire())
    run.check(looks >= 49 * seconds, "the health check did not look at each servo once a second")
    rows = shares(run, "safe_cycle50", seconds)
    rows["safe_cycle50_reads"] = fractions.Fraction(run.figure["reads"], run.figure["periods"])
    run.check(rows.pop("safe_cycle50_missed") == 0, "periods were missed")
    return rows


# ---- timed moves ----

def motion_of(joints, board):
    run = Run("benchmark/motion", "--stamp", "B", "--seconds", "30", board=board, servos=f"1-{joints}",
              eeprom=[joints])
    run.check(run.figure["moves"] == 3, "not all moves ended well")
    run.check(run.figure["reads"] > run.figure["periods"], "less than a READ in each period")
    return run


def motion():
    """A joint costs what a poll of six joints takes, less the calls of cds_cycle_goal() in it."""
    small, large = motion_of(18, "atmega128"), motion_of(50, "arduino-mega")
    polls = sorted(cycles - handlers for cycles, handlers, _ in small.spans(POLL))
    sixes = [cycles for cycles in polls if cycles > small.net(CALL)]
    return {**small.everywhere(), "motion_joint": fractions.Fraction(sixes[len(sixes) // 2] - small.net(CALL), 6),
            "motion_poll_max": max(small.net(POLL), small.net(SLOW)),
            "motion50_missed": large.figure["missed"] + large.figure["unsent"]}


def gait_of(sines, joints):
    """A run with so many sines of each joint; the cycles of a joint, without cds_cycle_goal(), in a poll
    that sets the goals of so many."""
    run = Run("benchmark/gait", "--stamp", "B", "--seconds", "10", servos="1-18", eeprom=[sines])
    run.check(run.figure["walked"] == 1 and run.figure["missed"] == 0, "the gait did not end well")
    run.check(run.figure["reads"] > run.figure["periods"], "less than a READ in each period")
    goals = fractions.Fraction(run.net(CALL) * joints, 6)
    polls = sorted(cycles - handlers for cycles, handlers, _ in run.spans(POLL))
    full = [cycles for cycles in polls if cycles > goals]
    return run, (full[len(full) // 2] - goals) / joints


def gait():
    (one, joint), (three, joint_of_three) = gait_of(1, 3), gait_of(3, 2)
    sine = (joint_of_three - joint) / 2
    return {**one.everywhere(), "gait_joint": joint - sine, "gait_sine": sine,
            "gait_poll_max": max(run.net(pin) for run in (one, three) for pin in (POLL, SLOW))}


TORQUE_OFF = packet(BROADCAST, WRITE, [0x18, 0])
SAFE_MARGIN = 100 * MHZ  # CDS_REPLY_MARGIN_US
FAILED = 100 * MHZ  # after the deadline the bus may still have the transaction, or wait for a quiet line
DAMAGED_ID = 60  # test/benchmark/safe_torque_off.c


def ends(wire):
    """(start of the first start bit, end, failed) of each transaction except torque off. A transaction
    without a good reply ends at its deadline."""
    for i, (begun, ours, raw) in enumerate(wire):
        if not ours or raw == TORQUE_OFF:
            continue
        last = begun + BYTE * len(raw)
        if raw[2] == BROADCAST:
            yield begun, last, False
        elif i + 1 < len(wire) and not wire[i + 1][1] and raw[2] != DAMAGED_ID:
            yield begun, wire[i + 1][0] + BYTE * len(wire[i + 1][2]), False
        else:
            due = 6 + (raw[6] if raw[4] == READ else 0)
            yield begun, last + BYTE * due + RETURN_DELAY + SAFE_MARGIN, True


def safe_torque_off():
    run = Run("benchmark/safe_torque_off", "--stamp", "B", "--seconds", "60", "--allow-duplicates",
              "--fault", f"turnaround {DAMAGED_ID} 25", servos=f"{SAFE},{DAMAGED_ID},{DAMAGED_ID}")
    run.check(run.figure["good"] == 1, "not all servos were prepared")
    run.check(run.figure["stops"] == run.figure["over"] == 7 * 60, "torque off did not end well")
    wire = list(run.wire())
    offs = [begun for begun, ours, raw in wire if ours and raw == TORQUE_OFF]
    transactions = list(ends(wire))
    longest = {False: 0, True: 0}
    met = {False: 0, True: 0}
    torque_on = {begun for begun, ours, raw in wire if ours and raw[4:6] == bytes([SYNC_WRITE, 0x18])}
    met_torque_on = 0
    for _, _, call in run.spans(CALL):
        first = next(begun for begun in offs if begun >= call)
        begun, end, failed = max(one for one in transactions if one[0] < first)
        run.check(begun < call or end <= call, "another packet left before torque off")
        failed &= call < end + FAILED
        met[failed] += end > call
        met_torque_on += end > call and begun in torque_on
        longest[failed] = max(longest[failed], first - max(call, end))
    run.check(min(met.values()) >= 40, f"hardly any call during a transaction: {met}")
    run.check(met_torque_on >= 8, f"hardly any call during torque on to all: {met_torque_on}")
    return {**run.everywhere(), "safe_torque_off_us": fractions.Fraction(longest[False], MHZ),
            "safe_torque_off_failed_us": fractions.Fraction(longest[True], MHZ)}


def bulk():
    run = Feedback()
    if run.status or not run.is_equal:
        raise Wrong("BULK READ:\n" + run.output)
    return {"bulk18": fractions.Fraction(run.bulk_us * MHZ) / (18 * 22 * BYTE)}


def bridge_sync_write(count):
    """The longest time from the last stop bit of the host's SYNC WRITE of `count` goals and speeds to the
    first start bit on the bus, in cycles."""
    ids, rounds = range(1, count + 1), 20
    lines = [*ENTER_MODE_PROGRAM, "say " + packet(1, PING, []).hex(" "), "hear 6", *FAST_HOST_LINK,
             "text group " + " ".join(map(str, ids)), "hear 4 within 1000",
             "say " + packet(BROADCAST, WRITE, [TORQUE, 1]).hex(" "), "wait 100000"]
    for step in range(rounds):
        goals = [byte for id in ids for byte in (id, step, 2, 100, 0)]
        lines += ["say " + packet(BROADCAST, SYNC_WRITE, [GOAL, 4, *goals]).hex(" "), "wait 20000"]
    with tempfile.TemporaryDirectory() as folder:
        program = pathlib.Path(folder, "program.pc")
        program.write_text("\n".join(lines) + "\n")
        run = Run("controller", "--host", program, servos=f"1-{count}")
    said = [int(end) for end in re.findall(r"^said \d+ (\d+) \d+$", run.output, re.M)][-rounds:]
    size = 8 + 5 * count
    begun = [start for start, _, bytes, *_ in run.sent if bytes == size]
    run.check(len(begun) == len(said) == rounds, "not every SYNC WRITE was passed on")
    return max(start - end for start, end in zip(begun, said))


def stop_latency(count):
    """The longest time from the last stop bit of Ctrl-X to the first start bit of torque off, in cycles, while the
    controller reads feedback of `count` servos for the host as the control panel asks for it."""
    rounds, feedback = 60, packet(BROADCAST, SYNC_READ, [0x24, 8, *range(1, count + 1)])
    lines = [*ENTER_MODE_PROGRAM, "say " + packet(DEVICE, PING, []).hex(" "), "hear 6", *FAST_HOST_LINK]
    for step in range(rounds):
        lines += ["text release", "wait 20000", "say " + packet(BROADCAST, WRITE, [TORQUE, 1]).hex(" "), "wait 5000",
                  "say " + feedback.hex(" "), f"wait {1 + 131 * step}", "say 18", "wait 100000"]
    with tempfile.TemporaryDirectory() as folder:
        program = pathlib.Path(folder, "program.pc")
        program.write_text("\n".join(lines) + "\n")
        run = Run("controller", "--host", program, servos=f"1-{count}")
    ctrl_x = [int(end) for end in re.findall(r"^said \d+ (\d+) 1$", run.output, re.M)]
    off = [start for start, _, sent in run.wire() if sent == packet(BROADCAST, WRITE, [TORQUE, 0])]
    run.check(len(ctrl_x) == rounds and len(off) >= rounds, "not every Ctrl-X switched torque off")
    return max(min(start for start in off if start > end) - end for end in ctrl_x)


def bridge():
    return {"bridge_sync18": bridge_sync_write(18), "stop_latency": stop_latency(18)}


def lost(run, counters):
    """Number of lost bytes and replies."""
    return counters["timeouts"] + counters["corrupt"] + run.broken("overrun", "reply-lost")


def three(n):
    run = Run("firmware/three_buses", "--servos", "1:2", "--servos", "2:3", "--rules", "warn",
              "--seconds", "15", board="arduino-mega", eeprom=[n, 8, 3, 10, 1])
    counters = [dict(re.findall(r"^(\w+) (\d+)$", text, re.M)) for text in
                re.split(r"^bus \d$", run.output, flags=re.M)[1:4]]
    run.check(all(int(count["reads"]) > 10000 for count in counters), "hardly anything was read")
    return sum(int(count[name]) for count in counters for name in ("timeouts", "corrupt")) + \
        run.broken("overrun", "reply-lost")


def two_mbps():
    run = Run("benchmark/two_mbps", "--rules", "warn", "--seconds", "15", eeprom=[10, 1])
    run.check(run.figure["reads"] > 10000, "hardly anything was read")
    return {**run.everywhere(), "two_mbps_lost": lost(run, run.figure)}


def size():
    run = Run("benchmark/min", "--seconds", "0.1", board="test/boards/atmega644p", servos="1-18")
    sent = [(raw[4], len(raw)) for way, raw in run.packets() if way == "->in"]
    run.check(sent == [(1, 6), (2, 8), (3, 9), (0x83, 98)], f"it sends {sent}")
    least = sizes(ROOT / "build/atmega644p/benchmark/min.elf")
    whole = sizes(ROOT / "build/atmega128/controller.elf")
    return {"min_flash": least[0], "min_ram": least[1], "console_ram": whole[1]}


def handlers(board, suffix=""):
    """All paths of the handlers: in good transactions, and with a babbling servo and noise."""
    clean = Run("benchmark/handlers", "--seconds", "2", board=board, servos="1-50", eeprom=[0])
    clean.check(clean.figure["good"] == 100, "not all transactions were good")
    bad = Run("benchmark/handlers", "--seconds", "2", "--rules", "warn", "--seed", "1", "--fault",
              "babble random", "--fault", "noise 100000", board=board, eeprom=[1])
    for name in ["framing_errors", "overruns", "ring_overflows"]:
        bad.check(bad.figure[name] > 20, f"hardly any {name}")
    return worst([run.handlers(suffix) if suffix else run.everywhere() for run in (clean, bad)])


JOBS = {
    "loaded": loaded,  # the longest first
    "turnaround": turnaround,
    "three": lambda: {"three_buses_lost": three(5)},
    "three_2us": lambda: {"three_buses_lost_2us": three(1)},
    "cycle50": cycle50,
    "cycle50_11": cycle50_11,
    "safe_cycle50": safe_cycle50,
    "motion": motion,
    "gait": gait,
    "safe_torque_off": safe_torque_off,
    "two_mbps": two_mbps,
    "polls": polls,
    "bulk": bulk,
    "bridge": bridge,
    "shipped": lambda: shipped("irq_off_max", [name for name in boards.ALL if boards.BOARDS[name].wiring != "TIED"]),
    "shipped_tied": lambda: shipped("irq_off_max_tied", [name for name in boards.ALL if boards.BOARDS[name].wiring == "TIED"]),
    "handlers": lambda: handlers("atmega128"),
    "handlers_2560": lambda: handlers("arduino-mega", "_2560"),
    "handlers_tied": lambda: handlers("arbotix", "_tied"),
    "read": read,
    "prepared": prepared,
    "noisy": noisy,
    "safe_read": safe_read,
    "safe_calls": safe_calls,
    "sync18": sync18,
    "group18": group18,
    "absent": absent,
    "size": size,
}


# ---- how the cost grows -----------------------------------------------------------------------------

PERIOD = 4000 * MHZ  # cycles in a period of cycle.h


def scaling_read(servos):
    return group(servos)[0], servos * READ_8


def scaling_sync(servos):
    build, cycles, _ = sync(servos)
    return build + cycles, (8 + 5 * servos) * BYTE


def scaling_cycle(servos, seconds=2):
    """(time to read the feedback of all servos while goals are sent at 250 Hz, its floor). Floor: READs
    without a gap in the part of each period that the goals leave."""
    run = cycle(servos, seconds, 1)
    run.check(run.figure["missed"] == 0, "missed")
    asked = next(raw for _, raw in run.packets() if raw[4] == 2 and len(raw) == 8)
    one = (8 + 6 + asked[6]) * BYTE + RETURN_DELAY
    goals = (8 + 5 * servos) * BYTE
    return (fractions.Fraction(servos * seconds * MHZ * 1000000, run.figure["reads"]),
            fractions.Fraction(servos * one * PERIOD, PERIOD - goals))


scaling_points = {"read": scaling_read, "sync": scaling_sync, "cycle": scaling_cycle}
