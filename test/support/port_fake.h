/* A port that records. The core's verbs land in a log, the clock stands where the test puts it, and
 * the test plays the line, the transmitter and the servos by raising the events of link.h.
 *
 * The fake also keeps the rules of port.h: a verb out of place (a byte given while the driver is
 * off, a second talk before the first has ended ...) is a breach, and a test ends with none.
 */
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

/* All of it back to nothing; the clock at 0. */
void port_fake_reset(void);

/* Empties the log; clock, directions and counts of packets and breaches stay. */
void port_fake_forget(void);

/* True while a packet is on the wire or its reply is awaited. */
bool port_fake_is_in_flight(const struct cds_bus *bus);

/* Time passes in silence, at most 3 ms, until the first request has been sent: also in a rest. */
void port_fake_settle(struct cds_bus *bus);

/* Polls while the clock stands still, until a poll changes nothing or the transaction in flight has
 * ended. A poll does one thing: a reply takes several. */
void port_fake_look(struct cds_bus *bus);

/* The transmitter takes bytes until it has the last one, which leaves the link draining. False when
 * a packet has no end. */
bool port_fake_drain(struct cds_link *link, uint8_t port);

/* As above, and then the last stop bit leaves: the link listens. */
bool port_fake_transmit(struct cds_link *link, uint8_t port);

/* The receiver hears these bytes, none of them damaged. */
void port_fake_hear(struct cds_link *link, const uint8_t *bytes, uint16_t count);

/* A servo answers: a whole status packet with a right checksum, the fake's own arithmetic. */
void port_fake_answer(struct cds_link *link, uint8_t id, uint8_t error, const uint8_t *parameters,
                      uint8_t count);

#endif
