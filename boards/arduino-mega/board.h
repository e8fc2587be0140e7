/* SPDX-License-Identifier: MIT */
/* Arduino Mega 2560: USART1 (pins 18, 19), USART2 (16, 17) and USART3 (14, 15) to three buses
 * through a 74HC126 each, enables on pins 22 and 23, 24 and 25, 26 and 27; USART0 to the PC over
 * USB. A program binds those it uses. Plain letters and numbers: the simulator reads this file too.
 */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_BUS_COUNT 3

#define BOARD_BUS0_USART          1
#define BOARD_BUS0_RXD_PORT       D
#define BOARD_BUS0_RXD_BIT        2
#define BOARD_BUS0_TXD_PORT       D
#define BOARD_BUS0_TXD_BIT        3
#define BOARD_BUS0_TX_ENABLE_PORT A
#define BOARD_BUS0_TX_ENABLE_BIT  0
#define BOARD_BUS0_RX_ENABLE_PORT A
#define BOARD_BUS0_RX_ENABLE_BIT  1

#define BOARD_BUS1_USART          2
#define BOARD_BUS1_RXD_PORT       H
#define BOARD_BUS1_RXD_BIT        0
#define BOARD_BUS1_TXD_PORT       H
#define BOARD_BUS1_TXD_BIT        1
#define BOARD_BUS1_TX_ENABLE_PORT A
#define BOARD_BUS1_TX_ENABLE_BIT  2
#define BOARD_BUS1_RX_ENABLE_PORT A
#define BOARD_BUS1_RX_ENABLE_BIT  3

#define BOARD_BUS2_USART          3
#define BOARD_BUS2_RXD_PORT       J
#define BOARD_BUS2_RXD_BIT        0
#define BOARD_BUS2_TXD_PORT       J
#define BOARD_BUS2_TXD_BIT        1
#define BOARD_BUS2_TX_ENABLE_PORT A
#define BOARD_BUS2_TX_ENABLE_BIT  4
#define BOARD_BUS2_RX_ENABLE_PORT A
#define BOARD_BUS2_RX_ENABLE_BIT  5

#define BOARD_HOST_USART 0
#define BOARD_HOST_BAUD  115200

#define BOARD_CLOCK_TIMER 1

#endif
