# SPDX-License-Identifier: MIT
# Arduino Mega 2560 with a 74HC126 (or 74HC241) on a shield.
MCU        := atmega2560
F_CPU      := 16000000

# Budgets of the firmware: bytes of flash, all but the 8 KB of the boot loader; bytes of static RAM
# (of 8192).
FLASH_MAX  := 253952
RAM_MAX    := 5120

# The boot loader Arduino ships writes the flash; it can neither erase the chip (hence -D) nor write
# fuses, and they are right as they are: external crystal, brown-out at 2.7 V.
PROGRAMMER  := wiring
PORT        := /dev/ttyACM0
FLASH_FLAGS := -D
FUSES       := as-shipped
