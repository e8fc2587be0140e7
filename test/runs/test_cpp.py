# SPDX-License-Identifier: MIT
"""Programs in C++11 (test/firmware/library/cpp*.cpp) and all headers, on boards with different handlers."""
# needs: $(patsubst %,build/lib/libcds55xx-%.a,atmega128 atmega2560 atmega644p)
import pathlib
import tempfile
import unittest

from simulator import ROOT, Run, call as run

CHIPS = {"atmega128": "atmega128", "arduino-mega": "atmega2560", "arbotix": "atmega644p"}
WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror"]


def compiler(board, standard):
    return ["avr-g++", f"-mmcu={CHIPS[board]}", "-DF_CPU=16000000UL", f"-std={standard}", "-Os",
            "-flto", "-Wl,--relax", "-Wl,--gc-sections", *WARNINGS, "-Iinclude",
            f"-Iboards/{board}"]


class Cpp(unittest.TestCase):
    def test_all_headers_at_once(self):
        headers = sorted(p.relative_to(ROOT / "include") for p in (ROOT / "include").rglob("*.h"))
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "all.cpp"
            source.write_text("".join(f"#include <{h}>\n" for h in headers) +
                              (ROOT / "test/firmware/library/cpp.cpp").read_text())
            for standard in ["c++11", "gnu++14"]:
                self.assertEqual(run(*compiler("arduino-mega", standard), "-c", source, "-o",
                                     "/dev/null", cwd=ROOT), (0, ""))

    def test_it_links_and_talks_to_its_servos(self):
        with tempfile.TemporaryDirectory() as folder:
            for board in CHIPS:
                elf = f"{folder}/{board}.elf"
                self.assertEqual(run(*compiler(board, "c++11"), "test/firmware/library/cpp.cpp",
                                     f"build/lib/libcds55xx-{CHIPS[board]}.a", "-o", elf, cwd=ROOT), (0, ""))
                done = Run(elf, "--seconds", "0.05", board=board, servos="1-3")
                self.assertEqual(done.status, 0, done.output)
                self.assertIn("rules:   none broken", done.output)
                self.assertEqual([packet for _, _, packet in done.packets], [
                    "FF FF 02 04 02 03 01 F3", "FF FF 02 03 00 02 F8",
                    "FF FF 02 04 03 19 01 DC", "FF FF 02 02 00 FB",
                    "FF FF FE 0E 83 1E 04 01 BC 02 00 02 02 2C 01 00 02 5C"])

    def test_joint_name_of_nine_characters_does_not_compile(self):
        for compile_ in [["avr-gcc", "-std=gnu99", "-x", "c"], ["avr-g++", "-std=c++11", "-x", "c++"]]:
            for name, fits in [("12345678", True), ("123456789", False)]:
                with tempfile.NamedTemporaryFile("w", suffix=".c") as source:
                    source.write("#include <cds55xx/robot.h>\nextern const struct cds_joint row;\n"
                                 "const struct cds_joint row = CDS_JOINT(1, CDS_FORWARD, 150000, -90000, "
                                 f'90000, 31000, CDS_JOINT_CDS55XX, "{name}");\n')
                    source.flush()
                    status, said = run(*compile_, "-mmcu=atmega128", "-DF_CPU=16000000UL", *WARNINGS,
                                       "-Iinclude", "-c", source.name, "-o", "/dev/null", cwd=ROOT)
                    self.assertEqual(status == 0, fits, said)

    def test_robot_reads_its_table_in_flash(self):
        with tempfile.TemporaryDirectory() as folder:
            for board in CHIPS:
                elf = f"{folder}/{board}.elf"
                self.assertEqual(run(*compiler(board, "c++11"), "test/firmware/library/cpp_robot.cpp",
                                     f"build/lib/libcds55xx-{CHIPS[board]}.a", "-o", elf, cwd=ROOT), (0, ""))
                done = Run(elf, "--seconds", "0.05", board=board, servos="1,2")
                self.assertEqual(done.status, 0, done.output)
                # 20 degrees: 580 of servo 1, 443 of servo 2, which is reversed; 31 RPM
                goals = [packet for _, _, packet in done.packets if " 83 1E " in packet]
                self.assertEqual(goals[-1],
                                 "FF FF FE 0E 83 1E 04 01 44 02 00 02 02 BB 01 00 02 45")


if __name__ == "__main__":
    unittest.main()
