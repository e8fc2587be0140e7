/* SPDX-License-Identifier: MIT */
/* Robotis CM-510: USART0 to the bus, TX enable on PE2, RX enable on PE3; USART1 to the PC. Plain
 * letters and numbers: the simulator reads this file too. */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_BUS_COUNT           1
#define BOARD_BUS0_WIRING         TWO_ENABLES
#define BOARD_BUS0_USART          0
#define BOARD_BUS0_RXD_PORT       E
#define BOARD_BUS0_RXD_BIT        0
#define BOARD_BUS0_TXD_PORT       E
#define BOARD_BUS0_TXD_BIT        1
#define BOARD_BUS0_TX_ENABLE_PORT E
#define BOARD_BUS0_TX_ENABLE_BIT  2
#define BOARD_BUS0_RX_ENABLE_PORT E
#define BOARD_BUS0_RX_ENABLE_BIT  3

#define BOARD_HOST_USART 1
#define BOARD_HOST_BAUD  57600

#define BOARD_CLOCK_TIMER 1

#endif
