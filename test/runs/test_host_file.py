# SPDX-License-Identifier: MIT
"""--host FILE: the program on the PC ends with its last line, with a line that is not met, or with the run."""
# needs: build/atmega128/controller.elf
import pathlib
import tempfile
import unittest

from simulator import ROOT, SIM, Run, call

DEAF = "int main(void) { for (;;); }\n"


class HostFile(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_with(self, lines, elf="build/atmega128/controller.elf", *options):
        path = self.folder / "pc.txt"
        path.write_text(lines)
        return Run(elf, "--host", path, *options)

    def deaf(self):
        """Firmware that opens no receiver."""
        source, elf = self.folder / "deaf.c", self.folder / "deaf.elf"
        source.write_text(DEAF)
        self.assertEqual(call("avr-gcc", "-mmcu=atmega128", "-Os", source, "-o", elf), (0, ""))
        return elf

    def test_firmware_that_never_receives_ends_the_run(self):
        run = self.run_with("text p\n", self.deaf())
        self.assertEqual(run.status, 1)
        self.assertIn("pc.txt:1: after 10 s the firmware does not receive on its host USART", run.output)

    def test_run_that_is_over_before_the_last_line_fails(self):
        run = self.run_with("# first\ntext p\n", self.deaf(), "--seconds", "1")
        self.assertEqual(run.status, 1)
        self.assertIn("script-unfinished: ", run.output)
        self.assertIn("pc.txt:2: --seconds were over", run.output)
        self.assertEqual(self.run_with("text ping 1\nwait 100000\n").status, 0)

    def test_expect_goes_on_once_the_text_has_come(self):
        run = self.run_with("text ping 1\nexpect ok within 2000\ntext ping 9\nexpect error 2: servo 9: no reply\n")
        self.assertEqual(run.status, 0, run.output)
        last = run.output.split("heard")[-1].split("\n")[0]
        self.assertTrue(bytes.fromhex("".join(last.split()[3:])).endswith(b"error 2: servo 9: no reply"), last)

    def test_lines_of_text_stand_under_their_bytes(self):
        run = self.run_with("text mode program\nwait 100000\nrest\ntext get 1 ID\nexpect ok\n")
        self.assertIn(" 6F 6B\ntext: ID = 1\ntext: ok\n", run.output)

    def test_bytes_that_are_no_text_stand_alone(self):
        run = self.run_with("text ping 1\nwait 100000\nrest\nsay FF FF 01 02 01 FB\nhear 6\n")
        self.assertIn(" 6 FF FF 01 02 00 FC\ntime:", run.output)

    def test_expect_of_a_text_that_does_not_come_fails(self):
        run = self.run_with("text ping 1\nexpect ok\nexpect within reach within 50\ntext ping 1\n")
        self.assertEqual(run.status, 1)
        self.assertIn("pc.txt:3: heard ", run.output)
        self.assertIn(" bytes without 'within reach'", run.output)

    def test_expect_takes_no_blanks_around_within(self):
        run = self.run_with("text ping 1\nexpect okay  within  50\ntext ping 1\n")
        self.assertIn(" bytes without 'okay'\n", run.output)

    def test_a_wrong_line_is_refused_with_its_number(self):
        path = self.folder / "pc.txt"
        for line, wrong in [("expect", "a text is wanted"), ("say FF 1", "wanted: bytes in hexadecimal, 1024 at most"),
                            ("rest 1", "too many words"), ("wait", "a number is wanted"), ("wait 0", "a number is wanted"),
                            ("wait 1 2", "too many words"), ("baud x", "a number is wanted"), ("baud 9600 8", "too many words"),
                            ("hear 4097", "a number is wanted"), ("hear 1 within x", "milliseconds are wanted"),
                            ("hear 1 2", "too many words"), ("hear 1 within 2 3", "too many words"),
                            ("flood 1 0", "a seed is wanted"), ("flood 1 2 3", "too many words"),
                            ("sing", "unknown word; there are say text rest hear wait baud flood reset expect")]:
            with self.subTest(line=line):
                path.write_text(f"# a comment\n\n  {line}  \ntext p")
                status, said = call(SIM, "firmware", ROOT / "build/atmega128/controller.elf", "--board", "atmega128",
                                    "--servos", "1", "--host", path)
                self.assertEqual((status, said), (2, f"{path}:3: {wrong}\n"))


if __name__ == "__main__":
    unittest.main()
