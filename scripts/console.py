#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""docs/console.md from the rows of src/controller/console/commands/*.c, and from a first session with the firmware in the simulator (arduino-mega, built). Prints the document.

usage: console.py [--session]    --session: only the session, shortened for docs/getting-started.md
"""
import pathlib
import re
import subprocess
import sys
import tempfile

from typed import lines_shown, steps_shown

ROOT = pathlib.Path(__file__).resolve().parents[1]
STRING = r'"(?:[^"\\]|\\.)*"'
FOLDER = ROOT / "src/controller/console/commands"
PROFILES = ROOT / "src/controller/profiles"
MESSAGES = ROOT / "src/controller/console/messages.c"

# What is typed, and for how long the reply is waited for, in ms. Ends a line: `\r`, as Enter does.
SESSION = [("version", 20), ("scan", 1500), ("servos", 30), ("info 1", 300), ("torque 1 on", 10),
           ("move 1 90deg 30rpm", 20), ("monitor 1 every 100ms as plot", 520), ("\r", 20),
           ("get 1 PRESENT_POSITION", 10), ("id 3 4", 20), ("ping 3", 20), ("help id", 30)]


# What is typed into tmux: keys, and what ends the screen then (typed.py).
KEYS = [("pnig 1[Left][Left][Left][Left]", r"> pnig 1"), ("[Backspace]", r"> pig 1"), ("[Right]n[End]3", r"> ping 13"), ("[Backspace][Enter]", r"ok\n>"), ("led 2 on[Enter]", r"ok\n>"),
        ("get 3", r"> get 3"), ("[Up][Up]", r"> ping 1"), ("[Down][Down]", r"> get 3"), (" LED[Enter]", r"ok\n>"),
        ("[Up][Up][Up]", r"> led 2 on"), ("[Home][Del][Del][Del]torque[Enter]", r"ok\n>"), ("ping 9[Ctrl-C]", r"> ping 9\n>")]
TAB = [("to[Tab]", r"> torque"), ("1 o[Tab]", r"\n> torque 1 o"), ("n[Enter]", r"ok\n>"),
       ("get 1 PRES[Tab]", r"> get 1 PRESENT_"),
       ("[Tab]", r"\n> get 1 PRESENT_"), ("P[Tab]", r"> get 1 PRESENT_POSITION"), ("[Enter]", r"ok\n>")]
HINTS = ["torqe 1 on", "get 1 PRESENT_VOLTAG", "PING 1", "Get 1 goal_position", "settings bus_bauds", "move 1 400", "led 1"]
MONITOR = [("monitor 1 2 9[Enter]", r"servo 9: absent"), ("p", r"ok\n> p"), ("ing 1[Enter]", r"ping 1\nok\n>")]
STOP = [("torque 1 on[Enter]", r"ok\n>"), ("move 1 9", "> move 1 9"), ("[Ctrl-X]", r"ok\n>"), ("torque 1 on[Enter]", r"error.*\n>"),
        ("release[Enter]", r"ok\n>")]

# Lists of servos, and errors that name servo, argument, value and range.
LISTS = ["scan", "torque 1 2 3 on", "set all MAX_TEMPERATURE 70C", "set 1-3 RETURN_DELAY 10us", "get 1-3 RETURN_DELAY",
         "torque 1 2 9 off", "baud all 500000", "bus", "settings bus_baud 500000", "id 1 1"]

# A new servo, alone on the bus, and what restores its registers.
NEW_SERVO = ["new 5", "backup 5", "set 5 MIN_VOLTAGE 6.5V", "restore 5 MIN_VOLTAGE 6V", "restore 5 MAX_VOLTAGE 16V"]

# What a program sends, and for how long it waits, in ms.
PROGRAM = [(b"\x03mode program\r", 30), (b"hello1\r", 80), (b"ping 1\r", 20),
           (b"get 1-3 PRESENT_POSITION\r", 40), (b"ping 9\r", 20)]

# The document above the table of the commands.
PAGE = """# The console

The text interface of the firmware on the host link: 8N1, at the rate of the board. `make docs` writes this page from
the rows of `src/controller/console/commands/` and from a real run in the simulator.

One command a line, ended by Enter. The reply has zero or more lines, then `ok`, or `error N: text; remedy`
([errors.md](errors.md)); the profile `console` leaves the remedy out. Text and remedy may differ from that list: while there is
noise, error 2 reads `error 2: noise on the line, ...`. Lines that begin with `warning:` report a
condition, with a list of servos also the servo; the command has worked. `help` or `?` lists the commands (in mode person `arduino-mega` and `cm510` only name them), `help COMMAND` explains one, `help units` the units, `help keys` the keys (`arduino-mega`, `cm510`).
Press Ctrl-C when you open the terminal: another terminal may have left a line half typed, and Enter would run it. `stop` stops, whatever
stands behind it.

| key | what it does |
|---|---|
| Ctrl-X | **stops the robot** at once: torque off for all servos, verified servo by servo; no servo is driven until `release` ([safety.md](safety.md)). The line being typed is dropped, a running command ends as `error 54`, and the reply is that of `stop` |
| Backspace | deletes the character before the cursor |
| Ctrl-U | deletes the last 80 characters of the line. Ctrl-C drops a longer line |
| Ctrl-W, Ctrl-K | delete the word before the cursor; all from the cursor on |
| Ctrl-C | drops the line |
| Left, Right, Home, End; Ctrl-B, Ctrl-F, Ctrl-A, Ctrl-E | move the cursor within the line; text is inserted there |
| Del, Ctrl-D | delete the character at the cursor |
| Up, Down; Ctrl-P, Ctrl-N | the line before, the line after. A chip with 8 KB of RAM or more keeps 240 bytes of lines, one with 4 KB keeps 88; a line takes a byte more than its characters. A line of more than 80 characters is not kept. A line that was begun is kept, too |
| Tab | with echo: completes commands, their words, registers, settings, and (not on `atmega1284p`) the names of stored poses and sequences. If several fit, it completes what they share, and lists them if they share no more. Without echo a Tab is a space |
| any key | ends `scan`, `diagnose`, `monitor`, the search of `new` and `motion wait`. A key that is not Enter is also the first one of the next line |

- A new controller is in `mode person`: a banner after a reset (with the cause, if it was watchdog or brown-out), a prompt and echo. A terminal with local echo shows each
  character twice: switch that off. `mode echo` has echo alone, `mode program` bare replies: [for programs](#for-programs).
  `save` keeps the mode over power-off.
- In mode person `help` lists only the names of the commands, and `help all` how each is written (`arduino-mega`, `cm510`); `help motion`
  explains the commands below the heading "Motion", `help one servo` those below "One servo". On `atmega128` `help` lists how each command
  is written. On `atmega1284p`, in the profile `console` and in the other modes `help` lists all with an explanation.
- In mode person `settings` also tells what a value means, and the autostart; an empty `pose list` or `sequence list` says so (`arduino-mega`, `cm510`).
- `limits 1` prints the line that sets the soft limits of servo 1 again, `limits` the line of each servo with limits; `limits 1 off` removes them (`arduino-mega`,
  `cm510`). On other boards `servos` shows them, and `limits 1 0 300` removes them.
- Each servo that gets its factory values gets ID 1, so `factory` with a list of servos is error 53 (`arduino-mega`, `cm510`).
- Commands, their words, registers, settings and units may be typed in any case. Names of poses and sequences keep theirs.
- If a name is unknown, the error says which name is near: `did you mean torque?` A part of a name is enough: `get 1 temp` names
  MAX_TEMPERATURE and PRESENT_TEMPERATURE (not on `atmega1284p`).
- In a line of more than 80 characters the older part can no longer be deleted. A line wider than the terminal can only
  be edited at its end.
- IDs are 0 to 253. Where the usage says `ID|254`, 254 is all servos. Bytes are 0 to 255.
- Where the usage says `ID`, `ID|254` or `ID...`, a list of servos may stand: `3`, `1-6`, `1,2,5-8`, or `all`, the servos of
  the robot. The instructions of the manual, `id`, and the profile `console` take one servo.
- A list may have blanks (`torque 1 2 3 on`), but not where a number follows: write `move 1-3 90`. The line `move 1 2 30` moves
  servo 1 to 2deg at 30rpm, and a warning says so if the robot has a servo 2. `get 1 2 3` reads register 3 of servos 1 and 2; a warning says so if the robot has
  a servo 3 (not on `atmega1284p`).
- With a list, the command runs for one servo after the other. The reply of each servo begins with `servo 3: ` (but not that of
  `backup`); then comes `ok`, the value or the error. The last line is `ok` if all servos did it, else error 87.
- Numbers: `90`, `90.5deg`, `-20rpm`, `6.5V`, `512raw`, `0x1F`. A number without unit has the unit that `get` shows; `raw`
  is the value of the register ([registers.md](registers.md)). A number between two register values becomes the nearest
  one.
- The servos of the robot are those that `scan` finds or `group` names. The controller checks each of them once a second.
  Before the first check `servos` says `not asked yet`. A servo whose torque went off by itself
  has lost its state: the console says so at once, as it does an alarm (after an absence with the line about its return), and the servo is not driven until `release`.
  In mode person on `arduino-mega` and `cm510` (profile `full`) the line also comes during `monitor`, above its table, and while a line
  of up to 80 characters is half typed, above that line; else, and during other commands, it waits.
- On the same boards the console also tells a person, once, that a fault it has told is over for 1.5 s (a fault of the line: 2 s), and what to do next:
  `servo 2 answers again, torque on; it may be driven` (or `two servos may have its ID`, if its replies came damaged before), `bus ok again; driving is inhibited until 'release'`,
  `stop: torque read back as off at all servos; ...` if `stop` could not say so (without a known servo: `stop: sent; ...`). A remedy that was printed just before, as by the error of
  the same command, is left out of the next warning or alarm: `alarm of servo 1: range`. A servo that comes and goes within that time
  is told as offline once. After the first command a line says if the sequence of the autostart does not play.
- A servo with the factory value of the return delay, 2 us, may answer before the controller listens, but only while the PC
  sends, and rarely ([bridge.md](bridge.md#tests)). `set ID RETURN_DELAY 4us` prevents that; `new` sets it.
- `cycle` counts a period as `unsent` if its goals did not leave: all servos were left out, or the line was busy. A servo is left out
  when its goal was refused, as by a stop, until the next `pose`.
- An error names servo, argument, value and allowed range: `error 33: servo 1: ANGLE 400deg is out of range: 0 to 300deg`. Error 56, a
  time, has its range, too, but not on `atmega1284p`. With a list of servos a number out of range is refused for all, before anything is sent.
- After `scan`, also `scan all`, a line tells which servo answers sooner than this board listens, with the command that mends it.
  A servo whose long replies are damaged is diagnosed at once: two servos may have its ID ([diagnose.md](diagnose.md)). Only
  servos at the rate of the bus are checked so: for others, `bus RATE`, then `scan`.
- In the firmware profile `console`, the default on the ArbotiX, keys delete only at the end of the line, Up fetches only
  the last line, and there is no Tab and no `did you mean`. It has no `diagnose` (error 55){omitted},
  and none of the commands of [Motion](#motion) (error 30). There an ID is one servo, an error has its text only, `monitor`
  prints lines, `settings` takes a rate as the register, `counters` prints no age and no part of `scan`, `scan` ends with the number of servos,
  `torque on` of a servo that has shut down says `ok` behind the warning, not error 85,
  and `help COMMAND` leaves ranges and examples to this page.
- How to teach, store and play poses: [motion.md](motion.md).

## For programs

A program that types commands sends `mode program` first, and then reads bare replies:

1. Send Ctrl-C (byte 0x03), which drops a line that is not ended and ends `monitor` or a search of an earlier program. Then
   send `mode program` and Enter, and wait for a line that is `ok`. A line ends with CR LF; before the prompt stands a CR.
2. Send `hello1`, which is no command. Drop all text up to a line that begins with `error 30: 'hello1'`: no other line has this
   reply. If it does not come within 0.5 s, send `hello2`, and so on: a line may be lost while an earlier command ends.
3. From then on each command is answered by the lines of its reply and `ok` or `error N: ...`, and nothing else. Exception:
   with the setting `alarm_report` 1 a line `alarm ...` may come between two replies.
4. After a reset of the controller begin again; or let it start in this mode: `mode program`, then `save`.

A program that only sends packets needs no mode: packets are answered in each mode, text is never printed within a status
packet, and no prompt comes after it. The first bytes after a reset may be the banner: look for `FF FF` ([bridge.md](bridge.md)).
`echo off` and `echo on` are the same as `mode program` and `mode echo`.

A session of a program with servos 1 to 3 in the simulator, in the notation of Python. The first reply begins with the echo:

```
{program}```

A [scenario](scenario.md) of the simulator does this by itself.

## If the console no longer answers

After `settings host_baud` the terminal must have the new rate, too: end it, and start it with this rate, as in
`picocom -q -e t -b 57600 /dev/ttyUSB0`. If the terminal cannot do the rate, and `save` was not typed, reset the board:
the console is back at the rate from before. In the simulator `make poke DO="reset power"` is this reset, and the rate of the
terminal counts only with `make run HOST_BAUD=client`.

A saved `host_baud` that the terminal cannot do is undone from the keyboard:

1. Set the terminal to the rate of the board: 115200 bit/s, on `cm510` 57600.
2. Reset the board by its reset button, or switch its power off and on.
3. Press Enter three times or more in the 2 s after the reset. On a board with a boot loader these 2 s begin
   when the boot loader ends: go on pressing Enter. The console says `host link at the board's rate: save
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

The firmware on a simulated Arduino Mega with three servos. `> ` is the prompt of the console. Enter ends
`monitor`; without `as plot` it draws a table that stays in place.

```
{session}```

## Keys

This session and those below were typed into tmux, an ordinary terminal, by `make docs`. Behind `typed:` are the keys, names of
keys in brackets. Then follows the screen, from the line on in which they were typed. The profile is `full`.

```
{keys}```

## Tab

Tab completes a word. If it has nothing to add, it lists what fits.

```
{tab}```

## Wrong lines

An unknown name is answered with a name near it. An error names servo, argument, value and range. Capital and small letters are the same.

```
{hints}```

## A table that stays in place

`monitor` draws its table over the one before, here with the absent servo 9. The key that ends it, `p`, is the first one of the
next line. N and M depend on when the key comes.

```
{monitor}```

## Ctrl-X

Ctrl-X stops the robot in the middle of a line. `IDs not checked: 254`: torque off goes to every ID, and is read back from the
servos of the list; here the list is empty.

```
{stop}```

## Several servos at once

Servo 9 is absent, so its line ends with error 87. `baud` with a list is one change: the bus goes along, and a servo that does
not follow is named. Typed into tmux as above.

```
{lists}```

## A new servo

The new servo is alone on the bus; if another one answers, `new` names both and writes nothing (error 89). An ID of the robot's
list is refused, as NEW (error 11) and as that of the servo found (error 95): `servos forget` empties the list, and of several
new servos the last gets ID 1, the factory's ([hardware.md](hardware.md#more-new-servos)). The six listed rates are 1000000,
500000, 250000, 117647, 57143 and 19231 bps: those of the manual, which a servo keeps over power-off. Behind another rate the console
prints `, until power-off`: then the servo is back at its last listed rate. Typed into tmux as above.

`new`, `id`, `baud`, `factory`, `lock`, `set` of a register in EEPROM and `restore` try three times if a packet or its reply
is lost. They read first, and write again only if the servo shows that the write was lost. What a servo refuses is not tried
again.

```
{new_servo}```

### Backup and restore

These two lines of the shell save the registers of servos 1 to 3 to a file, and send them back. Close the terminal program first
(picocom: Ctrl-T, then Ctrl-Q): two programs on one port take each other's replies.

```sh
echo 'backup 1-3' | scripts/send-lines.py --replies /dev/ttyUSB0 /dev/stdin > servos.txt
scripts/send-lines.py /dev/ttyUSB0 servos.txt
```

Behind each line of the file stands what the console replied: `unchanged`, or the old value and `differed: written`. The
CM-510 needs its rate at the end of both lines of the shell: `servos.txt 57600`, `/dev/stdin 57600`. Do not paste the lines of a backup into
a terminal: they are too fast, and some of them are lost (error 36). Afterwards the console is in mode program: `mode person`
brings the prompt back.

`restore` reads the register, shows a value that differs, writes it and reads it back. An error follows the
name of the register: `not written`, the servo does not hold the new value; `sent, not confirmed`, the servo could not be read back,
so it may hold the new value: send the line again.

## Commands"""


def text_of(field, row):
    """The string of a field of a row: adjacent literals, as one, or a message of messages.c."""
    name = re.search(rf"\.{field} = (message_\w+),", row)
    if name:
        return re.search(rf"{name[1]}\[\] = ({STRING})", MESSAGES.read_text())[1][1:-1]
    found = re.search(rf"\.{field} =\s*\w+\(((?:\s*{STRING})+)\s*\)", row)
    return "".join(part[1:-1] for part in re.findall(STRING, found[1])) if found else None


def commands(profile="full", has_room=True):
    """(heading, usage, what, details, example) of each row, in the order of `help`; has_room: on a chip with 256 KB of flash."""
    heading = None
    groups = re.search(r" groups\[\] = \{\n(.*?)^\};", (PROFILES / f"{profile}.c").read_text(), re.M | re.S)[1]
    groups = re.sub(r"^#if HAS_ROOM\n(.*?)(?:^#else\n(.*?))?^#endif\n",
                    lambda match: match[1] if has_room else match[2] or "", groups, flags=re.M | re.S)
    for name in re.findall(r"&(\w+)_commands", groups):
        if not (FOLDER / f"{name}.c").exists():
            continue  # of commands that the profile omits
        text = (FOLDER / f"{name}.c").read_text()
        heading = text_of("heading", text) or heading
        for row in re.findall(r"^    \{\n(        \.usage.*?)^    \},", text, re.M | re.S):
            texts = {field: text_of(field, row) for field in ("usage", "what", "details", "example")}
            for field, text_of_field in texts.items():
                if text_of_field is None and field != "example":  # none: it is the usage
                    raise SystemExit(f"{name}.c: {texts['usage']}: .{field} is missing")
            yield heading.rstrip(":"), *texts.values()


def heard(typed, servos):
    """What the PC hears after each of `typed`: (bytes, ms to wait). The first entry: banner and prompt."""
    program = ["wait 50000", "rest"]
    for data, ms in typed:
        program += [f"say {data.hex(' ')}", f"wait {ms * 1000}", "rest"]
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "pc"
        path.write_text("\n".join(program) + "\n")
        done = subprocess.run(
            [ROOT / "build/host/cds55xx-sim", "firmware", ROOT / "build/arduino-mega/controller.elf",
             "--board", "arduino-mega", "--servos", servos, "--host", path], stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, text=True, timeout=120)
    if done.returncode:
        raise SystemExit(done.stdout)
    return [bytes.fromhex("".join(line.split()[4:])).decode()
            for line in done.stdout.splitlines() if line.startswith("heard")]


def session():
    """The first session, as it stands on the terminal in the end."""
    typed = [((keys if keys == "\r" else keys + "\r").encode(), ms) for keys, ms in SESSION]
    shown = "".join(heard(typed, "1-3")).replace("\r\n", "\n").replace("\r", "")
    return re.sub("^> $", ">", shown.removesuffix("> "), flags=re.M)  # no blank at the end of a line


def program_session():
    """Each line of a program, and the bytes of its reply, in Python's way to write them."""
    replies = heard(PROGRAM, "1-3")[1:]
    return "".join(f"sends {data.decode()!r}\nreads {reply!r}\n" for (data, _), reply in zip(PROGRAM, replies))


def shortened(text):
    """Without `version`, and with the first and last registers of `info` only."""
    text = re.sub(r"> version\n.*?ok\n", "", text, flags=re.S)
    return re.sub(r"(> info 1\n(?:0x.*\n){6})(?:0x.*\n)+(0x.*\nok\n)", r"\1...\n\2", text)


def escape(text):
    return text.replace("|", "\\|").replace("<", "&lt;")


def omitted_commands(rows):
    """The commands that the profile `console` lacks, but for those that PAGE names itself."""
    in_console = {usage.split()[0] for _, usage, *_ in commands("console")} | {"diagnose"}
    names = dict.fromkeys(usage.split()[0] for heading, usage, *_ in rows if heading != "Motion")
    return "".join(f", no `{name}`" for name in names if name not in in_console)


def print_commands(rows):
    last = None
    everywhere = set(commands(has_room=False))
    for heading, usage, what, details, example in rows:
        if (heading, usage, what, details, example) not in everywhere:
            details += ". Only on chips with 256 KB of flash"
        if heading != last:
            print(f"\n### {heading}\n\n| command | what it does | ranges and remarks | example |")
            print("|---|---|---|---|")
            last = heading
        print(f"| `{escape(usage)}` | {escape(what)} | {escape(details)} | `{escape(example or usage)}` |")


def main(arguments):
    if arguments == ["--session"]:
        print(shortened(session()), end="")
        return
    rows = list(commands())
    print(PAGE.format(omitted=omitted_commands(rows), program=program_session(), session=session(), keys=steps_shown(KEYS),
                      tab=steps_shown(TAB), hints=lines_shown(HINTS), monitor=steps_shown(MONITOR), stop=steps_shown(STOP),
                      lists=lines_shown(LISTS), new_servo=lines_shown(NEW_SERVO, "1")))
    print_commands(rows)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
