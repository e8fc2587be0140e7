#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Collects a release: copies files, packs the sources of the last commit, and writes SHA256SUMS.

usage: release.py DIR PREFIX FILE:NAME...    DIR/PREFIX-NAME is a copy of FILE, DIR/PREFIX.tar.gz the sources
       release.py --check    only tells what refuses a release: make asks before it builds
The same commit gives the same bytes. Exit 1 if there is no commit, or if what was built is not the commit. DIR is
replaced when all files are there: an error leaves it as it was.
"""
import gzip
import hashlib
import pathlib
import shutil
import subprocess
import sys


def git(*words):
    """What git prints; None if it fails, and then git has told why, or if it is not installed."""
    try:
        done = subprocess.run(["git", *words], stdout=subprocess.PIPE)
    except FileNotFoundError:
        return None
    return done.stdout if done.returncode == 0 else None


def fill(target, prefix, files, sources):
    """Makes the folder with all its files; returns those that SHA256SUMS names."""
    target.mkdir(parents=True)
    for file in files:
        source, name = file.split(":")
        shutil.copyfile(source, target / f"{prefix}-{name}")
    (target / f"{prefix}.tar.gz").write_bytes(gzip.compress(sources, mtime=0))
    names = sorted(target.iterdir())
    (target / "SHA256SUMS").write_text("".join(
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in names))
    return names


def put_back(target, old):
    """A run that ended between its two renames has left the earlier release in `old`."""
    if old.exists() and not target.exists():
        old.rename(target)


def refusal():
    """Why the tree cannot be released; None: it can."""
    if not git("rev-parse", "-q", "--verify", "HEAD"):
        return "make release needs a clone with git: it packs the sources of the last commit"
    changed = git("status", "--porcelain").decode().splitlines()
    if changed:
        return f"not in the last commit: {', '.join(line[3:] for line in changed[:5])}; commit or remove them, so that " \
            "sources and firmware agree"
    return None


def main(folder, prefix, *files):
    why = refusal()
    if why:
        return why
    sources = git("archive", "--format=tar", f"--prefix={prefix}/", "HEAD")
    if not sources:
        return f"git archive fails: {folder} is as it was; mend what this says: git archive HEAD > /dev/null"
    target, new, old = [pathlib.Path(folder + end) for end in ["", ".new", ".old"]]
    put_back(target, old)
    for rest in [new, old]:
        shutil.rmtree(rest, ignore_errors=True)
    try:
        names = fill(new, prefix, files, sources)
        if target.exists():
            target.rename(old)
        new.rename(target)
    except OSError as error:
        put_back(target, old)
        shutil.rmtree(new, ignore_errors=True)
        return f"{error.filename2 or error.filename or new}: {error.strerror}; {folder} is as it was: mend this, and repeat"
    shutil.rmtree(old, ignore_errors=True)
    print(f"{len(names)} files and SHA256SUMS in {folder}")
    return 0


if __name__ == "__main__":
    sys.exit(refusal() if sys.argv[1:] == ["--check"] else main(*sys.argv[1:]))
