/* A board's two data files, read as plain text: board.mk (chip, clock) and board.h (wiring). */
#ifndef SIM_BOARD_H
#define SIM_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#define BOARD_BUSES_MAX 3
#define BOARD_PATH_SIZE 1024
#define BOARD_FILE_KIB  256 // the longest board.h or board.mk that is read

/* How a bus hangs on its USART. */
enum board_wiring {
    BOARD_TWO_ENABLES,  // the manual's circuit: one buffer each way, an enable pin for each
    BOARD_ONE_ENABLE,   // the same from one pin: high talks, low listens
    BOARD_TIED,         // TXD and RXD joined to the wire
    BOARD_ADAPTER,      // an adapter between them and the wire that finds the direction by itself
    BOARD_ADAPTER_ECHO, // one that hears the wire always, what it says itself too
    BOARD_WIRINGS
};

struct board_pin {
    char port; // 'A'...
    uint8_t bit;
};

struct board_bus {
    enum board_wiring wiring;
    unsigned usart;
    struct board_pin tx_enable; // the one enable too; not of those without
    struct board_pin rx_enable; // of BOARD_TWO_ENABLES
    struct board_pin txd;
    struct board_pin rxd;
};

struct board {
    char mcu[64];
    char core[64]; // the chip that simavr has in its place: the same, unless SIM_MCU says otherwise
    uint32_t clock_Hz;
    unsigned bus_count;
    struct board_bus bus[BOARD_BUSES_MAX];
    bool has_host; // a USART is left for a PC: not so on a chip that has only one
    unsigned host_usart;
    uint32_t host_baud;
};

/* The paths of the two files that board_read() reads; they need not exist. */
void board_paths(const char *folder, const char *name, char wiring[BOARD_PATH_SIZE],
                 char chip[BOARD_PATH_SIZE]);

/* Reads FOLDER/NAME/board.h and board.mk. A name with `.` or `/` in it is the path of a board.h, or
 * of the folder it is in; its chip and clock are BOARD_MCU and BOARD_F_CPU in it, or MCU and F_CPU
 * in a board.mk beside it. False, with one line on stderr, when there is no such board (the line
 * lists those there are), a file lacks something, is no regular file or is too long. */
bool board_read(struct board *board, const char *folder, const char *name);

#endif
