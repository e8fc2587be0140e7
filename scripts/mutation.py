#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Mutation testing of src/core: changes one place at a time, and counts the changes that a test on
this machine notices.

usage: mutation.py [--count N] [--seed S] [--limit PERCENT] [--only FILE[:LINE]] [--list]

A mutant is the core with one change. A mutant is killed if a test program on this machine fails,
crashes or reaches its limit of CPU time. A mutant that no program notices has survived. Mutants that
behave as the original does (equivalent mutants) count as survivors, too.

Operators:
  negate     a condition of if, while, for or ?:, or a value of type bool
  relation   < for <=, > for >=, == for !=, and back
  constant   a number, character or enum constant plus or minus 1; true for false, and back
  value      a value that is assigned, returned or initialises a variable, plus or minus 1
  delete     an expression statement, break, continue or a return without a value

Each line that has a mutant has the same chance: the script draws a line, then one of its operators,
then one of its mutants. A mutant that does not compile is replaced by another of the same line, if
there is one. --only FILE[:LINE] runs every mutant of a file or line instead; --list prints all
mutants and runs none.

The script works on a copy in build/mutation, and never changes the working tree. Exit status 1
below the limit, 2 if the unchanged core fails a test or a change that must be noticed is not.
"""
import argparse
import bisect
import collections
import math
import pathlib
import random
import re
import shlex
import subprocess
import sys
import time

import coverage

ROOT = coverage.ROOT
TREE = ROOT / "build/mutation"
LIBRARY = "libcds_core.so"
# The test programs load the core from a shared library, so a mutant costs one compilation and one
# link. The first variant is fast. The second variant runs what survived the first, as `make test` does.
VARIANTS = {
    "plain": "-O1 -g0",
    "sanitized": "-O1 -g0 -fsanitize=address,undefined -fno-sanitize-recover=all",
}
CPU_LIMIT_S = 2         # least limit of each program; the slowest program takes about a tenth of it
CPU_LIMIT_FACTOR = 10
MEMORY_LIMIT = 1 << 30  # bytes; not for the sanitized variant, which reserves terabytes

# ---- C --------------------------------------------------------------------------------------------

TOKEN = re.compile(r"""
    (?P<space>\s+|//[^\n]*|/\*.*?\*/|(?:(?<=\n)|\A)[ \t]*\#(?:\\\n|/\*.*?\*/|[^\n])*)
  | (?P<string>"(?:\\.|[^"\\])*")
  | (?P<char>'(?:\\.|[^'\\])+')
  | (?P<number>\.?[0-9](?:[eEpP][+-]|[\w.])*)
  | (?P<word>[A-Za-z_]\w*)
  | (?P<sign><<=|>>=|\.\.\.|->|\+\+|--|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|[-+*/%&|^~!<>=?:;,.(){}\[\]])
""", re.X | re.S)
RELATIONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
ASSIGNMENTS = {"=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>="}
OPENING, CLOSING = {"(": ")", "[": "]", "{": "}"}, {")", "]", "}"}
SPECIFIERS = {"const", "static", "struct", "enum", "union", "unsigned", "signed", "int", "char", "bool",
              "void", "long", "short", "float", "double", "volatile", "register", "extern", "inline"}
CONSTANT = re.compile(r"[A-Z][A-Z0-9_]+")
BOOL_NAME = re.compile(r"\bbool\s+(?!\*)(\w+)((?:\s*,\s*\w+)*)")
# Statements without effect on behaviour: (void)x, and a barrier for the optimizer.
NO_EFFECT = re.compile(r"\(void\)\s*\w+(?:\s*,\s*\(void\)\s*\w+)*|\w*BARRIER\w*\s*\(.*\)", re.S)


class Mutant:
    def __init__(self, source, operator, start, end, new):
        """Replaces the characters from `start` to before `end` with `new`."""
        self.source, self.operator, self.start, self.end, self.new = source, operator, start, end, new
        self.line, self.last_line = source.line_at(start), source.line_at(end - 1)

    def text(self):
        return self.source.text[:self.start] + self.new + self.source.text[self.end:]

    def __str__(self):
        old, new = (" ".join(text.split()) for text in (self.source.text[self.start:self.end], self.new))
        line = " ".join(self.source.text.splitlines()[self.line - 1].split())
        return (f"{self.source.name}:{self.line}: {self.operator}: {old} -> {new or 'nothing'}"
                f"   in: {line}")


class Source:
    """A C file in the project's format and all its mutants. It knows as much of C as it needs."""

    def __init__(self, name, text, bools):
        self.name, self.text, self.bools = name, text, bools
        self.starts = [0] + [match.end() for match in re.finditer("\n", text)]
        self.words, self.spans = [], []  # of each token
        self.kinds = []
        self.functions = []              # (first line, last line, offset behind its "{")
        self.mutants = []
        at = 0
        while at < len(text):
            match = TOKEN.match(text, at)
            if not match:
                sys.exit(f"{name}:{self.line_at(at)}: the script does not know this token")
            if match.lastgroup != "space":
                self.words.append(match[0])
                self.spans.append(match.span())
                self.kinds.append(match.lastgroup)
            at = match.end()
        self.match = self.match_brackets()
        self.read_file()

    def line_at(self, offset):
        return bisect.bisect_right(self.starts, offset)

    def match_brackets(self):
        """{index of an opening bracket: that of its closing one}"""
        match, stack = {}, []
        for index, word in enumerate(self.words):
            if word in OPENING:
                stack.append(index)
            elif word in CLOSING:
                match[stack.pop()] = index
        return match

    def words_of(self, first, end):
        """The text of the tokens from `first` to before `end`."""
        return self.text[self.spans[first][0]:self.spans[end - 1][1]]

    def find(self, wanted, first, end):
        """Index of the first token of `wanted` outside brackets, or `end`."""
        while first < end:
            if self.words[first] in wanted:
                return first
            first = self.match[first] + 1 if first in self.match else first + 1
        return end

    def add(self, operator, first, end, new):
        self.mutants.append(Mutant(self, operator, self.spans[first][0], self.spans[end - 1][1], new))

    # ---- the parts of a file ----

    def read_file(self):
        index = first = 0
        while index < len(self.words):
            word = self.words[index]
            if word == "=":
                index = self.read_initialiser(index, first)
            elif word == "{":
                end = self.match[index]
                if self.words[index - 1] == ")":
                    self.functions.append((self.line_at(self.spans[first][0]),
                                           self.line_at(self.spans[end][0]), self.spans[index][1]))
                    self.returns_bool = self.is_bool(first, index)
                    self.read_block(index + 1, end)
                    first = end + 1
                index = end + 1
            else:
                index = self.match[index] + 1 if index in self.match else index + 1
                if word == ";":
                    first = index

    def is_bool(self, first, end):
        """True if the declaration that begins at `first` is of type bool."""
        for index in range(first, end):
            if self.words[index] == "bool":
                return self.words[index + 1] != "*"
            if self.words[index] == "(" and not self.words[index - 1].startswith("__attribute"):
                return False
        return False

    def read_initialiser(self, index, first):
        """Reads an "=" of a declaration that begins at `first`. Returns the index after the value."""
        end = self.find({",", ";"}, index + 1, len(self.words))
        self.read_value(index + 1, end, self.is_bool(first, index))
        return end

    def read_block(self, first, end):
        while first < end:
            first = self.read_statement(first)

    def read_condition(self, opening):
        """Reads a condition in brackets. Returns the index after it."""
        closing = self.match[opening]
        self.negate(opening + 1, closing)
        self.read_expression(opening + 1, closing)
        return closing + 1

    def read_statement(self, first):
        """Reads a statement. Returns the index after it."""
        words, word = self.words, self.words[first]
        if word == ";":
            return first + 1
        if word == "{":
            self.read_block(first + 1, self.match[first])
            return self.match[first] + 1
        if word in ("if", "while"):
            behind = self.read_statement(self.read_condition(first + 1))
            if word == "if" and words[behind] == "else":
                behind = self.read_statement(behind + 1)
            return behind
        if word == "switch":
            self.read_expression(first + 2, self.match[first + 1])
            return self.read_statement(self.match[first + 1] + 1)
        if word == "for":
            return self.read_for(first)
        if word == "do":
            behind = self.read_statement(first + 1)  # at its "while"
            return self.read_condition(behind + 1) + 1
        if word == "case":
            end = self.find({":"}, first, len(words))
            self.read_expression(first + 1, end)
            return end + 1
        if words[first + 1] == ":":  # a label
            return first + 2
        end = self.find({";"}, first, len(words))
        if word == "return" and end > first + 1:
            self.read_value(first + 1, end, self.returns_bool)
        elif word in ("return", "break", "continue"):
            self.add("delete", first, end, "")
        elif word in ("goto", "__asm__", "asm", "_Static_assert", "static_assert"):
            pass
        elif self.is_declaration(first):
            self.read_declaration(first, end)
        else:
            if not NO_EFFECT.fullmatch(self.words_of(first, end)):
                self.add("delete", first, end, "")
                self.read_expression(first, end)
        return end + 1

    def read_for(self, first):
        opening, closing = first + 1, self.match[first + 1]
        one = self.find({";"}, opening + 1, closing)
        two = self.find({";"}, one + 1, closing)
        if self.is_declaration(opening + 1):
            self.read_declaration(opening + 1, one)
        else:
            self.read_expression(opening + 1, one)
        if two > one + 1:
            self.negate(one + 1, two)
        self.read_expression(one + 1, two)
        self.read_expression(two + 1, closing)
        return self.read_statement(closing + 1)

    def is_declaration(self, first):
        word, after = self.words[first], self.words[first + 1]
        if word in SPECIFIERS:
            return True
        if self.kinds[first] != "word":
            return False
        return self.kinds[first + 1] == "word" or word.endswith("_t") and after == "*"

    def read_declaration(self, first, end):
        index = first
        while (index := self.find({"="}, index, end)) < end:
            index = self.read_initialiser(index, first)

    # ---- expressions ----

    def negate(self, first, end):
        self.add("negate", first, end, f"!({self.words_of(first, end)})")

    def read_value(self, first, end, is_bool):
        """Mutates a value that is assigned, returned or initialises a variable."""
        is_constant = end == first + 1 and (self.kinds[first] in ("number", "char") or
                                            self.is_constant(first))
        is_struct = "{" in self.words[first:first + 1] or self.is_compound_literal(first)
        if is_bool and not is_constant:
            self.negate(first, end)
        elif not is_constant and not is_struct and self.kinds[first] != "string":
            for sign in "+-":
                self.add("value", first, end, f"({self.words_of(first, end)}) {sign} 1")
        self.read_expression(first, end)

    def is_compound_literal(self, first):
        return self.words[first] == "(" and self.words[self.match[first] + 1] == "{"

    def is_constant(self, index):
        word = self.words[index]
        return (self.kinds[index] == "word" and word != "NULL" and
                (word in ("true", "false") or CONSTANT.fullmatch(word)) and
                self.words[index + 1] not in ("(", "{") and
                self.words[index - 1] not in (".", "->", "struct", "enum", "union"))

    def read_expression(self, first, end):
        """Mutates the operands of the expression."""
        for index in range(first, end):
            word = self.words[index]
            if word in RELATIONS:
                self.add("relation", index, index + 1, RELATIONS[word])
            elif word in ("true", "false"):
                self.add("constant", index, index + 1, "false" if word == "true" else "true")
            elif self.kinds[index] in ("number", "char") or self.is_constant(index):
                for sign in "+-":
                    self.add("constant", index, index + 1, f"({word} {sign} 1)")
            elif word == "?":
                self.negate(self.start_of_condition(index, first), index)
            elif word in ASSIGNMENTS:
                self.read_assigned(index, end)

    def read_assigned(self, index, end):
        """Mutates the value after the assignment or designated initialiser at `index`."""
        closing = self.find({",", ";", ")", "]", "}"}, index + 1, end)
        inner = self.mutants
        self.mutants = []  # the caller reads the operands
        self.read_value(index + 1, closing, self.words[index - 1] in self.bools)
        start, stop = self.spans[index + 1][0], self.spans[closing - 1][1]
        self.mutants = inner + [mutant for mutant in self.mutants
                                if (mutant.start, mutant.end) == (start, stop) and
                                mutant.operator in ("negate", "value")]

    def start_of_condition(self, index, first):
        """Index of the first token of the condition whose "?" is at `index`."""
        depth = 0
        for at in range(index - 1, first - 1, -1):
            word = self.words[at]
            if word in CLOSING:
                depth += 1
            elif word in OPENING:
                if depth == 0:
                    return at + 1
                depth -= 1
            elif depth == 0 and (word in (",", "?", ":", "return") or word in ASSIGNMENTS):
                return at + 1
        return first


def bool_names(tree):
    """Names of variables, fields and functions of type bool."""
    names = set()
    for folder in (coverage.CORE, "include"):
        for path in (tree / folder).rglob("*.[ch]"):
            for match in BOOL_NAME.finditer(path.read_text()):
                names |= {match[1], *re.findall(r"\w+", match[2])}
    return names


def lines_with_mutants(sources):
    """{(file, line): its mutants}. A mutant of several lines is one of each of them."""
    lines, seen = collections.defaultdict(list), set()
    for source in sources:
        for mutant in source.mutants:
            key = (source.name, mutant.start, mutant.end, mutant.new)
            if key in seen:
                continue
            seen.add(key)
            for line in range(mutant.line, mutant.last_line + 1):
                lines[source.name, line].append(mutant)
    return lines


def all_mutants(lines):
    return list(dict.fromkeys(mutant for of_line in lines.values() for mutant in of_line))


def read_sources(tree):
    bools = bool_names(tree)
    return [Source(name, (tree / name).read_text(), bools) for name in coverage.sources(tree)]


# ---- building and running -------------------------------------------------------------------------

class Variant:
    """The test programs and the core, built with the flags of a variant."""

    def __init__(self, name, project, names):
        self.name, self.tree = name, TREE / name
        coverage.copy_project(self.tree, project)
        self.home, self.changed = self.tree / "build/core", self.tree / "build/mutant"
        for folder in (self.home, self.changed):
            folder.mkdir(parents=True, exist_ok=True)
        library = self.home / LIBRARY
        # make stamps these flags, so it builds anew if they change. -Wl, is for the link only.
        flags = f"{VARIANTS[name]} -fPIC -Wl,--no-as-needed -Wl,{library}"
        self.objects = {name: coverage.object_of(name) for name in names}
        # With CORE_SRC empty the programs have no core of their own.
        variables = [f"SANITIZE={flags}", "CORE_SRC="]
        coverage.make(self.tree, *variables, *self.objects.values())
        self.compiler = shlex.split((self.tree / "build/host/test/flags").read_text())
        self.link(library, self.objects.values())
        coverage.make(self.tree, *variables, "host-tests")
        self.programs = coverage.list_programs(self.tree)
        self.check_programs(library)
        self.seconds = {}  # {program: CPU seconds}

    def link(self, library, objects):
        subprocess.run([self.compiler[0], *shlex.split(VARIANTS[self.name]), "-shared",
                        f"-Wl,-soname,{LIBRARY}", *objects, "-o", library], cwd=self.tree, check=True)

    def check_programs(self, library):
        """A program with a core of its own would not notice a mutant."""
        def defined(path, *options):
            text = subprocess.run(["nm", "--defined-only", *options, path], cwd=self.tree, check=True,
                                  stdout=subprocess.PIPE, text=True).stdout
            return {line.split()[-1] for line in text.splitlines() if line.split()[-2] in "TW"}
        core = {name for name in defined(library, "-D") if name.startswith("cds_")}
        for program in self.programs:
            if own := core & defined(program):
                sys.exit(f"{program} has its own {', '.join(sorted(own)[:3])}: CORE_SRC was ignored")

    def compile(self, name, text):
        """The object of a changed source; None if the change does not compile."""
        source = self.changed / pathlib.Path(name).name
        source.write_text(text)
        target = source.with_suffix(".o")
        done = subprocess.run([*self.compiler, "-w", "-iquote", str(pathlib.Path(name).parent), "-c",
                               source, "-o", target], cwd=self.tree, stderr=subprocess.DEVNULL)
        return target if done.returncode == 0 else None

    def try_object(self, name, changed, programs):
        """Runs the programs with a changed object in place of that of `name`, until one fails.
        Returns (result, program), or ("", None) if none did."""
        self.link(self.changed / LIBRARY,
                  [changed if key == name else path for key, path in self.objects.items()])
        for program in programs:
            result, _, _ = self.run(program, self.changed)
            if result:
                return result, pathlib.Path(program).name
        return "", None

    def run(self, program, folder):
        limit = max(CPU_LIMIT_S, math.ceil(CPU_LIMIT_FACTOR * self.seconds.get(program, 0)))
        return coverage.run_program(self.tree, program, limit,
                                    MEMORY_LIMIT if self.name == "plain" else None,
                                    {"LD_LIBRARY_PATH": str(folder)})

    def check_unchanged(self):
        """Checks that all programs pass with the unchanged core. Notes the CPU time of each."""
        for program in self.programs:
            result, seconds, output = self.run(program, self.home)
            if result:
                print(f"{output}\n{program}: {result} with the unchanged core ({self.name})")
                return False
            self.seconds[program] = seconds
        return True


class Runner:
    """Runs the test programs with each mutant."""

    def __init__(self, project, sources, measured):
        self.lines_of = measured.lines_of  # {program: lines that it runs}
        names = [source.name for source in sources]
        self.variants = [Variant(name, project, names) for name in VARIANTS]

    def programs_for(self, source, first, last):
        """The programs that run one of these lines. First the suite that has the name of the file, which is
        the likeliest to fail; then the fastest."""
        stem, lines = pathlib.Path(source.name).stem, {(source.name, i) for i in range(first, last + 1)}
        seconds = self.variants[0].seconds
        return sorted((program for program, ran in self.lines_of.items() if ran & lines),
                      key=lambda program: (pathlib.Path(program).name != f"test_{stem}", seconds[program]))

    def programs_of(self, mutant):
        """The programs that run the mutant's lines, then those that run another line of its function. A
        program that never runs the function cannot notice the mutant. For a table: all programs."""
        source = mutant.source
        first, last = next(((first, last) for first, last, _ in source.functions
                            if first <= mutant.line <= last), (None, None))
        if first is None:
            near = self.programs_for(source, 1, len(source.starts))
            return near + [program for program in self.lines_of if program not in near]
        near = self.programs_for(source, mutant.line, mutant.last_line)
        return near + [program for program in self.programs_for(source, first, last)
                       if program not in near]

    def test(self, name, text, programs):
        """None if the text does not compile, else (result, program)."""
        for variant in self.variants:
            changed = variant.compile(name, text)
            if not changed:
                return None
            result, program = variant.try_object(name, changed, programs)
            if result:
                return result, program
        return "", None

    def is_same_code(self, mutant):
        """True if the compiler makes the same object of the mutant as of the original."""
        variant, name = self.variants[0], mutant.source.name
        return (variant.compile(name, mutant.text()).read_bytes() ==
                variant.compile(name, mutant.source.text).read_bytes())

    def check(self, sources):
        """Checks the script itself. The unchanged core must pass. A trap at the start of a function
        that a test runs must be noticed, for one function of each file."""
        start = time.monotonic()
        if not all(variant.check_unchanged() for variant in self.variants):
            return False
        traps = 0
        for source in sources:
            for first, last, offset in source.functions:
                programs = self.programs_for(source, first, last)
                if not programs:
                    continue
                text = source.text[:offset] + " __builtin_trap();" + source.text[offset:]
                for variant in self.variants:
                    changed = variant.compile(source.name, text)
                    if not changed or not variant.try_object(source.name, changed, programs)[0]:
                        print(f"{source.name}:{first}: no test notices a trap in this function")
                        return False
                traps += 1
                break
        print(f"unchanged core: all {len(self.variants[0].programs)} programs pass; "
              f"traps noticed: {traps} of {traps}; {time.monotonic() - start:.0f} s\n", flush=True)
        return True


# ---- the run --------------------------------------------------------------------------------------

def draw(lines, rng):
    """Yields, for each line in turn, an iterator over its mutants in the order to try them. Begins
    with another order of all lines when each has had its turn."""
    left = {line: list(mutants) for line, mutants in lines.items()}

    def mutants_of(line):
        while left[line]:
            operator = rng.choice(sorted({mutant.operator for mutant in left[line]}))
            mutant = rng.choice([mutant for mutant in left[line] if mutant.operator == operator])
            for number in range(mutant.line, mutant.last_line + 1):
                if mutant in left[mutant.source.name, number]:
                    left[mutant.source.name, number].remove(mutant)
            yield mutant

    while any(left.values()):
        for line in rng.sample(sorted(left), len(left)):
            yield mutants_of(line)


def choose_only(lines, only):
    """The mutants of FILE or FILE:LINE."""
    file, _, line = only.partition(":")
    chosen = []
    for (name, number), mutants in sorted(lines.items()):
        if name.endswith(file) and (not line or number == int(line)):
            chosen += [mutant for mutant in mutants if mutant not in chosen]
    return chosen


def run(runner, turns, count):
    """Tests up to `count` mutants, one of each turn. Returns (survivors, {(file, result): number},
    number that did not compile)."""
    survivors, results, rejected, done = [], collections.Counter(), 0, 0
    for turn in turns:
        if done == count:
            break
        for mutant in turn:
            start = time.monotonic()
            programs = runner.programs_of(mutant)
            outcome = runner.test(mutant.source.name, mutant.text(), programs)
            if outcome is None:
                rejected += 1
                continue
            done += 1
            result, program = outcome
            results[mutant.source.name, result] += 1
            what = f"killed ({result} in {program})" if result else "SURVIVED"
            if not result:
                note = "" if programs else " (no test runs this function)"
                if runner.is_same_code(mutant):
                    note += " (same machine code)"
                survivors.append(f"{mutant}{note}")
            print(f"{done:>4}/{count} {time.monotonic() - start:5.1f} s  {what}: {mutant}", flush=True)
            break
    return survivors, results, rejected


def print_results(survivors, results, rejected):
    """Returns the percentage of killed mutants."""
    total, files = sum(results.values()), sorted({file for file, _ in results})
    print(f"\n  {'killed':<32}{'mutants':>8}{'killed':>8}")
    for file in files:
        of_file = sum(number for (name, _), number in results.items() if name == file)
        print(f"  {file:<32}{of_file:>8}{of_file - results[file, '']:>8}")
    by_result = collections.Counter()
    for (_, result), number in results.items():
        by_result[re.sub(r" \d+", "", result) or "survived"] += number
    print("\n  " + ", ".join(f"{result}: {number}" for result, number in by_result.most_common()) +
          f"; did not compile: {rejected}")
    print("\nsurvivors:")
    for survivor in survivors:
        print(survivor)
    killed = coverage.percent(total - len(survivors), total)
    print(f"\nkilled {total - len(survivors)} of {total} mutants of {coverage.CORE}: {killed:.1f} %")
    return killed


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300, help="mutants to draw")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--limit", type=float, default=0, help="percent; below it, exit status 1")
    parser.add_argument("--only", metavar="FILE[:LINE]", help="every mutant there; draws none")
    parser.add_argument("--list", action="store_true", help="print all mutants; run none")
    arguments = parser.parse_args()
    if arguments.list:
        for mutant in all_mutants(lines_with_mutants(read_sources(ROOT))):
            print(mutant)
        return 0
    held = coverage.lock(TREE)
    # From here on only this copy is used, so the project may be edited during the run.
    tree, measured = coverage.measure()
    sources = read_sources(tree)
    lines = lines_with_mutants(sources)
    print(f"{len(lines)} lines with {len(all_mutants(lines))} mutants in {len(sources)} files; "
          f"seed {arguments.seed}", flush=True)
    runner = Runner(tree, sources, measured)
    if measured.failed or not runner.check(sources):
        return 2
    if arguments.only:
        turns = [[mutant] for mutant in choose_only(lines, arguments.only)]
        if not turns:
            sys.exit(f"{arguments.only} has no mutant")
        count = len(turns)
    else:
        turns, count = draw(lines, random.Random(arguments.seed)), arguments.count
    killed = print_results(*run(runner, turns, count))
    held.close()
    if killed < arguments.limit:
        print(f"below the limit of {arguments.limit:g} %")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
