# SPDX-License-Identifier: MIT
"""The commands of the group "Motion:" that move servos, over the firmware in the simulator."""
# needs: $(CONSOLE_ELFS)
import pathlib
import re
import tempfile
import unittest

from motion_console import FULL, LOW, MOVING, Motion, READY, STAND, SWEEP, SWING, TWO_BOARDS, WALKING
from simulator import ROOT, controller


class Play(Motion):
    eeproms = {}  # by board and lines that store

    def eeprom_with(self, lines, board):
        """The EEPROM of a controller that has stored these lines."""
        if (board, lines) not in self.eeproms:
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder, "eeprom")
                super().run_on(lines, board, "--eeprom", path)
                self.eeproms[board, lines] = path.read_bytes()
        return self.eeproms[board, lines]

    def run_on(self, script, board=MOVING[0], *options):
        """The lines in front that store poses and sequences run once for each board: they take longer than most
        of the tests."""
        lines = re.match("(?:(?:pose set|sequence) .*\n)*", script)[0]
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "eeprom")
            path.write_bytes(self.eeprom_with(lines, board))
            return super().run_on(script[len(lines):], board, "--eeprom", path, *options)

    def run_on_each(self, script):
        for board in MOVING:
            with self.subTest(board):
                self.run_on(script, board)

    def test_play_moves_servos_step_by_step(self):
        self.run_on_each(WALKING + "play walk\nmotion\n@expect text motion: walk: step 1 of 4, run 1, at 100%\n"
                    "@wait 600\n" + LOW + "@wait 300\nmotion\n@expect text step 2 of 4, run 1\n@wait 400\n"
                    + STAND.replace("508..515", "495..515") + "motion wait\n" + STAND
                    + "motion\n@expect text motion: none\n@wait 50\n! cycle\n@expect text error 44:\n")

    def duration(self, script):
        return float(re.search(r"time: +([\d.]+) s", self.run_on(script + "motion wait\n").output)[1])

    def test_play_several_times(self):
        once, twice = (self.duration(WALKING + line) for line in ("play walk\n", "play walk times 2\n"))
        self.assertAlmostEqual(twice - once, 1.8, delta=0.1)

    def test_play_faster(self):
        whole, fast = (self.duration(SWEEP + line) for line in ("play sweep\n", "play sweep at 200%\n"))
        self.assertAlmostEqual(whole - fast, (2 + 2) / 2, delta=0.1)

    def test_motion_shows_the_speed_that_the_servos_can(self):
        self.run_on_each(SWEEP.replace("b 2s", "b 1.5s") + "play sweep at 200%\n@wait 300\nmotion\n"
                         "@expect text step 1 of 2, run 1, at 200%\n@wait 1000\nmotion\n@expect text step 2 of 2, run 1, at 165%\n")

    def test_play_faster_than_the_servos_can_does_not_jump(self):
        run = self.run_on("pose set a 90 100 110\npose set b 120 130 140\nsequence f new a 0.4s pass\n"
                          "sequence f add b 0.3s pass\nsequence f add a 0.3s\nteach off\nplay f\nmotion wait\n"
                          "play f times 3 at 200%\nmotion wait\n", MOVING[0])
        goals = [int(data.split()[8], 16) | int(data.split()[9], 16) << 8
                 for _, way, data in run.packets if way == "->in" and " 83 1E 04 " in data]
        self.assertGreater(len(goals), 500)
        self.assertLessEqual(max(abs(one - other) for one, other in zip(goals, goals[1:])), 6)

    def test_play_goes_on_in_a_loop_until_motion_off(self):
        self.run_on(WALKING + "play walk loop\n@wait 4200\nmotion\n@expect text run 3\nmotion off\n"
                    "motion\n@expect text motion: none\n! motion off\n@expect text error 79:\n"
                    "@wait 100\n@expect servo 1-3 MOVING 0\n@expect servo 1-3 torque on\n")

    def test_a_servo_that_loses_its_power_ends_the_motion(self):
        self.run_on(SWING + "sequence walk new low 2s\nsequence walk add stand 2s\nplay walk loop\n@wait 500\n"
                    "@power 1 off\n! motion wait\n@expect text servo 1 is the cause\n@expect text error 2:\n"
                    "@power 1 on\n@wait 1500\nrelease\n")

    def test_a_new_motion_is_not_paused(self):
        self.run_on(WALKING + "play walk\n@wait 200\npause\nmotion off\n@wait 100\npose 100 110 120 in 1s\n"
                    "motion\n@expect text motion: a move\n@wait 10\nmotion wait\n"
                    "@expect servo 1 PRESENT_POSITION 338..344\n")

    def test_a_pause_at_any_time_holds(self):
        """Also while the next step is checked, and near a pose that is passed."""
        for ms in range(480, 560, 9):
            run = self.run_on(WALKING + f"play walk loop\n@wait {ms}\npause\n@wait 800\n")
            goals = [packet for _, way, packet in run.packets if way == "->in" and " 83 1E 04 " in packet]
            self.assertEqual(len(set(goals[-150:-1])), 1, ms)  # the last one may be cut

    def test_a_pause_at_rest_keeps_the_next_step_back(self):
        self.run_on(SWING + "sequence walk new low 0.5s dwell 0.5s\nsequence walk add stand 0.5s\n"
                    "play walk\n@wait 800\npause\n@wait 1000\nmotion\n@expect text step 1 of 2, run 1, paused\n"
                    + LOW + "resume\nmotion wait\n@wait 50\n" + STAND)

    def test_pause_and_resume_stop_on_the_way_and_at_rest(self):
        self.run_on(SWING + "sequence walk new low 1s dwell 0.5s\nsequence walk add stand 0.5s\n"
                    "play walk\n@wait 500\npause\n@wait 400\nmotion\n@expect text run 1, paused\n"
                    "@expect servo 1-3 PRESENT_SPEED 0\n@expect servo 1 PRESENT_POSITION 420..490\n"
                    "@wait 1000\n@expect servo 1 PRESENT_POSITION 420..490\nresume\n@wait 900\n" + LOW
                    + "pause\n@wait 800\n" + LOW + "resume\nmotion wait\n" + STAND)
        self.run_on("! pause\n@expect text error 79:\n! resume\n@expect text error 79:\n")

    def test_a_new_motion_while_one_is_paused_has_its_own_error(self):
        for motion in "play walk", "pose 100 110 120 in 1s":
            self.run_on(WALKING + f"{motion}\n@wait 200\npause\n@wait 300\n" + "".join(
                f"! {line}\n@expect text error 92:\n" for line in [
                    "pose 1 2 3 in 1s", "pose low in 1s", "play walk"])
                + "resume\n@wait 20\n! play walk\n@expect text error 58:\npause\nmotion off\n@wait 300\nplay walk\n")

    def test_wait_after_a_goal_beyond_the_limits_names_no_id(self):
        run = self.run_on(SWING + "limits 1 149 151\nsequence x new low 2s\n! play x\n! motion wait\n@expect text error 11: not within "
                          "the servo's limits; see 'servos' and docs/safety.md\n", MOVING[0], "--echo")
        self.assertNotIn("'id' sets an ID", run.output)

    def test_a_step_that_is_too_fast_lets_nothing_begin(self):
        """Also the way back to the first step of a repeated sequence."""
        steps = SWING + "sequence x new low 0.5s\nsequence x add stand 20ms\n"
        says = "@expect text servo 1 needs 250 ms in step 2\n@expect text error 57:\n"
        run = self.run_on(steps + f"! play x\n{says}! motion wait\n{says}")
        goals = {packet for _, way, packet in run.packets if way == "->in" and " 83 1E 04 " in packet}
        self.assertEqual(goals, set())
        back = SWING + "sequence x new low 100ms\nsequence x add low 0.5s\nsequence x add stand 0.5s\n"
        self.run_on(back + "pose low in 1s\nmotion wait\n! play x times 2\n@expect text in step 1\n"
                    "@expect text error 57:\nplay x\nmotion wait\n")

    def test_all_steps_that_are_too_fast_are_told_at_once(self):
        """Also a step that is too fast only in the second run. Nothing begins, and the start of a mended sequence is
        as any other."""
        steps = SWING + ("sequence x new low 100ms\nsequence x add stand 20ms\nsequence x add low 0.5s\n"
                         "sequence x add stand 30ms pass\nsequence x add low 0.5s\n")
        told = ["servo 1 needs 250 ms in step 2, pose stand", "servo 1 needs 250 ms in step 4, pose stand"]
        run = self.run_on(steps + "pose low in 1s\nmotion wait\n@wait 100\n! play x\n@expect text error 57:\n! motion wait\n"
                          "! play x loop\nsequence x set 2 stand 1s\n! play x\nsequence x set 4 stand 1s\nplay x\n"
                          "motion\n@expect text step 1 of 5\nmotion wait\n", MOVING[0], "--echo")
        found = re.findall("servo 1 needs .*|error 57", run.output)
        self.assertEqual(found, told + ["error 57", told[0], "error 57"] + told + ["error 57", told[1], "error 57"])

    def test_stop_amid_the_search_for_steps_too_fast(self):
        """Nothing moves, and the next sequence plays as any other."""
        steps = SWING + "sequence x new low 10ms\n" + "sequence x add stand 20ms\nsequence x add low 20ms\n" * 4
        heard = []
        for us in range(2_000, 200_000, 22_000):
            said = self.typed(READY + steps, [
                ("text play x", us), ("say 18", 100_000), ("text release", 50_000), ("text get 1 GOAL_POSITION", 50_000),
                ("text teach off", 100_000), ("text sequence x new low 1s", 300_000), ("text play x", 500_000),
                ("text motion", 50_000), ("text motion wait", 1_000_000), ("text get 1 GOAL_POSITION", 50_000)], MOVING[0])
            goals = re.findall(r"GOAL_POSITION = .*\((\d+)\)", said)
            self.assertEqual(len(goals), 2, said)
            self.assertIn(int(goals[0]), range(510, 515), said)
            self.assertIn(int(goals[1]), range(404, 414), said)
            self.assertIn("motion: x: step 1 of 1", said)
            heard.append((said.count("needs"), "error 54" in said))
        self.assertTrue([lines for lines, is_stopped in heard if is_stopped and 0 < lines < 9], heard)

    def test_motion_says_why_it_is_slower_than_play_asked(self):
        run = self.run_on(SWEEP.replace("b 2s", "b 1.5s") + "play sweep at 200%\n@wait 300\nmotion\n@wait 1000\nmotion\n",
                          MOVING[0], "--echo")
        self.assertEqual([line.split(", ", 2)[2] for line in run.output.splitlines() if line.startswith("motion: sweep")],
                         ["at 200%", "at 165%: a servo can go no faster, so not at 200%"])

    def test_error_of_a_motion_names_what_may_be_done(self):
        self.run_on(WALKING + "play walk loop\n! pose save z\n@expect text 'motion at PERCENT' changes its speed\n"
                    "pause\n! pose save z\n@expect text a motion is paused; 'resume' goes on with it\n")

    def test_motion_says_how_the_last_one_was_ended(self):
        lost = "settings link_loss_action 2\nsettings link_loss_ms 100\nplay walk loop\n@wait 600\n"
        for script, says in [("play walk loop\nmotion off\n@wait 300\n", "ended on its way by 'motion off' or 'cycle off'"),
                             ("play walk loop\nstop\n@wait 300\n", "ended on its way by a stop or a lost host link"),
                             (lost, "ended on its way, as the host link was lost; 'clear' when it is back")]:
            self.run_on(WALKING + script + f"motion\n@expect text motion: none\n@expect text last motion: {says}\n")
        self.run_on(WALKING + "play walk\nmotion off\n@wait 300\n! motion wait\n@expect text error 79: the last motion did not "
                    "reach its end: 'motion off'\n! motion off\n@expect text error 79: no motion is under way\n")

    def test_missing_group_is_named_with_its_servos(self):
        """After power-up the group is gone. What needs none takes the servos of the stored poses."""
        says = "@expect text error 45: no group chosen; 'group 1 2 3' chooses the servos of the stored poses\n"
        gone = WALKING + "@reset power\n@wait 100\n"
        self.run_on(gone + "".join(f"! {line}\n{says}" for line in ["cycle every 10ms", "group", "pose 1 2 3", "pose save z"])
                    + "teach on\nteach off\ngroup\n@expect text group 1 2 3 sync\n")
        self.run_on("@reset power\n@wait 100\n! teach off\n@expect text error 45: no group chosen; choose its servos\n")

    def test_play_warns_of_a_supply_that_is_too_low(self):
        says = "warning: since 'clear' servo 2 has reported a supply outside of MIN_VOLTAGE to MAX_VOLTAGE"
        run = self.run_on(WALKING + f"play walk\nmotion wait\n@supply 2 5.5\n@wait 300\nplay walk\n@expect text {says}\n",
                          MOVING[0], "--echo")
        self.assertEqual(run.output.count("has reported a supply"), 1)

    def test_a_step_too_fast_behind_a_pass_lets_nothing_begin(self):
        """The servos turn at low and at high: they must slow down to 0 there, so each way needs longer than the mean
        speed tells."""
        run = self.run_on(
            "group 1 2 3\npose set low 100 110 120\npose set high 200 190 180\npose set middle 150 150 150\n"
            "sequence z new low 1s\nsequence z add middle 1s\nsequence z add low 1s pass\nsequence z add high 0.4s pass\n"
            "sequence z add low 0.4s pass\nsequence z add middle 1s\n! play z\n"
            "@expect text servo 1 needs 510 ms in step 4\n@expect text error 57:\n")
        goals = {packet for _, way, packet in run.packets if way == "->in" and " 83 1E 04 " in packet}
        self.assertEqual(goals, set())

    def test_a_refused_motion_leaves_no_servos_and_no_group(self):
        for line, number in [("pose nosuch in 1s", 74), ("play nosuch", 75), ("pose low in 1s", 2), ("play walk", 2),
                             ("play x", 57)]:
            self.run_on(WALKING + "sequence x new low 1s\nsequence x add stand 10ms\nservos forget\n"
                        + ("@power 1-3 off\n" if number == 2 else "")
                        + f"! {line}\n@expect text error {number}:\n! group\n@expect text error 45:\n"
                        "status\n@expect text servos: 0\n")

    def test_rate_of_the_bus_stays_while_a_motion_plays(self):
        self.run_on(WALKING + "play walk loop\n" + "".join(f"! {line}\n@expect text error 58:\n" for line in [
            "bus 500000bps", "settings bus_baud 3", "settings bus_baud 500000", "baud 1 500000", "baud 1-3 500000"])
            + "settings bus_baud\nmotion\n@expect text walk\nmotion off\n@wait 300\nsettings bus_baud 3\n")

    def test_pose_in_time_is_a_motion_too(self):
        self.run_on(WALKING + "pose 100 110 120 in 1s\nmotion\n@expect text motion: a move\nmotion wait\n"
                    "@expect servo 1 PRESENT_POSITION 338..344\npose 150 150 150 in 1s\n@wait 300\n"
                    "! play walk\n@expect text error 58:\npause\n"
                    "motion\n@expect text motion: a move, paused\nresume\nmotion wait\n" + STAND)

    def test_goals_for_servos_of_a_motion_are_refused(self):
        run = self.run_on(
            WALKING + "servos\nmove 4 150\nplay walk loop\n" + "".join(
                f"! {line}\n@expect text error {number}:\n" for line, number in [
                    ("move 1 100", 58), ("turn 2 20", 58), ("pose 1 2 3", 58), ("pose 1 2 3 in 1s", 58),
                    ("pose low in 1s", 58), ("play walk", 58), ("write 1 GOAL_POSITION 100", 14),
                    ("write 254 GOAL_POSITION 100", 14), ("write 1 TORQUE_ENABLE 1 0 0 0 0 0 0 9", 14),
                    ("set 1 MOVING_SPEED 10rpm", 14), ("regwrite 2 GOAL_POSITION 5", 14), ("action", 14),
                    ("action 3", 14), ("reset 2", 14),
                    ("sync GOAL_POSITION 2 4:0,1 3:0,1", 14), ("teach on", 58), ("teach off 4", 58),
                    ("write 1 ID 5", 14), ("write 2 BAUD_RATE 34", 14), ("write 254 RETURN_DELAY 9", 14),
                    ("set 1 RETURN_DELAY 40us", 14), ("set 1 STATUS_RETURN_LEVEL 1", 14),
                    ("id 1 5", 58), ("baud 1 57600bps", 58), ("baud 1-3 57600bps", 58), ("factory 1", 58),
                    ("group 1 2", 58), ("group 4", 58), ("servos forget", 58), ("scan", 58)])
            + "write 4 GOAL_POSITION 600\nget 1 PRESENT_POSITION\nled 1 on\n"
            "motion\n@expect text walk\ntorque 3 off\n@expect servo 3 torque off\n! motion wait\n@expect text error 84:\n"
            "write 1 GOAL_POSITION 100\n", MOVING[0], "--servos", "1-4")
        self.assertIn("03 1E 64 00", run.transcript)

    def test_nothing_is_stored_while_a_motion_plays(self):
        self.run_on(WALKING + "settings return_delay 100\nplay walk loop\n" + "".join(
            f"! {line}\n@expect text error 58:\n" for line in [
                "pose save x", "pose set x 1 2 3", "pose delete low", "sequence walk add low 1s",
                "sequence delete walk", "save", "defaults"])
            + "settings return_delay\n@expect text return_delay = 100\n"
            "pose list\npose show\nsequence show\nmotion off\npose save x\nsave\ndefaults\n"
            "settings return_delay\n@expect text return_delay = 254\n")

    def test_play_of_what_cannot_be_played_is_refused(self):
        self.run_on(WALKING + "".join(f"! {line}\n@expect text error {number}:\n" for line, number in [
            ("play nix", 75), ("play walk at 9%", 82), ("play walk at 201%", 82), ("play walk at 80.5%", 32),
            ("play walk times 0", 33), ("play walk times 65536", 33), ("play walk loop loop", 38)])
            + "group 1 2\n! play walk\n@expect text error 81:\ngroup 3 1 2\nplay walk at 80\nmotion wait\n"
            "pose delete low\n! play walk\n@expect text error 78:\n! cycle\n@expect text error 44:\n")

    def test_step_too_fast_for_a_servo_says_how_long_it_needs(self):
        self.run_on(SWING + "sequence walk new low 50ms\n! play walk\n@expect text servo 1 needs\n"
                    "@expect text error 57:\n@wait 50\n! cycle\n"
                    "sequence walk new low 1s\nsequence walk add stand 50ms\n! play walk\n"
                    "@expect text servo 1 needs\n@expect text error 57:\n" + STAND)

    def test_servo_that_joins_in_a_later_step_is_checked_there(self):
        self.run_on(SWING + "sequence x new low 1s\nsequence delete x\ngroup 1\npose set one 120\ngroup 2\n"
                    "pose set two 200\ngroup 1 2 3\nsequence x new one 0.5s\nsequence x add two 50ms\n! play x\n"
                    "@expect text servo 2 needs\n@expect text in step 2\n@expect text error 57:\n")

    def test_play_without_group_after_power_off(self):
        self.run_on_each(WALKING + "@reset power\n@wait 500\nplay walk\nmotion wait\n" + STAND)

    def test_play_without_group_takes_no_servo_of_a_deleted_pose(self):
        """Servo 9 is in the list of joints, but in no stored pose."""
        self.run_on_each(WALKING + "servos forget\ngroup 9 1\npose set gone 10 20\npose delete gone\n"
                         "@reset power\n@wait 500\nplay walk\nmotion wait\ngroup\n@expect text group 1 2 3\n" + STAND)

    def test_play_after_a_power_failure_behind_the_list_of_joints(self):
        """The list is stored before the pose."""
        self.run_on_each(WALKING + "servos forget\ngroup 9 1\n@reset power write 24 50\npose set gone 10 20\n"
                         "@wait 500\npose list\nplay walk\nmotion wait\ngroup\n@expect text group 1 2 3\n" + STAND)

    def test_refused_move_leaves_the_move_under_way(self):
        self.run_on(SWING + "pose low in 1s\n@wait 200\n! pose stand in 1ms\n@expect text error 57:\n"
                    "motion\n@expect text motion: a move\nmotion wait\n" + LOW, MOVING[0])

    def test_long_line_beside_a_cycle_is_read_whole(self):
        """At the rate of the host link, 115200 bit/s: 18 angles of 6 characters."""
        ids = [str(n) for n in range(1, 19)]
        heard = self.typed("echo off\n" + "".join(f"write {n} RETURN_DELAY 10\n" for n in ids)
                           + f"group {' '.join(ids)}\ntorque 254 on\ncycle every 4ms\n",
                           [(f"text pose {' '.join(['512raw'] * 18)} in 2s", 500_000)], MOVING[0], "1-18")
        self.assertEqual(heard, "ok\r\n")

    def test_play_in_a_running_cycle_leaves_it_running(self):
        self.run_on(WALKING + "cycle every 4ms\nplay walk\nmotion wait\n" + STAND + "cycle\ncycle off\n")

    def test_stop_ends_what_plays(self):
        self.run_on_each(WALKING + "play walk loop\n@wait 500\nstop\n@expect servo 1-3 torque off\n"
                    "motion\n@expect text motion: none\n! motion wait\n@expect text error 54:\n"
                    "! play walk\nrelease\nteach off\nplay walk\nmotion wait\n" + STAND)

    def test_torque_off_after_a_stop_lets_nothing_begin(self):
        for line in "play walk", "pose low in 1s":
            self.run_on(WALKING + f"stop\nrelease\n! {line}\n@expect text servo 1 is the cause\n"
                        "@expect text error 84:\n! cycle\ngroup 3 1 2\ntorque 1 on\n"
                        f"! {line}\n@expect text servo 2 is the cause\nteach off\n{line}\nmotion wait\n", MOVING[0])

    def test_torque_that_is_off_lets_nothing_begin(self):
        for loss in "torque 3 off\n", "@power 3 off\n@wait 2000\n@power 3 on\n@wait 2000\nrelease 3\n":
            for line in "play walk", "pose low in 1s":
                self.run_on(WALKING + loss + f"! {line}\n@expect text servo 3 is the cause\n"
                            f"@expect text error 84:\n@expect servo 1 MOVING 0\nteach off\n{line}\nmotion wait\n",
                            MOVING[0])

    def test_pose_leaves_out_a_servo_without_torque(self):
        self.run_on(WALKING + "torque 2 off\ngroup 1 3\npose set b 150 200\ngroup 1 2 3\npose b in 1s\nmotion wait\n"
                    "@expect servo 3 GOAL_POSITION 682\n", MOVING[0])

    def test_blocked_servo_ends_the_motion(self):
        self.run_on(SWEEP + "play sweep loop\n@wait 1000\n@block 2 on\n@wait 800\nmotion\n"
                    "@expect text motion: none\n! motion wait\n@expect text servo 2 is the cause\n"
                    "@expect text error 83:\n@expect servo 1 torque on\n@expect servo 1 MOVING 0\n"
                    "@block 2 off\n@wait 500\nplay sweep at 200%\nmotion wait\n")

    def test_number_of_a_step_that_is_not_there_is_named(self):
        appends = "; 'sequence NAME add' appends a step behind the last one"
        run = self.run_on(WALKING + "! sequence walk set 9 stand 1s\n! sequence walk set 0 stand 1s\n! sequence walk delete 5\n"
                          "! sequence walk set 70000 stand 1s\n! sequence walk insert 5 stand 1s\n", MOVING[0], "--echo")
        told = re.findall("error 33: .*", run.output)
        self.assertEqual(told, [f"error 33: N {n} is out of range: 1 to 4" for n in (9, 0, 5, 70000)]
                         + ["error 33: N 5 is out of range: 1 to 4" + appends])

    def test_remedy_of_a_deleted_pose_is_one_line(self):
        run = self.run_on(WALKING + "pose delete low\n! play walk\n", MOVING[0], "--echo")
        self.assertIn("error 78: a step names a deleted pose; 'sequence NAME show' numbers the steps, "
                      "'sequence NAME set N POSE TIME' mends step N", run.output[-3000:])

    def test_pose_beyond_the_angle_limits_of_a_servo_moves_nothing(self):
        for board, says in zip(TWO_BOARDS, (" in step 2, pose b: 239.883deg is out of range: 0deg to 179.765deg, "
                                            "CW_ANGLE_LIMIT to CCW_ANGLE_LIMIT of the servo", " in step 2")):
            with self.subTest(board):
                run = self.run_on(SWEEP + "write 2 CCW_ANGLE_LIMIT 613\n! play sweep\n@expect text error 11:\n"
                                  "@expect servo 1-3 GOAL_POSITION 512 within 0\n! pose 100 200 100 in 1s\n"
                                  "@expect text error 11:\n@expect servo 1-3 GOAL_POSITION 512 within 0\n"
                                  "group 2 1 3\n! motion wait\n"
                                  "write 2 CCW_ANGLE_LIMIT 1023\nplay sweep\n", board, "--echo")
                self.assertTrue(f"servo 2 is the cause{says}\n" in run.output)
                self.assertEqual(run.output.count("servo 2 is the cause: 200deg is out") == 2, board == TWO_BOARDS[0])

    def test_motion_that_fails_at_rest_names_the_step_of_the_pose(self):
        for board, pose in zip(TWO_BOARDS, (", pose a", "")):
            with self.subTest(board):
                run = self.run_on(SWEEP.replace("a 2s", "a 2s dwell 3s") + "play sweep\n@wait 3000\nmotion\n"
                                  "@expect text step 1 of 2, run 1\n@power 2 off\n! motion wait\n", board, "--echo")
                self.assertIn(f"servo 2 is the cause in step 1{pose}\n", run.output)

    def test_failed_motion_is_reported_once_in_mode_person(self):
        for mode, line, count in (("person", "@wait 2000", 1), ("person", "! motion wait", 0), ("program", "@wait 2000", 0)):
            with self.subTest(mode=mode, line=line):
                run = self.run_on(SWEEP + f"@echo on\nmode {mode}\nplay sweep loop\n@wait 500\n@block 2 on\n{line}\n"
                                  "@wait 200\nservos\n@wait 200\nmode program\n", MOVING[0])
                self.assertEqual(len(re.findall(r"motion: in step \d, pose \w+: servo 2: error 83: the servo does not follow",
                                                run.output)), count,
                                 run.output[-3000:])

    def told(self, script, board="arduino-mega"):
        """What the console says unasked while a person plays a sequence in a loop; without step and pose, which depend on
        the moment and on the board."""
        run = self.run_on(SWEEP + f"@echo on\nmode person\nplay sweep loop\n@wait 500\n{script}@wait 1500\n"
                          "mode program\n", board)
        return [re.sub(r"in step \d(, pose \w+)?: ", "", line)
                for line in re.findall(r"(?:motion: |alarm of|noise|the line|the host).*", run.output)]

    def test_end_of_a_motion_names_a_servo_that_does_not_answer(self):
        for board in MOVING:
            for script in ("@power 2 off\n", "@fault turnaround 2 800\n"):
                with self.subTest(script=script, board=board):
                    ends = [line for line in self.told(script, board) if "motion" in line]
                    self.assertEqual(ends, ["motion: servo 2: error 2: no reply by the deadline; check power, wiring, "
                                            "ID and baud rate of the servo"])

    def test_torque_off_in_a_motion_is_named_as_its_end(self):
        for board in TWO_BOARDS:
            with self.subTest(board):
                self.assertRegex(self.told("torque 2 off\n", board)[-1], "^motion: .*servo 2: error 84: torque of a servo is off")

    def test_torque_off_near_the_goal_ends_the_motion(self):
        """Also a servo that is as near to its goals as a blocked one may be, and in a pause."""
        for board in MOVING:
            for script in ("torque 2 off\n", "pause\n@wait 500\ntorque 2 off\n@wait 100\n! resume\n"):
                with self.subTest(script=script, board=board):
                    self.run_on(READY + "pose set near 150 150 150\npose set by 150 155 150\nsequence sway new near 3s\n"
                                "sequence sway add by 3s\nplay sway\n@wait 3500\n" + script
                                + "! motion wait\n@expect text servo 2 is the cause\n@expect text error 84:\n", board)

    def test_servo_at_another_rate_is_named_with_its_rate(self):
        self.run_on("scan\nteach off all\nbaud 3 57600\ngroup 1 2\n! pose 100 100 in 2s\n"
                    "@expect text servo 1 is the cause: not at the rate of the bus: 'bus 1000000bps' first\n", TWO_BOARDS[0])

    def test_end_of_a_motion_by_a_low_line_names_no_servo(self):
        for board in MOVING:
            with self.subTest(board=board):
                told = self.told("@fault stuck low 1500\n", board)
                self.assertIn("the line is held low", told[0])
                self.assertRegex(told[-1], "^motion: error 9: ")
        self.assertIn("the line is held low", self.told("@fault stuck low 1500\n")[-1])

    def test_end_of_a_motion_by_a_babbling_servo_names_the_line(self):
        for board in MOVING:
            for what in ("random", "headers", "0x55"):
                with self.subTest(board=board, what=what):
                    ends = [line for line in self.told(f"@fault babble {what}\n@wait 1500\n@fault babble off\n", board)
                            if "motion" in line]
                    self.assertEqual([line[:16] for line in ends], ["motion: error 9:"], ends)

    def test_blocked_or_silent_servo_has_its_own_error(self):
        for board in MOVING:
            with self.subTest(board=board):
                self.assertRegex(self.told("@power 3 off\n@block 2 on\n@wait 1000\n", board)[-1], "servo (3: error 2|2: error 83): ")

    def test_end_of_a_motion_without_power_names_no_servo(self):
        self.assertRegex(self.told("@power off\n")[-1], "^motion: error 2: no servo of the robot answers")

    def test_end_of_a_motion_by_a_lost_link_names_the_link(self):
        for board in MOVING:
            with self.subTest(board=board):
                self.assertIn("motion: error 65: the host link was lost; no byte for link_loss_ms: see 'status'; "
                              "'clear' when it is back", self.told("settings link_loss_ms 500\n", board))

    def test_noise_is_told_once_and_ends_a_motion_by_its_name(self):
        for rate in (2000, 20000):
            with self.subTest(rate=rate):
                told = self.told(f"@fault noise {rate}\n@wait 2500\n@fault noise 0\n")
                noise = "noise on the line, or a loose plug; check plugs, ground"
                unasked = "noise on the line, a loose plug, or a servo that sends without end; 'diagnose ID' tells which"
                self.assertEqual(told.count(unasked), 1, told)
                self.assertEqual([line[:len("motion: error 2: " + noise)] for line in told if "motion" in line],
                                 ["motion: error 2: " + noise], told)
                behind = told[told.index(unasked):]
                self.assertFalse([line for line in behind if "offline" in line or "the line is held" in line], told)

    def test_a_servo_that_babbles_is_not_told_as_noise_alone(self):
        for what in ("random", "headers", "0x55"):
            with self.subTest(what):
                run = self.run_on(f"@echo on\nmode person\n@fault babble {what}\n@wait 2000\ndiagnose 1\nmode program\n", "arduino-mega")
                said = run.output.split("> diagnose 1")
                self.assertIn("or a servo that sends without end; 'diagnose ID' tells which", said[0])
                self.assertIn("never quiet", said[-1])
                self.assertNotIn("keep off motor and mains", run.output)

    def last_end(self, script):
        """What `motion` tells of the last motion after its cause is over."""
        run = self.run_on(SWEEP + f"@echo on\nmode person\nplay sweep loop\n@wait 500\n{script}motion\nmode program\n", "arduino-mega")
        return re.findall("last motion.*", run.output)

    def test_cause_of_an_end_by_noise_outlives_the_noise(self):
        self.assertRegex(self.last_end("@fault noise 20000\n@wait 2500\n@fault noise 0\n@wait 5000\n")[0],
                         "^last motion: (in step .*: )?error 2: noise on the line, or a loose plug")

    def test_cause_of_an_end_by_a_lost_link_outlives_clear(self):
        self.assertRegex(self.last_end("settings link_loss_action 1\nsettings link_loss_ms 500\n@wait 2000\nclear\n")[0],
                         "^last motion: (in step .*: )?error 65: the host link was lost")

    def test_stop_amid_noise_names_the_noise(self):
        run = self.run_on("@echo on\nmode person\n@fault noise 20000\n@wait 500\n! stop\n@fault noise 0\n@wait 300\n"
                          "mode program\n", "arduino-mega")
        self.assertRegex(run.output, "error [23]: noise on the line")  # by what the noise has hit

    def test_late_servo_is_not_taken_for_noise(self):
        run = self.run_on("@echo on\nmode person\ncycle every 4ms\n@fault turnaround 2 800\n@wait 3000\ncycle off\n"
                          "@wait 500\nmode program\n", "arduino-mega")
        self.assertIn("alarm of servo 2: offline", run.output)
        self.assertNotIn("noise on the line", run.output)

    def test_remedy_for_a_late_servo_works(self):
        run = self.run_on("write 2 RETURN_DELAY 254\n@fault turnaround 2 300\n@wait 100\ndiagnose 2\n"
                          "! set 2 RETURN_DELAY 4us\n! write 2 RETURN_DELAY 2\nping 2\nget 2 RETURN_DELAY\n"
                          "@expect servo 2 RETURN_DELAY 2\n", "arduino-mega", "--echo")
        self.assertIn("'write ID RETURN_DELAY 2'", run.output)

    def test_cause_of_a_failed_motion_outlives_its_group(self):
        self.run_on(SWEEP + "play sweep loop\n@wait 100\ntorque 3 off\n@wait 2000\ngroup 3 2 1\n! motion wait\n"
                    "@expect text servo 3 is the cause\n@expect text error 84:\n", MOVING[0])

    def test_motion_that_ends_well_or_on_demand_is_not_reported(self):
        run = self.run_on(WALKING + "@echo on\nmode person\nplay walk\n@wait 3000\nplay walk loop\n@wait 500\nmotion off\n"
                          "@wait 500\nplay walk loop\n@wait 500\nstop\n@wait 500\nservos\nmode program\n", MOVING[0])
        self.assertIn("servo 3: online", run.output)
        self.assertNotRegex(run.output, "motion: (servo|error|in)")

    def test_servo_without_torque_ends_the_motion(self):
        self.run_on(SWEEP + "play sweep loop\n@wait 100\ntorque 3 off\n! motion wait\n"
                    "@expect text servo 3 is the cause\n@expect text error 84:\n")

    def test_servo_that_dies_ends_the_motion(self):
        self.run_on_each(WALKING + "play walk loop\n@wait 700\n@power 2 off\n! motion wait\n"
                    "@expect text servo 2 is the cause\n@expect text error\n@expect servo 1 torque on\n")

    def test_cycle_off_ends_the_motion_without_a_stop(self):
        self.run_on(SWEEP + "cycle every 4ms\nplay sweep loop\n@wait 300\ncycle off\n! motion wait\n"
                    "@expect text error 79:\nplay sweep at 200%\nmotion wait\n")

    def test_servo_that_lost_its_power_is_released_before_it_plays(self):
        self.run_on(SWEEP + "@power 2 off\n@wait 1500\n@power 2 on\n@wait 1500\n! play sweep\n"
                    "@expect text servo 2 is the cause\n@expect text error 12:\nrelease\n! play sweep\n"
                    "@expect text servo 2 is the cause\n@expect text error 84:\nteach off\nplay sweep at 200%\n"
                    "motion wait\n")

    def test_pose_with_a_servo_that_does_not_answer_names_it(self):
        run = self.run_on("@power 2 off\n@wait 2500\n! pose 100 100 100\n"
                          "@expect text error 12: servo 2: not driven, as it gives no good answer\n"
                          "group 1 3\npose 100 100\n")
        goals = [data for _, way, data in run.packets if way == "->in" and " 83 1E 04" in data]
        self.assertEqual(len(goals), 1, goals)

    def test_pose_with_a_servo_that_lost_its_power_names_it(self):
        self.run_on("@power 2 off\n@wait 2500\n@power 2 on\n@wait 1500\n! pose 100 100 100\n"
                    "@expect text error 12: servo 2: the servo may not be driven\n"
                    "release\ntorque 2 on\npose 100 100 100\n")

    def test_servo_whose_replies_are_damaged_is_not_driven(self):
        self.run_on("@fault flip out every 5 3\n@wait 4000\nservos\n@expect text servo 2: offline\n"
                    "! pose 100 100 100\n@expect text error 12: servo 1: not driven, as it gives no good answer\n")

    def test_time_of_too_many_digits_has_no_range(self):
        run = self.run_on(SWEEP + "! pose low in 99999999999s\n@expect text error 33: TIME '99999999999s': number out of range\n")
        self.assertNotIn("0 to 0", run.output)

    def test_loss_of_the_host_link_ends_the_motion(self):
        self.run_on_each(SWEEP + "settings link_loss_ms 300\nplay sweep loop\n@wait 600\n! motion wait\n"
                    "@expect text error 65:\nmotion\n@expect text motion: none\n! play sweep\n"
                    "@expect servo 1-3 torque on\nclear\nplay sweep at 200%\nsettings link_loss_ms 0\nmotion wait\n")

    def test_soft_limit_of_a_servo_lets_nothing_begin(self):
        self.run_on(SWEEP + "limits 2 90 210\n! play sweep\n@expect text servo 2 is the cause\n@expect text error 11:\n"
                    "limits 2 0 300\nplay sweep at 200%\nmotion wait\n")

    def test_refusal_names_step_pose_value_and_range(self):
        for board, says in zip(TWO_BOARDS, ["in step 2, pose far: 250.147deg is out of range: 100deg to 200deg", "in step 2"]):
            self.run_on(SWING + "pose set far 250 150 150\nsequence y new low 1s\nsequence y add far 1s\nlimits 1 100 200\n"
                        f"! play y\n@expect text servo 1 is the cause {says}\n@expect text error 11:\n", board)

    def test_pose_beyond_soft_limits_is_told_with_value_and_range(self):
        self.run_on(SWING + "limits 2 90 110\n! pose stand in 1s\n"
                    "@expect text servo 2 is the cause: 150.147deg is out of range: 90.029deg to 109.971deg\n", MOVING[0])

    def test_servo_that_is_not_in_the_group_is_named(self):
        self.run_on(SWING + "sequence y new low 1s\ngroup 1 2\n! play y\n"
                    "@expect text servo 3 is the cause in step 1, pose low\n@expect text error 81:\n"
                    "pose delete low\n! play y\n@expect text step 1 is the cause\n@expect text error 78:\n", MOVING[0])

    def test_motion_tells_how_the_last_one_failed(self):
        for board, says in zip(TWO_BOARDS, ["last motion: in step 2, pose stand: servo 1: error 57: too fast",
                                            "motion: none; 'motion wait' tells the last end"]):
            self.run_on(SWING + "sequence x new low 2s\nsequence x add stand 20ms\n! play x\n"
                        f"motion\n@expect text {says}\n", board)

    def test_speed_changes_under_way(self):
        run = self.run_on(SWEEP + "! motion at 50%\n@expect text error 79:\nplay sweep loop\n@wait 300\nmotion at 50%\n"
                          "@wait 400\nmotion\n@expect text , at 50%\nmotion at 100%\n@wait 400\nmotion\n"
                          "@expect text , at 100%\n! motion at 9\n@expect text error 82: PERCENT 9 is out of range: "
                          "10 to 200%\nmotion\n@expect text , at 100%\nmotion off\n", MOVING[0])
        self.assertIn("rules:   none broken", run.output)

    def test_speed_of_a_timed_pose_changes_under_way(self):
        self.run_on(SWING + "pose 100 100 100 in 2s\n@wait 100\nmotion at 50%\n@wait 2500\nmotion\n"
                    "@expect text motion: a move\nmotion wait\n@expect servo 1 GOAL_POSITION 341\n", MOVING[0])

    def test_silent_servo_lets_nothing_begin(self):
        self.run_on(WALKING + "".join(
            f"@power 2 off\n! {line}\n@expect text servo 2 is the cause\n@expect text error 2:\n@wait 50\n! cycle\n"
            for line in ["play walk", "pose low in 1s"]), MOVING[0])

    def test_board_without_room_for_motions_says_so(self):
        for board in set(FULL) - set(MOVING):
            self.run_on(WALKING + "".join(f"! {line}\n@expect text error 55:\n" for line in [
                "play walk", "motion", "motion wait", "motion off"]) + "! pause\n", board)


class Example(unittest.TestCase):
    def test_example_teaches_and_plays(self):
        run = controller((ROOT / "examples/console_teach.script").read_text(), MOVING[0], "1-3")
        self.assertEqual(run.status, 0, run.output[-3000:])
        self.assertIn("sequence wave add middle 0.4s pass\n", run.output)


if __name__ == "__main__":
    unittest.main()
