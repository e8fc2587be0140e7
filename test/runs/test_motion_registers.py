# SPDX-License-Identifier: MIT
"""A PC plays stored sequences by packets: the registers of motions of the virtual device."""
# needs: $(CONSOLE_ELFS)
import pathlib
import re
import subprocess
import tempfile
import unittest

import boards
from client import BAUD, GOAL_POSITION, ID, PRESENT_POSITION, READ, TORQUE_ENABLE, WRITE, packet
from simulator import ROOT, SIM

DEVICE = 253
PLAY, OVERRIDE, PAUSE, STATE, STEP, ERROR = range(0x70, 0x76)
RANGE = 0x08
MS = 1000

POSES = ["echo off", *(f"write {n} RETURN_DELAY 10" for n in (1, 2, 3)), "group 1 2 3", "torque 254 on",
         "pose set stand 150 150 150", "pose set low 120 130 140"]
READY = [*POSES,
         "sequence bow new low 0.5s", "sequence bow add stand 0.5s dwell 0.5s",
         "sequence long new low 3s", "sequence long add stand 3s"]
BOW, LONG = 1, 2


def write(register, *values):
    return packet(DEVICE, WRITE, [register, *values]), 6


def read(register, count=1):
    return packet(DEVICE, READ, [register, count]), 6 + count


def position(servo):
    return packet(servo, READ, [PRESENT_POSITION, 2]), 8


def wait(ms):
    return ms


class Registers(unittest.TestCase):
    def setup_lines(self, lines):
        return "".join(f"text {line}\nwait {600 * MS}\n" for line in lines) + "rest\n"

    def run_program(self, program, board=boards.WITH_MOTION[0]):
        """What the controller answers to each 'hear' and 'rest' of a PC's program."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "pc.txt")
            path.write_text(program)
            done = subprocess.run([SIM, "firmware", ROOT / f"build/{board}/controller.elf", "--board", board,
                                   "--servos", "1-3", "--host", path],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.assertEqual(done.returncode, 0, done.stdout[-2000:])
        return [bytes.fromhex("".join(line.split()[4:])) for line in re.findall(r"^heard .*", done.stdout, re.M)]

    def talk(self, *steps, setup=READY, board=boards.WITH_MOTION[0]):
        """Types the lines of `setup`, then sends the packets of `steps`; a number of `steps` is a time in ms.
        Returns the error and the parameters of each status packet."""
        program = self.setup_lines(setup)
        for step in steps:
            if isinstance(step, int):
                program += f"wait {step * MS}\n"
                continue
            program += f"say {step[0].hex(' ')}\n" + (f"hear {step[1]} within 30\n" if step[1] else "") + "wait 1000\n"
        return [(status[4], status[5:-1]) for status in self.run_program(program, board)[1:]]

    def words(self, replies):
        return [int.from_bytes(data, "little") for _, data in replies]

    def test_line_that_stores_is_refused_after_a_motion_has_begun(self):
        """The console compares the name with its words, or reads the servos, before it stores: the motion begins then."""
        setup = [*POSES, "cycle every 4ms", "sequence s new stand 20ms", *["sequence s add stand 20ms"] * 4]
        for line in "pose set zz 1 2 3", "pose save zz", "sequence q new stand 1s":
            program = self.setup_lines(setup) + f"text {line}\nwait {7 * MS}\nsay {write(PLAY, 1)[0].hex(' ')}\n" \
                f"hear 6 within 30\nwait {1000 * MS}\nrest\nsay {read(PLAY, 6)[0].hex(' ')}\nhear 12 within 30\n"
            heard = self.run_program(program)[1:]
            self.assertIn(b"error 58", heard[1], line)
            self.assertEqual(heard[2][5:11], bytes([0, 100, 0, 0, 0, 0]), line)

    def test_play_moves_servos_and_shows_state_step_and_end(self):
        for board in boards.WITH_MOTION:
            replies = self.talk(write(PLAY, BOW), read(PLAY, 6), wait(200), read(PLAY, 6), wait(500), read(STEP),
                                position(1), wait(1500), read(PLAY, 6), position(1), board=board)
            self.assertEqual(replies[:3], [(0, b""), (0, bytes([BOW, 100, 0, 1, 0, 0])),
                                           (0, bytes([BOW, 100, 0, 2, 1, 0]))])
            self.assertEqual(replies[3], (0, b"\2"))
            self.assertLess(self.words(replies)[4], 508)
            self.assertEqual(replies[5], (0, bytes([0, 100, 0, 0, 0, 0])))
            self.assertAlmostEqual(self.words(replies)[6], 512, delta=4)

    def test_pause_override_and_end(self):
        replies = self.talk(write(PLAY, LONG, 50), wait(1500), write(PAUSE, 1), wait(600), read(PLAY, 6), position(1),
                            wait(800), position(1), write(OVERRIDE, 200), write(PAUSE, 0), wait(700), position(1),
                            write(PLAY, 0), wait(600), position(1), wait(300), position(1), read(PLAY, 6),
                            write(PLAY, 0), write(PAUSE, 1))
        words = self.words(replies)
        self.assertEqual(replies[2], (0, bytes([LONG, 50, 1, 2, 1, 0])))
        self.assertEqual(words[3], words[4])  # it rests
        self.assertLess(words[7], words[4] - 10)
        self.assertEqual(words[9], words[10])
        self.assertGreater(words[10], 412)  # it was ended on the way
        self.assertEqual(replies[11], (0, bytes([0, 200, 0, 0, 0, 79])))
        self.assertEqual(replies[12:], [(RANGE, b"")] * 2)

    def test_refused_pose_leaves_the_override_of_the_motion(self):
        """The last line of the set-up begins a move of 5 s; a pose in 10 ms is refused."""
        program = self.setup_lines(READY + ["pose low in 5s"])
        for line in f"say {write(OVERRIDE, 50)[0].hex(' ')}\nhear 6 within 30\n", "text pose low in 10ms\nwait 100000\nrest\n", "":
            program += line + f"wait {100 * MS}\n"
        program += f"say {read(OVERRIDE)[0].hex(' ')}\nhear 7 within 30\n"
        heard = self.run_program(program)
        self.assertIn(b"error 57", b"".join(heard))
        self.assertEqual(heard[-1][5], 50)

    def test_play_is_refused_as_at_the_console(self):
        replies = self.talk(write(PLAY, 3), write(OVERRIDE, 9), write(PLAY, LONG), wait(300), write(PLAY, BOW),
                            read(STATE), write(0x10, 1))
        self.assertEqual([error for error, _ in replies], [RANGE, RANGE, 0, RANGE, 0, RANGE])
        self.assertEqual(self.words(replies)[4], 2)

    def test_goal_id_and_rate_of_a_servo_in_motion_are_a_range_error(self):
        """The bridge answers in place of the servo. The motion goes on, and the servo keeps ID and rate."""
        replies = self.talk(write(PLAY, LONG), wait(300), *((packet(1, WRITE, data), 6) for data in (
            [GOAL_POSITION, 0, 2], [ID, 7], [BAUD, 34])), wait(40), read(STATE), position(1), position(2))
        self.assertEqual([error for error, _ in replies], [0, RANGE, RANGE, RANGE, 0, 0, 0])
        self.assertEqual(self.words(replies)[4], 2)

    def test_store_cannot_be_read_while_settings_are_saved(self):
        """A packet SAVE, and a line of the console in the midst of the save: between two bytes, or within one."""
        save = "say " + write(0x10, 1)[0].hex(" ") + "\nhear 6 within 30\n"
        for late_us in (1, 1700, 3500, 20000):
            for line in ("pose list", "pose show", "sequence list", "sequence show bow", "play bow", "pose stand in 1s",
                         "settings autostart"):
                said = self.run_program(self.setup_lines(READY) + save + f"wait {late_us}\ntext {line}\nwait {600 * MS}\n"
                                        f"rest\ntext sequence list\nwait {600 * MS}\nrest\n")[2:]
                self.assertIn(b"error 63", said[0], line)
                self.assertEqual(said[1].split(), [b"bow", b"long", b"ok"])

    def test_save_begun_while_the_store_is_listed_ends_the_list(self):
        """It does not leave lines out and answer ok."""
        save = f"wait 2000\nsay {write(0x10, 1)[0].hex(' ')}\nwait {600 * MS}\nrest\n"
        for line in ("pose show", "sequence show"):
            said = b"".join(self.run_program(self.setup_lines(READY) + f"text {line}\n{save}")[1:])
            self.assertNotIn(b"ok", said, line)
            self.assertIn(b"error 63", said, line)

    def test_play_while_inhibited_is_refused(self):
        replies = self.talk(write(PLAY, BOW), setup=READY + ["stop"])
        self.assertEqual(replies, [(RANGE, b"")])

    def test_error_tells_why_nothing_plays(self):
        for setup, number in [(READY + ["pose delete low"], 78), (READY + ["group 1 2"], 81),
                              (READY + ["limits 1 140 300"], 11), (READY + ["stop", "release"], 84),
                              (POSES + ["sequence bow new low 20ms"], 57),
                              (POSES + ["sequence bow new low 1s", "sequence bow add stand 20ms"], 57)]:
            replies = self.talk(write(PLAY, BOW), wait(300), read(PLAY, 6), setup=setup)
            self.assertEqual(replies, [(0, b""), (0, bytes([0, 100, 0, 0, 0, number]))], setup[-1])

    def test_servo_whose_torque_goes_off_is_error_84(self):
        replies = self.talk(write(PLAY, LONG), wait(300), (packet(1, WRITE, [TORQUE_ENABLE, 0]), 6), wait(2500),
                            read(PLAY, 6))
        self.assertEqual(replies[-1], (0, bytes([0, 100, 0, 0, 0, 84])))

    def test_console_sees_what_the_pc_plays(self):
        """And the PC what the console plays."""
        replies = self.talk(wait(200), read(PLAY, 6), setup=READY + ["play long at 80%"])
        self.assertEqual(replies, [(0, bytes([LONG, 80, 0, 2, 1, 0]))])

    def test_boards_without_motions_read_0_and_refuse(self):
        for board in set(boards.CONSOLES) - set(boards.WITH_MOTION):
            replies = self.talk(read(PLAY, 6), *(write(register, value) for register, value in
                                                 [(PLAY, 0), (PLAY, 1), (OVERRIDE, 100), (PAUSE, 1)]),
                                setup=["echo off"], board=board)
            self.assertEqual(replies, [(0, bytes(6))] + [(RANGE, b"")] * 4)


if __name__ == "__main__":
    unittest.main()
