# SPDX-License-Identifier: MIT
"""The manual's own packets, on the wire, byte for byte and in order."""
# needs: $(patsubst %,build/%/controller.elf,atmega128 arduino-mega) build/atmega128/examples/hexapod.elf
import re
import shutil
import subprocess
import unittest

from simulator import PACKET, ROOT, controller


def manual_packets():
    lines = (ROOT / "test/runs/manual_packets.tsv").read_text().splitlines()
    rows = [line.split("\t") for line in lines if not line.startswith("#")]
    return [("->in" if sender == "controller" else "<-out", bytes_) for _, sender, bytes_ in rows]


class Manual(unittest.TestCase):
    def all_packets_on(self, board):
        run = controller((ROOT / "examples/manual.script").read_text(), board)
        self.assertEqual(run.status, 0, run.output)
        self.assertEqual([packet[1:] for packet in run.packets], manual_packets())

    def test_there_are_41_packets(self):
        self.assertEqual(len(manual_packets()), 41)

    def test_all_packets_on_atmega128(self):
        self.all_packets_on("atmega128")

    def test_all_packets_on_arduino_mega(self):
        self.all_packets_on("arduino-mega")

    def test_the_demo_leaves_them_in_its_transcript_and_pictures(self):
        shutil.rmtree(ROOT / "build/demo", ignore_errors=True)
        demo = subprocess.run([ROOT / "scripts/demo.sh"], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=120)
        self.assertEqual(demo.returncode, 0, demo.stdout)
        lines = (ROOT / "build/demo/transcript.txt").read_text().splitlines()
        packets = [(m[2], m[3].strip()) for m in map(PACKET.match, lines) if m]
        self.assertEqual(packets[:41], manual_packets())
        self.assertGreater(len(packets), 400)
        manual = (ROOT / "build/demo/manual.txt").read_text()
        for number in [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 15, 16, 18, 19, 20, 21]:
            title = re.search(rf"^Example ({number}: .*\n)", manual, re.M)[1]
            self.assertRegex(demo.stdout, rf"(?m)^(Example|  ) {re.escape(title)}")
        self.assertIn("present position", (ROOT / "build/demo/motion.svg").read_text())
        for text in ["a hand teaches three poses", "> play wave loop\n", "a robot with six legs walks"]:
            self.assertIn(text, demo.stdout)
        self.assertEqual(len(re.findall(r"passed: \d+ packets to the servos, \d+ replies, no rule of the wire broken\n",
                                        demo.stdout)), 3)
        self.assertTrue(demo.stdout.endswith("\nmake demo: all 4 parts passed\n"))
        self.assertLess(demo.stdout.count("\n"), 100)
        self.assertLessEqual(max(map(len, demo.stdout.splitlines())), 120)
        self.assertIn("animate", (ROOT / "build/demo/hexapod.svg").read_text())
        files = sorted(path.name for path in (ROOT / "build/demo").iterdir())
        self.assertEqual(sorted(re.findall(r"^build/demo/(\S+) ", demo.stdout, re.M)), files)
        table = (ROOT / "docs/getting-started.md").read_text().split("files in `build/demo/`:")[1].split("\n\n")[1]
        cells = " ".join(re.findall(r"^\| (`.*?`) \|", table, re.M))
        self.assertEqual(sorted(re.findall(r"`(\S+)`", cells)), files)


if __name__ == "__main__":
    unittest.main()
