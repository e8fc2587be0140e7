/* The faults of a bus, injected: orders as in docs/faults.md, and what they do to the wire and to
 * the servos on it.
 *
 * It watches who begins which byte of which packet, and overrides the level of the wire for as long
 * as a bit, a byte or a short circuit lasts; other faults change a servo's reply before it leaves,
 * or the servo itself. All at random comes from one seed.
 *
 * Nothing that follows of a fault is the controller's doing: a servo that talks in an exchange in
 * which a fault has acted is excused (struct driver), and the rules of the wire look away from it.
 */
#ifndef SIM_FAULTS_H
#define SIM_FAULTS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "script/fault_order.h"
#include "wire/net.h"
#include "wire/schedule.h"
#include "servo/servos.h"
#include "wire/uart.h"

#define FAULTS_PENDING_MAX 64  // orders
#define FAULTS_PULSES_MAX  128 // overrides at one time: two bits for each order

/* An order that waits for its packet. */
struct pending_fault {
    struct fault_order order; // its packet counted from the start of the run
    bool acted;
};

struct fault_pulse {
    uint64_t from, until;
    enum net_override override;
};

/* The packet that the controller sends. */
struct controller_packet {
    uint32_t packets;
    unsigned byte; // the latest one, from 0
    unsigned id;   // where the ID is; 0: not yet
    unsigned size; // bytes of the packet; 0: not yet known
    uint64_t end;  // of its latest byte
    bool complete; // with its latest byte
};

struct faults {
    struct schedule *schedule;
    struct servos *servos;
    struct net *sig;
    uint32_t bit_256; // of the bus: what the controller last used
    uint32_t random;
    struct pending_fault pending[FAULTS_PENDING_MAX];
    unsigned pending_count;
    struct controller_packet packet_in;
    uint32_t replies;
    struct fault_pulse pulse[FAULTS_PULSES_MAX];
    unsigned pulses;
    struct event edge; // of an override
    enum net_override stuck;
    struct event unstick;
    uint32_t noise; // flips per second
    struct event flip;
    struct driver babbler;
    struct uart_tx babble;
    enum fault_babble babbling;
    uint8_t babble_byte;
    struct driver echo; // on RXD, beside the receive buffer
    struct listener on_sig;
    bool disturbed; // a fault has acted since the controller's latest packet began
    uint64_t disturbed_until;
    uint32_t orders, acts, unused;
    uint32_t resets; // of the controller: as good as a fault, for who is to blame
    void *context;
    /* A fault acts, for pictures; until == from: it has no end of its own. May be 0. */
    void (*on_act)(void *context, uint64_t from, uint64_t until, const char *what);
};

/* On the servos' net; takes the servos' on_due and on_frame. */
void faults_init(struct faults *faults, struct schedule *schedule, struct servos *servos,
                 uint32_t seed);
/* The controller's receiver hangs on `rxd`, behind a buffer; without one there is no `echo`. */
void faults_connect_receiver(struct faults *faults, struct net *rxd);

/* To be called when a byte of the controller begins on the wire, before it drives. */
/* The controller was reset: servos that talk, or answer what it was cut short in, are excused. */
void faults_controller_reset(struct faults *faults, uint64_t now);

void faults_controller_byte(struct faults *faults, uint64_t now, const struct uart_tx *tx);

/* Takes an order. Returns 0, or what is wrong. The check does nothing else: it is for a file that
 * is read before there are servos. */
const char *faults_order(struct faults *faults, uint64_t now, const char *text);
const char *faults_check(const char *text);

/* One line, if there were orders; `where` says on which bus, or "". */
void faults_report(const struct faults *faults, const char *where, FILE *out);

#endif
