# SPDX-License-Identifier: MIT
"""The boards of boards/, as their board.mk and board.h describe them. The runs take their boards from
here, so a new board joins them without another list."""
import collections
import re
import subprocess

from simulator import ROOT

PROFILES = ["bridge", "console", "full"]


def chips(architecture):
    return re.search(rf"^{architecture}_MCUS *:= *(.*)$", (ROOT / "mk/library.mk").read_text(), re.M)[1].split()


# Chips with up to 64 KB of flash: their boards have no profile `full` by default, as make gives. Chips with 256 KB: their
# profile `full` has all commands (HAS_ROOM of profiles/full.c).
SMALL, LARGE = chips("avr5"), chips("avr6")

# profile: of the controller; None: the board has no host link, its firmware is a program of its own.
# profiles: those that its flash has room for. host_bps: rate of the host link, None without one.
Board = collections.namedtuple("Board", "name mcu profile profiles wiring host_bps")


def read_board(folder):
    fields = dict(re.findall(r"^(\w+) *:= *(.*?) *$", (folder / "board.mk").read_text(), re.M))
    macros = dict(re.findall(r"^#define BOARD_(\w+) +(\S+)", (folder / "board.h").read_text(), re.M))
    hosted = not fields.get("FIRMWARE")
    profiles = fields.get("PROFILES", "").split() or [p for p in PROFILES if p != "full" or fields["MCU"] not in SMALL]
    return Board(name=folder.name, mcu=fields["MCU"],
                 profile=(fields.get("PROFILE") or profiles[-1]) if hosted else None,
                 profiles=profiles if hosted else [],
                 wiring=macros.get("BUS0_WIRING", "TWO_ENABLES"),
                 host_bps=int(macros["HOST_BAUD"]) if "HOST_BAUD" in macros else None)


# By name. The board of the manual comes first: runs on one board take it.
BOARDS = {path.parent.name: read_board(path.parent)
          for path in sorted((ROOT / "boards").glob("*/board.mk"),
                             key=lambda path: (path.parent.name != "atmega128", path))}
ALL = list(BOARDS)
# Boards with the controller, that is, with a host link; those whose controller has a console; those without
# a host link.
HOSTED = [name for name in ALL if BOARDS[name].profile]
CONSOLES = [name for name in HOSTED if BOARDS[name].profile != "bridge"]
UNHOSTED = [name for name in ALL if not BOARDS[name].profile]


def with_profile(profile):
    """Names of the boards whose flash has room for this profile."""
    return [name for name in ALL if profile in BOARDS[name].profiles]


def has(macro, mcu):
    """A macro of profiles/full.c such as HAS_MOTION, as the compiler of the firmware answers for this chip."""
    conditions = re.findall(r"#define HAS_\w+ +\(.*\)\n", (ROOT / "src/controller/profiles/full.c").read_text())
    answer = subprocess.run(["avr-gcc", f"-mmcu={mcu}", "-E", "-P", "-"], check=True, text=True, stdout=subprocess.PIPE,
                            input=f"#include <avr/io.h>\n{''.join(conditions)}#if {macro}\nyes\n#endif\n")
    return "yes" in answer.stdout.split()


# Boards whose firmware moves servos by a motion.
WITH_MOTION = [name for name in with_profile("full") if has("HAS_MOTION", BOARDS[name].mcu)]
# Two of them: the first with 256 KB of flash, and the first with less.
WITH_MOTION_BY_SIZE = [next(name for name in WITH_MOTION if (BOARDS[name].mcu in LARGE) == is_large) for is_large in (True, False)]
# Boards whose profile `full` has room for longer texts of errors.
WITH_ADVICE = [name for name in with_profile("full") if has("HAS_ADVICE", BOARDS[name].mcu)]
