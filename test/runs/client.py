# SPDX-License-Identifier: MIT
"""A client for CDS55xx servos (Dynamixel protocol 1.0) at a serial port, Python 3 and nothing else.

It works on a USB2Dynamixel as on the simulator's pty:

    with Port("/dev/pts/5") as port:
        print(port.scan(range(1, 19)))
        port.write(1, TORQUE_ENABLE, [1])
        port.sync_write(GOAL_POSITION, {1: word(200) + word(300)})
        print(port.read_word(1, PRESENT_POSITION))
"""
import os
import select
import termios
import time
import tty

PING, READ, WRITE, REG_WRITE, ACTION, RESET, SYNC_WRITE = 1, 2, 3, 4, 5, 6, 0x83
BROADCAST = 0xFE

ID, BAUD, RETURN_LEVEL, TORQUE_ENABLE, LED = 0x03, 0x04, 0x10, 0x18, 0x19
CCW_LIMIT, GOAL_POSITION, MOVING_SPEED, PRESENT_POSITION, MOVING = 0x08, 0x1E, 0x20, 0x24, 0x2E
PRESENT_VOLTAGE = 0x2A


class NoReply(Exception):
    """Nothing, or nothing whole, came back in time."""


class ServoError(Exception):
    """The servo has answered with error bits: .bits"""

    def __init__(self, bits):
        super().__init__(f"error bits 0x{bits:02X}")
        self.bits = bits


def word(value):
    """A 16-bit register's two bytes."""
    return [value & 0xFF, value >> 8]


def packet(servo, instruction, parameters=()):
    body = [servo, len(parameters) + 2, instruction, *parameters]
    return bytes([0xFF, 0xFF, *body, ~sum(body) & 0xFF])


class Port:
    """A serial port with servos at it. A reply is waited for `timeout` seconds; it comes much sooner,
    so the time matters only where no servo replies."""

    def __init__(self, path, baud=1000000, timeout=60):
        self.file = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        self.timeout = timeout
        tty.setraw(self.file)
        self.set_baud(baud)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        os.close(self.file)

    def set_baud(self, baud):
        self.baud = baud
        speed = getattr(termios, f"B{baud}")
        mode = termios.tcgetattr(self.file)
        mode[4] = mode[5] = speed
        termios.tcsetattr(self.file, termios.TCSADRAIN, mode)

    def send(self, raw):
        while raw:
            select.select([], [self.file], [])
            raw = raw[os.write(self.file, raw):]

    def receive(self, size, timeout):
        """At most `size` bytes, fewer when the time is over."""
        end = time.monotonic() + timeout
        got = b""
        while len(got) < size:
            rest = max(end - time.monotonic(), 0)
            if not select.select([self.file], [], [], rest)[0]:
                break
            got += os.read(self.file, size - len(got))
        return got

    def transaction(self, servo, instruction, parameters=(), timeout=None):
        """The parameters of the status packet, as bytes; None where no servo answers."""
        termios.tcflush(self.file, termios.TCIFLUSH)
        self.send(packet(servo, instruction, parameters))
        if servo == BROADCAST and instruction != PING:
            return None
        timeout = self.timeout if timeout is None else timeout
        head = self.receive(4, timeout)
        if len(head) < 4 or head[:2] != b"\xFF\xFF" or servo not in (head[2], BROADCAST):
            raise NoReply(f"servo {servo}: {head.hex(' ')}")
        rest = self.receive(head[3], timeout)
        if len(rest) < head[3] or sum(head[2:] + rest) & 0xFF != 0xFF:
            raise NoReply(f"servo {servo}: {(head + rest).hex(' ')}")
        if rest[0]:
            raise ServoError(rest[0])
        return rest[1:-1]

    def ping(self, servo, timeout=None):
        try:
            self.transaction(servo, PING, timeout=timeout)
            return True
        except NoReply:
            return False

    def clear(self):
        """A servo that has heard another rate may have taken noise for the head of a packet, and
        wait for its missing bytes: 254 bytes at most."""
        self.send(bytes(254))
        time.sleep(254 * 10 / self.baud + 0.005)

    def scan(self, ids, present=(), absence=0.02):
        """The servos that reply. For those that should be `present` the scan has patience; an absent
        one costs `absence` seconds."""
        return [servo for servo in ids if self.ping(servo, None if servo in present else absence)]

    def read(self, servo, address, count):
        return self.transaction(servo, READ, [address, count])

    def read_word(self, servo, address):
        return int.from_bytes(self.read(servo, address, 2), "little")

    def write(self, servo, address, values):
        self.transaction(servo, WRITE, [address, *values])

    def sync_write(self, address, values):
        """values: {servo: bytes}, as many for each."""
        size = len(next(iter(values.values())))
        blocks = [byte for servo, block in values.items() for byte in (servo, *block)]
        self.transaction(BROADCAST, SYNC_WRITE, [address, size, *blocks])
