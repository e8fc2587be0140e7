# SPDX-License-Identifier: MIT
"""Every test/scenario/*.script: with the firmware on both boards, or on a bus of its own.

A line `# run: bus` says that it needs no firmware; `# board: ...` names the only board; `# options: ...` adds options.
"""
# needs: $(patsubst %,build/%/controller.elf,atmega128 arduino-mega arduino-uno) build/atmega128/firmware/busy.elf
import re
import subprocess
import unittest

from simulator import ROOT, SIM

BOARDS = ["atmega128", "arduino-mega"]
SCENARIOS = sorted((ROOT / "test/scenario").glob("*.script"))


def simulate(*arguments):
    done = subprocess.run([SIM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          stdin=subprocess.DEVNULL, timeout=300, text=True)
    return done.returncode, done.stdout


def firmware(board):
    return ["firmware", ROOT / f"build/{board}/controller.elf", "--board", board]


class Scenarios(unittest.TestCase):
    def passes(self, path):
        text = path.read_text()
        on_bus = re.search(r"^# run: bus$", text, re.M)
        options = re.search(r"^# options: (.*)$", text, re.M)
        board = re.search(r"^# board: (.*)$", text, re.M)
        for way in [["bus"]] if on_bus else [firmware(name) for name in ([board[1]] if board else BOARDS)]:
            status, output = simulate(*way, "--servos", "1", *(options[1].split() if options else []),
                                      "--script", path)
            self.assertEqual(status, 0, output)


for scenario in SCENARIOS:
    setattr(Scenarios, f"test_{scenario.stem}", lambda self, path=scenario: self.passes(path))


class Language(unittest.TestCase):
    """What the tests of the parts (test/sim/test_script.c) do not see: the exit status."""

    def run_text(self, text, way):
        path = ROOT / "build/scenario_under_test.script"
        path.write_text(text)
        status, output = simulate(*way, "--servos", "1", "--script", path)
        path.unlink()
        return status, output, str(path)

    def test_unmet_expectation_fails_with_its_line_and_what_was_seen(self):
        for way in [["bus"], firmware("atmega128")]:
            status, output, path = self.run_text("# one\n@expect servo 1 LED 1 within 5\n", way)
            self.assertEqual(status, 1, output)
            self.assertIn(f"expectation: {path}:2: @expect servo 1 LED 1 within 5: not met; "
                          "seen: servo 1 has 0 (0x00)\n", output)

    def test_passed_scenario_tells_its_number_of_lines(self):
        for way in [["bus"], firmware("atmega128")]:
            self.assertIn("\nscript:  2 lines done\n", self.run_text("# one\n@wait 1\n\n@expect servo 1 LED 0\n", way)[1])
            self.assertNotIn("done", self.run_text("@wait 1\n@expect servo 1 LED 1 within 5\n", way)[1])

    def test_host_stdout_shows_firmware_text_beside_the_scenario(self):
        for options, count in [([], 0), (["--host", "stdout"], 1), (["--echo"], 1), (["--echo", "--host", "stdout"], 1)]:
            status, output, _ = self.run_text("get 1 ID\n", firmware("atmega128") + options)
            self.assertEqual((status, len(re.findall("^ID = 1$", output, re.M))), (0, count), output)
        self.assertIn("a bus has no firmware", self.run_text("@wait 1\n", ["bus", "--host", "stdout"])[1])
        for other in "pty", "tcp:0", "./pc":
            self.assertIn("only --host stdout",
                          self.run_text("@wait 1\n", firmware("atmega128") + ["--host", other])[1])

    def test_a_scenario_that_does_not_reach_its_last_line_fails(self):
        for way in [["bus", "--seconds", "0.1"], firmware("atmega128") + ["--seconds", "0.1"]]:
            status, output, path = self.run_text("@wait 200\n@print done\n", way)
            self.assertEqual(status, 1, output)
            self.assertIn(f"script-unfinished: {path}:1", output)

    def test_bad_lines_are_bad_input(self):
        both = [["bus"], firmware("atmega128")]
        for text, ways, what in [
                ("\n@fly 1\n", both, "unknown @ command"),
                ("\n@supply 1 99\n", both, "volts are wanted"), ("\n@supply 1 5V\n", both, "volts are wanted, 0 to 25.5, without V"),
                ("\n@load 2 10\n", both, "there is no servo 2 at this line"),
                ("\n@fault rain\n", both, ""),
                ("\nping 1 within 99999999999\n", both[1:], "milliseconds are wanted behind within"),
                ("\nping 1\n", both[:1], "there is no console here: use @send"),
                ("\n@expect text ok\n", both[:1], "there is no firmware here that prints text"),
                ("\n@send FF\n", both[1:], "only without firmware: cds55xx-sim bus")]:
            for way in ways:
                status, output, path = self.run_text(text, way)
                self.assertEqual(status, 2, output)
                self.assertEqual(len(output.splitlines()), 1, output)
                self.assertIn(f"{path}:2: {what}", output)

    def test_bad_line_names_the_servos_and_the_right_form(self):
        for text, what in [("@power 9 off\n", "there is no servo 9 at this line; there: 1"),
                           ("@power 2nd off\n", "@power 2nd off: there are 1 servos at this line"),
                           ("@power 1 of\n", r"on or off is wanted behind power [IDS]"),
                           ("@echo 1\n", "wanted: echo on|off"),
                           ("@wait 1s\n", "milliseconds are wanted, 0 to 3600000 (an hour), without unit"),
                           ("@show 1 LED\n", "wanted: show servo IDS WHAT, as in show servo 1 PRESENT_POSITION"),
                           ("@expect servo 1 LED\n", "wanted: expect servo IDS WHAT VALUE, as in "),
                           ("@expect servo 1 GOAL_POSITION 2000\n", "a position is 0 to 1023 (300 degrees)"),
                           ("@expect servo 1 torque 5\n", "torque is on or off")]:
            status, output, path = self.run_text(text, firmware("atmega128"))
            self.assertEqual((status, output.startswith(f"{path}:1: {what}")), (2, True), output)
            self.assertNotIn("hint", output)

    def test_fault_for_an_absent_servo_is_told_without_a_hint(self):
        status, output, _ = self.run_text("@fault brownout 9 100\n", firmware("atmega128"))
        self.assertEqual((status, "no servo has that ID; a fault takes" in output, "hint" in output), (1, True, False), output)
        for text in "@fault unplug in 1 0 1,9 5\n@wait 5\n", "@fault unplug in 1 0 1,9 5\n@wait 1\nping 1\n":
            status, output, _ = self.run_text(text, firmware("atmega128"))
            self.assertIn("\nfaults:  unplug named servos that were not there: 9\n", output)

    def test_servo_without_supply_is_dead(self):
        text = ("scan\ntorque 1 on\n@supply 1 2.9\n@expect servo 1 torque off\n! ping 1\n@expect text error 2: \n@power 1 on\n! ping 1\n"
                "@supply 1 3\n@wait 100\nping 1\n")
        status, output, path = self.run_text(text, ["firmware", ROOT / "build/arduino-mega/controller.elf", "--board", "arduino-mega"])
        self.assertEqual(status, 0, output)

    def test_orders_need_no_console(self):
        text = "@servos 1-3\n@wait 5\n@power 2 off\n@expect servo 2 torque off\n@wait 30\n"
        for elf, board in [("firmware/busy.elf", "atmega128"), ("controller.elf", "arduino-uno")]:
            way = ["firmware", ROOT / f"build/{board}/{elf}", "--board", board]
            status, output, path = self.run_text(text, way)
            self.assertEqual(status, 0, output)
            self.assertIn("time:    0.036", output)
        status, output, path = self.run_text(text + "ping 1\n", way)
        self.assertEqual(status, 2, output)
        self.assertIn(f"{path}:6: there is no console here: only lines that begin with @", output)
        status, output, path = self.run_text(text + "@expect text hello\n", way)
        self.assertEqual(status, 2, output)
        self.assertIn(f"{path}:6: the board has no USART for text: board.h has no BOARD_HOST_USART", output)

    def test_a_command_that_takes_longer_names_the_limit(self):
        status, output, path = self.run_text("@power off\nscan 0-253\nping 1 within 0\n", firmware("atmega128"))
        self.assertEqual(status, 1, output)
        self.assertIn(f"{path}:3: ping 1: no reply in 0 ms, neither 'ok' nor 'error N: text'; if it takes longer, "
                      "write 'within MS' at the end of the line\n", output)

    def test_register_met_before_the_first_packet_is_a_warning(self):
        text = "@expect servo 1 torque off\n@expect servo 1 PRESENT_POSITION 512\n"
        warning = "warning: met before the firmware has sent a packet"
        for before, count in [("", 1), ("ping 1\n", 0)]:
            status, output, path = self.run_text(before + text, firmware("atmega128") + ["--servos", "1"])
            self.assertEqual(status, 0, output)
            self.assertEqual(output.count(warning), count, output)
            self.assertNotIn("speed:", output)

    def test_one_run_is_as_the_other(self):
        path = ROOT / "test/scenario/alarm_voltage.script"
        runs = {re.sub(r"speed: .*", "", simulate(*firmware("atmega128"), "--servos", "1", "--echo",
                                                  "--script", path)[1]) for _ in range(2)}
        self.assertEqual(len(runs), 1)


if __name__ == "__main__":
    unittest.main()
