/* SPDX-License-Identifier: MIT */
/* Arduino Uno: its one USART (pins 0, 1) to the bus through a 74HC241, whose two enables hang on
 * pin 2; the PC is left out. Plain letters and numbers: the simulator reads this file too. */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_BUS_COUNT        1
#define BOARD_BUS0_WIRING      ONE_ENABLE
#define BOARD_BUS0_USART       0
#define BOARD_BUS0_RXD_PORT    D
#define BOARD_BUS0_RXD_BIT     0
#define BOARD_BUS0_TXD_PORT    D
#define BOARD_BUS0_TXD_BIT     1
#define BOARD_BUS0_ENABLE_PORT D
#define BOARD_BUS0_ENABLE_BIT  2

#define BOARD_CLOCK_TIMER 1

#endif
