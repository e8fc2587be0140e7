# SPDX-License-Identifier: MIT
"""settings autostart: the sequence plays after power-up, and only when it may. Packets on the wire decide."""
# needs: $(CONSOLE_ELFS)
import pathlib
import random
import re
import tempfile
import unittest

import boards
from simulator import LONG, ROOT, controller

SERVOS = "1-3"
PREPARE = ("echo off\ngroup 1 2 3\npose set low 130 140 160\npose set stand 150 150 150\n"
           "sequence walk new low 0.5s\nsequence walk add stand 0.4s\n")
# The controller does not sleep in the delay, so a short one keeps the runs short.
AFTER_1_S = "settings autostart walk 1s\n"

TEXTS = {int(number): text for number, text in
         re.findall(r'X\(\w+, (\d+), *"([^"]*)"', re.sub(r"\\\n", "", (
             ROOT / "include/cds55xx/result.h").read_text() + (
             ROOT / "src/controller/console/errors.h").read_text()))}


def fails(servo, error):
    """What `settings autostart` says of a servo that is not well."""
    return f"not begun: servo {servo}: {TEXTS[error]};"


# A chip with 256 KB of flash, whose firmware names the pose, too, and a chip with 128 KB.
TWO_BOARDS = boards.WITH_MOTION_BY_SIZE


# Lines right after power-up, and what `settings autostart` then says, or the error of servo {n}.
TROUBLES = {
    "none": ("", "has begun"),
    "host byte": ("@wait {ms}\nversion\n", "not begun: a byte came from the host"),
    "servo missing": ("@power {n} off\n", 2),
    "low voltage": ("@supply {n} 5.5\n", 86),
    "high voltage": ("@supply {n} 16.5\n", 86),
    "overheating": ("write {n} MAX_TEMPERATURE 20\n@reset power\n", 85),
    "two replies damaged": ("@fault flip out 1 6 1\n@fault flip out 2 6 1\n", "has begun"),
    "three replies damaged": ("@fault flip out 1 6 1\n@fault flip out 2 6 1\n@fault flip out 3 6 1\n",
                               f"not begun: servo 1: {TEXTS[2]};"),
    "servo dies late": ("@wait 900\n@power {n} off\n", 2),
    "external reset": ("@wait {short}\n@reset external\n", "not begun: the last reset was not power-on"),
    "watchdog reset": ("@wait {short}\n@reset watchdog\n", "not begun: the last reset was not power-on"),
    "brown-out": ("@wait {short}\n@reset brown-out\n", "not begun: the last reset was not power-on"),
    "second power-up": ("@wait {short}\n@reset power\n", "has begun"),
}

POWER_UPS = 40 if LONG else len(TROUBLES)


def driving(run):
    """Packets that drive a servo, as [cycle, ...]: goals, speeds, torque on."""
    found = []
    for cycle, way, packet in run.packets:
        data = bytes.fromhex(packet)
        if way != "->in" or data[4] not in (0x03, 0x04, 0x05, 0x83):
            continue
        if data[4] == 0x05 or 0x1E <= data[5] <= 0x21 or (data[5] == 0x18 and any(data[6:-1])):
            found.append(cycle)
    return found


class Autostart(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.eeprom = pathlib.Path(folder.name, "eeprom")

    def prepare(self, board, line, script=PREPARE):
        self.eeprom.unlink(missing_ok=True)
        run = controller(script + line, board, SERVOS, "--eeprom", self.eeprom)
        self.assertEqual(run.status, 0, run.output[-2000:])

    def power_up(self, board, lines, says, wait_ms=2500):
        """A run from power-on; nobody types before `settings autostart` asks how it went."""
        script = f"{lines}@wait {wait_ms}\nsettings autostart\n@expect text {says}\n"
        run = controller(script, board, SERVOS, "--echo", "--eeprom", self.eeprom)
        self.assertEqual(run.status, 0, lines + run.output[-3000:])
        return run

    def test_sequence_plays_after_power_up(self):
        for board in boards.WITH_MOTION:
            with self.subTest(board):
                self.prepare(board, "settings autostart walk\n")
                run = self.power_up(board, "@wait 2900\n@expect servo 1 PRESENT_POSITION 440..447 within 1000\n"
                                    "@expect servo 1-3 PRESENT_POSITION 508..515 within 600\n",
                                    "autostart: walk after 3 s; has begun", 100)
                first = driving(run)[0] / 16_000_000
                self.assertGreater(first, 3)
                self.assertLess(first, 3.2)
                self.assertIn("rules:   none broken", run.output)

    def test_autostart_says_how_its_motion_has_ended(self):
        """A chip with 256 KB tells it."""
        for loop, lines, says in [("", "", "ended as it should"),
                                  (" loop", "@wait 1500\n@power 2 off\n", "servo 2: error 2: no reply by the deadline")]:
            self.prepare(TWO_BOARDS[0], f"settings autostart walk{loop} 1s\n")
            self.power_up(TWO_BOARDS[0], lines, f"after 1 s; has begun; no motion is under way, the last one: {says}", 3000)

    def test_sequence_plays_for_ever_after_another_delay(self):
        board = boards.WITH_MOTION[0]
        self.prepare(board, "settings autostart walk loop 1s\n")
        self.power_up(board, "@wait 4000\nmotion\n@expect text motion: walk: step\nmotion off\n",
                      "autostart: walk loop after 1 s; has begun", 100)

    def test_autostart_with_a_fault_plays_only_if_permitted(self):
        """Random trouble at random times."""
        board, dice = boards.WITH_MOTION[0], random.Random(3)
        self.prepare(board, AFTER_1_S)
        names = list(TROUBLES) * (POWER_UPS // len(TROUBLES) + 1)
        for name in names[:POWER_UPS]:
            values = {"n": dice.randint(1, 3), "ms": dice.randint(1, 900), "short": dice.randint(1, 900)}
            lines, says = TROUBLES[name]
            lines, says = lines.format(**values), fails(values["n"], says) if isinstance(says, int) else says
            with self.subTest(name, **values):
                run = self.power_up(board, lines, says)
                self.assertEqual(bool(driving(run)), says == "has begun")

    def test_autostart_after_a_stop_does_not_begin(self):
        """The drive inhibit survives resets other than power-on; after those it does not play anyway."""
        board = boards.WITH_MOTION[0]
        self.prepare(board, AFTER_1_S)
        run = self.power_up(board, "stop\n@reset external\n", "not begun")
        self.assertEqual(driving(run), [])

    def test_pose_beyond_angle_limits_is_refused(self):
        for board, says in zip(TWO_BOARDS, [
                "servo 2 in step 1, pose low: 139.883deg is out of range: 146.628deg to 0deg",
                "servo 2: the pose of step 1 is beyond its angle limits"]):
            with self.subTest(board):
                self.prepare(board, AFTER_1_S)
                run = self.power_up(board, "write 2 CW_ANGLE_LIMIT 500 0\n@reset power\n", f"not begun: {says}")
                reset = int(re.search(r"(\d+) reset\n", run.output)[1])
                self.assertEqual([cycle for cycle in driving(run) if cycle > reset], [])

    def test_servo_in_endless_turn_is_refused(self):
        board = boards.WITH_MOTION[0]
        self.prepare(board, AFTER_1_S)
        run = self.power_up(board, "write 3 CCW_ANGLE_LIMIT 0\n@reset power\n", fails(3, 47))
        reset = int(re.search(r"(\d+) reset\n", run.output)[1])
        self.assertEqual([cycle for cycle in driving(run) if cycle > reset], [])

    def test_servo_that_refuses_its_goal_gets_no_torque(self):
        """Servo 2 stands at 150 degrees, outside of its angle limits; the poses are within."""
        board = boards.WITH_MOTION[0]
        self.prepare(board, AFTER_1_S, PREPARE.replace(" 140 ", " 200 ").replace("150 150 150", "150 210 150"))
        self.power_up(board, "write 2 CW_ANGLE_LIMIT 600\n@reset power\n"
                      "@wait 5500\n@expect servo 1-3 torque off\n", fails(2, 70), 1)

    def test_too_short_first_step_is_reported(self):
        for board, says in zip(TWO_BOARDS, ["servo 1 needs 710 ms in step 1, pose low", f"servo 1: {TEXTS[57]};"]):
            with self.subTest(board):
                self.prepare(board, AFTER_1_S, PREPARE.replace("low 130", "low 290").replace("0.5s", "0.1s"))
                self.power_up(board, "@wait 2500\n@expect servo 1-3 torque off\n", f"not begun: {says}", 1)
                script = "@wait 2500\n! motion wait\n@expect text servo 1 needs 710 ms in step 1\n@expect text error 57:\n"
                run = controller(script, board, SERVOS, "--echo", "--eeprom", self.eeprom)
                self.assertEqual(run.status, 0, run.output[-3000:])

    def test_refused_motion_leaves_torque_that_was_on(self):
        board = boards.WITH_MOTION[0]
        self.prepare(board, AFTER_1_S, PREPARE.replace("low 130", "low 290").replace("0.5s", "0.1s"))
        self.power_up(board, "torque 2 on\n@reset power\n@wait 2500\n@expect servo 1,3 torque off\n"
                      "@expect servo 2 torque on\n", "not begun: servo 1 needs", 1)

    def test_a_later_step_that_is_too_short_moves_nothing(self):
        board = boards.WITH_MOTION[0]
        self.prepare(board, AFTER_1_S, PREPARE.replace("0.4s", "0.02s"))
        run = self.power_up(board, "", "not begun: servo 1 needs 210 ms in step 2, pose stand")
        goals = {packet for _, way, packet in run.packets if way == "->in" and " 83 1E 04 " in packet}
        self.assertEqual(len(goals), 0)

    def test_autostart_with_a_missing_record_does_not_begin(self):
        board = boards.WITH_MOTION[0]
        self.prepare(board, "")
        self.power_up(board, "", "autostart: none", 2000)
        self.prepare(board, AFTER_1_S + "settings autostart off\n")
        self.power_up(board, "", "autostart: none", 2000)
        for board, says in zip(TWO_BOARDS, ["step 2: the pose is deleted", "the pose of step 2 is deleted"]):
            with self.subTest(board):
                self.prepare(board, AFTER_1_S + "pose delete stand\n@expect text has this pose: it plays no more\n")
                run = self.power_up(board, "", f"not begun: {says}")
                self.assertEqual(driving(run), [])

    def test_autostart_without_any_pose_does_not_begin(self):
        board = boards.WITH_MOTION[0]
        self.prepare(board, AFTER_1_S + "pose delete low\npose delete stand\n")
        self.assertEqual(driving(self.power_up(board, "", "not begun: sequence or poses are missing")), [])

    def test_reason_names_no_pose_after_a_change_of_the_steps(self):
        """What is stored now is not what was not played."""
        board = boards.WITH_MOTION[0]
        self.prepare(board, AFTER_1_S, PREPARE.replace("low 130", "low 290").replace("0.5s", "0.1s"))
        self.power_up(board, "", "not begun: servo 1 needs 710 ms in step 1, pose low")
        run = self.power_up(board, "@wait 2500\nsequence walk set 1 stand 1s\n", "servo 1 needs 710 ms in step 1")
        self.assertNotIn("in step 1, pose", run.output)

    def test_servo_of_a_deleted_pose_is_not_needed(self):
        """Servo 9 is the first one of the list of joints, but in no stored pose: its place does not shift the others."""
        board = boards.WITH_MOTION[0]
        self.prepare(board, AFTER_1_S, "echo off\ngroup 9\npose set gone 10\nservos forget\n" + PREPARE[9:]
                     + "pose delete gone\n")
        self.power_up(board, "@wait 1600\n@expect servo 1 PRESENT_POSITION 440..447 within 1000\n"
                      "@expect servo 1-3 PRESENT_POSITION 508..515 within 600\n", "has begun", 100)

    def test_its_sequence_cannot_be_deleted(self):
        board = boards.WITH_MOTION[0]
        self.prepare(board, AFTER_1_S + "! sequence delete walk\n@expect text error 93:\n"
                     "settings autostart off\nsequence delete walk\npose delete low\n")

    def test_stop_during_autostart_sends_no_goal(self):
        """No goal leaves after a stop. The stop comes at different parts of start and move."""
        board = boards.WITH_MOTION[0]
        self.prepare(board, "settings autostart walk loop 1s\n")
        for ms in (1001, 1004, 1010, 1020, 1100, 2000):
            with self.subTest(ms):
                script = f"@wait {ms}\nstop\n@wait 1000\n@expect servo 1-3 torque off\n"
                run = controller(script, board, SERVOS, "--echo", "--eeprom", self.eeprom)
                self.assertEqual(run.status, 0, run.output[-3000:])
                off = [cycle for cycle, way, packet in run.packets if packet.startswith("FF FF FE 04 03 18 00")]
                self.assertTrue(off)
                self.assertEqual([cycle for cycle in driving(run) if cycle > off[0]], [])

    def test_bad_arguments_are_refused(self):
        board = boards.WITH_MOTION[0]
        self.prepare(board, "! settings autostart wolk\n@expect text error 75:\n"
                     + "".join(f"! settings autostart walk {time}\n"
                               f"@expect text error 33: DELAY {shown} is out of range: 1 to 127s, whole seconds\n"
                               for time, shown in [("loop 128s", "128s"), ("0s", "0s"), ("1ms", "1ms"), ("1500ms", "1500ms"),
                                                   ("loop 200", "200ms")]) +
                     "! settings autostart walk twice\n@expect text error 32:\n")
        without = [name for name in boards.with_profile("full") if name not in boards.WITH_MOTION]
        for board in without:
            self.prepare(board, "", "! settings autostart\n@expect text error 55:\n"
                         "! settings autostart walk\n@expect text error 55:\n")


if __name__ == "__main__":
    unittest.main()
