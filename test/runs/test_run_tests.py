# SPDX-License-Identifier: MIT
"""scripts/run-tests.py counts only what a suite reports, and ends when it is interrupted."""
import pathlib
import re
import signal
import subprocess
import tempfile
import unittest

from simulator import ROOT, call, is_long, wait_until

RUN_TESTS = ROOT / "scripts/run-tests.py"


SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]


def default_signals():
    """A test that runs under nohup or in the background inherits signals that are ignored."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)


class RunTests(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def suite(self, body, name="suite"):
        """The path of a program that stands for a suite."""
        program = self.folder / name
        program.write_text(body if name.endswith(".py") else "#!/bin/sh\n" + body)
        program.chmod(0o755)
        return program

    def outcome(self, body, name="suite"):
        """(status, last line of the output)."""
        status, output = call(RUN_TESTS, self.suite(body, name))
        return status, output.strip().splitlines()[-1]

    def test_passing_suite_passes(self):
        self.assertEqual(self.outcome("echo '3 Tests 0 Failures 0 Ignored'"), (0, "3 passed, 0 failed"))

    def test_failing_suite_fails(self):
        self.assertEqual(self.outcome("echo '3 Tests 1 Failures 0 Ignored'; exit 1"),
                         (1, "2 passed, 1 failed"))

    def test_ignored_tests_have_not_passed(self):
        self.assertEqual(self.outcome("echo '3 Tests 0 Failures 2 Ignored'"), (1, "1 passed, 2 failed"))

    def test_crash_after_the_summary_fails(self):
        self.assertEqual(self.outcome("echo '3 Tests 0 Failures 0 Ignored'; exit 139")[0], 1)

    def test_silence_is_a_failure(self):
        self.assertEqual(self.outcome("exit 0"), (1, "0 passed, 1 failed"))

    def test_no_tests_is_a_failure(self):
        self.assertEqual(self.outcome("echo '0 Tests 0 Failures 0 Ignored'")[0], 1)

    def test_last_of_several_summaries_counts(self):
        self.assertEqual(self.outcome("echo '9 Tests 0 Failures 0 Ignored'\n"
                                      "echo '3 Tests 1 Failures 0 Ignored'"), (1, "2 passed, 1 failed"))
        self.assertEqual(self.outcome("print('Ran 9 tests in 1s'); print('FAILED (failures=2)')\n"
                                      "print('Ran 3 tests in 1s'); print('OK (skipped=1)')", "suite.py"),
                         (1, "2 passed, 1 failed"))

    def test_summary_of_unity_does_not_count_for_a_run(self):
        self.assertEqual(self.outcome("print('3 Tests 0 Failures 0 Ignored')", "suite.py"),
                         (1, "0 passed, 1 failed"))

    def test_skipped_suites_are_named_before_the_last_line(self):
        status, output = call(RUN_TESTS, "--skipped", "the page: make test-panel", self.suite("echo '3 Tests 0 Failures 0 Ignored'"))
        self.assertEqual((status, output.splitlines()[-3:]), (0, ["skipped: the page: make test-panel", "", "3 passed, 0 failed"]))

    def test_each_line_says_how_many_suites_have_ended(self):
        suites = [self.suite("echo '2 Tests 0 Failures 0 Ignored'", f"suite{n}") for n in range(3)]
        output = call(RUN_TESTS, *suites)[1]
        self.assertEqual([line.split()[0] for line in output.splitlines()[:3]], ["1/3", "2/3", "3/3"])

    def test_program_that_cannot_start_counts_as_failed(self):
        status, output = call(RUN_TESTS, self.folder / "nosuch")
        self.assertEqual(status, 1, output)
        self.assertIn("No such file", output)
        self.assertIn("0 passed, 1 failed", output)

    def test_damaged_file_of_times_is_ignored(self):
        times = self.folder / "times"
        times.write_bytes(b"junk\n\xff\tx\nsuite\t1")
        suite = self.suite("echo '2 Tests 0 Failures 0 Ignored'")
        self.assertEqual(call(RUN_TESTS, "--times", times, suite)[0], 0)

    def interrupted_by(self, number):
        """Interrupts a run of three suites, two of which do not end. Returns its output."""
        ended = self.suite("echo '1 Tests 0 Failures 0 Ignored'", "ended")
        # the shell starts sleep, which must end with the shell
        hanging = [self.suite(f"echo > '{self.folder}/began{n}'\nsleep 120\n", f"hanging{n}")
                   for n in range(2)]
        never = self.suite(f"echo > '{self.folder}/began'", "never")
        times = self.folder / "times"
        times.write_text(f"{ended}\t9\n{hanging[0]}\t8\n{hanging[1]}\t7\n{never}\t0\n")
        process = subprocess.Popen([RUN_TESTS, "--jobs", "2", "--times", times, ended, *hanging, never],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   preexec_fn=default_signals)
        self.assertTrue(wait_until(lambda: all((self.folder / name).exists() for name in ["began0", "began1"])))
        process.send_signal(number)
        output = process.communicate(timeout=60)[0]
        self.assertEqual(process.returncode, 130, output)
        self.assertFalse((self.folder / "began").exists())
        self.assertEqual(call("pgrep", "-f", str(self.folder))[1], "")
        return output

    def test_interrupt_kills_what_runs_and_says_so(self):
        for number in SIGNALS:
            with self.subTest(number):
                self.setUp()
                output = self.interrupted_by(number)
                self.assertIn("interrupted: 1 of 4 suites have ended; killed: hanging0, hanging1\n", output)
                self.assertNotIn("Traceback", output)


class Long(unittest.TestCase):
    SUITES = re.search(r"^LONG_SUITES := ((?:.*\\\n)*.*)", (ROOT / "test/test.mk").read_text(), re.M)[1].replace("\\", "").split()

    def test_each_long_suite_is_in_one_of_four_parts(self):
        parts = [[suite for suite in self.SUITES if is_long(f"{part}/4", f"test_{suite}")] for part in (1, 2, 3, 4)]

        self.assertEqual(sorted(sum(parts, [])), sorted(self.SUITES))
        for suites in parts:
            self.assertGreaterEqual(len(suites), 3, parts)

    def test_long_suites_are_all_with_1_and_none_without(self):
        for suite in self.SUITES:
            self.assertEqual([is_long(wanted, f"test_{suite}") for wanted in ("1", "")], [True, False], suite)


if __name__ == "__main__":
    unittest.main()
