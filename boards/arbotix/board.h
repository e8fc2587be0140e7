/* SPDX-License-Identifier: MIT */
/* ArbotiX: TXD1 and RXD1 of the ATmega644P tied to the bus, direction by TXEN and RXEN; USART0 to
 * the PC. Plain letters and numbers: the simulator reads this file too. */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_BUS_COUNT     1
#define BOARD_BUS0_WIRING   TIED
#define BOARD_BUS0_USART    1
#define BOARD_BUS0_RXD_PORT D
#define BOARD_BUS0_RXD_BIT  2
#define BOARD_BUS0_TXD_PORT D
#define BOARD_BUS0_TXD_BIT  3

#define BOARD_HOST_USART 0
#define BOARD_HOST_BAUD  115200

#define BOARD_CLOCK_TIMER 1

#endif
