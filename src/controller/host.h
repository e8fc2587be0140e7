/* The host link taken apart: protocol packets and text, which alternate as they like.
 *
 * A byte 0xFF outside a packet begins one, for it is never part of text, and drops the line that
 * was being typed. All else outside a packet is text. What looked like a packet and is none (no
 * second 0xFF, LENGTH, checksum, or silence for HOST_SILENCE_US before its end) is dropped, but a
 * packet that begins within it is found, and half a line behind it that goes on no more within that
 * time is taken for the rest of it. Behind a gap in what came, all is dropped up to the end of
 * the line, the next 0xFF or that silence; only then the loss is told.
 *
 * A packet with a bad checksum is dropped, not passed on: the ID it has may not be the one that was
 * meant, and a servo may be set to switch its torque off when such a one reaches it.
 *
 * Manual: 2.2; ruling R27. Main context.
 */
#ifndef CONTROLLER_HOST_H
#define CONTROLLER_HOST_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/packet.h" // CDS_LENGTH_MAX
#include "cds55xx/ring.h"   // struct cds_ring

#define HOST_PACKET_MAX (CDS_LENGTH_MAX + 4) // bytes
#define HOST_SILENCE_US 50000

/* Bytes in the ring of text that the host cannot have said: where they stand, the line so far is
 * gone, because a packet began; or because something was lost, which has to be answered. */
enum host_mark { HOST_MARK_DROPPED = 0xF8, HOST_MARK_LOST = 0xF9 };

/* Counted modulo 65536. */
struct host_counters {
    uint16_t packets; // whole ones
    uint16_t broken;  // dropped: LENGTH or checksum
    uint16_t silent;  // ... not ended in time
    uint16_t gaps;    // where something was lost, before or behind the rings
};

/* All state of the link. Zero it (static storage is), then host_open(). */
struct host {
    struct cds_ring *input; // from the host
    struct cds_ring *text;  // for the console
    uint8_t *bytes;         // HOST_PACKET_MAX of them
    uint16_t from, count;   // what is or may become a packet stands at from ... count - 1,
    uint16_t seen;          // and this is the next of these bytes to be examined
    uint16_t end;           // where the packet will end, 0 until its LENGTH is known
    uint8_t sum;            // of the bytes from the ID on
    uint32_t heard_us;      // when the last byte was taken
    bool stale;             // ... too long ago for what has begun
    bool whole;             // a packet stands there; only text is taken until host_take()
    bool typing;            // the text so far ends within a line
    bool suspect;           // ... which may be the rest of a packet that was broken
    bool lost;              // a gap was met; HOST_MARK_LOST is due
    bool skipping;          // ... and what follows is dropped
    bool stop;              // Ctrl-X was typed, wherever the text is now; who has seen to it clears
    struct host_counters counters;
};

/* `bytes`: HOST_PACKET_MAX of them. */
void host_open(struct host *host, struct cds_ring *input, struct cds_ring *text, uint8_t *bytes);

/* Looks at what came, some bytes at a time; host->whole says whether there is a packet. True: one
 * is coming in, without a pause so far. */
bool host_poll(struct host *host);

/* There is a gap behind all that was taken. */
void host_gap(struct host *host);

/* Hands over the packet, only while host->whole: it is the first bytes of the buffer returned, of
 * the size that its LENGTH says. `other`, a buffer of HOST_PACKET_MAX, takes the place of it. */
uint8_t *host_take(struct host *host, uint8_t *other);

/* Nothing to do before more comes? Then no packet has begun either. */
bool host_idle(const struct host *host);

#endif
