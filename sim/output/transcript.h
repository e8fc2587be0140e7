/* What went over the wire, packet by packet, in the manual's notation, and the counts of it.
 *
 * It decodes the wire itself, at the rate of whoever drives it. A packet ends when its LENGTH is
 * complete, when another one drives, or when the line was idle for three byte times. Bytes that do
 * not make a packet are shown as well; a `!` behind a byte is a framing error.
 */
#ifndef SIM_TRANSCRIPT_H
#define SIM_TRANSCRIPT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "wire/net.h"
#include "wire/schedule.h"
#include "wire/uart.h"

#define TRANSCRIPT_SIZE 300 // bytes of one line; a packet has 259 at most

struct transcript {
    struct schedule *schedule;
    const struct driver *controller;    // who of the net's drivers is the controller
    const struct driver *controller_tx; // whose bits that one repeats; knows the bit time
    const struct driver *servo;         // the latest other one that began to drive
    struct uart_rx rx;
    struct listener listener;
    struct event idle;
    const char *label;    // of its bus, behind the cycle of each line; 0: none
    FILE *file;           // 0: none
    FILE *echo;           // likewise
    bool from_controller; // the byte that is being heard
    bool of_controller;   // the packet so far
    uint16_t size;
    uint64_t start;
    uint8_t bytes[TRANSCRIPT_SIZE];
    bool bad[TRANSCRIPT_SIZE]; // framing errors

    bool good;            // the line is a packet
    uint32_t packets_in;  // good ones, from the controller
    uint32_t packets_out; // from servos
    uint32_t damaged;     // lines that are no packet
    uint64_t busy;        // cycles with a frame on the wire

    void *context;
    /* A line is complete, packet or not; it is gone afterwards. May be 0. */
    void (*on_line)(void *context, const struct transcript *transcript);
};

/* `controller` may be 0: then all are servos. */
void transcript_init(struct transcript *transcript, struct schedule *schedule, struct net *net,
                     const struct driver *controller);

/* The run is over: writes down what is still unfinished, and does not count it. */
void transcript_end(struct transcript *transcript);

#endif
