# SPDX-License-Identifier: MIT
"""A diagnosis on the simulated wire, of each cause that can be injected, and of buses that are well."""
# needs: $(patsubst %,build/%/firmware/diagnose.elf,atmega128 adapter-echo arbotix)
import re
import unittest

from simulator import LONG, ROOT, Run

HEADER = (ROOT / "include/cds55xx/diagnose.h").read_text().replace("\\\n", " ")
FINDINGS = {int(m[2]): m[1] for m in re.finditer(r"X\(CDS_FINDING_(\w+), (\d+),", HEADER)}
WRITES = re.compile(r"FF FF [0-9A-F]{2} [0-9A-F]{2} (?!01|02)")
NOBODY = 255


class Diagnose(unittest.TestCase):
    def runs(self, script, servos="1", *faults, options=(), board="atmega128", baud=1,
             status=0):
        """What each `d` of the script said, as {name: number}; at the end the bus is as it was."""
        options = [*options, *(word for fault in faults for word in ("--fault", fault))]
        name = board.rsplit("/", 1)[-1]
        run = Run(f"build/{name}/firmware/diagnose.elf", "--echo", *options, board=board,
                  servos=servos, script=script)
        self.assertEqual(run.status, status, run.output)
        self.assertNotIn("faults:  acted 0 times", run.output)
        found = [{name: int(number) for name, number in re.findall(r"^(\w+) (\d+)$", part, re.M)}
                 for part in re.split(r"^> d .*$", run.output, flags=re.M)[1:]]
        self.assertEqual(len(found), len(re.findall("^d", script, re.M)))
        for one in found:
            self.assertEqual((one["result"], one["baud"], one["repeats"]), (0, baud, 1))
            self.assertLessEqual(one["transactions"], 300)
            self.assertLess(one["us"], 400000 if baud == 1 else 700000)
        sent = [packet for _, way, packet in run.packets if way == "->in"]
        if not faults and not re.search("^[wf]", script, re.M):
            self.assertEqual([packet for packet in sent if WRITES.match(packet)], [])
        self.found = found
        return [FINDINGS[one["finding"]] for one in found]

    # ---- all is well ----

    def test_one_servo(self):
        self.assertEqual(self.runs("d 1\nd 254\n"), ["OK"] * 2)
        self.assertEqual([one["found_id"] for one in self.found], [1, 1])
        self.assertLess(self.found[0]["us"], 100000)
        self.assertLessEqual(self.found[0]["transactions"], 20)

    def test_18_servos_after_feedback_at_return_delays_1_and_254(self):
        prepare = "".join(f"w {id} 5 254\n" for id in range(2, 19, 2))
        script = prepare + "".join(f"f {id} 5\nd {id}\n" for id in (1, 2, 10, 17, 18))
        self.assertEqual(self.runs(script, "1-18"), ["OK"] * 5)

    def test_reply_to_an_abandoned_request_is_no_finding(self):
        script = "w 1 5 254\nr 2\n" + "f 1 1\nd 2\n" * 5
        self.assertEqual(self.runs(script, "1,2"), ["OK"] * 5)
        self.assertEqual(self.found[0]["return_delay_us"], 2)

    def test_a_few_damaged_replies_in_a_thousand_are_no_finding(self):
        # 14 wrong bits a second: about 0.2 % of transactions of 0.15 ms
        script = "f 1 20\nd 1\n" * 20
        self.assertEqual(self.runs(script, "1-18", "noise 14", options=["--seed", "5"]), ["OK"] * 20)
        self.assertGreater(max(one["unasked"] for one in self.found), 0)

    def test_one_damaged_or_lost_reply_of_any_sort_is_no_finding(self):
        for packet in (1, 3, 5, 9, 11, 16):
            for fault in (f"flip out {packet} 3 4", f"lose out {packet} 0", f"flip in {packet} 4 2"):
                self.assertEqual(self.runs("d 1\n", "1", fault), ["OK"], fault)

    def test_damaged_length_that_makes_a_servo_deaf_is_no_finding(self):
        for packet in (1, 4, 8, 12):
            for servos in ("1", "1,2"):
                # a second LENGTH bit: the servo waits for 64 bytes more, ten PINGs
                found = self.runs("d 1\n", servos, f"flip in {packet} 3 7")
                self.assertEqual(found, ["OK"], (packet, servos))

    def test_wirings_that_hear_themselves(self):
        for board in ("test/boards/adapter-echo", "arbotix"):
            self.assertEqual(self.runs("d 1\nd 2\n", "1", board=board), ["OK", "OTHER_ID"])

    # ---- nobody, or not there ----

    def test_silence(self):
        self.assertEqual(self.runs("d 1\nd 254\n", "none"), ["SILENCE"] * 2)
        self.assertEqual(self.runs("d 1\n", "1", "stuck high"), ["SILENCE"])
        self.assertLess(self.found[0]["us"], 300000)
        self.assertEqual(self.runs("d 1\n", "1", "stuck high", board="arbotix"), ["SILENCE"])

    def test_another_rate_each_of_the_listed_ones(self):
        for own in (1, 7, 103) if LONG else (1,):
            for baud in {1, 3, 7, 16, 34, 103} - {own}:
                found = self.runs(f"b {own}\nd 1\nd 254\nd 9\n", "1", f"baud 1 {baud}", baud=own)
                self.assertEqual(found, ["OTHER_RATE"] * 3, (own, baud))
                self.assertEqual([(one["found_id"], one["found_baud"]) for one in self.found],
                                 [(1, baud)] * 3)

    def test_another_rate_while_others_are_at_this_one(self):
        self.assertEqual(self.runs("d 1\n", "1,2", "baud 1 34"), ["OTHER_RATE"])
        self.assertEqual((self.found[0]["found_id"], self.found[0]["found_baud"]), (1, 34))

    def test_another_id(self):
        for other in (0, 8, 253):
            self.assertEqual(self.runs("d 7\n", str(other)), ["OTHER_ID"])
            self.assertEqual(self.found[0]["found_id"], other)

    def test_another_id_among_several_that_answer_at_once(self):
        self.assertEqual(self.runs("d 7\n", "100-110", options=["--rules", "warn"]), ["OTHER_ID"])
        self.assertEqual(self.found[0]["found_id"], 100)

    def test_anybody_of_several(self):
        self.assertEqual(self.runs("d 254\n", "3-20", options=["--rules", "warn"]), ["OK"])
        self.assertEqual(self.found[0]["found_id"], 3)

    def test_anybody_of_two_that_answer_one_after_the_other(self):
        self.assertEqual(self.runs("w 2 5 254\nd 254\n", "1,2"), ["OK"])
        self.assertEqual(self.found[0]["extra"], 0)

    def test_anybody_whose_first_answers_have_a_made_up_id(self):
        self.assertEqual(self.runs("d 254\n", "5", *(f"id out {n} 77" for n in (1, 2, 3))), ["OK"])
        self.assertEqual(self.found[0]["found_id"], 5)

    # ---- the line ----

    def test_line_low(self):
        for board in ("atmega128", "arbotix"):
            self.assertEqual(self.runs("d 1\n@fault stuck off\nd 1\n", "1", "stuck low", board=board),
                             ["LINE_LOW", "OK"])

    def test_babble(self):
        for what in ("headers", "random", "0x00", "0x01", "0x55"):
            self.assertEqual(self.runs("d 1\n@fault babble off\nd 1\n", "1", f"babble {what}"),
                             ["BABBLE", "OK"], what)

    def test_noise(self):
        for rate in (200, 1000, 3000):
            for servo in (1, 5, 254):
                self.assertEqual(self.runs(f"d {servo}\n", "1", f"noise {rate}"), ["NOISE"])

    def test_replies_damaged_on_a_line_that_is_quiet(self):
        orders = [f"flip out {packet} 3 4" for packet in (1, 5, 8, 12, 17, 21, 24, 28)]
        self.assertEqual(self.runs("d 1\n", "1,2", *orders), ["NOISE"])
        self.assertEqual(self.runs("d 1\n", "1,2", *orders[:4]), ["OK"])  # the second time
        self.assertEqual(self.runs("d 1\n", "1,2", "flip out every 3 4"), ["NOISE"])  # both servos'

    def test_echo(self):
        # a return delay that leaves time for the echo of the last byte, as in test_faults.py
        script = "w 1 5 20\nd 1\nd 2\nd 254\n@fault echo off\nd 1\n"
        self.assertEqual(self.runs(script, "1", "echo on"), ["ECHO"] * 3 + ["OK"])

    def test_collision_of_own_bytes(self):
        for byte in (2, 4, 5):
            for board in ("test/boards/adapter-echo", "arbotix"):
                self.assertEqual(self.runs("d 1\n", "1", f"flip in every {byte} 3", board=board),
                                 ["COLLISION"])

    def test_replies_of_another_id_are_somebody_else_s(self):
        self.assertEqual(self.runs("d 1\n", "1", *(f"id out {packet} 9" for packet in (6, 7, 8))),
                         ["COLLISION"])

    # ---- two servos with one ID ----

    def twins(self, script, servos, *faults):
        return self.runs(script, servos, *faults, options=["--allow-duplicates"])

    def test_twins_that_reply_at_once_differ_in_measured_values(self):
        script = "@supply 2 11.5\nw 254 3 7\nd 7\nd 254\n"
        self.assertEqual(self.twins(script, "1,2"), ["DUPLICATE_ID"] * 2)
        self.assertEqual(self.found[0]["ping"] + self.found[0]["same"], 10)
        self.assertEqual([one["found_id"] for one in self.found], [7, 7])

    def test_twins_in_step_that_differ_in_torque_only(self):
        self.assertEqual(self.twins("w 1 24 1\nw 254 3 7\nd 7\n", "1,2"), ["DUPLICATE_ID"])
        self.assertEqual(self.found[0]["ping"] + self.found[0]["same"], 10)
        self.assertEqual(self.twins("w 254 24 1\nw 254 3 7\nd 7\n", "1,2"), ["OK"])

    def test_twins_with_jitter(self):
        for us in (1, 4, 20):
            script = f"@supply 2 11.5\nw 254 3 7\n@fault quirk 7 jitter_us {us}\nd 7\n"
            self.assertEqual(self.twins(script, "1,2"), ["DUPLICATE_ID"], us)

    def test_twins_apart_by_a_bit_to_half_a_millisecond_alone_or_not(self):
        for us in (1, 2, 5, 9, 20, 40, 59, 61, 70, 100, 300, 500):
            for servos in ("7,7", "7,7,9"):
                self.assertEqual(self.twins("d 7\n", servos, f"turnaround 7 {us}"), ["DUPLICATE_ID"], us)

    def test_one_that_answers_before_the_driver_has_let_go(self):
        for servos, ids in (("1", (1, 254)), ("77", (77,)), ("1,2", (1,))):
            script = f"w {ids[0]} 5 0\n" + "".join(f"d {id}\n" for id in ids)
            found = self.runs(script, servos, options=["--rules", "warn"])
            self.assertEqual(found, ["REPLIES_TOO_EARLY"] * len(ids), servos)
            self.assertEqual({one["found_id"] for one in self.found}, {ids[0]})
        self.assertEqual(self.runs("w 1 5 0\nd 1\nw 1 5 1\nd 1\n", options=["--rules", "warn"]),
                         ["REPLIES_TOO_EARLY", "OK"])
        self.assertEqual(self.runs("w 1 5 0\nd 1\n", board="arbotix"), ["OK"])

    def test_twins_that_answer_before_the_driver_has_let_go(self):
        script = "@supply 2 11.5\nw 254 3 7\nw 7 5 0\nd 7\n"
        found = self.runs(script, "1,2", options=["--allow-duplicates", "--rules", "warn"])
        self.assertEqual(found, ["DUPLICATE_ID"])

    # ---- what a servo says, or does not ----

    def test_no_reply_by_level(self):
        self.assertEqual(self.runs("w 1 16 0\nd 1\nd 254\n"), ["NO_REPLY_BY_LEVEL"] * 2)
        self.assertEqual(self.runs("w 1 16 1\nd 1\n"), ["OK"])

    def test_slow(self):
        self.assertEqual(self.runs("r 2\nw 1 5 254\nd 1\nr 508\nd 1\n"), ["SLOW", "OK"])
        self.assertEqual(self.found[0]["value"], 508)
        for us in (180, 200, 210, 220, 240, 260, 280, 900): # amid the reply, or before it
            self.assertEqual(self.runs("w 1 5 254\nd 1\n", "1", f"quirk 1 extra_turnaround_us {us}"),
                             ["SLOW"])
            self.assertEqual(self.found[0]["value"], 0)

    def test_slow_beyond_the_time_in_which_a_reply_counts_as_stale(self):
        for us in (1600, 2000, 2500, 3000, 5000, 9000):
            with self.subTest(us=us):
                self.assertEqual(self.runs("d 1\n", "1-3", f"turnaround 1 {us}"), ["SLOW"])
                self.assertEqual(self.found[0]["found_id"], 1)

    def test_supply_and_temperature(self):
        script = ("@supply 5.9\nd 1\n@supply 6\nd 1\n@supply 16\nd 1\n@supply 16.1\nd 1\n@supply 12\n"
                  "@ambient 95\n@wait 30000\nd 1\n")
        self.assertEqual(self.runs(script),
                         ["LOW_SUPPLY", "OK", "OK", "HIGH_SUPPLY", "OVERHEATED"])
        self.assertEqual([self.found[i]["value"] for i in (0, 3)], [5900, 16100])
        self.assertGreater(self.found[4]["value"], 80)


if __name__ == "__main__":
    unittest.main()
