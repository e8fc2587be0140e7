#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the pictures of the documents, docs/img/*.svg: real data from the simulator.

usage: pictures.py    needs the simulator and programs in build/: run make pictures
bus.svg: one READ on the wire, its turnaround in detail, and a wave of 18 servos. storeys.svg: who may
call whom, from the table of layering.py. curves.svg and arrival.svg: motion_pictures.py. hexapod.svg,
which moves: hexapod_picture.py. wiring-*.svg: wiring.py.
"""
import collections
import csv
import pathlib
import subprocess
import sys
import tempfile

import hexapod_picture
import layering
import motion_pictures
import wave
import wiring
from drawing import BLUE, DARK, GREEN, GREY, ORANGE, PALE, VIOLET, Drawing, simplified, stairs

ROOT = pathlib.Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs/img"
CYCLES_PER_US = 16
VCD_UNITS_PER_US = 10000  # its timescale is 100 ps


def simulate(script, *options):
    """Runs the firmware with a scenario; returns the lines of its transcript."""
    with tempfile.TemporaryDirectory() as folder:
        scenario, transcript = pathlib.Path(folder) / "script", pathlib.Path(folder) / "transcript"
        scenario.write_text(script)
        subprocess.run([ROOT / "build/host/cds55xx-sim", "firmware",
                        ROOT / "build/atmega128/controller.elf", "--board", "atmega128", "--script",
                        scenario, "--transcript", transcript, *options],
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
        return transcript.read_text().splitlines()


# ---- one transaction --------------------------------------------------------------------------------

def vcd_signals(path):
    """{name: [(us, value), ...]} of a waveform file."""
    names, signals, now = {}, collections.defaultdict(list), 0.0
    for line in path.read_text().splitlines():
        words = line.split()
        if line.startswith("$var"):
            names[words[3]] = words[4]
        elif line.startswith("#"):
            now = int(line[1:]) / VCD_UNITS_PER_US
        elif line.startswith("b"):
            signals[names[words[1]]].append((now, int(words[0][1:], 2)))
        elif line[:1] in ("0", "1"):
            signals[names[line[1:]]].append((now, int(line[0])))
    return signals


def spans(changes):
    """[(start, end)] of the times at which a signal is not 0."""
    found, start = [], None
    for now, value in changes:
        if start is not None:
            found.append((start, now))
        start = now if value else None
    return found


class Axis:
    """Microseconds `first` to `last` over the pixels from `left` on."""

    def __init__(self, first, last, left, width):
        self.first, self.last, self.left, self.scale = first, last, left, width / (last - first)

    def x(self, us):
        return self.left + (min(max(us, self.first), self.last) - self.first) * self.scale

    def level(self, drawing, changes, top, height, colour):
        """A signal of two levels, as a line."""
        value, points = 1, []
        for now, then in [*changes, (self.last, None)]:
            if now > self.first or then is None:
                y = top + (0 if value else height)
                if not points:
                    points.append((self.left, y))
                points.append((self.x(now), y))
                if then is None or now >= self.last:
                    break
                points.append((self.x(now), top + (0 if then else height)))
            value = then
        drawing.path(points, colour, 1.2)

    def bars(self, drawing, found, top, height, colour):
        for start, end in found:
            if end > self.first and start < self.last:
                x = self.x(start)
                drawing.box(x, top, max(self.x(end) - x, 0.8), height, colour)


LANES = [("wire", "bus0_wire", DARK), ("TX enable", "bus0_tx_enable", BLUE),
         ("RX enable", "bus0_rx_enable", GREEN)]


def draw_lanes(drawing, axis, signals, top):
    for row, (name, signal, colour) in enumerate(LANES):
        y = top + 30 * row
        drawing.text(axis.left - 8, y + 13, name, "end")
        axis.level(drawing, signals[signal], y, 18, colour)
    y = top + 30 * len(LANES)
    drawing.text(axis.left - 8, y + 13, "bus handlers", "end")
    drawing.path([(axis.left, y + 18), (axis.x(axis.last), y + 18)], PALE)
    bus_vectors = (30, 31, 32)  # USART1 of an ATmega128: receive, data register empty, transmit complete
    handlers = [(now, value in bus_vectors) for now, value in signals["cpu_handler_vector"]]
    axis.bars(drawing, spans(handlers), y, 18, VIOLET)


def draw_bytes(drawing, axis, line, start, top, colour):
    """The bytes of a packet over its frames; `line` is that of the transcript."""
    for n, byte in enumerate(line.split(":", 1)[1].split("(")[0].split()):
        x, width = axis.x(start + 10 * n), 10 * axis.scale
        drawing.box(x + 0.5, top, width - 1, 17, colour)
        drawing.text(x + width / 2, top + 13, byte, "middle", "#ffffff", 11)


def mark(drawing, axis, us, top, bottom, dash="3 2"):
    drawing.path([(axis.x(us), top), (axis.x(us), bottom)], GREY, 1, dash)


def draw_transaction(drawing, top):
    with tempfile.TemporaryDirectory() as folder:
        vcd = pathlib.Path(folder) / "vcd"
        packet, reply = simulate("@servos 1\nread 1 PRESENT_POSITION\n@wait 1\n", "--vcd", vcd)
        signals = vcd_signals(vcd)
    sent, heard = (int(line.split()[0]) / CYCLES_PER_US for line in (packet, reply))
    last = spans(signals["bus0_controller_talks"])[-1][1]  # end of the last stop bit
    driver_off = next(now for now, value in signals["bus0_tx_enable"] if now > sent and not value)
    listens = next(now for now, value in signals["bus0_rx_enable"] if now > sent and value)
    signals = {name: [(now - last, value) for now, value in changes]
               for name, changes in signals.items()}
    sent, heard, driver_off, listens = sent - last, heard - last, driver_off - last, listens - last

    drawing.text(20, top, "One READ at 1 Mbps: 8 bytes out, 8 bytes back", weight="bold", size=14)
    axis = Axis(sent - 4, heard + 84, 110, 800)
    draw_bytes(drawing, axis, packet, sent, top + 12, BLUE)
    draw_bytes(drawing, axis, reply, heard, top + 12, ORANGE)
    draw_lanes(drawing, axis, signals, top + 38)
    drawing.text(axis.x(sent), top + 170, f"instruction packet: {-sent:.0f} µs", colour=BLUE)
    drawing.text(axis.x(heard + 80), top + 170, "status packet: 80 µs", "end", ORANGE)
    drawing.path([(axis.x(-1), top + 34), (axis.x(3), top + 34), (axis.x(3), top + 152),
                  (axis.x(-1), top + 152), (axis.x(-1), top + 34)], GREY, 1, "2 2")
    drawing.text(axis.x(1), top + 170, "turnaround", "middle", GREY)

    top += 210
    drawing.text(20, top, "The turnaround in detail", weight="bold", size=14)
    axis = Axis(-1, 3, 110, 800)
    draw_lanes(drawing, axis, signals, top + 30)
    for us, text, anchor in [(0, "end of the last stop bit ", "end"),
                             (driver_off, f" driver off: {driver_off * CYCLES_PER_US:.0f} cycles, "
                                          f"receiver on: {listens * CYCLES_PER_US:.0f}", "start"),
                             (heard, f" start bit of the reply: {heard:.0f} µs", "start")]:
        mark(drawing, axis, us, top + 16, top + 145)
        drawing.text(axis.x(us) + (4 if anchor == "start" else -4), top + 22, text.strip(), anchor, GREY)
    for us in range(-1, 4):
        drawing.text(axis.x(us), top + 162, f"{us} µs", "middle", GREY, 11)


# ---- the wave ---------------------------------------------------------------------------------------

def last_block(path):
    """The columns behind the last empty line of a CSV of the simulator: those of the 18 servos."""
    with open(path) as file:
        rows = list(csv.reader(file))
    begin = max(n for n, row in enumerate(rows) if row and row[0] == "time_ms") + 1
    return [[float(cell) for cell in column] for column in zip(*rows[begin:])]


def draw_wave(drawing, top):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "csv"
        simulate(wave.script(60), "--csv", path)
        time, *columns = last_block(path)
    begin = next(n for n, goal in enumerate(columns[0]) if goal != columns[0][0])
    time, columns = time[begin:], [column[begin:] for column in columns]
    left, width, row = 110, 800, 16
    x = [left + width * (ms - time[0]) / (time[-1] - time[0]) for ms in time]
    drawing.text(20, top, "A wave through 18 servos: one SYNC WRITE sends all 18 goals", weight="bold",
                 size=14)
    for servo in range(18):
        base = top + 34 + row * servo
        drawing.text(left - 8, base, f"servo {servo + 1}", "end", size=10)
        goal, present = ([(at, base - 4 - 9 * (unit - wave.MIDDLE) / wave.SWING)
                          for at, unit in zip(x, column)] for column in columns[2 * servo:2 * servo + 2])
        drawing.path(stairs(goal), ORANGE, 0.8)
        drawing.path(simplified(present, 0.3), BLUE, 1.3)
    bottom = top + 34 + row * 18
    seconds = (time[-1] - time[0]) / 1000
    for second in range(int(seconds) + 1):
        drawing.text(left + width * second / seconds, bottom, f"{second} s", "middle", GREY, 11)
    drawing.text(left, bottom + 18, "goal position", colour=ORANGE)
    swing = 2 * wave.SWING * 300 // 1023
    drawing.text(left + 100, bottom + 18, f"present position; {swing} degrees from trough to crest",
                 colour=BLUE)


def bus():
    drawing = Drawing(930, 800)
    draw_transaction(drawing, 26)
    draw_wave(drawing, 436)
    drawing.write(IMAGES / "bus.svg")


# ---- the storeys ------------------------------------------------------------------------------------

# Above the library, and below it: what it is, and of what folder.
CONTROLLER = ("controller", "src/controller: the firmware", ["main.c", "host/", "console/", "profiles/", "robot/", "avr/"])
ROBOT_PROGRAM = ("your program", "examples/: linked with the library",
                 ["two_servos", "two_joints", "robot", "hexapod", "teach"])
PORT = ("AVR port", "include/cds55xx/avr: only this folder knows a register", ["usart", "handlers", "clock", "timer"])


def draw_storey(drawing, x, y, width, name, what, modules, colour):
    drawing.box(x, y, width, 58, colour, GREY)
    drawing.text(x + 12, y + 22, name, weight="bold", size=14)
    drawing.text(x + width - 12, y + 22, what, "end", GREY, 11)
    drawing.text(x + 12, y + 44, ", ".join(modules))


def arrow(drawing, x, y1, y2, colour=GREY):
    drawing.path([(x, y1), (x, y2)], colour, 1.4)
    tip = 6 if y2 > y1 else -6
    drawing.path([(x - 4, y2 - tip), (x, y2), (x + 4, y2 - tip)], colour, 1.4)


def storeys():
    """A row for each storey; safety and service share one, as neither knows the other."""
    drawing = Drawing(930, 640)
    left, width = 20, 890
    half = (width - 20) // 2
    drawing.text(left, 24, "Each storey calls those below it, never one above it",
                 weight="bold", size=14)
    y = 44
    draw_storey(drawing, left, y, half, *CONTROLLER, "#f3eaf7")
    draw_storey(drawing, left + half + 20, y, half, *ROBOT_PROGRAM, "#f3eaf7")
    what = {"robot": "a whole robot: goals, timed moves, gaits", "safety": "what is known of each servo; the permit",
            "service": "step machines", "servo": "one servo, many servos, the cycle",
            "bus": "one transaction, one state machine", "wire": "bytes, packets, direction of the line"}
    for row in (["robot"], ["safety", "service"], ["servo"], ["bus"], ["wire"]):
        y += 82
        span = (width - 20 * (len(row) - 1)) // len(row)
        for n, name in enumerate(row):
            x = left + n * (span + 20)
            draw_storey(drawing, x, y, span, name, what[name], layering.STOREYS[name],
                        "#fdeee0" if name == "safety" else "#e8f1f8")
        columns = [left + half / 2, left + half * 1.5 + 20]
        for x in columns if row[0] not in ("bus", "wire") else [left + width / 2]:
            arrow(drawing, x, y - 24, y)
    y += 82
    draw_storey(drawing, left, y, width, *PORT, "#e5f4ef")
    arrow(drawing, left + width / 3, y - 24, y)
    arrow(drawing, left + 2 * width / 3, y, y - 24, GREEN)
    drawing.text(left + width / 3 - 8, y - 7, "port.h", "end", GREY, 11)
    drawing.text(left + 2 * width / 3 + 8, y - 7, "link.h, ring.h: events of the interrupt handlers",
                 colour=GREEN, size=11)
    drawing.text(left, y + 82, "Upwards a storey calls only pointers that were handed down: bus->hooks (permit, "
                 "queue), bus->lock, request->on_end.", colour=GREY)
    drawing.write(IMAGES / "storeys.svg")


def main():
    sys.setrecursionlimit(10000)
    IMAGES.mkdir(exist_ok=True)
    bus()
    storeys()
    motion_pictures.curves(IMAGES / "curves.svg")
    motion_pictures.arrival(IMAGES / "arrival.svg")
    hexapod_picture.hexapod(IMAGES / "hexapod.svg")
    wiring.main(IMAGES)


if __name__ == "__main__":
    main()
