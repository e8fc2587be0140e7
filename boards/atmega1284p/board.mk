# SPDX-License-Identifier: MIT
# The interface circuit of the CDS55xx manual (1.2.3) on an ATmega1284P.
MCU        := atmega1284p
F_CPU      := 16000000

# Budgets of the firmware: bytes of flash, bytes of static RAM (of 16384).
FLASH_MAX  := 131072
RAM_MAX    := 5120

PROGRAMMER  := usbasp
PORT        := usb
FLASH_FLAGS :=
FLASH_NOTE  := a new ATmega1284P runs at 1 MHz from its internal oscillator: make fuses first

# Crystal of 8 to 16 MHz at full swing, slow start-up, no divider; JTAG off, EEPROM kept at chip erase;
# brown-out reset at 4.3 V.
FUSES       := -U lfuse:w:0xf7:m -U hfuse:w:0xd1:m -U efuse:w:0xfc:m
