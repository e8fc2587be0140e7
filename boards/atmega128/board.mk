# The interface circuit of the CDS55xx manual (1.2.3) on an ATmega128.
MCU        := atmega128
F_CPU      := 16000000

# Budgets of the firmware: bytes of flash, bytes of static RAM.
FLASH_MAX  := 24576
RAM_MAX    := 3072

# Fuses: external crystal, slow start-up; M103C off (from the factory it is on, and an ATmega103 has
# no USART1); JTAG off; EEPROM kept at chip erase; brown-out reset at 4.0 V; boot at 0.
LFUSE      := 0x1f
HFUSE      := 0xd1
EFUSE      := 0xff
PROGRAMMER := usbasp
PORT       := usb
