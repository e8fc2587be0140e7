#!/usr/bin/env python3
"""Checks the documents: the target of every relative link exists, its heading too, and so does every
file that stands in code marks, such as `src/core/bus/bus.c`.

usage: links.py [FILE...]    the files of git that end in .md if none is named. Exit 1 if one is missing.
"""
import functools
import pathlib
import re
import subprocess
import sys

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
ELSEWHERE = re.compile(r"[a-z]+:")  # https:, mailto:
FILE = re.compile(r"`((?:boards|examples|include|mk|scripts|sim|src|test)/[\w./*-]+)`")
EXAMPLES = re.compile(r"/myboard/|/x\.")  # files that a text invents
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
    if path.name == "CHANGELOG.md":  # it names files of its time
        return
    for name in FILE.findall(text_of(path)):
        if not EXAMPLES.search(name) and not list(pathlib.Path().glob(name)):
            yield f"{path}: {name}: there is no such file"


def main(names):
    names = names or subprocess.run(["git", "ls-files", "*.md"], stdout=subprocess.PIPE, text=True,
                                    check=True).stdout.split()
    wrong = [line for name in names for line in broken(pathlib.Path(name))]
    for line in wrong:
        print(line, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
