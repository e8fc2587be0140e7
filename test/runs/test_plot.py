# SPDX-License-Identifier: MIT
"""The pictures: --plot as an SVG that says what it must, --vcd as a dump that a viewer can read."""
# needs: build/atmega128/controller.elf $(patsubst %,build/firmware/%.elf,breaches byte_time mutant_late_release three_buses)
import os
import pathlib
import re
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

from simulator import ROOT, SIM, Run

SVG = "{http://www.w3.org/2000/svg}"
LEGEND = {"packet of the controller", "packet of a servo", "fault injected", "collision",
          "rule broken", "no packet", "up to 1 %", "to 10 %", "to 50 %", "to 100 %"}
# as in scripts/plot.gp
CONTROLLER, SERVO = " 27, 108, 168", "217,  95,   2"


class Picture:
    """A run with --plot: .status, .output, and the picture's .texts, .legend, .source."""

    def __init__(self, *options, elf="build/atmega128/controller.elf", board="atmega128",
                 servos="1-3", script=None):
        with tempfile.TemporaryDirectory() as folder:
            svg = pathlib.Path(folder) / "it's a picture.svg"
            run = Run(elf, "--plot", svg, *options, board=board, servos=servos, script=script)
            self.status, self.output = run.status, run.output
            self.root = root = ElementTree.parse(svg).getroot()
        self.width, self.height = (int(root.get(name)) for name in ("width", "height"))
        self.texts = ["".join(t.itertext()).strip() for t in root.iter(SVG + "text")]
        self.legend = LEGEND & set(self.texts)
        self.source = ElementTree.tostring(root, encoding="unicode")

    def count(self, colour):
        """Bars of that colour, the legend's one included."""
        return len(re.findall(r"<[\w:]*polygon fill=\"rgb\(%s\)" % colour, self.source))

    def boxes(self):
        """(text, left, top, right, bottom) of each text that stands level, in pixels. A character is taken for 0.55
        of the size of the font."""
        found = []
        for group in self.root.iter(SVG + "g"):
            place = re.fullmatch(r"translate\(([^,]*),([^)]*)\)", group.get("transform", ""))
            for text in group.findall(SVG + "text") if place else ():
                what, size = "".join(text.itertext()).strip(), float(group.get("font-size"))
                width = 0.55 * size * len(what)
                left = float(place[1]) - width * {"start": 0, "middle": 0.5, "end": 1}[group.get("text-anchor")]
                bottom = float(place[2])
                found.append((what, left, bottom - 0.8 * size, left + width, bottom + 0.2 * size))
        return found

    def curves(self):
        """Heights of the points of each full line in the colour of the first servo, in pixels above its first
        point. The legend has no part in them."""
        lines = re.findall(r'<[\w:]*path stroke="rgb\( 27, 108, 168\)" d="M[^"]* M([^"]*)"', self.source)
        heights = [[float(point.split(",")[1]) for point in line.replace("L", " ").split()] for line in lines]
        return [[points[0] - y for y in points] for points in heights]


class Plot(unittest.TestCase):
    def labels(self, picture, *wanted):
        for text in wanted:
            self.assertIn(text, picture.texts)

    def test_both_panes_are_labelled_with_units(self):
        picture = Picture(script="ping 1\nwrite 1 TORQUE_ENABLE 1\nwrite 1 GOAL_POSITION 700\n"
                                 "@wait 100\n")
        self.assertEqual(picture.status, 0, picture.output)
        self.labels(picture, "controller.elf on atmega128", "Senders on the bus",
                    "Where the servos are", "position (degrees)", "300", "goal position",
                    "present position", "packet of the controller", "packet of a servo")
        self.assertEqual(picture.texts.count("time (ms)"), 2)

    def test_speed_and_load_have_panes_on_request(self):
        script = "@load 1 300\nwrite 1 TORQUE_ENABLE 1\nwrite 1 MOVING_SPEED 512\n" \
                 "write 1 GOAL_POSITION 900\n@wait 500\n"
        pane = 320  # pixels
        picture = Picture("--panes", "load,speed", servos="1", script=script)
        self.assertEqual(picture.status, 0, picture.output)
        self.labels(picture, "position (degrees)", "speed (RPM)", "load (% of the stall torque)")
        self.assertEqual(picture.texts.count("time (ms)"), 4)
        _, speed, load = picture.curves()
        self.assertAlmostEqual(max(speed), pane * 31 / 124, delta=2)
        friction = 40
        self.assertAlmostEqual(min(load), -pane * (300 + friction) / 2046, delta=2)

    def test_each_pane_stands_alone_if_asked_alone(self):
        for pane, label in [("speed", "speed (RPM)"), ("load", "load (% of the stall torque)")]:
            picture = Picture("--panes", pane, script="ping 1\n")
            self.labels(picture, label)
            self.assertEqual(picture.texts.count("time (ms)"), 3)

    def test_speed_and_load_of_many_servos_have_rows(self):
        picture = Picture("--panes", "speed,load", servos="1-18", script="ping 1\n")
        self.labels(picture, "Present speed (CCW is positive): each row spans -62 to 62 RPM",
                    "Present load (CCW is positive): each row spans -100 to 100 % of the stall torque")
        self.assertEqual(picture.texts.count("servo 18"), 4)

    def test_a_lane_for_each_talker(self):
        picture = Picture(script="ping 3\n")
        self.labels(picture, "wire", "controller", "servo 1", "servo 2", "servo 3")
        self.assertEqual(picture.legend, {"packet of the controller", "packet of a servo"})

    def test_fifty_servos_have_rows_of_their_own(self):
        ids = range(1, 51)
        picture = Picture(servos="1-50", script="".join(f"ping {n}\n" for n in ids))
        for n in ids:
            self.assertEqual(picture.texts.count(f"servo {n}"), 2)  # as a sender; where it is
        self.labels(picture, "Where the servos are: each row spans 0 to 300 degrees")
        self.assertGreater(picture.height, 50 * (14 + 20))
        self.assertLess(picture.width, 1300)

    def test_every_packet_of_a_short_run_is_a_bar(self):
        picture = Picture(script="ping 1\nping 2\nping 1\n")
        self.assertEqual(picture.count(CONTROLLER), 3 + 1)  # and the legend
        self.assertEqual(picture.count(SERVO), 3 + 1)

    def test_a_long_busy_run_shows_shares_of_time(self):
        picture = Picture(script="ping 1\nping 2\n@wait 20\n" * 150)
        self.assertEqual(picture.legend - {"up to 1 %", "to 10 %", "to 50 %"}, set())
        self.assertTrue(picture.legend)
        self.assertTrue(any(re.match(r"Senders on the bus: share of every [\d.]+ ms", t)
                            for t in picture.texts))
        self.labels(picture, "time (s)")

    def test_marks_of_faults_and_damaged_packets(self):
        picture = Picture("--fault", "flip out 2 4 3", script="ping 1\n! ping 2\n")
        self.assertEqual(picture.status, 0, picture.output)
        self.assertLessEqual({"fault injected", "no packet"}, picture.legend)

    def test_marks_of_breaches(self):
        picture = Picture("--seconds", "0.5", elf="build/firmware/breaches.elf")
        self.assertEqual(picture.status, 1)
        self.assertIn("rule broken", picture.legend)
        self.assertNotIn("collision", picture.legend)

    def test_marks_of_collisions(self):
        picture = Picture("--seconds", "0.5", "--rules", "warn",
                          elf="build/firmware/mutant_late_release.elf")
        self.assertIn("collision", picture.legend)

    def test_a_collision_is_marked_where_it_is_no_breach(self):
        picture = Picture("--allow-duplicates", script="@servos 1,1\nping 1\n")
        self.assertEqual(picture.status, 0, picture.output)
        self.assertEqual(picture.texts.count("servo 1 (2)"), 2)
        self.assertIn("collision", picture.legend)
        self.assertNotIn("rule broken", picture.legend)

    def test_several_buses_are_told_apart(self):
        picture = Picture("--servos", "2:1", "--seconds", "0.5",
                          elf="build/firmware/three_buses.elf", board="arduino-mega")
        lanes = [t for t in dict.fromkeys(picture.texts) if t.startswith("bus ")]
        self.assertEqual(lanes[::-1], [  # they are written from the bottom up
            "bus 0 wire", "bus 0 controller", "bus 0 servo 1", "bus 0 servo 2", "bus 0 servo 3",
            "bus 1 wire", "bus 1 controller", "bus 2 wire", "bus 2 controller", "bus 2 servo 1"])

    def assert_no_text_covers_another(self, picture):
        boxes = picture.boxes()
        self.assertGreater(len(boxes), 20)
        for a, left, top, right, bottom in boxes:
            self.assertGreaterEqual(left, 0, a)
            self.assertLessEqual(right, picture.width, a)
            self.assertEqual([], [b for b, b_left, b_top, b_right, b_bottom in boxes if b is not a and
                                  left < b_right and b_left < right and top < b_bottom and b_top < bottom], a)

    def test_no_text_covers_another(self):
        servos = [["--servos", "1:1-2", "--servos", "2:1,253"], ["--servos", "1:1-9", "--servos", "2:253"]]
        for options in servos:
            self.assert_no_text_covers_another(Picture(
                *options, "--seconds", "0.5", "--panes", "speed,load", elf="build/firmware/three_buses.elf",
                board="arduino-mega", servos="1-2"))
        script = "ping 1\nping 2\n@wait 20\n" * 150 + "@fault flip out 2 4 3\nping 1\n! ping 2\n"
        self.assert_no_text_covers_another(Picture("--panes", "speed,load", script=script))

    def test_the_same_run_draws_the_same_picture(self):
        first, second = (Picture(script="ping 1\nping 2\n").source for _ in range(2))
        self.assertEqual(first, second)

    def refused(self, svg, path=None):
        environment = dict(os.environ, **({"PATH": path} if path else {}))
        done = subprocess.run([SIM, "firmware", ROOT / "build/firmware/byte_time.elf", "--board",
                               "atmega128", "--seconds", "0.1", "--plot", svg],
                              env=environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stdout, "")
        return done.stderr

    def test_without_gnuplot_one_line_says_so(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertRegex(self.refused(folder + "/x.svg", path=folder),
                             r"\A.*x\.svg: --plot needs gnuplot .*\n\Z")

    def test_a_picture_that_cannot_be_written_is_refused(self):
        self.assertEqual(self.refused("/no/such/folder/x.svg"),
                         "/no/such/folder/x.svg: No such file or directory; make its folder first, or name another folder\n")


    def test_plot_without_a_locale_prints_no_warning(self):
        with tempfile.TemporaryDirectory() as folder:
            environment = {name: value for name, value in os.environ.items() if not name.startswith(("LC_", "LANG"))}
            done = subprocess.run([SIM, "bus", "--servos", "1", "--seconds", "0.01", "--plot", folder + "/x.svg"],
                                  env=environment, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("warning", done.stderr)


class Dump(unittest.TestCase):
    """A value change dump, read as a viewer does."""

    def read(self, script, servos="1"):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "x.vcd"
            run = Run("build/atmega128/controller.elf", "--vcd", path, servos=servos,
                      script=script)
            self.assertEqual(run.status, 0, run.output)
            head, body = path.read_text().split("$enddefinitions $end\n")
        self.assertRegex(head, r"\$timescale 100 ps \$end")
        names = dict(re.findall(r"\$var wire \d+ (\S+) (\S+) \$end", head))
        changes = {name: [] for name in names.values()}
        now = -1
        for line in body.splitlines():
            if line[0] == "#":
                self.assertGreater(int(line[1:]), now)
                now = int(line[1:])
            else:
                value, code = line[1:].split() if line[0] == "b" else (line[0], line[1:])
                changes[names[code]].append((now * 1e-7, int(value, 2)))
        return changes

    def test_torque_and_led_of_a_servo(self):
        changes = self.read("write 1 LED 1\n@wait 10\nwrite 1 TORQUE_ENABLE 1\n@wait 10\n"
                            "write 1 LED 0\n@wait 10\n")
        self.assertEqual([value for _, value in changes["bus0_servo1_led"]], [0, 1, 0])
        self.assertEqual([value for _, value in changes["bus0_servo1_torque"]], [0, 1])
        lit, _ = changes["bus0_servo1_led"][1]
        driven, _ = changes["bus0_servo1_torque"][1]
        self.assertAlmostEqual(driven - lit, 12, delta=6)  # ms: they are looked at every 4

    def test_handlers_and_talkers(self):
        changes = self.read("ping 1\n")
        vectors = {value for _, value in changes["cpu_handler_vector"]}
        self.assertLessEqual({0, 30, 32}, vectors)  # none, USART1 RX, USART1 TX
        talks = changes["bus0_servo1_talks"]
        self.assertEqual([value for _, value in talks], [0, 1, 0])
        self.assertAlmostEqual((talks[2][0] - talks[1][0]) * 1000, 60, places=3)  # us: six bytes


if __name__ == "__main__":
    unittest.main()
