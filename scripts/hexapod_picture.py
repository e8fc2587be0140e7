#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws hexapod.svg: the robot of examples/hexapod from above, animated. Angles of its joints are the
present positions of 18 simulated servos in one step of the gait; forward kinematics gives the feet. SMIL
animates the picture, so that it moves in a README, too.

usage: hexapod_picture.py CSV SVG    CSV: of a run of at least 5 s (cds55xx-sim --csv)
"""
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

from drawing import BLUE, DARK, GREY, ORANGE, PALE, Drawing

ROOT = pathlib.Path(__file__).resolve().parents[1]
ELF = "build/arduino-mega/examples/hexapod.elf"
ROWS = 250            # of 4 ms in a step
FIRST = 4 * ROWS      # of the step that is shown: the gait runs at full swing
EVERY = 5             # rows from frame to frame
SECONDS = 2           # that the step takes in the picture

# mm: the body, the coxa, the femur, the tibia
MOUNTS = [(112, -44), (0, -58), (-112, -44), (112, 44), (0, 58), (-112, 44)]  # x forward, y left
COXA, FEMUR, TIBIA = 24, 50, 76
NAMES = ["R1", "R2", "R3", "L1", "L2", "L3"]
STANDS = 3            # mm above its lowest point: a foot stands up to there
AIR = "#9fb8cc"       # of a leg that is lifted


# ---- kinematics -------------------------------------------------------------------------------------

def leg(number, positions):
    """Points of a leg from mount to foot, (x, y, z) in mm, from the positions of its three servos."""
    side = 1 if number < 3 else -1  # the servos of the left side are mirrored
    coxa, femur, tibia = (math.radians((position - 512) * 300 / 1023) * side for position in positions)
    tibia = femur - math.pi / 2 - tibia
    x, y = MOUNTS[number]
    points = [(x, y, 0)]
    reach, z = 0, 0
    for length, angle in ((COXA, 0), (FEMUR, femur), (TIBIA, tibia)):
        reach += length * math.cos(angle)
        z += length * math.sin(angle)
        points.append((x + reach * math.sin(coxa), y - side * reach * math.cos(coxa), z))
    return points


class Step:
    """One step of the gait: .legs[frame][leg], .stands[frame][leg], and how far the robot has come."""

    def __init__(self, rows):
        rows = rows[FIRST:FIRST + ROWS]
        legs = [[leg(n, row[3 * n:3 * n + 3]) for n in range(6)] for row in rows]
        lowest = min(points[3][2] for frame in legs for points in frame)
        stands = [[points[3][2] < lowest + STANDS for points in frame] for frame in legs]
        self.stride, self.way = 0.0, []
        for n, (frame, standing) in enumerate(zip(legs, stands)):
            self.way.append(self.stride)
            # the feet that stand push the body forward
            pushed = [points[3][0] - after[3][0] for points, after, on_ground
                      in zip(frame, legs[(n + 1) % ROWS], standing) if on_ground]
            self.stride += sum(pushed) / len(pushed)
        self.legs, self.stands, self.way = legs[::EVERY], stands[::EVERY], self.way[::EVERY]
        self.frames = len(self.legs)

    def lands(self, number):
        """The frame in which a foot is put down."""
        return next(n for n in range(self.frames)
                    if self.stands[n][number] and not self.stands[n - 1][number])


def read(table):
    """Present positions of all servos, a row for each 4 ms."""
    with open(table) as file:
        return [[int(cell) for cell in row[2::2]] for row in list(csv.reader(file))[1:]]


def walk():
    with tempfile.TemporaryDirectory() as folder:
        table = pathlib.Path(folder) / "csv"
        subprocess.run([ROOT / "build/host/cds55xx-sim", "firmware", ROOT / ELF, "--board", "arduino-mega",
                        "--servos", "1-18", "--seconds", str((FIRST + ROWS) / 250 + 0.1), "--csv", table],
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
        return read(table)


# ---- the animation ----------------------------------------------------------------------------------

class Animation(Drawing):
    """A drawing of `frames` frames. A viewer that does not animate shows `frame`."""

    def __init__(self, width, height, frames, frame=0):
        super().__init__(width, height)
        self.frames, self.frame = frames, frame

    def animate(self, attribute, values, kind="animate", mode="linear", more=""):
        return (f'<{kind} attributeName="{attribute}" {more}dur="{SECONDS}s" repeatCount="indefinite" '
                f'calcMode="{mode}" values="{";".join(values)}"/>')

    def loop(self, attribute, values):
        """One value for each frame; the first one comes again at the end."""
        return self.animate(attribute, [*values, values[0]])

    def changes(self, attribute, values):
        """One value for each frame, which jumps: only the frames in which it changes."""
        times = [0] + [n for n in range(1, self.frames) if values[n] != values[n - 1]]
        if len(times) == 1:
            return ""
        more = f'keyTimes="{";".join(f"{n / self.frames:.3g}" for n in times)}" '
        return self.animate(attribute, [values[n] for n in times], mode="discrete", more=more)

    def slide(self, offsets):
        """Begins a group that slides: one offset for each frame, and where it is at the end of the loop."""
        values = [f"{x:.1f} 0" for x in offsets]
        self.lines.append(f'<g transform="translate({values[self.frame]})">' +
                          self.animate("transform", values, "animateTransform", more='type="translate" '))

    def moving_line(self, shapes, colours, width):
        """A line through the points of each frame, in its colour."""
        values = [" ".join(f"{x:.1f},{y:.1f}" for x, y in points) for points in shapes]
        self.lines.append(f'<polyline points="{values[self.frame]}" fill="none" stroke="{colours[self.frame]}" '
                          f'stroke-width="{width}" stroke-linecap="round" stroke-linejoin="round">'
                          f'{self.loop("points", values)}{self.changes("stroke", colours)}</polyline>')

    def moving_dot(self, places, radius, fills, line):
        x, y = [f"{x:.1f}" for x, _ in places], [f"{y:.1f}" for _, y in places]
        self.lines.append(f'<circle cx="{x[self.frame]}" cy="{y[self.frame]}" r="{radius}" '
                          f'fill="{fills[self.frame]}" stroke="{line}" stroke-width="2">{self.loop("cx", x)}'
                          f'{self.loop("cy", y)}{self.changes("fill", fills)}</circle>')

    def end_group(self):
        self.lines.append("</g>")


def place(point):
    """A point in mm, from above, in pixels: the robot looks to the right."""
    return 290 + 1.04 * point[0], 225 - 1.04 * point[1]


SAND, DOT, PRINT = "#f6f4ee", "#d8d2c2", "#e4dcc6"
GROUND = (10, 46, 560, 358)  # of the part from above: left, top, width, height


def draw_ground(drawing, step):
    """Dots and footprints, which stay where they are while the robot walks on."""
    left, top, width, height = GROUND
    scale = place((1, 0))[0] - place((0, 0))[0]
    stride = step.stride * scale
    drawing.lines.append(f'<clipPath id="c"><rect x="{left}" y="{top}" width="{width}" height="{height}"/>'
                         '</clipPath><g clip-path="url(#c)">')
    drawing.box(left, top, width, height, SAND)
    drawing.slide([-way * scale for way in [*step.way, step.stride]])
    for row in range(9):
        line = [f"M{left + n * stride / 2:.1f} {top + 20 + 40 * row}h0"
                for n in range(int((width + stride) / stride * 2) + 2)]
        drawing.lines.append(f'<path d="{"".join(line)}" stroke="{DOT}" stroke-width="4" '
                             'stroke-linecap="round"/>')
    for number in range(6):
        lands = step.lands(number)
        x, y = place(step.legs[lands][number][3])
        x += step.way[lands] * scale
        seen = ["visible" if n >= lands else "hidden" for n in range(step.frames)]
        drawing.lines.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="9" fill="{PRINT}" visibility="'
                             f'{seen[drawing.frame]}">{drawing.changes("visibility", seen)}</circle>')
        for ago in range(1, 5):
            drawing.lines.append(f'<circle cx="{x - ago * stride:.1f}" cy="{y:.1f}" r="9" fill="{PRINT}"/>')
    drawing.end_group()
    drawing.end_group()


def draw_robot(drawing, step):
    for number in range(6):
        shapes = [[place(point) for point in frame[number]] for frame in step.legs]
        standing = [frame[number] for frame in step.stands]
        drawing.moving_line(shapes, [BLUE if stands else AIR for stands in standing], 9)
        drawing.moving_dot([points[2] for points in shapes], 4, ["#ffffff"] * step.frames, GREY)
        drawing.moving_dot([points[3] for points in shapes], 8,
                           [ORANGE if stands else "#ffffff" for stands in standing], ORANGE)
    corners = [(150, -18), (124, -52), (0, -68), (-124, -52), (-150, -18), (-150, 18), (-124, 52), (0, 68),
               (124, 52), (150, 18)]
    outline = "L".join("{:.0f} {:.0f}".format(*place(corner)) for corner in corners)
    drawing.lines.append(f'<path d="M{outline}z" fill="#2b3a4a" stroke="#ffffff" stroke-width="2"/>')
    for number, mount in enumerate(MOUNTS):
        x, y = place(mount)
        drawing.lines.append(f'<circle cx="{x:.0f}" cy="{y:.0f}" r="9" fill="#44586c"/>')
        drawing.text(x, y + (18 if number >= 3 else -11), NAMES[number], "middle", "#ffffff", 11)
    tip, base = place((138, 0)), place((112, 13))
    drawing.lines.append(f'<path d="M{tip[0]:.0f} {tip[1]:.0f}L{base[0]:.0f} {base[1]:.0f}v'
                         f'{2 * (tip[1] - base[1]):.0f}z" fill="{ORANGE}"/>')


def draw_feet(drawing, step, left, top, width):
    """Which foot stands when: a bar for each stance, with a line that runs through."""
    drawing.text(left, top - 14, "Feet on the ground", weight="bold")
    for row, number in enumerate((3, 4, 5, 0, 1, 2)):
        y = top + 24 * row
        drawing.text(left - 8, y + 13, NAMES[number], "end", GREY, 11)
        drawing.box(left, y, width, 18, "#f1f1f1")
        standing = [frame[number] for frame in step.stands] + [False]
        begin = None
        for n, stands in enumerate(standing):
            if stands and begin is None:
                begin = n
            elif not stands and begin is not None:
                drawing.box(left + width * begin / step.frames, y, width * (n - begin) / step.frames, 18, ORANGE)
                begin = None
    return top + 24 * 6


def draw_joints(drawing, rows, left, top, width):
    """Angles of the joints of leg R1."""
    drawing.text(left, top - 14, "Joints of leg R1", weight="bold")
    drawing.box(left, top, width, 104, "none", PALE)
    drawing.path([(left, top + 62), (left + width, top + 62)], PALE)
    for servo, name, colour in ((0, "coxa", BLUE), (1, "femur", "#1b9e77"), (2, "tibia", "#7b3294")):
        points = [(left + width * n / ROWS, top + 62 - (rows[FIRST + n][servo] - 512) * 300 / 1023)
                  for n in range(0, ROWS + 1, EVERY)]
        drawing.path(points, colour, 1.6)
        drawing.text(left + servo * 60, top + 122, name, colour=colour)
    drawing.text(left - 8, top + 66, "0°", "end", GREY, 11)
    drawing.text(left - 8, top + 16, "50°", "end", GREY, 11)
    return top + 104


def draw(path, rows, frame=12):
    step = Step(rows)
    drawing = Animation(860, 430, step.frames, frame)
    drawing.text(10, 28, "examples/hexapod: 18 servos in a tripod gait, at half speed", weight="bold", size=14)
    draw_ground(drawing, step)
    draw_robot(drawing, step)
    left, width = 630, 210
    draw_feet(drawing, step, left, 80, width)
    bottom = draw_joints(drawing, rows, left, 270, width)
    drawing.slide([width * n / step.frames for n in range(step.frames + 1)])
    drawing.path([(left, 74), (left, bottom + 4)], DARK, 1.5)
    drawing.end_group()
    drawing.text(10, 422, "Filled: the foot stands. Legs, ground and footprints follow the present positions of "
                 "simulated servos.", colour=GREY, size=11)
    drawing.write(path)


def hexapod(path):
    draw(path, walk())


if __name__ == "__main__":
    draw(pathlib.Path(sys.argv[2]), read(sys.argv[1]))
