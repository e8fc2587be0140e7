# SPDX-License-Identifier: MIT
"""make install, uninstall and dist: what they write, and programs that use what is installed."""
# needs: $(foreach m,$(MCUS),$(call library_of,$(m)))
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "test/runs")]

from simulator import call

SIMULATED = {"atmega128", "atmega1280", "atmega1281", "atmega1284", "atmega1284p", "atmega164p", "atmega168",
             "atmega168p", "atmega2560", "atmega324p", "atmega328", "atmega328p", "atmega644", "atmega644p"}


def any_board(mcu):
    """board.h of a board that each chip can be: bus on USART0, whose port the installed header names, and one enable."""
    macros = call("avr-gcc", f"-mmcu={mcu}", "-E", "-dM", PREFIX / "include/cds55xx/cds55xx/avr/usart_pins.h")[1]
    port = re.search(r"#define CDS_AVR_RXD0_PORT (\w)", macros)[1]
    return "".join(f"#define BOARD_{line}\n" for line in [
        "BUS_COUNT 1", "BUS0_WIRING ONE_ENABLE", "BUS0_USART 0", f"BUS0_RXD_PORT {port}", "BUS0_RXD_BIT 0",
        f"BUS0_TXD_PORT {port}", "BUS0_TXD_BIT 1", "BUS0_ENABLE_PORT D", "BUS0_ENABLE_BIT 2", "CLOCK_TIMER 1"])


def setUpModule():
    global FOLDER, PREFIX, ENVIRONMENT
    FOLDER = pathlib.Path(tempfile.mkdtemp())
    unittest.addModuleCleanup(shutil.rmtree, FOLDER)
    PREFIX = FOLDER / "prefix"
    ENVIRONMENT = {**os.environ, "MAKEFLAGS": "", "PKG_CONFIG_PATH": str(PREFIX / "lib/pkgconfig")}
    status, output = make("install", f"PREFIX={PREFIX}")
    assert status == 0, output


def make(*arguments):
    return call("make", "-C", ROOT, "--no-print-directory", *arguments, env={**os.environ, "MAKEFLAGS": ""})


def files_of(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def shell(command, **options):
    """(status, output) of a command of a user who has the installed library."""
    return call("sh", "-c", command, env=ENVIRONMENT, **options)


def libraries():
    return sorted(path.stem[len("libcds55xx-"):] for path in (PREFIX / "lib/cds55xx").glob("*.a"))


class Files(unittest.TestCase):
    def test_all_headers_examples_and_boards_are_installed(self):
        self.assertEqual(files_of(PREFIX / "include/cds55xx"), files_of(ROOT / "include"))
        self.assertEqual(files_of(PREFIX / "share/cds55xx/boards"), files_of(ROOT / "boards"))
        self.assertEqual(files_of(PREFIX), sorted({  # nothing that the manifest does not name
            line.split(" ", 1)[1] for line in (PREFIX / "share/cds55xx/manifest").read_text().splitlines()
            if line.split(" ", 1)[1] != "."} | {"share/cds55xx/manifest"}))

    def test_each_library_has_a_pkg_config_file(self):
        self.assertEqual(len(libraries()), 19)
        for mcu in libraries():
            status, flags = shell(f"pkg-config --cflags --libs cds55xx-{mcu}")
            self.assertEqual(status, 0, flags)
            self.assertEqual(re.findall(r"-mmcu=(\S+)", flags), [mcu, mcu])  # to compile, and to link
            version = re.search(r'"(.*)"', (ROOT / "include/cds55xx/version.h").read_text())[1]
            self.assertEqual(shell(f"pkg-config --modversion cds55xx-{mcu}"), (0, version + "\n"))

    def test_docs_list_each_chip_that_has_a_library(self):
        text = (ROOT / "docs/linking.md").read_text()
        table = text.split("### Chips\n")[1].split("| chips |")[1].split("\n\n")[0]
        self.assertEqual(sorted(re.findall(r"\bat\w+", table)), libraries())

    def assert_uninstalls(self, prefix, words):
        """It says where, and how many files it has removed."""
        count = (prefix / "share/cds55xx/manifest").read_text().count("file ")
        self.assertEqual(make("uninstall", *words), (0, f"removed cds55xx from {prefix}: {count} files\n"))

    def test_destdir_install_and_uninstall_leave_nothing(self):
        words = [f"DESTDIR={FOLDER}/image", "PREFIX=/usr", "MCUS=atmega328p"]
        self.assertEqual(make("install", *words)[0], 0)
        self.assertEqual(sorted(p.name for p in (FOLDER / "image/usr").iterdir()),
                         ["bin", "include", "lib", "share"])
        flags = call("pkg-config", "--cflags", "cds55xx-atmega328p", env={
            **os.environ, "PKG_CONFIG_PATH": f"{FOLDER}/image/usr/lib/pkgconfig"})[1]
        self.assertIn("/usr/lib/pkgconfig/../../include/cds55xx", flags)  # never /usr/include of the host
        self.assert_uninstalls(FOLDER / "image/usr", words)
        self.assertFalse((FOLDER / "image").exists())

    def test_install_umask_077_others_may_read_chip_twice_is_one(self):
        prefix = FOLDER / "open"
        command = shlex.join(["make", "-C", str(ROOT), "-s", "install", f"PREFIX={prefix}", "MCUS=atmega328p atmega328p"])
        status, output = call("sh", "-c", f"umask 077 && {command}", env={**os.environ, "MAKEFLAGS": ""})
        self.assertEqual(status, 0, output)
        self.assertIn(f" in {prefix} for 1 chip\n", output)
        for path in [prefix, *prefix.rglob("*")]:
            self.assertEqual(path.stat().st_mode & 0o044, 0o044, path)
            self.assertEqual(path.stat().st_mode & 0o011, 0o011 if path.is_dir() or path.parent.name == "bin" else 0, path)

    def test_prefix_with_dots_behind_a_folder_that_does_not_exist(self):
        for order in ["install", "uninstall"]:
            status, output = make(order, f"PREFIX={FOLDER}/absent/../dots", "MCUS=atmega328p")
            self.assertEqual(status, 0, output)
            self.assertIn(f" {FOLDER}/dots", output)
            self.assertFalse((FOLDER / "absent").exists())
        self.assertFalse((FOLDER / "dots").exists())

    def test_uninstall_keeps_files_and_folders_of_others(self):
        prefix = FOLDER / "shared"
        (prefix / "lib").mkdir(parents=True)
        words = [f"PREFIX={prefix}", "MCUS=atmega328p"]
        self.assertEqual(make("install", *words)[0], 0)
        (prefix / "bin/other").write_text("")
        self.assertEqual(make("install", *words)[0], 0)  # again: replaces what is there
        self.assert_uninstalls(prefix, words)
        self.assertEqual(files_of(prefix), ["bin", "bin/other", "lib"])

    def test_uninstall_where_nothing_is_installed_says_so(self):
        status, output = make("uninstall", f"PREFIX={FOLDER}/none")
        self.assertNotEqual(status, 0)
        self.assertIn(f"nothing is installed in {FOLDER}/none; name the prefix", output)

    def test_man_page_has_the_options_of_help(self):
        options = re.compile(r"--[a-z]+(?:-[a-z]+)*")
        page = (PREFIX / "share/man/man1/cds55xx-sim.1").read_text().replace("\\-", "-")
        self.assertEqual(set(options.findall(page)),
                         set(options.findall(call(PREFIX / "bin/cds55xx-sim", "--help")[1])))


class Refused(unittest.TestCase):
    def refused(self, prefix, message, **options):
        done = subprocess.run(["/usr/bin/python3", FOLDER / "tree/scripts/install.py", "check", "--prefix", prefix],
                              stderr=subprocess.PIPE, text=True, cwd="/", **options)
        self.assertNotEqual(done.returncode, 0)
        self.assertRegex(done.stderr, f"^install.py: {message}.*\n$")

    def setUp(self):
        for file in ["scripts/install.py", "scripts/version.py", "include/cds55xx/version.h"]:
            target = FOLDER / "tree" / file
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / file, target)
        FOLDER.chmod(0o755)

    def test_prefix_that_is_no_folder(self):
        self.refused(FOLDER / "tree/scripts/install.py/x", ".*/install.py is no folder; name another one")

    def test_prefix_without_leave_to_write(self):
        (FOLDER / "closed").mkdir(mode=0o555)
        as_user = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
        self.refused(FOLDER / "closed/below", ".*/closed may not be written by .*; make install PREFIX=", **as_user)

    def test_prefix_on_a_read_only_file_system(self):
        if os.statvfs("/sys").f_flag & os.ST_RDONLY: # only some machines have one
            self.refused("/sys/x", "/sys is on a read-only file system; make install PREFIX=")

    def test_prefix_that_is_relative(self):
        self.refused("here", "PREFIX=here is not absolute")

    def test_prefix_that_a_program_cannot_link(self):
        for letter in " &;#%:é":
            self.refused(f"{FOLDER}/a{letter}b", f"PREFIX={FOLDER}/a{letter}b has '{letter}'; use ASCII letters, digits and ")

    def test_prefix_that_is_a_dangling_link(self):
        (FOLDER / "dangling").symlink_to(FOLDER / "nothing")
        for prefix in [FOLDER / "dangling", FOLDER / "dangling/below"]:
            self.refused(prefix, f"{FOLDER}/dangling is a link to {FOLDER}/nothing, which does not exist; remove it")

    def test_unknown_chip_lists_those_with_a_library(self):
        status, output = make("install", f"PREFIX={FOLDER}/none", "MCUS=atmega328p atmega32")
        self.assertNotEqual(status, 0)
        self.assertIn("there is no library for 'atmega32'; MCUS= some of: at90can128 ", output)
        self.assertFalse((FOLDER / "none").exists())


class Examples(unittest.TestCase):
    """Copies of the installed examples, built and run as a user does."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def copy(self, name):
        return shutil.copytree(PREFIX / "share/cds55xx/examples" / name, self.folder / name)

    def make_test(self, name, runs=1):
        status, output = shell("make test", cwd=self.copy(name))
        self.assertEqual(status, 0, output)
        self.assertEqual(output.count("rules:   none broken"), runs, output)

    def test_clean_removes_what_was_built_and_nothing_else(self):
        for makefile in sorted((ROOT / "examples").glob("*/Makefile")):
            folder = self.copy(makefile.parent.name)
            before = files_of(folder)
            self.assertEqual(shell("make -s", cwd=folder), (0, ""))
            self.assertNotEqual(files_of(folder), before)
            self.assertEqual(shell("make -s clean", cwd=folder), (0, ""))
            self.assertEqual(files_of(folder), before)

    def test_blink(self):
        self.make_test("blink")

    def test_sweep(self):
        self.make_test("sweep")

    def test_hexapod(self):
        self.make_test("hexapod")

    def test_teach(self):
        self.make_test("teach")

    def output_of_broken(self, name, text, other):
        """What `make test` of an example prints with `other` in place of `text` in its source. It must fail."""
        folder = self.copy(name)
        source = folder / f"{name}.c"
        source.write_text(source.read_text().replace(text, other))
        status, output = shell("make test", cwd=folder)
        self.assertNotEqual(status, 0)
        return output

    def test_wheels(self):
        self.make_test("wheels")

    def test_gripper_on_its_own_board(self):
        self.make_test("gripper", runs=3)

    def test_gripper_runs_all_its_tests_and_says_why_it_has_stopped(self):
        output = self.output_of_broken("gripper", "CDS_JOINT(1,", "CDS_JOINT(2,")
        self.assertEqual(output.count("servo 2 (joint 0, jaw): no reply\n"), 3, output)
        self.assertIn("\n0 passed, 3 failed: tests/closes.script tests/holds.script tests/stops.script\n", output)

    def test_ci_job_of_the_gripper_installs_and_tests(self):
        """The lines `run:` of the job, in a copy of the example with a clone of the library in it, as a user with a home of
        their own."""
        folder = self.copy("gripper")
        job = (folder / "ci.yml").read_text()
        (folder / "cds55xx").symlink_to(ROOT)
        home = self.folder / "home"
        home.mkdir()
        environment = {**os.environ, "MAKEFLAGS": "", "HOME": str(home)}
        steps = re.findall(r"- run: (.*)\n(?: +env: { (\w+): (.*) }\n)?", job)
        self.assertEqual(len(steps), 2)
        for command, name, value in steps:
            more = {name: value.replace("/home/runner", str(home))} if name else {}
            status, output = call("sh", "-c", command, cwd=folder, env={**environment, **more})
            self.assertEqual(status, 0, output)
        self.assertEqual(output.count("rules:   none broken"), 3, output)
        self.assertIn("\n3 passed, 0 failed\n", output)

    def test_example_that_fails_its_script_fails_make(self):
        output = self.output_of_broken("blink", "led = !led", "led = 0")
        self.assertIn("@expect servo 1 led on within 0: not met", output)

    def cmake(self, source):
        return shell(f"cmake --toolchain {PREFIX}/lib/cmake/cds55xx/avr-gcc.cmake -S {source} -B {self.folder}/build"
                     f" && cmake --build {self.folder}/build && ctest --test-dir {self.folder}/build")

    def test_blink_with_cmake(self):
        status, output = self.cmake(self.copy("blink"))
        self.assertEqual(status, 0, output)
        self.assertIn("100% tests passed", output)

    def test_cmake_component_without_library_is_named(self):
        source = self.copy("blink") / "CMakeLists.txt"
        source.write_text(source.read_text().replace("COMPONENTS atmega2560", "COMPONENTS atmega32"))
        status, output = self.cmake(source.parent)
        self.assertNotEqual(status, 0)
        self.assertIn("there is no library for 'atmega32'; COMPONENTS are some of: at90can128", output)

    def test_cmake_without_components_lists_the_chips(self):
        source = self.copy("blink") / "CMakeLists.txt"
        source.write_text(source.read_text().replace(" COMPONENTS atmega2560", ""))
        status, output = self.cmake(source.parent)
        self.assertEqual(status, 0, output)
        self.assertIn("cds55xx: link cds55xx::<chip>, one of: at90can128", output)

    def test_cmake_without_toolchain_file_names_the_file(self):
        status, output = shell(f"cmake -DCMAKE_PREFIX_PATH={PREFIX} -S {self.copy('blink')} -B {self.folder}/build")
        self.assertNotEqual(status, 0)
        self.assertIn(f"the C compiler is not avr-gcc; in a new build folder: cmake --toolchain {PREFIX}/lib/cmake/cds55xx/avr-gcc.cmake",
                      " ".join(output.split()))

    def test_cmake_without_avr_gcc_names_the_package(self):
        source = self.copy("blink")
        (self.folder / "bin").mkdir()
        (self.folder / "bin/make").symlink_to(shutil.which("make"))
        status, output = call(shutil.which("cmake"), "--toolchain", PREFIX / "lib/cmake/cds55xx/avr-gcc.cmake", "-S",
                              source, "-B", self.folder / "build", "-DCMAKE_FIND_USE_CMAKE_SYSTEM_PATH=FALSE",
                              env={"PATH": str(self.folder / "bin")})
        self.assertNotEqual(status, 0)
        self.assertIn("avr-gcc is not in PATH; Debian: apt-get install gcc-avr", " ".join(output.split()))

    def test_docs_name_the_chip_and_board_of_each_makefile(self):
        text = (ROOT / "docs/linking.md").read_text()
        for makefile in sorted((ROOT / "examples").glob("*/Makefile")):
            name = makefile.parent.name
            mcu = re.search(r"cds55xx-(\w+)", makefile.read_text())[1]
            board = re.search(r"^BOARD := .*boardsdir \S+\)/(\S+)", makefile.read_text(), re.M)
            place = f"`{board[1]}`" if board else "its folder `board`"
            self.assertRegex(text, rf"\| \[{name}\]\(../examples/{name}\) \|[^|]*\| {mcu}, {place} \|")

    def test_example_for_another_chip_by_the_line_of_the_docs(self):
        text = (ROOT / "docs/linking.md").read_text()
        line = re.search(r"\n(make -C sweep PACKAGE=.*\\\n.*)\n```", text)[1]
        self.copy("sweep")
        self.assertEqual(shell("make -C sweep", cwd=self.folder)[0], 0)  # first for the chip of its Makefile
        self.assertEqual(shell(line, cwd=self.folder)[0], 0)
        status, output = shell(f"{PREFIX}/bin/cds55xx-sim firmware sweep/sweep.elf --board arduino-uno --servos 1 --seconds 1",
                               cwd=self.folder)
        self.assertEqual(status, 0, output)

    def test_example_without_a_library_names_the_commands(self):
        for makefile in sorted((PREFIX / "share/cds55xx/examples").glob("*/Makefile")):
            with self.subTest(example=makefile.parent.name):
                status, output = call("make", "-C", self.copy(makefile.parent.name), "PACKAGE=cds55xx-atmega32",
                                      env={**ENVIRONMENT, "LC_ALL": "C"})
                self.assertEqual(status, 2)
                self.assertIn("no library cds55xx-atmega32: in the folder of the cds55xx sources type make install "
                              "PREFIX=$HOME/.local MCUS=atmega32, then here export PKG_CONFIG_PATH=$HOME/.local/lib/pkgconfig;", output)
                self.assertNotIn("docs/", output)  # which is not installed

    def test_library_before_the_sources_is_the_mistake_of_the_docs(self):
        source = self.copy("blink") / "blink.c"
        status, output = shell(f"avr-gcc -std=gnu99 -I{PREFIX}/share/cds55xx/boards/arduino-mega $(pkg-config --cflags --libs "
                               f"cds55xx-atmega2560) {source} -o {self.folder}/x.elf")
        self.assertNotEqual(status, 0)
        self.assertGreater(len(re.findall("undefined reference to `cds_", output)), 1, output)

    def test_examples_of_one_file_by_the_line_of_the_docs(self):
        text = (ROOT / "docs/linking.md").read_text()
        line = re.search(r"\n(avr-gcc .*(?:\\\n.*)*)\n```", text)[1]
        shutil.copy(PREFIX / "share/cds55xx/examples/stop_report.h", self.folder)
        for name, servos in [("robot", "1-12"), ("two_joints", "1,2"), ("timed_move", "1,2"),
                             ("keyframes", "1-3")]:
            shutil.copy(PREFIX / f"share/cds55xx/examples/{name}.c", self.folder)
            self.assertEqual(shell(line.replace("robot", name), cwd=self.folder), (0, ""))
            status, output = shell(f"{PREFIX}/bin/cds55xx-sim firmware {name}.elf --board arduino-mega --servos "
                                   f"{servos} --seconds 0.3", cwd=self.folder)
            self.assertEqual(status, 0, output)
            self.assertRegex(output, r"bus 0: +[1-9]\d\d+ packets in")


class Libraries(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def build(self, mcu, library=None, flags="", board=None):
        library = library or mcu
        (self.folder / "board.h").write_text(board or any_board(mcu))
        return shell(f"avr-gcc -std=gnu99 -Wall -Wextra -Werror {PREFIX}/share/cds55xx/examples/blink/blink.c -I. "
                     f"$(pkg-config --cflags cds55xx-{mcu}) $(pkg-config --libs cds55xx-{library} | "
                     f"sed s/-mmcu={library}/-mmcu={mcu}/) {flags} -o {mcu}.elf", cwd=self.folder)

    def test_each_chip_links_and_those_of_simavr_blink(self):
        for mcu in libraries():
            self.assertEqual(self.build(mcu), (0, ""), mcu)
            (self.folder / "board.mk").write_text(f"MCU := {mcu}\nF_CPU := 16000000\n")
            if mcu in SIMULATED:
                status, output = call(PREFIX / "bin/cds55xx-sim", "firmware", self.folder / f"{mcu}.elf", "--board",
                                      self.folder, "--servos", "1", "--seconds", "0.52")
                self.assertEqual(status, 0, (mcu, output))
                self.assertIn("bus 0:   1 packets in, 1 out, 0 damaged", output, mcu)

    def test_library_for_another_chip_is_one_error_with_both_names(self):
        for mcu, library in [("atmega328p", "atmega2560"), ("atmega1284p", "atmega128")]:
            for flags in ["", "-fno-lto"]:
                status, output = self.build(mcu, library, flags)
                self.assertNotEqual(status, 0)
                self.assertEqual(re.findall(r"undefined reference to `(.*)'", output), [
                    f"cds55xx_library_is_for_{library}_but_program_is_for_{mcu}"])

    def test_board_of_another_chip_is_one_error_that_stops_gcc(self):
        for board, mcu, message in [
                ("arduino-mega", "atmega328p", "bus 0 has USART 1, but atmega328p has no USART"),
                ("arduino-mega", "atmega1284p", "bus 1 has USART 2, but atmega1284p has no USART"),
                ("cm510", "atmega644p", "BOARD_BUS0_RXD is on port E bit 0; use a port of atmega644p"),
                ("arduino-uno", "atmega128", "USART 0 of atmega128 has RXD on port E bit 0"),
                ("quoted", "atmega328p", "BOARD_BUS0_RXD is on port 'D' bit 0; use a port of atmega328p")]:
            header = PREFIX / f"share/cds55xx/boards/{board}/board.h"
            status, output = self.build(mcu, board=header.read_text() if header.exists() else any_board(mcu).replace(" D", " 'D'"))
            self.assertNotEqual(status, 0)
            self.assertEqual(output.count(" error: "), 2, output)  # the other one says that the compiler stops
            self.assertRegex(output, f"board.h: .*{message}")
            self.assertLess(output.count("\n"), 20)

    def test_package_of_an_unknown_chip_is_named(self):
        status, output = shell("pkg-config --cflags cds55xx-atmega32")
        self.assertNotEqual(status, 0)
        self.assertIn("cds55xx-atmega32", output)


class Simulator(unittest.TestCase):
    def test_installed_simulator_has_its_boards(self):
        output = call(PREFIX / "bin/cds55xx-sim", "firmware", "x.elf", "--board", "toaster", "--seconds", "1", cwd="/")[1]
        self.assertIn(f'no board "toaster" in {PREFIX}/bin/../share/cds55xx/boards; there are: arbotix', output)

    def test_installed_simulator_draws_by_its_own_script(self):
        picture = FOLDER / "plot.svg"
        status, output = call(PREFIX / "bin/cds55xx-sim", "bus", "--servos", "1", "--seconds", "0.01", "--plot",
                              picture, cwd="/")
        self.assertEqual(status, 0, output)
        self.assertIn("</svg>", picture.read_text())
        self.assertNotIn(str(ROOT).encode() + b"/scripts", (PREFIX / "bin/cds55xx-sim").read_bytes())


class SendLines(unittest.TestCase):
    def test_installed_program_tells_its_usage(self):
        status, output = call(PREFIX / "bin/cds55xx-send-lines", cwd="/")
        self.assertEqual(status, 1)
        self.assertIn("Sends the lines of a file to the console", output)


class Dist(unittest.TestCase):
    def test_dist_unpacks_and_builds(self):
        status, output = make("dist")
        if not (ROOT / ".git").exists():
            self.assertIn("make dist needs a clone with git", output)
            return
        self.assertEqual(status, 0, output)
        other = {**os.environ, "MAKEFLAGS": "", "GIT_TEST_ASSUME_DIFFERENT_OWNER": "1", "GIT_CONFIG_GLOBAL": "/dev/null",
                 "GIT_CONFIG_NOSYSTEM": "1"}
        for target in ["dist", "may-release"]:
            status, message = call("make", "-C", ROOT, target, env=other)
            self.assertNotEqual(status, 0, message)
            self.assertIn("dubious ownership", message)
        archive = ROOT / output.splitlines()[-1]
        first = archive.read_bytes()
        make("dist")
        self.assertEqual(archive.read_bytes(), first)  # the same commit, the same bytes
        self.assertEqual(call("tar", "-xf", archive, "-C", FOLDER)[0], 0)
        folder = FOLDER / archive.name[:-len(".tar.gz")]
        status, output = call("make", "-C", folder, "DEPS=no", "build/arduino-uno/controller.elf", env={
            **os.environ, "MAKEFLAGS": ""})
        self.assertEqual(status, 0, output)


if __name__ == "__main__":
    unittest.main()
