# SPDX-License-Identifier: MIT
"""avr-gdb on the firmware while servos are simulated: what it sees, and that it changes nothing."""
# needs: build/atmega128/controller.elf build/firmware/crash_wild.elf
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import unittest

from simulator import PACKET, ROOT, SIM, cpu_ticks, wait_until

ELF = ROOT / "build/atmega128/controller.elf"
SCRIPT = "ping 1\nwrite 2 TORQUE_ENABLE 1\nwrite 2 GOAL_POSITION 700\n@wait 20\nping 3\n"
LIMIT_S = 60


def main_loop():
    """(first line, last line) of the main loop's body, the function turn()."""
    source = (ROOT / "src/controller/main.c").read_text().splitlines()
    first = next(n for n, line in enumerate(source, 1) if "void turn(" in line)
    return first, next(n for n, line in enumerate(source, 1) if line == "}" and n > first)


class Simulator:
    """A run that waits for gdb."""

    def __init__(self, *options, elf=ELF, script=SCRIPT):
        self.folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(self.folder.name)
        (folder / "script").write_text(script)
        self.transcript = folder / "transcript"
        self.process = subprocess.Popen(
            [SIM, "firmware", elf, "--board", "atmega128", "--servos", "1-3", "--script",
             folder / "script", "--transcript", self.transcript, *options],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True)

    def port(self):
        line = self.process.stderr.readline()
        return re.fullmatch(r"gdb: waiting; in avr-gdb: target remote 127\.0\.0\.1:(\d+)\n", line)[1]

    def end(self):
        self.output, self.errors = self.process.communicate(timeout=LIMIT_S)
        return self.process.returncode

    def packets(self):
        return [line for line in self.transcript.read_text().splitlines() if PACKET.match(line)]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()
        self.folder.cleanup()


def gdb_command(port, commands, elf=ELF):
    words = ["avr-gdb", "-batch", "-nx", "-ex", "set confirm off", "-ex", "set pagination off",
             "-ex", f"target remote 127.0.0.1:{port}"]
    for command in commands:
        words += ["-ex", command]
    return [*words, str(elf)]


def gdb(port, commands, elf=ELF):
    """What it said, its complaints last: Debian's avr-gdb complains in mid-line of Python
    modules that come with the native gdb only."""
    done = subprocess.run(gdb_command(port, commands, elf), stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True,
                          timeout=LIMIT_S)
    return done.stdout + done.stderr


class Debugger(unittest.TestCase):
    def debug(self, *commands):
        with Simulator("--gdb", "0") as run:
            said = gdb(run.port(), commands)
            self.status = run.end()
            self.run_output = run.output
            self.packets = run.packets()
        return said

    def test_the_run_waits_before_the_first_instruction(self):
        said = self.debug("info registers pc", "detach")
        self.assertRegex(said, r"pc +0x0 +0x0 <__vectors>")

    def test_breakpoint_in_the_main_loop_prints_the_controller(self):
        said = self.debug("break turn", "continue", "continue",
                          "print controller.bus.stats", "detach")
        stops = re.findall(r"^Breakpoint 1, turn \(.*\) at src/controller/main.c:(\d+)", said, re.M)
        first, last = main_loop()
        self.assertEqual(len(stops), 2, said)
        for line in stops:
            self.assertIn(int(line), range(first, last), said)
        self.assertRegex(said, r"\$1 = \{sent = \d+, retried = 0, timeouts = 0,")

    def test_a_breakpoint_in_a_handler_of_the_usart(self):
        said = self.debug("break __vector_30", "continue", "print controller.bus.stats.sent",
                          "x/6xb controller.console.buffer.packet", "detach")
        self.assertIn("Breakpoint 1, __vector_30 () at ", said)
        self.assertIn("$1 = 1\n", said)
        self.assertRegex(said, r"0xff\s+0xff\s+0x01\s+0x02\s+0x01\s+0xfb")  # it answers this ping

    def test_stepping_goes_on_line_by_line(self):
        # The linker shortens jumps and not the line table: if the function before turn() ends with such a jump,
        # the first two steps stop in the prologue of turn() and show no line.
        said = self.debug("break turn", "continue", "delete", *["next"] * 5, "detach")
        self.assertGreaterEqual(len(set(re.findall(r"^(\d+)\t", said, re.M))), 4, said)

    def test_a_step_runs_through_handlers(self):
        with Simulator("--gdb", "0") as run:
            steps = pathlib.Path(run.folder.name) / "steps"
            steps.write_text("set $n = 0\nwhile $n < 1500\nstepi\nset $n = $n + 1\nend\n")
            said = gdb(run.port(), ["tbreak __vector_18", "continue", "tbreak turn", "continue", "echo stepping\\n",
                                    f"source {steps}", "print controller.serial.rx", "detach"])
            self.assertEqual(run.end(), 0)
        stepped = said.split("stepping\n")[1]
        self.assertGreater(stepped.count("0x0000"), 50)
        self.assertEqual(re.findall(r"__vector\w* \(\)", stepped), [])
        self.assertRegex(stepped, r"bytes = \"mo")  # of `mode program`: the second letter came meanwhile

    def test_a_watchpoint_stops_where_a_variable_is_written(self):
        said = self.debug("break main", "continue", "watch controller.bus.stats.sent",
                          "continue", "continue", "detach")
        self.assertIn("Old value = 0\nNew value = 1\n", said)

    def test_stops_change_nothing(self):
        with Simulator() as plain:
            self.assertEqual(plain.end(), 0)
            packets = plain.packets()
        self.debug("break __vector_30", "continue", "continue", "stepi", "stepi", "delete",
                   "break turn", "continue", "next", "delete", "detach")
        self.assertEqual(self.status, 0)
        self.assertEqual(self.packets, packets)
        self.assertEqual(len(packets), 8)

    def test_the_end_of_the_run_is_told(self):
        self.assertIn("exited normally", self.debug("continue"))
        self.assertEqual(self.status, 0)

    def test_kill_ends_the_run(self):
        self.debug("break main", "continue", "kill")
        self.assertEqual(self.status, 1)
        self.assertIn("script-unfinished", self.run_output)

    def test_memory_and_registers_are_written(self):
        said = self.debug("break main", "continue", "set var controller.packets[0][0] = 0x42",
                          "print controller.packets[0][0]", "set var $r5 = 0x17", "print $r5",
                          "set {char}0x810003 = 0x33", "x/1xb 0x810003", "detach")
        self.assertRegex(said, r"\$1 = 66 'B'")
        self.assertIn("$2 = 23", said)
        self.assertRegex(said, r"0x810003:\s+0x33")

    def test_ctrl_c_stops_a_running_firmware(self):
        with Simulator("--gdb", "0", script="@wait 3600000\n") as run:
            client = subprocess.Popen(
                gdb_command(run.port(), ["continue", "info registers pc", "kill"]),
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            before = cpu_ticks(run.process)  # it computes once the firmware runs
            self.assertTrue(wait_until(lambda: cpu_ticks(run.process) > before + 10))
            client.send_signal(signal.SIGINT)
            said, _ = client.communicate(timeout=LIMIT_S)
            self.assertIn("Program received signal SIGINT", said)
            self.assertRegex(said, r"pc +0x[1-9a-f]")
            self.assertEqual(run.end(), 1)

    def test_a_crash_can_be_looked_at(self):
        elf = ROOT / "build/firmware/crash_wild.elf"
        with Simulator("--gdb", "0", elf=elf, script="ping 1\n") as run:
            said = gdb(run.port(), ["continue", "info registers SP", "continue"], elf)
            self.assertEqual(run.end(), 1)
            self.assertIn("received signal SIGSEGV", said)
            self.assertRegex(said, r"SP +0x")
            self.assertIn("crash: jump out of the code", run.output)

    def test_a_debugger_that_vanishes_leaves_the_run_alone(self):
        with Simulator("--gdb", "0") as run:
            client = subprocess.Popen(
                gdb_command(run.port(), ["break __vector_30", "continue", "shell sleep 60"]),
                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                start_new_session=True)
            self.assertTrue(any("Breakpoint 1, __vector_30" in line for line in client.stdout))
            os.killpg(client.pid, signal.SIGKILL)
            client.communicate()
            self.assertEqual(run.end(), 0)

    def test_a_port_in_use_is_refused(self):
        with Simulator("--gdb", "0") as first:
            with Simulator("--gdb", first.port()) as second:
                self.assertEqual(second.end(), 2)
                self.assertRegex(second.errors, r"\A--gdb \d+: Address already in use\n\Z")


if __name__ == "__main__":
    unittest.main()
