#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws a schematic of each wiring between controller and servos, docs/img/wiring-NAME.svg.

usage: wiring.py [DIR]    DIR: in place of docs/img
"""
import pathlib
import sys

from drawing import BLUE, DARK, GREY, ORANGE, Drawing

WIDTH, HEIGHT = 640, 330
SIG_X = 380  # of the vertical part of the signal wire


class Schematic(Drawing):
    def wire(self, *points, colour=DARK):
        self.path(points, colour, 1.5)

    def dot(self, x, y):
        self.box(x - 2.5, y - 2.5, 5, 5, DARK)

    def block(self, x, y, width, height, title, *notes):
        self.box(x, y, width, height, "#f4f4f4", DARK)
        self.text(x + width / 2, y + 18, title, "middle", weight="bold")
        for n, note in enumerate(notes):
            self.text(x + width / 2, y + 34 + 14 * n, note, "middle", GREY, 11)

    def resistor(self, x, y1, y2, end, value="10 kOhm"):
        """A vertical resistor from a wire at y1 to y2, where `end` stands: 5 V or GND."""
        middle, down = (y1 + y2) / 2, 1 if y2 > y1 else -1
        self.dot(x, y1)
        self.wire((x, y1), (x, middle - down * 13))
        self.box(x - 5, middle - 13, 10, 26, "#ffffff", DARK)
        self.wire((x, middle + down * 13), (x, y2))
        self.text(x + 9, middle + 4, value, size=11)
        if end == "GND":
            self.ground(x, y2)
        else:
            self.wire((x - 7, y2), (x + 7, y2))
            self.text(x, y2 + (14 if down > 0 else -5), end, "middle", size=11)

    def ground(self, x, y):
        for n, half in enumerate([9, 6, 3]):
            self.wire((x - half, y + 3 * n), (x + half, y + 3 * n))

    def buffer(self, x, y, right):
        """A buffer whose input is left (`right`) or right; its enable comes from below."""
        tip, base = (x + 40, x) if right else (x, x + 40)
        self.wire((base, y - 18), (base, y + 18), (tip, y), (base, y - 18))

    def plug_and_supply(self, note, common):
        """The signal wire's way to the servos, the plug and the supply. `common`: whose GND is GND, too."""
        self.wire((SIG_X, 150), (480, 150), colour=BLUE)
        self.text(430, 143, "SIG", "middle", BLUE, weight="bold")
        self.block(480, 90, 140, 110, "servo plug")
        for y, name in [(150, "SIG"), (168, "VCC"), (186, "GND")]:
            self.text(490, y + 4, name)
        self.block(480, 240, 140, 70, "servo supply", "6 V to 16 V", note)
        self.wire((600, 240), (600, 220), (545, 220), (545, 168), (520, 168), colour=ORANGE)
        self.text(606, 233, "+", colour=ORANGE)
        self.wire((500, 240), (500, 220), (460, 220), (460, 186), (480, 186))
        self.text(488, 236, "-")
        self.wire((460, 220), (440, 220))
        self.ground(440, 220)
        self.text(440, 243, "GND of the", "middle", GREY, 11)
        self.text(440, 256, common, "middle", GREY, 11)

    def controller(self, pins):
        """The controller's block with its pins (y, name) at the right edge, x = 150."""
        self.block(20, 40, 130, 250, "controller", "5 V, 16 MHz")
        for y, name in pins:
            self.text(144, y + 4, name, "end")

    def join(self):
        """Outputs and inputs of the two buffers on the signal wire, and its pull-up."""
        self.wire((300, 100), (SIG_X, 100), (SIG_X, 210), (300, 210), colour=BLUE)
        self.dot(SIG_X, 150)
        self.resistor(SIG_X, 100, 40, "5 V")


def two_enables(picture):
    picture.controller([(100, "TXD"), (140, "TX enable"), (210, "RXD"), (250, "RX enable")])
    picture.text(280, 20, "two buffers of a 74HC126, enables active high", "middle", GREY, 11)
    picture.buffer(260, 100, True)
    picture.buffer(260, 210, False)
    picture.wire((150, 100), (260, 100))
    picture.wire((150, 210), (260, 210))
    picture.wire((150, 140), (280, 140), (280, 109))
    picture.wire((150, 250), (280, 250), (280, 219))
    picture.resistor(190, 140, 190, "GND")
    picture.resistor(190, 250, 300, "5 V")
    picture.join()


def one_enable(picture):
    picture.controller([(100, "TXD"), (155, "enable"), (210, "RXD")])
    picture.text(280, 20, "two buffers of a 74HC241", "middle", GREY, 11)
    picture.buffer(260, 100, True)
    picture.text(287, 145, "2OE: active high", size=11)
    picture.buffer(260, 210, False)
    picture.text(280, 245, "1OE: active low", size=11)
    picture.text(272, 229, "o", "middle", size=11)
    picture.wire((150, 100), (260, 100))
    picture.wire((150, 210), (260, 210))
    picture.wire((150, 155), (280, 155), (280, 109))
    picture.dot(242, 155)
    picture.wire((242, 155), (242, 250), (272, 250), (272, 230))
    picture.resistor(175, 155, 196, "GND")
    picture.join()


def tied(picture):
    picture.controller([(100, "TXD"), (210, "RXD")])
    picture.text(280, 20, "no buffer: TXEN of the USART drives the wire and releases it", "middle", GREY, 11)
    picture.wire((150, 100), (SIG_X, 100), (SIG_X, 210), (150, 210), colour=BLUE)
    picture.dot(SIG_X, 150)


def adapter(picture):
    picture.block(20, 90, 100, 110, "PC", "USB")
    picture.block(200, 90, 140, 110, "adapter", "USB serial port", "to one wire,", "finds the direction", "by itself")
    picture.wire((120, 145), (200, 145))
    picture.wire((340, 150), (SIG_X, 150), colour=BLUE)
    picture.text(280, 20, "UP-Debugger, USB2Dynamixel or the like: no controller", "middle", GREY, 11)


# name: function, note at the supply, what shares its GND
WIRINGS = {
    "two-enables": (two_enables, "CM-510: the board's own", "controller"),
    "one-enable": (one_enable, "not the 5 V of the board", "controller"),
    "tied": (tied, "ArbotiX: the board's own", "controller"),
    "adapter": (adapter, "not from USB", "adapter"),
}


def main(folder="docs/img"):
    for name, (draw, note, common) in WIRINGS.items():
        picture = Schematic(WIDTH, HEIGHT)
        draw(picture)
        picture.plug_and_supply(note, common)
        picture.write(pathlib.Path(folder, f"wiring-{name}.svg"))


if __name__ == "__main__":
    main(*sys.argv[1:])
