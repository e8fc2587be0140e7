# SPDX-License-Identifier: MIT
"""examples/stop_report.h tells why a program has stopped: copies of examples with a mistake, or with trouble on the way."""
# needs: build/lib/libcds55xx-atmega128.a $(patsubst %,build/atmega128/examples/%.elf,keyframes timed_move two_joints)
import pathlib
import tempfile
import unittest

from simulator import ROOT, Run, call

TORQUE_OFF = "FF FF FE 04 03 18 00 E2"
TROUBLE = """        if (robot.cycle.counters.periods == 300)
            cds_servos_inhibit(&robot.servos, &robot.servos.states[1], CDS_INHIBIT_STOPPED);
        if (robot.cycle.counters.periods == 320)
            cds_servos_release_all(&robot.servos);
"""
TURN = "        if (robot.state != CDS_ROBOT_RUNNING"  # in the main loop of timed_move.c


class StopReport(unittest.TestCase):
    def reported(self, example, old, new, says, script=""):
        """Runs a copy of the example with `new` in place of `old`, in the scenario `script`, until it prints `says`. Returns the
        whole lines with it."""
        text = (ROOT / f"examples/{example}.c").read_text()
        self.assertEqual(text.count(old), 1)
        with tempfile.TemporaryDirectory() as folder:
            source, elf = (pathlib.Path(folder) / f"{example}{end}" for end in (".c", ".elf"))
            source.write_text(text.replace(old, new))
            self.assertEqual(call("avr-gcc", "-mmcu=atmega128", "-DF_CPU=16000000UL", "-std=gnu99", "-Os", "-flto",
                                  "-Wall", "-Wextra", "-Werror", "-Wl,--relax", "-Wl,--gc-sections", "-Iinclude",
                                  "-Iboards/atmega128", "-Iexamples", source, "build/lib/libcds55xx-atmega128.a", "-o",
                                  elf, cwd=ROOT), (0, ""))
            run = Run(elf, "--host", "stdout", servos="1-3", script=f"{script}@expect text {says} within 18000\n")
            self.assertEqual(run.status, 0, run.output)
            return [line for line in run.output.splitlines() if says in line]

    def check_reported(self, example, old, new, says, script=""):
        self.assertEqual(self.reported(example, old, new, says, script), [says])

    def check_scenario(self, example, lines, *options):
        """The example as it is passes the scenario."""
        run = Run(f"build/atmega128/examples/{example}.elf", *options, servos="1-3", script=lines)
        self.assertEqual(run.status, 0, run.output)
        return run

    def test_angle_of_a_key_frame_beyond_the_limits_is_named(self):
        self.check_reported("keyframes", "{80, 0, 45}", "{80, 0, 95}",
                            "step 2: servo 3 (joint 2, wrist): 95 degrees, its limits are -90 and 90")

    def test_angle_of_a_move_beyond_the_limits_is_named(self):
        self.check_reported("timed_move", "mdeg = 60000", "mdeg = 90500",
                            "motion: servo 1 (joint 0, left): 90.500 degrees, its limits are -90 and 90")

    def test_key_frame_that_is_too_fast_is_named_with_its_time(self):
        said, = self.reported("keyframes", "{{80, 0, 45}, 1000,", "{{80, 0, 45}, 100,", "step 2: servo ")
        self.assertRegex(said, r"^step 2: servo [13] \(joint [02], (base|wrist)\): too fast, it needs \d+ ms$")

    def test_key_frame_with_a_time_out_of_range_is_named(self):
        for step, old, new in [(3, "-45}, 1500,", "-45}, 0,"), (2, "{80, 0, 45}, 1000,", "{80, 0, 45}, 0,")]:
            with self.subTest(step): # the joints pass the pose of step 1
                self.check_reported("keyframes", old, new, f"step {step}: time 0 ms is out of range: 1 to 600000 ms")

    def test_joint_that_is_pushed_away_is_named(self):
        self.check_scenario("keyframes", "@wait 2400\n@load 2 1020\n@expect text step 2: servo 2 (joint 1, elbow): does "
                            "not follow its goals: blocked or pushed away within 2500\n@expect servo 1-3 torque off\n")

    def test_line_low_for_a_moment_stops_nothing(self):
        for at, ms in [(3400, 300), (3050, 240), (3300, 240), (3500, 340), (3600, 380)]:
            with self.subTest((at, ms)):
                run = self.check_scenario("keyframes", f"@wait {at}\n@fault stuck low\n@wait {ms}\n@fault stuck off\n@wait 1500\n"
                                          "@expect servo 1-3 torque on within 0\n", "--rules", "warn", "--host", "stdout")
                self.assertNotIn("step", run.output)

    def test_slow_main_loop_is_told_and_torque_off_can_be_sent(self):
        poll = "        cds_robot_poll(&robot);\n"
        for ms, says in [(15, "servo 1 (joint 0, base): feedback too old, the main loop is too slow"),
                         (100, "step 0: servo 1 (joint 0, base): its feedback is too old: no reply, or a slow main loop")]:
            with self.subTest(ms):
                self.check_reported("keyframes", poll, poll + f"        for (uint32_t us = cds_port_now_us(); cds_port_now_us() - us "
                                    f"< {ms}000ul;) {{}}\n", says)

    def test_two_servos_with_one_id_are_a_possible_cause(self):
        says = ("@expect text servo 2 (joint 1, elbow): no reply: replies damaged (noise, or two servos with this ID) "
                "within 4000\n")
        run = Run("build/atmega128/examples/keyframes.elf", "--rules", "warn", "--allow-duplicates", servos="1,2,3,2",
                  script="@load 4th 300\n" + says)
        self.assertEqual(run.status, 0, run.output)
        run = self.check_scenario("keyframes", "@power 2 off\n@expect text servo 2 (joint 1, elbow): no reply within 4000\n",
                                  "--host", "stdout")
        self.assertRegex(run.output, r"(?m)^servo 2 \(joint 1, elbow\): no reply$")

    def test_damaged_replies_of_an_offline_servo_are_counted(self):
        run = self.check_scenario("keyframes", "@wait 2000\n@fault noise 3000\n@expect text servo 2 (joint 1, elbow): offline "
                                  "within 3000\n", "--host", "stdout", "--rules", "warn", "--seed", "3")
        self.assertRegex(run.output, r"(?m)^servo 2 \(joint 1, elbow\): offline \(of its replies \d+ were missing, [1-9]\d* damaged\)$")

    def test_joint_that_stands_beyond_its_limits_is_named(self):
        row = '{0}, {1}, 31000, CDS_JOINT_CDS55XX, "left"'
        self.check_reported("timed_move", row.format(-90000, 90000), row.format(-61000, 61000),
                            "motion: servo 1 (joint 0, left): it stands beyond its limits", "@wait 1000\n@load 1 -1000\n")

    def test_row_of_the_table_out_of_range_is_named(self):
        self.check_reported("timed_move", "CDS_REVERSED, 150000,", "CDS_REVERSED, 350000,",
                            "joint 1 of the table: its ID stands twice, or a value is out of range")

    def test_id_that_stands_twice_is_named(self):
        self.check_reported("timed_move", "CDS_JOINT(2,", "CDS_JOINT(1,",
                            "joint 1 of the table: its ID stands twice, or a value is out of range")

    def test_start_with_a_period_out_of_range_is_told(self):
        self.check_reported("timed_move", "    cds_robot_start(", "    robot.period_us = 100;\n    cds_robot_start(",
                            "not started: argument out of range")

    def test_move_that_is_too_fast_is_told_with_its_time(self):
        said, = self.reported("timed_move", ".time_ms = 1500", ".time_ms = 150", "motion: servo 1 (joint 0, left): ")
        self.assertRegex(said, r"^motion: servo 1 \(joint 0, left\): too fast, it needs \d+ ms$")

    def test_move_with_a_time_out_of_range_is_told(self):
        self.check_reported("timed_move", ".time_ms = 1500", ".time_ms = 0",
                            "motion: time 0 ms is out of range: 1 to 600000 ms")

    def test_move_that_ends_early_ends_the_program(self):
        self.check_reported("timed_move", TURN, TROUBLE + TURN, "motion: servo 2 (joint 1, right): the servo may not be driven")

    def test_stop_by_the_program_is_told(self):
        self.check_reported("timed_move", TURN, "        if (robot.cycle.counters.periods == 300)\n            cds_robot_stop(&robot);\n"
                            + TURN, "stopped by the program")

    def test_error_bits_are_words(self):
        for cause, word in [("@block 2 on", "overload"), ("@supply 2 5 over 10", "input voltage")]:
            with self.subTest(cause):
                self.check_scenario("keyframes", f"@wait 2500\n{cause}\n@expect text servo 2 (joint 1, elbow): alarm: "
                                    f"{word} within 6000\n@expect servo 1-3 torque off\n")

    def test_line_held_low_is_told_while_it_is_low(self):
        self.check_scenario("keyframes", "@wait 2500\n@fault stuck low\n"
                            "@expect text line low or disturbed; torque off cannot be sent, switch the power off within 700\n"
                            "@wait 2000\n@expect servo 1-3 torque on\n@fault stuck off\n@expect servo 1-3 torque off\n",
                            "--rules", "warn")

    def test_line_low_from_the_start_is_told(self):
        self.check_scenario("keyframes", "@fault stuck low\n@expect text line low or disturbed within 2500\n",
                            "--rules", "warn")

    def test_report_does_not_delay_torque_off(self):
        run = self.check_scenario("keyframes", "@wait 2500\n@power 2 off\n@expect text servo 2 (joint 1, elbow): offline "
                                  "within 3000\n@expect servo 1-3 torque off\n")
        times = [cycle for cycle, way, packet in run.packets if packet == TORQUE_OFF]
        self.assertEqual(len(times), 3)
        self.assertLess(times[-1] - times[0], 2 * 16000)

    def test_robot_that_is_started_again_reports_again(self):
        said = self.reported("timed_move", TURN, "        if (cds_port_now_us() >> 16 == 30 || cds_port_now_us() >> 16 == 90)\n"
                             "            cds_robot_stop(&robot);\n"
                             "        if (cds_port_now_us() >> 16 == 60)\n            cds_robot_start(&robot);\n" + TURN,
                             "stopped by the program", "@expect text stopped by the program within 4000\n@wait 1000\n")
        self.assertEqual(len(said), 2)

    def test_stopped_robot_on_a_noisy_line_breaks_no_rule(self):
        for example in "keyframes", "timed_move", "two_joints":
            with self.subTest(example):
                self.check_scenario(example, "@wait 2500\n@fault noise 2000\n@expect servo 1-3 torque off within 3000\n"
                                    "@wait 2000\n", "--seed", "1")


if __name__ == "__main__":
    unittest.main()
