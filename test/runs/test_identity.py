# SPDX-License-Identifier: MIT
"""A change of ID, of the baud rate, and a RESET, interrupted at every step: test/firmware/library/change.c.

At every byte of every packet and reply of the undisturbed course: that byte is lost, or the servo
loses its power there, for no time at all, for some of the transaction, or for longer than it. The
simulator then says where the servo really is; what was reported must be true, and a scan of both
rates must find the servo there, and its neighbour untouched.
"""
# needs: build/atmega128/firmware/change.elf
import collections
import re
import unittest

from simulator import LONG, Run

ELF = "build/atmega128/firmware/change.elf"
CHANGED, UNCHANGED, LOST, BOTH = 1, 2, 4, 5
NEIGHBOUR = (5, 1)
MOMENT_MS, LONG_MS = 2, 12  # a transaction takes 5 ms, and 9 ms if nobody answers
PART = 9  # make test: every ninth fault; make test-long: all
DEAF_MS = 1000  # after power-up, of servos that need so long to start


class Change:
    """What is said for it; from and to are (ID, baud register)."""

    def __init__(self, command, source, target, deaf_ms=0):
        self.command, self.source, self.target = command, source, target
        self.deaf_ms = deaf_ms
        self.ids = f"{source[0]},{target[0]}" if source[0] != target[0] else f"{source[0]}"
        self.rates = sorted({1, source[1], target[1]})

    def begin(self):
        """Fresh servos, and the one that is to change where it starts from."""
        lines = [f"@servos {self.source[0]},{NEIGHBOUR[0]}", "rate 1"]
        if self.deaf_ms:
            lines += [f"@fault quirk {self.source[0]} silent_after_power_up 1",
                      f"@wait {self.deaf_ms}"]
        if self.source[1] != 1:
            lines += [f"baud {self.source[0]} {self.source[1]}"]
        return lines

    def round(self, fault):
        """One interrupted change; and, when the servo has its power again, where it is, what is
        reported then, and who is found."""
        servo = self.source[0]
        return self.begin() + [
            f"@print BEGIN {fault}", f"@fault {fault}", self.command, "@fault clear",
            f"@wait {LONG_MS + 1 + self.deaf_ms}", "@print LATER", f"@show servo {servo} ID",
            f"@show servo {servo} BAUD_RATE", "again", *[f"scan {rate}" for rate in self.rates]]

    def simulate(self, lines):
        run = Run(ELF, "--echo", servos=f"{self.source[0]},{NEIGHBOUR[0]}",
                  script="".join(line + "\n" for line in lines))
        if run.status != 0:
            raise AssertionError(run.output[-2000:])
        return run

    def course(self):
        """The undisturbed one: (way, bytes) of each packet."""
        before = len(self.simulate(self.begin()).packets)
        packets = self.simulate(self.begin() + [self.command]).packets
        return [(way, bytes.fromhex(text)) for _, way, text in packets[before:]]

    def faults(self):
        """(what, whether in or out, number of the packet, order)"""
        number = collections.Counter()
        for way, packet in self.course():
            number[way] += 1
            at = number[way]
            if way == "->in":
                for byte in range(len(packet)):
                    yield "lost", way, at, f"lose in {at} {byte}"
                    for ms in (0, MOMENT_MS, LONG_MS):
                        yield "power", way, at, f"unplug in {at} {byte} {self.ids} {ms}"
            else:
                for byte in range(len(packet)):
                    yield "lost", way, at, f"lose out {at} {byte}"
                for byte in range(len(packet) + 1):
                    for ms in (0, MOMENT_MS, LONG_MS):
                        yield "power", way, at, f"cut out {at} {byte} {ms}"


class Outcome:
    """What one round printed."""

    def __init__(self, text):
        at_once, later = text.split("LATER\n")
        self.state, self.baud = self.reported(at_once)
        self.later, self.later_baud = self.reported(later)
        self.written = int(re.search(r"^written (\d)$", at_once, re.M)[1]) != 0
        self.place = tuple(int(value) for value in
                           re.findall(r"^servo \d+ (?:ID|BAUD_RATE) (\d+)$", later, re.M))
        self.found = [divmod(int(value), 1000) for value in
                      re.findall(r"^found (\d+)$", later, re.M)]

    @staticmethod
    def reported(text):
        return tuple(int(re.search(rf"^{name} (\d+)$", text, re.M)[1]) for name in ("state", "baud"))


class Identity(unittest.TestCase):
    def check(self, change, fault, outcome):
        """What must hold whatever was interrupted."""
        _, _, _, order = fault
        told = f"{change.command}: {order}: {vars(outcome)}"
        self.assertIn(outcome.place, (change.source, change.target), told)
        self.assertIn(outcome.state, (CHANGED, UNCHANGED, LOST), told)
        where = {CHANGED: change.target, UNCHANGED: change.source}
        for state, baud in ((outcome.state, outcome.baud), (outcome.later, outcome.later_baud)):
            if state != LOST:
                self.assertEqual(where[state], outcome.place, told)
                self.assertEqual(baud, where[state][1], told)
        self.assertNotEqual(outcome.later, LOST, told)
        self.assertEqual(sorted(outcome.found), sorted([outcome.place, NEIGHBOUR]), told)
        if not outcome.written:
            self.assertEqual(outcome.place, change.source, told)

    def check_unlisted(self, change, fault, outcome):
        """The new rate lasts until the servo loses its power: what was true when it was reported
        may be over by then, but no other place can come of it than the old one."""
        what, _, _, order = fault
        told = f"{change.command}: {order}: {vars(outcome)}"
        self.assertIn(outcome.place, (change.source, change.target), told)
        if what == "lost" or outcome.place == change.target:
            self.check(change, fault, outcome)
        else:
            self.assertIn(outcome.state, (CHANGED, UNCHANGED, LOST, BOTH), told)
            self.assertIn(outcome.later, (outcome.state, UNCHANGED), told)
            self.assertEqual(sorted(outcome.found), [outcome.place, NEIGHBOUR], told)

    def check_lost(self, change, fault, outcome, write):
        """A byte that was lost cannot have stopped the change but in the WRITE itself."""
        _, way, number, order = fault
        expected = UNCHANGED if (way, number) == write else CHANGED
        self.assertEqual(outcome.state, expected, f"{change.command}: {order}")

    def interrupt(self, change, check, every=1 if LONG else PART):
        course = change.course()
        instructions = [packet[4] for way, packet in course if way == "->in"]
        write = "->in", 1 + next(n for n, what in enumerate(instructions) if what != 1)
        faults = list(change.faults())[::every]
        run = change.simulate([line for fault in faults for line in change.round(fault[-1])])
        self.assertIn("rules:   none broken", run.output)
        rounds = re.split(r"^BEGIN .*\n", run.output, flags=re.M)[1:]
        self.assertEqual(len(rounds), len(faults))
        self.assertEqual(re.search(r"; (\d+) of \d+ orders came to nothing", run.output)[1], "0")
        states = collections.Counter()
        for fault, text in zip(faults, rounds):
            outcome = Outcome(text)
            states[outcome.state] += 1
            check(change, fault, outcome)
            if fault[0] == "lost":
                self.check_lost(change, fault, outcome, write)
        for state in (CHANGED, UNCHANGED, LOST):  # else nothing was interrupted
            self.assertGreaterEqual(states[state], 12 // every, (change.command, states))

    def test_a_change_of_id(self):
        self.interrupt(Change("id 3 7", (3, 1), (7, 1)), self.check)

    def test_a_change_of_the_baud_rate(self):
        self.interrupt(Change("baud 3 3", (3, 1), (3, 3)), self.check)

    def test_a_change_to_a_rate_that_is_gone_without_power(self):
        self.interrupt(Change("baud 3 2", (3, 1), (3, 2)), self.check_unlisted)

    def test_a_servo_that_is_deaf_for_a_second_after_power_up(self):
        self.interrupt(Change("id 3 7", (3, 1), (7, 1), DEAF_MS), self.check, every=7 if LONG else 3 * PART)

    def test_a_reset(self):
        self.interrupt(Change("reset 3", (3, 1), (1, 1)), self.check)

    def test_a_reset_that_changes_id_and_rate(self):
        self.interrupt(Change("reset 3", (3, 3), (1, 1)), self.check)


if __name__ == "__main__":
    unittest.main()
