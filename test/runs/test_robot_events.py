# SPDX-License-Identifier: MIT
"""A robot of robot.h (test/firmware/library/robot_events.c) meets servos that are not well. The wire is the judge."""
# needs: $(patsubst %,build/%/firmware/robot_events.elf,atmega128 arbotix)
import pathlib
import re
import tempfile
import unittest

from simulator import SIM, Run, call

BOARDS = ["atmega128", "arbotix"]  # two enables, tied pins
STARTED, START_FAILED, ALARM, OFFLINE, STATE_LOST, WAS_STOPPED = range(6)
NO_REPLY, VOLTAGE, MODE = 1, 5, 4
OK, TIMEOUT, INHIBITED = 0, 2, 12
RETURN_DELAY, CW_LIMIT, MIN_VOLTAGE = 0x05, 0x06, 0x0C
DRIVES = re.compile(r"FF FF .. .. (03 1E|03 18 01|83 1E)")
TORQUE_OFF = "FF FF FE 04 03 18 00 E2"


def write(servo, address, *data):
    """A line of a scenario: WRITE from the adapter."""
    packet = [servo, len(data) + 3, 3, address, *data]
    return "@send FF FF " + " ".join(f"{byte:02X}" for byte in [*packet, ~sum(packet) & 0xFF])


class Events(unittest.TestCase):
    def events(self, *options, board="atmega128", servos="1-3", script="@wait 2500\n", kept=()):
        """Events as (kind, joint, why). `kept`: scenario lines that change the EEPROM of the servos before."""
        with tempfile.TemporaryDirectory() as folder:
            state = pathlib.Path(folder) / "state"
            before = pathlib.Path(folder) / "before"
            before.write_text("".join(f"{line}\n@wait 5\n" for line in kept))
            done = call(SIM, "bus", "--servos", "1-3", "--state", state, "--script", before)
            self.assertEqual(done[0], 0, done[1])
            run = Run(f"build/{board}/firmware/robot_events.elf", "--echo", "--state", state, *options,
                       board=board, servos=servos, script=script)
        self.assertEqual(run.status, 0, run.output)
        said = [(name, int(value)) for name, value in re.findall(r"^(\w+) (-?\d+)$", run.output, re.M)]
        events = [value for name, value in said if name in ("kind", "joint", "why", "result", "alarms")]
        run.events = [tuple(events[at:at + 3]) for at in range(0, len(events), 5)]
        run.results = events[3::5]
        run.said = dict(said)
        run.mdeg = [value for name, value in said if name == "mdeg"]
        run.sent = [packet for _, way, packet in run.packets if way == "->in"]
        run.drives = [at for at, packet in enumerate(run.sent) if DRIVES.match(packet)]
        self.assertEqual(run.events[-1][0], WAS_STOPPED)
        self.assertEqual(run.sent.count(TORQUE_OFF), 3)
        if run.drives:
            self.assertLess(run.drives[-1], run.sent.index(TORQUE_OFF))
        return run

    def test_well_servos_start_move_and_stop(self):
        for board in BOARDS:
            with self.subTest(board):
                run = self.events(board=board)
                self.assertEqual(run.events, [(STARTED, 0, 0), (WAS_STOPPED, 0, 0)])
                self.assertEqual(run.results, [OK, OK])
                self.assertEqual(run.said["move"], OK)
                for mdeg in run.mdeg:
                    self.assertLess(abs(mdeg - 20000), 1000)

    def test_servo_that_replies_too_early_is_heard_with_a_delay(self):
        for board in BOARDS:
            with self.subTest(board):
                run = self.events("--rules", "warn", board=board, kept=[write(2, RETURN_DELAY, 0)])
                if board == "atmega128":  # one READ with two retries, and the WRITE
                    self.assertIn("two-drivers, 4 times", run.output)
                self.assertEqual(run.events, [(STARTED, 0, 0), (WAS_STOPPED, 0, 0)])

    def test_each_servo_that_is_not_well_is_named_and_nothing_drives(self):
        for board in BOARDS:
            with self.subTest(board):
                run = self.events(board=board, servos="1,3", kept=[write(1, MIN_VOLTAGE, 125),
                                                                    write(3, CW_LIMIT, 0, 0, 0, 0)])
                self.assertEqual(run.events, [(START_FAILED, 0, VOLTAGE), (START_FAILED, 1, NO_REPLY),
                                              (START_FAILED, 2, MODE), (WAS_STOPPED, 0, 0)])
                self.assertEqual(run.results[1], TIMEOUT)
                self.assertEqual(run.drives, [])

    def test_alarm_stops_the_robot(self):
        run = self.events(script="@wait 300\n@supply 2 5.5\n@wait 1000\n")
        self.assertEqual(run.events, [(STARTED, 0, 0), (ALARM, 1, 0), (WAS_STOPPED, 0, 0)])
        self.assertEqual(run.said["move"], INHIBITED)

    def test_servo_without_power_stops_the_robot(self):
        for ms, kinds in ((1, {STATE_LOST}), (60000, {OFFLINE})):
            with self.subTest(ms=ms):
                run = self.events("--rules", "warn", script=f"@wait 300\n@fault brownout 3 {ms}\n@wait 2000\n")
                self.assertEqual(run.events[0], (STARTED, 0, 0))
                self.assertIn(run.events[1][0], kinds)
                self.assertEqual(run.events[1][1], 2)


if __name__ == "__main__":
    unittest.main()
