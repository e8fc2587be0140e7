# SPDX-License-Identifier: MIT
"""The simulator's files: read whole or refused, written whole or reported, whatever ends the run."""
# needs: build/atmega128/controller.elf
import itertools
import os
import pathlib
import resource
import shutil
import signal
import stat
import subprocess
import tempfile
import unittest

from simulator import ROOT, SIM

ELF = ROOT / "build/atmega128/controller.elf"
FIRMWARE = ["firmware", ELF, "--board", "atmega128", "--servos", "1"]
BUS = ["bus", "--servos", "1"]
EEPROM_BYTES = 4096
SCRIPT = "settings return_delay 5\nsave\n" + "ping 1\n" * 50


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.script = self.folder / "script"
        self.script.write_text(SCRIPT)

    def simulate(self, *options, **more):
        return subprocess.run([SIM, *options], text=True, stdin=subprocess.DEVNULL,
                              stderr=subprocess.PIPE,
                              **{"stdout": subprocess.PIPE, "timeout": 60, **more})

    def firmware(self, *options, **more):
        return self.simulate(*FIRMWARE, "--script", self.script, *options, **more)


class Input(Folder):
    def test_folder_as_text_file_is_refused(self):
        for option in ["--host", "--script"]:
            done = self.simulate(*FIRMWARE, option, f"{self.folder}/")
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertEqual(done.stderr, f"{self.folder}/: Is a directory\n")

    def test_endless_text_file_is_refused(self):
        for option in ["--host", "--script"]:
            done = self.simulate(*FIRMWARE, option, "/dev/zero")
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertEqual(done.stderr, "/dev/zero: longer than 16 MiB\n")

    def test_host_file_from_a_pipe_is_read(self):
        read, write = os.pipe()
        os.write(write, b"text ping 1\nhear 4\n")
        os.close(write)
        done = self.simulate(*FIRMWARE, "--host", f"/dev/fd/{read}", pass_fds=[read])
        os.close(read)
        self.assertEqual(done.returncode, 0, done)
        self.assertIn("\nheard ", done.stdout)


    def test_board_that_is_no_regular_file_is_refused(self):
        pipe, folder = self.folder / "pipe", self.folder / "folder"
        os.mkfifo(pipe)
        (folder / "board.h").mkdir(parents=True)
        for board, path in [("/dev/zero", "/dev/zero"), ("/dev/full", "/dev/full"), (pipe, pipe),
                            (folder, folder / "board.h")]:
            self.assert_board_refused(board, f"{path}: is no regular file\n")

    def test_board_that_is_too_long_is_refused(self):
        board = self.folder / "board.h"
        board.touch()
        for size in [256 * 1024 + 1, 1 << 40]:
            os.truncate(board, size)
            self.assert_board_refused(board, f"{board}: longer than 256 KiB\n")
        board.write_bytes((ROOT / "boards/atmega128/board.h").read_bytes())
        make = self.folder / "board.mk"
        make.symlink_to("/dev/zero")
        self.assert_board_refused(board, f"{make}: is no regular file; it or BOARD_MCU in board.h "
                                  "names the chip\n")

    def test_folder_of_the_user_without_slash_is_named(self):
        (self.folder / "mine").mkdir()
        done = self.simulate("firmware", ELF, "--board", "mine", "--seconds", "0.01", cwd=self.folder)
        self.assertEqual(done.returncode, 2)
        self.assertTrue(done.stderr.endswith("; the folder mine of yours is --board ./mine\n"), done.stderr)

    def test_board_of_the_longest_size_is_read(self):
        board = self.folder / "board.h"
        text = ((ROOT / "boards/atmega128/board.h").read_text() +
                "#define BOARD_MCU atmega128\n#define BOARD_F_CPU 16000000\n")
        board.write_text(text + "\n" * (256 * 1024 - len(text)))
        done = self.simulate("firmware", ELF, "--board", board, "--seconds", "0.001")
        self.assertEqual(done.returncode, 0, done)

    def assert_board_refused(self, board, message):
        done = self.simulate("firmware", ELF, "--board", board, "--seconds", "0.01", timeout=10)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (2, "", message))


class FullDisk(Folder):
    OUTPUTS = ["--transcript", "--vcd", "--csv", "--times"]

    def test_live_run_ends_at_once_if_nobody_can_read_where_to_connect(self):
        for options in [*FIRMWARE, "--host", "pty"], [*BUS, "--pty"]:
            with open("/dev/full", "w", encoding="ascii") as full:
                done = subprocess.run([SIM, *options], stdout=full, stderr=subprocess.PIPE, text=True, timeout=20, check=False)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("stdout: not everything could be written", done.stderr)

    def test_stdout_on_full_disk_fails(self):
        for command in [[*FIRMWARE, "--script", self.script], [*BUS, "--seconds", "0.01"],
                        ["--help"], [*FIRMWARE, "--host", "stdout", "--seconds", "0.01"]]:
            with open("/dev/full", "w", encoding="ascii") as full:
                done = self.simulate(*command, stdout=full)
            self.assertEqual(done.returncode, 2, command)
            self.assertIn("stdout: not everything could be written", done.stderr)

    def test_output_file_on_full_disk_fails_and_is_named(self):
        for option in [*self.OUTPUTS, "--plot"]:
            done = self.firmware(option, "/dev/full")
            self.assertEqual(done.returncode, 2, option)
            self.assertIn("/dev/full: ", done.stderr)
        for option in ["--transcript", "--vcd", "--csv", "--plot"]:
            done = self.simulate(*BUS, "--script", self.bus_script(), option, "/dev/full")
            self.assertEqual(done.returncode, 2, option)
            self.assertIn("/dev/full: ", done.stderr)

    def test_output_in_a_missing_folder_names_the_remedy(self):
        for option in [*self.OUTPUTS, "--plot", "--state"]:
            done = self.firmware(option, "/no/such/x")
            self.assertEqual(done.returncode, 2, option)
            self.assertEqual(done.stderr, "/no/such/x: No such file or directory; make its folder first, or name another folder\n")

    def bus_script(self):
        script = self.folder / "bus"
        script.write_text("@send FF FF 01 02 01 FB\n@wait 20\n")
        return script

    def test_disk_that_fills_up_during_the_run_fails(self):
        """A limit on the size of files has the same effect, for temporary files too."""
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (128, 128))
        for option in self.OUTPUTS:
            file = self.folder / "output"
            # restore_signals: SIGXFSZ stays ignored
            done = self.firmware(option, file, preexec_fn=limit, restore_signals=False)
            self.assertEqual(done.returncode, 2, option)
            self.assertIn(f"{file}: ", done.stderr)

    def test_plot_whose_data_finds_no_room_fails(self):
        """A gnuplot that draws whatever is left of its data."""
        plot = self.folder / "x.svg"
        gnuplot = self.folder / "gnuplot"
        gnuplot.write_text(f"#!/bin/sh\necho '<svg>nothing</svg>' > {plot}\n")
        gnuplot.chmod(0o755)
        path = {**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"}

        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
        self.assertEqual(self.firmware("--plot", plot, env=path).returncode, 0)
        done = self.firmware("--plot", plot, env=path, preexec_fn=limit, restore_signals=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("x.svg: ", done.stderr)


class SameFile(Folder):
    """An output that is another file of the command line would destroy it: nothing is opened."""
    OUTPUTS = ["--transcript", "--vcd", "--csv", "--times", "--plot"]
    BUS_OUTPUTS = ["--transcript", "--vcd", "--csv", "--plot"]

    def setUp(self):
        super().setUp()
        self.elf = self.folder / "c.elf"
        shutil.copy(ELF, self.elf)
        self.board = self.folder / "board/board.h"
        shutil.copytree(ROOT / "boards/atmega128", self.board.parent)
        self.eeprom = self.folder / "e.bin"
        self.eeprom.write_bytes(b"\xff" * EEPROM_BYTES)
        self.host = self.folder / "host"
        self.host.write_text("text ping 1\nhear 4\n")
        self.state = self.folder / "state"
        self.command = ["firmware", self.elf, "--board", self.board, "--servos", "1"]

    def contents(self):
        return {file: file.read_bytes() for file in self.folder.rglob("*") if file.is_file()}

    def assert_refused(self, first, second, *command, cwd=None):
        """One line that names both options, status 2, and all files as before."""
        before = self.contents()
        done = self.simulate(*command, cwd=cwd)
        self.assertEqual((done.returncode, done.stdout), (2, ""), command)
        self.assertRegex(done.stderr, rf"\Acds55xx-sim: {first} .+ and {second} .+ are the same "
                         rf"file: name another file for {first}\n\Z")
        self.assertEqual(self.contents(), before)

    def test_output_that_is_an_input_is_refused(self):
        script = ["--script", self.script]
        for option in self.OUTPUTS:
            for name, file, more in [
                    ("the ELF", self.elf, script), ("--script", self.script, script),
                    ("--host", self.host, ["--host", self.host]), ("--board", self.board, script),
                    ("--board", self.board.with_name("board.mk"), script)]:
                self.assert_refused(option, name, *self.command, *more, option, file)
            self.assert_refused(option, "--eeprom", *self.command, *script, option, self.eeprom,
                                "--eeprom", self.eeprom)

    def test_eeprom_that_is_an_input_is_refused(self):
        self.assert_refused("--eeprom", "the ELF", *self.command, "--seconds", "1", "--eeprom",
                            self.elf)

    def test_known_board_as_output_is_refused(self):
        """The ELF is for another chip: a simulator without the check ends before it opens the file
        of the repository."""
        for file in ["board.h", "board.mk"]:
            self.assert_refused("--transcript", "--board", "firmware", self.elf, "--board",
                                "arbotix", "--seconds", "0.001", "--transcript",
                                ROOT / "boards/arbotix" / file)

    def test_two_outputs_in_one_file_are_refused(self):
        output = self.folder / "output"
        for exists in [False, True]:
            if exists:
                output.write_text("old")
            for first, second in itertools.combinations(self.OUTPUTS, 2):
                self.assert_refused(first, second, *self.command, "--script", self.script, second,
                                    output, first, output)
            for first, second in itertools.combinations(self.BUS_OUTPUTS, 2):
                self.assert_refused(first, second, *BUS, "--seconds", "0.01", first, output,
                                    second, output)

    def test_new_eeprom_as_output_is_refused(self):
        self.eeprom.unlink()
        self.assert_refused("--transcript", "--eeprom", *self.command, "--script", self.script,
                            "--eeprom", self.eeprom, "--transcript", self.eeprom)

    def test_script_of_a_bus_as_output_is_refused(self):
        for option in self.BUS_OUTPUTS:
            self.assert_refused(option, "--script", *BUS, "--script", self.script, option,
                                self.script)

    def test_hard_and_symbolic_links_to_an_input_are_refused(self):
        hard, soft = self.folder / "hard", self.folder / "soft"
        os.link(self.script, hard)
        soft.symlink_to("script")
        for link in [hard, soft]:
            self.assert_refused("--transcript", "--script", *self.command, "--script", self.script,
                                "--transcript", link)

    def test_new_file_by_several_paths_is_refused(self):
        soft, there = self.folder / "soft", self.folder / "there"
        soft.symlink_to("chain")
        (self.folder / "chain").symlink_to(self.folder / "output")
        there.symlink_to(self.folder)
        for path in ["./output", f"{self.folder}/output", "board/../output", soft, there / "output",
                     there / "soft"]:
            self.assert_refused("--transcript", "--csv", *self.command, "--script", self.script,
                                "--transcript", "output", "--csv", path, cwd=self.folder)

    def test_output_that_is_a_servo_file_of_state_is_refused(self):
        self.state.mkdir()
        for exists in [False, True]:
            if exists:
                (self.state / "bus0-servo001.eeprom").write_text("old")
            for option, more in [("--transcript", []), ("--eeprom", ["--transcript", "/dev/null"])]:
                self.assert_refused(option, "--state", *self.command, "--script", self.script,
                                    "--state", self.state, *more, option,
                                    self.state / "bus0-servo001.eeprom")
            self.assert_refused("--csv", "--state", *BUS, "--seconds", "0.01", "--state",
                                self.state, "--csv", self.state / "bus0-servo001.eeprom")
        os.link(self.state / "bus0-servo001.eeprom", self.folder / "hard")
        self.assert_refused("--csv", "--state", *BUS, "--seconds", "0.01", "--state",
                            self.state, "--csv", self.folder / "hard")

    def test_output_that_is_the_file_of_stdout_is_refused(self):
        for mode in ["w", "a"]:
            for path in [self.folder / "log", "/dev/stdout"]:
                with open(self.folder / "log", mode, encoding="ascii") as log:
                    log.write("earlier\n")
                    log.flush()
                    done = self.simulate(*BUS, "--seconds", "0.01", "--transcript", path,
                                         stdout=log)
                self.assertEqual(done.returncode, 2)
                self.assertEqual(done.stderr, f"cds55xx-sim: --transcript {path} and stdout are the "
                                 "same file: name another file for --transcript\n")
                self.assertEqual((self.folder / "log").read_text()[:8], "earlier\n")

    def test_device_or_pipe_for_several_outputs_is_written(self):
        read, write = os.pipe()
        for path in ["/dev/null", "/dev/stdout", f"/dev/fd/{write}"]:
            outputs = [word for option in ["--transcript", "--csv", "--vcd", "--times"]
                       for word in [option, path]]
            done = self.simulate(*self.command, "--host", self.host, *outputs, "--seconds", "0.01",
                                 pass_fds=[write])
            self.assertEqual(done.returncode, 0, done)
            done = self.simulate(*BUS, *outputs[:-2], "--seconds", "0.01", pass_fds=[write])
            self.assertEqual(done.returncode, 0, done)
            self.assertEqual("$enddefinitions" in done.stdout, path == "/dev/stdout")
        os.close(write)
        with open(read, encoding="ascii") as pipe:
            self.assertIn("$enddefinitions", pipe.read())
        done = self.firmware("--transcript", "/dev/full", "--csv", "/dev/full")
        self.assertEqual(done.returncode, 2)
        self.assertIn("/dev/full: not everything could be written", done.stderr)

    def test_files_beside_each_other_are_written(self):
        """Other names in the folders of the inputs, and copies with the same content."""
        copy, servo = self.folder / "copy", self.state / "bus0-servo001.eeprom"
        self.state.mkdir()
        copy.write_text(SCRIPT)
        self.script.write_text("write 1 ID 9\n")
        done = self.simulate(*self.command, "--script", self.script, "--state", self.state,
                             "--eeprom", self.eeprom, "--transcript", copy, "--csv",
                             self.state / "motion.csv", "--vcd", self.board.with_name("board.vcd"),
                             "--times", self.board.with_name("bus0-servo001.eeprom"))
        self.assertEqual(done.returncode, 0, done)
        self.assertIn("->in", copy.read_text())
        self.assertIn("CRC", servo.read_text())


def accept_hangup():
    """Under nohup a test inherits SIGHUP as ignored."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


class Signals(Folder):
    """Whatever ends the run, the files are written."""

    def run_until_signal(self, number, *options):
        """The run is in its main loop when it has printed the path of its pty."""
        process = subprocess.Popen([SIM, *options], stdin=subprocess.DEVNULL, text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   preexec_fn=accept_hangup)
        process.stdout.readline()
        process.send_signal(number)
        output, errors = process.communicate(timeout=30)
        return process.returncode, output, errors

    def test_signals_end_a_firmware_run_with_all_files_written(self):
        for number in [signal.SIGHUP, signal.SIGINT, signal.SIGTERM]:
            eeprom, vcd = self.folder / f"eeprom{number}", self.folder / f"{number}.vcd"
            status, output, errors = self.run_until_signal(
                number, *FIRMWARE, "--host", "pty", "--eeprom", eeprom, "--vcd", vcd)
            self.assertEqual((status, "rules:   none broken" in output), (0, True), errors)
            self.assertEqual(len(eeprom.read_bytes()), EEPROM_BYTES)
            self.assertIn("$enddefinitions", vcd.read_text())

    def test_signals_end_a_bus_run_with_all_files_written(self):
        for number in [signal.SIGHUP, signal.SIGINT, signal.SIGTERM]:
            vcd = self.folder / f"{number}.vcd"
            status, output, errors = self.run_until_signal(number, *BUS, "--pty", "--vcd", vcd)
            self.assertEqual((status, "rules:   none broken" in output), (0, True), errors)
            self.assertIn("$enddefinitions", vcd.read_text())

    def test_reader_of_stdout_that_leaves_does_not_lose_the_eeprom(self):
        eeprom = self.folder / "eeprom"
        process = subprocess.Popen([SIM, *FIRMWARE, "--script", self.script, "--echo", "--eeprom",
                                    eeprom], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        process.stdout.readline()
        process.stdout.close()
        errors = process.stderr.read()
        process.stderr.close()
        self.assertEqual(process.wait(timeout=30), 2)
        self.assertIn("stdout: not everything could be written", errors)
        self.assertEqual(len(eeprom.read_bytes()), EEPROM_BYTES)

    def test_hangup_that_nohup_ignores_does_not_end_the_run(self):
        def ignore():
            signal.signal(signal.SIGHUP, signal.SIG_IGN)
        process = subprocess.Popen([SIM, *BUS, "--pty"], stdin=subprocess.DEVNULL, text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   preexec_fn=ignore)
        process.stdout.readline()
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
        ignored = int(status.split("SigIgn:")[1].split()[0], 16)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=30)
        self.assertTrue(ignored >> (signal.SIGHUP - 1) & 1)


class Eeprom(Folder):
    def setUp(self):
        super().setUp()
        self.eeprom = self.folder / "eeprom"

    def run_with_eeprom(self, **more):
        return self.firmware("--eeprom", self.eeprom, **more)

    def test_eeprom_file_is_replaced_not_truncated(self):
        self.eeprom.write_bytes(b"\xff" * EEPROM_BYTES)
        with self.eeprom.open("rb") as before:
            done = self.run_with_eeprom()
            self.assertEqual(done.returncode, 0, done)
            self.assertEqual(before.read(), b"\xff" * EEPROM_BYTES)
        self.assertNotEqual(self.eeprom.read_bytes(), b"\xff" * EEPROM_BYTES)
        self.assertEqual(sorted(os.listdir(self.folder)), ["eeprom", "script"])

    def test_eeprom_that_cannot_be_written_keeps_the_old_file(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (1024, 1024))
        old = bytes(range(256)) * (EEPROM_BYTES // 256)
        self.eeprom.write_bytes(old)
        done = self.run_with_eeprom(preexec_fn=limit, restore_signals=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn(f"{self.eeprom}: File too large", done.stderr)
        self.assertEqual(self.eeprom.read_bytes(), old)
        self.assertEqual(sorted(os.listdir(self.folder)), ["eeprom", "script"])

    def test_eeprom_file_keeps_its_permissions(self):
        self.eeprom.write_bytes(b"\xff" * EEPROM_BYTES)
        self.eeprom.chmod(0o640)
        self.assertEqual(self.run_with_eeprom().returncode, 0)
        self.assertEqual(stat.S_IMODE(self.eeprom.stat().st_mode), 0o640)

    def test_new_eeprom_file_obeys_the_umask(self):
        self.assertEqual(self.run_with_eeprom(umask=0o027).returncode, 0)
        self.assertEqual(stat.S_IMODE(self.eeprom.stat().st_mode), 0o640)

    def test_eeprom_file_keeps_its_owner(self):
        """Only root can give a file away; other users can give it to a group of theirs."""
        owner = (12345, 12346) if os.geteuid() == 0 else (os.geteuid(), max([os.getegid(), *os.getgroups()]))
        self.eeprom.write_bytes(b"\xff" * EEPROM_BYTES)
        os.chown(self.eeprom, *owner)
        self.assertEqual(self.run_with_eeprom().returncode, 0)
        found = self.eeprom.stat()
        self.assertEqual((found.st_uid, found.st_gid), owner)

    def test_symbolic_link_as_eeprom_is_refused(self):
        target = self.folder / "target"
        for exists in [False, True]:
            if exists:
                target.write_bytes(b"\xff" * EEPROM_BYTES)
            else:
                self.eeprom.symlink_to(target)
            done = self.run_with_eeprom()
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertEqual(done.stderr, f"{self.eeprom}: is a symbolic link, which the simulator "
                             "does not follow: name the file itself\n")
        self.assertEqual(target.read_bytes(), b"\xff" * EEPROM_BYTES)

    def test_link_planted_during_the_run_is_not_followed(self):
        target = self.folder / "target"
        target.write_bytes(b"precious")
        process = subprocess.Popen([SIM, *FIRMWARE, "--host", "pty", "--eeprom", self.eeprom],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        process.stdout.readline()  # the run has begun
        self.eeprom.symlink_to(target)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=30)
        self.assertEqual(target.read_bytes(), b"precious")
        self.assertEqual(len(self.eeprom.read_bytes()), EEPROM_BYTES)
        self.assertFalse(self.eeprom.is_symlink())

    def test_eeprom_that_is_no_regular_file_is_refused(self):
        for path in [self.folder, "/dev/full", "/dev/null"]:
            done = self.firmware("--eeprom", path)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertRegex(done.stderr, rf"\A{path}: is no regular file\n\Z")

    def test_eeprom_in_a_missing_folder_is_refused_at_start(self):
        done = self.firmware("--eeprom", self.folder / "missing/eeprom")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertRegex(done.stderr, r"\A\S*/missing/eeprom: No such file or directory; make its folder first, or name another folder\n\Z")


class State(Folder):
    def test_link_as_new_state_file_is_not_followed(self):
        """A file that another user has put where the simulator writes the new state."""
        state, target = self.folder / "state", self.folder / "target"
        state.mkdir()
        target.write_bytes(b"precious")
        (state / "bus0-servo001.eeprom.new").symlink_to(target)
        self.script.write_text("write 1 ID 9\n")
        done = self.firmware("--state", state)
        self.assertEqual(done.returncode, 0, done)
        self.assertEqual(target.read_bytes(), b"precious")
        self.assertTrue((state / "bus0-servo001.eeprom").is_file())


if __name__ == "__main__":
    unittest.main()
