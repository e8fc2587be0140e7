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

sys.path.insert(0, str(ROOT / "scripts"))
import faults

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

    def test_table_of_the_docs_needs_all_rows(self):
        with tempfile.TemporaryDirectory() as folder:
            table, docs = pathlib.Path(folder, "faults.tsv"), pathlib.Path(folder, "x.md")
            docs.write_text("<!-- make faults -->\n| old |\n<!-- end -->\n")
            names = [row.name for row in faults.rows([])]
            lines = ["\t".join(faults.COLUMNS), *(f"{name}\tx\t1\t0\t0\t0\t0\t0.0" for name in names)]
            table.write_text("\n".join(lines[:-1]) + "\n")
            with self.assertRaisesRegex(SystemExit, f"faults.tsv lacks {names[-1]}: run make faults-docs"):
                faults.document(table, docs)
            self.assertIn("| old |", docs.read_text())
            table.write_text("\n".join(lines) + "\n")
            faults.document(table, docs)
            self.assertEqual(docs.read_text().count("| x |"), ROWS)

    def test_parts_are_disjoint_and_the_seed_divides_them(self):
        counts = [[int(row["injections"]) for row in self.faults(
            "--part", f"{part}/3", "--seed", "5", "F3-packet", "F19")[1]] for part in (1, 2, 3)]
        self.assertEqual([sum(column) for column in zip(*counts)], [192, 432])


if __name__ == "__main__":
    unittest.main()
