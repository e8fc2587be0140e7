# SPDX-License-Identifier: MIT
"""The Arduino library: its ZIP, built with the core of Debian for Mega and Uno, and its sketches in the simulator."""
# needs: $(ARDUINO_ZIP) build/lib/libcds55xx-atmega2560.a
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "test/runs"), str(ROOT / "scripts")]

import arduino
from arduino_core import Builder, Failed
from simulator import Run, call

ARCHIVE = ROOT / f"build/arduino/CDS55xx-{arduino.version()}.zip"
EXAMPLES = ROOT / "arduino/examples"
SKETCHES = ROOT / "test/firmware/arduino"
CYCLES_MS = 16000

FLOATING_POINT = re.compile(r"__(add|sub|mul|div|cmp|fix|fixuns|float|floatun)\w*sf\w*")
ROBOT = "#include <CDS55xx.h>\nCDS55XX_ROBOT(robot);\n"
USES = "void use();\n"


def setUpModule():
    global FOLDER, MEGA, UNO
    FOLDER = tempfile.TemporaryDirectory()
    MEGA = Builder(pathlib.Path(FOLDER.name) / "mega", ARCHIVE, "arduino-mega")
    UNO = Builder(pathlib.Path(FOLDER.name) / "uno", ARCHIVE, "arduino-uno")


def tearDownModule():
    FOLDER.cleanup()


def word(packet, index):
    """A word of a packet, low byte first."""
    data = bytes.fromhex(packet)
    return data[index] + 256 * data[index + 1]


class Sketches(unittest.TestCase):
    def simulate(self, builder, path, *options, board="arduino-mega", **more):
        """Builds and runs a sketch: .said are its lines, .sent its packets."""
        run = Run(builder.sketch(path.stem, path.read_text()), *options, board=board, **more)
        self.assertIn("rules:   none broken", run.output)
        run.said = [line for line in run.output.splitlines()
                    if not re.search(r"(->in|<-out): |^(time|bus \d|cpu|rules|faults|script|speed):", line) and line]
        run.sent = [packet for _, way, packet in run.packets if way == "->in"]
        return run

    def example(self, builder, name, seconds, **more):
        options = ["--seconds", seconds]
        if builder is MEGA:
            options += ["--host", "stdout"]
        return self.simulate(builder, EXAMPLES / name / f"{name}.ino", *options, **more)

    def uno(self, name, seconds):
        return self.example(UNO, name, seconds, board="arduino-uno")

    def test_led_blinks(self):
        for run in [self.example(MEGA, "led", "2"), self.uno("led", "2")]:
            on = [cycle for cycle, _, packet in run.packets if packet.startswith("FF FF 01 04 03 19 01")]
            self.assertGreaterEqual(len(on), 2)
            self.assertAlmostEqual((on[1] - on[0]) / CYCLES_MS, 1000, delta=5)

    def test_position_mode_goals_arrive_and_serial_prints(self):
        run = self.example(MEGA, "position_mode", "2.5")
        said = [re.fullmatch(r"(\d+) ms: ([\d.]+) degrees", line) for line in run.said]
        self.assertEqual(len(said), 2, run.said)
        for match, ms, degrees in zip(said, (1000, 2000), (150, 90.5)):
            self.assertAlmostEqual(int(match[1]), ms, delta=10)  # millis() advances
            self.assertAlmostEqual(float(match[2]), degrees, delta=1)
        for run in [run, self.uno("position_mode", "2.5")]:
            goals = [word(packet, 6) for packet in run.sent if packet.startswith("FF FF 01 05 03 1E")]
            self.assertEqual(goals, [512, 309, 512])
            speeds = [word(packet, 6) for packet in run.sent if packet.startswith("FF FF 01 05 03 20")]
            self.assertEqual(speeds, [495])

    def test_velocity_mode_turns_both_ways_and_stops(self):
        run = self.example(MEGA, "velocity_mode", "3.2")
        speeds = [float(line.split()[0]) for line in run.said]
        for said, wanted in zip(speeds, (25.8, -6.2, 0)):
            self.assertAlmostEqual(said, wanted, delta=0.2)
        self.assertEqual(len(speeds), 3)
        self.assertIn("FF FF 01 07 03 06 00 00 00 00 EE", run.sent)  # both angle limits 0

    def test_scan_finds_the_servos(self):
        run = self.example(MEGA, "scan", "6.5", servos="1,77,253")
        self.assertEqual(run.said, ["1000000 bit/s, found 3", "ID 1, model 1", "ID 77, model 1",
                                    "ID 253, model 1", "500000 bit/s, found 0", "250000 bit/s, found 0",
                                    "115200 bit/s, found 0", "57600 bit/s, found 0",
                                    "19200 bit/s, found 0"])

    def test_id_changes_and_back(self):
        self.assertEqual(self.example(MEGA, "id", "0.5").said, ["1 to 100: ok", "100 to 1: ok"])

    def test_control_table_reads_registers(self):
        run = self.example(MEGA, "control_table", "0.4")
        self.assertEqual(run.said, ["12.00 V", "150147 millidegrees"])

    def test_examples_build_for_an_uno(self):
        for name in ["velocity_mode", "scan", "id", "control_table"]:
            path = EXAMPLES / name / f"{name}.ino"
            UNO.sketch(path.stem, path.read_text())

    def test_methods_return_what_the_table_says(self):
        run = self.simulate(MEGA, SKETCHES / "methods.ino", "--seconds", "8", "--host", "stdout",
                            servos="1-3")
        self.assertEqual(run.said, (SKETCHES / "methods.expected").read_text().splitlines())
        goals = [word(packet, 6) for packet in run.sent if packet.startswith("FF FF 01 05 03 1E")]
        # 0x0909 is the write that the servo refuses
        self.assertEqual(goals, [307, 309, 154, 1023, 100, 1023, 512, 0x0909])
        speeds = [word(packet, 6) for packet in run.sent if packet.startswith("FF FF 01 05 03 20")]
        self.assertEqual(speeds, [200, 512, 1, 0, 512, 0, 1536, 1124])

    def test_sketch_for_dynamixel2arduino_runs(self):
        run = self.simulate(MEGA, SKETCHES / "ported.ino", "--seconds", "4", "--host", "stdout")
        self.assertEqual(run.said, ["1", "32", "1", "1"])

    def test_failed_read_is_no_value(self):
        run = self.simulate(MEGA, SKETCHES / "absent.ino", "--echo", servos="1", script=(
            "@at 2500\n@power 1 off\n@at 3500\n@power 1 on\n@at 6000\n@fault baud 1 103\n"
            "@at 6300\n@fault baud 1 1\n@at 6500\n"))
        self.assertEqual(run.said, (SKETCHES / "absent.expected").read_text().splitlines())

    def test_full_load_loses_no_tick_of_millis_and_no_byte(self):
        run = self.simulate(MEGA, SKETCHES / "load.ino", "--seconds", "1.5", "--host", "stdout",
                            servos="1")
        said = "".join(run.said)
        self.assertRegex(said, r"^(0123456789)+ms ")  # no byte of Serial is lost
        ms, lost = map(int, re.search(r"ms (\d+) lost (\d+)", said).groups())
        cycles = [cycle for cycle, way, packet in run.packets if packet.startswith("FF FF 01 04 03 19")]
        self.assertAlmostEqual((cycles[1] - cycles[0]) / CYCLES_MS, ms, delta=2)
        self.assertEqual(lost, 0)


class Linking(unittest.TestCase):
    def refused(self, builder, *sources):
        with self.assertRaises(Failed) as failed:
            builder.sketch("refused", *sources)
        for path in (builder.folder / "refused").iterdir():
            path.unlink()
        (builder.folder / "refused").rmdir()
        return str(failed.exception)

    def test_uno_sketch_that_uses_serial_ends_with_our_message(self):
        for use in ["Serial.begin(9600);", "Print &out = Serial; out.print(1);", "if (Serial) use();"]:
            text = f"{ROBOT}{USES}void setup()\n{{\n    {use}\n}}\nvoid loop() {{}}\n"
            output = self.refused(UNO, text)
            self.assertIn("CDS55xx: the servos have the only USART of this board, so a sketch cannot use "
                          "Serial; use SoftwareSerial or a Mega (docs/arduino.md)", output)
            self.assertIn("refused.ino:6:", output)  # where the sketch uses it

    def test_mega_sketch_that_uses_serial1_ends_with_our_message(self):
        text = ROBOT + "void setup() { Serial1.begin(9600); }\nvoid loop() {}\n"
        self.assertIn("CDS55xx: the servos have USART1, so a sketch cannot use Serial1; use Serial, "
                      "Serial2 or Serial3", self.refused(MEGA, text))

    def test_other_file_that_uses_the_serial_ends_with_our_message(self):
        sketch = ROBOT + USES + "void setup() { robot.begin(); use(); }\nvoid loop() {}\n"
        for builder, serial in [(UNO, "Serial"), (MEGA, "Serial1")]:
            other = f"#include <Arduino.h>\nvoid use() {{ {serial}.print(1); }}\n"
            output = self.refused(builder, sketch, other)
            self.assertRegex(output, f"warning: CDS55xx: .* so a sketch cannot use {serial};")

    def test_mega_other_serials_work_beside_the_bus(self):
        MEGA.sketch("serials", ROBOT + "void setup() { robot.begin(); Serial.begin(9600); "
                    "Serial2.begin(9600); Serial3.begin(9600); }\nvoid loop() {}\n")

    def test_without_a_robot_no_handler_is_defined(self):
        use = "#include <Arduino.h>\nvoid use() { Serial1.print(1); Serial.print(1); }\n"
        sketch = "#include <CDS55xx.h>\n" + USES + "void setup() { use(); }\nvoid loop() {}\n"
        MEGA.sketch("unbound", sketch, use)
        elf = UNO.sketch("unused", "#include <CDS55xx.h>\nvoid setup() {}\nvoid loop() {}\n")
        empty = UNO.sketch("empty", "void setup() {}\nvoid loop() {}\n")
        self.assertEqual(*(subprocess.check_output(["avr-nm", "--format=posix", path]).count(b" T ")
                           for path in (elf, empty)))

    def test_integers_need_no_floating_point(self):
        sketch = ROBOT + ("""
void setup() { robot.begin(1000000); robot.ping(1); robot.setOperatingMode(1, OP_POSITION); robot.torqueOn(1); }
void loop()
{
    int32_t now;

    robot.setGoalVelocity(1, 30, UNIT_RPM);
    robot.setGoalPosition(1, (int)millis(), UNIT_DEGREE);
    if (robot.getPresentPosition(1, &now, UNIT_DEGREE) && robot.getPresentVelocity(1, &now, UNIT_RPM))
        robot.ledOn(1);
    if (robot.readControlTableItem(ControlTableItem::MOVING, 1) == 1)
        robot.setID(1, 2);
}
""")
        for builder in (MEGA, UNO):
            elf = builder.sketch("integers", sketch)
            names = subprocess.check_output(["avr-nm", elf], text=True)
            self.assertIsNone(FLOATING_POINT.search(names))
        with_float = UNO.sketch("floats", sketch.replace("(int)millis()", "millis() * 0.1"))
        self.assertIsNotNone(FLOATING_POINT.search(
            subprocess.check_output(["avr-nm", with_float], text=True)))


class Installed(unittest.TestCase):
    """Examples and a sketch beside the core, with what make install has put into a prefix."""

    @classmethod
    def setUpClass(cls):
        cls.prefix = pathlib.Path(FOLDER.name) / "prefix"
        status, output = call("make", "-C", ROOT, "--no-print-directory", "install", f"PREFIX={cls.prefix}",
                              "MCUS=atmega2560", env={**os.environ, "MAKEFLAGS": ""})
        assert status == 0, output

    def test_examples_of_the_mega_built_with_the_core_pass(self):
        for name, servos in [("blink", "1"), ("wheels", "1,2"), ("hexapod", "1-18"), ("teach", "1-3")]:
            with self.subTest(name):
                folder = self.prefix / "share/cds55xx/examples" / name
                run = Run(MEGA.linked(folder / f"{name}.c", self.prefix, "arduino-mega"), board="arduino-mega",
                          servos=servos, script=(folder / f"{name}.script").read_text())
                self.assertEqual(run.status, 0, run.output)
                self.assertIn("rules:   none broken", run.output)

    def test_sketch_links_the_library_and_serial_works_beside_it(self):
        elf = MEGA.linked(SKETCHES / "linked.ino", self.prefix, "arduino-mega")
        run = Run(elf, "--seconds", "1.6", "--host", "stdout", board="arduino-mega", servos="1")
        self.assertEqual(run.status, 0, run.output)
        leds = [packet[18:20] for _, way, packet in run.packets if way == "->in"]
        self.assertEqual(leds, ["01", "00", "01"])
        said = [int(ms) for ms in re.findall(r"(\d+) ms", run.output)]
        self.assertEqual(len(said), 3, run.output)
        for ms, wanted in zip(said, (500, 1000, 1500)):
            self.assertAlmostEqual(ms, wanted, delta=10)


class Headers(unittest.TestCase):
    def test_each_public_header_compiles_beside_the_core(self):
        names = sorted(p.relative_to(ROOT / "include") for p in (ROOT / "include").rglob("*.h"))
        others = ["SoftwareSerial.h", "EEPROM.h", "SPI.h", "Wire.h"]
        for name in names:
            MEGA.check(f"#include <Arduino.h>\n#include <{name}>\n")
        for builder in (MEGA, UNO):
            for first, second in [(others, names), (names, others)]:
                builder.check("#include <Arduino.h>\n" + "".join(
                    f"#include <{name}>\n" for name in [*first, *second, "CDS55xx.h"]))

    def test_chip_that_is_not_supported_is_named(self):
        target = UNO.target
        UNO.target = ["-mmcu=atmega644p", *target[1:]]
        self.addCleanup(setattr, UNO, "target", target)
        with self.assertRaises(Failed) as failed:
            UNO.check("#include <CDS55xx.h>\n")
        self.assertIn("CDS55xx supports Uno and Nano (ATmega328P) and Mega (ATmega2560, ATmega1280)",
                      str(failed.exception))


class CommandLine(unittest.TestCase):
    def test_it_builds_a_sketch_that_the_simulator_runs(self):
        for board in "arduino-mega", "arduino-uno":
            with tempfile.TemporaryDirectory() as folder:
                sketch = pathlib.Path(folder, "blink.ino")
                sketch.write_text(ROBOT + "void setup() { robot.begin(1000000); robot.ledOn(1); }\nvoid loop() {}\n")
                status, output = call(sys.executable, ROOT / "scripts/arduino_core.py", sketch, "--board", board)
                self.assertEqual(status, 0, output)
                run = Run(pathlib.Path(output.strip()).resolve(), "--seconds", "1", board=board, servos="1")
                self.assertIn("03 19 01", run.transcript)

    def test_a_sketch_that_is_missing_or_wrong_is_named(self):
        status, output = call(sys.executable, ROOT / "scripts/arduino_core.py", "nosuch.ino")
        self.assertEqual((status, output), (1, "arduino_core.py: there is no file nosuch.ino\n"))
        with tempfile.NamedTemporaryFile(suffix=".ino") as sketch:
            sketch.write(b"\xff")
            sketch.flush()
            status, output = call(sys.executable, ROOT / "scripts/arduino_core.py", sketch.name)
        self.assertEqual(status, 1)
        self.assertRegex(output, rf"^arduino_core.py: {sketch.name} cannot be read: .*; name a sketch in UTF-8\n$")

    def test_target_that_cannot_be_written_is_one_line(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "scripts").mkdir()
            shutil.copy(ROOT / "scripts/arduino_core.py", root / "scripts")
            (root / "build").write_text("a file, where the folder has to be")
            (root / "a.ino").write_text("")
            status, output = call(sys.executable, root / "scripts/arduino_core.py", root / "a.ino")
        self.assertEqual(status, 1)
        self.assertRegex(output, rf"^arduino_core.py: {folder}/build/\S+: Not a directory; the sketch is built in {folder}/build/.*\n$")


class Archive(unittest.TestCase):
    def test_it_holds_the_sources_of_the_tree_and_nothing_else(self):
        with zipfile.ZipFile(ARCHIVE) as packed:
            names = {name.removeprefix("CDS55xx/") for name in packed.namelist()}
            properties = packed.read("CDS55xx/library.properties").decode()
        self.assertEqual(names, set(arduino.files()))
        for folder in ["src/core", "include"]:
            for path in (ROOT / folder).rglob("*.[ch]"):
                self.assertTrue(any(name.endswith(f"/{path.name}") for name in names), path)
        self.assertIn(f"version={arduino.version()}\n", properties)

    def test_every_include_of_ours_is_relative(self):
        for name, text in arduino.files().items():
            for include in re.findall(r'^\s*#\s*include\s*"([^"]+)"', text, re.M):
                target = (pathlib.Path("/") / name).parent / include
                self.assertIn(str(pathlib.Path(*target.parts).resolve()).lstrip("/"),
                              arduino.files(), f"{name}: {include}")

    def test_every_link_of_a_document_leads_to_a_file(self):
        files = arduino.files()
        for name in [name for name in files if name.endswith(".md")]:
            for target in re.findall(r"\]\(([^)#]+)", files[name]):
                self.assertIn((pathlib.PurePosixPath(name).parent / target).as_posix(), files, name)

    def test_the_same_sources_give_the_same_bytes(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("a.zip", "b.zip"):
                subprocess.run([ROOT / "scripts/arduino.py", f"{folder}/{name}"], check=True)
            a, b = (pathlib.Path(folder, name).read_bytes() for name in ("a.zip", "b.zip"))
        self.assertEqual(a, b)

    def test_archive_that_cannot_be_written_is_one_line(self):
        with tempfile.NamedTemporaryFile() as file:
            self.assertEqual(call(ROOT / "scripts/arduino.py", f"{file.name}/arduino/x.zip"),
                             (1, f"arduino.py: {file.name}/arduino: Not a directory\n"))

    def test_keywords_has_each_name_of_the_class(self):
        text = (ROOT / "arduino/CDS55xx.h").read_text()
        public = text[text.index("class CDS55xx\n"):]
        public = public[:public.index("  private:")]
        public = re.sub(r"/\*.*?\*/", "", public, flags=re.S)
        methods = set(re.findall(r"^    \w[\w ]*[ &](\w+)\(", public, re.M)) - {"CDS55xx"}
        registers = set(re.findall(r"^    (\w+) = CDS_REG_", text, re.M))
        rows = dict(line.split("\t") for line in
                    (ROOT / "arduino/keywords.txt").read_text().splitlines() if "\t" in line)
        self.assertIn("setGoalPosition", methods)
        self.assertIn("GOAL_POSITION", registers)
        self.assertEqual({name for name, kind in rows.items() if kind == "KEYWORD2"}, methods)
        self.assertLessEqual(registers, {name for name, kind in rows.items() if kind == "LITERAL1"})
        documented = (ROOT / "docs/arduino.md").read_text()
        for method in methods:
            self.assertIn(f"`{method}(", documented)


if __name__ == "__main__":
    unittest.main()
