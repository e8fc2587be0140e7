# SPDX-License-Identifier: MIT
"""Every command of the console, its help and each of its errors, on every board with a host link:
by script, with what stands in the servos and on the wire afterwards, and over the pty, as a person
would type it."""
# needs: $(CONSOLE_ELFS)
import os
import re
import select
import signal
import subprocess
import sys
import tempfile
import time
import tty
import unittest

import boards
from client import BROADCAST, PING, READ, REG_WRITE, WRITE, packet, word
from simulator import LONG, PATIENCE_S, ROOT, SIM, controller, settle

sys.path.append(str(ROOT / "scripts"))
import console  # the rows of the commands

# Numbers that the console cannot say: 1 is no end; 4 and 8 are of requests that one console on one
# bus never shares or takes back; the console checks arguments itself, so 5 does not come.
UNSAID = {0, 1, 4, 5, 8}


def rows(path, name, fields):
    """The rows X(first, ...) of the table `name`: {first: [all fields]}, texts without quotes."""
    text = (ROOT / path).read_text().replace("\\\n", " ")
    text = re.search(rf"#define {name}\(X\)(.*)", text)[1]
    text = re.sub(r"/\*.*?\*/", "", text)
    text = re.sub(r'"\s*SERVO_ID\s*"', "ID", text)
    text = re.sub(r'"\s*COMMAND_NAME\s*"', "COMMAND", text)
    string = r'"(?:[^"\\]|\\.)*"'
    found = {}
    for row in re.findall(rf"X\(((?:{string}|[^()\"])*)\)", text):
        row = re.sub(r'"\s+"', "", row)  # adjacent texts are one
        values = [value.strip().strip('"') for value in re.findall(rf"{string}|[^,\"]+", row)]
        values = [value for value, raw in zip(values, re.findall(rf"{string}|[^,\"]+", row))
                  if raw.startswith('"') or value]
        assert len(values) == fields, values
        found[values[0]] = values
    return found



def commands_of(profile="full", has_room=True):
    """By name, a list of its rows: (heading, usage, what, details, example)."""
    found = {}
    for row in console.commands(profile, has_room):
        found.setdefault(row[1].split()[0], []).append(row)
    if profile == "console":
        found["diagnose"] = [("The bus", "diagnose [ID|254]", "not in this firmware", "", "")]
    return found


COMMANDS = commands_of()
ERROR_ROWS = [row for path, table in [("include/cds55xx/result.h", "CDS_RESULTS"),
                                      ("src/controller/console/errors.h", "CONSOLE_ERRORS"),
                                      ("src/controller/console/errors.h", "FULL_ERRORS")]
              for row in rows(path, table, 4).values()]
CAUSES = {int(number): cause for _, number, cause, _ in ERROR_ROWS}
ERRORS = {int(number): f"{cause}; {remedy}" for _, number, cause, remedy in ERROR_ROWS}


def errors_of(profile):
    """The texts of errors by number: the profile `console` leaves remedies to docs/errors.md."""
    return CAUSES if profile == "console" else ERRORS


def wire(*arguments):
    return f"@expect packet in {packet(*arguments).hex(' ').upper()}\n"


def servo(what):
    return f"@expect servo {what}\n"


def text(what):
    return f"@expect text {what}\n"


# Errors whose line names the word or the value, in the profile `full`: test_explain.c.
EXPLAINED = {11, 30, 31, 32, 33, 34, 38, 39, 41, 42, 60, 95}
# Errors whose line names the servo, in the profile `full`.
OF_SERVO = {2, 3, 5, 7, *range(9, 15), *range(20, 24), 42, 47, 48, 50, 51, 52}


# The reason of each error 9 here, in the profile `full`.
LINE_IS_LOW = "the line is held low; look for a short circuit"


def error(number, line):
    """A line and its error, which said_by() completes for a profile."""
    return f"! {line}\n" + text(f"ERROR {number}: {line}")


def error_line(number, line, profile):
    """How the last line of the reply begins."""
    words = line.split()
    start = f"error {number}: "
    if profile == "console":
        return start + CAUSES[number]
    if number in EXPLAINED or words[0] == "pose":
        return start
    cause = LINE_IS_LOW if number == 9 else ERRORS[number].removeprefix("servo: ")
    if number in (12, 21, 23, 40, 47) or (number, words[0]) == (54, "release"):
        cause = CAUSES[number].removeprefix("servo: ")  # the remedy depends on the board: advice.h
    if number in OF_SERVO and words[0] not in ("group", "sync") and len(words) > 1 \
            and words[1].isdigit():
        return start + f"servo {words[1]}: {cause}"[:130]
    return start + (cause if number in (9, 40, 54) else ERRORS[number])[:130]


def said_by(profile, script):
    return re.sub(r"(?<=@expect text )ERROR (\d+): (.*)",
                  lambda match: error_line(int(match[1]), match[2], profile), script)


# The factory's return delay of 2 us is too short for a controller that hears the PC meanwhile.
SLOWER = "".join(f"write {n} RETURN_DELAY 10\n" for n in (1, 2, 3))

# By command; nothing is known of servos until scan, so that nobody else sends.
SCRIPT = {
    "echo": "echo on\nversion\n" + text("version") + "echo off\n",
    "mode": "mode person\nversion\n" + text("version") + "MODE program\n",
    "version": "version\n" + text("cds55xx 0.1.0 BOARD"),
    "help": "help\n" + text("One servo:") + text("move ID|254 ANGLE [SPEED]: go to an angle")
            + error(30, "help me"),
    "ping": "ping 1\n" + wire(1, PING) + error(2, "ping 99") + error(31, "ping")
            + error(32, "ping one") + error(33, "ping 255") + error(30, "pong 1")
            + "@fault flip out 1 4 3\n" + error(3, "ping 1")
            + "@fault stuck low 30\n" + error(9, "ping 1") + "@wait 40\n",
    "read": "read 1 PRESENT_VOLTAGE\n" + wire(1, READ, [0x2A, 1]) + text("0x2A: 78")
            + text("PRESENT_VOLTAGE = 120") + error(34, "read 1 NOTHING") + error(33, "read 1 0 51"),
    "write": "write 1 LED 1\n" + wire(1, WRITE, [0x19, 1]) + servo("1 LED 1")
             + error(21, "write 1 PRESENT_POSITION 1") + error(33, "write 1 LED 2")
             + "@fault flip in 1 4 3\n" + error(22, "write 1 LED 1"),
    "regwrite": "regwrite 1 LED 0\n" + wire(1, REG_WRITE, [0x19, 0])
                + servo("1 REGISTERED_INSTRUCTION 1") + servo("1 LED 1"),
    "action": "action\n" + wire(BROADCAST, 5) + servo("1 LED 0") + error(20, "action 1"),
    "sync": "sync LED 1 1:1 2:1 3:0\n" + wire(BROADCAST, 0x83, [0x19, 1, 1, 1, 2, 1, 3, 0])
            + servo("1,2 LED 1") + servo("3 LED 0") + error(37, "sync LED 1 1:1,2")
            + error(6, "sync 0x1E 4 " + " ".join(f"{n}:1,0,1,0" for n in range(51))),
    "led": "led 1 off\n" + wire(1, WRITE, [0x19, 0]) + servo("1 LED 0") + "led 254 on\n"
           + servo("1-3 LED 1") + error(38, "led 1 maybe") + error(31, "led 1"),
    "torque": "torque 1 on\n" + wire(1, READ, [6, 28]) + wire(1, WRITE, [0x18, 1]) + servo("1 torque on") + "torque 254 off\n"
              + wire(BROADCAST, WRITE, [0x18, 0]) + servo("1-3 torque off")
              + error(38, "torque 1 maybe"),
    "move": "torque 1 on\nmove 1 90.5deg 30rpm\n" + wire(1, READ, [6, 19])
            + wire(1, WRITE, [0x1E] + word(309) + word(495)) + servo("1 GOAL_POSITION 309")
            + servo("1 PRESENT_POSITION 306..311 within 3000") + "move 1 512raw\n"
            + servo("1 GOAL_POSITION 512") + servo("1 MOVING_SPEED 495") + "move 2 100\n"
            + text("moves once torque is on")
            + servo("2 GOAL_POSITION 341") + servo("2 PRESENT_POSITION 512") + "move 254 150\n"
            + wire(BROADCAST, WRITE, [0x1E] + word(512)) + servo("1-3 GOAL_POSITION 512")
            + error(33, "move 1 301") + error(39, "move 1 90rpm") + error(32, "move 1 x")
            + error(33, "move 1 90 63rpm") + error(33, "move 1 1024raw")
            + "write 1 CCW_ANGLE_LIMIT 511\n" + error(23, "move 1 512raw")
            + "write 1 CCW_ANGLE_LIMIT 1023\n",
    "turn": "torque 2 on\nturn 2 -20rpm\n" + text("limits are 0: endless turn")
            + servo("2 CCW_ANGLE_LIMIT 0") + servo(f"2 MOVING_SPEED {0x400 + 330}")
            + servo("2 PRESENT_SPEED 1345..1364") + "turn 2 0\n" + servo("2 MOVING_SPEED 0")
            + error(47, "move 2 90") + error(33, "turn 2 63") + "torque 2 off\n",
    "get": "get 1 CCW_ANGLE_LIMIT\n" + wire(1, READ, [8, 2]) + text("CCW_ANGLE_LIMIT = 300deg (1023)")
           + "get 1 0x08\n" + text("CCW_ANGLE_LIMIT = 300deg (1023)") + "get 1 ID\n" + text("ID = 1")
           + "get 2 present-voltage\n" + text("PRESENT_VOLTAGE = 12V (120)") + error(34, "get 1 EYE"),
    "set": "set 2 CCW_ANGLE_LIMIT 300\n" + text("written") + servo("2 CCW_ANGLE_LIMIT 1023")
           + "set 2 CCW_ANGLE_LIMIT 300deg\n" + text("unchanged")
           + "set 1 MIN_VOLTAGE 6.5V\n" + servo("1 MIN_VOLTAGE 65") + "set 1 MIN_VOLTAGE 6000mV\n"
           + servo("1 MIN_VOLTAGE 60") + "set 1 ACC 0x20\n" + wire(1, WRITE, [0x22, 32])
           + "set 1 MOVING_SPEED 30rpm\n" + servo("1 MOVING_SPEED 495")
           + error(42, "set 1 PRESENT_POSITION 5") + error(42, "set 1 ID 5")
           + error(39, "set 1 MIN_VOLTAGE 6C") + error(33, "set 1 MIN_VOLTAGE 26")
           + error(33, "set 1 STATUS_RETURN_LEVEL 3") + "set 1 STATUS_RETURN_LEVEL 0\n" + servo("1 STATUS_RETURN_LEVEL 0")
           + "set 1 0x10 2\n" + servo("1 STATUS_RETURN_LEVEL 2") + "get 1 LED\n",
    "info": "info 1\n" + wire(1, READ, [0, 50]) + text("0x03 ID = 1 EEPROM")
            + text("0x04 BAUD_RATE = 1000000bps (1) EEPROM")
            + text("0x1E GOAL_POSITION = 150.147deg (512) RAM")
            + text("0x2B PRESENT_TEMPERATURE = 32C (32) RAM") + text("0x30 PUNCH = 90 RAM")
            + error(2, "info 77"),
    "monitor": error(40, "monitor 1 2 3 4 5 6 7 8 9") + error(41, "monitor 1 1")
               + error(33, "monitor 1 every 9ms") + error(39, "monitor 1 every 9V")
               + error(38, "monitor 1 often 9") + error(2, "monitor 77") + error(31, "monitor"),
    "counters": "counters\n" + text("line busy 1") + error(48, "counters 9"),
    "bus": "bus\n" + text("bus ok at 1000000bps") + "bus 57600bps\n" + "! ping 1\n" + text("error 2: ")
           + "bus 1raw\nping 1\n" + error(33, "bus 1500000") + error(39, "bus 1deg")
           + error(33, "bus 255raw"),
    "id": "id 1 9\n" + text("ID 9 at 1000000bps") + servo("1 ID 9") + error(2, "ping 1") + "id 9 1\n"
          + servo("1 ID 1") + error(50, "id 1 2") + servo("1 ID 1") + "id 1 1\n" + wire(1, PING)
          + error(2, "id 78 78") + error(2, "id 77 78") + "@fault unplug in 5 5 1 500\n" + error(51, "id 1 9") + "@wait 600\n"
          + "ping 1\n" + "write 1 RETURN_DELAY 10\n",
    "baud": "baud 3 1000000\n" + wire(3, PING) + "baud 3 57600\n" + text("ID 3 at 57143bps") + servo("3 BAUD_RATE 34") + "ping 3\n"
            + "! ping 1\n" + text("error 2: ") + "baud 3 1000000bps\n" + servo("3 BAUD_RATE 1")
            + "baud 3 500kbps\n" + "baud 3 66raw\n" + text("ID 3 at 29851bps, until power-off")
            + "baud 3 1raw\nping 1\n"
            + error(33, "baud 3 3000000") + error(39, "baud 3 5V") + error(33, "baud 3 255raw"),
    "lock": "lock 3\n" + text("written") + servo("3 LOCK 1") + "lock 3\n" + text("unchanged")
            + error(21, "set 3 MIN_VOLTAGE 7V") + error(21, "id 3 30") + error(2, "lock 77")
            + "@power 3 off\n@power 3 on\n@wait 10\n" + servo("3 LOCK 0"),
    "diagnose": "diagnose 1\n" + text("finding 1: one servo answers well, as far as the wire shows; nothing to do")
                + text("ID 1 at 1000000bps") + "diagnose 77\n" + text("finding 11:") + text("bps: another")
                + "@expect rule collision\n"  # all that there are answer its broadcast PING
                + "@power off\ndiagnose 1\n" + text("finding 9: no servo answers") + "@power on\n"
                + "@wait 10\n@supply 1 5.5\n@wait 5\ndiagnose 1\n" + text("finding 14:")
                + text("ID 1 at 1000000bps, supply 5500 mV") + "@supply 1 12\n@wait 5\n",
    "scan": "scan\n" + text("id 1 model 1") + text("id 2 model 1") + text("id 3 model 1")
            + text("3 found, 254 asked") + "baud 3 57600\nbus 1000000\nscan all\n"
            + text("id 2 model 1 at 1000000bps") + text("id 3 model 1 at 57143bps")
            + text("3 found, 1524 asked") + "bus 57600\nbaud 3 1000000\n" + error(38, "scan here"),
    "servos": "servos forget\nscan\n@wait 1500\nservos\n" + text("servo 1: online, torque off")
              + text("servo 3: online, torque off") + "counters 1\n" + text("timeouts 0")
              + "torque 1 on\n@power 1 off\n@wait 4000\nservos\n" + text("servo 1: offline, torque unknown")
              + "@power 1 on\n@wait 3000\nservos\n"
              + text("servo 1: online, torque off, inhibited: lost its state")
              + error(12, "torque 1 on") + "release 1\ntorque 1 on\n" + servo("1 torque on")
              + "@power 2 off\n@wait 10\n@power 2 on\n@wait 10\n",
    "limits": "limits 2 60 240deg 31rpm\n" + error(11, "move 2 50") + error(11, "move 2 90 32rpm")
              + "move 2 90 30rpm\n" + servo("2 GOAL_POSITION 307") + error(33, "limits 2 240 60")
              + error(48, "limits 77 0 300") + error(39, "limits 2 0 3rpm")
              + "limits 2 0 300 0rpm\nmove 2 100 62rpm\n" + "limits 2 0 300\n"
              + "move 2 50\n",
    "group": error(45, "group") + error(45, "pose 90") + error(45, "cycle every 4ms")
             + "group 1 2 3\n" + text("group 1 2 3 sync") + "group\n" + text("group 1 2 3 sync")
             + error(38, "group 1 2 maybe") + error(41, "group 1 2 1")
             + error(40, "group " + " ".join(str(n) for n in range(51)))
             + error(40, "group " + " ".join(str(n) for n in range(100, 116)))
             + "id 3 9\ngroup\n" + text("group 1 2 9 sync") + "id 9 3\ngroup\n" + text("group 1 2 3 sync")
             + "servos\n" + text("servo 3: online") + "stop\nrelease\n",
    "pose": "torque 254 on\npose 90 150.5 512raw at 30rpm\n" + servo("1 GOAL_POSITION 307")
            + servo("2 GOAL_POSITION 513") + servo("3 GOAL_POSITION 512")
            + servo("1-3 MOVING_SPEED 495") + error(46, "pose 1 2") + error(33, "pose 1 2 301")
            + error(39, "pose 1 2 3rpm") + error(39, "pose 1 2 3 at 3deg") + "group 1 2 3 action\n"
            + "pose 60 70 80\n" + servo("1-3 MOVING_SPEED 330") + servo("1 GOAL_POSITION 205")
            + servo("1 PRESENT_POSITION 202..208 within 3000") + servo("1-3 torque on")
            + "write 2 CCW_ANGLE_LIMIT 100\n" + error(7, "pose 100 110 120")
            + servo("1 GOAL_POSITION 205") + servo("1-3 REGISTERED_INSTRUCTION 0")
            + "write 2 CCW_ANGLE_LIMIT 1023\ngroup 1 2 3\npose 100 40 80 in 1s\n"
            + servo("1 PRESENT_POSITION 338..344 within 1500") + servo("2 PRESENT_POSITION 133..139 within 20")
            + servo("3 PRESENT_POSITION 270..276 within 20") + error(57, "pose 100 200 80 in 200ms")
            + text("servo 2 needs ") + error(56, "pose 1 2 3 in 0s") + error(56, "pose 1 2 3 in 601s")
            + error(39, "pose 1 2 3 in 3rpm") + "limits 3 0 200deg\n" + error(11, "pose 100 40 201 in 2s")
            + "limits 3 0 300deg\n",
    "cycle": error(44, "cycle") + error(44, "cycle off") + error(33, "cycle every 1ms")
             + "cycle every\ncycle\ncycle off\n" + error(39, "cycle every 4V") + "cycle every 5ms\n@wait 100\n"
             + "cycle\n" + text("missed 0, unsent 0") + text("failed 0") + text("servo 1: ")
             + "pose 100 110 120\n" + servo("1 GOAL_POSITION 341") + servo("3 GOAL_POSITION 409")
             + error(43, "scan") + error(43, "id 1 9") + error(43, "group 1") + error(43, "diagnose")
             + error(43, "move 1 90") + error(43, "turn 1 10rpm") + error(43, "move 254 90")
             + error(43, "bus 57600") + error(43, "cycle every 4ms") + error(43, "servos forget")
             + "led 1 off\n" + servo("1 LED 0") + "cycle off\n" + error(44, "cycle"),
    "stop": "torque 254 on\n" + servo("1-3 torque on") + "stop\n" + servo("1-3 torque off")
            + "servos\n" + text("servo 2: online, torque off, inhibited: stopped") + error(54, "torque 1 on")
            + error(54, "move 1 90") + "torque 1 off\n@power 3 off\n" + error(2, "stop")
            + text("servo 3: no answer") + "@power 3 on\n@wait 1500\n",
    "release": error(54, "release 1") + error(54, "torque 2 on") + "release\ntorque 1 on\ntorque 2 on\n"
               + servo("1,2 torque on") + error(48, "release 77"),
    "factory": error(53, "factory 254") + "! factory 3\n" + text("error 50: ") + "! reset 3\n" + text("error 50: ") + "set 1 MIN_VOLTAGE 7V\n"
               + "factory 1\n" + text("ID 1 at 1000000bps") + servo("1 MIN_VOLTAGE 60")
               + "servos forget\nservos\n" + text("the list is empty") + "@servos 7\nfactory 254 force\n"
               + servo("7 ID 1"),
    "reset": "@servos 8\nreset 8\n" + wire(8, 6) + servo("8 ID 1"),
}

# Commands that only the profile `full` has, and what it adds to others. They run on a chip with 256 KB of flash, which has all.
FULL_ONLY = {
    "new": error(89, "new 9") + text("id 1 at 1000000bps") + servo("1-3 RETURN_DELAY 10")
           + "@servos 1\nbaud 1 66raw\nbus 1000000\nnew 9\n" + text("step 1 of 4: search")
           + text("not there: search at all 255 rates")
           + text("one ID answers: ID 1 at 29851bps; connect one servo only")
           + text("step 2 of 4: return delay 4 us")
           + text("step 3 of 4: ID 1 becomes 9") + text("step 4 of 4: rate 29851bps becomes 1000000bps")
           + text("servo 9 is set up and joins the robot, at 1000000bps") + servo("1 ID 9")
           + servo("1 BAUD_RATE 1") + servo("1 RETURN_DELAY 2")
           + "! new 9\n" + text("error 11: ID 9 is in the robot's list; choose another ID, or ") + "@expect silence 10\nservos\n"
           + error(95, "new 8") + text(f"servo 9: {ERRORS[95]}") + servo("1 ID 9") + "servos forget\nnew 9\nservos forget\n@power off\n"
           + error(88, "new 9") + "@servos 1-18\n@wait 10\nservos forget\nscan\n" + error(40, "new 30")
           + "@expect silence 10\n",
    "backup": "@servos 1-3\nset 2 MIN_VOLTAGE 6.5V\nbackup 2\n" + text("restore 2 RETURN_DELAY 2us")
              + text("restore 2 MIN_VOLTAGE 6.5V") + text("restore 2 STATUS_RETURN_LEVEL 2")
              + "set 2 MIN_VOLTAGE 7V\nset 2 MIN_VOLTAGE 6.5V\n" + text("written")
              + "set 2 MIN_VOLTAGE 6.5V\n" + text("unchanged") + error(87, "backup 1,9")
              + text("restore 1 MIN_VOLTAGE 6V"),
    "restore": "@servos 1-3\nrestore 2 MIN_VOLTAGE 6V\n" + text("unchanged")
               + "restore 2 MIN_VOLTAGE 7V\n" + text("MIN_VOLTAGE = 6V (60) differed: written")
               + servo("2 MIN_VOLTAGE 70") + "restore 1-3 CW_ANGLE_LIMIT 30deg\n"
               + text("servo 3: CW_ANGLE_LIMIT = 0deg (0) differed: written") + servo("3 CW_ANGLE_LIMIT 102")
               + "lock 2\n" + error(21, "restore 2 MIN_VOLTAGE 6V")
               + text("MIN_VOLTAGE = 7V (70) differs: not written") + servo("2 MIN_VOLTAGE 70")
               + error(42, "restore 2 ID 5") + error(33, "restore 2 STATUS_RETURN_LEVEL 3")
               + error(2, "restore 9 MIN_VOLTAGE 6V"),
}

BAUD_LIST = ("scan\nbaud all 500000\n" + text("servo 3: at 500000bps") + text("bus at 500000bps")
             + servo("1-3 BAUD_RATE 3") + "ping 1\nlock 2\n" + error(87, "baud 1-3 1000000")
             + text("servo 2: stays at 500000bps: refused by a servo") + text("bus at 1000000bps")
             + servo("1,3 BAUD_RATE 1") + servo("2 BAUD_RATE 3") + "ping 1\nsettings bus_baud 500000\n"
             + "bus\n" + text("bus ok at 500000bps") + "ping 2\nsettings bus_baud 1\nping 3\n"
             + "baud 1,9,3 57600\n")

# Two servos that answer PING in step and differ in a measured value.
TWINS = ("servos forget\n@servos 1,2\n@supply 2 11.5\nwrite 2 ID 1\nscan\n" + text("id 1 model 1")
         + text("servo 1: finding 8: two servos seem to have this ID") + "@expect rule collision\n"
         + "servos forget\n" + error(90, "new 9") + servo("1,2 ID 1") + "@expect rule collision\n"
         + "diagnose 1\n" + text("finding 8:") + "@expect rule collision\ncounters\n"
         + text("since the reset, ") + text(" by scan and diagnose"))

# Two of one ID, of which one takes another and the other is locked.
BOTH = "lock 1\nservos forget\nwrite 2 ID 1\n" + error(52, "id 1 5") + "@expect rule collision\n"


# Lists of servos, in the profile `full`.
LISTS = ("info 1-2\n" + text("servo 1: 0x00 ") + text("servo 2: 0x1E GOAL_POSITION") + "torque 1 2 3 on\n" + text("servo 3: ok") + servo("1-3 torque on") + "set 1-3 RETURN_DELAY 20us\n"
         + text("servo 2: unchanged") + "scan\nset all MAX_TEMPERATURE 70C\n" + text("servo 1: written")
         + servo("1-3 MAX_TEMPERATURE 70") + "get 1-3 LED\n" + text("servo 2: LED = 0")
         + "move all 100 20rpm\n" + servo("1-3 GOAL_POSITION 341") + "led 1,3 on\n" + servo("1,3 LED 1")
         + servo("2 LED 0") + error(87, "torque 1 9 3 off") + text(f"servo 9: {ERRORS[2]}"[:60])
         + servo("1,3 torque off") + servo("2 torque on"))

# A line that is held low, and a servo that is unplugged: what is not known is not shown. In mode person, whose
# replies are the same but for the last lines of stop.
LINE_LOW = ("scan\ntorque 1 on\n@fault stuck low 3000\n@wait 1500\nservos\n" + text("servo 1: line held low, torque unknown") + "status\n"
            + text("servos: 3, offline 3")
            + error(9, "stop") + text("torque may still be on: switch off the supply; inhibited until 'release'")
            + "@wait 2000\nservos\n" + text("servo 1: online, torque off, inhibited: stopped")
            + "release\n@power 3 off\n@wait 2500\nservos\n" + text("servo 3: offline, torque unknown")
            + error(2, "stop") + text("torque may still be on: switch off the supply;"))

# A servo that is set not to answer, which the controller knows.
MUTE = ("scan\nread 1 STATUS_RETURN_LEVEL\nwrite 1 STATUS_RETURN_LEVEL 0\n@wait 1200\n"
        + error(10, "get 1 LED") + error(10, "set 1 MIN_VOLTAGE 7V") + "set 1 STATUS_RETURN_LEVEL 2\n"
        + "set 1 MIN_VOLTAGE 7V\n" + text("written"))

# A reply that comes too early for two enables.
EARLY = (error(13, "set 1 RETURN_DELAY 0us") + error(13, "sync RETURN_DELAY 1 1:0 2:0")
         + servo("1-3 RETURN_DELAY 10") + "status\n"
         + text("RETURN_DELAY refused: 2; lowest 1"))

# Lines, and the errors that name servo, argument, value and range, in the profile `full`.
EXPLANATIONS = {
    "move 1 400deg": "error 33: servo 1: ANGLE 400deg is out of range: 0 to 300deg",
    "set 1 MOVING_SPEED 70": "error 33: servo 1: VALUE 70 is out of range: 0 to 62rpm",
    "move 1 90 -63rpm": "error 33: servo 1: SPEED -63rpm is out of range: 0 to 62rpm",
    "set 1 STATUS_RETURN_LEVEL 3": "error 33: servo 1: VALUE 3 is out of range: 0 to 2",
    "ping 300": "error 33: ID|254 300 is out of range: 0 to 254",
    "monitor 1 every 5ms": "error 33: MS 5ms is out of range: 10 to 60000ms",
    "bus 3000000": "error 33: RATE 3000000 is out of range: 7843 to 2000000bps",
    "get 1 GOAL": f"error 34: servo 1: REG 'GOAL': {ERRORS[34]}; did you mean GOAL_POSITION?",
    "ping": f"error 31: {CAUSES[31]}; usage: ping ID|254",
}

OTHER_RATES = "; 'scan all' looks at other rates"

# The same where there is flash for longer texts (advice.h), and elsewhere.
ADVICE = {
    "factory 3": "error 50: servo 3: another servo has ID 1, nothing was written; 'id 1 NEW' first, or connect this one alone",
    "ping 77": f"error 2: servo 77: {ERRORS[2]}{OTHER_RATES}",
    "monitor 77": f"error 2: servo 77: {ERRORS[2]}{OTHER_RATES}",
    "move 1 1V": "error 39: servo 1: ANGLE 1V: wrong unit; units: deg, mdeg, raw",
    "settings repeats 1V": "error 39: VALUE 1V: wrong unit; this number has no unit",
    "move 1 x": "error 32: servo 1: ANGLE 'x': not a number; write an angle: 90, 90.5deg or 512raw",
    "get 1 temp": f"error 34: servo 1: REG 'temp': {ERRORS[34]}; did you mean MAX_TEMPERATURE or PRESENT_TEMPERATURE?",
    "get 254 LED": "error 33: ID '254': 254 means all servos; this command takes an ID from 0 to 253, or 'all': each in turn",
}
WITHOUT_ADVICE = {
    "factory 3": f"error 50: servo 3: {ERRORS[50]}",
    "ping 77": f"error 2: servo 77: {ERRORS[2]}",
    "monitor 77": f"error 2: servo 77: {ERRORS[2]}",
    "move 1 1V": f"error 39: servo 1: ANGLE 1V: {ERRORS[39]}",
    "settings repeats 1V": "error 39: VALUE 1V: not a unit of this setting; 'settings' shows its unit",
    "move 1 x": f"error 32: servo 1: ANGLE 'x': {ERRORS[32]}",
    "get 1 temp": f"error 34: servo 1: REG 'temp': {ERRORS[34]}",
    "get 254 LED": "error 33: ID 254 is out of range: 0 to 253",
}

# What the profile `console` leaves out.
OMITTED = error(55, "diagnose") + error(55, "diagnose 1")
LEFT_OUT = {"diagnose": OMITTED}


def script_of(board):
    """All commands; those that the profile of the board leaves out end with an error."""
    if boards.BOARDS[board].profile == "full":
        return "".join(SCRIPT.values())
    script = "".join(LEFT_OUT.get(name, lines.replace(error(43, "diagnose"), OMITTED))
                     for name, lines in SCRIPT.items())
    return script


class Scripts(unittest.TestCase):
    def run_on(self, board, script, servos="1-3", *options):
        script = said_by(boards.BOARDS[board].profile, script)
        run = controller("echo off\n" + SLOWER + script.replace("BOARD", board), board, servos,
                         "--echo", *options)
        self.assertEqual(run.status, 0, run.output[-3000:])
        return run

    def test_every_command_on_every_board(self):
        for board in boards.CONSOLES:
            with self.subTest(board):
                self.run_on(board, script_of(board))

    def test_every_row_of_the_table_has_a_test(self):
        in_console = set(commands_of("console"))
        self.assertEqual(set(SCRIPT), in_console - CONTROLLER,
                         "left: commands of SCRIPT of test_console_commands.py; right: of the profile console")
        self.assertEqual(set(FULL_ONLY), set(COMMANDS) - in_console - MOTION,
                         "left: commands of FULL_ONLY of test_console_commands.py; right: those only of the profile full")

    def test_every_error_is_provoked(self):
        said = "".join(SCRIPT.values()) + "".join(FULL_ONLY.values()) + LISTS + TWINS + BOTH + MUTE + EARLY + OMITTED
        provoked = {int(number) for number in re.findall(r"@expect text ERROR (\d+):", said)}
        self.assertEqual(set(ERRORS) - UNSAID - provoked - set(TYPED) - CONTROLLER_ERRORS - MOTION_ERRORS,
                         set())

    def test_what_the_wire_cannot_show_is_told(self):
        self.run_on("arduino-mega", "mode person\nid 1 5\n" + text("if two servos had ID 1, both have ID 5 now: 'diagnose 5' looks for that")
                    + "factory 254 force\n" + text("none answers to this: each servo that heard it has ID 1 now")
                    + "@expect rule collision\n")

    def test_mode_alone_tells_the_present_mode(self):
        self.run_on("arduino-mega", "! mode\n" + text("the mode is program; usage: mode program|echo|person")
                    + "mode echo\n! mode\n" + text("the mode is echo; usage"))

    def test_servos_are_listed_by_id(self):
        for board in ("atmega128", "arduino-mega"):
            run = self.run_on(board, "servos forget\ngroup 3 1 2\n@wait 1500\nservos\n" + text("servo 3: online"))
            self.assertEqual(re.findall(r"^servo (\d): online", run.output, re.M), ["1", "2", "3"], board)

    def test_servos_forget_takes_a_servo_that_is_gone_out_of_list_and_group(self):
        stays = "error 95: servo 2: it stays in the list, as it is "
        run = self.run_on("arduino-mega", "group 1 2 3\nlimits 3 60 200\n@wait 1500\n! servos forget 2\n" + text(stays + "not offline; unplug it first")
                          + "torque 2 on\n@wait 1500\n@power 2 off\n@wait 4000\n@power 2 on\n@wait 3000\n@power 2 off\n@wait 4000\n"
                          + "! servos forget 2\n" + text(stays + "inhibited; 'release 2' first")
                          + "release 2\n@power 2 on\n! servos forget 2\n" + text(stays + "not offline")
                          + "@wait 3000\n@power 2 off\n@wait 4000\nservos forget 2\n"
                          + "! servos forget 2\n" + text("error 48: ") + "servos\n" + text("servo 3: online, torque off, limits 60.117deg to 200deg")
                          + "group\n" + text("group 1 3 sync") + "! move 3 250\n" + text("error 11: "))
        self.assertNotIn("servo 2: offline", run.output)

    def test_servos_forget_takes_a_servo_that_was_just_unplugged(self):
        self.run_on("arduino-mega", "mode person\ngroup 1 2 3 9\n! ping 9\nservos forget 9\n@wait 1500\n@power 2 off\n! ping 2\nservos forget 2\ngroup\n"
                    + text("group 1 3 sync") + "bus 57600\n! servos forget 3\n"
                    + text("error 95: servo 3: it stays in the list, where its rate is 1000000bps; 'bus 1000000bps', then this line again"))

    def test_limits_without_angles_are_told_with_128_kb(self):
        self.run_on("atmega128", "scan\n! limits 2\n" + text("error 31: servo 2 has none; 'limits 2 LOW HIGH' sets some, 'info 2' shows those of its own")
                    + "limits 2 0 512raw 495raw\n! limits 2\n" + text("error 31: limits of servo 2: 0deg to 150.147deg, 30rpm; 'limits 2 LOW HIGH' changes them"))

    def test_empty_lists_of_poses_and_sequences_tell_a_person(self):
        run = self.run_on("arduino-mega", "pose list\nsequence list\nmode person\npose list\n" + text("no pose is stored; 'group ID...', then 'pose save NAME'")
                          + "sequence list\n" + text("no sequence is stored; 'sequence NAME") + "group 1\npose save up\nsequence go new up 1s\npose list\nsequence list\n")
        self.assertEqual(run.output.count("no pose is stored") + run.output.count("no sequence is stored"), 2, run.output)

    def test_servos_names_a_doubled_id_as_a_cause(self):
        run = self.run_on("arduino-mega", "@servos 1,2\ntorque 2 on\nservos forget\nwrite 2 ID 1\nservos forget\ngroup 1\n@wait 2500\nservos\n"
                          + text("servo 1: replies damaged as if two servos had this ID") + "@expect rule collision\n")
        self.assertNotIn("being checked", run.output)

    def test_raw_write_of_a_taken_id_is_refused_and_lists_no_servo(self):
        """REG WRITE of an ID is always refused."""
        for line, says in [("write 5 3 7", "error 50: servo 5: the new ID or rate is taken"),
                           ("regwrite 5 ID 7", "error 11: servo 5: not within"), ("regwrite 5 ID 5", "error 11: servo 5: not within"),
                           ("write 254 ID 7", "error 11: not within")]:
            with self.subTest(line):
                run = self.run_on("arduino-mega", f"@servos 5,7\n@echo on\nservos forget\ngroup 7\n! {line}\n" + text(says) + "servos\n")
                self.assertEqual(re.findall(r"^servo \d: .*torque unknown", run.output, re.M),
                                 ["servo 7: not asked yet, torque unknown"], run.output)

    def test_scan_all_notes_the_rate_of_an_offline_servo(self):
        self.run_on("arduino-mega", "baud 2 117647\nbus 1Mbps\nservos forget\ngroup 1 2\n@wait 4000\nservos\n"
                    + text("servo 2: offline") + "scan all\nservos\n" + text("servo 2: not at the rate of the bus but at 117647bps, torque unknown")
                    + "diagnose 2\n" + text("finding 10: ") + text("ID 2 at 117647bps: 'bus 117647bps' first") + "group 1 2 3\n! factory 2\n"
                    + text("error 50: servo 2: not at the rate of the bus: 'bus 117647bps' first") + "@expect rule collision\n")

    def test_set_refuses_limits_that_contradict_each_other(self):
        def refused(line, why):
            return f"! {line}\n" + text(f"error 33: servo 1: nothing was written: {why}")

        for board in ("atmega128", "arduino-mega"):
            self.run_on(board, refused("set 1 MIN_VOLTAGE 16.1V", "MAX_VOLTAGE is 16V, and MIN_VOLTAGE may not be above it")
                        + refused("set 1 MAX_VOLTAGE 5.9V", "MIN_VOLTAGE is 6V") + servo("1 MIN_VOLTAGE 60") + servo("1 MAX_VOLTAGE 160")
                        + "set 1 MAX_VOLTAGE 12V\nset 1 MIN_VOLTAGE 12V\nset 1 CCW_ANGLE_LIMIT 200\n"
                        + refused("set 1 CW_ANGLE_LIMIT 201", "CCW_ANGLE_LIMIT is 200deg") + "set 1 CW_ANGLE_LIMIT 100\n"
                        + refused("set 1 CCW_ANGLE_LIMIT 99", "CW_ANGLE_LIMIT is 100deg, and CCW_ANGLE_LIMIT may not be below it")
                        + "set 1 CCW_ANGLE_LIMIT 0\nset 1 CW_ANGLE_LIMIT 0\nset 1 CW_ANGLE_LIMIT 50\nset 1 CCW_ANGLE_LIMIT 300\n")

    def test_profile_console_knows_no_torque_on_a_line_held_low(self):
        self.run_on("arbotix", "torque 1 on\n@fault stuck low 3000\n@wait 1500\nservos\n" + text("servo 1: line held low, torque unknown")
                    + "status\n" + text("servos: 3, offline 3"))

    def test_servo_that_babbles_is_not_taken_for_noise(self):
        self.run_on("arduino-mega", "@fault babble random\n@wait 1000\n! ping 1\n"
                    + text("error 9: servo 1: the line is never quiet; unplug servos one by one until it is quiet") + "status\n"
                    + text("servos: 3, offline 0, as last known"))

    def test_cycle_tells_a_servo_that_was_inhibited(self):
        for board in ("arduino-mega", "atmega128"):
            with self.subTest(board):
                self.run_on(board, "group 1 2 3\nstop\ncycle every 4ms\ncycle\n" + text("12V 32C inhibited") + "release\n@wait 100\ncycle\n"
                            + text("12V 32C was inhibited: gets no goal until the next 'pose'")
                            + "pose 150 150 150\n@wait 100\ncycle off\n")

    def test_scan_in_noise_says_that_an_id_may_be_no_servo(self):
        for board in ("arduino-mega", "atmega128"):
            with self.subTest(board):
                run = self.run_on(board, "@fault noise 5000\n@wait 1500\nscan\n"
                                  + text("replies were damaged, so an ID above may be no servo: noise on the line"))
                self.assertRegex(run.output, r"id \d+: reply damaged: noise, or one ID twice\?\n")
                self.assertNotRegex(run.output, r"servo \d+: finding 6")

    def test_several_servos_that_answer_at_once_are_named(self):
        self.run_on("arduino-mega", "scan\n! ping 254\n" + text("several servos answer at the same time, so")
                    + "@expect rule collision\n")

    def test_two_of_one_id(self):
        self.run_on("atmega128", BOTH)

    def test_lists_of_servos(self):
        for board in boards.CONSOLES:
            if boards.BOARDS[board].profile == "full":
                with self.subTest(board):
                    self.run_on(board, LISTS)

    def test_servo_left_at_another_rate_is_shown_others_are_checked(self):
        self.run_on("atmega128", "scan\nbaud 1 57600\nbus 1000000\nservos\n"
                    + text("servo 1: not at the rate of the bus but at 57143bps, torque unknown") + "@power 3 off\n@wait 3000\nservos\n"
                    + text("servo 2: online, torque off") + text("servo 3: offline, torque unknown"))

    def test_torque_on_within_limits_reads_goal_and_speed(self):
        self.run_on("atmega128", "scan\nlimits 2 160 240\n" + error(11, "torque 2 on")
                    + text("servo 2: its goal is not known to be within its limits, 160.117deg to 239.883deg: 'info 2' reads it; ")
                    + "limits 2 60 240\ntorque 2 on\n" + servo("2 torque on"))

    def test_torque_on_at_speed_0_under_a_limit_names_the_way(self):
        self.run_on("atmega128", "scan\nlimits 2 0 300 20rpm\ninfo 2\n" + error(11, "torque 2 on")
                    + text("servo 2: its speed is 0, as fast as it can, and its limit is 20rpm: 'set 2 MOVING_SPEED 20rpm' first")
                    + "set 2 MOVING_SPEED 20rpm\ntorque 2 on\n" + servo("2 torque on"))

    def test_refusal_of_limits_tells_which_is_broken(self):
        angle, speed = text("servo 2: the angle is not within its limits, 60.117deg to 239.883deg"), text("servo 2: 'move' needs a SPEED above 0, up to 20rpm")
        self.run_on("atmega128", "scan\nlimits 2 60 240 20rpm\n" + error(11, "move 2 50") + angle + error(11, "move 2 241 10rpm") + angle
                    + error(11, "move 2 100") + speed + error(11, "move 2 100 40rpm") + speed + error(11, "move 2 100 0") + speed
                    + error(11, "set 2 GOAL_POSITION 50") + angle + error(11, "turn 2 30rpm") + text("servo 2: its limits are 60.117deg to "))

    def test_torque_on_of_a_servo_that_cannot_be_read_is_refused(self):
        for board in ("atmega128", "arbotix"):
            self.run_on(board, "scan\nturn 1 30rpm\ntorque 1 off\nset 1 STATUS_RETURN_LEVEL 0raw\n" + error(10, "torque 1 on")
                        + "@wait 300\n" + servo("1 torque off"))

    def test_torque_on_that_is_refused_tells_no_speed(self):
        run = self.run_on("atmega128", "scan\nturn 1 30rpm\nstop\n" + error(54, "torque 1 on"))
        self.assertNotIn("speed set to 0", run.output)

    def test_torque_on_does_not_start_an_endless_turn(self):
        for board in ("atmega128", "arbotix"):
            told = board == "atmega128"
            self.run_on(board, "scan\n@wait 1500\nturn 1 20rpm\n" + (text("torque is off: 'torque ID on', then 'turn' again") if told else "")
                        + "torque 1 on\n" + text("endless turn: speed set to 0") + servo("1 torque on") + servo("1 MOVING_SPEED 0")
                        + "@wait 300\n" + servo("1 PRESENT_SPEED 0") + "turn 1 20rpm\n@wait 300\n" + servo("1 MOVING_SPEED 330")
                        + servo("1 PRESENT_SPEED 300..340") + "torque 1 on\n" + servo("1 MOVING_SPEED 330"))

    def test_move_of_all_servos_names_those_in_endless_turn(self):
        run = self.run_on("atmega128", "scan\nturn 2 0\nmove 254 90\n" + text("servo 2: the servo is in endless turn") + "turn 3 0\nmove 254 100 20rpm\n"
                          + text("servo 3: the servo is in endless turn") + "set 2 CCW_ANGLE_LIMIT 300\nset 3 CCW_ANGLE_LIMIT 300\nmove 254 110\n")
        self.assertEqual(run.output.count("is in endless turn"), 3, run.output)

    def test_turn_names_the_way_back_to_the_old_limits(self):
        self.run_on("arduino-mega", "scan\nset 1 CW_ANGLE_LIMIT 100raw\nset 1 CCW_ANGLE_LIMIT 900raw\ntorque 1 on\nturn 1 0\n"
                    + text("'torque 1 off', then 'set 1 CCW_ANGLE_LIMIT 263.93deg', 'set 1 CW_ANGLE_LIMIT 29.326deg'")
                    + "torque 1 off\nset 1 CCW_ANGLE_LIMIT 263.93deg\nset 1 CW_ANGLE_LIMIT 29.326deg\n"
                    + servo("1 CW_ANGLE_LIMIT 100") + servo("1 CCW_ANGLE_LIMIT 900"))

    def test_limit_of_a_servo_that_turns_is_refused(self):
        for board in ("atmega128", "arbotix"):
            self.run_on(board, "scan\ntorque 1 on\nturn 1 20rpm\n" + error(47, "set 1 CCW_ANGLE_LIMIT 300") + error(47, "set 1 CW_ANGLE_LIMIT 10")
                        + servo("1 CCW_ANGLE_LIMIT 0") + "set 1 CCW_ANGLE_LIMIT 0\ntorque 1 off\nset 1 CCW_ANGLE_LIMIT 300\n"
                        + servo("1 CCW_ANGLE_LIMIT 1023") + "torque 1 on\nset 1 CCW_ANGLE_LIMIT 280\n" + servo("1 CCW_ANGLE_LIMIT 955"))

    def test_limit_0_that_begins_an_endless_turn_is_refused(self):
        told = text("error 47: servo 1: with both limits 0 it would turn at once")
        for board in ("atmega128", "arduino-mega"):
            self.run_on(board, "scan\ntorque 1 on\nmove 1 150 10rpm\n@wait 500\n! set 1 CCW_ANGLE_LIMIT 0\n" + told + "@wait 300\n" + servo("1 CCW_ANGLE_LIMIT 1023")
                        + servo("1 PRESENT_SPEED 0") + "set 1 CW_ANGLE_LIMIT 10\nset 1 CCW_ANGLE_LIMIT 0\n! set 1 CW_ANGLE_LIMIT 0\n" + told
                        + servo("1 CW_ANGLE_LIMIT 34") + "torque 1 off\nset 1 CW_ANGLE_LIMIT 0\n" + servo("1 CW_ANGLE_LIMIT 0"))

    def test_refusal_of_soft_limits_names_what_they_forbid(self):
        turn = text("error 11: servo 1: its limits are 60.117deg to 200deg: 'limits 1 0 300' first, since an endless turn")
        for board in ("atmega128", "arduino-mega"):
            self.run_on(board, "scan\nlimits 1 60 200\n! set 1 CCW_ANGLE_LIMIT 0\n" + turn + "! turn 1 20rpm\n" + turn
                        + "set 2 MOVING_SPEED 40rpm\nlimits 2 0 300 20rpm\n! torque 2 on\n"
                        + text("error 11: servo 2: its speed is not known to be within its limit, 20rpm: 'set 2 MOVING_SPEED 20rpm', then 'info 2'")
                        + "set 2 MOVING_SPEED 20rpm\ninfo 2\ntorque 2 on\n@expect servo 2 torque on\n")

    def test_usage_of_one_form_names_the_others(self):
        for line, usage in (("sequence", "sequence list"), ("play", "play NAME [at PERCENT]")):
            forms = f"; 'help {line}' has all forms of it"
            self.run_on("arduino-mega", f"! {line}\n" + text(f"error 31: {CAUSES[31]}; usage: {usage}{forms}"))
        run = self.run_on("arduino-mega", "! move 1\n")
        self.assertNotIn("has all forms", run.output)

    def test_stop_with_more_words_stops(self):
        for board in ("arbotix", "atmega128"):
            self.run_on(board, "scan\ntorque 1 on\nstop 1\n@expect servo 1 torque off\n" + error(54, "torque 1 on")
                        + "release\ntorque 1 on\nstop now please\n@expect servo 1 torque off\n")

    def test_servos_tells_no_torque_that_was_not_read(self):
        for board in ("atmega128", "arduino-mega"):
            run = controller("torque 1 on\nset 1 RETURN_DELAY 20us\nservos\n" + text("servo 1: online, torque unknown")
                             + "scan\n@wait 1500\nservos\n" + text("servo 1: online, torque on"), board, "1-3")
            self.assertEqual(run.status, 0, run.output[-2000:])

    def test_absent_servo_does_not_make_the_line_unquiet(self):
        looks = "".join(f"servos\n@wait {ms}\n" for ms in range(37, 157, 3))
        run = self.run_on("atmega128", "scan\ngroup 1 9\n" + looks)
        self.assertEqual(run.output.count("servo 1: online, torque off\n"), 40, run.output[-2000:])

    def test_limits_without_a_speed_are_shown_without_one(self):
        run = self.run_on("atmega128", "scan\n@wait 1500\nlimits 2 60 240\nservos\n")
        self.assertIn("servo 2: online, torque off, limits 60.117deg to 239.883deg\n", run.output)

    def test_help_of_a_heading_lists_the_commands_below_it(self):
        for board in ("atmega128", "arduino-mega"):
            run = self.run_on(board, "help safety\n" + text("Safety:") + text("  limits ID") + text("  servos [forget") + "! help safe\n")
            self.assertNotIn("Set-up of servos", run.output)

    def test_help_of_a_person_names_each_command_on_a_screen(self):
        run = self.run_on("arduino-mega", "mode person\nhelp\n" + text("'help all' shows how each is written"))
        listed = run.output.partition("\nThe console:")[2].partition("\nok\n")[0].splitlines()
        self.assertLessEqual(len(listed), 22, listed)
        self.assertLessEqual(max(map(len, listed)), 79, listed)
        self.assertIn("Motion: teach pose sequence play pause resume motion", listed)
        self.assertLessEqual(set(COMMANDS), {word for line in listed for word in line.partition(":")[2].split()} | set(listed[0].split()))

    def test_list_of_usages_of_a_person_fits_40_rows(self):
        for board, line, has_room in (("atmega128", "help", False), ("arduino-mega", "help all", True)):
            run = self.run_on(board, f"mode person\n{line}\n")
            listed = run.output.partition("\nThe console:\n")[2].partition("\nok\n")[0].splitlines()
            self.assertLessEqual(len(listed), 38, listed)
            self.assertLessEqual(max(map(len, listed)), 79, listed)
            usages = {usage for line in listed if line.startswith("  ") for usage in line.strip().split("; ")}
            for name, rows in commands_of("full", has_room).items():
                for heading, usage, *_ in rows:
                    if has_room or not (name in ONLY_NAMED or heading == "Without a PC"):
                        self.assertIn(usage, usages)

    def test_servos_tells_an_endless_turn(self):
        for board in ("atmega128", "arduino-mega"):
            self.run_on(board, "scan\ntorque 1 on\nturn 1 20\n@wait 1500\nservos\n" + text("servo 1: online, torque on, endless turn")
                        + text("servo 2: online, torque off\n"))

    def test_goal_beyond_soft_limits_is_named_by_an_angle_limit(self):
        for board in ("atmega128", "arduino-mega"):
            self.run_on(board, "scan\nturn 1 20\nlimits 1 60 240\n! set 1 CCW_ANGLE_LIMIT 300\n"
                        + text("it would leave the endless turn for its goal, not read yet or beyond its limits")
                        + "set 1 GOAL_POSITION 100\nget 1 GOAL_POSITION\nset 1 CCW_ANGLE_LIMIT 300\n" + servo("1 CCW_ANGLE_LIMIT 1023"))

    def test_factory_of_all_leaves_no_result_of_a_stop(self):
        for board in ("atmega128", "arduino-mega", "atmega1284p"):
            self.run_on(board, "scan\nstop\nrelease\nfactory 254 force\nstatus\n" + text("last stop: none") + "@expect rule collision\n")

    def test_settings_and_status_have_units(self):
        for board in ("atmega128", "arduino-mega", "cm510"):
            bps = 57600 if board == "cm510" else 115200
            self.run_on(board, "settings host_baud\n" + text(f"host_baud = 255 register, {bps}bps, the board's own")
                        + "status\n" + text("lowest 1 (2us)"))

    def test_help_leaves_out_what_other_boards_have(self):
        run = self.run_on("atmega128", "help\n" + text("5 commands are not in this firmware; other boards have them (docs/console.md)"))
        self.assertNotIn("  play ", run.output)

    def test_new_id_in_a_full_list_has_a_remedy(self):
        for board in ("atmega128", "arduino-mega"):
            self.run_on(board, "scan\n! id 18 200\n" + text("the list of servos is full: 'servos forget', then this line again")
                        + "servos forget\nid 18 200\n" + text("ID 200 at 1000000bps"), "1-18")

    def test_too_many_servos_names_the_limit_of_the_robot(self):
        self.run_on("arduino-mega", "scan\n! group 1 99\n" + text("too many servos; the robot has at most 18: 'servos forget'"), "1-18")

    def test_name_of_a_sequence_names_play(self):
        run = self.run_on("arduino-mega", "scan\ngroup 1 2\npose set rest 90 90\nsequence wave new rest 1s\n@wait 300\n! wave\n"
                          + text("'wave': a sequence: 'play NAME', 'play NAME times 2', 'play NAME loop'"))
        self.assertNotIn("did you mean", run.output)

    def test_deleted_pose_names_a_sequence_that_had_it(self):
        run = self.run_on("arduino-mega", "scan\ngroup 1 2\npose set rest 90 90\npose set far 99 99\npose set idle 95 95\n"
                          "sequence nod new rest 1s\nsequence wave new rest 1s\nsequence wave add far 1s\npose delete idle\n"
                          "pose delete far\n" + text("sequence wave has this pose and plays no more: "))
        self.assertEqual(run.output.count("has this pose"), 1)

    def test_deleted_pose_names_each_sequence_that_had_it(self):
        run = self.run_on("arduino-mega", "scan\ngroup 1 2\npose set rest 90 90\nsequence nod new rest 1s\nsequence wave new rest 1s\n"
                          "sequence sway new rest 1s\nsettings autostart wave\npose delete rest\n@wait 300\n")
        self.assertEqual(sorted(re.findall(r"sequence (\w+) has this pose", run.output)), ["nod", "sway"])
        self.assertIn("autostart", run.output[run.output.index("pose delete rest"):])

    def test_rate_of_a_list_names_save(self):
        run = self.run_on("arduino-mega", "mode person\nscan\nbaud all 500000\n")
        self.assertIn("bus at 500000bps: 'save' keeps it over power-off", run.output)

    def test_resume_without_a_pause_is_refused(self):
        self.run_on("arduino-mega", "scan\ntorque 1,2 on\nmove 1,2 90 0\n@wait 1000\ngroup 1 2\npose set rest 150 150\n@wait 300\n"
                    "pose rest in 3s\npause\nresume\n! resume\n" + text("error 79: the motion is not paused; 'pause' stops it"))

    def test_time_of_the_search_depends_on_repeats(self):
        for board in ("atmega128", "arduino-mega", "atmega1284p"):
            self.run_on(board, "settings repeats 1\n@power 2-3 off\nservos forget\nnew 9 within 60000\n" + text("six rates, about 9 s; a key"))

    def test_question_mark_is_help(self):
        for board in ("atmega128", "arbotix"):
            self.run_on(board, "?\n" + text("  help [COMMAND]: this list, or one command") + "? led\n" + text("led ID|254 on|off: LED on or off")
                        + error(30, "?x"))

    def test_teach_of_one_servo_names_its_error_once(self):
        run = self.run_on("atmega128", "! teach off 9\n" + text("error 2: servo 9: no reply by the deadline"))
        self.assertEqual(run.output.count("servo 9: no reply"), 1, run.output)

    def test_pose_of_servos_without_torque_is_told(self):
        run = self.run_on("atmega128", "scan\n@wait 1500\ngroup 1 2\npose 90 90\n" + text("moves once torque is on")
                          + "torque 1 2 on\npose 90 90\ngroup 1 2 action\ntorque 2 off\npose 100 100\n" + text("moves once torque is on")
                          + "pose 90 90 in 1s\n" + text("moves once torque is on") + "set 1 CW_ANGLE_LIMIT 200\ntorque 1 off\n"
                          + error(23, "move 1 100"))
        self.assertEqual(run.output.count("moves once torque is on"), 3, run.output)

    def test_commands_of_profile_full(self):
        self.run_on("arduino-mega", "".join(FULL_ONLY.values()))
        for script in [BAUD_LIST.replace("baud 1,9,3", "! baud 1,9,3"), TWINS]:
            self.run_on("atmega128", script)

    def test_servo_that_answers_too_early_is_told_and_mended(self):
        early = (text("0 found, 254 asked") + text("servo 1: finding 18: the servo answers before")
                 + text("servo 1 answers too early: 'write 1 RETURN_DELAY 1', then"))
        for script in ("scan\n" + early + error(2, "write 1 RETURN_DELAY 1") + "scan\n"
                       + text("1 found, 254 asked"),
                       "new 6\n" + text("a servo answers too early")
                       + text("servo 6 is set up") + servo("1 RETURN_DELAY 2") + "ping 6\n"):
            with tempfile.TemporaryDirectory() as folder:
                run = controller("write 1 RETURN_DELAY 0\n", "arbotix", "1", "--state", folder)
                self.assertEqual(run.status, 0, run.output)
                run = controller("echo off\n" + said_by("full", script), "atmega128", "1", "--state", folder,
                                 "--rules", "warn")
                self.assertEqual(run.status, 0, run.output[-3000:])

    def test_reset_of_all_servos_empties_the_list(self):
        self.run_on("atmega128", "scan\nservos\n" + text("servo 3: ") + "@servos 7\nfactory 254 force\n" + servo("7 ID 1")
                    + "servos\n" + text("the list is empty"))

    def test_line_low_and_servo_offline_are_told(self):
        self.run_on("atmega128", LINE_LOW)

    def test_command_beside_goals_ends_while_the_line_is_held_low(self):
        """The goals come more often than a wait for a quiet line may last."""
        self.run_on("atmega128", "scan\ntorque all on\ngroup 1 2 3\ncycle every 2ms\n@wait 100\n@fault stuck low 2000\n"
                    + error(9, "torque 1 off") + error(9, "set 1 LED 1") + "@wait 2500\n@expect servo 1 torque on\n"
                    + "set 1 LED 1\ncycle off\n")

    def test_new_servo_near_a_listed_rate_gets_the_rate_of_the_bus(self):
        script = ("bus 19417\nnew 1\nservos forget\nnew 1\n" + text("one ID answers: ID 1 at 19231bps") + text("step 4 of 4: the rate is 19417bps already")
                  + text("servo 1 is set up and joins the robot, at 19417bps") + error(95, "new 2"))
        run = controller("echo off\n" + said_by("full", script), "atmega128", "1", "--rules", "warn")
        self.assertEqual(run.status, 0, run.output[-3000:])

    def test_new_servo_is_found_at_unlisted_rates(self):
        """36 and 99 to 107 are near listed rates, where the servo is found but may not be understood."""
        for rate in (0, 36, *range(99, 108, 1 if LONG else 4), 150):
            with self.subTest(rate=rate):
                script = f"write 1 BAUD_RATE {rate}\nservos forget\n" + "new 2\n"
                script += servo("1 ID 2") + servo("1 BAUD_RATE 1") + "ping 2\n"
                run = controller("echo off\n" + said_by("full", script), "atmega128", "1", "--rules", "warn")
                self.assertEqual(run.status, 0, run.output[-3000:])

    def test_new_servos_of_one_id_are_set_up_one_after_the_other(self):
        script = "@power 1 off\n" + "".join(f"@power {place} on\n@wait 1000\nnew {new}\n@power {place} off\n"
                                            for place, new in (("1st", 2), ("2nd", 3), ("3rd", 1)))
        script += "@power 1 on\n@wait 1500\nscan\n" + text("3 found")
        run = controller("echo off\n" + said_by("full", script), "atmega128", "1,1,1", "--allow-duplicates")
        self.assertEqual(run.status, 0, run.output[-3000:])

    def test_new_servo_that_fails_does_not_join(self):
        refused = "! new 5\n" + text(f"error 21: servo 1: {ERRORS[21].removeprefix('servo: ')}")
        script = "lock 1\nservos forget\n" + refused + "servos\n" + text("the list is empty") + refused
        run = controller("echo off\nwrite 1 RETURN_DELAY 10\n" + said_by("full", script), "atmega128", "1")
        self.assertEqual(run.status, 0, run.output[-3000:])

    def test_a_servo_that_does_not_answer(self):
        self.run_on("atmega128", MUTE)

    def test_delay_that_the_board_cannot_bear_is_refused(self):
        run = self.run_on("atmega128", EARLY)
        self.assertNotIn("03 05 00 ", run.output)


# Commands of the group "The controller" in every profile, and their errors: test_commands_controller.c, test_failsafe.py.
CONTROLLER = {name for name, lines in commands_of("console").items() if lines[0][0] == "The controller"}
# The group "Motion", which only the profile `full` has: test_motion_commands.py, test_motion_play.py.
MOTION = {name for name, lines in COMMANDS.items() if lines[0][0] == "Motion"}
CONTROLLER_ERRORS = {number for number in ERRORS if 60 <= number < 70}

# Errors of motions: test_timed_pose.py, test_motion_commands.py, test_motion_play.py.
MOTION_ERRORS = {number for number in ERRORS
                 if number == 14 or 56 <= number <= 58 or 70 <= number <= 86 or 91 <= number <= 94}

# Errors that only typing provokes.
TYPED = {35, 36, 49, 54}
ONLY_NAMED = {"play", "pause", "resume", "motion"}  # where the firmware has no motions
PACKETS = {"ping", "read", "write", "regwrite", "action", "reset", "sync"}  # the line itself is a packet


CYCLES_PER_MS = 16000


class Terminal:
    """The firmware's console at a pty, in real time. When it is closed, `packets` are those that were
    on the wire, and `sent_at` has the CPU cycle at which each instruction packet began. Without
    mode="program" the console is in the mode of a new controller."""

    def __init__(self, board, servos="1-3", *options, mode="program"):
        self.profile = boards.BOARDS[board].profile
        self.has_room = boards.BOARDS[board].mcu in boards.LARGE
        self.has_advice = board in boards.WITH_ADVICE and self.profile == "full"
        self.has_motion = board in boards.WITH_MOTION and self.profile == "full"
        self.folder = tempfile.TemporaryDirectory()
        self.transcript = os.path.join(self.folder.name, "transcript.txt")
        self.process = subprocess.Popen(
            [SIM, "firmware", ROOT / f"build/{board}/controller.elf", "--board", board, "--servos",
             servos, "--host", "pty", "--transcript", self.transcript, *options],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        self.path = self.process.stdout.readline().decode().strip()
        self.file = os.open(self.path, os.O_RDWR | os.O_NOCTTY)
        self.unread = ""  # text behind what the latest hear() returned
        tty.setraw(self.file)
        if mode == "program":
            self.ask("mode program")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        if self.process.poll() is None:
            os.close(self.file)
            self.process.send_signal(signal.SIGINT)
        self.output = self.process.stdout.read().decode()
        self.process.stdout.close()
        self.process.wait(PATIENCE_S)
        with open(self.transcript) as file:
            text = file.read()
        self.packets = re.findall(r"(?:->in|<-out): ([0-9A-F ]+) \(LEN", text)
        self.sent_at = [int(cycle) for cycle in re.findall(r"^ *(\d+) ->in", text, re.M)]
        self.folder.cleanup()

    def type(self, keys):
        os.write(self.file, keys.encode("latin-1"))

    def hear(self, until=r"^(ok|error \d+: [^\r]*)\r\n", timeout=PATIENCE_S):
        """What is said up to and with what matches."""
        end = time.monotonic() + timeout
        while not (match := re.search(until, self.unread, re.M)):
            rest = end - time.monotonic()
            if rest <= 0 or not select.select([self.file], [], [], rest)[0]:
                raise AssertionError(f"no {until!r} in {self.unread!r}")
            self.unread += os.read(self.file, 1000).decode("latin-1")
        said, self.unread = self.unread[:match.end()], self.unread[match.end():]
        return said

    def silence(self):
        """What is said until nothing is for 0.15 s of the simulator."""
        said, self.unread = self.unread, ""
        while True:
            settle(self.process, 0.15)
            if not select.select([self.file], [], [], 0)[0]:
                return said
            said += os.read(self.file, 1000).decode("latin-1")

    def ask(self, line):
        self.type(line + "\r")
        return self.hear()


# Arguments in capitals that are no number.
ARGUMENTS = set(re.findall(r'{FLASH_TEXT\("(\S+)"\), ARGUMENT_', (ROOT / "src/controller/console/parse.c").read_text()))


def list_line(name, usage):
    """What help says of lists, in a profile that has them."""
    if name == "limits":  # a line begins with the first row
        usage = "limits ID LOW HIGH [SPEED]"
    behind_id = re.search(r"ID(?:\|254)? \[*([A-Z][^\] ]*)", usage)
    if "ID" not in re.sub("ID:", "", usage):
        return ""
    if name in PACKETS:
        return "ID: one servo, no list\r\n"
    if behind_id and behind_id[1] not in ARGUMENTS:  # `move 1 2 30` moves servo 1 to 2deg
        return "ID: one servo, or a list in one word: 1,2,5-8, or all\r\n"
    return "ID: one servo, or a list: 1 2 5-8, or 1,5-8, or all\r\n"


class Typed(unittest.TestCase):
    def each_board(self, check):
        for board in boards.CONSOLES:
            with self.subTest(board), Terminal(board) as terminal:
                terminal.ask("echo off")
                for n in (1, 2, 3):
                    terminal.ask(f"write {n} RETURN_DELAY 10")
                check(terminal)

    def test_the_help_of_every_command(self):
        def check(terminal):
            listed = terminal.ask("help")
            brief = terminal.profile == "console"  # this profile leaves details to docs/console.md
            commands = commands_of(terminal.profile, terminal.has_room)
            for name in COMMANDS:
                help_of = ""
                for heading, usage, what, details, example in commands.get(name, []):
                    if not brief and not terminal.has_motion and (name in ONLY_NAMED or heading == "Without a PC"):
                        self.assertNotIn(f"\r\n  {usage}: ", listed)
                        help_of += f"{usage}: {ERRORS[55]}\r\n"
                        continue
                    self.assertIn(f"\r\n  {usage}: {what}\r\n", listed)
                    help_of += f"{usage}: {what}\r\n"
                    help_of += "" if brief else f"{details}\r\n{list_line(name, usage)}"
                    help_of += f"Example: {example}\r\n" if example and not brief else ""
                heading_of = {"motion": "Motion:", "bus": "The bus:"}.get(name)
                if help_of and heading_of and terminal.has_advice:  # its heading follows
                    self.assertTrue(terminal.ask(f"help {name}").startswith(f"{help_of}{heading_of}\r\n"))
                elif help_of:
                    self.assertEqual(terminal.ask(f"help {name}"), f"{help_of}ok\r\n")
                else:
                    self.assertRegex(terminal.ask(f"help {name}"), f"^error 30: .*{CAUSES[30]}")
        self.each_board(check)

    def test_every_error_says_cause_and_remedy_if_profile_has_it(self):
        lines = [("frob", 30), ("ping", 31), ("ping x", 32), ("ping 999", 33), ("get 1 X", 34),
                 ("sync LED 1 1", 37), ("led 1 x", 38), ("move 1 1V", 39), ("monitor 1 1", 41),
                 ("set 1 MODEL_NUMBER 1", 42), ("cycle", 44), ("group", 45), ("release 9", 48),
                 ("id 1 2", 50), ("factory 254", 53), ("ping 77", 2),
                 ("write 1 MODEL_NUMBER 1", 21), ("action 1", 20)]

        def check(terminal):
            errors = errors_of(terminal.profile)
            for line, number in lines:
                said = terminal.ask(line)
                if terminal.profile == "console":
                    self.assertEqual(said, f"error {number}: {errors[number]}\r\n")
                self.assertTrue(said.startswith(error_line(number, line, terminal.profile)), said)
                remedied = errors[number].replace("COMMAND", line.split()[0] if terminal.has_room else "COMMAND")
                if number not in (31, 33) and not (terminal.has_advice and number in (2, 32, 39, 42)):
                    self.assertTrue(said.endswith(f"{remedied}\r\n".removeprefix("servo: ")), said)
            if terminal.profile == "full":
                for line, said in (EXPLANATIONS | (ADVICE if terminal.has_advice else WITHOUT_ADVICE)).items():
                    self.assertEqual(terminal.ask(line).removeprefix("0 lines, 0 answers missing\r\n"), f"{said}\r\n")
            self.assertEqual(terminal.ask("version" + " " * 1400),
                             f"error 35: {errors[35]}\r\n")
            terminal.type("help\r" + "x" * 600)  # nobody reads while help is written
            self.assertTrue(terminal.hear().endswith("\r\nok\r\n"))
            terminal.type("\r")
            self.assertEqual(terminal.hear(), f"error 36: {errors[36]}\r\n")
            self.assertEqual(terminal.ask("ping 1"), "ok\r\n")
        self.each_board(check)

    def test_editing_history_and_echo(self):
        with Terminal("atmega128") as terminal:
            self.assertEqual(terminal.ask("echo on"), "ok\r\n")
            self.assertEqual(terminal.ask("pong\b\b\bing 1"), "pong\b \b\b \b\b \bing 1\r\nok\r\n")
            terminal.type("\x1B[A")
            self.assertEqual(terminal.silence(), "ping 1")
            terminal.type("\x7F2\r")
            self.assertEqual(terminal.hear(), "\b \b2\r\nok\r\n")
            terminal.type("\x10")
            self.assertEqual(terminal.silence(), "ping 2")
            terminal.type("\x03")
            self.assertEqual(terminal.silence(), "\r\n")
            self.assertEqual(terminal.ask("echo off"), "echo off\r\nok\r\n")
            self.assertEqual(terminal.ask("ping 3"), "ok\r\n")
            terminal.type("\x10\n")
            self.assertEqual(terminal.hear(), "ok\r\n")
            self.assertEqual(terminal.ask("echo on"), "ok\r\n")
            self.assertEqual(terminal.ask("ping 1"), "ping 1\r\nok\r\n")
        pings = [packet(n, PING).hex(" ").upper() for n in (1, 2, 3, 3, 1)]
        self.assertEqual(terminal.packets[0::2], pings)

    def test_monitor_draws_until_a_key(self):
        def check(terminal):
            terminal.type("monitor 1 2 every 50ms\r\n")
            said = terminal.hear(r"(1deg.*\r\n){5}")
            for line in said.split("\r\n")[:5]:
                self.assertRegex(line, r"^1deg:150\.147,1rpm:0,1%:0,1V:12,1C:32,"
                                       r"2deg:150\.147,2rpm:0,2%:0,2V:12,2C:32$")
            terminal.type("p")  # the key is the first one of the next line
            self.assertRegex(terminal.hear(), r"\d+ lines, 0 answers missing\r\nok\r\n$")
            self.assertEqual(terminal.ask("ing 1"), "ok\r\n")
        self.each_board(check)

    def test_monitor_with_echo_draws_table_in_place(self):
        row = r"servo 1: 150\.147deg 0rpm 0% 12V 32C\x1B\[K\r\nservo 9: absent\x1B\[K\r\n"
        for board in boards.CONSOLES:
            if boards.BOARDS[board].profile != "full":
                continue
            with self.subTest(board), Terminal(board) as terminal:
                for n in (1, 2, 3):
                    terminal.ask(f"write {n} RETURN_DELAY 10")
                terminal.ask("echo on")
                terminal.type("monitor 1 9 every 50ms\r")
                said = terminal.hear(r"(\x1B\[2A[^A]*){3}")
                self.assertRegex(said, rf"^monitor 1 9 every 50ms\r\n{row}(\x1B\[2A{row})+")
                terminal.type("\r")
                self.assertRegex(terminal.hear(), r"\d+ lines, \d+ answers missing\r\nok\r\n$")
                terminal.type("monitor 1 9 as plot\r")
                said = terminal.hear(r"(1deg.*\r\n){2}")
                self.assertRegex(said, r"\r\n1deg:150\.147,1rpm:0,1%:0,1V:12,1C:32,9:absent\r\n1deg")
                terminal.type("\r")
                terminal.hear()
                terminal.ask("echo off")
                terminal.type("monitor 1 every 50ms as plot\r")
                self.assertNotIn("servo", terminal.hear(r"(1deg.*\r\n){2}"))
                terminal.type("\r")
                terminal.hear()
                rates = OTHER_RATES if terminal.has_advice else ""
                self.assertIn(f"\r\nerror 2: servo 9: {ERRORS[2]}{rates}\r\n", terminal.ask("monitor 8 9"))

    def test_monitor_keeps_its_period(self):
        with Terminal("atmega128") as terminal:
            terminal.ask("echo off")
            terminal.type("monitor 1 every 100ms\r")
            terminal.hear(r"(1deg.*\r\n){12}")
            terminal.type("\r")
            terminal.hear()
        # nothing but its READs
        self.assertEqual(set(terminal.packets[0::2]),
                         {packet(1, READ, [0x24, 11]).hex(" ").upper()})
        gaps_ms = [(later - sooner) / CYCLES_PER_MS for sooner, later in zip(terminal.sent_at, terminal.sent_at[1:])]
        self.assertGreaterEqual(len(gaps_ms), 11)
        for gap_ms in gaps_ms:
            self.assertAlmostEqual(gap_ms, 100, delta=1)

    def test_scan_takes_as_long_as_the_help_says(self):
        text = next(row[3] for row in COMMANDS["scan"])
        seconds, minutes = (float(re.search(end, text)[1]) for end in [r"([\d.]+) s\.", r"(\d+) minutes"])
        # all 255 rates take the mean of the first and the last, since the time of a bit is linear in the register
        slowest_ms = int(2 * minutes * 60_000 / 255) - 280
        run = controller(f"scan all within {int(1000 * seconds) + 50}\nsettings bus_baud 254\nscan within {slowest_ms}\n", "arduino-mega")
        self.assertEqual(run.status, 0, run.output)

    def test_a_key_ends_scan_and_diagnose(self):
        def check(terminal):
            for line in ["scan all", "scan rescue"] + ["diagnose 77"] * (terminal.profile == "full"):
                terminal.type(line + "\r")
                if line != "diagnose 77":
                    self.assertIn("now at", terminal.hear(r"now at \d+bps\r\n"))
                terminal.type("\r")
                said = terminal.hear()
                self.assertIn(f"error 49: {errors_of(terminal.profile)[49]}\r\n", said, line)
                self.assertIn("at 1000000bps", terminal.ask("bus"))
                self.assertEqual(terminal.ask("ping 2"), "ok\r\n")
        self.each_board(check)


class Names(unittest.TestCase):
    def test_no_pose_or_sequence_of_ours_has_the_name_of_a_command(self):
        """Else make demo, make docs or a test ends with error 73, much later."""
        words = {word for rows in COMMANDS.values() for row in rows for word in re.findall(r"[a-z]+", row[1])}
        words -= {"move", "dwell", "on", "in", "stop", "help"}  # tests give these to be refused
        files = [path for folder in ("docs", "examples", "scripts", "test", "panel/test", "panel/src", "arduino")
                 for path in (ROOT / folder).rglob("*") if path.suffix in (".md", ".script", ".py", ".sh", ".c", ".js")]
        for path in [ROOT / "README.md", *files]:
            names = re.findall(r"\b(?:pose (?:save|set)|sequence(?= \w+ (?:new|add))|(?:new|add)(?= \w+ [\d.]+m?s)) (\w+)",
                               path.read_text(), re.I)
            names = {name.lower() for name in names if not name.isupper()}  # NAME and POSE stand for a name
            self.assertEqual(words & names, set(),
                             f"{path}: a command takes the name of a pose or sequence: give the command another name")


class Stop(unittest.TestCase):
    OFF = packet(BROADCAST, WRITE, [0x18, 0]).hex(" ").upper()

    def prepare(self, terminal):
        terminal.ask("echo off")
        for n in (1, 2, 3):
            terminal.ask(f"write {n} RETURN_DELAY 10")
        terminal.ask("scan")
        self.assertEqual(terminal.ask("torque 254 on"), "ok\r\n")

    def check_stopped(self, terminal):
        self.assertIn("error 54", terminal.ask("torque 1 on"))
        said = terminal.ask("servos")
        for n in (1, 2, 3):
            self.assertIn(f"servo {n}: online, torque off, inhibited: stopped\r\n", said)
        for n in (1, 2, 3):
            self.assertIn("TORQUE_ENABLE = 0", terminal.ask(f"get {n} TORQUE_ENABLE"))
        self.assertEqual(terminal.ask("release"), "ok\r\n")
        self.assertEqual(terminal.ask("torque 254 on"), "ok\r\n")

    def test_ctrl_x_anywhere(self):
        for board in boards.CONSOLES:
            with self.subTest(board), Terminal(board) as terminal:
                self.prepare(terminal)
                terminal.type("\x18")  # on an empty line
                self.assertEqual(terminal.hear(), "ok\r\n")
                self.check_stopped(terminal)
                terminal.type("torque 1 o\x18")  # in a line, which is dropped
                self.assertEqual(terminal.hear(), "ok\r\n")
                self.check_stopped(terminal)
                for line, begun in [("monitor 1 every 20ms", "1deg"), ("help", "move"),
                                    ("scan all", "now at 1000000bps"),
                                    ("scan rescue", "now at 500000bps")]:
                    terminal.type(line + "\r")
                    terminal.hear(begun)
                    terminal.type("\x18")
                    self.assertIn(f"\r\nerror 54: {errors_of(terminal.profile)[54]}\r\n", terminal.hear(), line)
                    self.assertEqual(terminal.hear(), "ok\r\n", line)
                    self.check_stopped(terminal)
                terminal.ask("group 1 2 3")
                terminal.ask("cycle every 10ms")
                terminal.type("\x18")
                self.assertEqual(terminal.hear(), "ok\r\n")
                self.check_stopped(terminal)
                self.assertIn("error 44", terminal.ask("cycle"))

    def test_ctrl_x_drops_what_was_typed_before_it(self):
        with Terminal("atmega128") as terminal:
            self.prepare(terminal)
            terminal.type("help\rping 1\rping 1\r\x18")
            self.assertIn("error 54", terminal.hear())  # of help
            self.assertEqual(terminal.hear(), "ok\r\n")  # of stop
            self.check_stopped(terminal)
        self.assertEqual(terminal.packets.count(self.OFF), 3)
        self.assertEqual(terminal.packets.count(packet(1, PING).hex(" ").upper()), 1)  # of scan


if __name__ == "__main__":
    unittest.main()
