#!/usr/bin/env python3
"""docs/device.md from the register table in src/controller/host/device.h. Prints the document."""
import re

ROW = re.compile(r'X\((\w+),\s*(\w+),\s*(\d+),\s*(\w+),\s*(\d+),\s*(\d+),\s*"([^"]*)",'
                 r'\s*((?:"[^"]*"\s*)+)\)')

HEAD = """# The virtual device

The controller answers for itself under an ID of its own, 253 unless it is set otherwise, in the
manner of a servo: PING, READ, WRITE and RESET, with the errors of a servo (manual 2.3): range error
for what is out of range, read-only or no register at all, and then nothing of the WRITE is stored;
instruction error for any other instruction and for a wrong number of parameters. It does not listen
to broadcasts. With ID 254 there is no device; everything goes to the bus then. What a servo with the
device's ID says can only be read with the device elsewhere.

Words are low byte first. 0x03 to 0x0F are kept without power once SAVE was written; all others begin
anew at each reset. Counters count modulo 65536. Written by `make docs` from
`src/controller/host/device.h`.

| address | name | bytes | access | range | unit | |
|---|---|---|---|---|---|---|"""

TAIL = """
## Many servos in one packet

CDS55xx know single READ only. The device makes of it what two other controllers and Robotis have
defined (`src/controller/host/bulk_read.h`), and has the READ for the next servo ready when the answer of
the one before comes, so that the bus is hardly ever idle: `make feedback`.

- **SYNC READ 0x84**, as USB2AX and ArbotiX have it, to 254 or to the device:
  `FF FF FE LENGTH 84 ADDRESS N ID... CHECKSUM`. One status packet of the device with N bytes for each
  ID in the order asked, 252 in all. Of a servo that did not answer, or refused, they are FF, bit 7 of
  ERROR is set, and FAILED and FAILED_IDS say which it was. The device may be among the IDs.
- **BULK READ 0x92** of protocol 1.0, to 254: `FF FF FE LENGTH 92 00 (N ID ADDRESS)... CHECKSUM`. The
  status packets of the servos, in the order asked, each as the servo said it: one that refuses answers
  with its error bits and without data. A servo waits for the packet of the one before it: behind one
  that does not answer none follows. That is what the SDK's GroupBulkRead expects: it reads a packet
  for each ID in order, skips those of others, and as soon as one does not come in time its
  `rxPacket()` ends with that error and `isAvailable()` is false for all IDs; the next `txPacket()`
  begins anew and finds nothing left over. FAILED_IDS names the one to blame.
"""


def main():
    text = open("src/controller/host/device.h").read().replace("\\\n", " ")
    print(HEAD)
    rows = []
    for name, address, count, access, lowest, highest, unit, what in ROW.findall(text):
        what = "".join(re.findall(r'"([^"]*)"', what))
        access = {"RD": "read", "RW": "read, write"}[access]
        rows.append((int(address, 0), f"| {address} | `{name}` | {count} | {access} | {lowest} to "
                     f"{highest} | {unit} | {what} |"))
    if len(rows) != text.count("    X("):
        raise SystemExit("src/controller/host/device.h: a row is not understood")
    for _, row in sorted(rows):
        print(row)
    print(TAIL, end="")


if __name__ == "__main__":
    main()
