# SPDX-License-Identifier: MIT
"""scripts/send-lines.py, with the console of the simulator as its port."""
# needs: $(CONSOLE_ELFS)
import importlib.util
import os
import re
import subprocess
import tempfile
import unittest

import boards

from simulator import ROOT, Process


class SendLines(unittest.TestCase):
    POSES = "group 1 2 3\npose set left 448raw 576raw 512raw\npose set right 576raw 448raw 512raw\n" \
            "sequence wave new left 0.8s\nsequence wave add right 0.8s\n"

    def send(self, lines, path, *options):
        return subprocess.run([ROOT / "scripts/send-lines.py", *options, path, "/dev/stdin"], input=lines, capture_output=True,
                              text=True)

    def test_lines_are_stored_and_the_first_refused_one_ends_it(self):
        board = boards.WITH_MOTION[0]
        with Process("firmware", ROOT / f"build/{board}/controller.elf", "--board", board, "--servos", "1-3",
                     "--host", "pty") as sim:
            done = self.send("# my robot\n> " + self.POSES + "ok\n> pose show\nsequence show\n> \n", sim.path)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(len(re.findall(r"^\d/7 .*\bok$", done.stdout, re.M)), 7, done.stdout)
            saved = self.send("pose show\nsequence show\n", sim.path, "--replies").stdout
            self.assertEqual(saved.splitlines()[-2:], self.POSES.splitlines()[-2:])
            self.assertEqual(set(saved.splitlines()), set(self.POSES.splitlines()))  # no prompt, no ok
            for lines in "pose delete left\npose delete right\nsequence delete wave\n", saved:
                self.assertEqual(self.send(lines, sim.path).returncode, 0)
            self.assertEqual(self.send("pose show\nsequence show\n", sim.path, "--replies").stdout, saved)
            done = self.send("pose set x 1\npose list\n", sim.path)
            self.assertEqual(done.returncode, 1)
            self.assertIn("pose set x 1: error 46", done.stdout)
            self.assertIn("'pose set x 1' was refused; the lines after it were not sent", done.stderr)
            self.assertNotIn("pose list", done.stdout)

    def test_restored_backup_tells_which_registers_differed(self):
        board = boards.WITH_MOTION[0]
        with Process("firmware", ROOT / f"build/{board}/controller.elf", "--board", board, "--servos", "1-2",
                     "--host", "pty") as sim:
            saved = self.send("backup 1 2\n", sim.path, "--replies").stdout
            self.assertEqual(len(saved.splitlines()), 20)
            self.assertEqual(self.send("set 1 MIN_VOLTAGE 6.5V\n", sim.path).stdout, "1/1 set 1 MIN_VOLTAGE 6.5V: written; ok\n")
            shown = self.send(saved, sim.path).stdout.splitlines()
            self.assertEqual(shown[4], "5/20 restore 1 MIN_VOLTAGE 6V: MIN_VOLTAGE = 6.5V (65) differed: written; ok")
            self.assertEqual(sum(line.endswith(": unchanged; ok") for line in shown), 19)

    def test_help_shows_the_example_as_typed(self):
        done = subprocess.run([ROOT / "scripts/send-lines.py", "--help"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0)
        self.assertIn(r"printf 'pose show\nsequence show\n' | scripts/send-lines.py --replies", done.stdout)

    def test_a_motion_that_takes_longer_names_the_limit(self):
        board = boards.WITH_MOTION[0]
        with Process("firmware", ROOT / f"build/{board}/controller.elf", "--board", board, "--servos", "1-3",
                     "--host", "pty") as sim:
            done = self.send("teach off 1-3\ngroup 1 2 3\npose 100 100 100 in 3s\nmotion wait within 50\nlist\n", sim.path)
            self.assertEqual(done.returncode, 1)
            self.assertTrue(done.stdout.endswith(" in 3s: ok\n4/5 motion wait: no reply\n"), done.stdout)
            self.assertIn("no reply to 'motion wait' in 50 ms, but the console has replied before it; if it takes longer, "
                          "write 'motion wait within MS'; the lines after it were not sent", done.stderr)

    def test_motion_wait_ends_after_an_hour_silent_port_is_told(self):
        spec = importlib.util.spec_from_file_location("send_lines", ROOT / "scripts/send-lines.py")
        send_lines = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(send_lines)
        for line, limit in [("motion wait", ("motion wait", 3600000)), ("motion wait within 70000", ("motion wait", 70000)),
                            ("scan rescue", ("scan rescue", 10000)), ("scan rescue within 700000", ("scan rescue", 700000))]:
            self.assertEqual(send_lines.limited(line), limit)
        send_lines.PATIENCE_MS = 50
        master, slave = os.openpty()
        with tempfile.NamedTemporaryFile("w") as lines, self.assertRaisesRegex(SystemExit, "no reply on .* at 115200 bit/s: is it the console's .*Another program.*picocom"):
            send_lines.main(os.ttyname(slave), lines.name)
        os.close(master)
        os.close(slave)

    def test_port_that_cannot_be_opened_names_the_remedy(self):
        script = ["/usr/bin/python3", ROOT / "scripts/send-lines.py"]  # a user may run it
        master, slave = os.openpty()
        as_user = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
        with tempfile.NamedTemporaryFile() as closed, tempfile.NamedTemporaryFile("w") as lines:
            os.chmod(closed.name, 0)
            os.chmod(lines.name, 0o644)
            for path, file, rate, message, options in [
                    (closed.name, lines.name, "115200", r"may not be opened by .*; sudo usermod -aG \w+ .*, and log in again", as_user),
                    ("/dev/ttyNONE", lines.name, "115200", "/dev/ttyNONE does not exist; plug the board in", {}),
                    ("/dev/null", lines.name, "115200", "/dev/null: .*; name the serial port of the controller", {}),
                    ("/dev/null", lines.name, "1234", "1234 is no usual rate; name one such as", {}),
                    (lines.name, os.ttyname(slave), "115200", f"{lines.name}: .*; name the serial port of the controller", {}),
                    (os.ttyname(slave), "/nowhere/poses", "57600", "/nowhere/poses: .*; name a text file", {})]:
                done = subprocess.run([*script, path, file, rate], capture_output=True, text=True, **options)
                self.assertEqual(done.returncode, 1)
                self.assertRegex(done.stderr, rf"^.*{message}.*\n$")
        os.close(master)
        os.close(slave)

    def test_output_of_an_earlier_program_is_not_a_reply(self):
        with Process("firmware", ROOT / f"build/{boards.WITH_MOTION[0]}/controller.elf", "--board", boards.WITH_MOTION[0],
                     "--servos", "1-3", "--host", "pty") as sim:
            backup = self.send("backup 1-3\n", sim.path, "--replies").stdout
            self.assertEqual(len(backup.splitlines()), 30, backup)
            for left in ("mode person\rmonitor 1 2 3\r", "mode program\rmonitor 1 2 3\r", "scan all\r", "get 1 T",
                         "teach off 1-3\r" * 3):
                with self.subTest(left), open(sim.path, "wb", buffering=0) as port:
                    port.write(left.encode())
                    self.assertEqual(self.send("backup 1-3\n", sim.path, "--replies").stdout, backup)


if __name__ == "__main__":
    unittest.main()
