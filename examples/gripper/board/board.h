/* SPDX-License-Identifier: MIT */
/* The board of the gripper: an ATmega644P at 16 MHz, TXD0 and RXD0 tied to the wire of the servo,
 * USART1 to the PC. */
#define BOARD_BUS_COUNT     1
#define BOARD_BUS0_WIRING   TIED
#define BOARD_BUS0_USART    0
#define BOARD_BUS0_RXD_PORT D
#define BOARD_BUS0_RXD_BIT  0
#define BOARD_BUS0_TXD_PORT D
#define BOARD_BUS0_TXD_BIT  1
#define BOARD_HOST_USART    1
#define BOARD_HOST_BAUD     115200
#define BOARD_CLOCK_TIMER   1
