# SPDX-License-Identifier: MIT
"""A client with the timing of DynamixelSDK that dies within a packet, or speaks at a wrong rate, and
starts anew: no READ returns the value of an earlier one, and no goal reaches a servo after the
client has given it up.

Simulated time: a program says the client's bytes at its times, and the client's receiver looks at
what came before its timeout. Nothing depends on the machine.
"""
# needs: build/atmega128/controller.elf
import itertools
import pathlib
import subprocess
import tempfile
import unittest

from client import BAUD, BROADCAST, GOAL_POSITION, PING, READ, SYNC_WRITE, WRITE, packet, word
from sdk_client import LATENCY_MS, SUCCESS, Receiver, timeout_us
from simulator import PACKET, ROOT, SIM

CYCLES_PER_US = 16
CTRL_X = 0x18       # outside a whole packet it stops the robot
SERVO = 1
VALUES = {0x02: [1, SERVO], 0x08: word(1023), 0x30: word(90)}   # the three registers that are READ
READS = [packet(SERVO, READ, [address, 2]) for address in VALUES]
BLOCKS = [byte for servo in range(1, 19) for byte in (servo, *word(500), *word(300))]
CUT = packet(BROADCAST, SYNC_WRITE, [GOAL_POSITION, 4, *BLOCKS])    # LENGTH 0x5E
CUTS = range(1, len(CUT))
PINGS = [[packet(servo, PING) for servo in range(first, first + 10)] for first in (1, 51, 171, 231)]
RATES = (9600, 19200, 38400, 57600, 115200, 230400, 500000, 1000000, 2000000)
LONGEST = 258       # bytes of a packet
PAUSE_MS = 300      # between two sessions: what is left of the last one is over


def goal_requests():
    """WRITEs of goals, no two alike, without those that contain a Ctrl-X."""
    for goal in range(1, 1023):
        request = packet(SERVO, WRITE, [GOAL_POSITION, *word(goal)])
        if CTRL_X not in request:
            yield request


class Request:
    """`at_ms`: when the client sends it."""

    def __init__(self, raw, at_ms, baud, latency_ms):
        self.raw, self.at_ms = raw, at_ms
        self.patience_us = timeout_us(raw, baud, latency_ms)
        self.expected = bytes(VALUES[raw[5]]) if raw[4] == READ else b""
        self.heard = b""    # before the timeout
        self.too_late = b"" # between the timeout and the next request

    def is_goal(self):
        return self.raw[4] == WRITE

    def hear(self, cycle, raw):
        if cycle <= self.give_up_cycle():
            self.heard += raw
        else:
            self.too_late += raw

    def give_up_cycle(self):
        return self.sent_cycle + self.patience_us * CYCLES_PER_US


class Session:
    """The client says each of `before` at `before_baud`, a timeout apart, and dies; `restart_ms` later
    it begins with its requests. Each request follows the timeout of the one before it by 0 to 4 ms:
    34 to 39 ms behind it with the latency timer of the SDK. Every fourth request is a goal."""

    def __init__(self, begin_ms, before, before_baud, restart_ms, baud, goals, count,
                 latency_ms=LATENCY_MS):
        self.begin_ms, self.before_baud = begin_ms, before_baud
        self.before = []
        at_ms = begin_ms
        for raw in before:
            self.before.append((at_ms, raw))
            at_ms += -(-int(timeout_us(packet(1, PING), before_baud)) // 1000)
        at_ms = self.before[-1][0] + -(-len(before[-1]) * 10000 // before_baud) + restart_ms
        self.requests = []
        for number in range(count):
            raw = next(goals) if number % 4 == 3 else READS[number % 3]
            self.requests.append(Request(raw, at_ms, baud, latency_ms))
            at_ms += -(-int(self.requests[-1].patience_us) // 1000) + (number + restart_ms) % 4
        self.end_ms = at_ms


def cut_sessions(baud, restarts, latency_ms=LATENCY_MS):
    """The client dies at every byte of the SYNC WRITE."""
    goals, sessions, begin_ms = goal_requests(), [], 100
    for cut in CUTS:
        count = (len(CUT) - cut) // len(READS[0]) + 3   # until its LENGTH is full, and then some
        sessions.append(Session(begin_ms, [CUT[:cut]], baud, restarts[cut % len(restarts)], baud,
                                goals, count, latency_ms))
        begin_ms = sessions[-1].end_ms + PAUSE_MS
    return sessions


def rate_sessions(baud):
    """The client says ten PINGs at each wrong rate. Some leave what looks like the head of a packet:
    which rates and IDs do depends on the right rate."""
    goals, sessions, begin_ms = goal_requests(), [], 100
    for number, (rate, pings) in enumerate(itertools.product(RATES, PINGS)):
        if rate == baud:
            continue
        sessions.append(Session(begin_ms, pings, rate, 35 + number % 5, baud, goals,
                                LONGEST // len(READS[0]) + 3))
        begin_ms = sessions[-1].end_ms + PAUSE_MS
    return sessions


def requests_of(sessions):
    return [request for session in sessions for request in session.requests]


def run(kind, program, *options):
    """The lines that the simulator printed, and the packets of the transcript."""
    with tempfile.TemporaryDirectory() as folder:
        path, transcript = pathlib.Path(folder, "program"), pathlib.Path(folder, "transcript")
        path.write_text("\n".join(program) + "\n")
        done = subprocess.run([SIM, kind, *options, path, "--servos", "1-18", "--transcript",
                               transcript], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, timeout=280)
        assert done.returncode == 0, done.stdout[-2000:]
        wire = [match for match in map(PACKET.match, transcript.read_text().splitlines()) if match]
    return done.stdout.splitlines(), [(int(match[1]), match[2], bytes.fromhex(match[3]))
                                      for match in wire]


def run_firmware(sessions, board="atmega128", baud=115200):
    """The sessions on the host link of the controller. Returns the goals that were late: on the wire
    of the servos after the client had given them up, or never said by the client."""
    program, now_us = [], 0

    def until(ms):
        nonlocal now_us
        program.append(f"wait {int(ms * 1000) - now_us}")
        now_us = int(ms * 1000)

    for session in sessions:
        for at_ms, raw in session.before:
            until(at_ms)
            program += [f"baud {session.before_baud}", f"say {raw.hex(' ')}"]
        for request in session.requests:
            until(request.at_ms)
            program += ["rest", f"baud {baud}", f"say {request.raw.hex(' ')}"]
            until(request.at_ms + request.patience_us / 1000)
            program.append("rest")
        until(session.end_ms)
        program.append("rest")
    output, wire = run("firmware", program, ROOT / f"build/{board}/controller.elf", "--board", board,
                       "--host")
    order = iter([request for session in sessions   # as they are said
                  for request in [None for _ in session.before] + session.requests])
    request = None
    for line in map(str.split, output):
        if line[0] == "said":
            request = next(order)
            if request:
                request.sent_cycle = int(line[1])
        elif line[0] == "heard" and request:
            request.hear(int(line[1]), bytes.fromhex("".join(line[4:])))
    given_up = {request.raw: request.give_up_cycle() for request in requests_of(sessions)}
    return [(cycle, raw.hex(" ")) for cycle, way, raw in wire
            if way == "->in" and raw[4] in (WRITE, SYNC_WRITE) and raw[5] == GOAL_POSITION
            and cycle > given_up.get(raw, 0)]


def run_bus(sessions, baud=1000000):
    """The sessions on the bus itself, whose servos are set to `baud` first. Returns the goals that were late: the servo's goal before a
    request is another one than when the client had given up its last goal."""
    program = [f"@send {packet(BROADCAST, WRITE, [BAUD, 2000000 // baud - 1]).hex(' ')}"]
    for session in sessions:
        for at_ms, raw in session.before:
            program += [f"@at {at_ms}", f"@baud {session.before_baud}", f"@send {raw.hex(' ')}"]
        for request in session.requests:
            program += [f"@at {request.at_ms}", f"@show servo {SERVO} GOAL_POSITION",
                        f"@baud {baud}", f"@send {request.raw.hex(' ')}"]
        program += [f"@at {session.end_ms}", f"@show servo {SERVO} GOAL_POSITION"]
    output, wire = run("bus", program, "--script")
    shown = iter([int(line.split()[3]) for line in output if line.startswith("servo ")])
    late = []
    for session in sessions:
        goal = next(shown)
        for request in session.requests:
            before, goal = goal, next(shown)
            if goal != before and not (request.is_goal() and goal == request.raw[6] + 256 * request.raw[7]):
                late.append((request.at_ms, before, goal))
    requests = requests_of(sessions)
    for request in requests:
        request.sent_cycle = request.at_ms * 1000 * CYCLES_PER_US
    at = -1
    for cycle, way, raw in wire:
        while at + 1 < len(requests) and requests[at + 1].sent_cycle <= cycle:
            at += 1
        if way == "<-out" and at >= 0:
            requests[at].hear(cycle + len(raw) * 10 * CYCLES_PER_US, raw)
    return late


class Verdict:
    """What the client made of the replies. The C and C++ versions of the SDK drop what came before a
    request; `keeps_input`: the Python version does not."""

    def __init__(self, sessions, keeps_input=False):
        self.wrong, self.unanswered, self.answered = [], [], 0
        for session in sessions:
            receiver = Receiver()
            for request in session.requests:
                if not keeps_input:
                    receiver.clear()
                receiver.bytes += request.heard
                found = receiver.reply(SERVO)
                receiver.bytes += request.too_late
                if not found or found[0] != SUCCESS:
                    self.unanswered.append(request)
                elif found[1][4] == 0 and found[1][5:-1] != request.expected:
                    self.wrong.append((request.at_ms, request.raw.hex(" "), found[1].hex(" ")))
                else:
                    self.answered += 1


class SdkClient(unittest.TestCase):
    def check(self, sessions, late, unanswered=0):
        for keeps_input in (False, True):
            verdict = Verdict(sessions, keeps_input)
            total = len(requests_of(sessions))
            figures = (f"{len(verdict.wrong)} of {total} requests with a wrong reply, "
                       f"{len(verdict.unanswered)} without a reply, {len(late)} late goals; "
                       f"keeps input: {keeps_input}")
            print(figures)
            self.assertEqual((verdict.wrong[:5], late[:5]), ([], []), figures)
            self.assertLessEqual(len(verdict.unanswered), unanswered, figures)
            for session in sessions:
                self.assertNotIn(session.requests[-1], verdict.unanswered, "not heard any more")

    def test_firmware_client_dies_in_packet_no_wrong_value(self):
        sessions = cut_sessions(115200, (35, 36, 37, 38, 39))
        self.check(sessions, run_firmware(sessions))

    def test_firmware_client_restarts_at_once_no_wrong_value(self):
        sessions = cut_sessions(115200, (1, 3, 7, 11, 13, 17, 19, 23, 29, 33))
        self.check(sessions, run_firmware(sessions), len(sessions))

    def test_firmware_client_of_4_ms_patience_no_wrong_value(self):
        sessions = cut_sessions(115200, (1, 3, 5, 7, 9), latency_ms=1)  # many set the timer to 1 ms
        self.check(sessions, run_firmware(sessions), len(requests_of(sessions)))

    def test_bus_client_of_4_ms_patience_no_wrong_value(self):
        sessions = cut_sessions(1000000, (1, 3, 5, 7, 9), latency_ms=1)
        self.check(sessions, run_bus(sessions), len(requests_of(sessions)))

    def test_firmware_client_at_wrong_rate_no_wrong_value(self):
        sessions = rate_sessions(115200)
        self.check(sessions, run_firmware(sessions))

    def test_bus_client_dies_in_packet_no_wrong_value(self):
        sessions = cut_sessions(1000000, (35, 36, 37, 38, 39))
        self.check(sessions, run_bus(sessions), len(requests_of(sessions)))

    def test_bus_client_at_wrong_rate_no_wrong_value(self):
        sessions = rate_sessions(57600)
        self.check(sessions, run_bus(sessions, 57600), len(requests_of(sessions)))


if __name__ == "__main__":
    unittest.main()
