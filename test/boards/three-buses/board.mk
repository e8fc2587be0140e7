# An Arduino Mega 2560 with three buses, for tests of the simulator.
MCU   := atmega2560
F_CPU := 16000000
