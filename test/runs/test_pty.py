# SPDX-License-Identifier: MIT
"""The pseudo terminals of bus and firmware, under clients that flush, leave and come back at once."""
# needs: build/atmega128/controller.elf
import os
import pathlib
import random
import re
import tempfile
import termios
import time
import unittest

import client
from client import BAUD, GOAL_POSITION, Port, word
from simulator import ROOT, Process, bus, wait_until

STEP_CYCLES = 3200  # 0.2 ms: the steps of the simulator while there is traffic; 1 ms is five
SERVOS = range(1, 19)


def firmware(*options):
    """The firmware with its host link at a pty; the bridge of the firmware hands packets on."""
    return Process("firmware", ROOT / "build/atmega128/controller.elf", "--board", "atmega128",
                   "--servos", "1-18", "--host", "pty", *options)


class Leaving(unittest.TestCase):
    """A client closes the port in mid-packet, and another one opens it a moment later."""

    def assert_packets_are_sent_whole(self, path, baud):
        """A SYNC WRITE of all goals, closed at once; the next client then reads each goal. The
        moment between the two clients varies, so that the simulator sees both leave and arrival in
        most rounds."""
        for base in range(100, 120):
            goals = {servo: base + servo for servo in SERVOS}
            blocks = [byte for servo, goal in goals.items() for byte in (servo, *word(goal))]
            with Port(path, baud) as port:
                port.send(client.packet(client.BROADCAST, client.SYNC_WRITE,
                                        [GOAL_POSITION, 2, *blocks]))
            time.sleep(random.random() * 0.005)
            with Port(path, baud) as port:
                self.assertEqual(goals, {servo: port.read_word(servo, GOAL_POSITION)
                                         for servo in SERVOS})

    def test_bus_sends_packet_of_a_client_that_left_to_its_end(self):
        with bus() as sim:
            with Port(sim.path) as port:
                for servo in SERVOS:  # 62 bytes take 33 ms
                    port.write(servo, BAUD, [103])
                port.set_baud(19200)
                port.clear()  # of what the servos took for the head of a packet
                self.assertTrue(wait_until(lambda: port.scan(SERVOS, SERVOS) == list(SERVOS)))
            self.assert_packets_are_sent_whole(sim.path, 19200)
            self.assertIn(" 1 damaged", sim.end())  # the bytes of clear()

    def test_bytes_of_a_slow_client_leave_before_those_of_the_next(self):
        with tempfile.TemporaryDirectory() as folder:
            transcript = pathlib.Path(folder) / "transcript"
            with bus("--transcript", transcript, servos="1") as sim:
                with Port(sim.path, 9600) as port:
                    port.send(bytes(100))  # 104 ms; no servo takes zeros for a header
                with Port(sim.path) as port:
                    # a client should set its rate a moment after the last byte of another rate
                    self.assertTrue(wait_until(lambda: port.ping(1, 0.5)))
                sim.end()
            text = transcript.read_text()
        before, ping, _ = text.partition("FF FF 01 02 01 FB")
        self.assertTrue(ping, text)
        self.assertEqual(before.count(" 00"), 100, text)

    def test_firmware_hears_packet_of_a_client_that_left_to_its_end(self):
        with firmware() as sim:
            self.assert_packets_are_sent_whole(sim.path, 115200)
            self.assertIn(" 0 damaged", sim.end())

    def test_rate_of_a_client_that_comes_back_at_once_is_kept(self):
        for start in [bus, firmware]:
            with start() as sim:
                for i in range(500):
                    line = os.open(sim.path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
                    rate = [termios.B57600, termios.B1000000][i % 2]
                    mode = termios.tcgetattr(line)
                    mode[0] = mode[1] = mode[3] = 0
                    mode[4] = mode[5] = rate
                    termios.tcsetattr(line, termios.TCSANOW, mode)
                    for _ in range(random.randrange(200)):
                        os.getppid()  # a moment for the simulator, of any length
                    self.assertEqual(termios.tcgetattr(line)[5], rate, i)
                    os.close(line)


class Flushing(unittest.TestCase):
    """Clients that call tcflush(TCOFLUSH) before each packet. The system discards what its worker
    has not yet handed to the simulator's end of the pty. A reply proves that it has, so a client
    that waits for each reply loses nothing."""

    def test_ping_and_reply_with_a_flush_before_each_loses_nothing(self):
        for start in [bus, firmware]:
            with start() as sim, Port(sim.path) as port:
                if start is firmware:
                    port.set_baud(115200)
                for _ in range(300):
                    termios.tcflush(port.file, termios.TCIOFLUSH)
                    self.assertTrue(port.ping(1))
                self.assertIn("300 packets in, 300 out, 0 damaged", sim.end())


class Waking(unittest.TestCase):
    def test_firmware_hears_a_client_between_two_steps(self):
        """If the bytes of a client reached the firmware at the end of a step of real time only, all
        packets of the bus would begin at the same cycle after a step, within 600 cycles."""
        with tempfile.TemporaryDirectory() as folder:
            transcript = pathlib.Path(folder) / "transcript"
            with firmware("--transcript", transcript) as sim, \
                    Port(sim.path, 115200) as port:
                for _ in range(200):
                    self.assertTrue(port.ping(1))
                    for _ in range(random.randrange(1000)):
                        os.getppid()
                sim.end()
            begins = [int(cycle) % STEP_CYCLES for cycle in
                      re.findall(r"^ *(\d+) ->in", transcript.read_text(), re.M)]
        self.assertEqual(len(begins), 200)
        quarters = {begin // (STEP_CYCLES // 4) for begin in begins}
        self.assertEqual(quarters, {0, 1, 2, 3}, sorted(begins))


if __name__ == "__main__":
    unittest.main()
