#!/usr/bin/env python3
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


def main():
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    print("@print")
    print("@print A wave through 18 fresh servos: SYNC WRITE of goal and speed, positions read back")
    print("@echo off")
    print("@servos 1-18")
    print("write 254 TORQUE_ENABLE 1")
    for step in range(steps):
        if step % STEPS_PER_PERIOD == 0:
            print(f"@print wave: step {step} of {steps}")
        print("sync GOAL_POSITION 4 " + " ".join(block(servo, step) for servo in SERVOS))
        for servo in range(1 + step % 6, 19, 6):
            print(f"read {servo} PRESENT_POSITION")
        print("@wait 20")


if __name__ == "__main__":
    main()
