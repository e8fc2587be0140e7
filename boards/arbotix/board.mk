# ArbotiX.
MCU        := atmega644p
F_CPU      := 16000000

# Budgets of the firmware: bytes of flash, bytes of static RAM (of 4096).
FLASH_MAX  := 61440
RAM_MAX    := 3328

# Half the flash of the others: 2.5 KB less, for cycles in functions that keep many registers.
SMALLER    := -mcall-prologues -fno-inline-small-functions -fno-move-loop-invariants \
	-fira-algorithm=priority -fno-tree-sink -fno-tree-loop-im -fipa-pta

# Through an ISP programmer, which needs no boot loader. The fuses are left as shipped: external
# crystal.
PROGRAMMER  := usbasp
PORT        := usb
FLASH_FLAGS :=
FLASH_NOTE  := this erases the boot loader that the ArbotiX was shipped with
FUSES       :=
