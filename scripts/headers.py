#!/usr/bin/env python3
"""Is each public header enough to read? Prints file:line: symbol: what is missing; exit 1 if
anything is. Public is what begins with cds_ or CDS_ and does not end in _, in include/cds55xx/*.h,
src/avr/cds55xx_avr.h and src/avr/clock.h.

usage: headers.py [DIR [HEADER ...]]   (the project's root, default: the current directory; headers
                                        to be checked, default: all)

A symbol's comment stands above it, or above a group without blank lines that it belongs to, or
behind it on its line. The head of a file is its first comment and holds for all of it. A comment
that refers to another one ("as cds_x()", "what cds_x() returns", "one of x.h", "those of x.h",
"functions of x.h"), or begins with "cds_x()" or "cds_x() and cds_y()", includes the comment of that
function, or the head of that file; cds_blocking_x() includes those of cds_x_begin() and _poll(). A comment "---- like this ----" heads the functions below it that
have none. Wanted are

  all          a comment; a function that another header documents needs no second one
  struct       of each field, too: behind it, or above a run of fields, or by its name in the struct's
               comment. "... below", "// internal:", "what follows" and "the x's own" cover the fields
               that follow. A field that is a struct of ours is told by that
  macro        each of its parameters by name
  function     of an argument that is a number, its unit by its name (_us, mdeg, byte, ...), or it
               stands in one sentence with a range or unit; a pointer to numbers stands there by name
               its result: CDS_OK and each other enum cds_result that the function's body returns, or
               the field (request->result) it hands on; "true", "false" or a question for a bool; of
               a number, "Returns", a range or a unit; of another enum, one of its names
               its context: Main, Either, Any or Interrupt context, Producer, Consumer, Either side,
               "Event, from ...", "Only within on_...", "From on_rx"

What a body returns is followed through `return f()`, `x = f(); return x` and `return a->x` within
its file, where a->x is whatever any function there sets it to; of an operation, what the calls of
cds_steps_end() in its file have. That a result which is named can really come is not checked, nor
that a sentence is true.
Each header is also compiled alone, as C99 and as C++11; what has no body must be extern "C".
"""
import pathlib
import re
import subprocess
import sys

HEADERS = ["include/cds55xx/*.h", "src/avr/cds55xx_avr.h", "src/avr/clock.h"]

NUMBER = r"(?:u?int\d+_t|unsigned|int|long|size_t|char)"
UNIT_IN_NAME = re.compile(r"(?:^|_)(?:us|ms|mdeg|mrpm|cpct|permille|mv|celsius|bps|byte|word)$", re.I)
RANGE = re.compile(r"\d to |\d or more|at least|at most|<|\bCDS_\w+|\b0x|"
                   r"\b(?:bytes?|bits?|microseconds|degrees|millivolts|counts|unit|number of|register)\b")
CONTEXT = re.compile(r"\b(?:(?:main|either|any|interrupt) context|context: (?:main|either)|either side|"
                     r"producer|consumer|event, (?:from|in place of)|only within on_|from on_rx)", re.I)
REFERENCE = re.compile(r"\b(?:as(?: by)?|what)\s(cds_\w+)\(\)|"
                       r"\b(?:as|one of|those of|functions of)\s(\w+\.h)(?:\sand\s(\w+\.h))?", re.I)
BEGINS_WITH = re.compile(r"(cds_\w+)\(\)(?: and (cds_\w+)\(\))?")
FORMAT = re.compile(r"/\*.*?\*/|//[^\n]*", re.S)


class Symbol:
    def __init__(self, header, line, kind, name, code, comment):
        self.header, self.line, self.kind, self.name = header, line, kind, name
        self.code, self.comment = code, comment
        self.parameters, self.type, self.body = [], "", None


class Header:
    def __init__(self, path, name):
        self.path, self.name = path, name
        self.text = path.read_text()
        self.head = ""
        self.symbols = list(self.parse())

    def parse(self):
        """Each public symbol with the comment that is its own or its group's."""
        text, at, comment, section, last = self.text, 0, "", "", None
        match = re.match(r"\s*/\*.*?\*/", text, re.S)
        if match:
            self.head, at = plain(match.group()), match.end()
        while at < len(text):
            space = re.match(r"\s*", text[at:]).group()
            at += len(space)
            if space.count("\n") > 1:
                comment = ""
            found = None
            if text.startswith("/*", at):
                end = text.index("*/", at) + 2
                comment = plain(text[at:end])
                if comment.startswith("----"):
                    section, comment = comment, ""
            elif text.startswith("//", at):
                end = line_end(text, at)
                if last:
                    last.comment += " " + plain(text[at:end])
            elif text.startswith("#ifdef __cplusplus", at):
                end = text.index("#endif", at) + len("#endif")
            elif text.startswith("#", at):
                end = at + re.match(r"(?:[^\n\\]|\\\n|\\.)*?(?=\s*//|\n|\Z)", text[at:]).end()
                found = self.macro(text[at:end], at, comment)
            else:
                end = declaration_end(text, at)
                found = self.declaration(text[at:end], at, comment)
                if found and found.kind == "function":
                    found.comment = found.comment or section
            last = found or last
            if found and public(found.name):
                yield found
            at = end

    def line(self, at):
        return self.text.count("\n", 0, at) + 1

    def macro(self, text, at, comment):
        match = re.match(r"#define (\w+)(\(([^)]*)\))?(.*)", text, re.S)
        if not match or match[1].endswith("_H"):
            return None
        symbol = Symbol(self, self.line(at), "macro", match[1], text, comment)
        symbol.parameters = [p.strip() for p in (match[3] or "").split(",") if p.strip()]
        return symbol

    def declaration(self, text, at, comment):
        code = FORMAT.sub("", text)
        outside = code.split("{")[0]
        match = re.match(r"(struct|enum)\s*(\w*)\s*$", outside)
        if match:
            name = match[2] or "cds_ (an enum without a name)"
            symbol = Symbol(self, self.line(at), match[1], name, text, comment)
            symbol.body = text[text.index("{") + 1:text.rindex("}")]
            return symbol
        match = re.match(r"(.*?)\b(\w+)\s*\((.*)\)\s*;?\s*$", outside, re.S)
        if match:
            symbol = Symbol(self, self.line(at), "function", match[2], text, comment)
            symbol.type = re.sub(r"\b(static|inline|extern|AVR_INLINE)\b", "", match[1]).strip()
            symbol.parameters = [p.strip() for p in match[3].split(",") if p.strip() != "void"]
            return symbol
        match = re.match(r"extern\s.*?(\w+)\s*(?:\[\w*\])?\s*;$", outside, re.S)
        return Symbol(self, self.line(at), "object", match[1], text, comment) if match else None


def public(name):
    return name.lower().startswith("cds_") and not name.endswith("_")


def plain(comment):
    """One line of text, without what makes it a comment."""
    comment = re.sub(r"^\s*(/\*+|//)|\*/$", "", comment.strip())
    return " ".join(re.sub(r"\n\s*(\*|//)? ?", "\n", comment).split())


def line_end(text, at):
    end = text.find("\n", at)
    return len(text) if end < 0 else end


def declaration_end(text, at):
    """Behind its ; or, of a function with a body, behind the body's }."""
    depth = 0
    is_function = False
    while at < len(text):
        comment = FORMAT.match(text, at)
        if comment:
            at = comment.end()
            continue
        if text[at] == "(" and depth == 0:
            is_function = True
        depth += (text[at] == "{") - (text[at] == "}")
        at += 1
        if depth == 0 and (text[at - 1] == ";" or (text[at - 1] == "}" and is_function)):
            break
    return at


def named(name, text):
    return re.search(rf"\b{re.escape(name)}(?:e?s)?\b", text, re.I)


class Check:
    def __init__(self, root):
        self.root = root
        self.headers = {}
        for path in sorted(p for pattern in HEADERS for p in root.glob(pattern)):
            name = path.relative_to(root).as_posix()
            self.headers[name] = Header(path, name)
        self.functions = {}
        for header in self.headers.values():
            for symbol in header.symbols:
                if symbol.kind == "function" and (symbol.comment or symbol.name not in self.functions):
                    self.functions.setdefault(symbol.name, symbol)
        self.results = set()
        if "include/cds55xx/result.h" in self.headers:
            text = self.headers["include/cds55xx/result.h"].text
            self.results = set(re.findall(r"X\((CDS_\w+), \d+,", text))
        self.sources = Sources(root, self.results)

    def told(self, symbol, seen=()):
        """All that a reader is told: own comment, head, and what they refer to."""
        texts = [symbol.comment, symbol.header.head]
        for match in REFERENCE.finditer(" ".join(texts)):
            for name in filter(None, match.groups()):
                other = self.functions.get(name)
                if other and other.name not in seen:
                    texts.append(self.told(other, (*seen, symbol.name)))
                header = self.headers.get(f"include/cds55xx/{name}")
                if header:
                    texts.append(header.head)
        begins = BEGINS_WITH.match(symbol.comment)
        names = [*filter(None, begins.groups())] if begins else []
        if symbol.name.startswith("cds_blocking_"):
            names += [symbol.name.replace("blocking_", "") + end for end in ("_begin", "_poll")]
        for name in names:
            other = self.functions.get(name)
            if other and other.name not in seen:
                texts.append(self.told(other, (*seen, symbol.name)))
        return ". ".join(texts)

    def missing(self, symbol):
        if not symbol.comment:
            return ["a comment"]
        return {"function": self.function, "struct": self.struct, "macro": self.macro}.get(
            symbol.kind, lambda symbol: [])(symbol)

    def macro(self, symbol):
        return [f"what {p} is" for p in symbol.parameters if not named(p, symbol.comment)]

    def function(self, symbol):
        told = self.told(symbol)
        found = [wrong for p in symbol.parameters for wrong in self.parameter(p, told)]
        found += self.result(symbol, told)
        if not CONTEXT.search(told):
            found.append("its context")
        return found

    def parameter(self, parameter, told):
        match = re.match(rf"(?:const )?{NUMBER} (.*?)(\w+)(?:\[\w*\])?$", parameter)
        if not match or UNIT_IN_NAME.search(match[2]):
            return
        sentences = [s for s in re.split(r"(?<=[.;])\s", told) if named(match[2], s)]
        if "*" in match[1] and not sentences:
            yield f"what {match[2]} is"
        if "*" not in match[1] and not any(RANGE.search(s) for s in sentences):
            yield f"unit or range of {match[2]}"

    def result(self, symbol, told):
        if symbol.type == "enum cds_result":
            names = set(re.findall(r"\bCDS_\w+", told))
            returned = self.sources.returned(symbol.name, told=told) | {"CDS_OK"}
            return [f"its result {r}" for r in sorted(returned & self.results - names)] if (
                names & self.results) else ["its results"]
        if symbol.type == "bool":
            good = re.search(r"\b(true|false)\b|\?", symbol.comment, re.I)
        elif symbol.type.startswith("enum"):
            good = re.search(r"\bCDS_[A-Z]", symbol.comment)
        elif re.match(NUMBER, symbol.type):
            good = (RANGE.search(symbol.comment) or "Returns" in symbol.comment or
                    UNIT_IN_NAME.search(symbol.name))
        else:
            good = symbol.type == "void" or symbol.comment
        return [] if good else ["what it returns"]

    def struct(self, symbol):
        """Fields that nothing tells of."""
        owned = re.compile(r"\b(?:the \w+['’]s|its) own\b|^// internal|what follows", re.I)
        covered = owned.search(symbol.comment)
        above, found = False, []
        for line in re.sub(r"(;[^\n/]*)/\*", r"\1//", symbol.body).splitlines():
            code = FORMAT.sub("", re.sub(r"/\*.*", "", line)).strip()
            comment = line.strip()[len(code):].strip()
            if not line.strip():
                above = False
            elif not code and comment.startswith(("/*", "//")):
                above = True
            covered = covered or "below" in comment or owned.search(comment)
            told = comment or above or covered
            field = re.match(r"(?:volatile |const )*(?:(struct cds_)?\w+ )+", code)
            if code.endswith(";") and not told and field and "struct cds_" not in code:
                names = re.findall(r"(\w+)(?:\[\w+\])?\s*[,;]", code)
                found += [f"what {n} is" for n in names if not named(n, symbol.comment)]
        return found

    def compile(self, header):
        include = ["-I" + str(self.root / "include")]
        chip = ["-mmcu=atmega128", "-DF_CPU=16000000UL", "-Os"]
        if header.name.startswith("src/avr"):
            include += [f"-I{self.root / d}" for d in ["src/avr", "boards/atmega128"]]
            c = ["avr-gcc", *chip, "-std=gnu99", "-x", "c"]
        else:
            c = ["gcc", "-std=c99", "-pedantic-errors", "-x", "c"]
        cpp = ["avr-g++", *chip, "-std=c++11", "-pedantic-errors", "-x", "c++"] # not g++: gcc-avr is there anyway
        for command in [c, cpp]:
            done = subprocess.run([*command, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", *include, "-"],
                                  input=f'#include "{header.path}"\nextern int not_empty;\n',
                                  text=True, stderr=subprocess.PIPE)
            if done.returncode:
                yield f"{header.name}:1: does not compile alone ({command[0]}):\n{done.stderr.strip()}"

    def run(self, wanted):
        for header in self.headers.values():
            if wanted and not any(header.name.endswith(w) for w in wanted):
                continue
            for symbol in header.symbols:
                if symbol.kind == "function" and self.functions[symbol.name] is not symbol and (
                        not symbol.comment or self.functions[symbol.name].header is not header):
                    continue
                if symbol.kind == "function" and symbol.code.endswith(";") and (
                        'extern "C"' not in header.text):
                    yield f'{header.name}:{symbol.line}: {symbol.name}: no extern "C"'
                for what in self.missing(symbol):
                    yield f"{header.name}:{symbol.line}: {symbol.name}: {what}"
            yield from self.compile(header)


class Sources:
    """What the functions of src/core and the inline ones return, as far as their text says so."""

    FUNCTION = re.compile(r"^((?:NOINLINE )?(?:static )?(?:inline )?enum cds_result) (\w+)"
                          r"\([^;{]*?\)\n\{\n(.*?)^\}", re.M | re.S)

    def __init__(self, root, results):
        self.results = results
        self.bodies, self.texts = {}, {}
        for path in sorted([*root.glob("src/core/*/*.c"), *root.glob("include/cds55xx/*.h")]):
            text = FORMAT.sub("", path.read_text())
            self.texts[path] = text
            for match in self.FUNCTION.finditer(text):
                scope = path if "static enum" in match[1] else None
                self.bodies[scope, match[2]] = (path, match[3])

    def returned(self, name, path=None, seen=(), told=""):
        """A field that is returned as it stands and that `told` names, is told."""
        if name == "cds_steps_poll" and path:
            ends = re.findall(r"\bcds_steps_end\([^,;]*, ([^;]*)\);", self.texts[path])
            return {v for end in ends for v in self.values(end, "", path) if v in self.results}
        scope = next((s for s in [path, None] if (s, name) in self.bodies), None)
        if (scope, name) not in self.bodies or (scope, name) in seen:
            return set()
        path, body = self.bodies[scope, name]
        found = set()
        for expression in re.findall(r"\breturn ([^;]*);", body):
            field = re.match(r"(?:\(enum cds_result\))?(\w+->\w+)$", expression)
            if field and field[1] in told:
                continue
            for value in self.values(expression, body, path):
                if value in self.results:
                    found.add(value)
                else:
                    found |= self.returned(value, path, (*seen, (scope, name)), told)
        return found

    def values(self, expression, body, path):
        """Constants and functions whose value `expression` may be."""
        expressions = [expression]
        for value in expressions: # grows: what is assigned to a variable may be one, too
            branches = value.split("?", 1)[1].split(" : ") if "?" in value else [value]
            for branch in branches:
                branch = re.sub(r"^\((?:enum cds_result|uint8_t)\)", "", branch.strip())
                if re.match(r"\w+\s*\(|CDS_\w+$", branch):
                    yield re.match(r"\w+", branch)[0]
                elif re.match(r"\w+(->\w+)?$", branch):
                    expressions += [a for a in self.assigned(branch, body, path) if a not in expressions]

    def assigned(self, variable, body, path):
        text = self.texts[path] if "->" in variable else body
        found = re.findall(rf"(?:^|[^\w.>]){re.escape(variable)}\s=\s([^;]*);", text)
        if "->" in variable: # or set up as {.result = ...}
            found += re.findall(rf"\s\.{variable.split('->')[1]} = ([^,]*),", text)
        return found


def main(arguments):
    root = pathlib.Path(arguments[0] if arguments else ".").resolve()
    found = list(Check(root).run(arguments[1:]))
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
