# SPDX-License-Identifier: MIT
"""The bench itself: what it measures is in docs/internals/performance.md, from `make bench`."""
# needs: $(BENCH_NEEDS) build/atmega128/benchmark/slow_handlers.elf build/atmega128/benchmark/blocking_absent.elf
import contextlib
import csv
import io
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
from fractions import Fraction
from unittest import mock

from simulator import ROOT

sys.path.insert(0, str(ROOT / "scripts"))
import account
import bench
import blocks
import measure

QUICK = "isr_rx_max,isr_udre_max,isr_txc_max,sync18,sync18_build,absent_us,absent_blocked"
SLOW_HANDLER = "benchmark/handlers=build/atmega128/benchmark/slow_handlers.elf"


def run(*options):
    """(status, what it prints, the rows it writes)"""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "bench.tsv"
        done = subprocess.run([ROOT / "scripts/bench.py", "--out", out, *options], timeout=300,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        return done.returncode, done.stdout, out.read_text() if out.exists() else ""


class Rows(unittest.TestCase):
    def setUp(self):
        with open(bench.ROWS) as file:
            self.rows = list(csv.DictReader(file, delimiter="\t"))

    def test_one_row_and_one_name_a_figure(self):
        names = [row["name"] for row in self.rows]
        self.assertEqual(len(names), len(set(names)))

    def test_numbers_or_a_dash(self):
        for row in self.rows:
            self.assertIn(row["sense"], ("max", "min"))
            self.assertIn(row["job"], [*bench.JOBS, "all"])
            for cell in ("limit", "wanted", "goal", "floor"):
                self.assertRegex(row[cell], r"^(-|\d+(\.\d+)?)$", row["name"])

    def test_no_goal_is_easier_than_its_limit_nor_beyond_its_floor(self):
        for row in self.rows:
            limit, wanted, goal, floor = (bench.number(row[cell])
                                          for cell in ("limit", "wanted", "goal", "floor"))
            easier = (lambda a, b: a < b) if row["sense"] == "min" else (lambda a, b: a > b)
            for hard, easy in ((goal, limit), (wanted, limit), (goal, wanted), (floor, goal)):
                if hard is not None and easy is not None:
                    self.assertFalse(easier(hard, easy), row["name"])

    def test_a_limit_is_kept_up_to_the_last_digit(self):
        most, least = {"sense": "max", "limit": "1.30"}, {"sense": "min", "limit": "90"}
        self.assertFalse(bench.exceeds(most, Fraction("1.3"), "limit"))
        self.assertTrue(bench.exceeds(most, Fraction("1.3000001"), "limit"))
        self.assertFalse(bench.exceeds(least, Fraction(90), "limit"))
        self.assertTrue(bench.exceeds(least, Fraction("89.9999"), "limit"))
        self.assertTrue(bench.exceeds(most, None, "limit"))


TIMES = """\
pin 1000 7 1 500
pin 1002 7 0 500
pin 2000 2 1 500
sent 0 2100 3380 8 0 12
pin 2300 2 0 556
sent 0 4000 5441 9 1 31
pin 6000 2 1 600
pin 6102 2 0 600
handler 30 3 150 52
handler 32 1 25 25
off 57 4155
run 9000 700 0
"""


class Documents(unittest.TestCase):
    def test_a_stale_table_is_found_and_nothing_is_written(self):
        before = [(ROOT / path).read_text() for path in ("README.md", "docs/internals/performance.md")]
        with tempfile.NamedTemporaryFile("w") as file:
            file.write("\t".join(bench.COLUMNS) + "\nsync18\tx\t1\tcycles\tmax\t2\t-\t1\t-\n")
            file.flush()
            done = subprocess.run([ROOT / "scripts/bench.py", "--docs", "--check", "--out", file.name],
                                  stdout=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stdout.count("out of date"), 2)
        self.assertEqual(before, [(ROOT / path).read_text()
                                  for path in ("README.md", "docs/internals/performance.md")])

    def document(self, text):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = pathlib.Path(folder.name) / "x.md"
        path.write_text(text)
        return path

    def test_stale_tables_of_the_account_are_found(self):
        path = self.document("<!-- make bench-account -->\n1\n<!-- end -->\n\n<!-- make size-map -->\n2\n<!-- end -->\n")
        for figures, status in [(("1", "2"), 0), (("1", "3"), 1), (("0", "2"), 1)]:
            with mock.patch.object(account, "DOCS", path), mock.patch.object(account, "account", lambda: figures), \
                    contextlib.redirect_stdout(io.StringIO()) as said:
                self.assertEqual(account.main(["--docs", "--check"]), status)
            self.assertEqual(said.getvalue().count("out of date: run make bench-docs"), status)
        self.assertIn("\n1\n", path.read_text())
        self.assertIn("\n2\n", path.read_text())

    def test_a_block_without_its_marks_is_refused(self):
        whole = "<!-- a -->\n1\n<!-- end -->\n<!-- b -->\n2\n<!-- end -->\n"
        self.assertEqual(blocks.renew(self.document(whole), {"a": "1", "b": "2"}, check=True), 0)
        for text, wrong in [(whole.replace("<!-- a -->", ""), "no block"), (whole + whole, "2 blocks"),
                            (whole.replace("<!-- end -->\n", "", 1), "no block"), ("", "no block")]:
            with self.subTest(text=text), self.assertRaisesRegex(SystemExit, f"x.md has {wrong}s? from a line <!-- a -->"):
                blocks.renew(self.document(text), {"a": "1"}, check=True)

    def test_a_new_block_replaces_the_old_one_only(self):
        path = self.document("x\n<!-- a -->\n1\n<!-- end -->\n<!-- b -->\n2\n<!-- end -->\n")
        self.assertEqual(blocks.renew(path, {"a": "3\n\\1"}), 0)
        self.assertEqual(path.read_text(), "x\n<!-- a -->\n3\n\\1\n<!-- end -->\n<!-- b -->\n2\n<!-- end -->\n")


class Account(unittest.TestCase):
    def test_all_cycles_of_a_span_are_somebodys(self):
        program = account.Program("benchmark/sync", "--stamp", "B", seconds=2, servos="1-18", eeprom=[18])
        begun = program.run.spans(measure.CALL)[-1][2]
        spent = program.cycles(begun, begun + 500)
        self.assertEqual(sum(spent.values()), 500)
        self.assertGreater(spent["handlers"], 40)
        self.assertGreater(spent["cds_servo_send"], 10)


class Times(unittest.TestCase):
    """What is made of the simulator's figures."""

    def setUp(self):
        self.run_of = object.__new__(measure.Run)
        self.run_of.what, self.run_of.output, self.run_of.board = "x", "", "atmega128"
        self.run_of.read(TIMES)

    def test_marks_cost_nothing(self):
        self.assertEqual(self.run_of.spans(7)[0][0], 0)
        self.assertEqual(self.run_of.spans(2), [(298, 56, 2002), (100, 0, 6002)])

    def test_handlers_are_taken_off(self):
        self.assertEqual(self.run_of.net(2), 242)

    def test_transmissions(self):
        self.assertEqual(self.run_of.sent, [(2100, 3380, 8, 0, 12), (4000, 5441, 9, 1, 31)])

    def test_handlers_and_interrupts_off(self):
        self.assertEqual(self.run_of.everywhere(), {"isr_rx_max": 52, "isr_udre_max": 0,
                                                    "isr_txc_max": 25, "irq_off_max": 57})
        self.assertEqual((self.run_of.cycles, self.run_of.in_handlers), (9000, 700))

    def test_a_mark_that_is_missing_is_no_zero(self):
        with self.assertRaises(measure.Wrong):
            self.run_of.spans(3)

    def test_broken_rules_are_counted(self):
        self.run_of.output = ("WARNING: overrun, 7 times: lost\nBROKEN:  reply-lost, 2 times: x\n"
                              "WARNING: collision, 5 times: x\n")
        self.assertEqual(self.run_of.broken("overrun", "reply-lost"), 9)

    def test_the_worst_of_several(self):
        self.assertEqual(measure.worst([{"a": 1, "b": 5}, {"a": 3}]), {"a": 3, "b": 5})


class Runs(unittest.TestCase):
    def test_two_runs_agree_to_the_digit(self):
        first, second = run("--only", QUICK), run("--only", QUICK)
        self.assertEqual(first, second)
        lines = [line.split("\t") for line in first[2].splitlines()]
        self.assertEqual(lines[0], bench.COLUMNS)
        self.assertEqual([line[0] for line in lines[1:]], [
            "isr_rx_max", "isr_udre_max", "isr_txc_max", "sync18", "sync18_build", "absent_us",
            "absent_blocked"])
        for line in lines[1:]:
            for cell in (line[2], *line[5:]):
                self.assertRegex(cell, r"^(-|\d+(\.\d+)?)$")
            self.assertNotEqual(line[2], "-", line[0])

    def test_a_slowed_handler_makes_it_fail(self):
        rows = "isr_rx_max,isr_udre_max,isr_txc_max"
        status, output, good = run("--only", rows)
        self.assertEqual(status, 0, output)
        status, output, slow = run("--only", rows, "--program", SLOW_HANDLER)
        self.assertEqual(status, 1, output)
        self.assertIn("over the limit: isr_rx_max\n", output)
        value = lambda text: int(re.search(r"^isr_rx_max\t\w+\t(\d+)", text, re.M)[1])
        self.assertEqual(value(slow) - value(good), 42)  # 40, and a jump more

    def test_a_call_that_waits_makes_it_fail(self):
        status, output, rows = run("--only", "absent_blocked", "--program",
                                   "benchmark/absent=build/atmega128/benchmark/blocking_absent.elf")
        self.assertEqual(status, 1, output)
        self.assertGreater(int(re.search(r"^absent_blocked\t\w+\t(\d+)", rows, re.M)[1]), 500)

    def test_a_run_that_went_wrong_is_no_figure(self):
        status, output, rows = run("--only", "absent_us", "--program",
                                   "benchmark/absent=build/atmega128/benchmark/read.elf")
        self.assertEqual(status, 1, output)
        self.assertIn("FAILED: absent: ", output)
        self.assertIn("absent_us\tatmega128\t-\t", rows)


if __name__ == "__main__":
    unittest.main()
