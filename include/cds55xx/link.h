/* SPDX-License-Identifier: MIT */
/* The half-duplex direction of one bus: when the controller drives the line, and when it listens.
 *
 *   HIGH_Z --open--> LISTENING --talk--> TALKING --last byte given--> DRAINING
 *                        ^                                                |
 *                        +-------------------complete--------------------+
 *
 * The driver is released by "transmit complete", never by "transmit ready", and by time only if a
 * transmission does not end by its deadline: cds_link_abort(). The three events are called by the
 * port's interrupt handlers, which pass the number of the port as a constant, so that port verbs
 * inlined there act on constant addresses.
 *
 * Manual 2.1 (half duplex), 1.2.3 (the two enables).
 */
#ifndef CDS_LINK_H
#define CDS_LINK_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/packet.h" // CDS_HEADER
#include "cds55xx/port.h"   // the verbs
#include "cds55xx/ring.h"   // struct cds_ring

#ifdef __cplusplus
extern "C" {
#endif

/* As in the picture above. */
enum cds_link_state {
    CDS_LINK_HIGH_Z,
    CDS_LINK_LISTENING,
    CDS_LINK_TALKING,
    CDS_LINK_DRAINING
} __attribute__((packed));

/* Errors that the receiver reports for a byte: the port maps its status register to these. */
enum cds_line_error { CDS_LINE_FRAMING = 1, CDS_LINE_OVERRUN = 2 } __attribute__((packed));

/* What broke the stream of bytes first. Bit 0 is set if the stream is broken. */
enum cds_link_break {
    CDS_LINK_WHOLE = 0,
    CDS_LINK_DAMAGED = 1,
    CDS_LINK_FULL = 3
} __attribute__((packed));

/* What handlers and main context share of one bus. The ring last: an AVR reaches the first 64 bytes
 * of a struct in one instruction.
 *
 * Handlers count damage in 8 bits, for speed. The bus adds up what they have counted whenever it
 * finds the stream broken: 256 bytes lost or damaged between two of its polls count as none. */
struct cds_link {
    const uint8_t *volatile cursor; // next byte to be sent
    const uint8_t *volatile last;   // the packet's last byte
    const uint8_t *volatile echo;   // next byte to come back, where the receiver hears the driver
    volatile uint8_t state;         // enum cds_link_state
    volatile uint8_t broken;        // enum cds_link_break: since the bus last looked
    volatile uint8_t broken_at;  // position in the ring at which the first byte was damaged or lost
    volatile uint8_t whole_from; // position in the ring behind the last damaged or lost byte
    volatile uint8_t framing_errors; // bytes with a framing error and no overrun, modulo 256
    volatile uint8_t overruns;       // bytes with an overrun and no framing error, modulo 256
    volatile uint8_t both_errors;    // bytes with a framing error and an overrun, modulo 256
    volatile uint8_t ring_overflows; // Bytes dropped because the ring was full, modulo 256, except
                                     // each byte that sets `broken` to CDS_LINK_FULL: the bus
                                     // counts it in bus->ring_overflows.
    volatile uint16_t echo_errors;   // echo bytes that differ from the byte sent, modulo 65536;
                                     // read it with cds_link_count()
    struct cds_ring rx;              // bytes heard; the handlers put, the bus takes
};

/* Starts listening. Main context. */
void cds_link_open(struct cds_link *link, uint8_t port);

/* Turns the driver on and sends the header, before anything else is done. Returns how many bytes of
 * the header the transmitter has taken, 1 or 2. Main context; only while LISTENING, and followed by
 * cds_link_follow(). */
static inline uint8_t cds_link_begin(uint8_t port)
{
    return cds_port_talk(port, CDS_HEADER); // the receiver is off: no stale byte can follow
}

/* Sends the remaining bytes of the packet of `size` bytes (at least 3) at `packet`, of which
 * cds_link_begin() has sent `begun`. The packet must stay as it is until the link listens again.
 * What was received and not yet taken is thrown away. Main context. */
void cds_link_follow(struct cds_link *link, uint8_t port, const uint8_t *packet, uint16_t size,
                     uint8_t begun);

/* Sends the whole packet of `size` bytes (at least 3) at `packet`: calls cds_link_begin() and
 * cds_link_follow(). Main context. */
static inline void cds_link_talk(struct cds_link *link, uint8_t port, const uint8_t *packet,
                                 uint16_t size)
{
    cds_link_follow(link, port, packet, size, cds_link_begin(port));
}

/* Returns to LISTENING from any state: for a transmission that does not end. Main context. */
void cds_link_abort(struct cds_link *link, uint8_t port);

/* Reads a 16-bit counter that a handler may be changing. Main context. */
uint16_t cds_link_count(const volatile uint16_t *counter);

/* Notes where a damaged or lost byte broke the stream, and `why`: CDS_LINK_*. True if it was broken
 * already. From on_rx only. */
static inline bool cds_link_note_break(struct cds_link *link, uint8_t why)
{
    bool again = link->broken;

    if (!again) {
        link->broken = why;
        link->broken_at = link->rx.head;
    }
    link->whole_from = link->rx.head;
    return again;
}

/* Event, from the receive handler: a byte, and in `line_errors` what was wrong with it (CDS_LINE_*
 * bits, 0 if nothing). A damaged byte is counted and marked, not stored. */
static inline void cds_link_on_rx(struct cds_link *link, uint8_t byte, uint8_t line_errors)
{
    if (line_errors) {
        cds_link_note_break(link, CDS_LINK_DAMAGED);
        if (line_errors == CDS_LINE_FRAMING)
            link->framing_errors = (uint8_t)(link->framing_errors + 1);
        else if (line_errors == CDS_LINE_OVERRUN)
            link->overruns = (uint8_t)(link->overruns + 1);
        else
            link->both_errors = (uint8_t)(link->both_errors + 1);
        return;
    }
    if (!cds_ring_put(&link->rx, byte) && cds_link_note_break(link, CDS_LINK_FULL))
        link->ring_overflows = (uint8_t)(link->ring_overflows + 1);
}

/* Event, as cds_link_on_rx() and in its place where the receiver hears its own driver (tied pins,
 * an adapter with an echo): as many bytes as are sent are echo, compared and dropped. Counted
 * rather than timed: a reply without return delay may be here before the handler of "complete" has
 * run. */
static inline void cds_link_on_rx_echo(struct cds_link *link, uint8_t byte, uint8_t line_errors)
{
    const uint8_t *echo = link->echo;

    if (link->state == CDS_LINK_LISTENING || echo == link->last + 1) {
        cds_link_on_rx(link, byte, line_errors);
        return;
    }
    if (line_errors || byte != *echo)
        link->echo_errors = (uint16_t)(link->echo_errors + 1);
    link->echo = echo + 1;
}

/* Event, from the data-register-empty handler: the transmitter can take a byte. */
static inline void cds_link_on_tx_ready(struct cds_link *link, uint8_t port)
{
    const uint8_t *cursor = link->cursor;

    if (cursor == link->last) {
        cds_port_tx_last(port, *cursor);
        link->state = CDS_LINK_DRAINING;
        return;
    }
    cds_port_tx(port, *cursor);
    link->cursor = cursor + 1;
}

/* Event, from the transmit-complete handler: the last stop bit has left. */
static inline void cds_link_on_tx_complete(struct cds_link *link, uint8_t port)
{
    cds_port_listen(port);
    link->state = CDS_LINK_LISTENING;
}

#ifdef __cplusplus
}
#endif

#endif
