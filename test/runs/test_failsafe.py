# SPDX-License-Identifier: MIT
"""Settings when the power fails, loss of the host link, resets and alarms, in whole runs."""
# needs: $(CONSOLE_ELFS)
import pathlib
import random
import re
import tempfile
import unittest

import boards
from simulator import LONG, Run, controller

PERCENTS = (5, 47, 70, 95, 100) if LONG else (5, 95, 100)  # of a write, when the power goes
TORQUE_OFF = "FF FF FE 04 03 18 00 E2"
CLOCK_KHZ = 16000

# Two values for each setting that differ in every byte; the host's rate is the same for both (16 is
# 117647 bit/s, which is what 115200 becomes at 16 MHz). echo is 0 in all: a scenario sends `mode program`
# after each reset.
NAMES = ["device_id", "host_baud", "bus_baud", "return_delay", "repeats", "echo", "link_loss_ms",
         "link_loss_action", "alarm_report", "cycle_us"]
DEFAULTS = [253, 255, 1, 254, 0, 0, 0, 1, 0, 4000]
FIRST = [17, 16, 3, 100, 1, 0, 0xFFFF, 0, 1, 0x1234]
SECOND = [200, 255, 1, 7, 2, 0, 0xEEEE, 2, 0, 0x2345]


def change(values):
    return "".join(f"settings {name} {value}\n" for name, value in zip(NAMES, values))


def at_57600(values):
    """The same with the host rate of the CM-510."""
    return [34 if value == 16 else value for value in values]


def crc(data):
    """CRC-16/MCRF4XX, low byte first."""
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0x8408 if value & 1 else 0)
    return value.to_bytes(2, "little")


def listed(text):
    """Values of the last list of settings in it, and where they came from."""
    values = [int(re.findall(rf"^{name} = (\d+)", text, re.M)[-1]) for name in NAMES]
    return values, re.findall(r"^(?:settings at start|saved settings): (.*)$", text, re.M)[-1]


class Settings(unittest.TestCase):
    def run_script(self, script, board="atmega128", *options):
        run = controller(script, board, "1", "--echo", *options)
        self.assertEqual(run.status, 0, run.output)
        return run.output

    def cut(self, before, write, percent, board="atmega128"):
        """(was it cut?, settings, origin) after a save of SECOND over `before` saves of FIRST and so on,
        cut within that write to the EEPROM. Power-on ends the rate of the bus that a reset keeps."""
        script = "".join(change(values) + "save\n" for values in before)
        script += change(SECOND) + f"@reset brown-out write {write} {percent}\nsave\n@wait 300\n@reset power\nsettings\n"
        output = self.run_script(script, board)
        values, origin = listed(output)
        return output.count(" reset\n") == 2, values, origin

    def cut_everywhere(self, before, allowed, board="atmega128", percents=PERCENTS):
        """All writes of the save; returns how many there are and which settings were found."""
        write, found = 0, []
        while write < 100:
            write += 1
            outcomes = [self.cut(before, write, percent, board) for percent in percents]
            for was_cut, values, origin in outcomes:
                self.assertIn((values, origin), allowed if was_cut else [(SECOND, origin)], write)
                found.append((values, origin))
            if not outcomes[0][0]:
                return write - 1, found
        self.fail("it is cut for ever")

    def test_power_lost_in_any_write_of_the_first_save(self):
        saved = (SECOND, "as saved")
        nothing = [(DEFAULTS, "defaults: nothing saved"),
                   (DEFAULTS, "defaults: saved ones damaged")]
        writes, found = self.cut_everywhere([], [saved, *nothing])
        self.assertGreaterEqual(writes, 15) # all but those that are FF
        for outcome in [saved, *nothing]:
            self.assertIn(outcome, found)

    def test_power_lost_in_any_write_of_a_later_save(self):
        old, new = (FIRST, "as saved"), (SECOND, "as saved")
        writes, found = self.cut_everywhere([SECOND, FIRST], [old, new])
        self.assertGreaterEqual(writes, 5)
        self.assertIn(old, found)
        writes, found = self.cut_everywhere([FIRST], [old, new])
        self.assertGreaterEqual(writes, 15)
        self.assertIn(old, found)
        self.assertIn(new, found)

    def test_power_lost_on_the_other_boards(self):
        for board in boards.CONSOLES[1:]:
            first = at_57600(FIRST) if boards.BOARDS[board].host_bps == 57600 else FIRST
            old, new = (first, "as saved"), (SECOND, "as saved")
            writes, found = self.cut_everywhere([first], [old, new], board, (60,))
            self.assertGreaterEqual(writes, 15)
            self.assertIn(old, found)

    def test_save_uses_both_places_in_turn_and_the_file_keeps_them(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "eeprom")
            records = []
            for values in [FIRST, SECOND, FIRST]:
                self.run_script(change(values) + "save\n", "atmega128", "--eeprom", file)
                records.append((file.read_bytes()[16:80], file.read_bytes()[80:144]))
                found = listed(self.run_script("settings\n", "atmega128", "--eeprom", file))
                self.assertEqual(found, (values, "as saved"))
            empty = b"\xFF" * 64
            self.assertEqual(records[0][1], empty)
            self.assertEqual(records[1][0], records[0][0])
            self.assertEqual(records[2][1], records[1][1])
            self.assertNotEqual(records[2][0], records[1][0])
            bad = bytearray(file.read_bytes())
            bad[16 + 5] ^= 1 # the newer one
            file.write_bytes(bad)
            found = listed(self.run_script("settings\n", "atmega128", "--eeprom", file))
            self.assertEqual(found, (SECOND, "as saved"))
            bad[80 + 5] ^= 1
            file.write_bytes(bad)
            found = listed(self.run_script("settings\n", "atmega128", "--eeprom", file))
            self.assertEqual(found, (DEFAULTS, "defaults: saved ones damaged"))

    def start_with(self, record, script):
        """The output of a run that finds these bytes in the first place for a record."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "eeprom")
            file.write_bytes((b"\xFF" * 16 + record).ljust(4096, b"\xFF"))
            return self.run_script(script, "atmega128", "--eeprom", file)

    def test_record_of_another_firmware_is_read_and_told(self):
        ten = "11 10 03 64 01 01 FF FF 00 01 34 12"  # FIRST, and a byte or a word for each setting
        for record, values, origin in [
                (f"01 0C 01 {ten}", FIRST, "as saved"),
                (f"01 0A 01 {ten[:-6]}", FIRST[:9] + DEFAULTS[9:],
                 "older firmware; new ones: defaults"),
                (f"01 0E 01 {ten} 55 AA", FIRST, "saved by a newer firmware"),
                (f"02 0C 01 {ten}", DEFAULTS,
                 "defaults: of another version")]:
            data = bytes.fromhex(record)
            output = self.start_with(data + crc(data), "settings\nsave\n@reset power\nsettings\n")
            first, again = output.split(" reset\n")
            self.assertEqual(listed(first), (values, origin))
            saved = "saved by a newer firmware" if "newer" in origin else "as saved"
            self.assertEqual(listed(again), (values, saved))

    def test_a_save_does_not_block_the_bus(self):
        # The host waits for its ok, which is silence: torque goes off while bytes are being written,
        # and the servo, at its factory return delay, is read without a loss.
        for board in boards.CONSOLES:
            first = at_57600(FIRST) if boards.BOARDS[board].host_bps == 57600 else FIRST
            output = self.run_script(change(first) + "settings bus_baud 1\nping 1\n"
                                     "settings link_loss_action 2\nsettings link_loss_ms 20\nsave\n"
                                     "@wait 200\nstatus\n@expect text last stop: 1 of 1 servos read back as off\n", board)
            save = output.index("> save")
            bus = [m.start() for m in re.finditer(f"{TORQUE_OFF}|FF FF 01 04 02 18 01 DF", output)]
            self.assertEqual(len(bus), 4, f"{board}: {output}")
            self.assertTrue(all(save < at < output.index("\nok", save) for at in bus), output)

    def test_settings_act_at_once_and_only_saved_ones_outlive_power(self):
        output = self.run_script("settings bus_baud 3\n! ping 1\nwrite 254 BAUD_RATE 3\n@reset power\n"
                                 "settings\n", "atmega128")
        self.assertEqual(listed(output), (DEFAULTS, "defaults: nothing saved"))
        output = self.run_script("write 254 BAUD_RATE 3\nsettings bus_baud 3\nping 1\nsave\n"
                                 "@reset power\nping 1\n@reset external\ndefaults\n! ping 1\n")
        self.assertEqual(output.count("<-out: FF FF 01 02 00 FC"), 2)

    def test_errors(self):
        output = self.run_script("! settings nothing 1\n! settings repeats 3\n! settings repeats x\n"
                                 "! settings repeats 1 1\nsettings repeats 2\nsettings repeats\n")
        for error in [60, 33, 32, 31]:
            self.assertIn(f"error {error}: ", output)
        self.assertIn("repeats = 2\n", output)


class HostLink(unittest.TestCase):
    START = ("settings link_loss_ms 100\nwrite 1 TORQUE_ENABLE 1\nwrite 2 TORQUE_ENABLE 1\nwrite 1 GOAL_POSITION 300\n")

    def run_script(self, script, board):
        run = controller(script, board, "1,2", "--echo")
        self.assertEqual(run.status, 0, f"{board}: {run.output}")
        return run

    def test_lost_link_is_the_reason_in_lists_and_in_servos(self):
        self.run_script(
            self.START + "@wait 300\n! torque 1-2 on\n@expect text servo 1: the host link was lost\n"
            "@expect text error 87:\nservos\n@expect text servo 2: online, torque on, inhibited: host link lost\n"
            "clear\ntorque 1-2 on\nstop\n! torque 1-2 on\n@expect text servo 1: stopped: driving is inhibited\n"
            "servos\n@expect text servo 2: online, torque off, inhibited: stopped\n", "atmega128")

    def test_hold_sends_nothing_and_refuses_goals_until_cleared(self):
        for board in boards.CONSOLES:
            run = self.run_script(
                self.START + "settings link_loss_action 1\n@wait 90\nwrite 1 GOAL_POSITION 301\n"
                "@wait 300\n@expect silence 50\n@expect servo 1-2 torque on\nstatus\n"
                "@expect text host link: lost\n@expect text driving: inhibited until 'clear'\n"
                "! write 1 GOAL_POSITION 400\n! sync GOAL_POSITION 2 2:0,2\nread 1 ID\nclear\n"
                "write 1 GOAL_POSITION 401\nsync GOAL_POSITION 2 2:0,2\n@expect servo 2 GOAL_POSITION 512\n"
                "status\n@expect text host link: watched\n@expect text driving: allowed\n", board)
            sent = [packet for _, way, packet in run.packets if way == "->in"]
            self.assertFalse([p for p in sent if p.startswith("FF FF 01 05 03 1E 90 01")])
            self.assertEqual(len(sent), 7)

    def test_watch_begins_with_the_line_that_sets_it_and_with_clear(self):
        for ms in (0, 1, 33, 100):
            self.run_script(f"scan\n@wait {ms}\nsettings link_loss_ms 50\n@wait 200\nstatus\n"
                            "@expect text host link: lost\n! release\n"
                            "@expect text error 65: the host link was lost\n! release 1\n"
                            "! write 1 GOAL_POSITION 400\nclear\n@wait 200\nstatus\n"
                            "@expect text host link: lost\n", "atmega128")

    def test_torque_off_goes_out_three_times_and_is_verified(self):
        for board in boards.CONSOLES:
            run = self.run_script(
                self.START + "settings link_loss_action 2\n@wait 1\n" +
                f"@expect packet in {TORQUE_OFF}\n" * 3 +
                "@expect servo 1-2 torque off\n@wait 20\nstatus\n@expect text host link: lost\n"
                "@expect text last stop: 2 of 2 servos read back as off\n! write 1 TORQUE_ENABLE 1\n! write 2 GOAL_POSITION 1\n"
                "@expect servo 1-2 torque off\nclear\nwrite 1 TORQUE_ENABLE 1\n"
                "@expect servo 1 torque on\n", board)
            self.assertEqual(run.output.count("02 18 01 "), 2) # a READ of each
            # 100 ms after the last byte of the host, as exactly as the main loop is woken
            off = next(cycle for cycle, _, packet in run.packets if packet == TORQUE_OFF)
            last = [cycle for cycle, _, _ in run.packets if cycle < off][-1]
            self.assertGreater((off - last) / CLOCK_KHZ, 100)
            self.assertLess((off - last) / CLOCK_KHZ, 100 + 33 + 20)

    def test_a_dead_servo_is_not_said_to_be_off(self):
        run = self.run_script(self.START + "settings link_loss_action 2\n@power 2 off\n@wait 200\nstatus\n"
                              "@expect text last stop: 1 of 2 servos read back as off\n", "atmega128")
        self.assertEqual(run.output.count(TORQUE_OFF), 3)

    def test_a_loss_that_is_only_shown(self):
        run = self.run_script(self.START + "settings link_loss_action 0\n@wait 200\n@expect silence 50\nstatus\n"
                              "@expect text host link: lost\nwrite 1 GOAL_POSITION 400\n", "atmega128")
        self.assertIn("host link: lost", run.output)

    def test_an_action_chosen_after_a_loss_is_taken_at_the_next(self):
        self.run_script("scan\nsettings link_loss_action 0\nsettings link_loss_ms 100\n@wait 200\n"
                        "settings link_loss_action 2\ntorque 1 on\n@wait 300\n@expect servo 1 torque off\n",
                        "atmega128")

    def test_command_that_a_lost_link_ends_names_the_link(self):
        self.run_script("scan\ngroup 1\ntorque 1 on\nsettings link_loss_action 2\nsettings link_loss_ms 100\n"
                        "pose 100 in 3s\n! motion wait\n@expect text error 65\n", "arduino-mega")


class Resets(unittest.TestCase):
    MOMENTS = 60
    MOVE = "sync GOAL_POSITION 4 1:{0} 2:{0} 3:{0}\n"

    def one(self, board, moment_ms, rng):
        """A reset by the watchdog `moment_ms` after a command is begun that sets three servos in
        motion: in its text, on the wire, in a reply, or behind it. What is left of its text may end up in
        the line that follows: hence the nonsense."""
        command = rng.choice(["write 1 GOAL_POSITION 800 1023\n", "read 2 0 50\n", "ping 3\n",
                              "regwrite 2 GOAL_POSITION 800 1023\n", self.MOVE.format("255,3,255,3")])
        script = ("write 1 RETURN_DELAY 254\n" if rng.random() < 0.5 else "") + \
            "write 2 TORQUE_ENABLE 1\nregwrite 3 GOAL_POSITION 100\n" \
            "settings link_loss_ms 60\nsettings link_loss_action 2\n" + self.MOVE.format("50,0,255,0") + \
            f"@reset watchdog in {moment_ms:.3f}\n{command}@wait 400\n! nonsense\nstatus\n@wait 40\n"
        run = controller(script, board, "1-3", "--echo", "--seed", str(rng.randrange(1 << 16)))
        told = f"{board}, {command.strip()}, {moment_ms} ms: {run.output}"
        self.assertEqual(run.status, 0, told)
        before, after = run.output.split(" reset\n")
        self.assertIn("reset by watchdog\n", after, told)
        reset = int(before.rsplit("\n", 1)[-1])
        # nothing is sent any more, not even a torque off
        self.assertFalse([p for p in run.packets if p[1] == "->in" and p[0] >= reset], told)
        return reset, run

    def test_a_watchdog_reset_at_random_moments_with_the_bus_running(self):
        rng = random.Random(6)
        talking = 0
        for number in range(self.MOMENTS):
            board = boards.CONSOLES[number % len(boards.CONSOLES)]
            at, run = self.one(board, round(rng.uniform(0, 5), 3), rng)
            # how often a transaction was under way
            sent = [cycle for cycle, way, _ in run.packets if way == "->in" and cycle < at]
            talking += at - sent[-1] < 3 * CLOCK_KHZ
        self.assertGreater(talking, 10)

    def test_a_main_program_that_hangs_is_ended_by_the_watchdog(self):
        for board in boards.CONSOLES:
            run = controller("write 1 GOAL_POSITION 900 100\n@hang\nping 1\n@wait 100\nstatus\n"
                             "@expect text reset by watchdog\n@wait 500\nstatus\n", board, "1", "--echo")
            self.assertEqual(run.status, 0, f"{board}: {run.output}")
            self.assertEqual(run.output.count(" reset\n"), 1) # and then it is fed again
            hang = run.packets[-1][0]
            reset = int(re.search(r"(\d+) reset\n", run.output)[1])
            self.assertTrue(80 < (reset - hang) / CLOCK_KHZ < 160, (reset - hang) / CLOCK_KHZ)

    def test_every_cause_is_told_and_only_the_latest(self):
        for board in boards.CONSOLES:
            script = "".join(f"@reset {cause}\nstatus\n@expect text reset by {cause}\n"
                             for cause in ["external", "brown-out", "watchdog", "power", "watchdog"])
            run = controller("status\n@expect text reset by power\n" + script, board, "1", "--echo")
            self.assertEqual(run.status, 0, f"{board}: {run.output}")
            self.assertEqual(re.findall(r"^reset by(.*)$", run.output, re.M),
                             [" power", " external", " brown-out", " watchdog", " power", " watchdog"])

    def test_banner_tells_the_cause_of_an_unwanted_reset(self):
        for board in boards.CONSOLES:
            script = "@wait 100\n" + "".join(f"@reset {cause}\n@wait 100\n"
                                             for cause in ["watchdog", "external", "brown-out", "power"])
            with tempfile.TemporaryDirectory() as folder: # an EEPROM of a new controller: mode person
                run = controller(script, board, "1", "--host", "stdout", "--eeprom", pathlib.Path(folder, "eeprom"))
            self.assertEqual(run.status, 0, f"{board}: {run.output}")
            self.assertEqual(re.findall(r"cds55xx [0-9.]+ [a-z0-9-]+([^\r\n]*)\r?\n(?:servos may be [^\r\n]*\r?\n)?help lists .*Ctrl-X stops all servos\r?\n", run.output),
                             ["", "; reset by watchdog", "", "; reset by brown-out", ""], run.output)

    def test_limit_of_turning_servo_is_refused_after_a_reset(self):
        run = controller("scan\ntorque 1 on\nturn 1 20rpm\n@reset watchdog\n@wait 100\n! set 1 CCW_ANGLE_LIMIT 300\n"
                         "@expect text error 47\n@expect servo 1 CCW_ANGLE_LIMIT 0 within 0\ntorque 1 off\n"
                         "set 1 CCW_ANGLE_LIMIT 300\n@expect servo 1 CCW_ANGLE_LIMIT 1023\n", "arduino-mega", "1", "--echo")
        self.assertEqual(run.status, 0, run.output)

    def test_an_idle_controller_is_not_bitten(self):
        for board in boards.CONSOLES:
            run = controller("@wait 3000\nstatus\n@expect text reset by power\n", board, "1", "--echo")
            self.assertEqual(run.status, 0, run.output)
            self.assertNotIn(" reset\n", run.output)


# What brings each bit about, and its name.
ALARMS = [
    ("input voltage", "@supply 1 5.0\n@wait 20\nping 1\n", "@supply 1 12\n@wait 20\n"),
    ("angle limit", "write 1 CCW_ANGLE_LIMIT 511\n! write 1 GOAL_POSITION 900\n", ""),
    ("overheating", "@ambient 1 120\n@expect servo 1 error 0x04 within 60000\nping 1\n",
     "@ambient 1 20\n@expect servo 1 error 0x00 within 60000\n"),
    ("range", "! write 1 PRESENT_POSITION 1\n", ""),
    ("checksum", "@fault flip in 1 5 3\n! write 1 LED 1\n", ""),
    ("overload", "write 1 TORQUE_ENABLE 1\n@block 1 on\nwrite 1 GOAL_POSITION 1023\n"
                 "@expect servo 1 error 0x20 within 2000\nping 1\n",
     "@block 1 off\n@expect servo 1 error 0x00 within 5000\n"),
    ("instruction", "! action 1\n", ""),
]


class Alarms(unittest.TestCase):
    def test_an_alarm_of_every_kind_is_latched_shown_and_cleared(self):
        for name, cause, end in ALARMS:
            script = cause + end + ("ping 1\nalarms\n"
                                    f"@expect text alarm of servo 1: {name}\nclear\nalarms\nping 2\n")
            run = controller(script, "atmega128", "1,2", "--echo")
            self.assertEqual(run.status, 0, f"{name}: {run.output}")
            listed_ = re.findall(r"> alarms\n((?:alarm .*\n)*)ok", run.output)
            self.assertEqual(listed_, [f"alarm of servo 1: {name}\n", ""], run.output)

    def test_an_alarm_of_every_kind_is_told_at_once_if_asked(self):
        for name, cause, end in ALARMS:
            run = controller("settings alarm_report 1\n" + cause + f"@expect text alarm of servo 1: {name}\n@wait 50\n",
                             "atmega128", "1,2", "--echo")
            self.assertEqual(run.status, 0, f"{name}: {run.output}")
            self.assertEqual(run.output.count("alarm of servo 1: "), 1, run.output)

    def test_unplugged_servo_is_told_to_a_person_within_a_period(self):
        for board in boards.CONSOLES:
            run = controller("scan\nmode person\n@wait 1500\n@power 2 off\n@wait 1100\nservos\n@power 2 on\n@wait 500\n"
                             "servos\n", board, "1-3", "--echo")
            self.assertEqual(run.status, 0, run.output)
            remedy = "; check power, wiring, ID and baud rate of the servo" if boards.BOARDS[board].profile == "full" else ""
            self.assertEqual(re.findall("alarm .*", run.output), ["alarm of servo 2: offline" + remedy], run.output)
            self.assertEqual(re.findall("^servo 2: (.*),", run.output, re.M), ["offline", "online"], run.output)

    def test_torque_that_goes_off_by_itself_is_told_once_to_a_person(self):
        told = "torque went off by itself"
        for board in boards.CONSOLES:
            for mode in ("mode person", "settings alarm_report 1"):
                run = controller(f"scan\ntorque 1 on\ntorque 2 on\ntorque 3 on\n{mode}\n@wait 1500\n@power 2 on\n@wait 2500\n"
                                 "@power 3 off\n@wait 2500\n@power 3 on\n@wait 4000\nalarms\nclear\n@wait 2500\nservos\n"
                                 "stop\nrelease\n@wait 2500\n", board, "1-3", "--echo")
                self.assertEqual(run.status, 0, run.output)
                remedy = "; 'servos' tells why: mend power, load, plug or heat, then 'release'"
                lines = [f"alarm of servo 2: {told}", "alarm of servo 3: offline", f"alarm of servo 3: {told}"]
                listed = [lines[0], lines[2]]
                remedies = [remedy, remedy]
                if boards.BOARDS[board].mcu == "atmega128" and mode == "mode person": # once for all servos
                    remedies = ["; torque stays off: 'servos' tells why; mend power, load, plug or heat, 'release', then "
                                "'teach off ID' holds it where it is", ""]
                if boards.BOARDS[board].mcu in boards.LARGE: # it names the cause
                    remedies = [f"; without an alarm, so it lost its power or was reset: check its plug and supply, then "
                                f"'release {servo}'; 'teach off {servo}' holds it where it is" for servo in (2, 3)]
                if boards.BOARDS[board].profile == "full":
                    lines = [lines[0] + remedies[0], lines[1] + "; check power, wiring, ID and baud rate of the servo",
                             lines[2] + remedies[1]]
                if boards.BOARDS[board].mcu in boards.LARGE and mode == "mode person": # one line tells return and loss
                    lines.pop()
                    listed.append("alarm of servo 3: offline (over)")
                    self.assertIn("> servo 3 answers again, torque off; it lost its state: 'release 3'", run.output)
                self.assertEqual(re.findall("alarm of servo .*", run.output),
                                 lines + listed, run.output)

    def test_max_torque_0_is_told_by_set_and_diagnose(self):
        told = "MAX_TORQUE acts from the servo's next power-up on: switch its power off and on\n"
        run = controller("scan\nset all MAX_TORQUE 0\nset 1 PUNCH 40\n@power 2 off\n@wait 100\n@power 2 on\n@wait 1500\n"
                         "diagnose 2\n@expect text finding 19: MAX_TORQUE is 0\n", "arduino-mega", "1,2", "--echo")
        self.assertEqual(run.status, 0, run.output)
        self.assertEqual(run.output.count(f"servo 2: written\n{told}ok\n"), 1, run.output)
        self.assertEqual(run.output.count(told), 1, run.output)

    def test_servo_that_shuts_down_is_told_with_its_alarm(self):
        for cause, name in [("@ambient 1 120\n@wait 60000\n", "overheating"),
                            ("@supply 1 5.0\n@wait 2500\n", "input voltage")]:
            run = controller(f"scan\nset 1 ALARM_SHUTDOWN 5\ntorque 1 on\nmode person\n@wait 1500\n{cause}", "atmega128", "1", "--echo")
            self.assertEqual(re.findall("alarm of servo 1: (.*?);", run.output), [name, "torque went off by itself"], run.output)

    def test_held_line_and_lost_link_are_told_once_to_a_person(self):
        for mode, told in (("person", 1), ("program", 0)):
            run = controller(f"scan\nmode {mode}\n@fault stuck low 1500\n@wait 1000\n! monitor 1 2\n@wait 1500\nservos\n"
                             "settings link_loss_action 2\nsettings link_loss_ms 500\n@wait 1500\nservos\n",
                             "atmega128", "1,2", "--echo")
            self.assertEqual(run.output.count("> the line is held low; look for a short circuit")
                             + run.output.count("\nthe line is held low; look for a short circuit"), told, run.output)
            self.assertEqual(run.output.count("the host link was lost; no byte for link_loss_ms"), told, run.output)
            self.assertIn("inhibited: host link lost", run.output)

    def test_way_out_of_a_lost_link_works_for_a_person(self):
        way = "to work by hand: 'settings link_loss_ms 0', 'clear'"
        for board in ("atmega128", "arduino-mega"):
            run = controller("mode person\nscan\nsettings link_loss_ms 500\n@wait 1000\nstop\n@wait 1000\n! release\n"
                             "settings link_loss_ms 0\nclear\n@wait 1000\nrelease\ntorque 1 on\nmove 1 100\n"
                             "@expect servo 1 torque on\n", board, "1", "--echo")
            self.assertEqual(run.status, 0, run.output)
            self.assertIn("if you type nothing for 500ms, driving is inhibited; 'settings link_loss_ms 0' ends that\nok\n", run.output)
            self.assertIn("robot stopped: torque off, driving inhibited until 'clear'\nok\n", run.output)
            self.assertRegex(run.output, f"error 65: the host link was lost; .*; {way}")

    def test_release_works_on_a_lost_link_that_inhibits_nothing(self):
        run = controller("mode person\nscan\nsettings link_loss_action 0\nsettings link_loss_ms 500\n@wait 1000\nrelease\nrelease 1\n",
                         "arduino-mega", "1", "--echo")
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("link_loss_ms: driving goes on, as link_loss_action is 0", run.output)

    def test_status_counts_no_servo_at_another_rate_as_stopped(self):
        """It has not heard the stop, and its torque is on."""
        run = controller("scan\nteach off all\nbaud 3 57600bps\n! stop\n@wait 3000\nstatus\nmode person\nrelease\n", "arduino-mega", "1-3",
                         "--echo")
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("last stop: 1 of 3 servos read back as off", run.output)
        self.assertIn("servos that have not confirmed 'stop': 2, the first: 1; see 'servos'\nok\n", run.output)

    def test_stop_that_no_servo_could_hear_is_confirmed_later(self):
        """Torque was off before, so the state check finds no reason to send the stop again."""
        run = controller("scan\ntorque all off\nbus 500000\n! stop\nbus 1000000\n@wait 2000\nstatus\n", "arduino-mega", "1-3", "--echo")
        self.assertEqual(run.status, 0, run.output)
        self.assertIn("last stop: 3 of 3 servos read back as off", run.output)

    def test_status_names_the_fault_of_the_bus(self):
        for board in boards.CONSOLES:
            run = controller("scan\nstatus\n@expect text bus ok at 1000000bps\n@fault stuck low 500\n@wait 100\nstatus\n"
                             "@expect text bus held low at 1000000bps\n", board, "1", "--echo")
            self.assertEqual(run.status, 0, run.output)

    def test_line_that_is_low_again_is_told_again_after_a_command(self):
        low = "@fault stuck low 200\n@wait 400\n"
        run = controller("scan\nmode person\n" + 3 * low + "servos\n" + low + "servos\n", "atmega128", "1", "--echo")
        self.assertEqual(run.output.count("the line is held low; look for a short circuit"), 2, run.output)

    def test_torque_and_rate_that_are_not_known_are_not_told(self):
        run = controller("scan\ntorque 1 on\nwrite 1 STATUS_RETURN_LEVEL 0\n@power 1 off\n@wait 300\n@power 1 on\n"
                         "@wait 3000\nservos\n@expect text servo 1: online, torque unknown\n"
                         "baud 2 57600\n! ping 3\n@expect text servo 3: not at the rate of the bus: 'bus 1000000bps' first\n"
                         "! stop\n@expect text servo 3: not at the rate of the bus: 'bus 1000000bps' first\n",
                         "atmega128", "1-3", "--echo")
        self.assertEqual(run.status, 0, run.output)

    def test_alarm_is_told_of_a_servo_in_place_of_a_forgotten_one(self):
        run = controller("settings alarm_report 1\n! write 1 PRESENT_POSITION 1\n@expect text alarm of servo 1: range\n"
                         "servos forget\n! write 2 PRESENT_POSITION 1\n@expect text alarm of servo 2: range\n",
                         "atmega128", "1,2", "--echo")
        self.assertEqual(run.status, 0, run.output)

    def test_alarms_of_several_servos_each_with_its_id(self):
        for board in boards.CONSOLES:
            run = controller("! write 2 PRESENT_POSITION 1\n! action 1\n! write 1 PRESENT_POSITION 1\nalarms\n",
                             board, "1,2", "--echo")
            self.assertIn("> alarms\nalarm of servo 2: range\nalarm of servo 1: range\nalarm of servo 1: instruction\nok", run.output)


class Memory(unittest.TestCase):
    def test_the_deepest_stack_leaves_a_margin_on_every_board(self):
        for board in boards.CONSOLES:
            goals = " ".join(f"{n}:{n},2" for n in range(1, 19))
            # a return delay that bears the handlers of the host link beside the bus
            run = controller(f"write 254 RETURN_DELAY 10\nsettings link_loss_ms 50\nsettings link_loss_action 2\nread 1 0 50\n"
                             f"sync GOAL_POSITION 2 {goals}\nsave\n@wait 200\nclear\nhelp\nalarms\n"
                             "! action 1\n! reset 2\n@wait 50\nstatus\n", board, "1-18", "--echo")
            self.assertEqual(run.status, 0, run.output)
            spare, room = map(int, re.search(r"^stack: (\d+) of (\d+) bytes unused$", run.output,
                                             re.M).groups())
            self.assertGreater(room, spare)
            self.assertGreater(room - spare, 40)
            self.assertGreater(spare, 400, board)

    def test_status_counts_the_stack_when_asked(self):
        """The figure is as deep right behind a command as it is 20 s later."""
        goals = " ".join(f"{n}:{n},2" for n in range(1, 19))
        for board in boards.CONSOLES:
            run = controller(f"status\nsync GOAL_POSITION 2 {goals}\nread 1 0 50\nstatus\n"
                             "@wait 20000\nstatus\n", board, "1-18", "--echo")
            before, behind, later = map(int, re.findall(r"^stack: (\d+) of", run.output, re.M))
            self.assertEqual(behind, later, board)
            self.assertLess(behind, before, board)


if __name__ == "__main__":
    unittest.main()
