/* SPDX-License-Identifier: MIT */
/* Decodes the wire and writes each packet in the manual's notation, with counts.
 *
 * A byte is decoded at the bit rate of its sender. A packet ends when its LENGTH is complete, when
 * another sender drives the wire, or when the line was idle for three byte times. Bytes that are no
 * packet are written too. A `!` after a byte marks a framing error. */
#ifndef SIM_TRANSCRIPT_H
#define SIM_TRANSCRIPT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "wire/net.h"
#include "wire/schedule.h"
#include "wire/uart.h"

#define TRANSCRIPT_SIZE 300 // bytes of one line; a packet has at most 259

struct transcript {
    struct schedule *schedule;
    const struct driver *controller; // the controller's driver of the net
    const struct driver
        *controller_tx;         // the driver whose bits `controller` repeats; it knows the bit time
    const struct driver *servo; // the latest other driver that was enabled
    struct uart_rx rx;
    struct listener listener;
    struct event idle;
    const char *label;           // names the bus in each line; 0: none
    FILE *file;                  // 0: none
    FILE *echo;                  // a second output; 0: none
    bool byte_from_controller;   // sender of the present byte
    bool packet_from_controller; // sender of the present packet
    uint16_t size;
    uint64_t start;
    uint8_t bytes[TRANSCRIPT_SIZE];
    bool bad[TRANSCRIPT_SIZE]; // framing errors

    bool good;            // the line is a packet
    uint32_t packets_in;  // good packets from the controller
    uint32_t packets_out; // good packets from servos
    uint32_t damaged;     // lines that are no packet
    uint64_t busy;        // cycles with a frame on the wire

    void *context;
    /* A line is complete, as a packet or not. It is valid during the call. May be 0. */
    void (*on_line)(void *context, const struct transcript *transcript);
};

/* `controller` may be 0: then all senders are servos. */
void transcript_init(struct transcript *transcript, struct schedule *schedule, struct net *net,
                     const struct driver *controller);

/* Ends the run: writes an unfinished packet and does not count it. */
void transcript_end(struct transcript *transcript);

#endif
