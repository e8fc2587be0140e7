/* SPDX-License-Identifier: MIT */
/* A port for tests. It records the calls of the core in a log. The test sets the clock, and calls
 * the functions of link.h in place of line, transmitter and servos.
 *
 * The fake checks the rules of port.h. A call that breaks one counts as a breach: a byte while the
 * driver is off, a second cds_port_talk() before the first has ended. Each test must end without
 * breaches. */
#ifndef PORT_FAKE_H
#define PORT_FAKE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"  // struct cds_bus
#include "cds55xx/link.h" // struct cds_link, the events

enum fake_verb { FAKE_OPEN, FAKE_HIGH_Z, FAKE_LISTEN, FAKE_TALK, FAKE_TX, FAKE_TX_LAST };

struct fake_entry {
    uint8_t verb; // enum fake_verb
    uint8_t port;
    uint8_t byte; // of FAKE_TX and FAKE_TX_LAST; the baud register of FAKE_OPEN
};

#define FAKE_LOG_SIZE  40  // verbs kept; later ones are only counted
#define FAKE_SENT_SIZE 258 // the longest packet there is
#define FAKE_PORTS     4

struct port_fake {
    uint32_t now_us;      // what cds_port_now_us() answers
    uint16_t clock_reads; // how often the clock or a timer was read
    uint16_t verbs;       // how many since reset or forget; the first of them are in `log`
    struct fake_entry log[FAKE_LOG_SIZE];
    uint8_t sent[FAKE_SENT_SIZE]; // what the driver has put on the line since the last talk
    uint16_t sent_size;
    uint16_t packets;          // last bytes given
    uint16_t breaches;         // verbs out of place
    uint8_t lines[FAKE_PORTS]; // enum fake_verb: the last one that changed the direction
    uint8_t bauds[FAKE_PORTS]; // the register value each was last opened with
    struct fake_timer {
        uint32_t from_us; // the moment it is counted from
        uint32_t wait_us; // it expires so long after that moment
    } timers[FAKE_PORTS];
    bool followed;           // the packet that has begun goes on
    uint16_t us_per_reading; // how far the clock moves on whenever it is asked
    bool low;                // the line is held low
    uint32_t low_seen;       // looks that found it low
    uint8_t low_looks;       // so many looks at the line find it low, as amid the bits of a byte
    bool takes_two;          // the transmitter takes two bytes at once
    struct cds_link *eager;  // if set: its packets are on the line before talk returns
    struct cds_link *late;   // if set: its "complete" was held up, until the timer is read
};

extern struct port_fake port_fake;

/* Resets the whole fake; the clock is 0. */
void port_fake_reset(void);

/* Empties the log; clock, directions and counts of packets and breaches stay. */
void port_fake_forget(void);

/* True while a packet is on the wire or its reply is awaited. */
bool port_fake_is_in_flight(const struct cds_bus *bus);

/* Advances the clock on a silent line, 3 ms at most, until the first request is sent; also during a
 * rest of the bus. */
void port_fake_settle(struct cds_bus *bus);

/* Polls without advancing the clock until a poll changes nothing or the transaction has ended. A
 * reply takes several polls. */
void port_fake_look(struct cds_bus *bus);

/* The transmitter takes all bytes of the packet; then the link is DRAINING. Returns false if the
 * packet has no end. */
bool port_fake_drain(struct cds_link *link, uint8_t port);

/* As port_fake_drain(); then the last stop bit is sent, and the link is LISTENING. */
bool port_fake_transmit(struct cds_link *link, uint8_t port);

/* The receiver gets these bytes, undamaged. */
void port_fake_hear(struct cds_link *link, const uint8_t *bytes, uint16_t count);

/* A servo sends a whole status packet. The fake computes the checksum itself. */
void port_fake_answer(struct cds_link *link, uint8_t id, uint8_t error, const uint8_t *parameters,
                      uint8_t count);

#endif
