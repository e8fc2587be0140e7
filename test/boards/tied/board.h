/* SPDX-License-Identifier: MIT */
/* An ATmega128 with TXD1 and RXD1 tied to the bus, for tests of the simulator. */
#ifndef BOARD_H
#define BOARD_H

#define BOARD_MCU   atmega128
#define BOARD_F_CPU 16000000

#define BOARD_BUS_COUNT     1
#define BOARD_BUS0_WIRING   TIED
#define BOARD_BUS0_USART    1
#define BOARD_BUS0_RXD_PORT D
#define BOARD_BUS0_RXD_BIT  2
#define BOARD_BUS0_TXD_PORT D
#define BOARD_BUS0_TXD_BIT  3

#define BOARD_HOST_USART 0
#define BOARD_HOST_BAUD  115200

#endif
