# SPDX-License-Identifier: MIT
"""A client with the timing of DynamixelSDK at a pty, in real time: it dies at every byte of a SYNC
WRITE, or speaks at a wrong rate, closes the port and opens it again.

A busy machine delays simulator and client: a request may time out, and its reply may answer the next
request, as with the SDK at any port. So the judge is the wire in simulated time, not the client:

- on the bus: when the servo's goal changes, the WRITE of this goal ended at most 8 ms ago;
- behind the firmware: a request reaches the wire before the client gives it up. The simulated time of
  the wire and the client's clock are compared by the smallest difference between the two that any
  request shows. The simulator never runs ahead of real time, so a delay of the machine can only make
  a request look earlier. A wrong reply needs a request that the client gave up although it was on the
  wire in time: the delay of the machine.
"""
# needs: build/atmega128/controller.elf
import concurrent.futures
import functools
import pathlib
import tempfile
import unittest

from client import BAUD, READ, WRITE, packet
from sdk_client import SUCCESS, SdkPort, timeout_us
from simulator import PACKET, ROOT, Process
from test_sdk_client import CUT, CUTS, PINGS, RATES, SERVO, goal_requests

CYCLES_PER_MS = 16000
REGISTERS = 50
GOAL = range(0x1E, 0x20)    # changes, so it is not READ
MARGIN_MS = 5
GOAL_LATE_MS = 8            # a servo takes a goal at once, the CSV has a line every 4 ms
REQUESTS_MAX = 40           # 258 bytes, the longest packet, are filled by then
OPENINGS_MAX = 5
STARTING = 100              # requests while the firmware may still start
ANSWERED = 4                # requests in a row end a session; one of four is a goal
CLIENTS = 3                 # at once, each with a simulator of its own: a client waits most of the time


def unique_requests():
    """READs of 2 bytes and more, no two alike, and a goal behind every third."""
    goals = goal_requests()
    while True:
        number = 0
        for address in range(REGISTERS):
            for count in range(2, REGISTERS - address + 1):
                if set(GOAL) & set(range(address, address + count)):
                    continue
                yield packet(SERVO, READ, [address, count])
                number += 1
                if number % 3 == 0:
                    yield next(goals)


class Asked:
    """A request. In ms of the client's clock: when it was sent, when the client was done with it, and
    how long the client would have waited."""

    def __init__(self, port, raw):
        self.raw = raw
        self.result, self.reply = port.ask(raw)
        self.sent_ms, self.ended_ms = port.sent * 1000, port.ended * 1000
        self.until_ms = max(self.ended_ms, self.sent_ms + timeout_us(raw, port.baud) / 1000)


class Client:
    def __init__(self, path, baud):
        self.path, self.baud = path, baud
        self.requests, self.asked = unique_requests(), []
        with SdkPort(path, baud) as port:
            self.table = self.read_table(port)

    @staticmethod
    def read_table(port):
        for _ in range(STARTING):
            result, reply = port.ask(packet(SERVO, READ, [0, REGISTERS]))
            if result == SUCCESS:
                return reply[5:-1]
        raise AssertionError("servo 1 does not answer")

    def session(self, before, before_baud):
        """The client says what is in `before`, dies and starts anew."""
        with SdkPort(self.path, before_baud) as port:
            before(port)
        for _ in range(OPENINGS_MAX):
            if self.ask_until_answered():
                return
        raise AssertionError("the port does not answer any more")

    def ask_until_answered(self):
        with SdkPort(self.path, self.baud) as port:
            row = 0
            for _ in range(REQUESTS_MAX):
                self.asked.append(Asked(port, next(self.requests)))
                row = row + 1 if self.asked[-1].result == SUCCESS else 0
                if row == ANSWERED:
                    return True
        return False

    def wrong(self):
        """Replies that the client took for those of its requests, and are not."""
        return [(asked.raw.hex(" "), asked.reply.hex(" ")) for asked in self.asked
                if asked.result == SUCCESS and asked.reply[4] == 0
                and asked.reply[5:-1] != self.expected(asked.raw)]

    def surely_answered(self):
        """READs whose reply can be that of no other recent request, and sent only once."""
        raws = [asked.raw for asked in self.asked]
        replies = [self.expected(raw) for raw in raws]
        return [asked for at, asked in enumerate(self.asked)
                if asked.result == SUCCESS and asked.reply[5:-1] == replies[at]
                and replies[at] not in replies[max(at - REQUESTS_MAX, 0):at]
                and raws.count(asked.raw) == 1]

    def expected(self, raw):
        return self.table[raw[5]:raw[5] + raw[6]] if raw[4] == READ else b""


def die_everywhere(client, part):
    for cut in CUTS[part::CLIENTS]:
        client.session(lambda port, size=cut: port.send(CUT[:size]), client.baud)


def speak_at_wrong_rates(client, part):
    for rate in RATES[part::CLIENTS]:
        if rate != client.baud:
            for pings in PINGS[:2]:
                client.session(lambda port, raws=pings: [port.ask(raw) for raw in raws], rate)


class Sim(Process):
    """A simulator with a transcript and a CSV, to be looked at when it has ended."""

    def __init__(self, *options):
        self.files = tempfile.TemporaryDirectory()
        self.transcript = pathlib.Path(self.files.name, "transcript")
        self.csv = pathlib.Path(self.files.name, "csv")
        super().__init__(*options, "--servos", "1-18", "--transcript", str(self.transcript), "--csv",
                         str(self.csv))

    def __exit__(self, *arguments):
        super().__exit__(*arguments)
        self.files.cleanup()

    def wire(self):
        """(cycle, bytes) from the client or the controller."""
        lines = map(PACKET.match, self.transcript.read_text().splitlines())
        return [(int(line[1]), bytes.fromhex(line[3])) for line in lines if line and line[2] == "->in"]

    def goals(self):
        """(ms, goal) of each change of the servo's goal position."""
        rows = [line.split(",") for line in self.csv.read_text().splitlines()[1:] if line]
        values = [(float(row[0]), int(row[1])) for row in rows]
        return [now for before, now in zip(values, values[1:]) if before[1] != now[1]]


def late_goals(sim):
    """On the bus: (ms, goal) of the changes that no WRITE within the last GOAL_LATE_MS explains."""
    stream = [(cycle / CYCLES_PER_MS + at / 100, byte) for cycle, raw in sim.wire()
              for at, byte in enumerate(raw)]
    raw = bytes(byte for _, byte in stream)
    written = {}
    for request in goal_requests():
        at = raw.find(request)
        if at >= 0:
            written[request[6] + 256 * request[7]] = stream[at][0]
    return [(ms, goal) for ms, goal in sim.goals() if not ms - written.get(goal, 0) < GOAL_LATE_MS]


def late_requests(sim, client):
    """Behind the firmware: (ms too late, request) of those that the client had given up; and those
    given up that were on the wire in time."""
    known = {}
    for asked in client.asked:
        known.setdefault(asked.raw, []).append(asked)
    wire = [(cycle / CYCLES_PER_MS, raw) for cycle, raw in sim.wire() if raw in known]
    sure = {asked.raw for asked in client.surely_answered()}
    ahead = min(known[raw][0].ended_ms - ms for ms, raw in wire if raw in sure)
    late, delayed = [], []
    for ms, raw in wire:
        asked = min(known[raw], key=lambda one: abs(one.sent_ms - ms - ahead))
        if ms + ahead > asked.until_ms + MARGIN_MS:
            late.append((ms + ahead - asked.until_ms, raw.hex(" ")))
        elif asked.result != SUCCESS:
            delayed.append(raw.hex(" "))
    return late, delayed


def each_part(run, *arguments):
    """Calls run(*arguments, part) for all parts at once."""
    with concurrent.futures.ThreadPoolExecutor(CLIENTS) as pool:
        list(pool.map(functools.partial(run, *arguments), range(CLIENTS)))


class SdkClientPty(unittest.TestCase):
    def check(self, client, late):
        figures = (f"{len(client.asked)} requests, {len(client.wrong())} with a wrong reply, "
                   f"{sum(asked.result != SUCCESS for asked in client.asked)} without a reply, "
                   f"{len(late)} late")
        print(figures)
        self.assertEqual(late[:5], [], figures)

    def on_bus(self, baud, do, part):
        with Sim("bus", "--pty") as sim:
            if baud != 1000000:
                with SdkPort(sim.path, 1000000) as port:
                    Client.read_table(port)
                    port.ask(packet(SERVO, WRITE, [BAUD, 2000000 // baud - 1]))
            client = Client(sim.path, baud)
            do(client, part)
            sim.end()
            self.check(client, late_goals(sim))

    def behind_firmware(self, do, part):
        with Sim("firmware", str(ROOT / "build/atmega128/controller.elf"), "--board", "atmega128",
                 "--host", "pty", "--host-baud", "client") as sim:
            client = Client(sim.path, 115200)
            do(client, part)
            sim.end()
            late, delayed = late_requests(sim, client)
            self.check(client, late)
            if not delayed:
                self.assertEqual(client.wrong()[:5], [])

    def test_bus_pty_client_dies_in_packet_no_late_goal(self):
        each_part(self.on_bus, 1000000, die_everywhere)

    def test_bus_pty_client_at_wrong_rate_no_late_goal(self):
        each_part(self.on_bus, 57600, speak_at_wrong_rates)

    def test_firmware_pty_client_dies_in_packet_none_late(self):
        each_part(self.behind_firmware, die_everywhere)

    def test_firmware_pty_client_at_wrong_rate_none_late(self):
        each_part(self.behind_firmware, speak_at_wrong_rates)


if __name__ == "__main__":
    unittest.main()
