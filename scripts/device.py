#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""docs/device.md from the register table in src/controller/host/device.h. Prints the document."""
import re

ROW = re.compile(r'X\((\w+),\s*(\w+),\s*(\d+),\s*(\w+),\s*(\d+),\s*(\d+),\s*"([^"]*)",'
                 r'\s*((?:"[^"]*"\s*)+)\)')

HEAD = """# The virtual device

The controller answers under an ID of its own as if it were a servo: 253, or the value of its register ID. It knows PING,
READ, WRITE and RESET, and reports the errors of a servo (manual 2.3):

- range error: a value out of range, a read-only register, or no register. Nothing of that WRITE is stored.
- instruction error: any other instruction, or a wrong number of parameters.

The device ignores broadcasts. ID 254 switches it off; all packets then go to the bus. A servo with the ID of the device
can be reached only after the device has another ID.

Words are low byte first. SAVE keeps 0x03 to 0x0F without power; the other registers start again at each reset. Counters
count modulo 65536. `make docs` writes this page from `src/controller/host/device.h`.

| address | name | bytes | access | range | unit | |
|---|---|---|---|---|---|---|"""

TAIL = """
## Motions

Only a firmware with motions ([motion.md](motion.md)) has the registers 0x70 to 0x75 at work. In others they read 0, and
a WRITE to them is a range error. They do what the commands `play`, `pause`, `resume` and `motion off` of the console do,
with the same checks. Files: `src/controller/host/motion_registers.[ch]`.

| the PC writes | the console's command |
|---|---|
| MOTION_PLAY = N | `play NAME at MOTION_OVERRIDE%`, once; NAME stands in line N of `sequence list` |
| MOTION_PLAY = 0 | `motion off` |
| MOTION_PAUSE = 1, 0 | `pause`, `resume` |

- The number of a sequence changes when a sequence is stored or deleted. It stays over power-off.
- The answer to MOTION_PLAY comes at once. A range error: there is no such sequence; a motion is under way; the EEPROM is
  being written; driving is inhibited, or torque off is under way. Then MOTION_ERROR stays as it was.
- After an answer without error MOTION_STATE is 1 while the steps are checked and each servo is read, up to 1 s. Then it
  is 2 until the motion has ended. During a rest (dwell) MOTION_STEP is the step at whose pose the joints
  rest. If the motion is refused, MOTION_STATE is 0 and MOTION_ERROR tells why: 78, a step names
  a deleted pose; 81, a joint is not in the group; 84, torque is off; 57, a step is too fast; 11, a pose is beyond a limit; 2, a
  servo does not answer.
- The PC need not wait: a READ of the six registers from 0x70 on shows all of them at one time.
- SAVE, a RESET of the device and another value of BUS_BAUD are a range error while a motion is under way, as `save`, `defaults`
  and `settings bus_baud` are error 58.
- A motion of the autostart that is refused shows in MOTION_ERROR, too.
- One WRITE to 0x70 and 0x71 plays at this speed. MOTION_PAUSE cannot be in the same WRITE as a number to play: no motion
  is under way yet.

To play sequence 2 at half the speed, and read the state:

```
FF FF FD 05 03 70 02 32 56      WRITE 2, 50 to 0x70
FF FF FD 02 00 00               the answer
FF FF FD 04 02 70 06 86         READ of 6 bytes from 0x70
FF FF FD 08 00 02 32 00 02 01 00 C3   sequence 2, 50 %, not paused, under way, step 1, no error
```

## Many servos in one packet

A CDS55xx knows READ of one servo only. The device turns two requests for many servos into READs. It sends the READ for
the next servo as soon as the answer of the last one has come: `make feedback` shows the time. Files:
`src/controller/host/bulk_read.[ch]`.

| | SYNC READ 0x84 | BULK READ 0x92 |
|---|---|---|
| as in | USB2AX, ArbotiX | Dynamixel protocol 1.0 |
| sent to | 254 or the device | 254 |
| packet | `FF FF FE LENGTH 84 ADDRESS N ID... CHECKSUM` | `FF FF FE LENGTH 92 00 (N ID ADDRESS)... CHECKSUM` |
| answer | one status packet of the device: N bytes for each ID, in the order of the request, 252 bytes in all | the status packets of the servos, in the order of the request, as the servos sent them |
| a servo does not answer | its bytes are FF; bit 7 of ERROR is set | no packet follows for this servo and for those after it |
| a servo refuses | as above | its packet has error bits and no data |
| setting `repeats` | applies to each READ | does not apply: each READ is sent once |

FAILED and FAILED_IDS name the servos that failed. SYNC READ may include the device.

BULK READ ends at a servo that does not answer because GroupBulkRead of DynamixelSDK expects that. It reads a packet for
each ID in order and skips packets of other servos. If a packet does not come in time, `rxPacket()` ends with that error and
`isAvailable()` is false for all IDs. The next `txPacket()` starts again and finds no old bytes.
"""


def rows():
    """(name, address, bytes, access, lowest, highest, unit, what) of each register, by address."""
    text = open("src/controller/host/device.h").read().replace("\\\n", " ")
    found = [(*row[:-1], "".join(re.findall(r'"([^"]*)"', row[-1]))) for row in ROW.findall(text)]
    if len(found) != text.count("    X("):
        raise SystemExit("src/controller/host/device.h: a row is not understood")
    return sorted(found, key=lambda row: int(row[1], 0))


def main():
    print(HEAD)
    for name, address, count, access, lowest, highest, unit, what in rows():
        access = {"RD": "read", "RW": "read, write"}[access]
        print(f"| {address} | `{name}` | {count} | {access} | {lowest} to {highest} | {unit} | {what} |")
    print(TAIL, end="")


if __name__ == "__main__":
    main()
