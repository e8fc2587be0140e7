# SPDX-License-Identifier: MIT
"""make dist, install, uninstall and release if something goes wrong: one line says it, and what was there is kept."""
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/runs"))

from simulator import call
from test_make import copy_build_files

ENVIRONMENT = {**os.environ, "MAKEFLAGS": "", "GIT_CONFIG_GLOBAL": "/dev/null"}


def git(folder, *words):
    subprocess.run(["git", "-C", folder, "-c", "user.name=x", "-c", "user.email=x@x", *words], check=True,
                   stdout=subprocess.DEVNULL, env=ENVIRONMENT)


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def path_without(self, name):
        """A PATH with all programs of this machine but one."""
        folder = self.folder / f"without-{name}"
        folder.mkdir()
        readable = [place for place in os.environ["PATH"].split(":") if os.access(place, os.R_OK | os.X_OK)]
        for place in readable:
            for program in pathlib.Path(place).glob("*"):
                if program.name != name and not (folder / program.name).is_symlink():
                    (folder / program.name).symlink_to(program)
        return str(folder)


class Dist(Case):
    def setUp(self):
        super().setUp()
        self.root = self.folder / "sources"
        self.root.mkdir()
        copy_build_files(self.root)
        (self.root / "build").mkdir()
        self.archive = self.root / "build/cds55xx-.tar.gz"
        self.archive.write_text("the earlier one")

    def dist(self, **environment):
        return call("make", "-C", self.root, "-s", "--no-print-directory", "dist", env={**ENVIRONMENT, **environment})

    def refused(self, message, **environment):
        status, output = self.dist(**environment)
        self.assertNotEqual(status, 0, output)
        self.assertRegex(output, f"^{message}.*\nmake: .*\n$")
        self.assertEqual([(file.name, file.read_text()) for file in (self.root / "build").iterdir()],
                         [(self.archive.name, "the earlier one")])

    def commit(self):
        git(self.root, "init", "-q")
        git(self.root, "add", "Makefile")
        git(self.root, "commit", "-qm", "x")

    def test_dist_in_a_folder_that_the_repository_around_it_lacks(self):
        (self.folder / "other").write_text("")
        git(self.folder, "init", "-q")
        git(self.folder, "add", "other")
        git(self.folder, "commit", "-qm", "x")
        self.refused("make dist needs a clone with git whose last commit has these sources")

    def test_dist_without_a_commit(self):
        git(self.root, "init", "-q")
        self.refused("make dist needs a clone with git whose last commit has these sources")

    def test_dist_without_gzip(self):
        self.commit()
        self.refused("make dist needs gzip; Debian: apt-get install gzip", PATH=self.path_without("gzip"))

    def test_dist_if_a_program_fails(self):
        self.commit()
        (self.folder / "gzip").write_text("#!/bin/sh\necho 'gzip: no room' >&2; exit 1\n")
        (self.folder / "gzip").chmod(0o755)
        self.refused("build/cds55xx-.tar.gz is not written: mend this, and repeat: gzip: no room",
                     PATH=f"{self.folder}:{os.environ['PATH']}")

    def test_dist_replaces_the_earlier_archive(self):
        self.commit()
        self.assertEqual(self.dist(), (0, "build/cds55xx-.tar.gz\n"))
        self.assertEqual(call("tar", "-tf", self.archive), (0, "cds55xx-/\ncds55xx-/Makefile\n"))
        self.assertEqual(list((self.root / "build").iterdir()), [self.archive])


class Installed(Case):
    """install.py of a copy of the tree; the simulator is a text, and so is the library, of 200 KB."""

    def setUp(self):
        super().setUp()
        self.root = self.folder / "sources"
        for name in ["include", "packaging", "boards"]:
            shutil.copytree(ROOT / name, self.root / name)
        for name in ["scripts/install.py", "scripts/version.py", "scripts/plot.gp", "scripts/send-lines.py", "mk/constants.ld",
                     "LICENSE", "README.md"]:
            (self.root / name).parent.mkdir(exist_ok=True)
            shutil.copy(ROOT / name, self.root / name)
        for name in ["host/cds55xx-sim", "lib/libcds55xx-atmega328p.a", "lib/libcds55xx-atmega64.a"]:
            (self.root / "build" / name).parent.mkdir(parents=True, exist_ok=True)
            (self.root / "build" / name).write_text("x" * (200_000 if name.endswith("64.a") else 10))
        self.prefix = self.folder / "prefix"
        self.manifest = self.prefix / "share/cds55xx/manifest"

    def run_it(self, order, *words, room=resource.RLIM_INFINITY, **environment):
        """No file becomes larger than `room`: Python takes the error as that of a full disk."""
        return call(sys.executable, self.root / "scripts/install.py", order, "--prefix", self.prefix, *words,
                    env={**ENVIRONMENT, **environment}, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room)))

    def install(self, mcus="atmega328p", **options):
        return self.run_it("install", "--mcus", mcus, **options)

    def uninstalls(self):
        status, output = self.run_it("uninstall")
        self.assertEqual(status, 0, output)
        self.assertRegex(output, rf"^removed cds55xx from {re.escape(str(self.prefix))}: \d+ files\n$")

    def contents(self):
        return {str(path.relative_to(self.prefix)): path.read_bytes() if path.is_file() else None
                for path in self.prefix.rglob("*")}

    def test_install_on_a_full_disk_keeps_the_earlier_installation(self):
        self.assertEqual(self.install()[0], 0)
        before = self.contents()
        (self.root / "boards/new").mkdir()
        (self.root / "boards/new/board.h").write_text("")
        for name in ["README.md", "include/cds55xx/version.h"]:
            with open(self.root / name, "a", encoding="utf-8") as file:
                file.write("\n")
        self.assertEqual(self.install("atmega328p atmega64", room=100_000), (
            1, f"install.py: {self.prefix}/lib/cds55xx/libcds55xx-atmega64.a: File too large; the earlier installation "
               "is kept: make room or set the permissions, or name another PREFIX\n"))
        self.assertEqual(self.contents(), before)
        self.assertRegex(self.install(room=1000)[1], f"^install.py: {self.manifest}: File too large; the earlier installation is kept: ")
        self.assertEqual(self.contents(), before)
        self.uninstalls()
        self.assertFalse(self.prefix.exists())

    def test_install_on_a_full_disk_leaves_nothing(self):
        self.prefix.mkdir()
        for room in [100_000, 1000, 0]: # a large file, the manifest, nothing
            status, output = self.install("atmega64", room=room)
            self.assertEqual(status, 1)
            self.assertRegex(output, f"^install.py: {self.prefix}/.*: File too large; nothing is installed: make room.*\n$")
            self.assertEqual(self.contents(), {})

    def test_install_that_is_killed_can_be_uninstalled(self):
        """os.replace ends the program after so many calls; the first puts the manifest in place."""
        self.assertEqual(self.install()[0], 0)
        for calls in [1, 2, 20]:
            program = ("import os, runpy, sys\nreplace, calls = os.replace, []\n"
                       "def replace_or_end(*names):\n    replace(*names)\n    calls.append(names)\n"
                       f"    if len(calls) == {calls}: os._exit(9)\n"
                       "os.replace = replace_or_end\nsys.path[0] = os.path.dirname(sys.argv[1])\nrunpy.run_path(sys.argv.pop(1), run_name='__main__')\n")
            self.assertEqual(call(sys.executable, "-c", program, self.root / "scripts/install.py", "install", "--prefix",
                                  self.prefix, "--mcus", "atmega64"), (9, ""))
            self.uninstalls()
            self.assertFalse(self.prefix.exists())

    def change_header(self):
        with open(self.root / "include/cds55xx/units.h", "a", encoding="utf-8") as file:
            file.write("\n")

    def test_install_over_another_one_removes_what_it_no_longer_has(self):
        self.assertEqual(self.install("atmega328p atmega64")[0], 0)
        shutil.rmtree(self.root / "boards/cm510")
        self.change_header()
        status, output = self.install()
        self.assertEqual(status, 0)
        self.assertIn("\nremoved, since the headers have changed: atmega64; to install them again: make install "
                      f'PREFIX={self.prefix} MCUS="atmega64"\n', output)
        second = self.contents()
        self.assertFalse({name for name in second if "cm510" in name or "atmega64" in name or "new" in name})
        self.uninstalls()
        self.assertFalse(self.prefix.exists())
        self.assertEqual(self.install()[0], 0)
        self.assertEqual({**self.contents(), "share/cds55xx/manifest": ""}, {**second, "share/cds55xx/manifest": ""})

    def test_install_of_another_chip_keeps_the_library_of_the_first(self):
        self.assertEqual(self.install("atmega64")[0], 0)
        (self.root / "build/lib/libcds55xx-atmega64.a").unlink()  # make builds the chips of MCUS only
        for _ in range(2):
            status, output = self.install("atmega328p")
            self.assertEqual(status, 0, output)
            self.assertIn(" for 1 chip\nkept, not rebuilt: atmega64; to build and install them: make install "
                          f'PREFIX={self.prefix} MCUS="atmega64"\n', output)
            now = self.contents()
            self.assertEqual(len(now["lib/cds55xx/libcds55xx-atmega64.a"]), 200_000)
            for mcu in ["atmega64", "atmega328p"]:
                self.assertIn(f"Name: cds55xx-{mcu}\n".encode(), now[f"lib/pkgconfig/cds55xx-{mcu}.pc"])
            self.assertIn(b"set(cds55xx_MCUS atmega328p atmega64)", now["lib/cmake/cds55xx/cds55xx-config.cmake"])
        self.uninstalls()
        self.assertFalse(self.prefix.exists())

    def test_install_of_a_new_header_removes_libraries_of_old_ones(self):
        for change in [self.change_header, lambda: (self.root / "include/cds55xx/more.h").write_text("")]:
            self.assertEqual(self.install("atmega328p atmega64")[0], 0)
            change()
            self.assertIn("removed, since the headers have changed: atmega64;", self.install()[1])
            self.assertNotIn("lib/cds55xx/libcds55xx-atmega64.a", self.contents())

    def test_install_prints_each_variable_that_lacks_its_folder(self):
        line = (f"export PKG_CONFIG_PATH={self.prefix}/lib/pkgconfig PATH={self.prefix}/bin:$PATH\n")
        self.assertTrue(self.install()[1].endswith(line))
        packages = {"PKG_CONFIG_PATH": f"/x:{self.prefix}/lib/pkgconfig"}
        programs = {"PATH": f"{os.environ['PATH']}:{self.prefix}/bin"}
        self.assertTrue(self.install(**packages)[1].endswith(f"\nexport PATH={self.prefix}/bin:$PATH\n"))
        self.assertTrue(self.install(**programs)[1].endswith(f"\nexport PKG_CONFIG_PATH={self.prefix}/lib/pkgconfig\n"))
        self.assertEqual(self.install(**packages, **programs)[1].count("\n"), 1)
        self.assertEqual(self.run_it("install", "--mcus", "atmega64", "--destdir", self.folder / "image")[1].count("\n"), 1)
        for prefix, lines in [("/usr/local", 0), ("/usr", 0), ("/opt/cds", 2)]:
            program = f"import install, pathlib, types; install.tell_path(pathlib.Path('{prefix}'), types.SimpleNamespace(destdir=''))"
            self.assertEqual(call(sys.executable, "-c", program, cwd=self.root / "scripts")[1].count("\n"), lines)

    def test_install_where_a_folder_has_the_name_of_a_file(self):
        (self.prefix / "bin/cds55xx-sim").mkdir(parents=True)
        self.assertEqual(self.install(), (
            1, f"install.py: {self.prefix}/bin/cds55xx-sim is a folder, where a file must be; move it away, or name "
               "another PREFIX\n"))
        self.assertEqual(set(self.contents()), {"bin", "bin/cds55xx-sim"})

    def test_uninstall_with_a_damaged_manifest_removes_nothing(self):
        self.assertEqual(self.install()[0], 0)
        text = self.manifest.read_text()
        first = text.splitlines()[0]
        for damaged, line in [
                (text + "garbage\n", text.count("\n") + 1), ("\n" + text, 1), ("", 1), (text[:-3], text.count("\n")),
                (text[:text.index("\nfile share/cds55xx/boards/") + 27], None), (first + "\nfile lib\n", 2),
                (first + "\nfile /etc/none\n", 2), (first + "\nfile ../none\n", 2), ("file \0\n" + text, 1),
                ("file \udcff\n" + text, 1), ("fold bin\n" + text, 1)]:
            self.manifest.write_text(damaged, errors="surrogateescape")
            before = self.contents()
            status, output = self.run_it("uninstall")
            self.assertEqual(status, 1, output)
            self.assertRegex(output, f"^install.py: {self.manifest}, line {line or '[0-9]+'} is damaged, nothing is "
                                     r"removed; make install into the same PREFIX writes it anew, then make uninstall\n$")
            self.assertEqual(self.contents(), before)
        self.assertEqual(self.install()[0], 0)
        self.uninstalls()
        self.assertEqual([path for path in self.prefix.rglob("*") if not path.is_dir()], [])


class Release(Case):
    """release.py in a repository of two files."""

    def setUp(self):
        super().setUp()
        self.root = self.folder / "sources"
        self.root.mkdir()
        (self.root / "firmware").write_text("x")
        (self.root / ".gitignore").write_text("build\n")
        self.release = self.root / "build/release"
        self.release.mkdir(parents=True)
        (self.release / "earlier").write_text("")
        git(self.root, "init", "-q")
        git(self.root, "add", ".")
        git(self.root, "commit", "-qm", "x")

    def run_it(self, file="firmware", **environment):
        return call(sys.executable, ROOT / "scripts/release.py", "build/release", "p", f"{file}:name", cwd=self.root,
                    env={**ENVIRONMENT, **environment})

    def refused(self, message, *file, **environment):
        status, output = self.run_it(*file, **environment)
        self.assertEqual(status, 1)
        self.assertRegex(output, f"^{message}.*\n$")
        self.assertEqual([str(path.relative_to(self.root)) for path in self.root.glob("build/**/*")],
                         ["build/release", "build/release/earlier"])

    def test_release_without_git(self):
        self.refused("make release needs a clone with git", PATH=str(self.folder))

    def test_release_without_a_commit(self):
        shutil.rmtree(self.root / ".git")
        git(self.root, "init", "-q")
        self.refused("make release needs a clone with git")

    def test_release_if_git_archive_fails(self):
        stub = self.folder / "git"
        stub.write_text(f'#!/bin/sh\n[ $1 != archive ] || {{ echo half; exit 1; }}\nexec {shutil.which("git")} "$@"\n')
        stub.chmod(0o755)
        self.refused("git archive fails: .* git archive HEAD", PATH=f"{self.folder}:{os.environ['PATH']}")

    def test_release_without_a_file(self):
        self.refused("none: No such file or directory; build/release is as it was", "none")

    def test_release_replaces_the_earlier_one(self):
        self.assertEqual(self.run_it(), (0, "2 files and SHA256SUMS in build/release\n"))
        self.assertEqual(sorted(path.name for path in self.root.glob("build/*/*")), ["SHA256SUMS", "p-name", "p.tar.gz"])
        self.assertEqual(call("tar", "-tf", self.release / "p.tar.gz"), (0, "p/\np/.gitignore\np/firmware\n"))


if __name__ == "__main__":
    unittest.main()
