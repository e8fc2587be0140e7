# SPDX-License-Identifier: MIT
# The chip of the gripper, for the simulator and for make flash BOARD_DIR=.
MCU      := atmega644p
F_CPU    := 16000000
FIRMWARE := examples/gripper/gripper.c
