# SPDX-License-Identifier: MIT
"""A client that behaves as Robotis DynamixelSDK does for protocol 1.0, written from its behaviour.

The SDK sends a request, waits for one status packet of the servo it asked and gives up after

    (bytes of the reply) x (time of a byte) + 2 x 16 ms (latency timer of a USB adapter) + 2 ms

It does not repeat a request. Its C and C++ versions drop received bytes before each request; its
Python version does not, so that a reply that comes too late answers the next request.
"""
import os
import select
import termios
import time

from client import BROADCAST, READ

SUCCESS, TIMEOUT, CORRUPT = "success", "timeout", "corrupt"
STATUS_MIN = 6      # bytes of a status packet without parameters
LATENCY_MS = 16     # of a USB adapter, as the SDK assumes it
MARGIN_MS = 2


def timeout_us(request, baud, latency_ms=LATENCY_MS):
    """How long the SDK waits for the reply to this instruction packet."""
    parameters = request[6] if request[4] == READ else 0
    return (STATUS_MIN + parameters) * 10e6 / baud + (2 * latency_ms + MARGIN_MS) * 1000


class Receiver:
    """Finds status packets in received bytes as the SDK does."""

    def __init__(self):
        self.bytes = bytearray()

    def clear(self):
        self.bytes.clear()

    def packet(self):
        """(SUCCESS, status packet), (CORRUPT, None), or None: more bytes are wanted."""
        while len(self.bytes) >= STATUS_MIN:
            at = self.bytes.find(b"\xFF\xFF")
            if at != 0:
                del self.bytes[:at if at > 0 else len(self.bytes) - 1]
            elif self.bytes[2] > 0xFD or self.bytes[3] > 250 or self.bytes[4] > 0x7F:
                del self.bytes[:1]
            elif len(self.bytes) < self.bytes[3] + 4:
                return None
            else:
                found = bytes(self.bytes[:self.bytes[3] + 4])
                del self.bytes[:len(found)]
                return (SUCCESS, found) if sum(found[2:]) & 0xFF == 0xFF else (CORRUPT, None)
        return None

    def reply(self, servo):
        """The same for the status packet of one servo: those of others are skipped."""
        while True:
            found = self.packet()
            if found is None or found[0] != SUCCESS or found[1][2] == servo:
                return found


class SdkPort:
    """A serial port as the SDK opens it."""

    def __init__(self, path, baud):
        self.file = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        self.baud = baud
        self.receiver = Receiver()
        speed = getattr(termios, f"B{baud}")
        flags = termios.CS8 | termios.CLOCAL | termios.CREAD
        termios.tcflush(self.file, termios.TCIFLUSH)
        termios.tcsetattr(self.file, termios.TCSANOW,
                          [termios.IGNPAR, 0, flags, 0, speed, speed, [b"\0"] * 32])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.close(self.file)

    def send(self, raw):
        os.write(self.file, raw)

    def ask(self, request):
        """(SUCCESS, status packet), or (TIMEOUT or CORRUPT, None). A broadcast has no reply."""
        termios.tcflush(self.file, termios.TCIFLUSH)
        self.receiver.clear()
        self.send(request)
        self.sent = time.monotonic()
        if request[2] == BROADCAST:
            return SUCCESS, None
        while True:
            left = timeout_us(request, self.baud) / 1e6 - (time.monotonic() - self.sent)
            if select.select([self.file], [], [], max(left, 0))[0]:
                self.receiver.bytes += os.read(self.file, 256)
            found = self.receiver.reply(request[2])
            self.ended = time.monotonic()
            if found:
                return found
            if (self.ended - self.sent) * 1e6 > timeout_us(request, self.baud):
                return (CORRUPT if self.receiver.bytes else TIMEOUT), None
