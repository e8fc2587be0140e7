#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks docs/internals/conformance.md: its registers are the 50 bytes of the simulator, its
rulings are those of docs/internals/rulings.md, every row names a test, and every test named there
exists. Prints what does not hold."""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
REGISTERS, RULINGS = 50, 40
NAMED = re.compile(r"`(\w+): (\w+)`")


def exists(where, name):
    if where == "scenario":
        return (ROOT / f"test/scenario/{name}.script").exists()
    for path, form in [(ROOT / f"test/sim/test_{where}.c", r"^void test_%s\(void\)$"),
                       (ROOT / f"test/runs/test_{where}.py", r"^    def test_%s\(self\):$")]:
        if path.exists():
            return re.search(form % name, path.read_text(), re.M) is not None
    return False


def sections(text):
    """{"Registers": [[cell, ...], ...], ...}, without the heads of the tables."""
    found = {}
    for part in text.split("\n## ")[1:]:
        lines = [line for line in part.splitlines() if line.startswith("| ")]
        found[part.splitlines()[0]] = [[cell.strip() for cell in line.split("|")[1:-1]]
                                       for line in lines[1:]]
    return found


def table_rows():
    """(address, bytes, name) of each row of the simulated servo's table."""
    header = (ROOT / "sim/servo/control_table.h").read_text()
    addresses = {name: int(value, 16) for name, value in re.findall(r"(TABLE_\w+) = (0x\w+)", header)}
    rows = re.findall(r"^    \{(\w+),\s+(\d),.*\"(\w+)\"\}", (ROOT / "sim/servo/control_table.c").read_text(), re.M)
    return [(addresses[at] if at in addresses else int(at, 16), int(size), name)
            for at, size, name in rows]


def registers_wrong(rows):
    told = [(int(row[0], 16), int(row[1]), row[2].strip("`")) for row in rows]
    for row in sorted(set(told) ^ set(table_rows())):
        yield f"register {row}: not the same here and in sim/servo/control_table.c"
    covered = [at + i for at, size, _ in told for i in range(size)]
    if covered != list(range(REGISTERS)):
        yield f"the registers are not the {REGISTERS} bytes, each once and in order"


def rulings_wrong(rows):
    wanted = range(1, RULINGS + 1)
    ruled = re.findall(r"^\| (.*?) \|", (ROOT / "docs/internals/rulings.md").read_text(), re.M)[1:]  # without the head
    if (ruled != [f'<a id="r{n}"></a>R{n}' for n in wanted]
            or [row[0] for row in rows] != [f"[R{n}](rulings.md#r{n})" for n in wanted]):
        yield f"the rulings are not R1 to R{RULINGS}, here or in docs/internals/rulings.md"
    for n, row in zip(wanted, rows):
        if not any(f"R{n}" in name.split("_") for _, name in NAMED.findall(row[1])):
            yield f"R{n}: no test bears its number"


def main():
    text = (ROOT / "docs/internals/conformance.md").read_text()
    found = sections(text)
    wrong = list(registers_wrong(found["Registers"])) + list(rulings_wrong(found["Rulings"]))
    for title, rows in found.items():
        wrong += [f"{title}: no test in the row of {row[0]}" for row in rows
                  if not NAMED.search(" ".join(row))]
    wrong += [f"there is no test {where}: {name}" for where, name in sorted(set(NAMED.findall(text)))
              if name != "x" and not exists(where, name)]
    for line in wrong:
        print(f"docs/internals/conformance.md: {line}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
