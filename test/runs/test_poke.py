# SPDX-License-Identifier: MIT
"""Orders for a running simulator: --poke SOCKET and `cds55xx-sim poke SOCKET ORDER`."""
# needs: build/atmega128/controller.elf
import pathlib
import re
import signal
import socket
import subprocess
import tempfile
import unittest

from simulator import PATIENCE_S, ROOT, SIM, Process, wait_until

FIRMWARE = ["firmware", ROOT / "build/atmega128/controller.elf", "--board", "atmega128", "--servos", "1-3",
            "--host", "tcp:0"]


class Console:
    """A client of the firmware's console."""

    def __init__(self, sim):
        host, port = sim.path.split(":")
        self.socket = socket.create_connection((host, int(port)), PATIENCE_S)
        self.file = self.socket.makefile("rwb")

    def ask(self, line):
        """The reply, up to `ok` or the line of the error."""
        self.file.write(line.encode() + b"\n")
        self.file.flush()
        reply = ""
        while not re.search(r"^(ok|error .*)\r\n$", reply, re.M):
            reply += self.file.readline().decode()
        return reply

    def position(self, servo):
        return int(re.search(r"\((\d+)\)", self.ask(f"get {servo} PRESENT_POSITION"))[1])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.file.close()
        self.socket.close()


class Poke(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name) / "poke"

    def start(self, *options):
        sim = Process(*(options or FIRMWARE), "--poke", self.path)
        self.addCleanup(sim.__exit__)
        return sim

    def begin(self, *order):
        """A poke that runs."""
        process = subprocess.Popen([SIM, "poke", self.path, *order], stdin=subprocess.DEVNULL, text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def poke(self, *order):
        """(status, stdout, stderr) of a poke."""
        process = self.begin(*order)
        output, errors = process.communicate(timeout=PATIENCE_S)
        return process.returncode, output, errors

    def assert_ok(self, *order):
        self.assertEqual(self.poke(*order), (0, "ok\n", ""))

    def assert_error(self, message, *order):
        status, output, errors = self.poke(*order)
        self.assertEqual((status, output), (1, ""))
        self.assertRegex(errors, rf"\Aerror: [^\n]*{message}[^\n]*\n\Z")


class Orders(Poke):
    def test_load_turns_an_output_that_the_console_then_reads(self):
        with Console(self.start()) as console:
            before = console.position(2)
            self.assert_ok("load 2 -100")
            self.assertTrue(wait_until(lambda: console.position(2) > before + 50))
            self.assert_ok("load", "2", "0")
            self.assertEqual(console.position(1), before)

    def test_power_off_unplugs_a_servo_until_power_on(self):
        with Console(self.start()) as console:
            self.assertEqual(console.ask("ping 3"), "ok\r\n")
            self.assert_ok("@power 3 off")
            self.assertIn("error 2: servo 3: no reply", console.ask("ping 3"))
            self.assertEqual(console.ask("ping 2"), "ok\r\n")
            self.assert_ok("power 3 on")
            self.assertEqual(console.ask("ping 3"), "ok\r\n")

    def test_an_order_without_ids_says_that_it_is_for_all(self):
        self.start()
        self.assertEqual(self.poke("load 1"), (0, "all servos: load 1\nok\n", ""))

    def test_an_order_to_a_servo_without_power_says_so(self):
        self.start()
        self.assert_ok("power 3 off")
        off = "servo 3 is off: switch it on with 'power 3 on'\nok\n"
        self.assertEqual(self.poke("load 2,3 300"), (0, off, ""))
        self.assertEqual(self.poke("load 3rd 300"), (0, off, ""))
        self.assert_ok("load 2 300")

    def test_a_servo_below_3_volts_is_started_by_its_supply(self):
        self.start()
        off = "servo 3 is off below 3 V: 'supply 3 12' starts it\nok\n"
        self.assertEqual(self.poke("supply 3 2"), (0, off, ""))
        self.assertEqual(self.poke("power 3 on"), (0, off, ""))
        self.assert_ok("supply 3 12")

    def test_wrong_order_is_named_and_changes_nothing(self):
        with Console(self.start()) as console:
            for order, message in [("servo 3 unplug", "unknown command; there are servos power"),
                                   ("unplug 2", "unknown command; to unplug servo 2: power 2 off"),
                                   ("ping 1", "unknown command"),
                                   ("# comment", "unknown command"),
                                   (" ", "unknown command"),
                                   ("power all off", r"wanted: power \[IDS\] on\|off, .*; without IDS: all servos"),
                                   ("supply all 5", r"wanted: supply \[IDS\] VOLTS \[over MS\]"),
                                   ("power 3 maybe", "on or off is wanted"),
                                   ("load 9 100", "there is no servo 9; there: 1-3$"),
                                   ("supply 1", "below 3 V they are off: name the servo, as in supply 1 7.4"),
                                   ("power 4th off", "power 4th off: there are 3 servos$"),
                                   ("servos 1,1", "an ID occurs twice"),
                                   ("fault explode", "a fault is wanted: flip "),
                                   ("send FF", "only without firmware")]:
                self.assert_error(message, order)
            self.assertEqual(console.ask("ping 3"), "ok\r\n")

    def test_expectations_and_values_are_answered(self):
        self.start()
        self.assert_ok("supply 1 9.5")
        self.assert_ok("expect servo 1 PRESENT_VOLTAGE 95 within 60000")
        self.assertEqual(self.poke("show servo 1-2 MODEL_NUMBER"),
                         (0, "servo 1 MODEL_NUMBER 1\nservo 2 MODEL_NUMBER 1\nok\n", ""))
        self.assert_error("not met; seen: servo 1 has torque off", "expect servo 1 torque on within 10")

    def test_expect_text_sees_lines_of_the_console(self):
        with Console(self.start()) as console:
            poke = self.begin("expect text cds55xx within 3600000")
            while poke.poll() is None:
                console.ask("version")
            self.assertEqual(poke.communicate()[0], "ok\n")

    def test_servos_are_replaced_during_a_ramp(self):
        with Console(self.start()) as console:
            self.assert_ok("load 1 1000 over 3600000")
            self.assert_ok("servos 5")
            self.assertEqual(console.ask("ping 5"), "ok\r\n")
            self.assert_error("there is no servo 1", "load 1 0")

    def test_controller_is_reset(self):
        with Console(self.start()) as console:
            self.assertNotIn("reset by watchdog", console.ask("status"))
            self.assert_ok("reset watchdog")
            self.assertTrue(wait_until(lambda: "reset by watchdog" in console.ask("status")))

    def test_bus_without_a_controller_takes_orders(self):
        self.start("bus", "--servos", "1", "--pty")
        self.assert_ok("load 1 300")
        self.assert_ok("expect servo 1 PRESENT_POSITION 0..500 within 60000")
        self.assert_error("there is no controller here", "reset power")


class Clients(Poke):
    def test_second_order_waits_until_the_first_has_ended(self):
        sim = self.start()
        with socket.socket(socket.AF_UNIX) as first:
            first.connect(str(self.path))
            first.sendall(b"wait 500\n")
            sim.settle(0.1)
            self.assert_ok("load 1 0")
            first.setblocking(False)
            self.assertEqual(first.recv(100), b"ok\n")

    def test_order_of_a_client_that_has_left_is_dropped(self):
        sim = self.start()
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(str(self.path))
            client.sendall(b"wait 3600000\n")
            sim.settle(0.1)
        self.assert_ok("load 1 0")

    def test_line_that_never_ends_is_refused(self):
        self.start()
        for sent, message in [(b"x" * 4096, b"error: the line is too long: 4095 characters at most\n"),
                              (b"half", b"error: no line came within 2 s\n")]:
            with socket.socket(socket.AF_UNIX) as client:
                client.settimeout(PATIENCE_S)
                client.connect(str(self.path))
                client.sendall(sent)
                self.assertEqual(client.recv(100), message)
        self.assert_ok("load 1 0")

    def test_end_of_the_simulator_ends_the_order_and_the_socket(self):
        sim = self.start()
        poke = self.begin("wait 3600000")
        sim.settle(0.2)
        sim.end()
        self.assertIn("error: the simulat", poke.communicate()[1])
        self.assertEqual(poke.returncode, 1)
        self.assertFalse(self.path.exists())


class Socket(Poke):
    def run_simulator(self, *options):
        return subprocess.run([SIM, *options, "--seconds", "0.01", "--poke", self.path], capture_output=True,
                              text=True, timeout=PATIENCE_S, stdin=subprocess.DEVNULL)

    def test_without_a_simulator_poke_says_so(self):
        self.assertEqual(self.poke("load 1 0"), (2, "", f"no simulator listens at {self.path}: start one with "
                                                        "make run or --poke\n"))

    def test_order_that_is_no_line_is_refused(self):
        for order in [[], [""], ["load 1 0\nload 2 0"], ["x" * 5000]]:
            status, _, errors = self.poke(*order)
            self.assertEqual(status, 2)
            self.assertIn("poke wants a socket and an order of one line", errors)

    def test_socket_of_a_killed_simulator_is_replaced(self):
        self.start().end(signal.SIGKILL)
        self.assertTrue(self.path.is_socket())
        self.start()
        self.assert_ok("load 1 0")

    def test_socket_in_use_and_file_are_refused_and_stay(self):
        self.start()
        done = self.run_simulator(*FIRMWARE)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertEqual(done.stderr, f"--poke {self.path}: another simulator listens there, or it is a file: end that "
                                      "simulator with Ctrl-C in its terminal, run another board, or name another socket\n")
        self.assert_ok("load 1 0")
        self.path = self.path.with_name("file")
        self.path.write_text("mine")
        self.assertEqual(self.run_simulator(*FIRMWARE).returncode, 1)
        self.assertEqual(self.path.read_text(), "mine")

    def test_path_that_cannot_be_a_socket_is_refused(self):
        self.path = self.path / "x" / "y"
        done = self.run_simulator(*FIRMWARE)
        self.assertEqual(done.stderr, f"--poke {self.path}: its folder does not exist: make it, or name another socket\n")
        self.path = "x" * 200
        self.assertIn("File name too long", self.run_simulator(*FIRMWARE).stderr)

    def test_first_lines_name_the_command_for_orders(self):
        for hint, says in [([], f'{SIM} poke {self.path} "load 1 300"'),
                           (["--poke-hint", 'make poke BOARD=x DO="load 1 300"'], 'make poke BOARD=x DO="load 1 300"')]:
            done = self.run_simulator(*FIRMWARE, *hint)
            self.assertIn(f"\npoke the servos with: {says}\n", done.stdout)

    def test_run_that_is_not_in_real_time_is_refused(self):
        for options in [FIRMWARE[:-2], ["bus", "--servos", "1"],
                        ["bus", "--servos", "1", "--pty", "--script", ROOT / "test/scenario/motion.script"]]:
            done = self.run_simulator(*options)
            self.assertEqual(done.returncode, 2)
            self.assertIn("--poke is for a run in real time without --script", done.stderr)


if __name__ == "__main__":
    unittest.main()
