# SPDX-License-Identifier: MIT
# For the bench: the chip that published drivers were measured on, with two enables. Never flashed.
MCU   := atmega644p
F_CPU := 16000000
