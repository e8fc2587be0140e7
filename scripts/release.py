#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Collects a release: copies files, packs the sources of the last commit, and writes SHA256SUMS.

usage: release.py DIR PREFIX FILE:NAME...    DIR/PREFIX-NAME is a copy of FILE, DIR/PREFIX.tar.gz the sources
The same commit gives the same bytes. Exit 1 if there is no commit, or if what was built is not the commit.
"""
import gzip
import hashlib
import pathlib
import shutil
import subprocess
import sys


def git(*words):
    return subprocess.run(["git", *words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout


def main(folder, prefix, *files):
    if not git("rev-parse", "HEAD"):
        return "make release needs a clone with git: it packs the sources of the last commit"
    if git("status", "--porcelain"):
        return "there are changes that are not committed: commit them, so that sources and firmware agree"
    target = pathlib.Path(folder)
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    for file in files:
        source, name = file.split(":")
        shutil.copyfile(source, target / f"{prefix}-{name}")
    sources = git("archive", "--format=tar", f"--prefix={prefix}/", "HEAD")
    (target / f"{prefix}.tar.gz").write_bytes(gzip.compress(sources, mtime=0))
    sums = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in sorted(target.iterdir())]
    (target / "SHA256SUMS").write_text("".join(sums))
    print(f"{len(sums)} files and SHA256SUMS in {folder}")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
