# SPDX-License-Identifier: MIT
# Arduino Uno with a 74HC241 on a shield.
MCU        := atmega328p
F_CPU      := 16000000

# The bus has the only USART, so there is no console: the firmware is the shortest program.
FIRMWARE   := examples/two_servos.c

# Budgets of the firmware: bytes of flash, bytes of static RAM (of 2048).
FLASH_MAX  := 8192
RAM_MAX    := 512

# The boot loader Arduino ships writes the flash, and cannot write fuses; they are right as they are:
# external crystal, brown-out at 2.7 V.
PROGRAMMER  := arduino
PORT        := /dev/ttyACM0
FLASH_FLAGS := -b 115200 -D
FLASH_NOTE  := the boot loader uses the bus's USART: take the RX buffer's output off pin 0 while it writes
FUSES       := as-shipped
