# SPDX-License-Identifier: MIT
"""make release of one board: its files, and the same bytes from two clones in different folders."""
import hashlib
import io
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/runs"))
sys.path.insert(0, str(ROOT / "scripts"))

import release
from simulator import call

WHEN = "2020-01-01T00:00:00Z"
ENVIRONMENT = {**os.environ, "MAKEFLAGS": "", "GIT_AUTHOR_DATE": WHEN, "GIT_COMMITTER_DATE": WHEN}
VERSION = re.search(r'CDS_VERSION "(.*)"', (ROOT / "include/cds55xx/version.h").read_text())[1]


def git(folder, *words):
    subprocess.run(["git", "-C", folder, "-c", "user.name=x", "-c", "user.email=x@x", *words], check=True,
                   stdout=subprocess.DEVNULL, env=ENVIRONMENT)


def clone(folder):
    """A clone of the tree as it is now, with one commit."""
    folder.mkdir()
    files = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                           stdout=subprocess.PIPE, check=True).stdout
    tar = subprocess.run(["tar", "-c", "--null", "-T", "-"], cwd=ROOT, input=files, stdout=subprocess.PIPE).stdout
    subprocess.run(["tar", "-x", "-C", folder], input=tar, check=True)
    git(folder, "init", "-q")
    git(folder, "add", "-A")
    git(folder, "commit", "-qm", "x")


class Release(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.clones = [pathlib.Path(folder.name, name) for name in ["one", "another"]]
        for path in cls.clones:
            clone(path)

    def make(self, path):
        return call("make", "-C", path, "-s", "--no-print-directory", "release", "BOARD=arduino-uno",
                    "BOARDS=arduino-uno", "MCUS=atmega328p", env=ENVIRONMENT)

    def test_release_two_clones_same_bytes_and_right_sums(self):
        contents = []
        for path in self.clones:
            status, output = self.make(path)
            self.assertEqual(status, 0, output)
            contents.append({file.name: file.read_bytes() for file in (path / "build/release").iterdir()})
        one, another = contents
        self.assertEqual([name for name in one if one[name] != another.get(name)], [])
        self.assertEqual(set(one), set(another))
        sums = one.pop("SHA256SUMS").decode()
        self.assertEqual(sums, "".join(f"{hashlib.sha256(one[name]).hexdigest()}  {name}\n" for name in sorted(one)))
        for name in [f"cds55xx-{VERSION}-arduino-uno-firmware.{kind}" for kind in ["elf", "hex"]]:
            self.assertIn(name, one)
        self.assertIn(f"cds55xx-{VERSION}.tar.gz", one)
        with zipfile.ZipFile(io.BytesIO(one[f"cds55xx-{VERSION}-panel.zip"])) as panel:
            texts = {name.split("/")[1]: panel.read(name).decode() for name in panel.namelist()}
        self.assertLessEqual({"index.html", "app.js", "style.css", "LICENSE.txt"}, set(texts))
        self.assertIn("BSD 3-Clause", texts["LICENSE-lit.txt"])
        self.assertIn("Redistribution and use in source and binary forms", texts["LICENSE-lit.txt"])
        self.assertIn("Permission is hereby granted", texts["LICENSE-uplot.txt"])
        self.assertEqual(sum(name.endswith(".a") for name in one), 1)

    def test_release_change_not_committed_is_refused(self):
        path = self.clones[0]
        (path / "README.md").write_text("changed\n")
        self.addCleanup(git, path, "checkout", "-q", "README.md")
        status, output = call(sys.executable, path / "scripts/release.py", "build/none", "x", cwd=path)
        refused = "not in the last commit: README.md; commit or remove them, so that sources and firmware agree\n"
        self.assertEqual((status, output), (1, refused))
        status, output = self.make(path)
        self.assertEqual(status, 2, output)
        self.assertTrue(output.startswith(refused), output)  # before the build


class Replace(unittest.TestCase):
    """The folder of the release is replaced at the end, by two renames."""
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.target = pathlib.Path(folder.name, "release")
        self.target.mkdir()
        (self.target / "file").write_text("old")
        self.answers = unittest.mock.patch.object(release, "git", lambda *words: b"" if "status" in words else b"x")

    def run_with(self, rename):
        with self.answers, unittest.mock.patch.object(pathlib.Path, "rename", rename):
            return release.main(str(self.target), "x")

    def test_release_second_rename_fails_keeps_the_old_one(self):
        renames, original = [], pathlib.Path.rename

        def rename(path, to):
            renames.append(path)
            if len(renames) == 2:
                raise OSError(28, "No space left on device", str(path))
            return original(path, to)

        said = self.run_with(rename)
        self.assertIn("is as it was", said)
        self.assertEqual((self.target / "file").read_text(), "old")
        self.assertEqual([path.name for path in self.target.parent.iterdir()], ["release"])

    def test_release_killed_between_renames_is_put_back(self):
        self.target.rename(self.target.with_suffix(".old"))
        with unittest.mock.patch.object(release, "fill", side_effect=OSError(28, "No space left on device")):
            said = self.run_with(pathlib.Path.rename)
        self.assertIn("is as it was", said)
        self.assertEqual((self.target / "file").read_text(), "old")


if __name__ == "__main__":
    unittest.main()
