# SPDX-License-Identifier: MIT
"""A client for Dynamixel protocol 1.0 gets the same answers through the firmware's bridge as from
the servos themselves."""
# needs: $(CONSOLE_ELFS)
import pathlib
import subprocess
import tempfile
import termios
import time
import unittest

import boards
import client
from client import (ACTION, BAUD, BROADCAST, GOAL_POSITION, ID, LED, PING, PRESENT_POSITION, READ,
                    REG_WRITE, RESET, RETURN_LEVEL, SYNC_WRITE, TORQUE_ENABLE, WRITE, NoReply, Port,
                    packet, word)
from simulator import LONG, ROOT, SIM, Process, in_mode_program

DEVICE, OFF = 253, 254
SYNC_READ, BULK_READ = 0x84, 0x92
DEVICE_ID, HOST_BAUD, BUS_BAUD, FAILED, FAILED_IDS = 0x03, 0x04, 0x05, 0x16, 0x50
BUS_SENT, BUS_OK, BUS_TIMEOUTS, HOST_MALFORMED, HOST_SILENT = 0x18, 0x1C, 0x1E, 0x36, 0x38
BROADCAST_PING = packet(BROADCAST, PING)


def bridge(*options, servos="1-18", board="atmega128"):
    return Process("firmware", str(ROOT / f"build/{board}/controller.elf"), "--board", board,
                   "--host", "pty", "--host-baud", "client", "--servos", servos, *options)


def bus(*options, servos="1-18"):
    return Process("bus", "--pty", "--servos", servos, *options)


class Client(Port):
    """A port that returns the bytes that came, unchecked."""

    def __init__(self, sim, baud=115200):
        super().__init__(sim.path, baud)
        self.sim = sim
        sim.settle(0.05)

    def ask(self, raw, size=None, silence=0.03):
        """Sends, and returns the bytes that come: `size` of them, or all until the simulator has been silent
        for `silence` seconds; 0.2 s if nothing comes at all."""
        self.send(raw)
        if size:
            return self.receive(size, self.timeout)
        got, wait = b"", silence
        while wait:
            self.sim.settle(wait)
            more = self.receive(1000, 0)
            wait = silence if more else 0.2 if not got and wait < 0.2 else 0
            got += more
        return got

    def status(self):
        """One status packet: (ID, error, parameters)."""
        head = self.receive(4, self.timeout)
        assert head[:2] == b"\xFF\xFF", head.hex(" ")
        rest = self.receive(head[3], self.timeout)
        assert sum(head[2:] + rest) & 0xFF == 0xFF, (head + rest).hex(" ")
        return head[2], rest[0], rest[1:-1]

    def device(self, address, count=1):
        return int.from_bytes(self.read(DEVICE, address, count), "little")

    def switch_device_off(self):
        self.write(DEVICE, DEVICE_ID, [OFF])


class BothWays(unittest.TestCase):
    """Compares the answers to each packet through the bridge and on the bus, each with new servos."""

    def compare(self, packets, servos="1-18"):
        answers = []
        with bus(servos=servos) as sim, Client(sim, 1000000) as port:
            answers.append([port.ask(raw) for raw in packets])
        with bridge(servos=servos) as sim, Client(sim) as port:
            port.switch_device_off()
            answers.append([port.ask(raw) for raw in packets])
            sim.end()
            self.assertEqual(sim.status, 0, sim.output)
        for raw, direct, bridged in zip(packets, *answers):
            self.assertEqual(bridged.hex(" "), direct.hex(" "), raw.hex(" "))
        return answers[0]

    def test_every_instruction_with_every_outcome(self):
        packets = [
            packet(1, PING), packet(1, READ, [0x2B, 1]), packet(1, READ, [0, 50]),
            packet(1, READ, [0x31, 1]), packet(1, READ, [0, 51]), packet(1, READ, [0, 0]),
            packet(1, READ, [50, 1]), packet(1, READ, [3]), packet(1, READ, [3, 1, 1]),
            packet(1, WRITE, [LED, 1]), packet(1, READ, [LED, 1]), packet(1, WRITE, [LED, 2]),
            packet(1, WRITE, [0x01, 9]), packet(1, WRITE, [LED]), packet(1, WRITE, [0x06, *word(300)]),
            packet(1, WRITE, [GOAL_POSITION, *word(100)]), packet(1, ACTION),
            packet(1, REG_WRITE, [LED, 0]), packet(1, READ, [0x2C, 1]), packet(1, ACTION),
            packet(1, READ, [LED, 1]), packet(2, REG_WRITE, [LED, 1]), packet(BROADCAST, ACTION),
            packet(2, READ, [LED, 1]), packet(1, 0x07), packet(1, 0xFF, [1, 2, 3]), packet(1, 0x84, [1]),
            packet(BROADCAST, SYNC_WRITE, [LED, 1, 1, 1, 3, 1]), packet(3, READ, [LED, 1]),
            packet(5, SYNC_WRITE, [LED, 1, 5, 1]), packet(BROADCAST, READ, [0, 1]),
            packet(BROADCAST, WRITE, [LED, 1]), packet(18, READ, [LED, 1]),
            packet(4, WRITE, [RETURN_LEVEL, 1]), packet(4, WRITE, [LED, 0]), packet(4, READ, [LED, 1]),
            packet(4, WRITE, [RETURN_LEVEL, 0]), packet(4, READ, [LED, 1]), packet(4, PING),
            packet(6, WRITE, [ID, 77]), packet(77, READ, [ID, 1]), packet(6, PING),
            packet(1, WRITE, [ID, 100]), packet(77, RESET), packet(77, PING), packet(1, READ, [0, 10]),
            packet(1, WRITE, [0x2F, 1]), packet(1, WRITE, [ID, 200]), packet(1, RESET),
            packet(99, PING), packet(99, WRITE, [LED, 1]), packet(0, READ, [0, 2]),
            packet(BROADCAST, 0x92, [0, 1, 1, 0]), packet(BROADCAST, 0x84, [0, 1, 1]),
        ]
        answers = self.compare(packets)
        silent = [raw for raw, answer in zip(packets, answers) if not answer]
        self.assertCountEqual(silent, [raw for raw in packets if raw[2] in (BROADCAST, 99, 0)] + [
            packet(4, WRITE, [LED, 0]), packet(4, WRITE, [RETURN_LEVEL, 0]),  # at level 1
            packet(4, READ, [LED, 1]), packet(6, PING),       # at level 0; the servo now has ID 77
            packet(77, PING)])           # the servo is reset

    def test_the_longest_packets(self):
        blocks = [byte for servo in range(50) for byte in (servo, *word(servo * 20), *word(512))]
        answers = self.compare([
            packet(BROADCAST, SYNC_WRITE, [GOAL_POSITION, 4, *blocks]),
            packet(18, READ, [GOAL_POSITION, 4]), packet(1, WRITE, range(252)),
            packet(1, READ, [0, 50])])
        self.assertEqual(answers[1][5:-1], bytes(word(360) + word(512)))

    def test_all_254_ids(self):
        servos = list(range(254))
        pings = [packet(servo, PING) for servo in servos]
        reads = [packet(servo, READ, [ID, 1]) for servo in servos]
        with bus(servos="0-253") as sim, Client(sim, 1000000) as port:
            direct = [port.ask(raw, size) for raws, size in ((pings, 6), (reads, 7)) for raw in raws]
        with bridge(servos="0-253") as sim, Client(sim) as port:
            port.switch_device_off()
            bridged = [port.ask(raw, size) for raws, size in ((pings, 6), (reads, 7)) for raw in raws]
        self.assertEqual(bridged, direct)
        self.assertEqual([answer[2] for answer in bridged], servos * 2)

    def test_a_broadcast_ping_finds_the_only_servo(self):
        answers = self.compare([BROADCAST_PING], servos="42")
        self.assertEqual(answers, [b"\xff\xff\x2a\x02\x00\xd3"])

class Bridge(unittest.TestCase):
    def test_packets_sent_without_waiting_are_answered_in_order(self):
        with bridge() as sim, Client(sim) as port:
            for _ in range(3):
                ids = [*range(1, 19), *range(18, 0, -1)]
                port.send(b"".join(packet(servo, READ, [ID, 1]) for servo in ids))
                self.assertEqual([port.status() for _ in ids],
                                 [(servo, 0, bytes([servo])) for servo in ids])

    def test_a_damaged_packet_is_dropped_and_costs_only_itself(self):
        with bridge(servos="1") as sim, Client(sim) as port:
            good = packet(1, READ, [ID, 1])
            for at in range(2, len(good)):
                damaged = bytearray(good)
                damaged[at] ^= 0x41
                if at == 3:
                    damaged[at] = 2 # a shorter packet; its last bytes remain
                self.assertEqual(port.ask(bytes(damaged)), b"", damaged.hex(" "))
                self.assertEqual(port.ask(good, 7).hex(" "), "ff ff 01 03 00 01 fa")
            self.assertEqual(port.device(HOST_MALFORMED, 2), len(good) - 2)
            self.assertEqual(port.device(BUS_SENT, 2), len(good) - 2)

    def test_a_packet_that_stops_is_dropped_after_50_ms(self):
        with bridge(servos="1") as sim, Client(sim) as port:
            good = packet(1, PING)
            for cut in range(2, len(good)):
                port.send(good[:cut])
                sim.settle(0.08)
                self.assertEqual(port.ask(b"ping 1\r", 4), b"ok\r\n")
            self.assertEqual(port.device(HOST_SILENT, 2), len(good) - 2)

    def test_text_and_packets_alternate_packet_drops_half_a_line(self):
        with bridge(servos="1") as sim, Client(sim) as port:
            for _ in range(5):
                self.assertEqual(port.ask(b"ping 1\r" + packet(1, PING) + b"version\r"
                                          + b"write 1 LED " + packet(1, READ, [ID, 1]) + b"ping 1\r",
                                          silence=0.1).count(b"ok\r\n"), 3)
            self.assertEqual(port.read(1, LED, 1), b"\x00")

    def test_a_status_packet_is_never_torn_by_text(self):
        with bridge(servos="1") as sim, Client(sim) as port:
            whole = port.ask(packet(1, READ, [0, 50]), 56)
            for milliseconds in range(1, 40, 2 if LONG else 5):
                port.send(b"help\r")
                time.sleep(milliseconds / 1000)  # at any moment
                said = port.ask(packet(1, READ, [0, 50]) + b"version\r", silence=0.1)
                self.assertIn(whole, said)
                self.assertEqual(said.replace(whole, b"").count(b"\nok\r\n"), 2, said)

    def test_ctrl_x_behind_packets_does_not_wait_for_them(self):
        absent = packet(BROADCAST, SYNC_READ, [ID, 1, *range(100, 200)]) # 1 ms each
        with tempfile.TemporaryDirectory() as folder:
            said, wire = pathlib.Path(folder, "said"), pathlib.Path(folder, "wire")
            said.write_text(f"say {(absent + packet(1, PING)).hex(' ')} 18\nwait 300000\n")
            options = ["firmware", ROOT / "build/atmega128/controller.elf", "--board", "atmega128", "--servos", "1",
                       "--host", said, "--transcript", wire]
            done = subprocess.run([SIM, *options, *in_mode_program(options, folder)],
                                  stdout=subprocess.PIPE, text=True)
            packets = wire.read_text().splitlines()
        self.assertEqual(done.returncode, 0, done.stdout)
        off = next(int(line.split()[0]) for line in packets if "FF FF FE 04 03 18 00 E2" in line)
        self.assertLess(off - int(done.stdout.split()[2]), 10000 * 16) # not the 100 ms of them all

    def test_scan_drops_a_sync_read_that_it_delays(self):
        """A PING 20 ms later ends the scan. Its status packet is the only one."""
        first = packet(BROADCAST, SYNC_READ, [ID, 1, *range(100, 150)]) + b"scan all\r"
        with tempfile.TemporaryDirectory() as folder:
            said = pathlib.Path(folder, "said")
            said.write_text(f"say {first.hex(' ')}\nwait 20000\nsay {packet(1, PING).hex(' ')}\n"
                            "wait 200000\nrest\n")
            options = ["firmware", ROOT / "build/atmega128/controller.elf", "--board", "atmega128", "--servos",
                       "1-18", "--host", said]
            done = subprocess.run([SIM, *options, *in_mode_program(options, folder)],
                                  stdout=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 0, done.stdout)
        heard = next(line for line in done.stdout.splitlines() if line.startswith("heard"))
        self.assertEqual(heard.count("FF FF"), 1, heard)
        self.assertIn("FF FF 01 02 00 FC", heard)

    def test_on_every_board(self):
        for board in boards.CONSOLES[1:]:
            baud = boards.BOARDS[board].host_bps
            with self.subTest(board), bridge(servos="1-3", board=board) as sim, \
                    Client(sim, baud) as port:
                self.assertEqual(port.scan(range(5), [1, 2, 3], 0.1), [1, 2, 3])
                self.assertEqual(port.read(1, ID, 1), b"\x01")
                port.write(DEVICE, HOST_BAUD, [1])
                sim.settle(0.02)
                port.set_baud(1000000)
                sim.settle(0.02)
                port.sync_write(LED, {1: [1], 3: [1]})
                port.send(packet(BROADCAST, SYNC_READ, [LED, 1, 1, 2, 9, 3]))
                self.assertEqual(port.status(), (DEVICE, 0x80, b"\x01\x00\xff\x01"))
                port.send(packet(BROADCAST, BULK_READ, [0, 1, 3, LED, 50, 2, 0, 2, DEVICE, 0]))
                self.assertEqual(port.status(), (3, 0, b"\x01"))
                self.assertEqual(len(port.status()[2]), 50)
                self.assertEqual(port.status(), (DEVICE, 0, b"\x55\xcd"))
                self.assertEqual(port.ask(b"ping 1\r", 4), b"ok\r\n")
                sim.end()
                self.assertEqual(sim.status, 0, sim.output)

    def test_too_much_text_is_answered_by_a_numbered_error(self):
        with bridge(servos="1") as sim, Client(sim) as port:
            self.assertIn(b"error 36: ", port.ask(b"help\r" * 20, silence=0.3))
            self.assertEqual(port.ask(b"ping 1\r", 4), b"ok\r\n")
            self.assertTrue(port.ping(1))


class Device(unittest.TestCase):
    def test_it_answers_in_the_manner_of_a_servo(self):
        with bridge(servos="1") as sim, Client(sim) as port:
            for raw, error, parameters in [
                    (packet(DEVICE, PING), 0, b""),
                    (packet(DEVICE, READ, [0, 2]), 0, b"\x55\xcd"),
                    (packet(DEVICE, READ, [0, 0]), 0x08, b""),
                    (packet(DEVICE, READ, [0, 0x77]), 0x08, b""),
                    (packet(DEVICE, READ, [0x76, 1]), 0x08, b""),
                    (packet(DEVICE, READ, [0]), 0x40, b""),
                    (packet(DEVICE, WRITE, [0, 1]), 0x08, b""),
                    (packet(DEVICE, WRITE, [0x07, 3]), 0x08, b""),
                    (packet(DEVICE, WRITE, [0x07, 2, 3]), 0x08, b""),  # the second byte is out of range
                    (packet(DEVICE, READ, [0x07, 2]), 0, b"\x00\x00"), # neither byte was stored
                    (packet(DEVICE, WRITE, [0x07, 2, 1]), 0, b""),
                    (packet(DEVICE, READ, [0x07, 2]), 0, b"\x02\x01"),
                    (packet(DEVICE, WRITE, [0x0C, 0]), 0, b""),        # low byte of 4000
                    (packet(DEVICE, READ, [0x0C, 2]), 0, b"\x00\x0F"),
                    (packet(DEVICE, WRITE, [0x0D, 1]), 0x08, b""),     # 256 is below 2000
                    (packet(DEVICE, WRITE, [0x4E, 0]), 0x08, b""),     # there is no register
                    (packet(DEVICE, WRITE, [3]), 0x40, b""),
                    (packet(DEVICE, REG_WRITE, [0x07, 1]), 0x40, b""),
                    (packet(DEVICE, RESET, [1]), 0x40, b""),
                    (packet(DEVICE, RESET), 0, b""),
                    (packet(DEVICE, READ, [0x07, 2]), 0, b"\x00\x02")]: # mode person
                port.send(raw)
                self.assertEqual(port.status(), (DEVICE, error, parameters), raw.hex(" "))

    def test_another_id_and_none(self):
        with bridge(servos="1,253") as sim, Client(sim) as port:
            port.write(DEVICE, DEVICE_ID, [1])
            self.assertEqual(port.read(1, 0, 2), b"\x55\xcd")
            self.assertEqual(port.read(DEVICE, 0, 2), b"\x00\x01")
            port.write(1, DEVICE_ID, [OFF])
            self.assertEqual(port.read(1, 0, 2), b"\x00\x01")

    def test_broadcasts_are_not_meant_for_it(self):
        with bridge(servos="1") as sim, Client(sim) as port:
            port.write(BROADCAST, ID, [9])
            self.assertTrue(port.ping(9))
            self.assertTrue(port.ping(DEVICE))

    def test_the_rate_of_the_bus_behind_the_bridge(self):
        with bridge(servos="1-3") as sim, Client(sim) as port:
            port.write(BROADCAST, BAUD, [34])
            port.write(DEVICE, BUS_BAUD, [34])
            self.assertEqual(port.scan(range(5), [1, 2, 3], 0.1), [1, 2, 3])
            port.write(BROADCAST, BAUD, [1])
            port.write(DEVICE, BUS_BAUD, [1])
            self.assertEqual(port.scan(range(5), [1, 2, 3], 0.1), [1, 2, 3])

    def test_the_rate_of_the_host_link(self):
        with bridge(servos="1-3") as sim, Client(sim) as port:
            for register, baud in ((1, 1000000), (3, 500000), (255, 115200)):
                port.write(DEVICE, HOST_BAUD, [register])
                sim.settle(0.02)
                port.set_baud(baud)
                sim.settle(0.02)
                self.assertEqual(port.scan(range(5), [1, 2, 3], 0.1), [1, 2, 3])
                self.assertEqual(port.ask(b"ping 1\r", 4), b"ok\r\n")

    def test_its_counters_are_those_of_the_wire(self):
        with bridge(servos="1") as sim, Client(sim) as port:
            for servo in (1, 2, 1):
                port.ping(servo, 0.05)
            port.send(packet(BROADCAST, WRITE, [LED, 1]))
            port.ping(1)
            self.assertEqual([port.device(at, 2) for at in (BUS_SENT, BUS_OK, BUS_TIMEOUTS)],
                             [5, 4, 1])
            self.assertIn("5 packets in, 3 out", sim.end())


class GroupReads(unittest.TestCase):
    """SYNC READ and BULK READ of servos that answer, are absent or refuse."""

    def failed(self, port):
        bits = int.from_bytes(port.read(DEVICE, FAILED_IDS, 32), "little")
        ids = [servo for servo in range(256) if bits >> servo & 1]
        self.assertEqual(port.device(FAILED), len(ids))
        return ids

    def test_sync_read_of_servos_that_are_there(self):
        with bridge() as sim, Client(sim) as port:
            for to in (BROADCAST, DEVICE):
                port.send(packet(to, SYNC_READ, [ID, 1, *range(18, 0, -1)]))
                self.assertEqual(port.status(), (DEVICE, 0, bytes(range(18, 0, -1))))
            self.assertEqual(self.failed(port), [])

    def test_sync_read_of_all_that_fits_and_of_more(self):
        with bridge(servos="0-251") as sim, Client(sim) as port:
            port.send(packet(BROADCAST, SYNC_READ, [ID, 1, *range(0, 250)]))
            self.assertEqual(port.status(), (DEVICE, 0, bytes(range(0, 250))))
            port.send(packet(BROADCAST, SYNC_READ, [0, 42, *range(6)]))
            servo, error, data = port.status()
            self.assertEqual((error, len(data), data[42 * 5 + 3]), (0, 252, 5))
            for bad in ([0, 50, *range(6)], [0, 0, 1], [0, 1], [0], []):
                port.send(packet(BROADCAST, SYNC_READ, bad))
                self.assertEqual(port.status(), (DEVICE, 0x08, b""), bad)

    def test_sync_read_of_servos_that_fail(self):
        with bridge(servos="1-3") as sim, Client(sim) as port:
            port.write(3, RETURN_LEVEL, [0])
            port.send(packet(BROADCAST, SYNC_READ, [ID, 2, 1, 9, 2, 3, 254, DEVICE]))
            self.assertEqual(port.status(), (DEVICE, 0x80, b"\x01\x01\xff\xff\x02\x01\xff\xff\xff\xff"
                                             b"\xfd\xff"))
            self.assertEqual(self.failed(port), [3, 9, 254])
            port.send(packet(BROADCAST, SYNC_READ, [49, 2, 1])) # beyond the table: the servo refuses
            self.assertEqual(port.status(), (DEVICE, 0x80, b"\xff\xff"))
            self.assertEqual(self.failed(port), [1])

    def bulk(self, port, *items):
        """items: (ID, address, length)"""
        port.send(packet(BROADCAST, BULK_READ, [0, *(byte for servo, address, length in items
                                                     for byte in (length, servo, address))]))

    def test_bulk_read_of_servos_that_are_there(self):
        with bridge() as sim, Client(sim) as port:
            self.bulk(port, *((servo, ID, servo % 9 + 1) for servo in range(18, 0, -1)))
            for servo in range(18, 0, -1):
                got, error, data = port.status()
                self.assertEqual((got, error, data[0], len(data)), (servo, 0, servo, servo % 9 + 1))
            self.assertEqual(self.failed(port), [])
            self.bulk(port, (1, ID, 1), (DEVICE, 0, 2), (1, 0, 50))
            self.assertEqual(port.status(), (1, 0, b"\x01"))
            self.assertEqual(port.status(), (DEVICE, 0, b"\x55\xcd"))
            self.assertEqual(len(port.status()[2]), 50)

    def test_behind_an_absent_servo_none_answers(self):
        with bridge(servos="1-3") as sim, Client(sim) as port:
            self.bulk(port, (1, ID, 1), (9, ID, 1), (2, ID, 1), (3, ID, 1))
            self.assertEqual(port.status(), (1, 0, b"\x01"))
            sim.settle(0.1)
            self.assertEqual(port.receive(1, 0), b"")
            self.assertEqual(self.failed(port), [9])
            self.bulk(port, (3, ID, 1)) # the next BULK READ is not affected
            self.assertEqual(port.status(), (3, 0, b"\x03"))

    def test_one_that_refuses_has_answered_too(self):
        with bridge(servos="1-3") as sim, Client(sim) as port:
            self.bulk(port, (1, ID, 1), (2, 49, 2), (3, 0, 60), (3, ID, 1))
            self.assertEqual(port.status(), (1, 0, b"\x01"))
            self.assertEqual(port.status(), (2, 0x08, b""))
            self.assertEqual(port.status(), (3, 0x08, b""))
            self.assertEqual(port.status(), (3, 0, b"\x03"))

    def test_a_bulk_read_that_makes_no_sense_is_met_with_silence(self):
        with bridge(servos="1") as sim, Client(sim) as port:
            for bad in ([], [0], [0, 1, 1], [0, 1, 1, 3, 1], [0, 1, 254, 3]):
                self.assertEqual(port.ask(packet(BROADCAST, BULK_READ, bad)), b"", bad)
            self.assertTrue(port.ping(1))

    def test_a_client_like_the_sdk(self):
        with bridge(servos="1-6") as sim, Client(sim) as port:
            whole = GroupBulkRead(port, {servo: (PRESENT_POSITION, 8) for servo in (1, 6, DEVICE, 3)})
            lame = GroupBulkRead(port, {servo: (ID, 1) for servo in (1, 2, 9, 3, 4)})
            for _ in range(3):
                self.assertTrue(whole.tx_rx_packet())
                self.assertEqual(whole.data[6], port.read(6, PRESENT_POSITION, 8))
                self.assertFalse(lame.tx_rx_packet())
                self.assertEqual(lame.data, {1: b"\x01", 2: b"\x02"})
                self.assertEqual(lame.skipped, 0)


class GroupBulkRead:
    """Reads as DynamixelSDK's GroupBulkRead for protocol 1.0: one timeout for all packets, a packet for
    each ID in order, packets of other IDs skipped; the first missing packet ends it."""

    def __init__(self, port, items):
        self.port, self.items = port, items

    def tx_rx_packet(self):
        self.data, self.skipped = {}, 0
        termios.tcflush(self.port.file, termios.TCIFLUSH)
        self.port.send(packet(BROADCAST, BULK_READ, [0, *(
            byte for servo, (address, length) in self.items.items()
            for byte in (length, servo, address))]))
        size = sum(length + 7 for _, length in self.items.values())
        self.patience = size * 10 / self.port.baud + 0.034
        return all(self.read_rx(servo) for servo in self.items)

    def receive(self, size):
        """Returns the bytes that come while the client waits, in time of the simulator."""
        got = self.port.receive(size, 0)
        if len(got) < size:
            self.port.sim.settle(self.patience)
            got += self.port.receive(size - len(got), 0)
        return got

    def read_rx(self, servo):
        while True:
            head = self.receive(4)
            if len(head) < 4:
                return False
            rest = self.receive(head[3])
            if sum(head[2:] + rest) & 0xFF != 0xFF:
                return False
            if head[2] == servo:
                self.data[servo] = rest[1:-1]
                return True
            self.skipped += 1


if __name__ == "__main__":
    unittest.main()
