# SPDX-License-Identifier: MIT
"""The host link of the firmware at a TCP port: --host tcp:PORT."""
# needs: build/atmega128/controller.elf
import contextlib
import socket
import subprocess
import unittest

from simulator import PATIENCE_S, ROOT, SIM, Process

FIRMWARE = ["firmware", ROOT / "build/atmega128/controller.elf", "--board", "atmega128", "--servos", "1"]
BUSY = b"cds55xx-sim: another client is connected; close it first\r\n"
PONG = bytes.fromhex("FF FF 01 02 00 FC")


def simulator(*options):
    return Process(*FIRMWARE, "--host", "tcp:0", *options)


def connect(sim):
    host, port = sim.path.split(":")
    return socket.create_connection((host, int(port)), PATIENCE_S)


def read_until(client, end):
    """What the simulator sends, up to `end` or the end of the connection."""
    got = b""
    while end not in got:
        part = client.recv(1000)
        if not part:
            break
        got += part
    return got


def ask_until_answered(client, line):
    """A line that meets the change of the rate is lost, as on a real cable: asks again."""
    client.settimeout(1)
    for _ in range(PATIENCE_S):
        client.sendall(line)
        with contextlib.suppress(TimeoutError):
            return read_until(client, b"ok\r\n")
    return b""


class Session(unittest.TestCase):
    def assert_version_is_answered(self, client):
        client.sendall(b"version\n")
        self.assertRegex(read_until(client, b"ok\r\n"), rb"(?s)^cds55xx .*ok\r\n$")

    def test_console_and_bridge_answer_over_tcp(self):
        with simulator() as sim, connect(sim) as client:
            self.assertRegex(sim.path, r"^127\.0\.0\.1:[1-9]\d*$")
            self.assert_version_is_answered(client)
            client.sendall(bytes.fromhex("FF FF 01 02 01 FB"))
            self.assertEqual(read_until(client, PONG), PONG)
            self.assertIn("1 packets in, 1 out, 0 damaged", sim.end())
            self.assertIn("bytes from clients", sim.output)

    def test_client_follows_the_rate_of_the_firmware(self):
        with simulator() as sim, connect(sim) as client:
            client.sendall(b"settings host_baud 1\n")
            read_until(client, b"ok\r\n")
            self.assertIn(b"host_baud = 1", ask_until_answered(client, b"\nsettings host_baud\n"))

    def test_second_client_is_told_and_the_first_goes_on(self):
        with simulator() as sim, connect(sim) as first:
            self.assert_version_is_answered(first)
            with connect(sim) as second:
                second.sendall(b"version\n")
                self.assertEqual(read_until(second, b"never"), BUSY)
            self.assert_version_is_answered(first)
            self.assertIn("1 clients refused", sim.end())

    def test_next_client_comes_when_the_client_has_left(self):
        with simulator() as sim:
            for _ in range(20):
                with connect(sim) as client:
                    self.assert_version_is_answered(client)
            sim.settle(0.1)  # without a client
            with connect(sim) as client:
                self.assert_version_is_answered(client)
            self.assertNotIn("refused", sim.end())

    def test_client_that_ends_its_input_gets_the_reply_and_the_end(self):
        with simulator() as sim, connect(sim) as client:
            client.sendall(b"version\n")
            client.shutdown(socket.SHUT_WR)
            self.assertRegex(read_until(client, b"never"), rb"(?s)^cds55xx .*ok\r\n$")


class Refusal(unittest.TestCase):
    def run_simulator(self, *options):
        return subprocess.run([SIM, *FIRMWARE, "--seconds", "0.01", *options], capture_output=True, text=True, timeout=PATIENCE_S,
                              stdin=subprocess.DEVNULL)

    def test_port_in_use_ends_with_one_line_and_status_1(self):
        with simulator() as sim:
            port = sim.path.split(":")[1]
            done = self.run_simulator("--host", f"tcp:{port}")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertEqual(done.stderr, f"--host tcp:{port}: 127.0.0.1:{port}: Address already in use; "
                                      "port 0 takes a free port\n")

    def test_port_that_is_no_number_is_refused(self):
        for port in ["", "-1", "65536", "99999999999999999999", " 1", "+1", "0x1", "1.5", "localhost:1"]:
            done = self.run_simulator("--host", f"tcp:{port}")
            self.assertEqual((done.returncode, done.stdout), (2, ""), port)
            self.assertEqual(done.stderr, f"cds55xx-sim: --host tcp:PORT wants a port, 0 (any) to 65535, not: {port} "
                                          "(try --help)\n")

    def test_rate_of_the_client_is_refused(self):
        done = self.run_simulator("--host", "tcp:0", "--host-baud", "client")
        self.assertEqual(done.returncode, 2)
        self.assertIn("a TCP client has no rate", done.stderr)


if __name__ == "__main__":
    unittest.main()
