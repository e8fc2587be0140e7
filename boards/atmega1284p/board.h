/* SPDX-License-Identifier: MIT */
/* The interface circuit of the CDS55xx manual (1.2.3) on an ATmega1284P: USART1 to the bus through
 * a 74HC126, USART0 to the PC. Plain letters and numbers: the simulator reads this file too. */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_BUS_COUNT           1
#define BOARD_BUS0_USART          1
#define BOARD_BUS0_RXD_PORT       D
#define BOARD_BUS0_RXD_BIT        2
#define BOARD_BUS0_TXD_PORT       D
#define BOARD_BUS0_TXD_BIT        3
#define BOARD_BUS0_TX_ENABLE_PORT D
#define BOARD_BUS0_TX_ENABLE_BIT  6
#define BOARD_BUS0_RX_ENABLE_PORT D
#define BOARD_BUS0_RX_ENABLE_BIT  7

#define BOARD_HOST_USART 0
#define BOARD_HOST_BAUD  115200

#define BOARD_CLOCK_TIMER 1

#endif
