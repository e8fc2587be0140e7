#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Who may include whom. Prints every breach as file:line: why; exit 1 if there is one.

usage: layering.py [DIR]   (the project's root; default: the current directory)
"""
import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')

# The storeys of the library, each with its public headers, and the storeys that each one knows.
STOREYS = {
    "wire": ["ring", "port", "link", "parser", "packet", "result", "control_table", "units", "version"],
    "bus": ["bus", "queue", "steps"],
    "servo": ["servo", "servo_units", "feedback", "sync_write", "read_pipeline", "group_read",
              "registered_move", "cycle"],
    "safety": ["servos", "health", "torque_off"],
    "service": ["scan", "identity", "setup", "diagnose", "torque_on"],
    "robot": ["blocking", "motion", "sequence", "gait", "pose", "follow", "robot", "cds55xx"],
}
BELOW = {
    "wire": [],
    "bus": ["wire"],
    "servo": ["bus", "wire"],
    "safety": ["servo", "bus", "wire"],
    "service": ["servo", "bus", "wire"],
    "robot": ["service", "safety", "servo", "bus", "wire"],
}

# The folders of the controller, each with the folders that it knows beside itself.
CONTROLLER = {
    "avr": [],
    "robot": ["avr"],
    "host": ["avr", "robot"],
    "console": ["avr", "host", "robot"],
    "profiles": ["avr", "console", "host", "robot"],
}

# Modules that know less than their storey, and the public headers that they may include.
WIRE = "ring|port|link|parser|packet|result|control_table"
MODULES = [
    ("wire", ["ring", "port", "link", "parser", "packet", "result", "control_table"], WIRE),
    ("bus", ["bus"], f"bus|{WIRE}"),
    ("servo", ["servo"], "servo|bus|packet|result|control_table"),
    ("safety", ["servos", "permit", "learn", "limits"], "servo|servos|queue|bus|packet|result|control_table"),
]

# The port for AVR: headers that a program for AVR includes, and no other.
PORT = ["include/cds55xx/avr.h", "include/cds55xx/avr/*.h"]

# files, what must not be found in a line of code, why
FORBIDDEN = [
    (["include/cds55xx/*.h", "!include/cds55xx/avr.h", "src/core/**/*.[ch]"],
     re.compile(r"\bavr/|\bUCSR|\bISR\b|\bF_CPU\b|board\.h"),
     "the core knows no chip and no board"),
    (["src/controller/*.[ch]", "src/controller/host/*.[ch]", "src/controller/robot/*.[ch]",
     "src/controller/console/**/*.[ch]", "examples/*.c"],
     re.compile(r"\bUCSR|\bUDR\d|\bPORT[A-L]\b|\bDDR[A-L]\b|\bTCNT"),
     "only the port, include/cds55xx/avr, knows a register"),
    (["boards/*/*.h"], re.compile(r"[{}();]"), "a board is data, without code"),
    (["src/core/**/*.[ch]", "src/controller/**/*.[ch]", "include/cds55xx/parser.h"],
     re.compile(r"\b0[xX][fF][fF]\b"),
     "only packet.h says what a header is: CDS_HEADER"),
    (["src/core/**/*.[ch]", *PORT],
     re.compile(r"\bcds_blocking_|\bblocking\.h\b|\b_delay_\w+|util/delay|_delay_loop"),
     "the library never waits"),
]

# files, the headers of ours they may include
ALLOWED = [
    (PORT, re.compile(r"^(cds55xx/(port|link|ring|avr/\w+)\.h|board\.h)$"),
     "the port meets the core in port.h, link.h and ring.h only"),
    (["examples/*.c", "examples/*/*.c"], re.compile(r"^(cds55xx/\w+|stop_report)\.h$"), "an example includes public headers only"),
    (["src/controller/**/*.[ch]"],
     re.compile(r"^(cds55xx/(avr/)?\w+\.h|compiler\.h|flash\.h|(avr|console|host|robot)/[\w/]+\.h)$"
                r"|^(ring_input|board)\.h$"),
     "of the core the controller includes public headers, compiler.h and flash.h only"),
    (["src/controller/%s/**/*.[ch]" % folder for folder in CONTROLLER if folder != "avr"]
     + ["src/controller/*.[ch]"],
     re.compile(r"^(?!board\.h$|cds55xx/avr/)"),
     "only src/controller/avr includes board.h and the headers in cds55xx/avr/"),
    *((["src/controller/%s/**/*.[ch]" % folder],
       re.compile(r"^(?!(%s)/)" % "|".join(set(CONTROLLER) - {folder, *below})),
       "a lower folder of the controller knows no higher one")
      for folder, below in CONTROLLER.items() if len(below) < len(CONTROLLER) - 1),
    (["sim/**/*.[ch]"],
     re.compile(r"^(?!cds55xx|src/|.*/include/).*$"),
     "the simulator includes nothing of include/ or src/"),
    *((["include/cds55xx/%s.h" % name for name in headers] + ["src/core/%s/*.[ch]" % storey],
       re.compile(r"^(cds55xx/(%s)\.h|(%s)/\w+\.h|compiler\.h|flash\.h)$"
                  % ("|".join(sum((STOREYS[one] for one in below), headers)), "|".join((storey, *below)))),
       "a lower storey knows no higher one")
      for storey, headers, below in [(storey, STOREYS[storey], BELOW[storey]) for storey in STOREYS]),
    *((["include/cds55xx/%s.h" % name for name in names] +
       ["src/core/%s/%s.c" % (storey, name) for name in names],
       re.compile(r"^(cds55xx/(%s)\.h|(?!cds55xx)\w+/\w+\.h|compiler\.h|flash\.h)$" % known),
       "a lower module knows no higher one")
      for storey, names, known in MODULES),
    (["arduino/*.[ch]*"],
     re.compile(r"^(cds55xx/\w+|CDS55xx|Arduino|serial_notice|(arduino-\w+/)?board)\.h$"),
     "the Arduino class includes public headers only"),
]
SYSTEM = re.compile(r"^(avr|util|std|sys|simavr)\w*(/|\.h$)|^(string|stdio|errno|math|time|poll|"
                    r"fcntl|unistd|termios|pty|signal|limits|ctype|inttypes|dirent|elf|libelf|gelf)\.h$")


def code_lines(path):
    """(number, text) of each line, without comments."""
    text = path.read_text()
    text = re.sub(r"/\*.*?\*/", lambda m: "\n" * m.group().count("\n"), text, flags=re.S)
    for number, line in enumerate(text.splitlines(), 1):
        yield number, re.sub(r"//.*", "", line)


def files(root, patterns):
    """The files of all patterns, but of those that begin with "!"."""
    found = {p for pattern in patterns if pattern[0] != "!" for p in root.glob(pattern)}
    return sorted(found - {p for pattern in patterns if pattern[0] == "!" for p in root.glob(pattern[1:])})


def without_storey(root):
    """Public headers and folders of the core that no storey has: no rule would hold for them."""
    known = {f"include/cds55xx/{name}.h" for headers in STOREYS.values() for name in headers}
    known |= {f"src/core/{storey}" for storey in STOREYS}
    for path in files(root, ["include/cds55xx/*.h", "src/core/*/"]):
        name = path.relative_to(root).as_posix()
        if name not in known and name != PORT[0]:
            yield f"{name}: no storey has it: name it in STOREYS of scripts/layering.py"


def breaches(root):
    yield from without_storey(root)
    for patterns, what, why in FORBIDDEN:
        for path in files(root, patterns):
            name = path.relative_to(root).as_posix()
            for number, line in code_lines(path):
                if what.search(line):
                    yield f"{name}:{number}: {why}: {line.strip()}"
    for patterns, allowed, why in ALLOWED:
        for path in files(root, patterns):
            name = path.relative_to(root).as_posix()
            for number, line in code_lines(path):
                match = INCLUDE.match(line)
                if match and not SYSTEM.match(match[1]) and not allowed.match(match[1]):
                    yield f"{name}:{number}: {why}: {match[1]}"


def main(arguments):
    root = pathlib.Path(arguments[0] if arguments else ".").resolve()
    found = list(breaches(root))
    for line in found:
        print(line)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
