#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Puts the files that the pages of the site lead to beside them, and checks every link between pages.

usage: site.py DIR    DIR: what Doxygen has made. Exit 1 if a link leads nowhere.
"""
import html.parser
import pathlib
import shutil
import sys
import urllib.parse

LINKS = {"a": "href", "link": "href", "img": "src", "script": "src", "object": "data", "iframe": "src"}


class Page(html.parser.HTMLParser):
    """The links and the anchors of a page."""

    def __init__(self, path):
        super().__init__()
        self.links, self.anchors = [], set()
        self.feed(path.read_text())

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.anchors |= {values[name] for name in ("id", "name") if values.get(name)}
        if values.get(LINKS.get(tag)):
            self.links.append(values[LINKS[tag]])


def copy(site, name):
    """Copies a file or a folder of the tree to files/NAME of the site."""
    source, target = pathlib.Path(name), site / "files" / name
    target.parent.mkdir(parents=True, exist_ok=True)
    if source.is_dir():
        shutil.copytree(source, target)
    elif source.is_file():
        shutil.copyfile(source, target)


def broken(site):
    pages = {path.name: Page(path) for path in sorted(site.glob("*.html"))}
    for name, page in pages.items():
        for link in page.links:
            url = urllib.parse.urlsplit(link)
            file = urllib.parse.unquote(url.path) or name
            if url.scheme or link.startswith("#") and not url.fragment or file.startswith("javascript:"):
                continue
            if file.startswith("files/") and not (site / file).exists():
                copy(site, file.removeprefix("files/"))
            if not (site / file).exists():
                yield f"{name}: {link}: there is no such file"
            elif url.fragment and file in pages and url.fragment not in pages[file].anchors:
                yield f"{name}: {link}: there is no such place in the page"


def main(folder):
    wrong = sorted(set(broken(pathlib.Path(folder))))
    print(*wrong, sep="\n", end="\n" if wrong else "", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
