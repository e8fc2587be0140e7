# SPDX-License-Identifier: MIT
"""The servos behind a pty, and the firmware's console behind one: in real time, for any client."""
# needs: build/atmega128/controller.elf
import fcntl
import os
import pathlib
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time
import unittest

import client
from client import (BAUD, CCW_LIMIT, GOAL_POSITION, ID, LED, MOVING, PRESENT_POSITION,
                    TORQUE_ENABLE, Port, word)
from simulator import PATIENCE_S, ROOT, SIM, Process, bus, call, cpu_ticks, wait_until

SERVOS = list(range(1, 19))


class Clients(unittest.TestCase):
    def test_the_python_example_of_the_document_runs(self):
        text = (ROOT / "docs/simulated-bus.md").read_text()
        example = re.search(r"```python\n(.*?)```", text, re.S)[1]
        with bus() as sim:
            status, output = call(sys.executable, "-c", example.replace("/dev/pts/5", sim.path),
                                  env={**os.environ, "PYTHONPATH": str(ROOT / "test/runs")})
        self.assertEqual(status, 0, output)
        self.assertIn(str(SERVOS), output)

    def test_scan_change_an_id_change_the_rate_and_move_18_servos(self):
        with bus() as sim, Port(sim.path) as port:
            self.assertEqual(port.scan(range(254), SERVOS), SERVOS)

            port.write(7, ID, [77])
            self.assertEqual(port.scan([7, 77], [77]), [77])
            port.write(77, ID, [7])

            port.write(3, BAUD, [34])  # answered at the old rate
            self.assertFalse(port.ping(3, 0.05))
            port.set_baud(57600)
            port.clear()
            self.assertEqual(port.scan(SERVOS, [3]), [3])
            port.write(3, BAUD, [1])
            port.set_baud(1000000)
            port.clear()
            self.assertEqual(port.scan(SERVOS, SERVOS), SERVOS)

            goals = {servo: 300 + 20 * servo for servo in SERVOS}
            port.write(client.BROADCAST, TORQUE_ENABLE, [1])
            port.sync_write(GOAL_POSITION, {servo: word(goal) + word(400)
                                            for servo, goal in goals.items()})
            sim.settle(0.02)
            self.assertTrue(wait_until(lambda: not any(
                port.read(servo, MOVING, 1)[0] for servo in SERVOS)))
            for servo, goal in goals.items():
                self.assertAlmostEqual(port.read_word(servo, PRESENT_POSITION), goal, delta=2)
            self.assertNotIn("lost", sim.end(signal.SIGINT))
            self.assertEqual(sim.status, 0, sim.output)

    def test_a_move_takes_its_time_in_the_real_world(self):
        """The simulator may be held up, but never runs ahead: of several moves the shortest counts."""
        with bus(servos="1") as sim, Port(sim.path) as port:
            port.write(1, TORQUE_ENABLE, [1])
            took = []
            for goal in [812, 512] * 10:
                start = time.monotonic()
                port.write(1, GOAL_POSITION, word(goal) + word(500))  # 88 degrees at 182 / s
                sim.settle(0.02)
                self.assertTrue(wait_until(lambda: not port.read(1, MOVING, 1)[0]))
                took.append(time.monotonic() - start)
                if took[-1] < 1.5:
                    break
            self.assertGreater(min(took), 0.4)
            self.assertLess(min(took), 1.5)

    def test_slow_simulated_time_never_runs_ahead(self):
        start = time.monotonic()
        with bus("--slow", "20", servos="1") as sim, Port(sim.path) as port:
            self.assertTrue(port.ping(1))
            wait_until(lambda: time.monotonic() - start > 1)
            sim.end()
        simulated = float(re.search(r"([0-9.]+) s simulated", sim.output)[1])
        self.assertGreater(simulated, 0)
        self.assertLessEqual(simulated * 20, time.monotonic() - start)

    def test_reply_comes_within_3_ms_and_an_idle_bus_costs_little(self):
        with bus() as sim, Port(sim.path) as port:
            medians = []  # the machine may be busy: the best of several counts
            while not medians or min(medians) >= 0.003 and len(medians) < 50:
                medians.append(sorted(self.trip(port) for _ in range(200))[100])
            self.assertLess(min(medians), 0.003)
            sim.settle(0.1)
            used = cpu_ticks(sim.process)
            time.sleep(1)
            self.assertLess((cpu_ticks(sim.process) - used) / os.sysconf("SC_CLK_TCK"), 0.08)

    def trip(self, port):
        start = time.monotonic()
        self.assertTrue(port.ping(9))
        return time.monotonic() - start

    def test_the_port_is_raw_and_silent_without_any_setting(self):
        with bus(servos="1") as sim:
            self.assertEqual(self.ping_without_settings(sim), "ffff010200fc")

    @staticmethod
    def ping_without_settings(sim):
        """All that comes back, in hex."""
        line = os.open(sim.path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        os.write(line, client.packet(1, client.PING))
        sim.settle(0.1)
        got = os.read(line, 100)
        os.close(line)
        return got.hex()

    def test_a_client_can_come_after_another_and_finds_nothing_of_it(self):
        with bus(servos="1") as sim:
            with Port(sim.path) as port:
                port.send(client.packet(1, client.PING) + bytes(500))
                sim.settle(0.05)  # replies that it will not read
            sim.settle(0.05)
            with Port(sim.path) as port:
                sim.settle(0.1)
                self.assertEqual(port.receive(1, 0.01), b"")
                self.assertTrue(port.ping(1))
            os.system(f"stty -F {sim.path} sane")  # cooked, with echo, and gone
            sim.settle(0.05)
            self.assertEqual(self.ping_without_settings(sim), "ffff010200fc")

    def test_garbage_does_no_harm(self):
        with bus(servos="1,2") as sim, Port(sim.path) as port:
            before = port.read(1, 0, 24)
            port.send(bytes(range(256)) * 40 + b"\xff" * 100)
            port.send(b"\xff\xff\x01\xfe")  # a packet that does not end
            port.send(bytes(300))
            sim.settle(0.3)
            self.assertEqual(port.scan(range(4), [1, 2]), [1, 2])
            self.assertEqual(port.read(1, 0, 24), before)

    def test_a_wrong_rate_gets_no_answer_and_the_right_one_does(self):
        with bus(servos="1") as sim, Port(sim.path) as port:
            for baud in [500000, 115200, 9600]:
                port.set_baud(baud)
                self.assertFalse(port.ping(1, 0.05), baud)
                sim.settle(0.01)
            port.set_baud(1000000)
            port.clear()
            self.assertTrue(port.ping(1))

    def test_every_listed_rate(self):
        with bus(servos="1") as sim, Port(sim.path) as port:
            for register, baud in [(3, 500000), (16, 115200), (34, 57600), (103, 19200)]:
                port.write(1, BAUD, [register])
                port.set_baud(baud)
                self.assertTrue(port.ping(1), baud)

    def test_a_reader_that_pauses_loses_nothing_of_replies(self):
        read = client.packet(1, client.READ, [0, 50])
        with bus(servos="1") as sim, Port(sim.path) as port:
            for _ in range(500):  # 56 bytes each: more than the system keeps
                port.send(read)
                sim.settle(step=0.002)
            sim.settle(0.1)
            replies = port.receive(500 * 56, 0.1)
            self.assertNotIn("lost", sim.end())
            self.assertGreater(len(replies), 400 * 56)
            self.assertIn(f"{500 * 8} bytes from clients, {len(replies)} to clients", sim.output)

    def test_the_end_has_a_summary_by_sigint_and_by_sigterm(self):
        for number in [signal.SIGINT, signal.SIGTERM]:
            with bus(servos="1") as sim:
                with Port(sim.path) as port:
                    self.assertTrue(port.ping(1))
                self.assertIn("1 packets in, 1 out", sim.end(number))
                self.assertEqual(sim.status, 0)

    def test_a_scenario_is_the_world_around_the_client(self):
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder) / "script"
            script.write_text("@wait 300\n@power off\n")
            with bus("--script", script, servos="1") as sim, Port(sim.path) as port:
                self.assertTrue(port.ping(1))
                self.assertTrue(wait_until(lambda: not port.ping(1, 0.05)))


class Memory(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name) / "state"

    def bus(self):
        return bus("--state", self.folder, servos="1-3")

    def test_the_eeprom_area_survives_and_the_ram_area_does_not(self):
        with self.bus() as sim, Port(sim.path) as port:
            port.write(2, ID, [42])
            port.write(42, CCW_LIMIT, word(700))
            port.write(42, LED, [1])
            port.write(3, BAUD, [34])
            sim.end()
        self.assertEqual(len(list(self.folder.iterdir())), 2)  # of those that have changed
        with self.bus() as sim, Port(sim.path) as port:
            self.assertEqual(port.scan(range(50), [1, 42]), [1, 42])
            self.assertEqual(port.read_word(42, CCW_LIMIT), 700)
            self.assertEqual(port.read(42, LED, 1), b"\0")
            port.set_baud(57600)
            port.clear()
            self.assertTrue(port.ping(3))

    def test_a_run_that_is_killed_has_saved_what_is_a_second_old(self):
        with self.bus() as sim, Port(sim.path) as port:
            port.write(2, ID, [42])
            sim.settle(1)
            sim.end(signal.SIGKILL)
        with self.bus() as sim, Port(sim.path) as port:
            self.assertEqual(port.scan(range(50), [1, 3, 42]), [1, 3, 42])

    def test_a_damaged_file_is_one_line_and_status_2(self):
        with self.bus() as sim, Port(sim.path) as port:
            port.write(2, ID, [42])
            sim.end()
        file = self.folder / "bus0-servo002.eeprom"
        file.write_text(file.read_text().replace("2A", "2B"))
        done = subprocess.run([SIM, "bus", "--servos", "1-3", "--seconds", "1", "--state",
                               self.folder], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertRegex(done.stderr, r"\A\S*/bus0-servo002.eeprom: damaged[^\n]*\n\Z")

    def test_the_firmware_finds_the_servos_as_the_bus_left_them(self):
        with self.bus() as sim, Port(sim.path) as port:
            port.write(2, ID, [42])
            sim.end()
        script = self.folder / "script"
        script.write_text("ping 42\n! ping 2\nwrite 42 ID 43\n")
        command = [SIM, "firmware", ROOT / "build/atmega128/controller.elf", "--board", "atmega128",
                   "--servos", "1-3", "--state", self.folder, "--script", script]
        done = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with self.bus() as sim, Port(sim.path) as port:
            self.assertEqual(port.scan(range(50), [1, 3, 43]), [1, 3, 43])


class Firmware(unittest.TestCase):
    def controller(self, *options):
        return Process("firmware", ROOT / "build/atmega128/controller.elf", "--board", "atmega128",
                       "--servos", "1-18", "--host", "pty", *options)

    def ask(self, path, command):
        """What the console says, up to its ok or error."""
        line = os.open(path, os.O_RDWR | os.O_NOCTTY)
        os.write(line, command.encode() + b"\n")
        said = b""
        while not said.endswith(b"ok\r\n") and select.select([line], [], [], PATIENCE_S)[0]:
            said += os.read(line, 1000)
        os.close(line)
        return said.decode()

    def test_the_console_one_client_after_the_other(self):
        with self.controller() as sim:
            self.assertIn("ok", self.ask(sim.path, "ping 18"))
            sim.settle(0.05)
            self.assertIn("= 1023", self.ask(sim.path, "read 5 CCW_ANGLE_LIMIT"))
            self.assertIn("2 packets in, 2 out", sim.end(signal.SIGINT))
            self.assertEqual(sim.status, 0)

    def test_a_reader_that_pauses_loses_nothing(self):
        with self.controller() as sim:
            line = os.open(sim.path, os.O_RDWR | os.O_NOCTTY)
            for _ in range(20):
                os.write(line, b"read 1 0 50\n")
                sim.settle(0.05)
            said = b""
            while said.count(b"ok\r\n") < 20 and select.select([line], [], [], PATIENCE_S)[0]:
                said += os.read(line, 10000)
            os.close(line)
            self.assertEqual(said.count(b"0x00: 00 01 01 01"), 20)
            self.assertEqual(said.count(b"ok\r\n"), 20)
            self.assertNotIn("lost", sim.end())

    def test_simulated_time_is_real_time(self):
        """The simulator may be held up, but never runs ahead: of several runs the shortest counts."""
        took = []
        while not took or min(took) > 3 and len(took) < 10:
            with self.controller("--seconds", "1") as sim:
                start = time.monotonic()
                sim.process.wait(PATIENCE_S)
                took.append(time.monotonic() - start)
        self.assertGreater(min(took), 0.8)
        self.assertLess(min(took), 3)


    def test_run_prints_path_and_how_to_open_it_and_ends_by_ctrl_c(self):
        run = subprocess.Popen([SIM, "firmware", ROOT / "build/atmega128/controller.elf", "--board",
                                "atmega128", "--servos", "1-18", "--host", "pty"],
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               stdin=subprocess.DEVNULL)
        path = run.stdout.readline().decode().strip()
        self.assertIn("ok", self.ask(path, "ping 18"))
        run.send_signal(signal.SIGINT)
        output = run.communicate()[0].decode()
        self.assertIn(f"picocom -q -e t {path} (", output)  # without -e t, Ctrl-A does not reach the console
        self.assertIn("1 packets in, 1 out", output)

    def test_port_at_the_client_rate_shows_the_rate_to_open(self):
        with self.controller("--host-baud", "client") as sim:
            self.assertIn(f"picocom -q -e t -b 115200 {sim.path} (", sim.process.stdout.readline().decode())


class Table(unittest.TestCase):
    def test_follow_shows_every_servo(self):
        done = subprocess.run([SIM, "bus", "--servos", "1-18", "--seconds", "1", "--follow"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0)
        units, *last = done.stderr.split("errors\n")[-1].splitlines()
        self.assertEqual(units.split(), ["deg", "deg", "RPM", "%", "V", "C"])
        self.assertEqual([int(line.split()[1]) for line in last[:18]], SERVOS)
        self.assertEqual(last[0].split(), ["0", "1", "150.1", "150.1", "0.0", "0", "12.0", "32", "off"])
        self.assertNotIn("\033", done.stderr)
        self.assertNotIn("errors", done.stdout)

    def test_terminal_table_is_redrawn_in_place_and_stays_at_the_end(self):
        master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("4H", 9, 80, 0, 0))
        with Process("bus", "--servos", "1-18", "--pty", "--follow", "--seconds", "0.6",
                     stderr=slave) as sim:
            os.close(slave)
            drawn = b""
            while select.select([master], [], [], PATIENCE_S)[0]:
                try:
                    drawn += os.read(master, 10000)
                except OSError:
                    break  # it has ended
            self.assertEqual(sim.process.wait(PATIENCE_S), 0)
        os.close(master)
        pictures = drawn.decode().split("\r\033[J")[1:]
        self.assertTrue(4 <= len(pictures) <= 9, len(pictures))
        for picture in pictures[:-1]:
            lines = picture.split("\n")[:-1]
            self.assertEqual(len(lines), 3 + 4 + 1)  # head, what there is room for, how many not
            self.assertIn("and 14 more", lines[-1])
            self.assertIn("\033[8A", picture)
        self.assertTrue(pictures[-1].endswith("x real time\r\n"))
        self.assertIn("\033[8B\r\n", pictures[-1])


if __name__ == "__main__":
    unittest.main()
