# SPDX-License-Identifier: MIT
# ArbotiX.
MCU        := atmega644p
F_CPU      := 16000000

# Budgets of the firmware: bytes of flash, all but the 4 KB of the boot loader; bytes of static RAM
# (of 4096).
FLASH_MAX  := 61440
RAM_MAX    := 3456

# All commands but diagnose: the flash has no room for `full`.
PROFILE    := console
PROFILES   := bridge console

# Through an ISP programmer, which needs no boot loader. The fuses are left as shipped: external
# crystal.
PROGRAMMER  := usbasp
PORT        := usb
FLASH_FLAGS :=
FLASH_NOTE  := this erases the boot loader that the ArbotiX was shipped with
FUSES       := as-shipped
