# SPDX-License-Identifier: MIT
# For tests: never flashed.
MCU   := atmega128
F_CPU := 16000000
