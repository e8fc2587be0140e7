#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""docs/console.md from the rows of src/controller/console/commands/*.c, and from a first session with the firmware in the simulator (atmega128, built). Prints the document.

usage: console.py [--session]    --session: only the session, shortened for docs/getting-started.md
"""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
STRING = r'"(?:[^"\\]|\\.)*"'
FOLDER = ROOT / "src/controller/console/commands"
PROFILE = ROOT / "src/controller/profiles/full.c"

# What is typed, and for how long the reply is waited for, in ms. Ends a line: `\r`, as Enter does.
SESSION = [("echo on", 20), ("version", 20), ("scan", 1500), ("servos", 30), ("info 1", 300), ("torque 1 on", 10),
           ("move 1 90deg 30rpm", 20), ("monitor 1 every 100ms as plot", 520), ("\r", 20),
           ("get 1 PRESENT_POSITION", 10), ("id 3 4", 20), ("ping 3", 20), ("help id", 30)]


# Lists of servos, and errors that name servo, argument, value and range.
LISTS = [("echo on", 20), ("scan", 1500), ("set all MAX_TEMPERATURE 70C", 60), ("get 1-3 RETURN_DELAY", 40),
         ("torque 1 2 9 on", 60), ("move 1 400", 20), ("baud all 500000", 200), ("bus", 20)]

# A new servo, alone on the bus, and what restores its registers.
NEW_SERVO = [("echo on", 20), ("new 5", 4500), ("backup 5", 100), ("set 5 MIN_VOLTAGE 6V", 20)]


def text_of(field, row):
    """The string of a field of a row: adjacent literals, as one."""
    found = re.search(rf"\.{field} =\s*\w+\(((?:\s*{STRING})+)\s*\)", row)
    return "".join(part[1:-1] for part in re.findall(STRING, found[1])) if found else None


def commands():
    """(heading, usage, what, details, example) of each row, in the order of `help`."""
    heading = None
    for name in re.findall(r"&(\w+)_commands", PROFILE.read_text()):
        text = (FOLDER / f"{name}.c").read_text()
        heading = text_of("heading", text) or heading
        for row in re.findall(r"^    \{\n(        \.usage.*?)^    \},", text, re.M | re.S):
            yield heading.rstrip(":"), *(text_of(field, row)
                                         for field in ("usage", "what", "details", "example"))


def program(typed):
    lines = []
    for keys, ms in typed:
        lines += [f"say {keys.encode().hex(' ')}" if len(keys) == 1 else f"text {keys}",
                  f"wait {ms * 1000}", "rest"]
    return "\n".join(lines) + "\n"


def session(typed=SESSION, servos="1-3"):
    """What stands on the terminal in the end."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "pc"
        path.write_text(program(typed))
        done = subprocess.run(
            [ROOT / "build/host/cds55xx-sim", "firmware", ROOT / "build/atmega128/controller.elf",
             "--board", "atmega128", "--servos", servos, "--host", path], stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, text=True, timeout=120)
    if done.returncode:
        raise SystemExit(done.stdout)
    heard = [bytes.fromhex("".join(line.split()[4:])).decode()
             for line in done.stdout.splitlines() if line.startswith("heard")]
    shown = ""
    heard[0] = f"{typed[0][0]}\r\n{heard[0]}"  # that is not echoed yet
    for (keys, _), text in zip(typed, heard):  # what is typed is told from what is said
        shown += "> " + text if len(keys) > 1 else text
    return shown.replace("\r\n", "\n")


def shortened(text):
    """Without `version`, and with the first and last registers of `info` only."""
    text = re.sub(r"> version\n.*?ok\n", "", text, flags=re.S)
    return re.sub(r"(> info 1\n(?:0x.*\n){6})(?:0x.*\n)+(0x.*\nok\n)", r"\1...\n\2", text)


def escape(text):
    return text.replace("|", "\\|").replace("<", "&lt;")


def main(arguments):
    if arguments == ["--session"]:
        print(shortened(session()), end="")
        return
    rows = list(commands())
    print(f"""# The console

The text interface of the firmware on the host link: 8N1, at the rate of the board. `make docs` writes this page from
the rows of `src/controller/console/commands/` and from a real run in the simulator.

One command a line, ended by Enter. The reply has zero or more lines, then `ok`, or `error N: text; remedy`
([errors.md](errors.md)); the profile `console` leaves the remedy out. Lines that begin with `warning:` report a
condition; the command has worked. `help` lists the commands, `help COMMAND` explains one.

| key | what it does |
|---|---|
| Ctrl-X | **stops the robot** at once: torque off for all servos, verified servo by servo; no servo is driven until `release` ([safety.md](safety.md)). The line being typed is dropped, a running command ends as `error 54`, and the reply is that of `stop` |
| Backspace, Ctrl-U | delete the character before the cursor, the line |
| Ctrl-C | drops the line |
| Left, Right, Home, End; Ctrl-B, Ctrl-F, Ctrl-A, Ctrl-E | move the cursor within the line; text is inserted there |
| Del, Ctrl-D | delete the character at the cursor |
| Up, Down; Ctrl-P, Ctrl-N | the line before, the line after. A chip with 8 KB of RAM keeps 240 characters of lines, one with 4 KB keeps 88. A line that was begun is kept, too |
| Tab | with echo: completes commands, their words, registers and settings. If several fit, it completes what they share; a second Tab lists them. Without echo a Tab is a space |
| any key | ends `scan`, `diagnose` and `monitor`. The key is the first one of the next line; Enter begins none |

- `mode person` is for a terminal: a banner after a reset, a prompt and echo. `mode program` gives bare replies; a new
  controller has it. `save` keeps the mode over a reset. `echo on` gives echo alone. Local echo of the terminal beside it
  shows each character twice. After a packet of the host the console prints no prompt until the next line.
- Commands, their words, registers, settings and units may be typed in any case. Names of poses and sequences keep theirs.
- If a name is unknown, the error says which name is near: `did you mean torque?`
- In a line of more than 80 characters the older part can no longer be deleted. A line wider than the terminal can only
  be edited at its end.
- IDs are 0 to 253. Where the usage says `ID|254`, 254 is all servos. Bytes are 0 to 255.
- A list of servos may stand where the usage says `ID`, `ID|254` or `ID...`: `3`, `1-6`, `1,2,5-8`, or `all`, the
  servos of the robot. Several such words may follow each other (`torque 1 2 3 on`), but only one where a number
  follows (`move 1-3 90`). The command runs for one servo after the other. The reply has a line for each, `servo 3: ok`
  or the value or the error, and ends with `ok` only if all servos did it, else with error 87. The instructions of the
  manual, `id`, and the profile `console` take one servo.
- Numbers: `90`, `90.5deg`, `-20rpm`, `6.5V`, `512raw`, `0x1F`. A number without unit has the unit that `get` shows; `raw`
  is the value of the register ([registers.md](registers.md)). A number between two register values becomes the nearest
  one.
- The servos of the robot are those that `scan` finds or `group` names. The controller checks each of them once a second.
  Before the first check `servos` says `not asked yet`. A servo that lost its state is not driven until `release`.
- A servo with the factory value of the return delay, 2 us, may answer before the controller listens, but only while the PC
  sends, and rarely ([bridge.md](bridge.md#tests)). `set ID RETURN_DELAY 4us` prevents that.
- An error names servo, argument, value and allowed range: `error 33: servo 1: ANGLE 400 is out of range: 0 to 300deg`.
- After `scan` a line tells which servo answers sooner than this board listens, with the command that mends it. A servo
  whose long replies are damaged is diagnosed at once: two servos may have its ID ([diagnose.md](diagnose.md)).
- In the firmware profile `console`, the default on the ArbotiX, keys delete only at the end of the line, Up fetches only
  the last line, and there is no Tab, no `did you mean` and no `mode`. It has no `diagnose` (error 55), no `new`, no `backup`, and
  none of the commands of [Motion](#motion) (error 30). There an ID is one servo, an error has its text only, `monitor`
  prints lines, `settings` takes a rate as the register, `counters` only count, `scan` ends with the number of servos,
  and `help COMMAND` leaves ranges and examples to this page.
- How to teach, store and play poses: [motion.md](motion.md).

## If the console no longer answers

A saved `host_baud` that the terminal cannot do is undone from the keyboard:

1. Set the terminal to the rate of the board: 115200 bit/s, on `cm510` 57600.
2. Reset the board by its reset button, or switch its power off and on.
3. Press Enter three times or more in the 2 s after the reset. On a board with a boot loader these 2 s begin
   when the boot loader ends: go on pressing Enter. The console says `host link at own rate of the board: save
   keeps it`.
4. Type `save`. Without it the next reset brings the saved rate back.

For 2 s after power-on and an external reset the host link has the rate of the board if another rate is saved. In this
time:

- The controller takes only Enter and Ctrl-X. A program at the saved rate gets its first answer after the 2 s.
- Another byte between two Enters, or a damaged one, starts the count of Enters again.
- Ctrl-X at the rate of the board stops the robot within 21 ms, but only if no byte other than Enter and Ctrl-X came
  before it: other bytes come from a program at the saved rate.
- **Ctrl-X at the saved rate is not understood.**

After a reset by the watchdog or a brown-out the link has the saved rate at once.

## A first session

The firmware on a simulated ATmega128 with three servos. Lines behind `>` are input; the console itself prints no
prompt. Enter ends `monitor`; without `as plot` it draws a table that stays in place.

```
{session()}```

## Several servos at once

In the profile `full`. Servo 9 is absent, so the line ends with error 87. `baud` with a list is one change: the bus goes
along, and a servo that does not follow is named.

```
{session(LISTS)}```

## A new servo

In the profile `full`. The new servo is alone on the bus; if another one answers, `new` names both and writes nothing.
To restore registers, send the lines of `backup`: `set` writes only a value that differs, reads it back, and says
`written` or `unchanged`, or the error.

```
{session(NEW_SERVO, "1")}```

## Commands""")
    last = None
    for heading, usage, what, details, example in rows:
        if heading != last:
            print(f"\n### {heading}\n\n| command | what it does | ranges and remarks | example |")
            print("|---|---|---|---|")
            last = heading
        print(f"| `{escape(usage)}` | {escape(what)} | {escape(details)} | `{escape(example)}` |")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
