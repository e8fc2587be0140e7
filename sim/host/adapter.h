/* SPDX-License-Identifier: MIT */
/* A PC's serial adapter: sends the bytes of a program in order and passes received bytes to it.
 *
 * Full duplex, it is the PC's end of the host link. Half duplex, it is a USB2Dynamixel: it drives
 * the bus from the first start bit to the end of the last stop bit. Meanwhile it receives nothing,
 * neither its own bytes nor those of others. */
#ifndef SIM_ADAPTER_H
#define SIM_ADAPTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/net.h"
#include "wire/schedule.h"
#include "wire/uart.h"

#define ADAPTER_SIZE 4096 // bytes that wait to be sent

struct adapter_byte {
    uint32_t bit_time_256;
    uint8_t byte;
};

struct adapter {
    struct schedule *schedule;
    uint32_t clock_Hz;
    bool half_duplex;
    struct driver driver;
    struct uart_tx tx;
    struct net rxd; // behind the receive buffer
    struct driver to_rxd;
    struct listener listener;
    struct uart_rx rx;
    uint32_t baud, bit_time_256;
    uint32_t (*follow)(void *context); // adapter_follow(); 0: none
    void *follow_context;
    struct adapter_byte queue[ADAPTER_SIZE]; // a ring
    size_t head, waiting;
    uint32_t framing_errors;
    void *context;
    void (*on_byte)(void *context, uint64_t now, uint8_t byte); // may be 0
    void (*on_start)(void *context, uint64_t now);              // a byte begins; may be 0
    void (*on_drive)(void *context, uint64_t now,
                     bool driving); // half duplex: the driver turns on or off; may be 0
};

/* The adapter is half duplex if `to` and `from` are the same net. */
void adapter_init(struct adapter *adapter, struct schedule *schedule, struct net *to,
                  struct net *from, uint32_t clock_Hz, uint32_t baud);

/* Sets the bit rate for bytes given, and start bits received, from now on. 0 (the line was hung up)
 * changes nothing. */
void adapter_baud(struct adapter *adapter, uint32_t baud);

/* From now on each byte has the bit time that `follow` returns, in 1/256 cycle, in place of the
 * rate of adapter_baud(): for a PC that has no bit rate of its own. */
void adapter_follow(struct adapter *adapter, uint32_t (*follow)(void *context), void *context);

/* Returns how many bytes adapter_send() takes now. It drops further bytes. */
size_t adapter_space(const struct adapter *adapter);
void adapter_send(struct adapter *adapter, uint64_t now, const uint8_t *bytes, size_t size);

/* Returns the end of the last stop bit of all bytes so far. It is in the past if all are sent. */
uint64_t adapter_end(const struct adapter *adapter);

#endif
