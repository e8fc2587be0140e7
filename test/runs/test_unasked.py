# SPDX-License-Identifier: MIT
"""What the console tells a person without a command, in whole runs: faults that are over, alarms during `monitor` and above a
line that is half typed, and remedies that are not repeated."""
# needs: $(CONSOLE_ELFS)
import pathlib
import re
import tempfile
import unittest

from simulator import Run, controller


def found_with_torque(case, pattern, script, board="arduino-mega"):
    """What a person is told while three servos have torque."""
    run = controller(f"scan\ntorque all on\nmode person\n@wait 1500\n{script}", board, "1-3", "--echo")
    case.assertEqual(run.status, 0, run.output)
    return re.findall(pattern, run.output)


class Recovery(unittest.TestCase):
    """A fault that is over is told once to a person, with what to do next."""
    def told(self, script, board="arduino-mega"):
        return found_with_torque(self, "servo . answers again.*|bus ok again.*|stop: .*", script, board)

    def test_plug_that_is_back_tells_what_to_do(self):
        self.assertEqual(self.told("@power 2 off\n@wait 2000\n@power 2 on\n@wait 5000\nrelease 2\nteach off 2\n@wait 2000\n"),
                         ["servo 2 answers again, torque off; it lost its state: 'release 2', then 'teach off 2' holds it "
                          "where it is, 'torque 2 on' moves it to its goal"])

    def test_plug_that_is_back_without_lost_state_may_be_driven(self):
        self.assertEqual(self.told("@fault baud 2 34\n@wait 2500\n@fault baud 2 1\n@wait 3000\n"),
                         ["servo 2 answers again, torque on; it may be driven"])

    def test_plug_that_is_back_while_inhibited_names_release(self):
        self.assertEqual(self.told("stop\n@power 2 off\n@wait 2000\n@power 2 on\n@wait 3000\n"),
                         ["servo 2 answers again, torque off; driving is inhibited until 'release'"])

    def test_loose_plug_is_not_told_as_back(self):
        self.assertEqual(self.told("@power 2 off\n@wait 2000\n" + 4 * "@power 2 on\n@wait 500\n@power 2 off\n@wait 1500\n"), [])

    def test_free_line_is_told_once(self):
        self.assertEqual(self.told("@fault stuck low 1500\n@wait 6000\n"), ["bus ok again; 'servos' shows their state"])
        self.assertEqual(self.told("stop\n@fault noise 20000\n@wait 1500\n@fault noise 0\n@wait 6000\n"),
                         ["bus ok again; driving is inhibited until 'release'"])

    def test_noise_is_not_told_as_a_line_that_is_held_low(self):
        for board in ("atmega128", "arduino-mega"):
            for fault, count in (("noise 5000", 0), ("stuck low", 1)):
                told = found_with_torque(self, "the line is held low", f"@fault {fault}\n@wait 15000\nmode program\n", board)
                self.assertEqual(len(told), count, (board, fault))

    def test_line_that_is_low_again_soon_is_not_told_as_free(self):
        self.assertEqual(self.told(4 * "@fault stuck low 500\n@wait 1500\n"), [])

    def test_stop_that_succeeds_late_is_told(self):
        self.assertEqual(self.told("@fault stuck low 3000\n@wait 200\n! stop\n@wait 5000\nrelease\n@wait 2000\n")[0],
                         "stop: torque read back as off at all servos; driving is inhibited until 'release'")

    def test_stop_that_no_servo_could_hear_is_sent_again(self):
        """Torque was off before, so the state check finds no reason to send it."""
        late = "stop: torque read back as off at all servos; driving is inhibited until 'release'"
        self.assertEqual(self.told("torque all off\nbus 500000\n! stop\nbus 1000000\n@wait 3000\n"),
                         [late + "; other IDs are not checked"])
        self.assertEqual(self.told("torque all off\n@fault noise 20000\n! stop\n@fault noise 0\n@wait 3000\n")[0], late)

    def test_stop_that_succeeds_at_once_is_not_told_twice(self):
        self.assertNotIn("stop: torque read back", "".join(self.told("@power 2 off\n! stop\n@power 2 on\nstop\n@wait 2000\n")))

    def test_program_is_told_nothing(self):
        self.assertEqual(self.told("mode program\n@power 2 off\n@wait 2000\n@power 2 on\n@fault stuck low 1500\n@wait 6000\n"), [])


class AlarmOver(unittest.TestCase):
    """The end of an alarm is told to a person, with what remains to be done; `servos` tells which alarms last."""
    def run_on(self, script):
        return found_with_torque(self, "alarm of [^;\n]*|servo . answers again.*|servo .: .* over.*|servo 2: online.*",
                                 script + "mode program\n")

    def test_supply_that_is_back_is_told_and_told_again(self):
        self.assertEqual(self.run_on(2 * "@supply 2 5.5\n@wait 2500\nservos\n@supply 2 12\n@wait 4000\n" + "servos\n"),
                         2 * ["alarm of servo 2: input voltage",
                              "servo 2: online, torque on, latched alarms: input voltage (now)",
                              "servo 2: input voltage is over, torque on; 'clear' acknowledges it"]
                         + ["servo 2: online, torque on, latched alarms: input voltage (over)"])

    def test_heat_that_is_over_names_release_and_torque(self):
        told = self.run_on("@ambient 2 90\n@wait 40000\nservos\n@ambient 2 20\n@wait 60000\n")
        self.assertIn("servo 2: online, torque off, inhibited: lost its state ('release 2'), latched alarms: overheating (now)", told)
        self.assertEqual(told[-1], "servo 2: overheating is over, torque off; 'release 2', then 'teach off 2' holds it where it "
                                   "is, 'torque 2 on' moves it to its goal")

    def test_alarm_that_is_cleared_has_no_end(self):
        told = self.run_on("@supply 2 5.5\n@wait 2500\n@supply 2 12\n@wait 200\nclear\n@wait 4000\nservos\n")
        self.assertEqual(told, ["alarm of servo 2: input voltage", "servo 2: online, torque on"])

    def test_alarm_that_lasts_is_told_once(self):
        self.assertEqual(self.run_on("@supply 2 5.5\n@wait 9000\n"), ["alarm of servo 2: input voltage"])

    def test_alarm_of_a_servo_that_is_away_is_not_over(self):
        told = self.run_on("@supply 2 5.5\n@wait 2500\n@power 2 off\n@wait 6000\nservos\n")
        self.assertEqual(told, ["alarm of servo 2: input voltage", "alarm of servo 2: offline"])


class Remedy(unittest.TestCase):
    """What an alarm tells to do works as typed."""
    def test_remedy_of_heat_is_complete(self):
        for board in ("arduino-mega", "atmega128"):
            run = controller("mode person\nscan\ntorque all on\n@ambient 2 90\n@wait 40000\ntorque 2 off\n@ambient 2 20\n@wait 60000\nclear\n"
                             "release 2\nteach off 2\n@expect servo 2 torque on\n", board, "1-3", "--echo")
            self.assertEqual(run.status, 0, run.output)
            self.assertRegex(run.output, "alarm of servo 2: overheating; 'torque (ID|2) off', unload it; when cool, 'clear', 'release (ID|2)'")

    def test_alarm_of_heat_tells_where_torque_moves_it(self):
        told = found_with_torque(self, "overheating; .*", "@ambient 2 90\n@wait 40000\nmode program\n")
        self.assertEqual(told, ["overheating; 'torque 2 off', unload it; when cool, 'clear', 'release 2'; then 'torque 2 on' moves it to its "
                                "old goal, 'teach off 2' keeps it where it is"])

    def test_endless_turn_after_power_loss_names_turn(self):
        told = found_with_torque(self, "servo 2 answers again.*", "turn 2 20rpm\n@wait 1000\n@power 2 off\n@wait 4000\n@power 2 on\n"
                                 "@wait 4000\nrelease 2\ntorque 2 on\nturn 2 20rpm\n@expect servo 2 torque on\n")
        self.assertEqual(told, ["servo 2 answers again, torque off; it lost its state: 'release 2'; it was in endless turn: 'torque 2 on', "
                                "with speed 0, then 'turn 2 SPEED'"])

    def test_alarms_lists_what_was_told_and_is_over(self):
        told = found_with_torque(self, "alarm of .*", "@power 2 off\n@wait 4000\n@power 2 on\n@wait 4000\nalarms\nrelease 2\nclear\nalarms\n")
        self.assertEqual(told[1:], ["alarm of servo 2: torque went off by itself", "alarm of servo 2: offline (over)"])

    def test_alarms_lists_lost_torque_as_released(self):
        told = found_with_torque(self, "alarm of .*", "@power 2 off\n@wait 200\n@power 2 on\n@wait 4000\nrelease 2\nalarms\n")
        self.assertEqual(told[1:], ["alarm of servo 2: torque went off by itself (released)"])

    def test_alarm_of_a_servo_that_left_does_not_pass_to_another(self):
        run = controller("mode person\ngroup 1 2\npose set up 90 90\nsequence wave new up 500ms\n@power 1,2 off\n@wait 3000\n"
                         "servos forget\n! play wave\n@wait 3000\nscan\nalarms\n", "arduino-mega", "1-3", "--echo")
        self.assertEqual(run.status, 0, run.output)
        self.assertEqual(re.findall("alarm of .*", run.output)[2:], ["alarm of servo 1: offline"])

    def test_alarm_knows_a_turn_that_a_program_has_begun(self):
        told = found_with_torque(self, "torque went off by itself.*", "mode program\nturn 2 20rpm\n@wait 300\n@power 2 off\n@wait 100\n"
                                 "@power 2 on\nmode person\n@wait 4000\nmode program\n")
        self.assertEqual(told, ["torque went off by itself; without an alarm, so it lost its power or was reset: check its plug and "
                                "supply, then 'release 2'"])

    def test_alarms_says_what_noise_has_kept_back(self):
        told = found_with_torque(self, "alarm of .*", "@fault noise 2000\n@wait 20000\n@fault noise 0\n@wait 6000\nalarms\n")
        self.assertTrue(told)
        for line in told:
            self.assertRegex(line, r"alarm of servo .: (checksum|instruction) \(while the line was disturbed\)")

    def test_status_on_a_noisy_line_is_not_ok(self):
        told = found_with_torque(self, "bus busy.*|bus ok.*|servos: .*", "@fault noise 300\n@wait 3000\nstatus\n")
        self.assertEqual(told, ["bus busy: noise or others, at 1000000bps", "servos: 3, offline 0, as last known"])

    def test_status_counts_servos_at_another_rate(self):
        told = found_with_torque(self, "servos: .*", "baud 2 57600bps\nstatus\n")
        self.assertEqual(told, ["servos: 3, offline 0, at another rate 2: state unknown"])

    def test_scan_after_a_reset_tells_torque(self):
        told = found_with_torque(self, "servos that joined.*", "@reset external\n@wait 500\nmode person\nscan\nscan\n")
        self.assertEqual(told, ["servos that joined with torque on: 3, for example servo 3; it may be moving: "
                                "'stop' switches torque off"])

    def test_refusal_by_an_alarm_prints_its_remedy_once(self):
        told = found_with_torque(self, "warning: .*|error 85.*", "@ambient 2 90\n@wait 40000\n! torque 2 on\n")
        self.assertEqual(told, ["warning: overheating", "error 85: servo 2: the servo reports an alarm; 'torque 2 off', unload it; when cool, "
                                "'clear', 'release 2'"])

    def test_alarm_of_voltage_names_diagnose(self):
        told = found_with_torque(self, "input voltage; .*|finding.*|ID 2 at.*",
                                 "@supply 2 5.5\n@wait 2500\ndiagnose 2\nmode program\n")
        self.assertEqual(told, ["input voltage; too low or too high: 'diagnose 2' tells which, and the volts; mend supply or limits, "
                                "then 'clear'", "finding 14: the servo's supply is below MIN_VOLTAGE; charge the battery; check cables "
                                "and plugs under load", "ID 2 at 1000000bps, supply 5500 mV"])


class LostPower(unittest.TestCase):
    """A servo whose torque went off by itself: the alarm tells what is known of the cause."""
    def lost(self, script):
        return found_with_torque(self, "torque went off by itself.*", script + "mode program\n")

    def test_short_loss_of_power_is_named(self):
        self.assertEqual(self.lost("@power 2 off\n@wait 200\n@power 2 on\n@wait 4000\n"),
                         ["torque went off by itself; without an alarm, so it lost its power or was reset: check its plug and "
                          "supply, then 'release 2'; 'teach off 2' holds it where it is"])

    def test_shutdown_by_heat_is_not_taken_for_lost_power(self):
        self.assertRegex(self.lost("@ambient 2 90\n@wait 40000\n")[0], "^torque went off by itself; 'servos' tells why")


class SharedId(unittest.TestCase):
    """A servo that goes offline with damaged replies may share its ID."""
    def test_offline_servo_with_damaged_replies_may_share_its_id(self):
        run = controller("mode person\nscan\n@power 3 off\n@wait 2500\nservos forget 3\nid 2 3\ntorque 3 on\n@power 3 on\n"
                         "@wait 6000\nmode program\n", "arduino-mega", "1-3", "--echo", "--rules", "warn")
        self.assertEqual(re.findall("alarm of servo 3: offline; (.*)", run.output),
                         ["check power, wiring, ID and baud rate of the servo",
                          "check power, wiring; replies came damaged: a loose plug, two servos may have its ID, or it has another "
                          "rate: 'diagnose 3'"])

    def test_damaged_replies_of_several_servos_are_not_a_shared_id(self):
        told = found_with_torque(self, "answers again.*", "@fault lose out every 2\n@wait 15000\n@fault clear\n@wait 8000\nmode program\n")
        self.assertEqual(told, 3 * ["answers again, torque on; it may be driven"])

    def test_slow_servo_names_diagnose(self):
        told = found_with_torque(self, "offline; .*", "@fault turnaround 2 700\n@wait 9000\nmode program\n")
        self.assertEqual(told, ["offline; check power, wiring; most of its replies came late: 'diagnose 2'"])

    def test_slow_servo_that_recovered_is_not_slow_without_power(self):
        told = found_with_torque(self, "offline; .*", "@fault turnaround 2 900\n@wait 9000\n@fault turnaround 2 0\n@wait 5000\nclear\n"
                                 "@power 2 off\n@wait 5000\nmode program\n")
        self.assertEqual(told, ["offline; check power, wiring; most of its replies came late: 'diagnose 2'",
                                "offline; check power, wiring, ID and baud rate of the servo"])

    def test_servo_that_shares_its_id_is_not_told_as_well(self):
        """After a stop both answer alike."""
        run = controller("mode person\nscan\ntorque all on\n@power 3 off\n@wait 2500\nservos forget 3\nid 2 3\ntorque 3 on\n@power 3 on\n"
                         "@wait 6000\nstop\n@wait 6000\nmode program\n", "arduino-mega", "1-3", "--echo", "--rules", "warn")
        self.assertEqual(re.findall("servo 3 answers again.*", run.output),
                         ["servo 3 answers again, torque off; two servos may have its ID: 'diagnose 3'"])

    def test_noise_is_not_taken_for_a_shared_id(self):
        for board in ("arduino-mega", "atmega128"):
            told = found_with_torque(self, ".*two servos.*", "@fault noise 5000\n" + 40 * "@wait 500\nservos\n" + "mode program\n", board)
            self.assertEqual(told, [], board)


class Noise(unittest.TestCase):
    """What is said while a person has been told of noise, and not yet that the bus is ok again."""
    def said(self, pattern, flips, script, seed=1):
        run = controller(f"mode person\nscan\ntorque all on\n@wait 1500\n@fault noise {flips}\n{script}@fault noise 0\n@wait 8000\nmode program\n",
                         "arduino-mega", "1-3", "--echo", "--seed", str(seed), "--rules", "warn")
        return re.findall(pattern, run.output)

    def test_stop_in_noise_names_no_level(self):
        """Lost replies make the state check take a servo for one of status return level 0."""
        stops = 8 * "@wait 3300\nstop\n@wait 1000\nclear\n"
        for seed in (2, 3):
            said = self.said("answers no READ|STATUS_RETURN_LEVEL|noise on the line, or|robot stopped", 3000, stops, seed)
            self.assertGreater(len(said), 7)
            self.assertNotIn("answers no READ", said)
            self.assertNotIn("STATUS_RETURN_LEVEL", said)

    def test_status_is_as_told_unasked(self):
        for flips in (200, 3000):
            said = self.said("bus ok at|bus busy|noise on the line, a|bus ok again|as last known", flips, "@wait 4000\n" + 6 * "@wait 1700\nstatus\n")
            self.assertEqual(said, ["noise on the line, a"] + 6 * ["bus busy", "as last known"] + ["bus ok again"], flips)


class Clear(unittest.TestCase):
    """`clear` tells a person that it has ended an inhibit."""
    def test_clear_after_stop_tells_that_driving_is_allowed(self):
        told = found_with_torque(self, "driving is allowed again.*", "clear\nstop\nclear\n@wait 500\n@power 2 off\n@wait 2000\nclear\nmode program\n")
        self.assertEqual(told, ["driving is allowed again"])


class Advised(unittest.TestCase):
    """Alarms on a board without RAM for what was told: what damaged bytes mean, and no remedy twice in a row."""
    def told(self, script, board="atmega128"):
        return found_with_torque(self, "alarm of .*|error 2.: .*|.*of the list here.*|no servo examined.*|asked .*, silent.*", script, board)

    def test_alarms_in_noise_name_damaged_bytes(self):
        told = self.told("@fault noise 3000\n@wait 9000\nmode program\n")
        checksums = [line for line in told if ": checksum" in line]
        self.assertRegex(checksums[0], "checksum; bytes on the line may be damaged, by noise or a loose plug: 'diagnose .'$")
        self.assertEqual([line for line in told if "send it again" in line], [])

    def test_torque_that_is_lost_with_the_supply_has_one_remedy(self):
        told = self.told("@power off\n@wait 300\n@power on\n@wait 5000\nmode program\n")
        told = [line for line in told if "torque went off by itself" in line]
        self.assertEqual((len(told), "".join(told).count("; torque stays off: 'servos' tells why")), (3, 1), told)

    def test_alarm_does_not_repeat_the_error_before_it(self):
        self.assertEqual(len(self.told("! write 1 PRESENT_POSITION 1\n@wait 1000\nmode program\n")), 1)

    def test_bus_counts_a_servo_found_at_another_rate_once(self):
        for board in ("atmega128", "arduino-mega"):
            told = self.told("@fault baud 2 34\nscan all\nbus 57143\nmode program\n", board)
            self.assertEqual(told, ["the bus changed to this rate, 'save' keeps it over power-off; servos of the list here: 1; at the old rate: 2, until "
                                    "'bus 1000000bps'; one that moves goes on, and 'stop' does not reach it"])

    def test_diagnose_without_power_tells_what_it_sent(self):
        for board in ("atmega128", "arduino-mega"):
            told = self.told("@power off\n@wait 3000\ndiagnose\nmode program\n", board)
            self.assertRegex(told[-1], "^no servo examined; packets sent: [1-9]")


class Repeated(unittest.TestCase):
    """A remedy that was printed just before is not printed again."""
    def run_on(self, script):
        run = controller(f"scan\nmode person\n{script}", "arduino-mega", "1-3", "--echo")
        self.assertEqual(run.status, 0, run.output)
        return run.output

    def test_alarm_behind_its_error_is_short(self):
        output = self.run_on("! write 1 PRESENT_POSITION 1\n@wait 200\n")
        self.assertIn("error 21: servo 1: range error; a value or address", output)
        self.assertIn("alarm of servo 1: range\n", output)

    def test_alarm_of_several_servos_tells_the_remedy_once(self):
        output = self.run_on("@supply 5.5\n@wait 2000\n")
        self.assertEqual(output.count(": input voltage"), 3, output)
        self.assertEqual(output.count("mend supply or limits"), 1, output)

    def test_warning_of_a_list_tells_the_remedy_once_a_command(self):
        output = self.run_on("@supply 5.5\n@wait 2000\n" + 2 * "get 1-3 LED\n")
        self.assertEqual(re.findall("warning: servo (.): input voltage(;?)", output),
                         2 * [("1", ";"), ("2", ""), ("3", "")], output)


class Monitor(unittest.TestCase):
    """Alarms reach a person during `monitor` and above a line that is half typed."""
    def heard(self, program, *faults):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "pc")
            file.write_text(program)
            run = Run("build/arduino-mega/controller.elf", "--host", file, "--eeprom", pathlib.Path(folder, "eeprom"), *faults, board="arduino-mega", servos="1-3")
        self.assertEqual(run.status, 0, run.output)
        return [bytes.fromhex("".join(line.split()[4:])).decode("latin-1")
                for line in run.output.splitlines() if line.startswith("heard")]

    START = "wait 100000\nrest\ntext group 1 2\nwait 500000\nrest\n"
    UNPLUG = ("--fault", "unplug in 8 1 2 5000")
    ALARM = "alarm of servo 2: offline; check power, wiring, ID and baud rate of the servo\r\n"

    def test_alarm_stands_above_the_table_of_monitor(self):
        ticks = "text monitor 1 2 every 5s\nwait 7000000\nrest\n"
        told = self.heard(self.START + ticks, *self.UNPLUG)[2]
        row = "servo 1: 150.147deg 0rpm 0% 12V 32C\x1b[K\r\n"
        self.assertIn(f"\x1b[2A\x1b[J\r{self.ALARM}{row}servo 2: absent\x1b[K\r\n", told)
        self.assertNotIn(f"{self.ALARM}\x1b", told)

    def test_alarm_does_not_break_the_lines_of_a_plot(self):
        told = self.heard(self.START + "text monitor 1 2 as plot\nwait 4000000\nrest\n", *self.UNPLUG)[2]
        self.assertIn("2:absent", told)
        self.assertNotIn("alarm", told)

    def test_half_typed_line_comes_again_below_an_alarm(self):
        typed = "say 6D 6F 76 65 20 31 20 39 1B 5B 44 1B 5B 44\nwait 4000000\nrest\nsay 20 1B 5B 43 0D\nwait 500000\nrest\n"
        heard = self.heard(self.START + typed, *self.UNPLUG)
        self.assertEqual(heard[2], f"move 1 9\b\b\r\x1b[K\r{self.ALARM}\r> move 1 9\b\b")
        self.assertIn("ok\r\n", heard[3])


if __name__ == "__main__":
    unittest.main()
