# SPDX-License-Identifier: MIT
"""Driving is inhibited: the firmware of every board with a console, servos on the simulated wire."""
# needs: $(CONSOLE_ELFS) build/host/test/inhibit_random
import pathlib
import re
import subprocess
import tempfile
import unittest

import boards
from simulator import LONG, ROOT, Run, controller

MHZ = 16
TORQUE_OFF, CLEAR = "FF FF FE 04 03 18 00 E2", "FF FF FE 04 03 2C 00 CE"
DRIVING = ("! torque 254 on\n! move 254 90deg\n! torque 1 on\n! write 77 GOAL_POSITION 1 1\n! action\n"
           "! reset 5\n! sync GOAL_POSITION 4 1:0,0,255,3 200:0,0,255,3\n! regwrite 1 TORQUE_ENABLE 1\n")
STILL = "@wait 400\n@expect servo {0} PRESENT_POSITION 510..514\n@expect servo {0} torque off\n"


def run_script(case, script, board="atmega128", servos="1-3", *options):
    run = controller(script, board, servos, "--echo", *options)
    case.assertEqual(run.status, 0, f"{board}: {run.output}")
    return run


def drives(text):
    """Of a packet of DRIVING: all but PING, READ, and WRITE of TORQUE_ENABLE or 0x2C to 0."""
    packet = bytes.fromhex(text)
    return packet[4] > 2 and packet[4:7] not in (b"\x03\x18\x00", b"\x03\x2C\x00")


class Inhibit(unittest.TestCase):
    def test_inhibit_of_a_registered_move_keeps_it_from_action(self):
        for board in boards.CONSOLES:
            run = run_script(
                self, "regwrite 1 TORQUE_ENABLE 1 0 2 2 32 32 0 0\n@expect servo 1 REGISTERED_INSTRUCTION 1\n"
                "stop\n@expect servo 1-3 REGISTERED_INSTRUCTION 0\n! action\n! action 1\n" + STILL.format("1-3") +
                "release\n! action 1\n@expect text error 20\n" + STILL.format("1-3"), board)
            sent = [packet for _, way, packet in run.packets if way == "->in"]
            first = sent.index(TORQUE_OFF)
            self.assertEqual(sent[first:first + 6], [TORQUE_OFF] * 3 + [CLEAR] * 3)

    def test_inhibit_without_a_scan_holds_every_servo(self):
        for board in boards.CONSOLES:
            run = run_script(self, "stop\n@expect text IDs not checked: 254\n" +
                             DRIVING + STILL.format("1-3"), board)
            self.assertEqual([p for _, way, p in run.packets if way == "->in" and drives(p)], [], board)

    def test_inhibit_stays_when_servos_are_forgotten(self):
        run_script(self, "scan\nstop\nservos forget\n" + DRIVING + STILL.format("1-3"))

    def test_inhibit_holds_servos_beyond_the_list(self):
        run_script(self, "scan\nstop\n@expect text IDs not checked: 4\n" + DRIVING +
                   "".join(f"! torque {servo} on\n! move {servo} 90deg\n" for servo in (18, 19, 22)) +
                   STILL.format("1-22") + "status\n@expect text driving: inhibited until 'release'\n"
                   "@expect text last stop: 18 of 18 servos read back as off; IDs not checked: 4\n"
                   "release\nstatus\n@expect text driving: allowed\ntorque 22 on\n@expect servo 22 torque on\n",
                   servos="1-22")

    def test_inhibit_by_a_lost_link_holds_every_servo(self):
        for action in (1, 2):
            run_script(self, f"settings link_loss_action {action}\nsettings link_loss_ms 20\n@wait 100\n" + DRIVING +
                       "status\n@expect text driving: inhibited until 'clear'\n" + STILL.format("1-3") +
                       "clear\ntorque 1 on\n@expect servo 1 torque on\n")

    def test_stop_on_a_line_held_low_begins_anew_when_it_is_free(self):
        run_script(self, "turn 1 20rpm\ntorque 1 on\n@fault stuck low 2000\n! stop\n@wait 3000\n"
                   "@expect servo 1 torque off\n")

    def test_stop_on_a_line_held_low_says_so_as_soon_at_a_slow_rate(self):
        run_script(self, "torque 1 on\nbaud 1 7843bps\n@fault stuck low 2500\n! stop\n"
                   "@expect text error 9\n")

    def test_turn_with_lost_packets_leaves_no_servo_at_an_old_speed(self):
        for packet in range(1, 9):
            run = controller("scan\ntorque 1 on\nmove 1 200 60rpm\n@wait 1500\n"
                             f"@fault lose in {packet} 3\nturn 1 -1rpm\n@wait 500\n@show servo 1 PRESENT_SPEED\n",
                             "atmega128", "1-3", "--rules", "warn")
            speed = int(re.search(r"^servo 1 PRESENT_SPEED (\d+)$", run.output, re.M).group(1))
            self.assertLess(speed & 0x3FF, 30, (packet, run.output))  # 990 is 58 rpm, 16 is 1 rpm

    def test_stop_after_a_whole_scan_names_no_strangers(self):
        run = run_script(self, "scan\nstop\nstatus\n@expect text last stop: 3 of 3 servos read back as off\n")
        self.assertNotIn("not checked", run.output)

    def test_status_keeps_the_result_of_the_last_stop(self):
        run_script(self, "scan\nstop\nrelease\nservos forget\nscan\nstatus\n@expect text last stop: none\n"
                   "stop\nstatus\n@expect text last stop: 3 of 3 servos read back as off\n")
        run_script(self, "stop\nscan\nstatus\n@expect text last stop: 0 of 0 servos read back as off\n")
        run_script(self, "scan\n@fault stuck low 2000\n! stop\nstatus\n"
                   "@expect text last stop: 0 of 3 servos read back as off\n")
        run_script(self, "scan\nstop\nrelease\n@power 3 off\n@wait 2000\nrelease 3\nservos forget 3\n@power 3 on\n@wait 500\nscan\n"
                   "status\n@expect text last stop: 2 of 2 servos read back as off\n", board="arduino-mega")


class Resets(unittest.TestCase):
    def test_inhibit_survives_every_reset_but_power_on(self):
        for board in boards.CONSOLES:
            for cause in ("watchdog", "brown-out", "external"):
                run_script(self, f"stop\n@reset {cause}\n" + DRIVING + f"@reset {cause}\n" + DRIVING +
                           "status\n@expect text driving: inhibited until 'release'\n" + STILL.format("1-3") +
                           f"release\n@reset {cause}\nstatus\n@expect text driving: allowed\n"
                           "torque 1 on\n@expect servo 1 torque on\n", board)

    def test_rate_of_the_bus_survives_every_reset_but_power_on(self):
        for board in boards.CONSOLES:
            for cause in ("watchdog", "brown-out", "external"):
                run_script(self, "write 1 CCW_ANGLE_LIMIT 0\ntorque 1 on\nwrite 1 MOVING_SPEED 100\nwrite 254 BAUD_RATE 3\n"
                           f"settings bus_baud 3\n@reset {cause}\nstop\n@expect servo 1 torque off\nping 1\n"
                           "@reset power\n! ping 1\n", board)

    def test_rate_of_a_scan_is_not_the_rate_after_a_reset(self):
        for board in boards.CONSOLES:
            run_script(self, "settings bus_baud 3\n@reset watchdog in 20\n! scan all\nbus\n@expect text bus ok at 500000bps\n"
                       "@reset power\nping 1\n", board)

    def test_power_on_starts_free_and_drives_nothing(self):
        for board in boards.CONSOLES:
            run = run_script(self, "stop\n@reset power\nstatus\n@expect text driving: allowed\n" + STILL.format("1-3") +
                             "torque 1 on\n@expect servo 1 torque on\n", board)
            sent = [packet for _, way, packet in run.packets if way == "->in"]
            self.assertEqual(sent[6:], ["FF FF 01 04 02 06 1C D6", "FF FF 01 04 03 18 01 DE"], run.transcript)  # behind the stop's


class HostBytes(unittest.TestCase):
    """A program of the PC's, in simulated time; the wire is the judge."""

    def wire(self, program, board="atmega128", options=()):
        """What the controller sent as (cycle, packet), and the last cycle of each thing the PC said."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "pc")
            file.write_text(program)
            run = Run(f"build/{board}/controller.elf", "--host", file, *options, board=board, servos="1-3")
        self.assertEqual(run.status, 0, run.output)
        self.last = run
        said = [int(last) for last in re.findall(r"^said \d+ (\d+)", run.output, re.M)]
        return [(cycle, packet) for cycle, way, packet in run.packets if way == "->in"], said

    def test_stop_in_a_cut_packet_is_sent_within_20_ms(self):
        for board in boards.CONSOLES:
            for cut in ("FF FF 01 FE 03", "FF FF 01 FE 03 " + "11 " * 200, "FF FF FE 20 83 1E 04 01"):
                sent, said = self.wire(f"wait 20000\nsay {cut} 18\nwait 60000\n", board)
                self.assertEqual([packet for _, packet in sent[:3]], [TORQUE_OFF] * 3, (board, cut))
                # a packet is in the transcript when it is whole: 80 us behind its first bit
                self.assertLess((sent[0][0] - said[0]) / MHZ, 20000 + 80)

    def test_stop_pressed_60_times_in_a_cut_packet_is_sent(self):
        sent, _ = self.wire("wait 20000\nsay FF FF 01 FE 03\n" + "say 18\nwait 33000\n" * 60)
        stops = [packet for _, packet in sent].count(TORQUE_OFF)
        self.assertEqual(stops, 60 * 3)  # each press is a stop

    def test_stop_is_not_undone_by_a_release_said_before_it(self):
        read, release = "FF FF 4D 04 02 24 02 86 ", "FF FF FD 04 03 17 00 E4 "
        for said in (f"say {2 * read}{release}18\n",
                     f"text group 1 2 9 10 11\nhear 4 within 3000\nwait 100000\nsay 18\nwait 3000\nsay {release}\n"
                     "wait 1000\nsay 18\n"):
            sent, _ = self.wire(f"wait 50000\n{said}wait 1000000\ntext torque 1 on\nwait 100000\n")
            self.assertIn(TORQUE_OFF, [packet for _, packet in sent])
            self.assertNotIn("FF FF 01 04 03 18 01 DE", [packet for _, packet in sent])

    def test_stop_amid_a_change_of_rate_reaches_the_servo_there(self):
        for after_us in range(2000, 40000, 3000):
            program = ("wait 20000\ntext group 1\nwait 100000\ntext torque 1 on\nwait 100000\n"
                       f"text baud 1 57600bps\nwait {after_us}\nsay 18\nwait 900000\nsay FF FF 01 04 02 18 01 DF\n"
                       "wait 100000\n")
            sent, _ = self.wire(program)
            run = self.last
            self.assertEqual(run.packets[-1][2], "FF FF 01 03 00 00 FB", (after_us, run.transcript))  # torque is 0

    def test_stop_that_a_reset_interrupts_is_finished(self):
        sent, _ = self.wire("wait 20000\ntext torque 1 on\nwait 100000\nsay 18\nwait 200\nreset watchdog in 0\n"
                            "wait 300000\n")
        self.assertIn(TORQUE_OFF, [packet for _, packet in sent])

    def test_packet_that_waits_when_a_scan_begins_is_not_sent_late(self):
        sent, _ = self.wire("text settings bus_baud 103\nhear 4\nwait 972000\nsay FF FF 01 05 03 1E 00 01 D7\n"
                            "text scan\nhear 8 within 2000\nwait 900000\n",
                            options=("--fault", "baud 1 103", "--fault", "stuck low 1000", "--rules", "warn"))
        self.assertNotIn("FF FF 01 05 03 1E 00 01 D7", [packet for _, packet in sent])

    def test_stop_in_a_good_packet_is_none(self):
        sent, _ = self.wire("wait 20000\nsay FF FF 02 04 02 18 01 DE\nhear 7\nwait 30000\n")
        self.assertEqual([packet for _, packet in sent], ["FF FF 02 04 02 18 01 DE"])


class Random(unittest.TestCase):
    def test_inhibit_of_random_input_lets_nothing_drive(self):
        for seed in ("1", "2", "3"):
            done = subprocess.run([ROOT / "build/host/test/inhibit_random", "100000" if LONG else "20000", seed],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            self.assertEqual(done.returncode, 0, done.stdout.decode(errors="replace")[-3000:])


if __name__ == "__main__":
    unittest.main()
