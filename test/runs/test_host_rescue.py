# SPDX-License-Identifier: MIT
"""A saved host_baud that no terminal supports, and the window after a reset in which Enter undoes it."""
# needs: $(CONSOLE_ELFS)
import pathlib
import random
import re
import tempfile
import unittest

import boards
from simulator import Run

TORQUE_OFF = "FF FF FE 04 03 18 00 E2"
KEPT = b"host link at the board's rate: save keeps it\r\n"
OK = b"ok\r\n"
LOCKED = 7843  # bit/s, of host_baud 254
ENTERS = "say 0D\nwait 200000\n" * 3


def hear(expected, within_ms=1000):
    return f"hear {len(expected)} within {within_ms}\n"


def host_baud(register, board="atmega128"):
    """(lines that ask for the setting, the reply of the console)"""
    rate = f", {2000000 // (register + 1)}bps"
    if register == 255:  # the board's own, as a chip with room for longer texts says
        bps = 57600 if board == "cm510" else 115200
        rate = f", {bps}bps, the board's own" if board in boards.WITH_ADVICE else ""
    answer = f"host_baud = {register} register{rate}\r\nok\r\n".encode()
    return "text settings host_baud\n" + hear(answer), answer


def save_host_baud(register, baud):
    """The steps of a person who tries a rate with a terminal that changes its rate, too."""
    return (f"text settings host_baud {register}\n" + hear(OK) + f"wait 20000\nbaud {baud}\ntext save\n" +
            hear(OK, 3000))


def reset(cause, baud):
    return f"reset {cause}\nbaud {baud}\nwait 50000\n"


def packet(*body):
    """A protocol packet: ID, instruction, parameters."""
    body = [body[0], len(body), *body[1:]]
    return bytes([0xFF, 0xFF, *body, ~sum(body) & 0xFF])


def say(data):
    return f"say {data.hex(' ')}\n"


def heard_at_own_rate(data, bit_us=8.5):
    """The bytes that a receiver at 117647 bit/s makes of bytes at 1 Mbps; None for a damaged byte."""
    line = [1] * 100
    for byte in data:
        line += [0, *(byte >> bit & 1 for bit in range(8)), 1]
    line += [1] * 200
    at, heard = 1, []
    while at < len(line) - 100:
        if not line[at - 1] or line[at]:
            at += 1
        elif line[int(at + bit_us / 2)]:  # no start bit
            at = int(at + bit_us / 2) + 1
        else:
            bits = [line[int(at + (bit + 0.5) * bit_us)] for bit in range(1, 10)]
            heard.append(sum(level << bit for bit, level in enumerate(bits[:8])) if bits[8] else None)
            at = int(at + 9.5 * bit_us) + 1
    return heard


def imitation(byte, rng):
    """A WRITE at 1 Mbps of which a receiver at the board's own rate hears this byte last."""
    for _ in range(20000):
        write = packet(9, 3, 0x1E, *rng.randbytes(40))
        if heard_at_own_rate(write)[-1:] == [byte]:
            return write
    raise AssertionError(f"no packet looks like {byte}")


class Rescue(unittest.TestCase):
    def run_pc(self, program, board="atmega128"):
        """A Run with .heard: the bytes of each `hear` and `rest`, behind the two of save_host_baud()."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "pc"
            path.write_text(program)
            run = Run(f"build/{board}/controller.elf", "--host", path, board=board)
        self.assertEqual(run.status, 0, run.output)
        heard = [bytes.fromhex(words) for words in
                 re.findall(r"^heard \d+ \d+ \d+((?: \w\w)+)$", run.output, re.M)]
        self.assertEqual(heard[:2], [OK, OK])
        run.heard = heard[2:]
        return run

    def sent(self, run):
        return [data for _, way, data in run.packets if way == "->in"]

    def test_three_enters_bring_own_rate_back(self):
        for board in boards.CONSOLES:
            ask, answer = host_baud(255, board)
            own = boards.BOARDS[board].host_bps
            for cause in ["power", "external"]:
                run = self.run_pc(
                    save_host_baud(254, LOCKED) + reset(cause, own) + ENTERS + hear(KEPT) + ask +
                    "text save\n" + hear(OK) + reset("external", own) + ask, board)
                self.assertEqual(run.heard, [KEPT, answer, OK, answer], board)

    def test_own_rate_unsaved_ends_at_the_next_reset(self):
        ask, answer = host_baud(254)
        run = self.run_pc(save_host_baud(254, LOCKED) + reset("external", 115200) + ENTERS + hear(KEPT) +
                          reset("watchdog", LOCKED) + ask)
        self.assertEqual(run.heard, [KEPT, answer])

    def test_own_rate_stays_after_the_window(self):
        ask, answer = host_baud(255)
        run = self.run_pc(save_host_baud(254, LOCKED) + reset("external", 115200) + ENTERS + hear(KEPT) +
                          "wait 3000000\n" + ask)
        self.assertEqual(run.heard, [KEPT, answer])

    def test_without_enter_saved_rate_returns_after_window(self):
        ask, answer = host_baud(254)
        for cause in ["power", "external"]:
            run = self.run_pc(save_host_baud(254, LOCKED) + reset(cause, LOCKED) +
                              "wait 1850000\ntext version\nwait 40000\nrest\nwait 150000\n" + ask)
            self.assertEqual(run.heard, [answer], cause)

    def test_two_enters_do_not_keep_the_own_rate(self):
        ask, answer = host_baud(254)
        run = self.run_pc(save_host_baud(254, LOCKED) + reset("external", 115200) +
                          "say 0D\nsay 0D 0A\nsay 20 0D\nwait 2200000\n"
                          f"rest\nbaud {LOCKED}\n" + ask)
        self.assertEqual(run.heard, [answer])

    def test_no_window_after_watchdog_and_brown_out(self):
        ask, answer = host_baud(254)
        for cause in ["watchdog", "brown-out"]:
            run = self.run_pc(save_host_baud(254, LOCKED) + reset(cause, LOCKED) + ask)
            self.assertEqual(run.heard, [answer], cause)

    def test_no_window_if_saved_rate_is_the_own_rate(self):
        ask, answer = host_baud(16)
        run = self.run_pc(save_host_baud(16, 115200) + reset("power", 115200) + ask)
        self.assertEqual(run.heard, [answer])

    def test_window_takes_no_command_and_no_packet(self):
        ask, answer = host_baud(254)
        run = self.run_pc(save_host_baud(254, LOCKED) + reset("external", 115200) +
                          say(packet(1, 1)) + say(packet(1, 3, 0x19, 1)) + "text torque 1 on\n"
                          "text write 1 LED 1\nwait 2200000\nrest\n" + f"baud {LOCKED}\n" + ask)
        self.assertEqual(run.heard, [answer])
        self.assertEqual(self.sent(run), [])

    def test_ctrl_x_in_the_window_stops(self):
        ask, answer = host_baud(254)
        run = self.run_pc(save_host_baud(254, LOCKED) + reset("external", 115200) +
                          "say 18\nwait 500000\nrest\nwait 1700000\n" + f"baud {LOCKED}\n" + ask)
        self.assertEqual(self.sent(run).count(TORQUE_OFF), 3)
        self.assertTrue(run.heard[0].endswith(OK), run.heard)
        self.assertEqual(run.heard[1:], [answer])

    def test_watchdog_is_fed_in_the_window(self):
        answer = b"reset by external\r\n"
        run = self.run_pc(save_host_baud(254, LOCKED) + reset("external", LOCKED) +
                          "wait 2100000\ntext status\n" + hear(answer))
        self.assertEqual(run.heard, [answer])

    def test_program_at_the_saved_rate_is_no_rescue(self):
        """At 1 Mbps, as DynamixelSDK and others talk: a byte of the board's own rate is nine of these.

        Shortly before the window ends, the program becomes as slow as the bus: bytes that the board
        loses may leave a Ctrl-X in a damaged packet, which is a stop (docs/bridge.md).
        """
        rng = random.Random(15)
        all_ids = [1, 2, 3, 4, 5, 6, 17, 18]

        def read():
            return packet(rng.choice(all_ids), 2, rng.randrange(50), rng.randrange(1, 9))

        def write():
            return packet(rng.choice(all_ids), 3, 0x1E, *rng.randbytes(rng.randrange(1, 5)))

        def sync_write():
            goals = [byte for id in all_ids for byte in (id, *rng.randbytes(2))]
            return packet(254, 0x83, 0x1E, 2, *goals)

        def zeros():
            return packet(254, 0x83, 0x1E, 4, *[0] * rng.randrange(60))

        like_enter, like_ctrl_x = imitation(0x0D, rng), imitation(0x18, rng)
        one_read = packet(1, 2, 0x24, 2)
        streams = {
            "a READ again and again": (lambda: one_read, 36000),
            "a PING again and again": (lambda: packet(1, 1), 22000),
            "READs": (read, 36000),
            "READs, quick": (read, 400),
            "WRITEs": (write, 700),
            "SYNC WRITEs": (sync_write, 4000),
            "SYNC WRITEs of zeros": (zeros, 1500),
            "what looks like Enter": (lambda: like_enter, 2000),
            "what looks like Ctrl-X": (lambda: like_ctrl_x, 30000),
            "all kinds": (lambda: rng.choice([read, write, sync_write, zeros])(), 900),
        }
        ask, answer = host_baud(1)
        for name, (make, pause_us) in streams.items():
            lines, us = [], 0
            while us < 2300000:  # past the end of the window
                is_quick = us < 1900000
                wait_us = (pause_us if is_quick else max(pause_us, 4000)) + rng.randrange(300)
                lines.append(say(make()) + f"wait {wait_us}\n")
                us += wait_us
            run = self.run_pc(save_host_baud(1, 1000000) + reset("external", 1000000) +
                              "".join(lines) + "wait 100000\nrest\n" + ask)
            self.assertEqual(run.heard[-1], answer, name)
            self.assertNotIn(b"input lost", b"".join(run.heard), name)
            self.assertGreater(len(self.sent(run)), 4, name)
            self.assertNotIn(TORQUE_OFF, self.sent(run), name)


if __name__ == "__main__":
    unittest.main()
