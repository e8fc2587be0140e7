# SPDX-License-Identifier: MIT
# The interface circuit of the CDS55xx manual (1.2.3) on an ATmega128.
MCU        := atmega128
F_CPU      := 16000000

# Budgets of the firmware: bytes of flash, bytes of static RAM (of 4096).
FLASH_MAX  := 131072
RAM_MAX    := 3456

PROGRAMMER  := usbasp
PORT        := usb
FLASH_FLAGS :=
FLASH_NOTE  := a new ATmega128 runs at 1 MHz and as an ATmega103 without USART1 (fuse M103C): make fuses first

# Crystal of 8 MHz or more at full swing (CKOPT), slow start-up, brown-out reset at 4.0 V; M103C off,
# JTAG off, EEPROM kept at chip erase.
FUSES       := -U lfuse:w:0x3f:m -U hfuse:w:0xc1:m -U efuse:w:0xff:m
