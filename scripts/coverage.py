#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measures the branch coverage of src/core by the tests that run on this machine.

usage: coverage.py [--limit PERCENT]

Copies the project to build/coverage, builds the Makefile's list-host-tests there with gcc --coverage
at -O0, and runs each program once. Prints, per file and in total, how many branches were taken at
least once, then each branch that was not, as file:line. Inline functions of headers are listed
below the total and do not count. Exit status 1 below the limit or if a test fails.
"""
import argparse
import collections
import fcntl
import json
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
CORE = "src/core"
HEADERS = (CORE, "include/")
OBJECTS = pathlib.Path("build/host/test/obj")  # of the Makefile
NOT_COPIED = {".git", "build", "__pycache__"}
# always_inline would give each caller its own copy of a function's branches.
FLAGS = "-O0 --coverage -Dalways_inline=unused"
# A random test takes its number of inputs. `make fuzz` runs more.
ARGUMENTS = {"fuzz": ["20000", "2000"], "inhibit_random": ["20000"],
             "bus_random": ["20000"], "permit_random": ["20000"]}
MIB = 1 << 20
OUTPUT_MAX = 16 * MIB
# A make that runs this script must not pass its options on to the make that this script runs.
ENVIRONMENT = {name: value for name, value in os.environ.items()
               if name not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")}


def lock(folder):
    """Ends the script if another run works in this folder. The run that holds the file that this
    function returns holds the lock."""
    folder.mkdir(parents=True, exist_ok=True)
    file = open(folder / "lock", "w")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        sys.exit(f"another run works in {folder}; start again when it has ended")
    return file


def copy_project(to, project=ROOT):
    """Makes `to` a copy of the project. Leaves its build/ and each file that did not change, so that
    make builds only what changed."""
    wanted = set()
    for folder, folders, names in os.walk(project):
        folders[:] = [name for name in folders if name not in NOT_COPIED]
        for name in names:
            source = pathlib.Path(folder, name)
            if not source.is_file():
                continue
            target = to / source.relative_to(project)
            wanted.add(target)
            old, new = target.stat() if target.exists() else None, source.stat()
            if not old or (old.st_size, old.st_mtime_ns) != (new.st_size, new.st_mtime_ns):
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(source, target)
    for folder, folders, names in os.walk(to):
        if pathlib.Path(folder) == to:
            folders[:] = [name for name in folders if name not in NOT_COPIED]
        for name in names:
            if pathlib.Path(folder, name) not in wanted:
                pathlib.Path(folder, name).unlink()


def make(tree, *words):
    """Runs make in `tree`; returns its output. Ends the script if make fails."""
    unity = ROOT / os.environ.get("UNITY", "build/unity")
    done = subprocess.run(["make", "-s", f"UNITY={unity}", *words], cwd=tree, env=ENVIRONMENT,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        sys.exit(f"{done.stdout}\nmake failed in {tree}")
    return done.stdout


def sources(tree):
    """The C files of src/core, relative to the project."""
    return sorted(path.relative_to(tree).as_posix() for path in (tree / CORE).rglob("*.c"))


def object_of(source):
    return (OBJECTS / source).with_suffix(".o").as_posix()


def list_programs(tree):
    return make(tree, "list-host-tests").split()


def run_program(tree, program, cpu_s=None, memory=None, environment=None):
    """Runs a test program in `tree`. Returns (result, CPU seconds, output); the result is "" if all
    its tests passed, else a word for how it failed. A limit is in seconds of CPU time, not of wall
    time, so a busy machine changes nothing."""
    def limit():
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (OUTPUT_MAX, OUTPUT_MAX))
        if cpu_s:
            resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s + 1))
        if memory:
            resource.setrlimit(resource.RLIMIT_AS, (memory, memory))

    name = pathlib.Path(program).name
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryFile() as output:
        status = subprocess.run([program, *ARGUMENTS.get(name, [])], cwd=tree, stdout=output,
                                stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                env={**ENVIRONMENT, **(environment or {})},
                                preexec_fn=limit).returncode
        output.seek(0)
        text = output.read().decode(errors="replace")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    # A Unity suite prints a closing line; a suite that ends without it did not run all its tests.
    complete = name in ARGUMENTS or " Tests 0 Failures 0 Ignored" in text
    if cpu_s and status < 0 and cpu >= cpu_s - 0.1:
        result = "CPU limit"
    elif "Sanitizer" in text or "runtime error:" in text:
        result = "sanitizer"
    elif status < 0:
        result = f"signal {-status}"
    elif status or not complete:
        result = "failed test"
    else:
        result = ""
    return result, cpu, text


def read_gcov(tree):
    """Reads the counts since the last clear_counts(). Yields (file, line, count, [count of each
    branch], function)."""
    names = [name for name in sources(tree) if (tree / object_of(name)).with_suffix(".gcda").exists()]
    if not names:  # a program links only what it uses
        return
    text = subprocess.run(["gcov", "--json-format", "--stdout", "--branch-probabilities",
                           *(object_of(name) for name in names)], cwd=tree, check=True,
                          stdout=subprocess.PIPE, text=True).stdout
    for document in text.splitlines():
        for file in json.loads(document)["files"] if document.startswith("{") else []:
            for line in file["lines"]:
                yield (os.path.normpath(file["file"]), line["line_number"], line["count"],
                       [branch["count"] for branch in line["branches"]], line.get("function_name"))


def clear_counts(tree):
    for path in (tree / OBJECTS).rglob("*.gcda"):
        path.unlink()


class Coverage:
    """What the test programs run of src/core."""

    def __init__(self):
        self.lines = collections.Counter()     # {(file, line): count}
        self.branches = collections.Counter()  # {(file, line, function, number from 0 on): count}
        self.lines_of = {}                     # {program: {(file, line) that it runs}}
        self.failed = []                       # programs

    def measure(self, tree, programs):
        for program in programs:
            clear_counts(tree)
            result, _, output = run_program(tree, program)
            if result:
                print(f"{output}\n{program}: {result}")
                self.failed.append(program)
            ran, number = set(), collections.Counter()
            for file, line, count, branches, function in read_gcov(tree):
                if not file.startswith(HEADERS):
                    continue
                self.lines[file, line] += count
                if count:
                    ran.add((file, line))
                for branch in branches:
                    key = (file, line, function)
                    self.branches[(*key, number[key])] += branch
                    number[key] += 1
            self.lines_of[program] = ran

    def count(self, wanted):
        """(branches, taken branches) of the files for which `wanted` is true."""
        counts = [count for key, count in self.branches.items() if wanted(key[0])]
        return len(counts), sum(count > 0 for count in counts)


def measure():
    """Builds and runs all; returns (tree, Coverage)."""
    tree = ROOT / "build/coverage/tree"
    held = lock(tree.parent)
    copy_project(tree)
    make(tree, f"SANITIZE={FLAGS}", "host-tests")
    coverage = Coverage()
    coverage.measure(tree, list_programs(tree))
    for name in sorted(set(sources(tree)) - {file for file, _ in coverage.lines}):
        sys.exit(f"{name}: no test program on this machine links it")
    held.close()
    return tree, coverage


def percent(part, whole):
    return 100.0 * part / whole if whole else 100.0


def print_row(name, branches, taken):
    print(f"  {name:<40}{branches:>9}{taken:>8}{percent(taken, branches):>8.1f} %")


def print_missed(tree, coverage):
    """Lists each branch of src/core/**/*.c that was not taken."""
    of_line = collections.defaultdict(list)
    for (file, line, _, _), count in sorted(coverage.branches.items(), key=lambda item: item[0][:2]):
        if file.endswith(".c"):
            of_line[file, line].append(count)
    for (file, line), counts in of_line.items():
        text = (tree / file).read_text().splitlines()[line - 1].strip()
        for number, count in enumerate(counts, 1):
            if not count:
                why = "not taken" if coverage.lines[file, line] else "never reached"
                print(f"{file}:{line}: branch {number} of {len(counts)} {why}: {text}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--limit", type=float, default=0, help="percent; below it, exit status 1")
    arguments = parser.parse_args()
    tree, coverage = measure()
    print(f"  {'taken at least once':<40}{'branches':>9}{'taken':>8}")
    for name in sources(tree):
        print_row(name, *coverage.count(lambda file: file == name))
    branches, taken = coverage.count(lambda file: file.endswith(".c"))
    print_row(f"total of {len(coverage.lines_of)} test programs", branches, taken)
    print_row("inline functions of headers, not counted",
              *coverage.count(lambda file: file.endswith(".h")))
    print()
    print_missed(tree, coverage)
    if coverage.failed:
        print(f"failed: {' '.join(coverage.failed)}")
        return 1
    if percent(taken, branches) < arguments.limit:
        print(f"branch coverage of {CORE} is below {arguments.limit:g} %")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
