# SPDX-License-Identifier: MIT
"""scripts/link.sh: what a user reads if a profile does not fit the flash."""
import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

REMEDY = ("profile 'full' does not fit the flash of 'myboard', 660 bytes over: see 'Make room' in CONTRIBUTING.md; "
          "for a new board: PROFILES := bridge console in its board.mk (docs/linking.md)\n")


def link(command):
    done = subprocess.run([ROOT / "scripts/link.sh", "myboard", "full", "NAME=value", "sh", "-c", command],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return done.returncode, done.stdout


class Link(unittest.TestCase):
    def test_program_that_is_too_large_names_the_remedy(self):
        message = "ld: region `text' overflowed by 660 bytes"
        status, output = link(f"echo \"{message.replace('`', chr(92) + '`')}\"; exit 1")
        self.assertEqual(status, 1)
        self.assertIn(message, output)
        self.assertIn(REMEDY, output)

    def test_other_failure_has_no_remedy(self):
        self.assertEqual(link("echo undefined reference; exit 2"), (2, "undefined reference\n"))

    def test_success_prints_nothing(self):
        self.assertEqual(link("test \"$NAME\" = value"), (0, ""))


if __name__ == "__main__":
    unittest.main()
