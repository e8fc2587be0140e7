#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the documents: the target of every relative link exists in git, its heading too, and so does every
file that stands in code marks, such as `src/core/bus/bus.c`. docs/index.md links every page of docs/.

usage: links.py [FILE...]    the files of git that end in .md if none is named. Exit 1 if one is missing.
"""
import collections
import functools
import os
import pathlib
import re
import subprocess
import sys

CODE = re.compile(r"^ *(```|~~~).*?^ *\1$", re.M | re.S)
MARKED = re.compile(r"`[^`\n]*`")
INLINE = re.compile(r"\]\(\s*<?([^)\s>]+)")  # [text](target "title"), ![image](target)
HTML = re.compile(r"<[^>]*\b(?:href|src)\s*=\s*[\"']?([^\"'\s>]+)", re.I)
DEFINITION = re.compile(r"^ {0,3}\[([^\]]+)\]:\s*<?([^\s>]+)", re.M)  # [label]: target
REFERENCE = re.compile(r"\[([^\[\]]+)\]\[([^\[\]]*)\]")  # [text][label], [label][]
HEADING = re.compile(r"^#+ +(.*?)(?: +#+)?$|^(\S.*)\n(?:=+|-+)$", re.M)
HTML_ANCHOR = re.compile(r"<[^>]*\b(?:id|name)\s*=\s*[\"']?([^\"'\s>]+)", re.I)
ELSEWHERE = re.compile(r"[a-z]+:")  # https:, mailto:
FILE = re.compile(r"`((?:arduino|boards|docs|examples|include|mk|packaging|panel|scripts|sim|src|test)/[\w./*-]+)`")
EXAMPLES = re.compile(r"/myboard/|/x\.")  # files that a text invents


@functools.lru_cache
def text_of(path):
    return CODE.sub("", path.read_text())


@functools.lru_cache
def in_git():
    """The files of git, or that could be added, and their folders. Not those of build/."""
    names = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"],
                           stdout=subprocess.PIPE, text=True, check=True).stdout.splitlines()
    files = {pathlib.Path(name).resolve() for name in names if os.path.exists(name)}
    return files | {folder for file in files for folder in file.parents
                    if folder.is_relative_to(pathlib.Path.cwd())}


@functools.lru_cache
def anchors_in_order(path):
    """The names that GitHub and GitLab give to the headings: a second `Map` is `map-1`."""
    seen, names = collections.Counter(), []
    for heading in HEADING.findall(text_of(path)):
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", "".join(heading))
        name = re.sub(r"[^\w\- ]", "", text.lower().strip()).replace(" ", "-")
        names.append(f"{name}-{seen[name]}" if seen[name] else name)
        seen[name] += 1
    return names


def anchors(path):
    return {*HTML_ANCHOR.findall(text_of(path)), *anchors_in_order(path)}


def broken_link(path, link):
    """What is wrong with a link of the document `path`, or None."""
    name, _, heading = link.partition("#")
    target = (path.parent / name if name else path).resolve()
    if name.startswith("/") or (name and target not in in_git()):
        return "there is no such file"
    if heading and (target.suffix != ".md" or heading not in anchors(target)):
        return "there is no such heading"
    return None


def broken(path):
    text = MARKED.sub("``", text_of(path))
    definitions = {label.lower(): target for label, target in DEFINITION.findall(text)}
    for link in INLINE.findall(text) + HTML.findall(text) + list(definitions.values()):
        wrong = None if ELSEWHERE.match(link) else broken_link(path, link)
        if wrong:
            yield f"{path}: {link}: {wrong}"
    for first, second in REFERENCE.findall(text):
        if (second or first).lower() not in definitions:
            yield f"{path}: [{second or first}]: there is no such label"
    for name in FILE.findall(text_of(path)):
        if not EXAMPLES.search(name) and not list(pathlib.Path().glob(name)):
            yield f"{path}: {name}: there is no such file"


def not_in_index():
    """The pages of docs/ that docs/index.md does not link."""
    index = pathlib.Path("docs/index.md")
    linked = {(index.parent / link.partition("#")[0]).resolve() for link in INLINE.findall(text_of(index))}
    for page in sorted(pathlib.Path("docs").rglob("*.md")):
        if page != index and page.resolve() not in linked:
            yield f"{index}: {page}: no link leads to this page"


def main(names):
    everything = not names
    names = names or subprocess.run(["git", "ls-files", "*.md"], stdout=subprocess.PIPE, text=True,
                                    check=True).stdout.split()
    wrong = [line for name in names for line in broken(pathlib.Path(name))]
    if everything:
        wrong += not_in_index()
    for line in wrong:
        print(line, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
