/* SPDX-License-Identifier: MIT */
/* What the compiler or the linker says about the core's object of the USART that the servos have.
 */
#ifndef CDS55XX_SERIAL_NOTICE_H
#define CDS55XX_SERIAL_NOTICE_H

#include "board.h"

#if BOARD_BUS0_USART == 0
#define CDS55XX_SERIAL_NOTICE                                                                      \
    "CDS55xx: the servos have the only USART of this board, so a sketch cannot use Serial; use "   \
    "SoftwareSerial or a Mega (docs/arduino.md)"
#elif BOARD_BUS0_USART == 1
#define CDS55XX_SERIAL_NOTICE                                                                      \
    "CDS55xx: the servos have USART1, so a sketch cannot use Serial1; use Serial, Serial2 or "     \
    "Serial3 (docs/arduino.md)"
#endif

#endif
