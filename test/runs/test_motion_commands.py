# SPDX-License-Identifier: MIT
"""The commands of the group "Motion:" that teach and store, over the firmware in the simulator: loads turn servos by hand
while torque is off. test_motion_play.py has those that move servos."""
# needs: $(CONSOLE_ELFS)
import pathlib
import re
import unittest

from motion_console import FULL, MOVING, Motion, READY, TWO_BOARDS, turned
from simulator import ROOT, controller


class EndlessTurn(Motion):
    """A speed turns a servo in endless turn without end, so no motion takes one."""

    SEQUENCE = "pose set a 150 150 150\nsequence w new a 0.5s\n"

    def assert_refused(self, turn, command):
        run = controller(READY + self.SEQUENCE + turn + command + "\n@wait 500\n",
                         MOVING[0], "1-3")
        self.assertIn("error 47", run.output)
        speeds = [data for _, way, data in run.packets if way == "->in" and " 83 1E" in data]
        self.assertEqual(speeds, [], "goals left")

    def test_play_and_timed_pose_are_refused(self):
        for command in ("play w\nmotion wait", "pose 150 200 150 in 1s\nmotion wait", "pose 150 200 150 at 20rpm"):
            with self.subTest(command):
                self.assert_refused("turn 2 0rpm\n", command)

    def test_mode_that_the_controller_does_not_know_is_read(self):
        for command in ("play w\nmotion wait", "pose 150 200 150 in 1s\nmotion wait"):
            with self.subTest(command):
                self.assert_refused("turn 2 0rpm\nservos forget\ngroup 1 2 3\n", command)

    def test_pose_leaves_out_a_servo_in_endless_turn(self):
        run = self.run_on("turn 2 0rpm\ngroup 1 3\npose set b 150 200\ngroup 1 2 3\npose b in 1s\nmotion wait\n"
                          "@expect servo 3 GOAL_POSITION 682\n", MOVING[0])
        self.assertNotIn("error", run.output)


class Teach(Motion):
    def test_teach_off_holds_servos_where_a_hand_has_turned_them(self):
        run = self.run_on("teach on\n@expect servo 1-3 torque off\n" + turned(1, 200) + turned(2, -200)
                          + "@expect servo 1 PRESENT_POSITION 448\n@expect servo 2 PRESENT_POSITION 576\n"
                          + "teach off\n@expect servo 1-3 torque on\n@wait 300\n"
                          + "@expect servo 1 PRESENT_POSITION 448\n@expect servo 1 GOAL_POSITION 448\n"
                          + "@expect servo 2 PRESENT_POSITION 576\n@expect servo 3 PRESENT_POSITION 512\n")
        sent = [data.split() for _, way, data in run.packets if way == "->in"]
        last = [data for data in sent if data[2] == "02"]
        goal = last.index("FF FF 02 05 03 1E 40 02 95".split())
        check = last.index("FF FF 02 04 02 05 2A C8".split(), goal)  # a READ up to 0x2E, goal included
        torque = last.index("FF FF 02 04 03 18 01 DD".split())
        self.assertLess(check, torque)  # the goal is read back before torque goes on

    def test_teach_takes_servos_by_id(self):
        self.run_on("teach on 2 3\n@expect servo 1 torque on\n@expect servo 2,3 torque off\n"
                    "teach off 3\n@expect servo 3 torque on\n@expect servo 2 torque off\n")

    def test_teach_off_leaves_a_servo_with_torque_alone(self):
        run = self.run_on("move 1 100\n@wait 5\nteach off 1\n@expect servo 1 GOAL_POSITION 341\n"
                          "@expect servo 1 PRESENT_POSITION 339..343 within 3000\n")
        self.assertNotIn("FF FF 01 05 03 1E 00 02", run.transcript)

    def test_teach_off_of_a_servo_that_fails_goes_on_with_the_others(self):
        self.run_on("teach on\n@power 1 off\n! teach off\n@expect text servo 1: no reply by the deadline\n"
                    "@expect text servo 2: ok\n@expect text error 87:\n@expect servo 2,3 torque on\n")

    def test_teach_has_a_line_for_each_servo_as_other_lists(self):
        for line in "teach on", "teach off", "teach off 1,2,3":
            self.run_on(f"@power 2 off\n! {line}\n@expect text servo 1: ok\n@expect text servo 2: no reply by the deadline\n"
                        "@expect text servo 3: ok\n@expect text error 87:\n")

    def test_teach_off_keeps_torque_off_while_inhibited(self):
        self.run_on("teach on\nstop\n! teach off\n@expect text error 54: stopped\n"
                    "@expect servo 1-3 torque off\nrelease\nteach off\n@expect servo 1-3 torque on\n")

    def test_teach_off_of_a_hot_servo_says_so(self):
        self.run_on("teach on\n@ambient 2 120\n@expect servo 2 error 0x04 within 60000\n! teach off 2\n"
                    "@expect text error 85: servo 2:\n@expect servo 2 torque off\nteach off 1\n"
                    "@expect servo 1 torque on\n")

    def test_torque_on_of_a_hot_servo_is_refused(self):
        for board in "arduino-mega", "atmega128", "atmega1284p":
            with self.subTest(board):
                self.run_on("teach on\n@ambient 2 120\n@expect servo 2 error 0x04 within 60000\n! torque 2 on\n"
                            "@expect text error 85: servo 2:\n@expect servo 2 torque off\ntorque 1 on\n", board)

    def test_teach_off_of_an_endless_servo_is_refused(self):
        self.run_on("teach on 1\nwrite 1 CW_ANGLE_LIMIT 0 0\nwrite 1 CCW_ANGLE_LIMIT 0\n"
                    "write 1 MOVING_SPEED 300\n! teach off 1\n@expect text servo 1: the servo is in endless turn\n"
                    "@expect text error 47:\n@expect servo 1 torque off\n")

    def test_teach_off_outside_the_soft_limits_is_refused(self):
        self.run_on("limits 1 0 149.9\nteach on 1\n! teach off 1\n@expect text error 11:\n"
                    "@expect servo 1 torque off\n")

    def test_teach_off_with_a_goal_not_kept_leaves_torque_off(self):
        self.run_on("teach on 1\n" + turned(1, 200) + "@fault flip in 2 6 1\n@fault flip in 2 8 1\n! teach off 1\n"
                    "@expect text error 70:\n@expect servo 1 GOAL_POSITION 449\n"
                    "@expect servo 1 torque off\n")

    def test_teach_needs_servos_and_no_operation(self):
        self.run_on("servos forget\n! teach on\n@expect text error 45:\ngroup 1 2\ncycle every 4ms\n"
                    "! teach off\n@expect text error 43:\n! teach on\n@expect text error 43:\n"
                    "! group 1\n@expect text error 43:\n! pose 1 2 3 4\n@expect text error 46:\n")


def shown(run):
    """The lines of a run that store poses and sequences again."""
    return "".join(f"{line}\n" for line in run.output.splitlines()
                   if line.startswith(("group", "pose set", "sequence ")) and not line.endswith("sync"))


POSES = "pose set stand 90 100 110\npose set low 120 130 140\ngroup 3 1\npose set lift 80 70\ngroup 1 2 3\n"
WALK = ("sequence walk new stand 1.2s dwell 0.5s\nsequence walk add low 0.3s pass\n"
        "sequence walk add lift 2s\n")


class Stored(Motion):
    def test_pose_save_stores_where_servos_are(self):
        run = self.run_on("teach on\n" + turned(1, 200) + "teach off\npose save stand\n@echo on\n"
                          "pose list\n@expect text stand\npose show stand\n")
        self.assertEqual(shown(run), "group 1 2 3\npose set stand 448raw 512raw 512raw\n")

    def test_pose_of_a_name_is_replaced(self):
        run = self.run_on("pose set stand 90 100 110\npose set stand 0 300 150\n@echo on\npose show\n")
        self.assertEqual(shown(run), "group 1 2 3\npose set stand 0raw 1023raw 512raw\n")

    def test_what_is_shown_is_stored_again_elsewhere(self):
        first = shown(self.run_on(POSES + WALK + "@echo on\npose show\nsequence show\n"))
        self.assertIn("group 1 3\npose set lift 239raw 273raw\n", first)
        self.assertIn("sequence walk add low 0.3s pass\n", first)
        again = self.run_on(first + "@echo on\npose show\nsequence show\n")
        self.assertEqual(shown(again), first)
        twice = self.run_on(first + first + "@echo on\npose show\nsequence show\n", "arduino-mega")
        self.assertEqual(shown(twice), first)

    def test_poses_and_sequences_survive_power_off(self):
        for board in FULL:
            run = self.run_on(POSES + WALK + "@reset power\n@wait 300\n@echo on\npose show low\n"
                              "sequence show walk\n", board)
            self.assertEqual(shown(run), "group 1 2 3\npose set low 409raw 443raw 477raw\n"
                             + WALK)

    def test_pose_is_reached_in_time(self):
        for board in FULL:
            self.run_on(POSES + "pose low in 1s\n@expect servo 1 PRESENT_POSITION 406..412 within 1200\n"
                        "@expect servo 3 PRESENT_POSITION 474..480 within 50\n"
                        "pose lift in 1s\n@wait 1200\n@expect servo 1 PRESENT_POSITION 236..242\n"
                        "@expect servo 2 PRESENT_POSITION 440..446\n", board)

    def test_pose_without_group_moves_servos_of_stored_poses(self):
        self.run_on(POSES + "@reset power\n@wait 300\ntorque 254 on\npose stand in 1s\n"
                    "group\n@expect text group 1 2 3\n"
                    "@expect servo 1 PRESENT_POSITION 304..310 within 1500\n")

    def test_pose_save_without_reply_stores_nothing(self):
        self.run_on("pose set stand 90 100 110\n@power 2 off\n! pose save stand\n"
                    "@expect text servo 2: no reply by the deadline\n@expect text error 2:\n@echo on\n"
                    "pose show stand\n@expect text pose set stand 307raw 341raw 375raw\n"
                    "! pose save other\n! pose show other\n@expect text error 74:\n")

    def test_play_ends_while_the_line_is_held_low(self):
        self.run_on("group 1-3\ntorque 1-3 on\npose set a 90 90 90\nsequence w new a 1s\n@fault stuck low 4000\n@wait 10\n"
                    "! play w\n@expect text error 9:\n@wait 6000\n@expect servo 1 PRESENT_POSITION 510..514\n", MOVING[0])

    def test_names_that_are_none_are_refused(self):
        self.run_on("".join(f"! {line}\n@expect text error {number}:\n" for line, number in [
            ("pose save a_b", 71), ("pose save 1st", 71), ("pose save abcdefghi", 72),
            ("pose save " + "x" * 30, 72), ("pose save move", 73), ("pose save dwell", 73), ("pose save OK", 73),
            ("pose set on 1 2 3", 73), ("pose show abcdefghi", 74), ("pose delete stand", 74),
            ("pose stand in 1s", 74), ("sequence show walk", 75), ("sequence delete walk", 75),
            ("sequence walk add stand 1s", 74)])
            + "! pose show abcdefghi\n@expect text error 74: 'abcdefghi': unknown pose; 'pose list'\n"
            "! sequence walk add stand 1s\n@expect text error 74: 'stand': unknown pose\n"
            "! sequence show walk\n@expect text error 75: 'walk': unknown sequence\n")
        self.run_on(POSES + "".join(f"! {line}\n@expect text error {number}:\n" for line, number in [
            ("sequence a-b new stand 1s", 71), ("sequence abcdefghi new stand 1s", 72),
            ("sequence help new stand 1s", 73)])
            + "pose save abcdefgh\npose save A1\npose save Mover\n")

    def test_bad_steps_are_refused(self):
        self.run_on(POSES + "".join(f"! {line}\n@expect text error {number}:\n" for line, number in [
            ("sequence walk add stand 0s", 56), ("sequence walk add stand 4ms", 56),
            ("sequence walk add stand 600.1s", 56), ("sequence walk add stand 1s dwell 66s", 56),
            ("sequence walk add stand 5ms", 56), ("sequence walk add stand 1234ms", 91),
            ("sequence walk add stand 1s dwell 5ms", 91), ("sequence walk add stand 0.015s pass", 91),
            ("sequence walk add stand 1deg", 39), ("sequence walk add stand", 31),
            ("sequence walk add stand 1s dwell 1s pass", 31)])
            + "! sequence show walk\n" + "sequence walk add stand 1s\n" * 16
            + "! sequence walk add stand 1s\n@expect text error 77:\nsequence walk new stand 10ms\n"
              "sequence walk add stand 600s dwell 65.53s\n", MOVING[0])

    def test_step_with_dwell_and_pass_names_both_words(self):
        for line in ("add stand 1s pass dwell 1s", "add stand 1s dwell 1s pass", "set 1 stand 1s pass dwell 1s", "set 1 stand 1s dwell 1s pass"):
            self.run_on(POSES + WALK + f"! sequence walk {line}\n@expect text error 31: a step has 'dwell TIME' or 'pass', not both\n",
                        MOVING[0])
        run = self.run_on(POSES + WALK + "! sequence walk add stand 1s dwell\n! sequence walk add stand 1s dwell 1s 1s\n"
                          "! sequence walk add stand 1s pass 1s\n", MOVING[0], "--echo")
        self.assertNotIn("not both", run.output)

    def test_time_of_a_step_that_is_not_stored_is_answered_with_one_that_is(self):
        for line, given, time in [("new stand 856ms", 856, 860), ("new stand 1s dwell 5ms", 5, 10), ("new stand 1.001s pass", 1001, 1010),
                                  ("new stand 2001ms dwell 1s", 2001, 2010), ("set 1 stand 234ms", 234, 240)]:
            self.run_on(POSES + WALK + f"! sequence walk {line}\n@expect text error 91: {given}ms is not a multiple of 10 ms, "
                        f"nothing was stored; give {time}ms\n", MOVING[0])

    def test_sequence_with_a_deleted_pose_says_so(self):
        self.run_on(POSES + WALK + "pose delete low\n! sequence show walk\n@expect text sequence walk step 2: its pose is deleted\n"
                    "@expect text error 78:\npose set low 1 2 3\n! sequence show walk\n")

    def test_no_step_is_added_after_a_refused_new(self):
        """The lines of an import never go to an older sequence of the same name."""
        add, refused = "sequence walk add low 1s\n", "! sequence walk add low 1s\n@expect text error 94:\n"
        for new in ("walk new nix 1s", "walk new stand", "walk new stand 1s dwel 1s", "walk nwe stand 1s",
                    "walk new stand 1s dwell 66s", "walk step 1: its pose is deleted", "walk ew stand 1s", "wa=k new stand 1s"):
            run = self.run_on(POSES + WALK + f"! sequence {new}\n" + refused + "pose list\n" + refused
                              + "! sequence walk new stand 5ms\n" + refused + "@echo on\nsequence show\n")
            self.assertEqual(shown(run), WALK)
        self.run_on(POSES + WALK + "! sequence walk add nix 1s\n" + add + "! sequence walk new nix 1s\n" + refused
                    + "sequence list\n" + add + "! sequence walk ad low 1s\n" + add + "! sequence walk new nix 1s\nsequence walk new stand 1s\n" + add)

    def test_refused_line_that_is_no_new_lets_add_go_on(self):
        """`sequence walk play` is a slip of a person, and no line of an import."""
        for line in ("walk", "walk play", "play walk", "walk loop", "new", "walk addd low 1s", "walk delte 1", "walk insret 1 low 1s",
                     "walk set 1", "walk seet 1 low 1s"):
            self.run_on(POSES + WALK + f"! sequence {line}\nsequence walk add low 1s\n")

    def test_pose_with_a_joint_outside_the_group_is_refused(self):
        self.run_on(POSES + "group 1 2\n! pose stand in 1s\n@expect text error 81:\n"
                    "group 3 2 1\npose stand in 1s\n@expect servo 1 GOAL_POSITION 307 within 1500\n")

    def test_full_store_says_so(self):
        run = self.run_on("@echo on\nstatus\n@expect text room for\n", MOVING[0])
        room = int(re.search(r"poses: 0, room for (\d+); sequences: 0, room for", run.output)[1])
        self.assertGreaterEqual(room, 48)
        self.run_on("".join(f"pose set p{n} 1 2 3\n" for n in range(room))
                    + "! pose set more 1 2 3\n@expect text error 76:\npose set p0 4 5 6\n"
                    f"status\n@expect text poses: {room}, room for 0; sequences: 0\n"
                    "pose delete p7\npose set more 1 2 3\n", MOVING[0])

    def test_too_many_joints_are_refused(self):
        ids = " ".join(str(n) for n in range(1, 19))
        self.run_on(f"group {ids}\npose set a {ids}\nservos forget\ngroup 1 30\n! pose set b 1 2\n"
                    "@expect text error 80:\ngroup 1 2\npose set b 1 2\n")

    def test_servos_of_deleted_poses_are_free_places(self):
        ids = " ".join(str(n) for n in range(1, 19))
        run = self.run_on(f"group {ids}\npose set a {ids}\nservos forget\ngroup 18 2\npose set b 180 20\n"
                          "servos forget\ngroup 30 1 31\n! pose set c 1 2 3\n@expect text error 80:\npose delete a\n"
                          "pose set c 30 10 31\n@echo on\npose show\n")
        self.assertEqual(shown(run), "group 2 18\npose set b 68raw 614raw\ngroup 1 30 31\npose set c 34raw 102raw 106raw\n")

    def test_stop_amid_a_save_keeps_the_old_pose_or_the_new_one(self):
        old, new = "pose set stand 307raw 341raw 375raw", "pose set stand 3raw 7raw 10raw"
        found = set()
        for us in range(8_000, 500_000, 21_000):
            said = self.typed(READY + "pose set stand 90 100 110\n",
                              [("text pose set stand 1 2 3", us), ("say 18", 30_000),
                               ("text pose show stand", 100_000)])
            line = re.search("pose set stand .*", said.replace("\r", ""))[0]
            self.assertIn(line, (old, new) if "error 54" in said else (new,))
            found.add(line)
        self.assertEqual(found, {old, new})


class Steps(Motion):
    """sequence NAME set, insert, delete: one step of a stored sequence."""

    BEGIN = ("pose set a 100 100 100\npose set b 120 120 120\nsequence w new a 1s\nsequence w add b 2s dwell 0.5s\n"
             "sequence w add a 3s pass\n")

    def stored_after(self, lines):
        run = self.run_on(self.BEGIN + lines + "sequence show w\n", MOVING[0], "--echo")
        return [line.removeprefix("sequence w ") for line in shown(run).splitlines()
                if line.startswith("sequence w ") and "this pose" not in line]

    def test_set_replaces_one_step(self):
        self.assertEqual(self.stored_after("sequence w set 2 a 1.23s pass\n"), ["new a 1s", "add a 1.23s pass", "add a 3s pass"])
        self.assertEqual(self.stored_after("sequence w set 1 b 10ms dwell 20ms\nsequence w set 3 b 4s\n"),
                         ["new b 0.01s dwell 0.02s", "add b 2s dwell 0.5s", "add b 4s"])

    def test_insert_moves_the_steps_behind_it(self):
        self.assertEqual(self.stored_after("sequence w insert 1 b 5s\nsequence w insert 4 b 6s pass\n"),
                         ["new b 5s", "add a 1s", "add b 2s dwell 0.5s", "add b 6s pass", "add a 3s pass"])

    def test_delete_takes_out_one_step(self):
        self.assertEqual(self.stored_after("sequence w delete 2\n"), ["new a 1s", "add a 3s pass"])
        self.assertEqual(self.stored_after("sequence w delete 3\nsequence w delete 1\n"), ["new b 2s dwell 0.5s"])

    def test_show_numbers_the_steps(self):
        run = self.run_on(self.BEGIN + "sequence w show\npose delete b\nsequence w show\n! sequence v show\n@expect text error 75:\n",
                          MOVING[0], "--echo")
        self.assertEqual(re.findall("^([1-9]: .*)", run.output, re.M), [
            "1: a 1s", "2: b 2s dwell 0.5s", "3: a 3s pass", "1: a 1s", "2: its pose is deleted", "3: a 3s pass"])

    def test_full_sequence_takes_no_step_more_but_a_change(self):
        lines = "".join(f"sequence w add b {n}s\n" for n in range(1, 14))
        steps = self.stored_after(lines + "! sequence w insert 1 a 1s\n@expect text error 77:\nsequence w set 16 a 9s\n"
                                  "sequence w set 1 b 8s\n")
        self.assertEqual((len(steps), steps[0], steps[14], steps[15]), (16, "new b 8s", "add b 12s", "add a 9s"))
        steps = self.stored_after(lines + "sequence w delete 1\nsequence w insert 1 b 7s\n")
        self.assertEqual((len(steps), steps[0], steps[1], steps[15]), (16, "new b 7s", "add b 2s dwell 0.5s", "add b 13s"))

    def test_wrong_steps_change_nothing(self):
        """Also the last step that is left, and any step while the sequence plays."""
        wrong = [("delete 4", 33), ("delete 0", 33), ("set 4 a 1s", 33), ("insert 4 a 1s", 33), ("set 1 c 1s", 74),
                 ("set 1 a 1ms", 56), ("set 1 a 1234ms", 91), ("set 1 a", 31), ("set a 1s", 32), ("delete", 31)]
        steps = self.stored_after("".join(f"! sequence w {line}\n@expect text error {number}:\n" for line, number in wrong)
                                  + "! sequence v delete 1\n@expect text error 75:\nplay w at 200%\n"
                                  "! sequence w delete 1\n@expect text error 58:\nmotion off\n@wait 300\n")
        self.assertEqual(steps, ["new a 1s", "add b 2s dwell 0.5s", "add a 3s pass"])
        self.assertEqual(self.stored_after("sequence w delete 2\nsequence w delete 2\n! sequence w delete 1\n"
                                           "@expect text error 33:\n"), ["new a 1s"])

    def test_set_mends_a_step_whose_pose_is_deleted(self):
        self.assertEqual(self.stored_after("pose set c 90 90 90\nsequence w set 2 c 1s\npose delete c\n! play w\n"
                                           "@expect text error 78:\nsequence w set 2 b 1s\nplay w at 200%\nmotion wait\n"),
                         ["new a 1s", "add b 1s", "add a 3s pass"])

    def test_chip_without_room_has_no_such_command(self):
        self.run_on(self.BEGIN + "! sequence w delete 1\n@expect text error 38:\n! motion at 50%\n@expect text error 38:\n",
                    TWO_BOARDS[1])


class Errors(unittest.TestCase):
    def test_every_error_of_motions_is_provoked(self):
        text = "".join(path.read_text() for path in [
            pathlib.Path(__file__).with_name(f"{suite}.py")
            for suite in ("test_motion_commands", "test_motion_play", "test_autostart")])
        table = (ROOT / "src/controller/console/errors.h").read_text()
        others = {*range(87, 91), 95}  # of lists of servos and of `new`: their own suites
        numbers = {n for n in map(int, re.findall(r"X\(ERROR_\w+, (\d+),", table)) if n >= 70 and n not in others}
        self.assertGreater(len(numbers), 10)
        self.assertEqual({n for n in numbers if not re.search(rf"error {n}:|, {n}\)", text)}, set())


if __name__ == "__main__":
    unittest.main()
