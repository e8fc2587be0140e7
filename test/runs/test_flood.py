# SPDX-License-Identifier: MIT
"""300 000 random bytes, or READs of all servos, at 1 Mbps on the host link while a cycle of 18 servos
runs at 250 Hz: flood.py."""
# needs: $(patsubst %,build/%/firmware/flood.elf,$(HOST_BOARDS))
import unittest

import boards
from client import READ, WRITE, packet
from flood import DEVICE, LIMIT_US, LINK_LOSS_MS, NAMES, PERIOD_US, Run, flooded
from simulator import LONG

SERVOS = range(1, 19)


class Flood(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        every = boards.with_profile("console")
        cls.runs = {(board, during): run
                    for board in (every if LONG else ["atmega128", "arbotix"])
                    for during, run in (("quiet", Run(board, "wait 3000000")), ("flood", flooded(board, 7)))}

    def test_flood_loses_nothing_on_the_bus(self):
        for which, run in self.runs.items():
            with self.subTest(which):
                self.assertEqual(run.status, 0, run.output)  # no rule of the wire broken
                self.assertIn(run.reads - run.replies, (0, 1))  # the last one may be cut
                for name in NAMES[:14]:
                    if name not in ("sent", "ok"):
                        self.assertEqual(run.counters[name], 0, name)
                self.assertLessEqual(run.counters["sent"] - run.counters["ok"], 1)
                self.assertLessEqual(run.asked, run.counters["sent"])
                self.assertLessEqual(run.counters["sent"], run.told)

    def test_flood_misses_no_period_and_delays_no_goal(self):
        for which, run in self.runs.items():
            with self.subTest(which):
                self.assertEqual(run.periods, round(run.seconds * 1e6 / PERIOD_US) + 1)
                self.assertLessEqual(run.latest_us, LIMIT_US)  # seed 7; make flood runs others

    def test_reads_of_the_host_delay_no_goal_beyond_its_bound(self):
        """Each READ shows the permit settings of a servo; LINK_LOSS_MS makes the robot know them all."""
        for board in boards.with_profile("console"):
            for registers, gap_us in ([6, 4], 900), ([0, 17], 300), ([0, 50], 1700):
                reads = ["say " + packet(DEVICE, WRITE, [LINK_LOSS_MS, 0x60, 0xEA]).hex(" ")]
                reads += [f"say {packet(servo, READ, registers).hex(' ')}\nwait {gap_us}"
                          for servo in SERVOS]
                run = Run(board, "\n".join(reads))
                with self.subTest(board=board, registers=registers):
                    self.assertEqual(run.status, 0, run.output)
                    self.assertLess(max(run.late_on_free_line_us), 800)

    def test_flood_leaves_time_for_feedback(self):
        for quiet, loud in self.pairs():
            self.assertGreater(loud.reads, 0.7 * quiet.reads)

    def test_flood_counts_its_gaps(self):
        for quiet, loud in self.pairs():
            self.assertEqual((quiet.counters["gaps"], quiet.counters["host_malformed"]), (0, 0))
            self.assertGreater(loud.counters["gaps"], 100)
            self.assertGreaterEqual(loud.counters["gaps"], loud.counters["host_overflows"])

    def pairs(self):
        runs = list(self.runs.values())
        return zip(runs[::2], runs[1::2])


if __name__ == "__main__":
    unittest.main()
