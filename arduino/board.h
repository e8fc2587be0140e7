/* SPDX-License-Identifier: MIT */
/* Chooses the board from the chip that the Arduino IDE compiles for, and takes bus 0 of that board.
 * The other buses of a Mega stay free: their pins and Serial2, Serial3 belong to the sketch. */
#ifndef CDS55XX_ARDUINO_BOARD_H
#define CDS55XX_ARDUINO_BOARD_H

#if defined(__AVR_ATmega2560__) || defined(__AVR_ATmega1280__)
#include "arduino-mega/board.h"
#elif defined(__AVR_ATmega328P__)
#include "arduino-uno/board.h"
#else
#error "CDS55xx supports Uno and Nano (ATmega328P) and Mega (ATmega2560, ATmega1280)"
#endif

#undef BOARD_BUS_COUNT
#define BOARD_BUS_COUNT 1

#endif
