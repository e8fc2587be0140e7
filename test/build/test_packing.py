# SPDX-License-Identifier: MIT
"""make dist, install, uninstall and release if something goes wrong: one line says it, and what was there is kept."""
import os
import pathlib
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
        for place in os.environ["PATH"].split(":"):
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

    def test_dist_in_a_folder_that_the_repository_around_it_does_not_have(self):
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


if __name__ == "__main__":
    unittest.main()
