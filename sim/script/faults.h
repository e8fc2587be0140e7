/* SPDX-License-Identifier: MIT */
/* Injects the faults of one bus (docs/faults.md).
 *
 * The module counts the packets and bytes of each sender. Some faults override the level of the
 * wire during a bit, a byte or a short circuit. Others change a servo's reply before it is sent, or
 * the servo. All random numbers come from one seed.
 *
 * A fault is never the controller's error: a servo that sends in a transaction in which a fault has
 * acted is exempt from the rules of the wire (struct driver). */
#ifndef SIM_FAULTS_H
#define SIM_FAULTS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "script/fault_order.h"
#include "servo/servos.h"
#include "wire/net.h"
#include "wire/schedule.h"
#include "wire/uart.h"

#define FAULTS_PENDING_MAX 64  // orders
#define FAULTS_PULSES_MAX  128 // overrides at one time: two bits for each order

/* An order that waits for its packet. */
struct pending_fault {
    struct fault_order order; // its packet number counts from the start of the run
    bool acted;
};

struct fault_pulse {
    uint64_t from, until;
    enum net_override override;
};

/* The packet that the controller sends. */
struct controller_packet {
    uint32_t packets;
    unsigned byte; // index of the latest byte
    unsigned id;   // position of the ID; 0: not known yet
    unsigned size; // bytes of the packet; 0: not known yet
    uint64_t end;  // end of the latest byte
    bool complete; // the latest byte completes the packet
};

struct faults {
    struct schedule *schedule;
    struct servos *servos;
    struct net *sig;
    uint32_t bit_time_256; // latest bit time of the controller, in 1/256 cycle
    uint32_t random;
    struct pending_fault pending[FAULTS_PENDING_MAX];
    unsigned pending_count;
    struct controller_packet controller_packet;
    uint32_t replies;
    struct fault_pulse pulse[FAULTS_PULSES_MAX];
    unsigned pulses;
    struct event edge; // of an override
    enum net_override stuck;
    struct event unstick;
    uint32_t noise; // flips per second; 0: off
    struct event flip;
    struct driver babbler;
    struct uart_tx babble;
    enum fault_babble babbling;
    uint8_t babble_byte;
    struct driver echo; // drives RXD, together with the receive buffer
    struct listener on_sig;
    bool exempts_replies;   // a fault has acted since the start of the controller's latest packet
    uint64_t exempts_until; // end of the latest fault
    uint32_t orders, acts, unused;
    bool absent[IDS_MAX]; // no servo had such an ID when an unplug acted
    uint32_t resets;      // of the controller; a reset exempts servos as a fault does
    void *context;
    /* A fault acts; for plots. until == from: the fault has no end of its own. May be 0. */
    void (*on_act)(void *context, uint64_t from, uint64_t until, const char *what);
};

/* Uses the servos' fault_on_reply and fault_on_byte. */
void faults_init(struct faults *faults, struct schedule *schedule, struct servos *servos,
                 uint32_t seed);
/* Connects `echo` to the controller's receiver, which a buffer separates from the wire. Without a
 * receiver there is no `echo`. */
void faults_connect_receiver(struct faults *faults, struct net *rxd);

/* The controller was reset. Servos that send, or that reply to a packet that the reset cut, are
 * exempt from the rules. */
void faults_controller_reset(struct faults *faults, uint64_t now);

/* Call it when a byte of the controller begins on the wire, before the byte drives the wire. */
void faults_controller_byte(struct faults *faults, uint64_t now, const struct uart_tx *tx);

/* faults_order() executes an order. faults_check() only checks its text: use it before there are
 * servos. Both return 0, or what is wrong. */
const char *faults_order(struct faults *faults, uint64_t now, const char *text);
const char *faults_check(const char *text);

/* Prints one line if there were orders. `where` names the bus, or is "". */
void faults_report(const struct faults *faults, const char *where, FILE *out);

#endif
