# SPDX-License-Identifier: MIT
"""Draws the curves of timed moves from runs of the simulator: curves.svg, one joint and eight moves of
test/firmware/library/curves.c; arrival.svg, 18 joints that test/firmware/library/motion.c sends to
poses at random. Both programs hold pin B0 high while a move is under way.
"""
import csv
import pathlib
import re
import subprocess
import tempfile

from drawing import BLUE, DARK, GREY, ORANGE, PALE, Drawing, simplified, stairs

ROOT = pathlib.Path(__file__).resolve().parents[1]
PERIOD_MS = 4
CYCLES_PER_MS = 16000
DEGREES = 300 / 1023  # of a step
RPM = DEGREES / 6     # of a step per second
SHADE = "#bcd3e6"     # of the ideal, under goal and present position


def run(elf, servos):
    """(goals, positions, moves, said) of a program: for each row of 4 ms those of all servos, the (first,
    last) row of each move, and what the program prints."""
    with tempfile.TemporaryDirectory() as folder:
        table, times = pathlib.Path(folder) / "csv", pathlib.Path(folder) / "times"
        done = subprocess.run([ROOT / "build/host/cds55xx-sim", "firmware", ROOT / elf, "--board", "atmega128",
                               "--servos", f"1-{servos}", "--host", "stdout", "--seconds", "60", "--csv",
                               table, "--times", times, "--stamp", "B"],
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True)
        with open(table) as file:
            rows = [[int(cell) for cell in row[1:]] for row in list(csv.reader(file))[1:]]
        pins = [int(line.split()[1]) // CYCLES_PER_MS // PERIOD_MS
                for line in times.read_text().splitlines() if line.startswith("pin")]
    return [row[0::2] for row in rows], [row[1::2] for row in rows], list(zip(pins[0::2], pins[1::2])), done.stdout


# ---- the curves in real numbers: position and speed ------------------------------------------------

def minimum_jerk(x):
    return x**3 * (10 + x * (6 * x - 15))


def braking(x):
    """Of a speed that falls from 1 to 0, in the share of the time."""
    x = min(max(x, 0), 1)
    return x - x**3 + x**4 / 2


def trapezoid(ramp):
    def way(x):
        if x > 0.5:
            return 1 - way(1 - x)
        return x * x / (2 * ramp * (1 - ramp)) if x < ramp else (x - ramp / 2) / (1 - ramp)
    return way


def move(start, goal, seconds, curve=minimum_jerk, begin_speed=0.0, end_speed=0.0, window=None):
    """The position at a time of a move, as docs/internals/motion.md tells."""
    window = window or seconds
    brakes, passes = begin_speed * window, end_speed * seconds
    distance = goal - start - brakes / 2 - passes / 2

    def at(time):
        return (start + brakes * braking(time / window) + distance * curve(time / seconds) +
                passes * (0.5 - braking(1 - time / seconds)))
    return at


def after(first, seconds, second):
    """`second` takes the place of `first` at that time."""
    return lambda time: first(time) if time <= seconds else second(time - seconds)


def speed(at, time):
    return (at(time + 1e-4) - at(time - 1e-4)) / 2e-4


def harmonic_mean(a, b):
    return 2 * a * b / (a + b)


# ---- one joint, eight moves -------------------------------------------------------------------------

START, GOAL, SECONDS = 300, 700, 1.2  # of curves.c
ACCELERATION = 1000 * 62 / 1023 / RPM  # of its trapezoid, in steps per second^2
JERK = move(START, GOAL, SECONDS)
PASS = harmonic_mean(300 / 0.6, 100 / 0.6)
TURN, WINDOW = 0.604, 0.252  # s: periods of the new target, and of braking
# Share of the time in which the trapezoid speeds up.
RAMP = (1 - (1 - 4 * (GOAL - START) / SECONDS / ACCELERATION / SECONDS)**0.5) / 2

# title, what happens, the ideal if it is known, the plan that the joint leaves, marked moments in s
MOVES = [
    ("minimum jerk", "smooth start and end", JERK, None, []),
    ("linear", "the same speed all the time", move(START, GOAL, SECONDS, lambda x: x), None, []),
    ("trapezoid", "a given acceleration", move(START, GOAL, SECONDS, trapezoid(RAMP)), None, []),
    ("by the servo", "one goal, one speed", move(START, GOAL, SECONDS, lambda x: x), None, []),
    ("through a pose", "passes 176° without a stop",
     after(move(START, 600, 0.6, end_speed=PASS), 0.6, move(600, GOAL, 0.6, begin_speed=PASS)), None, [0.6]),
    ("new target", "117° instead, after 0.6 s",
     after(JERK, TURN, move(JERK(TURN), 400, 0.6, begin_speed=speed(JERK, TURN), window=WINDOW)), JERK, [0.6]),
    ("pause, resume", "after 0.4 s and 0.8 s", None, JERK, [0.4, 0.8]),
    ("override, abort", "50 % after 0.4 s, abort after 1 s", None, JERK, [0.4, 1.0]),
]
LENGTH = 1.7          # s, of the time axis
SMOOTH = 8            # rows on each side over which the speed of a joint is measured
ONE_GOAL = "by the servo"


def end_of(number):
    """When the ideal of a move ends, in s."""
    return TURN + 0.6 if MOVES[number][0] == "new target" else SECONDS


def first_goal(goals, first, ideal):
    """The row of the first goal of a move. The pin rises up to two periods before it leaves."""
    def error(row):
        return max(abs(goals[row + n] - ideal(n * PERIOD_MS / 1000)) for n in range(100))
    return min(range(first - 1, first + 4), key=error)


class Pane:
    """A pane of width x height pixels with LENGTH seconds; y is `lowest` to `highest`."""
    WIDTH = 196

    def __init__(self, drawing, left, top, height, lowest, highest):
        self.drawing, self.left, self.top, self.height = drawing, left, top, height
        self.lowest, self.highest = lowest, highest
        drawing.box(left, top, self.WIDTH, height, "none", PALE)

    def x(self, seconds):
        return self.left + self.WIDTH * min(seconds, LENGTH) / LENGTH

    def y(self, value):
        return self.top + self.height * (self.highest - value) / (self.highest - self.lowest)

    def line(self, points, colour, width, dash="", tolerance=0.15):
        points = [(self.x(seconds), self.y(value)) for seconds, value in points if seconds <= LENGTH]
        self.drawing.path(simplified(points, tolerance), colour, width, dash)

    def level(self, value, text):
        y = self.y(value)
        self.drawing.path([(self.left, y), (self.left + self.WIDTH, y)], PALE)
        if text:
            self.drawing.text(self.left - 6, y + 4, text, "end", GREY, 11)

    def moment(self, seconds):
        x = self.x(seconds)
        self.drawing.path([(x, self.top), (x, self.top + self.height)], GREY, 0.8, "2 3")


def sampled(at, end):
    """A curve until `end` seconds, where it stays; (s, value)."""
    return [(n / 100, at(min(n / 100, end))) for n in range(int(LENGTH * 100) + 1)]


def draw_move(drawing, left, top, number, goals, positions, first):
    """One move: position above, speed below."""
    title, what, ideal, plan, moments = MOVES[number]
    end = end_of(number)
    row = first if title == ONE_GOAL else first_goal(goals, first, ideal or plan)
    rows = range(row, row + int(LENGTH * 1000) // PERIOD_MS)
    times = [(n - row) * PERIOD_MS / 1000 for n in rows]
    smooth = 2 * SMOOTH * PERIOD_MS / 1000
    drawing.text(left, top - 20, title, weight="bold")
    drawing.text(left, top - 6, what, colour=GREY, size=11)

    pane = Pane(drawing, left, top, 110, 60, 230)
    for degrees in (90, 150, 210):
        pane.level(degrees, f"{degrees}°" if number % 4 == 0 else "")
    for moment in moments:
        pane.moment(moment)
    if plan:
        pane.line([(s, at * DEGREES) for s, at in sampled(plan, SECONDS)], GREY, 1, "4 3")
    if ideal:
        pane.line([(s, at * DEGREES) for s, at in sampled(ideal, end)], SHADE, 5)
    pane.line(stairs([(s, goals[n] * DEGREES) for s, n in zip(times, rows)]), ORANGE, 1.1)
    pane.line([(s, positions[n] * DEGREES) for s, n in zip(times, rows)], BLUE, 1.3, tolerance=0.3)

    pane = Pane(drawing, left, top + 118, 80, -34, 46)
    for rpm in (-30, 0, 30):
        pane.level(rpm, f"{rpm} RPM" if number % 4 == 0 else "")
    for moment in moments:
        pane.moment(moment)
    if ideal:
        pane.line([(s, speed(ideal, s) * RPM if s < end else 0) for s, _ in sampled(ideal, end)], SHADE, 5)
    pane.line([(s, (positions[n + SMOOTH] - positions[n - SMOOTH]) / smooth * RPM)
               for s, n in zip(times, rows)], BLUE, 1.3, tolerance=0.4)
    for second in (0, 0.5, 1, 1.5):
        drawing.text(pane.x(second), top + 212, f"{second:g} s", "middle", GREY, 11)


def legend(drawing, top, entries):
    """entries: (text, colour, width, dash), from left to right."""
    left = 70
    for text, colour, width, dash in entries:
        drawing.path([(left, top - 4), (left + 24, top - 4)], colour, width, dash)
        drawing.text(left + 30, top, text)
        left += 48 + 6.6 * len(text)


def curves(path):
    goals, positions, moves, _ = run("build/atmega128/firmware/curves.elf", 1)
    goals, positions = [row[0] for row in goals], [row[0] for row in positions]
    drawing = Drawing(930, 600)
    drawing.text(20, 26, "One joint: 117 degrees in 1.2 s by each curve, and what may happen on the way",
                 weight="bold", size=14)
    for number, (first, _) in enumerate(moves):
        draw_move(drawing, 70 + 212 * (number % 4), 80 + 262 * (number // 4), number, goals, positions, first)
    legend(drawing, 584, [("the curve in real numbers", SHADE, 5, ""), ("goal, every 4 ms", ORANGE, 1.1, ""),
                          ("simulated servo: position, speed over 64 ms", BLUE, 1.3, ""),
                          ("the move as begun", GREY, 1, "4 3")])
    drawing.write(path)


# ---- 18 joints arrive together ----------------------------------------------------------------------

JOINTS, SHOWN = 18, 4  # joints of motion.c; its moves in the picture
BEFORE, AFTER = 20, 40  # rows in front of the first move and behind the last one
LEFT, ACROSS = 110, 800


def deviations(goals, moves):
    """{row: (lowest, highest)} of goal minus curve in steps, of all joints, while a move is under way."""
    found = {}
    for first, last, periods in moves:
        start, end = goals[first - 5], goals[last + 5]
        ideal = [move(a, b, periods * PERIOD_MS / 1000) for a, b in zip(start, end)]
        widest = max(range(JOINTS), key=lambda joint: abs(end[joint] - start[joint]))
        row = first_goal([goal[widest] for goal in goals], first, ideal[widest])
        for n in range(row, row + periods + 1):
            errors = [goals[n][joint] - ideal[joint]((n - row) * PERIOD_MS / 1000) for joint in range(JOINTS)]
            found[n] = min(errors), max(errors)
    return found


def band(drawing, ranges, x, y, colour):
    """A filled band between the lowest and the highest value of each row."""
    lower = [(x(row), y(low)) for row, (low, _) in ranges]
    upper = [(x(row), y(high)) for row, (_, high) in ranges]
    drawing.area(simplified(upper, 0.4) + simplified(lower, 0.4)[::-1], colour)


def axis(drawing, top, height, name, levels, y):
    drawing.text(LEFT, top - 8, name)
    drawing.box(LEFT, top, ACROSS, height, "none", PALE)
    for value, text in levels:
        drawing.path([(LEFT, y(value)), (LEFT + ACROSS, y(value))], PALE)
        drawing.text(LEFT - 6, y(value) + 4, text, "end", GREY, 11)


def arrival(path):
    goals, positions, moves, said = run("build/atmega128/firmware/motion.elf", JOINTS)
    periods = [-(-int(ms) // PERIOD_MS) for ms in re.findall(r"^ms (\d+)$", said, re.M)]
    moves = [(first, last, number) for (first, last), number in zip(moves, periods)][:SHOWN]
    rows = range(max(moves[0][0] - BEFORE, 0), moves[-1][1] + AFTER)
    drawing = Drawing(930, 640)

    def x(row):
        return LEFT + ACROSS * (row - rows[0]) / len(rows)

    def scale(top, height, lowest, highest):
        return lambda value: top + height * (highest - value) / (highest - lowest)

    drawing.text(20, 26, "18 joints go to poses at random: all arrive with their last goals", weight="bold",
                 size=14)
    y = scale(66, 330, 0, 300)
    axis(drawing, 66, 330, "Goal and position of each joint", [(n, f"{n}°") for n in (0, 60, 120, 180, 240, 300)], y)
    for joint in range(JOINTS):
        goal, present = ([(x(n), y(values[n][joint] * DEGREES)) for n in rows] for values in (goals, positions))
        drawing.path(simplified(goal, 0.5), ORANGE, 0.9)
        drawing.path(simplified(present, 0.5), BLUE, 0.9)

    y = scale(436, 50, -1.2, 1.2)
    axis(drawing, 436, 50, "Goal beside the curve in real numbers, all joints", [(n, f"{n} step") for n in (-1, 0, 1)], y)
    errors = deviations(goals, moves)
    for first, last, _ in moves:
        band(drawing, [(n, errors[n]) for n in range(first, last + 4) if n in errors], x, y, ORANGE)

    y = scale(526, 70, -40, 40)
    axis(drawing, 526, 70, "Position beside the goal, all joints", [(n, f"{n} steps") for n in (-30, 0, 30)], y)
    lags = [(n, [a - b for a, b in zip(positions[n], goals[n])]) for n in rows]
    band(drawing, [(n, (min(lag), max(lag))) for n, lag in lags], x, y, BLUE)

    for first, last, periods in moves:
        drawing.path([(x(last), 66), (x(last), 596)], DARK, 0.8, "2 3")
        drawing.text((x(first) + x(last)) / 2, 411, f"in {periods * PERIOD_MS / 1000:g} s", "middle", GREY)
    seconds = len(rows) * PERIOD_MS / 1000
    for second in range(int(seconds) + 1):
        drawing.text(LEFT + ACROSS * second / seconds, 614, f"{second} s", "middle", GREY, 11)
    legend(drawing, 632, [("goals", ORANGE, 0.9, ""), ("simulated servos", BLUE, 0.9, ""),
                          ("the last goals of a move are sent", DARK, 0.8, "2 3")])
    drawing.write(path)
