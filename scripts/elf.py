#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What the library's machine code must not do. Prints every breach as file: function: what; exit 1
if there is one, or if a file has nothing to check.

usage: elf.py FILE ...   (archives and objects, of which every function is the library's; linked
                          programs, of which those named cds_... but cds_blocking_... and the
                          interrupt vectors are)

Reads the calls and jumps between functions from avr-objdump. Rules, for all code on any path:
  forbidden    no malloc, free or alloca, no floating point, no cds_blocking_...; no division on the hot
               path (HOT and the vectors)
  recursion    the graph has no cycle. POINTERS lists the functions of the library that are called
               through a pointer, and the callers of each; an indirect call of another function is a
               breach. The callbacks of a program, for example on_end, are not checked
  blocking     no sleep, and no cli except in a stack frame; no loop of up to 8 instructions that only
               tests a register or memory, or only counts; no loop that reads the clock or polls.
               Allowed: a loop that reads a value until two reads agree
"""
import functools
import re
import subprocess
import sys

HOT = re.compile(r"cds_(?:bus_(?:poll|submit)|cycle_(?:poll|goal|commit)|"
                 r"(?:link|group_read|read_pipeline|sync_write|servo(?!_units)|feedback|packet|parser|"
                 r"port)_\w+)$|__vector_")

# Of functions whose address is taken (object: name): the functions that call them through a pointer.
POINTERS = {
    r"permit\.o: cds_servos_permit": r"bus\.o: send_if_permitted",
    r"queue\.o: submit": r"bus\.o: cds_bus_send_or_wait|servos\.o: submit",
    r"servos\.o: submit": r"bus\.o: cds_bus_send_or_wait",
    r"queue\.o: cancel": r"open\.o: cds_bus_open|cancel\.o: cds_bus_cancel|servos\.o: cancel",
    r"servos\.o: cancel": r"open\.o: cds_bus_open|cancel\.o: cds_bus_cancel",
    r"queue\.o: request_ended": r"bus\.o: finish|cancel\.o: cds_bus_cancel|servos\.o: request_ended",
    r"servos\.o: request_ended": r"bus\.o: finish|cancel\.o: cds_bus_cancel",
    r"learn\.o: cds_servos_on_sending": r"bus\.o: poll_sending_only",
    r"learn\.o: cds_servos_on_packet": r"bus\.o: note_unexpected",
    r"permit\.o: cds_servos_permit_goal|servos\.o: changed_since": r"cycle_goals\.o: \w+",
    r"servos\.o: set_move": r"registered_move\.o: set_move",
    r"(?:steps|torque_off|read_pipeline)\.o: on_end|cycle\.o: goals_ended": r"bus\.o: finish", # of requests
    r"steps\.o: abort_steps": r"torque_off\.o: claim_own_rate", # of a lock
    r"robot_motion\.o: poll_motion": r"robot\.o: cds_robot_poll", # on_poll
    r"group_read\.o: (?:next|take)": r"read_pipeline\.o: \w+",
    r"\w+\.o: (?:send|ended|send_packet|packet_ended)": r"steps\.o: cds_steps_poll",
}
# Functions to check in a linked program. A program may choose to call cds_blocking_....
OURS = re.compile(r"cds_(?!blocking_)|__vector_")

# These call functions of the program.
CALLS_POINTERS = re.compile("|".join(POINTERS.values()) + r"|bus\.o: cds_bus_poll"
                            r"|sequence\.o: (?:read_to|report_pose|cds_sequence_poll)|robot\.o: cds_robot_report")

ALLOCATION = re.compile(r"(?:m|c|re)alloc$|free$|alloca$|sbrk$")
FLOAT = re.compile(r"__\w*[sd]f\d?$|__fp_|__(?:float|fix)|(?:sin|cos|tan|sqrt|pow|exp|log|floor|ceil|fabs)f?$")
DIVISION = re.compile(r"__u?(?:div|mod)")
LOOK = re.compile(r"cds_port_now_us$|cds_\w+_poll$")

LABEL = re.compile(r"([0-9a-f]+) <([^>]+)>:$")
CODE = re.compile(r"\s*([0-9a-f]+):\t(?:[0-9a-f]{2} )+\s*\t(\w+)\s*([^;]*?)\s*"
                  r"(?:;.*?(?:<([^>+]+)(?:\+0x([0-9a-f]+))?>)?)?$")
RELOCATION = re.compile(r"\s*[0-9a-f]+: R_AVR_(\w+)\t([^+\s]+)(?:\+0x([0-9a-f]+))?")

BRANCH = re.compile(r"(?:br\w+|rjmp|jmp)$")
CALL = re.compile(r"r?call$")
# A loop that waits consists of these instructions only: tests and branches, or counting.
LOOKING = re.compile(r"(?:in|lds?|ldd|ldi|andi?|or|cp\w*|tst|bst|sbi[cs]|sbr[cs]|br\w+|rjmp|jmp|nop|wdr)$")
COUNTING = re.compile(r"(?:dec|inc|subi|sbci|sbiw|adiw|br\w+|rjmp|jmp|nop|wdr)$")
WAIT_LENGTH = 8
MOMENTARY = re.compile(r"(?:in|out|ldi?|lds|ldd|sts?|std|mov|andi?|ori?|com|sbi|cbi|pop)$")
MOMENT = 7  # instructions


class Instruction:
    def __init__(self, at, name, operands, target):
        self.at, self.name, self.operands = at, name, operands
        self.target = target # (name of function or section, offset) or None
        self.goes_to = None  # address in its own function
        self.callee = ""     # name


class Function:
    def __init__(self, unit, section, name, at):
        self.unit, self.section, self.name, self.at = unit, section, name, at
        self.code = []
        self.calls = set() # Functions, or names if they are not in the file
        self.taken = False # its address is used
        self.indirect = False
        self.is_ours = True

    @property
    def plain(self):
        return self.name.split(".")[0] # without what link-time optimisation appends

    def __str__(self):
        return f"{self.unit}: {self.name}" if self.unit else self.name


class Program:
    def __init__(self, path):
        self.path = path
        described = subprocess.check_output(["avr-objdump", "-f", path], text=True)
        self.linked = "EXEC_P" in described
        self.functions = []
        self.here, self.everywhere = {}, {} # by (unit, name), by name
        self.sections = {}                  # (unit, section): functions in order
        self.references = []                # (unit, name, offset) of addresses taken
        self.read()
        if not self.linked:
            self.read_tables()
        for function in self.functions:
            function.is_ours = not self.linked or bool(OURS.match(function.name))
            self.link(function)
        for unit, name, offset in self.references:
            function, inside = self.find(unit, name, offset)
            if isinstance(function, Function) and not inside:
                function.taken = True

    def read(self):
        unit, section, function = "", "", None
        options = ["-d"] if self.linked else ["-dr"]
        output = subprocess.check_output(["avr-objdump", *options, self.path], text=True)
        for line in output.splitlines():
            if "file format" in line and not self.linked:
                unit = line.split(":")[0].split("/")[-1]
            elif line.startswith("Disassembly of section"):
                section, function = line.split()[-1][:-1], None
            elif LABEL.match(line):
                at, name = LABEL.match(line).groups()
                function = Function(unit, section, name, int(at, 16))
                self.functions.append(function)
                self.here[unit, name] = function
                self.everywhere.setdefault(name, function)
                self.sections.setdefault((unit, section), []).append(function)
            elif function and CODE.match(line):
                at, name, operands, target, offset = CODE.match(line).groups()
                target = (target, int(offset or "0", 16)) if target else None
                function.code.append(Instruction(int(at, 16), name, operands, target))
            elif function and function.code and RELOCATION.match(line):
                kind, name, offset = RELOCATION.match(line).groups()
                last = function.code[-1]
                last.target = (name, int(offset or "0", 16))
                if kind.endswith(("_PM", "_GS")):
                    self.references.append((unit, name, last.target[1]))

    def read_tables(self):
        """Notes the functions whose addresses are in data."""
        unit, data = "", False
        for line in subprocess.check_output(["avr-objdump", "-r", self.path], text=True).splitlines():
            if "file format" in line:
                unit = line.split(":")[0].split("/")[-1]
            elif line.startswith("RELOCATION RECORDS"):
                data = re.search(r"\[\.(?:data|rodata|progmem)", line)
            elif data and "_PM" in line:
                name, _, offset = line.split()[-1].partition("+0x")
                self.references.append((unit, name, int(offset or "0", 16)))

    def find(self, unit, name, offset):
        """(Function or name, offset in it)"""
        if (unit, name) in self.sections:
            within = [f for f in self.sections[unit, name] if f.at <= offset]
            if within:
                return within[-1], offset - within[-1].at
        function = self.here.get((unit, name)) or self.everywhere.get(name)
        return (function, offset) if function else (name, offset)

    def link(self, function):
        """Fills in the calls. Sets goes_to of each jump within the function."""
        for it in function.code:
            if it.name in ("icall", "eicall", "ijmp", "eijmp"): # a jump: the last call of a function
                function.indirect = True
            if not it.target or not (CALL.match(it.name) or BRANCH.match(it.name)):
                continue
            target, offset = self.find(function.unit, *it.target)
            within = target is function
            if within and BRANCH.match(it.name):
                it.goes_to = function.at + offset
            elif within and function.at + offset == it.at + 2: # rcall .+0: room on the stack
                it.name = "room"
            else:
                function.calls.add(target)
                it.callee = target if isinstance(target, str) else target.plain

    def callees(self, function):
        found = {f for f in function.calls if isinstance(f, Function)}
        if function.indirect:
            found |= {f for f in self.functions if f.taken and may_call(function, f)}
        return found

    @functools.cached_property
    def cycles(self):
        """Functions that can reach themselves."""
        done, cyclic, path = set(), set(), []

        def visit(function):
            if function in path:
                cyclic.update(path[path.index(function):])
            elif function not in done:
                path.append(function)
                for callee in self.callees(function):
                    visit(callee)
                path.pop()
                done.add(function)

        for function in self.functions:
            visit(function)
        return cyclic

    @functools.cache
    def reaches(self, function, what):
        """A path of calls to a function whose name matches `what`, as text, or None."""
        seen, paths = {function}, [(function, (function.name,))]
        while paths:
            at, path = paths.pop()
            for callee in sorted(at.calls, key=str):
                name = callee if isinstance(callee, str) else callee.name
                if what.match(name):
                    return " -> ".join((*path, name))
            for callee in self.callees(at) - seen:
                seen.add(callee)
                paths.append((callee, (*path, callee.name)))
        return None


def may_call(caller, taken):
    """True unless POINTERS says that `taken` is called by others only."""
    callers = next((by for name, by in POINTERS.items() if re.fullmatch(name, str(taken))), ".*")
    return re.fullmatch(callers, str(caller))


def successors(code):
    """{index: indices that may come next}, within the function and without jump tables."""
    index = {it.at: i for i, it in enumerate(code)}
    found = {}
    for i, it in enumerate(code):
        after = [i + 1] if not re.match(r"reti?$|e?ijmp$|r?jmp$", it.name) else []
        if re.match(r"sb[ir][cs]$|cpse$", it.name):
            after.append(i + 2)
        if it.goes_to in index:
            after.append(index[it.goes_to])
        found[i] = [a for a in after if a < len(code)]
    return found


def reach(begin, edges, end=None):
    """All indices that are reached from `begin`, with `begin`. Does not follow the edges of `end`."""
    seen, left = {begin}, [begin]
    while left:
        at = left.pop()
        for to in edges.get(at, ()) if at != end else ():
            if to not in seen:
                seen.add(to)
                left.append(to)
    return seen


def loops(function):
    """(address, instructions) of each loop: what lies between a jump back and its target."""
    code = function.code
    after = successors(code)
    before = {}
    for i, following in after.items():
        for to in following:
            before.setdefault(to, []).append(i)
    for last, it in enumerate(code):
        if it.goes_to is None or it.goes_to > it.at:
            continue
        first = next((i for i, other in enumerate(code) if other.at == it.goes_to), None)
        forward = reach(first, after) if first is not None else ()
        if last in forward:
            yield it.goes_to, [code[i] for i in sorted(reach(last, before, first) & forward)]


def waits(function):
    """Yields a text for each loop that waits."""
    for first, body in loops(function):
        moving = any("+" in i.operands.split(", ")[-1][1:] or "-" in i.operands.split(", ")[-1][:1]
                     for i in body if i.name == "ld")
        if len(body) <= WAIT_LENGTH and not moving:
            if all(LOOKING.match(i.name) for i in body):
                yield f"a loop at 0x{first:x} only tests, and waits for a change from outside"
            elif all(COUNTING.match(i.name) for i in body):
                yield f"a loop at 0x{first:x} only counts"
        for i in body:
            if LOOK.match(i.callee):
                yield f"a loop at 0x{first:x} calls {i.callee}()"


def is_moment(ahead):
    """True if interrupts are off for a few instructions only: SREG is restored, or the handler ends,
    within MOMENT instructions and without a branch."""
    for it in ahead[:MOMENT]:
        if it.name == "reti" or it.name == "out" and it.operands.startswith("0x3f"):
            return True
        if not MOMENTARY.match(it.name):
            return False
    return False


def stops(function):
    for i, it in enumerate(function.code):
        ahead = function.code[i + 1:]
        if it.name == "sleep":
            yield "sleeps"
        moves_stack = ahead and ahead[0].name == "out" and ahead[0].operands.startswith(("0x3d", "0x3e"))
        if it.name == "cli" and not moves_stack and not is_moment(ahead):
            yield "turns interrupts off"


def breaches(program):
    for function in program.functions:
        if not function.is_ours:
            continue
        forbidden = [(ALLOCATION, "allocates"), (FLOAT, "uses floating point"),
                     (re.compile("cds_blocking_"), "waits")]
        if HOT.match(function.plain):
            forbidden.append((DIVISION, "divides on the hot path"))
        for what, why in forbidden:
            path = program.reaches(function, what)
            if path:
                yield function, f"{why}: {path}"
        if function in program.cycles:
            yield function, "is recursive"
        if function.indirect and not program.linked and not CALLS_POINTERS.fullmatch(str(function)):
            yield function, "calls through a pointer, which only those in POINTERS may"
        for why in [*waits(function), *stops(function)]:
            yield function, why


def main(paths):
    status = 0
    for path in paths:
        program = Program(path)
        found = [f"{path}: {function}: {why}" for function, why in breaches(program)]
        if not any(function.is_ours for function in program.functions):
            found.append(f"{path}: no function to check")
        if found:
            print(*found, sep="\n")
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
