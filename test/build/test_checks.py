# SPDX-License-Identifier: MIT
"""The project's own checks notice what they are for."""
# needs: $(BOARDS:%=build/%/controller.elf) build/lib/libcds55xx-atmega128.a
import collections
import contextlib
import io
import os
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "test/runs"), str(ROOT / "scripts")]

import boards
from simulator import SIM, call as run
import elf


class Layering(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        for name in ["include", "src", "sim", "boards", "examples", "arduino"]:
            shutil.copytree(ROOT / name, self.root / name)

    def tearDown(self):
        self.folder.cleanup()

    def breach(self, file, line):
        with open(self.root / file, "a") as source:
            source.write(line + "\n")
        status, output = run(sys.executable, ROOT / "scripts/layering.py", self.root)
        self.assertEqual(status, 1, output)
        self.assertIn(file, output)

    def test_the_tree_as_it_is_passes(self):
        self.assertEqual(run(sys.executable, ROOT / "scripts/layering.py", self.root), (0, ""))

    def test_core_must_not_include_an_avr_header(self):
        self.breach("src/core/bus/bus.c", "#include <avr/io.h>")

    def test_core_must_not_know_a_register_or_the_clock(self):
        self.breach("src/core/wire/link.c", "int x = UCSR1B;")
        self.breach("include/cds55xx/bus.h", "#define X (F_CPU / 8)")

    def test_arduino_class_must_not_know_an_internal_header(self):
        self.breach("arduino/CDS55xx.cpp", '#include "bus/bus_internal.h"')

    def test_core_must_not_know_a_board(self):
        self.breach("src/core/bus/bus.c", '#include "board.h"')

    def test_controller_must_not_know_a_register(self):
        self.breach("src/controller/console/console.c", "int x = UCSR0A;")

    def test_controller_includes_public_headers_of_the_library(self):
        self.breach("src/controller/main.c", '#include "bus/bus_internal.h"')
        self.breach("src/controller/robot/robot.c", '#include "cds55xx/avr/handlers.h"')
        self.breach("src/controller/host/bridge.c", '#include "board.h"')
        self.breach("examples/robot.c", '#include "compiler.h"')

    def test_avr_port_includes_no_more_of_the_core_than_the_seam(self):
        self.breach("include/cds55xx/avr/usart.h", '#include "cds55xx/bus.h"')

    def test_a_lower_layer_includes_no_higher_one(self):
        self.breach("src/core/wire/parser.c", '#include "cds55xx/bus.h"')
        self.breach("include/cds55xx/bus.h", '#include "cds55xx/servos.h"')
        self.breach("src/core/safety/servos.c", '#include "cds55xx/scan.h"')
        self.breach("src/core/safety/permit.c", '#include "cds55xx/cycle.h"')
        self.breach("src/core/wire/packet.c", '#include "cds55xx/units.h"')

    def test_a_lower_folder_of_the_controller_includes_no_higher_one(self):
        self.breach("src/controller/avr/memory.c", '#include "robot/robot.h"')
        self.breach("src/controller/robot/robot.c", '#include "console/errors.h"')
        self.breach("src/controller/robot/failsafe.c", '#include "host/host_demux.h"')
        self.breach("src/controller/host/bridge.c", '#include "console/console.h"')

    def test_a_header_or_folder_without_a_storey_is_told(self):
        (self.root / "src/core/new").mkdir()
        self.breach("include/cds55xx/new.h", "")
        self.assertIn("src/core/new: no storey", run(sys.executable, ROOT / "scripts/layering.py",
                                                     self.root)[1])

    def test_simulator_includes_nothing_of_the_library(self):
        self.breach("sim/wire/codec.c", '#include "cds55xx/packet.h"')
        self.breach("sim/servo/servo.c", '#include "../include/cds55xx/packet.h"')

    def test_boards_hold_no_code(self):
        self.breach("boards/atmega128/board.h", "static inline int f(void) { return 1; }")

    def test_only_packet_h_says_what_a_header_is(self):
        self.breach("src/core/wire/parser.c", "#define HEADER 0xFF")


    def test_the_library_waits_for_nothing(self):
        self.breach("src/core/service/scan.c", "static void f(void) { cds_blocking_for(0, 0, CDS_OK); }")
        self.breach("include/cds55xx/avr/clock.h", "#include <util/delay.h>")


class MachineCode(unittest.TestCase):
    """scripts/elf.py, on objects compiled here."""

    def check(self, code, name="bus", *options):
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / f"{name}.c"
            source.write_text("#include <avr/interrupt.h>\n#include <avr/io.h>\n#include <stdint.h>\n"
                              "extern volatile uint32_t a, b;\nvoid other(void);\n" + code)
            out = pathlib.Path(folder) / f"{name}.o"
            done = run("avr-gcc", "-mmcu=atmega128", "-DF_CPU=16000000UL", "-std=gnu99", "-Os", *options,
                       *([] if options else ["-ffunction-sections", "-c"]), source, "-o", out)
            self.assertEqual(done, (0, ""))
            told = io.StringIO()
            with contextlib.redirect_stdout(told):
                return elf.main([out]), told.getvalue()

    def breach(self, code, complaint, name="bus", *options):
        status, output = self.check(code, name, *options)
        self.assertEqual(status, 1, output)
        self.assertIn(complaint, output)

    def test_good_code_passes(self):
        self.assertEqual(self.check("""
            static volatile uint16_t counter;
            struct item { struct item *next; void (*on_end)(struct item *); };
            uint16_t cds_link_count(void)
            {
                uint16_t first, second = counter;
                do {
                    first = second;
                    second = counter;
                } while (first != second);
                return first * 10u;
            }
            void cds_bus_poll(struct item *item)
            {
                volatile uint8_t room[20];
                for (uint8_t i = 0; i < 20; i++)
                    room[i] = UDR1;
                while (item->next)
                    item = item->next;
                item->on_end(item);
            }
            uint32_t cds_units_to_register(void) { return a / b; }"""), (0, ""))

    def test_nothing_to_check_does_not_pass(self):
        self.assertEqual(self.check("uint8_t x;")[0], 1)

    def test_recursion(self):
        self.breach("uint8_t f(uint8_t n) { return n ? f(n - 1) * f(n >> 1) : 1; }", "f: is recursive")

    def test_recursion_by_way_of_jumps(self):
        self.breach("""void g(uint8_t n);
            __attribute__((noinline)) void f(uint8_t n) { PORTA = n; g(n); }
            __attribute__((noinline)) void g(uint8_t n) { PORTB = n; f(n); }""", "g: is recursive")

    def test_recursion_by_way_of_a_pointer(self):
        self.breach("""void cds_bus_poll(void (**f)(void)) { (*f)(); other(); }
            static void again(void) { cds_bus_poll(0); other(); }
            void cds_bus_set(void (**f)(void)) { *f = again; }""", "cds_bus_poll: is recursive")
        self.breach("""void cds_bus_poll(void (**f)(void)) { (*f)(); other(); }
            static void again(void) { cds_bus_poll(0); other(); }
            void (*const table[])(void) = {again};""", "cds_bus_poll: is recursive")

    def test_calls_through_a_pointer_are_for_the_bus_only(self):
        self.breach("void f(void (**p)(void)) { (*p)(); other(); }",
                    "scan.o: f: calls through a pointer", "scan")

    def test_floating_point(self):
        self.breach("uint32_t f(void) { return a * 0.5f; }", "f: uses floating point: f -> __")

    def test_division_on_the_hot_path(self):
        self.breach("void cds_bus_poll(void) { a = a / b; }",
                    "cds_bus_poll: divides on the hot path: cds_bus_poll -> __udivmodsi4")
        self.breach("""__attribute__((noinline)) void cds_units_to_register(void) { a = a / b; }
            void cds_bus_submit(void) { cds_units_to_register(); other(); }""",
                    "hot path: cds_bus_submit -> cds_units_to_register -> __udivmodsi4")

    def test_division_of_16_and_64_bits(self):
        self.breach("uint16_t cds_link_talk(uint16_t n, uint16_t m) { return n / m; }",
                    "divides on the hot path: cds_link_talk -> __udivmodhi4")
        self.breach("int64_t cds_servo_ping(int64_t n, int64_t m) { return n % m; }",
                    "divides on the hot path: cds_servo_ping -> __moddi3")

    def test_allocation(self):
        self.breach("#include <stdlib.h>\nvoid *f(void) { return malloc(a); }", "f: allocates: f -> malloc")

    def test_busy_waiting(self):
        for loop in ["while (!(UCSR1A & 1 << UDRE1)) { }", "while (!(PINB & 4)) { }", "while (a) { }",
                     "loop_until_bit_is_set(UCSR1A, 5);", "for (;;) { }"]:
            self.breach("void f(void) { " + loop + " }", "only tests")

    def test_busy_waiting_for_what_a_pointer_points_to(self):
        self.breach("void f(volatile uint8_t *p) { other(); while (*p == 1) { } other(); }", "only tests")

    def test_busy_waiting_within_a_loop(self):
        self.breach("void f(uint8_t n) { for (; n; n--) { while (!(UCSR1A & 32)) { } UDR1 = n; } }",
                    "only tests")

    def test_delays(self):
        self.breach("#include <util/delay.h>\nvoid f(void) { _delay_us(3); }", "only counts")
        self.breach("#include <util/delay.h>\nvoid f(void) { _delay_ms(30); }", "only counts")

    def test_waiting_for_the_clock_or_by_polling(self):
        self.breach("uint32_t cds_port_now_us(void); void f(uint32_t t) { while (cds_port_now_us() < t) { } }",
                    "calls cds_port_now_us()")
        self.breach("uint8_t cds_bus_poll(void); void f(void) { while (cds_bus_poll()) { } }",
                    "calls cds_bus_poll()")

    def test_waiting_as_a_caller_may(self):
        self.breach("void cds_blocking_for(void); void f(void) { cds_blocking_for(); other(); }", "f: waits")

    def test_interrupts_off_and_sleep(self):
        self.breach("void f(void) { cli(); a = 1; sei(); }", "f: turns interrupts off")
        self.breach("void f(void) { uint8_t s = SREG; cli(); other(); SREG = s; }",
                    "f: turns interrupts off")
        self.breach("void f(void) { uint8_t s = SREG; cli(); while (a) { } SREG = s; }",
                    "f: turns interrupts off")

    def test_interrupts_off_for_a_moment(self):
        status, output = self.check(
            "void f(uint8_t m) { uint8_t s = SREG; cli(); PORTA |= m; SREG = s; }")
        self.assertEqual(status, 0, output)
        handler = ("ISR(USART1_RX_vect, ISR_NAKED) "
                   "{ __asm__ volatile(\"cli\\n\\t%s pop r24\\n\\treti\"); }")
        status, output = self.check(handler % "")
        self.assertEqual(status, 0, output)
        self.breach(handler % "1: sbis 5, 0\\n\\trjmp 1b\\n\\t", "__vector_30: turns interrupts off")
        self.breach("void f(void) { __asm__ volatile(\"sleep\"); }", "f: sleeps")

    def test_a_handler_of_a_linked_program(self):
        self.breach("""volatile uint32_t a, b;
            ISR(USART1_RX_vect) { a = a / b; }
            int main(void) { for (;;) a = b / a; }""", "__vector_30: divides on the hot path",
                    "program", "-flto")


class Scripts(unittest.TestCase):
    def test_a_gem_that_does_not_come_is_told_from_a_wrong_one(self):
        """gem may fail with status 0, as without certificates."""
        wrong = 'mkdir "$3/cache" && echo x > "$3/cache/$6-$8.gem"'  # gem install --install-dir DIR ...
        for gem, complaint in [("echo 'ERROR: SSL' >&2", "could not be fetched; without the network: make UNITY=dir"),
                               ("exit 2", "could not be fetched; without the network: make UNITY=dir"),
                               (wrong, "is not the one we know (SHA-256 differs)")]:
            with tempfile.TemporaryDirectory() as folder:
                stub = pathlib.Path(folder) / "gem"
                stub.write_text(f"#!/bin/sh\n{gem}\n")
                stub.chmod(0o755)
                status, output = run(ROOT / "scripts/deps.sh", "unity", env={
                    **os.environ, "PATH": f"{folder}:{os.environ['PATH']}", "DEPS": "yes",
                    "UNITY": f"{folder}/unity"})
                self.assertEqual(status, 1, output)
                self.assertIn(complaint, output.splitlines()[-1])
                self.assertFalse(os.path.exists(f"{folder}/unity"))

    def test_a_firmware_over_budget_fails_the_size_check(self):
        elf = ROOT / "build/atmega128/controller.elf"
        flash, ram = re.findall(r"^(?:FLASH|RAM)_MAX *:= (\d+)$",
                                (ROOT / "boards/atmega128/board.mk").read_text(), re.M)
        self.assertEqual(run(ROOT / "scripts/size.py", elf, flash, ram)[0], 0)
        for limits in [("100", ram), (flash, "100")]:
            status, output = run(ROOT / "scripts/size.py", elf, *limits)
            self.assertEqual(status, 1)
            self.assertIn("OVER BUDGET", output)

    def test_no_two_files_give_a_message_the_same_name(self):  # the map finds no file for such a message
        names = collections.Counter(name for source in (ROOT / "src").rglob("*.c") for name in re.findall(
            r"^(?:static )?const CDS_FLASH char (message_\w+)", source.read_text(), re.M))
        self.assertGreater(len(names), 100)
        self.assertEqual([name for name, count in names.items() if count > 1], [])

    def test_the_map_of_the_flash_has_all_of_it_and_each_byte_once(self):
        elf = ROOT / "build/atmega128/controller.elf"
        status, output = run(ROOT / "scripts/size-map.py", elf)
        self.assertEqual(status, 0, output)
        rows = re.findall(r"^ *(\d+) +(\d+|-)  ( *)(.+)$", output, re.M)
        flash = {name: int(size) for size, _, _, name in rows}
        tables = {name: int(size) for _, size, _, name in rows if size != "-"}
        text, data = map(int, run("avr-size", elf)[1].splitlines()[1].split()[:2])
        self.assertEqual(flash.pop("in all"), text + data)
        folders = [name for _, _, inner, name in rows[:-1] if not inner]
        self.assertEqual(sum(flash[name] for name in folders), text + data)
        files = sum(int(size) for size, _, inner, _ in rows if inner)  # two folders may each have a bus.c
        self.assertEqual(files, sum(flash[name] for name in folders if "/" in name))
        self.assertTrue(0 < tables["printer.c"] < flash["printer.c"], output)
        self.assertGreater(flash["strings in tables"], 5000, output)
        self.assertNotIn("torque_off.c", tables)
        self.assertTrue({"bus.c", "torque_off.c", "console.c", "serial.c", "ring.h"} < set(flash), output)
        # Functions of libgcc and vectors: if a hundredth of the flash has no source, the map has lost a file.
        self.assertLess(flash["compiler and C library"] + flash["vectors and start-up"], (text + data) / 100, output)


class Links(unittest.TestCase):
    def links(self, text):
        with tempfile.NamedTemporaryFile("w", suffix=".md") as file:
            file.write("# A title\n" + text)
            file.flush()
            return run(ROOT / "scripts/links.py", file.name, cwd=ROOT)

    def complaint(self, text, complaint):
        status, output = self.links(text)
        self.assertEqual(status, 1, text)
        self.assertEqual(output.count("\n"), 1, output)
        self.assertIn(complaint, output)

    def test_good_links_pass(self):
        root = os.path.relpath(ROOT, tempfile.gettempdir())
        for text in ["[a](#a-title) [c](https://x.y/z)", f"[b]({root}/README.md#map)",
                     f"[b](<{root}/README.md#map> 'the map')", f"![b]({root}/docs/img/bus.svg)",
                     f"[folder]({root}/docs/) `docs/` `src/core/bus/bus.c` `src/core/*/bus.c`",
                     "[a][label] [label][]\n\n[label]: #a-title\n",
                     "<a id='here'></a> [a](#here)", "## Twice\n## Twice\n[a](#twice-1)",
                     "## [b](#a-title) and `c`\n[a](#b-and-c)", "Under\n=====\n[a](#under)",
                     "`[a](gone.md)`", "1. a\n\n   ```c\n   [a](gone.md)\n   ```\n"]:
            self.assertEqual(self.links(text), (0, ""), text)

    def test_a_missing_file_is_named(self):
        for text in ["[a](gone.md)", "[a](gone.md 'title')", "[a](<gone.md>)", "![a](gone.md)",
                     "[![a](https://x.y/z)](gone.md)", "[a][b]\n\n[b]: gone.md\n",
                     "<a href='gone.md'>a</a>", '<img alt="a"\n  src="gone.md">', "[a](gone.md#b)"]:
            self.complaint(text, "gone.md")
        self.complaint(f"[a]({ROOT}/README.md)", "README.md: there is no such file")
        for name in ["src/core/gone.c", "docs/gone.md", "panel/gone.mjs", "packaging/gone.in", "arduino/gone.h"]:
            self.complaint(f"`{name}`", f"{name}: there is no such file")

    def test_a_file_that_is_not_in_git_is_named(self):
        root = os.path.relpath(ROOT, tempfile.gettempdir())
        self.complaint(f"[a]({root}/build/lib/libcds55xx-atmega128.a)", "there is no such file")

    def test_a_missing_heading_or_label_is_named(self):
        root = os.path.relpath(ROOT, tempfile.gettempdir())
        for text in ["[a](#gone)", f"[a]({root}/README.md#gone)", f"[a]({root}/Makefile#gone)",
                     f"[a]({root}/docs#gone)", "## Once\n[a](#once-1)",
                     "   ~~~\n# gone\n   ~~~\n[a](#gone)"]:
            self.complaint(text, "there is no such heading")
        self.complaint("[a][gone]", "[gone]: there is no such label")


class Readme(unittest.TestCase):
    def test_readme_command_line_builds_a_program_outside_the_tree(self):
        """The command line of "Link the library", word for word but for the folder."""
        text = (ROOT / "docs/library.md").read_text()
        command = re.search(r"```sh\n(avr-gcc (?:.*\\\n)*.*)\n```", text)[1]
        with tempfile.TemporaryDirectory() as folder:
            shutil.copy(ROOT / "examples/two_servos.c", f"{folder}/robot.c")
            command = command.replace("robot.c", f"{folder}/robot.c")
            command = command.replace("robot.elf", f"{folder}/robot.elf")
            self.assertEqual(run("sh", "-c", command, cwd=ROOT), (0, ""))
            status, output = run(SIM, "firmware", f"{folder}/robot.elf", "--board", "atmega128",
                                 "--servos", "1,2", "--seconds", "2.5")
        self.assertEqual(status, 0, output)
        self.assertIn("3 packets in, 0 out, 0 damaged", output)

    def test_pause_and_speed_of_motion_md_compile_in_timed_move(self):
        text = (ROOT / "docs/motion.md").read_text()
        block = re.search(r"### Pause a move.*?```c\n(.*?)```", text, re.S)[1]
        program = (ROOT / "examples/timed_move.c").read_text().replace("int main(void)", f"{block}\nint main(void)")
        program = program.replace("        stop_report_poll(&robot);\n", "stop_report_poll(&robot);\nobey('p');\n")
        self.assertEqual(program.count("obey("), 2)
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "paused.c").write_text(program)
            self.assertEqual(run("avr-gcc", "-mmcu=atmega128", "-DF_CPU=16000000UL", "-std=gnu99", "-Os", "-Wall", "-Wextra", "-Werror",
                                 "-Iinclude", "-Iexamples", "-Iboards/atmega128", "-fsyntax-only", f"{folder}/paused.c", cwd=ROOT), (0, ""))

    def test_bytes_from_the_pc_of_motion_md_reach_a_moving_robot(self):
        text = (ROOT / "docs/motion.md").read_text()
        obey = re.search(r"### Pause a move.*?```c\n(.*?)```", text, re.S)[1]
        block = re.search(r"### Bytes from the PC.*?```c\n(.*?)```", text, re.S)[1]
        program = (ROOT / "examples/timed_move.c").read_text().replace("int main(void)", f"{obey}\n{block}\nint main(void)")
        program = program.replace("    sei();\n", "    pc_open();\n    sei();\n")
        program = program.replace("        stop_report_poll(&robot);\n", "stop_report_poll(&robot);\nif (UCSR0A & 1 << UDRE0)\npc_poll();\n")
        program = program.replace("obey((char)ring[ring_begin]);", "obey((char)ring[ring_begin]); UDR0 = ring[ring_begin];")  # an echo
        with tempfile.TemporaryDirectory() as folder:
            said = pathlib.Path(folder, "pc.said")
            said.write_text(f"wait 1500000\ntext {50 * 'x'}\nhear 51 within 100\n")
            output = self.assert_runs(folder, program, "2", "--host", said)
        self.assertEqual(re.search(r"heard \d+ \d+ 51 (.*)", output)[1].split(), 50 * ["78"] + ["0D"])

    def test_joint_without_torque_of_library_md_leads(self):
        """The functions of "One joint without torque" and "Keep something in the EEPROM", in two_joints.c."""
        text = (ROOT / "docs/library.md").read_text()
        blocks = [re.search(rf"### {name}.*?```c\n(.*?)```", text, re.S)[1]
                  for name in ("One joint without torque", "Keep something in the EEPROM")]
        program = (ROOT / "examples/two_joints.c").read_text()
        program = re.sub(r"        for \(uint8_t i[^\n]*\n *cds_robot_set_goal[^\n]*\n", "        follow(), poll_eeprom();\n", program, flags=re.S)
        program = re.sub(r"(    cds_robot_open.*\n)", r"\1    robot.on_event = on_event;\n    kept_size = 0;\n", program)
        program = program.replace("int main(void)", "\n".join(blocks) + "\nint main(void)")
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder, "lead.script")
            script.write_text("@expect servo 2 torque on within 3000\n@wait 20\n@expect servo 1 torque off\n@load 1 60\n@wait 4000\n"
                              "@expect servo 2 torque on\n@show servo 1-2 PRESENT_POSITION\n"
                              "@fault brownout 2 1\n@expect servo 2 torque off within 2000\n")
            output = self.assert_runs(folder, "#include <avr/eeprom.h>\n#include <cds55xx/servo.h>\n" + program, "2", "--script", script)
        lever, follower = [int(value) for value in re.findall(r"PRESENT_POSITION (\d+)", output)]
        self.assertLess(lever, 450) # 512 at the start
        self.assertGreater(lever + follower, 1023 - 10)  # joint 1 is reversed
        self.assertLess(lever + follower, 1023 + 10)

    def test_program_of_the_readme_stops_in_a_slow_main_loop(self):
        """A servo without power is found with turns of 2 ms; with turns of 5 ms no feedback is read."""
        program = "#include <util/delay.h>\n" + (ROOT / "examples/two_joints.c").read_text()
        for ms, script in [(2, "@wait 2000\n@expect servo 1 torque on\n@power 2 off\n@expect servo 1 torque off within 500\n"),
                           (5, "@expect servo 1-2 torque off within 1000\n")]:
            with self.subTest(ms=ms), tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder, "slow.script")
                path.write_text("@expect servo 1-2 torque on within 5000\n" + script)
                slow = program.replace("for (;; cds_robot_poll", f"for (;; _delay_ms({ms}), cds_robot_poll")
                self.assert_runs(folder, slow, "2", "--script", path)

    def assert_runs(self, folder, program, servos, *options):
        pathlib.Path(folder, "own.c").write_text(program)
        self.assertEqual(run("avr-gcc", "-mmcu=atmega128", "-DF_CPU=16000000UL", "-std=gnu99", "-Os", "-flto", "-Wall", "-Wextra",
                             "-Werror", "-Wl,--relax", "-Wl,--gc-sections", "-Iinclude", "-Iexamples", "-Iboards/atmega128",
                             f"{folder}/own.c", "build/lib/libcds55xx-atmega128.a", "-o", f"{folder}/own.elf", cwd=ROOT), (0, ""))
        status, output = run(SIM, "firmware", f"{folder}/own.elf", "--board", "atmega128", "--servos", f"1-{servos}", *options)
        self.assertEqual(status, 0, output)
        return output

    def play(self, turn, script):
        """The code of "Play once, pause, change the speed", in keyframes.c: `turn` is called in each turn of the main loop
        while the robot runs or has stopped, with the time since then."""
        text = (ROOT / "docs/library.md").read_text()
        block = re.search(r"### Play once, pause.*?```c\n(.*?)```", text, re.S)[1]
        program = (ROOT / "examples/keyframes.c").read_text()
        unused = '#pragma GCC diagnostic ignored "-Wunused-function"\n'
        program = unused + re.sub(r"static void on_event\(.*?\n}\n", lambda _: block + f"""
            static void turn(bool is_running, uint32_t ms)
            {{
                static uint8_t stage;
                {turn}
            }}""", program, count=1, flags=re.S)
        program = program.replace("        cds_robot_poll(&robot);\n", """
            static uint32_t from_us;
            static bool was_running;
            cds_robot_poll(&robot);
            bool is_running = robot.state == CDS_ROBOT_RUNNING;
            if (is_running != was_running)
                from_us = cds_port_now_us();
            was_running = is_running;
            if (is_running || robot.state == CDS_ROBOT_STOPPED)
                turn(is_running, (cds_port_now_us() - from_us) / 1000);
            """)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "play.script")
            path.write_text("@expect servo 1-3 torque on within 3000\n" + script)
            return self.assert_runs(folder, program, "3", "--script", path, "--host", "stdout")

    def test_motion_calls_of_library_md_play_once_with_a_pause(self):
        output = self.play("""
            if (is_running && stage == 0 && play_at(150) == CDS_OK && play_once() == CDS_OK)
                stage = 1;
            if (stage == 1 && ms > 1500)
                pause_motion(), stage = 2;
            if (stage == 2 && ms > 4500)
                go_on(), stage = 3;
            if (stage == 3 && has_ended())
                cds_robot_stop(&robot), stage = 4;
            """, "@wait 4000\n@expect servo 1-3 torque on within 0\n@expect servo 1-3 torque off within 6000\n@wait 100\n")
        self.assertIn("stopped by the program", output)  # once all steps are over

    def test_play_once_of_library_md_is_busy_in_a_rest(self):
        self.play("""
            if (is_running && stage == 0 && play_once() == CDS_OK)
                stage = 1;
            if (stage == 1 && ms > 1750) // the joints rest at the first pose from 1.5 s to 2 s
                stage = motion.result == CDS_OK && play_once() == CDS_BUSY ? 2 : 3;
            if (stage == 3)
                cds_robot_stop(&robot), stage = 4;
            """, "@wait 3000\n@expect servo 1-3 torque on within 0\n")

    def test_play_once_of_library_md_stops_if_a_joint_is_pushed(self):
        output = self.play("""
            if (is_running && stage == 0 && play_once() == CDS_OK)
                stage = 1;
            (void)ms;
            """, "@wait 1500\n@load 1 1020\n@expect servo 1-3 torque off within 5000\n@wait 100\n")
        self.assertRegex(output, r"step \d: servo 1 \(joint 0, base\): does not follow its goals: blocked or pushed away")

    def test_end_of_library_md_brakes_and_torque_stays_on(self):
        """Ends in mid-motion; once has_ended() is true, the next sequence may begin."""
        output = self.play("""
            static uint32_t end_ms;
            if (is_running && stage == 0 && play_once() == CDS_OK)
                stage = 1;
            if (stage == 1 && ms > 2500)
                end_motion(), end_ms = ms, stage = 2;
            if (stage == 2 && has_ended())
                stage = ms - end_ms > 100 && ms - end_ms < 500 && play_once() == CDS_OK ? 3 : 4;
            if (stage == 4)
                cds_robot_stop(&robot), stage = 5;
            if (stage == 3 && has_ended())
                stage = 5;
            """, "@wait 12000\n@expect servo 1-3 torque on within 0\n@show servo 1-3 GOAL_POSITION\n")
        self.assertEqual(re.findall(r"GOAL_POSITION (\d+)", output), ["375", "307", "358"])

    def test_robot_of_library_md_stopped_amid_a_sequence_plays_when_told(self):
        """Also a sequence that is begun while the robot is stopped does not play at its start."""
        output = self.play("""
            if (is_running && stage == 0 && play_once() == CDS_OK)
                stage = 1;
            if (stage == 1 && ms > 2500)
                cds_robot_stop(&robot), stage = 2;
            if (stage == 2 && !is_running && ms > 1000 && play_once() == CDS_OK && cds_robot_start(&robot) == CDS_OK)
                stage = 3;
            if (stage == 3 && is_running && ms > 3000 && play_once() == CDS_OK)
                stage = 4;
            """, "@expect servo 1-3 torque off within 4000\n@expect servo 1-3 torque on within 3000\n@wait 100\n"
            "@show servo 1-3 GOAL_POSITION\n@wait 2500\n@show servo 1-3 GOAL_POSITION\n@wait 8000\n"
            "@expect servo 1-3 torque on within 0\n@show servo 1-3 GOAL_POSITION\n")
        goals = re.findall(r"GOAL_POSITION (\d+)", output)
        self.assertEqual(goals[:3], goals[3:6])
        self.assertEqual(goals[6:], ["375", "307", "358"])
        self.assertIn("stopped by the program", output)

    def test_program_and_library_for_two_chips_do_not_link(self):
        for chip, board, flags in [("atmega2560", "arduino-mega", ["-flto"]),
                                   ("atmega1284p", "arbotix", ["-fno-lto"])]:  # avr51, as atmega128
            with tempfile.TemporaryDirectory() as folder:
                status, output = run("avr-gcc", f"-mmcu={chip}", "-DF_CPU=16000000UL", "-std=gnu99",
                                     "-Os", *flags, "-Iinclude", f"-Iboards/{board}",
                                     "examples/two_servos.c", "build/lib/libcds55xx-atmega128.a", "-o",
                                     f"{folder}/robot.elf", cwd=ROOT)
            self.assertNotEqual(status, 0)
            self.assertEqual(re.findall(r"undefined reference to `(.*)'", output), [
                "cds55xx_library_is_for_atmega128_but_program_is_for_" + chip])

    def test_unoptimised_programs_are_refused_with_the_remedy(self):
        status, output = run("avr-gcc", "-mmcu=atmega128", "-DF_CPU=16000000UL", "-O0", "-Iinclude",
                             "-Iboards/atmega128", "-c", "examples/two_servos.c", "-o",
                             "/dev/null", cwd=ROOT)
        self.assertNotEqual(status, 0)
        self.assertIn("compile with -Os", output)


class Turnaround(unittest.TestCase):
    def test_transmit_complete_vector_turns_the_line_around_first(self):
        """The enables before anything is saved; and no more than was written by hand."""
        rest = ["push", "ldi", "sts", "ldi", "sts", "pop", "reti"]
        for board in boards.ALL:
            turns = {"TWO_ENABLES": ["cbi", "sbi"], "ONE_ENABLE": ["cbi"]}.get(boards.BOARDS[board].wiring)
            if turns is None:
                continue
            macros = run("avr-gcc", f"-mmcu={boards.BOARDS[board].mcu}", "-E", "-dM", "-include", "avr/io.h",
                         "-x", "c", ROOT / f"boards/{board}/board.h")[1]
            usart = re.search(r"#define BOARD_BUS0_USART +(\d)", macros)[1]
            vector = re.search(rf"#define USART{usart}?_TX_vect_num (\d+)", macros)[1]
            code = run("avr-objdump", "-d", "--no-show-raw-insn",
                       ROOT / f"build/{board}/controller.elf")[1]
            body = re.search(rf"<__vector_{vector}>:\n((?:.+\n)+)", code)[1]
            self.assertEqual(re.findall(r":\s+([a-z]+)", body), turns + rest, body)


class Recipes(unittest.TestCase):
    def test_board_of_linking_md_is_complete_and_compiles(self):
        section = (ROOT / "docs/linking.md").read_text().split("## A board of your own\n")[1].split("\n## ")[0]
        with tempfile.TemporaryDirectory() as folder:
            for language, name in (("c", "board.h"), ("make", "board.mk")):
                pathlib.Path(folder, name).write_text(re.search(rf"```{language}\n(.*?)```", section, re.S)[1])
            self.assertEqual(run(ROOT / "scripts/board.py", folder), (0, ""))
            self.assertEqual(run("avr-gcc", "-mmcu=atmega644p", "-DF_CPU=16000000UL", "-std=gnu99", "-Os", "-Iinclude", f"-I{folder}",
                                 "-fsyntax-only", "-include", "cds55xx/avr/board_check.h", "-x", "c", "/dev/null", cwd=ROOT), (0, ""))
        for field in re.search(r"BOARD_FIELDS := (.*)", (ROOT / "mk/avr.mk").read_text())[1].split():
            self.assertIn(f"`{field}`", section)

    def test_each_board_is_named_in_the_documents(self):
        firmware = (ROOT / "docs/firmware.md").read_text()
        profiles = re.search(r"\| board \|.*\n\|---.*\n\| chip .*\n", firmware)[0]
        wiring = firmware.split("## Wiring\n")[1].split("\n## ")[0]
        for board in (ROOT / "boards").iterdir():
            self.assertIn(f"`{board.name}`", profiles, "docs/firmware.md: the first table of boards")
            self.assertIn(f"`{board.name}`", wiring, "docs/firmware.md: Wiring")

    def test_boards_with_motions_are_named_by_error_55_and_motion_md(self):
        remedy = f"boards {', '.join(sorted(boards.WITH_MOTION))} have it"
        self.assertTrue(remedy in (ROOT / "src/controller/console/errors.h").read_text(), f"errors.h, error 55: {remedy}")
        row = re.search(r".*\| yes \| yes \|", (ROOT / "docs/motion.md").read_text())[0]
        self.assertEqual(sorted(re.findall("`(.*?)`", row)), sorted(boards.WITH_MOTION), "docs/motion.md, the table")

    def test_rate_of_a_host_link_not_115200_is_in_the_documents(self):
        for name, board in boards.BOARDS.items():
            for document in ("docs/bridge.md", "docs/hardware.md", "docs/known-clients.md", "scripts/console.py"):
                rate = re.search(rf"115200.*`{name}`:? {board.host_bps}", (ROOT / document).read_text())
                self.assertTrue(rate or board.host_bps in (None, 115200), f"{document}: `{name}`: {board.host_bps}")

    def test_new_file_of_recipe_names_its_licence(self):
        """scripts/spdx.py checks files that are not committed, too."""
        text = (ROOT / "CONTRIBUTING.md").read_text()
        begin = text.index("or in a new file:")
        block = re.search(r"```c\n(.*?)```", text[begin:], re.S)[1]
        self.assertEqual(block.split("\n")[0].strip(), "/* SPDX-License-Identifier: MIT */")

    def test_code_of_recipe_compiles(self):
        """A command, and the functions of one that sends several packets."""
        recipe = (ROOT / "CONTRIBUTING.md").read_text().split("### Add a command\n")[1].split("\n### ")[0]
        command, functions = re.findall(r"^   ```c\n(.*?)^   ```", recipe, re.S | re.M)[:2]
        headers = "".join(f'#include "console/{name}.h"\n' for name in ["commands/shared", "errors", "messages"])
        for code in [command, headers + functions]:
            with tempfile.NamedTemporaryFile("w", suffix=".c") as file:
                file.write(code)
                file.flush()
                self.assertEqual(run("gcc", "-std=gnu99", "-fsyntax-only", "-Wall", "-Wextra", "-Wconversion", "-Werror",
                                     "-Wno-unused-function", "-Iinclude", "-Isrc/core", "-Isrc/controller", file.name, cwd=ROOT), (0, ""))


if __name__ == "__main__":
    unittest.main()
