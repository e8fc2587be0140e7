# SPDX-License-Identifier: MIT
# Robotis CM-510.
MCU        := atmega2561
# simavr has the same die with more pins.
SIM_MCU    := atmega2560
F_CPU      := 16000000

# Budgets of the firmware: bytes of flash, bytes of static RAM (of 8192).
FLASH_MAX  := 262144
RAM_MAX    := 5120

# Through an ISP programmer. The fuses are left as Robotis set them: external crystal.
PROGRAMMER  := usbasp
PORT        := usb
FLASH_FLAGS :=
FLASH_NOTE  := this erases the boot loader of Robotis, and with it the way back to their firmware without a programmer
FUSES       := as-shipped
