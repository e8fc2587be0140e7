#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Filters one file for Doxygen (INPUT_FILTER of mk/Doxyfile): prints it in the form that Doxygen reads.

usage: doxygen_filter.py FILE

These comments of a header become comments of Doxygen:
  the comment at the top           of the file
  a comment before declarations    of each declaration up to the next empty line
  // text behind a declaration     of that declaration
Fields are left out behind a line `// internal:` and in a struct whose comment says that its fields are
internal. An enum whose values come from a list of X() rows gets these rows as its values.

A document (.md): its headings get labels, its links lead to the pages and files of the site.
"""
import os
import pathlib
import re
import sys
import textwrap

import links  # anchors()

# ---- headers ----------------------------------------------------------------------------------------

SPECIAL = re.compile(r"([\\@<>#%*|\[\]\"~])")
CODE_MARKS = re.compile(r"(`[^`]*`)")
ENUM_OF_LIST = re.compile(r"#define (\w+_ENUM_)\(([^)]*)\)\s*\\?\s*([^\n]*)\n\s*(\w+)\(\1\)\n#undef \1\n")
SEVERAL = re.compile(r"(\s+)([\w ]+? )(\w+(?:, \w+)+);")  # uint8_t id, address;


def escaped(text):
    """`text` without a meaning for Doxygen, but for what stands in code marks."""
    return "".join(part if part.startswith("`") else SPECIAL.sub(r"\\\1", part)
                   for part in CODE_MARKS.split(text))


def is_list(line):
    return re.match(r"\s*(?:-|\d+\.) ", line)


def paragraph(rows):
    """A paragraph of a comment. Rows that are indented keep their form, unless they are a list."""
    inner = [n for n, row in enumerate(rows) if row.startswith("  ")]
    if not inner or is_list(rows[inner[0]]):
        return "\n".join(escaped(row) if is_list(row) else escaped(row.strip()) for row in rows)
    first, behind = inner[0], inner[-1] + 1
    form = "\n@verbatim\n" + textwrap.dedent("\n".join(rows[first:behind])) + "\n@endverbatim\n"
    return escaped("\n".join(rows[:first])) + form + escaped("\n".join(rows[behind:]))


def of_doxygen(comment, command=""):
    """A plain comment as one of Doxygen."""
    text = re.sub(r"^\s*\*(?: |$)", "", comment.strip()[2:-2], flags=re.M).rstrip()
    parts = [paragraph(part.strip("\n").split("\n")) for part in re.split(r"\n[ \t]*\n", text)]
    return "/** " + command + "\n\n".join(parts).strip() + " */\n"


def values_of_list(match, text):
    """The values of an enum that a list of X() rows makes, each with its row as comment."""
    name, number, *others = [word.strip() for word in match[2].split(",")]
    rows = re.search(rf"#define {match[4]}\(X\)(.*?[^\\])\n", text, re.S)[1]
    for row in re.split(r"\bX\(", re.sub(r"\s*\\\n\s*", " ", rows))[1:]:
        words = [word.strip(' ")') for word in re.findall(r'"[^"]*"|[^,"]+', row) if word.strip()]
        value = match[3].replace("##" + name, words[0])
        value = re.sub(rf"\b{name}\b", words[0], re.sub(rf"\b{number}\b", words[1], value))
        yield f"    {value} // " + "; ".join(map(": ".join, zip(others, words[2:]))) + "\n"


class Lines:
    """The lines of a header, one thing at a time."""

    def __init__(self, text):
        self.lines = text.splitlines(keepends=True)

    def until(self, is_last):
        text = self.lines.pop(0)
        line = text
        while not is_last(line):
            line = self.lines.pop(0)
            text += line
        return text

    def things(self):
        """Yields (kind, text, comment behind it)."""
        while self.lines:
            line = self.lines[0]
            if line.startswith("{"):
                yield "body", self.until(lambda line: line.startswith("}")), ""
            elif line.lstrip().startswith("/*"):
                yield "comment", self.until(lambda line: "*/" in line), ""
            elif line.startswith("#"):
                text = self.until(lambda line: not line.endswith("\\\n"))
                yield ("define", *self.behind(text)) if text.startswith("#define") else ("", text, "")
            elif line.lstrip().startswith("//"):
                yield "note", self.lines.pop(0), ""
            elif not line.strip() or line.startswith(("extern \"C\"", "}")):
                yield "blank", self.lines.pop(0), ""
            else:
                end = re.compile(r"[;{,}]\s*(?:__attribute__\(\(packed\)\);)?\s*(//.*)?$|//")
                if not line.startswith(" "): # a declaration, up to its end or to the body
                    end = re.compile(r"[;{]\s*(//.*)?$")
                text = self.until(lambda line: end.search(line) or not self.lines or self.lines[0].startswith("{"))
                yield "code", *self.behind(text)

    def behind(self, text):
        """The text and the comment behind its last line, which may go on in the next lines."""
        code, mark, comment = text.partition("//")
        if not mark:
            return text, ""
        column = len(text.split("\n")[-2].partition("//")[0])
        while self.lines and re.match(" {%d}//" % column, self.lines[0]):
            comment += " " + self.lines.pop(0).strip()[2:]
        return code.rstrip() + "\n", " ".join(comment.split())


def header(text):
    """The parts of a header for Doxygen."""
    text = re.sub(r"^(?:// SPDX|/\* SPDX).*\n", "", text, flags=re.M)
    text = ENUM_OF_LIST.sub(lambda match: "".join(values_of_list(match, text)), text)
    comment, is_first, is_hidden = "", True, False
    for kind, code, behind in Lines(text).things():
        if kind == "comment" and is_first:
            yield of_doxygen(code, "@file\n")
            is_first = False
        elif kind == "comment":
            comment = of_doxygen(code)
        elif kind == "note" or code.startswith("}"):
            if is_hidden:
                yield "/** @endcond */\n"
            is_hidden = kind == "note" and "internal" in code
            yield "/** @cond */\n" if is_hidden else code
        elif kind == "blank":
            comment = ""
            yield code
        elif kind in ("code", "define"):
            yield comment
            yield with_comment(code, f"/**< {escaped(behind)} */" if behind else "")
            if code.startswith("struct") and "fields are internal" in " ".join(comment.split()):
                yield "/** @cond */\n"
                is_hidden = True
            if code.startswith(" ") or code.endswith("{\n"):
                comment = ""
        else:
            yield code


def with_comment(code, comment):
    """`code` with a comment behind it; of several fields each gets the comment."""
    several = SEVERAL.fullmatch(code.rstrip())
    if several and comment:
        return "".join(f"{several[1]}{several[2]}{name}; {comment}\n" for name in several[3].split(", "))
    return f"{code.rstrip()} {comment}\n"


# ---- documents --------------------------------------------------------------------------------------

LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")
ANCHOR = re.compile(r'(<a id=")([^"]*)')
MAIN_PAGE = "docs/index.md"
FENCE = re.compile(r"^( *)(```|~~~)")


def label(path):
    """The name of the page of a document: docs/internals/faults.md is internals-faults."""
    return "-".join(pathlib.PurePath(path).with_suffix("").parts).replace("docs-", "", 1).lower()


def target(path, link):
    """Where `link` of the document `path` leads in the site."""
    if links.ELSEWHERE.match(link):
        return link
    name, _, heading = link.partition("#")
    file = os.path.relpath(os.path.normpath(os.path.join(os.path.dirname(path), name)) if name else path)
    if file.endswith(".md"):
        page = "index" if file == MAIN_PAGE else label(file)
        return f"{page}.html" + (f"#{label(file)}-{heading}" if heading else "")
    if file == "include/cds55xx":
        return "files.html"
    if os.path.dirname(file) == "include/cds55xx" and file.endswith(".h"):
        return os.path.basename(file).replace("_", "__").replace(".h", "_8h.html")
    return "files/" + file


def linked(path, line):
    def one(match):
        if match[1]:
            return f'<img src="files/{os.path.relpath(os.path.join(os.path.dirname(path), match[3]))}" alt="{match[2]}"/>'
        return f"[{match[2]}]({target(path, match[3])})"
    return LINK.sub(one, line)


def document(path, text):
    """The lines of a document for Doxygen."""
    names = iter(links.anchors_in_order(pathlib.Path(path)))
    fence = None
    title = True
    for line in re.sub(r"^<!--.*?-->\n", "", text, flags=re.M | re.S).splitlines():
        mark = FENCE.match(line)
        if mark:
            fence = None if fence == mark[2] else fence or mark[2]
        if fence or mark:
            yield line + "\n"
            continue
        if re.match(r"#+ ", line):
            name = next(names)
            if path != MAIN_PAGE or not title: # Doxygen gives the main page its label
                line += f" {{#{label(path)}}}" if title else f" {{#{label(path)}-{name}}}"
            title = False
        yield linked(path, ANCHOR.sub(rf"\1{label(path)}-\2", line)) + "\n"


def main(path):
    path = os.path.relpath(path)
    text = pathlib.Path(path).read_text()
    sys.stdout.writelines(document(path, text) if path.endswith(".md") else header(text))


if __name__ == "__main__":
    main(sys.argv[1])
