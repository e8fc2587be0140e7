/* SPDX-License-Identifier: MIT */
/* An ATmega128 whose USART1 goes to an adapter that finds the direction by itself and
 * does not let RXD hear what TXD says, for tests. */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_BUS_COUNT     1
#define BOARD_BUS0_WIRING   ADAPTER
#define BOARD_BUS0_USART    1
#define BOARD_BUS0_RXD_PORT D
#define BOARD_BUS0_RXD_BIT  2
#define BOARD_BUS0_TXD_PORT D
#define BOARD_BUS0_TXD_BIT  3

#define BOARD_HOST_USART 0
#define BOARD_HOST_BAUD  115200

#define BOARD_CLOCK_TIMER 1

#endif
