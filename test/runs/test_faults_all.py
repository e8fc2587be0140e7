# SPDX-License-Identifier: MIT
"""`make faults`, a small seeded part of it: every row runs, on every board, and none fails."""
# needs: $(FAULTS_NEEDS)
import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from simulator import LONG, ROOT

ROWS = 47
PARTS = 20 if LONG else 120


class Part(unittest.TestCase):
    def faults(self, *options):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "faults.tsv"
            done = subprocess.run([sys.executable, "scripts/faults.py", "--out", out, *options],
                                  cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  text=True)
            return done, list(csv.DictReader(out.read_text().splitlines(), delimiter="\t"))

    def test_a_part_of_all_faults_has_no_failure(self):
        done, rows = self.faults("--part", f"1/{PARTS}", "--seed", "1")
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(len(rows), ROWS)
        self.assertEqual({row["fault"].split("-")[0] for row in rows},
                         {f"F{n}" for n in range(1, 21)})
        self.assertGreater(sum(int(row["injections"]) for row in rows), 120000 // PARTS)

    def test_parts_are_disjoint_and_the_seed_divides_them(self):
        counts = [[int(row["injections"]) for row in self.faults(
            "--part", f"{part}/3", "--seed", "5", "F3-packet", "F19")[1]] for part in (1, 2, 3)]
        self.assertEqual([sum(column) for column in zip(*counts)], [192, 432])


if __name__ == "__main__":
    unittest.main()
