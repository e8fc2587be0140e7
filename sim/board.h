/* SPDX-License-Identifier: MIT */
/* Reads a board's two data files as text: board.mk (chip, clock) and board.h (wiring). */
#ifndef SIM_BOARD_H
#define SIM_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#define BOARD_BUSES_MAX 3
#define BOARD_PATH_SIZE 1024
#define BOARD_FILE_KIB  256 // longest board.h or board.mk

/* How a bus is connected to its USART. */
enum board_wiring {
    BOARD_TWO_ENABLES,  // the manual's circuit: one buffer each way, an enable pin for each
    BOARD_ONE_ENABLE,   // the same circuit with one pin: high sends, low receives
    BOARD_TIED,         // TXD and RXD are connected to the wire
    BOARD_ADAPTER,      // an adapter between USART and wire finds the direction by itself
    BOARD_ADAPTER_ECHO, // an adapter that also receives what it sends
    BOARD_WIRINGS
};

struct board_pin {
    char port; // 'A' to 'L'
    uint8_t bit;
};

struct board_bus {
    enum board_wiring wiring;
    unsigned usart;
    struct board_pin tx_enable; // also the pin of BOARD_ONE_ENABLE
    struct board_pin rx_enable; // BOARD_TWO_ENABLES only
    struct board_pin txd;
    struct board_pin rxd;
};

struct board {
    char mcu[64];
    char core[64]; // the chip that simavr simulates: `mcu`, unless SIM_MCU names another
    uint32_t clock_Hz;
    unsigned bus_count;
    struct board_bus bus[BOARD_BUSES_MAX];
    bool has_host; // false on a chip whose only USART drives the bus
    unsigned host_usart;
    uint32_t host_baud;
};

/* Returns the paths of the two files that board_read() reads. The files need not exist. */
void board_paths(const char *folder, const char *name, char wiring[BOARD_PATH_SIZE],
                 char chip[BOARD_PATH_SIZE]);

/* Reads FOLDER/NAME/board.h and board.mk. A name with `.` or `/` is the path of a board.h or of its
 * folder. Chip and clock are BOARD_MCU and BOARD_F_CPU in board.h, or MCU and F_CPU in the board.mk
 * beside it. A clock that is not given is 16 MHz. Returns false, with one line on stderr, if there
 * is no such board (the line lists the known boards), or if a file lacks a value, is no regular
 * file or is too long. */
bool board_read(struct board *board, const char *folder, const char *name);

#endif
