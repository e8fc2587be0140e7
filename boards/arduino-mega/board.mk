# Arduino Mega 2560 with a 74HC126 (or 74HC241) on a shield.
MCU        := atmega2560
F_CPU      := 16000000

# Budgets of the firmware: bytes of flash, bytes of static RAM.
FLASH_MAX  := 24576
RAM_MAX    := 3072

# Fuses: as Arduino ships it (external crystal, boot loader of 4096 words, brown-out at 2.7 V).
FLASH_NOTE := the boot loader of Arduino is used; fuses stay as they are
LFUSE      := 0xff
HFUSE      := 0xd8
EFUSE      := 0xfd
PROGRAMMER := wiring
PORT       := /dev/ttyACM0
