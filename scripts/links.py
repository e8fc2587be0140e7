#!/usr/bin/env python3
"""Checks the documents: the target of every relative link exists, and so does its heading.

usage: links.py [FILE...]    the files of git that end in .md if none is named. Exit 1 if a link is broken.
"""
import functools
import pathlib
import re
import subprocess
import sys

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
ELSEWHERE = re.compile(r"[a-z]+:")  # https:, mailto:
CODE = re.compile(r"^```.*?^```$", re.M | re.S)


@functools.lru_cache
def text_of(path):
    return CODE.sub("", path.read_text())


def anchor(heading):
    """The name that GitHub and GitLab give to a heading."""
    words = re.sub(r"[^\w\- ]", "", heading.replace("`", "").lower().strip())
    return words.replace(" ", "-")


@functools.lru_cache
def anchors(path):
    return {anchor(heading) for heading in re.findall(r"^#+ +(.*)$", text_of(path), re.M)}


def broken(path):
    for link in LINK.findall(text_of(path)):
        if ELSEWHERE.match(link):
            continue
        name, _, heading = link.partition("#")
        target = path.parent / name if name else path
        if not target.exists():
            yield f"{path}: {link}: there is no such file"
        elif heading and heading not in anchors(target):
            yield f"{path}: {link}: there is no such heading"


def main(names):
    names = names or subprocess.run(["git", "ls-files", "*.md"], stdout=subprocess.PIPE, text=True,
                                    check=True).stdout.split()
    wrong = [line for name in names for line in broken(pathlib.Path(name))]
    for line in wrong:
        print(line, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
