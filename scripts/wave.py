#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints a console script: a wave through servos 1 to 18 by SYNC WRITE, positions read back.

usage: wave.py [STEPS]   (default 60, about 90 ms each)
"""
import math
import sys

SERVOS = range(1, 19)
STEPS_PER_PERIOD = 30
MIDDLE, SWING = 512, 300  # units of 300/1023 degrees
SPEED = 700               # units of 62/1023 RPM


def goal(servo, step):
    phase = 2 * math.pi * (step / STEPS_PER_PERIOD - servo / len(SERVOS))
    return round(MIDDLE + SWING * math.sin(phase))


def block(servo, step):
    return f"{servo}:{goal(servo, step) & 255},{goal(servo, step) >> 8},{SPEED & 255},{SPEED >> 8}"


def script(steps):
    """The whole script as text."""
    lines = ["@print",
             "@print A wave through 18 fresh servos: SYNC WRITE of goal and speed, positions read back",
             "@echo off", "@servos 1-18", "write 254 TORQUE_ENABLE 1"]
    for step in range(steps):
        if step % STEPS_PER_PERIOD == 0:
            lines.append(f"@print wave: step {step} of {steps}")
        lines.append("sync GOAL_POSITION 4 " + " ".join(block(servo, step) for servo in SERVOS))
        lines += [f"read {servo} PRESENT_POSITION" for servo in range(1 + step % 6, 19, 6)]
        lines.append("@wait 20")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(script(int(sys.argv[1]) if len(sys.argv) > 1 else 60), end="")
