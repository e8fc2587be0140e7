/* Takes the host link apart: protocol packets and text, which alternate as they like.
 *
 * A byte 0xFF outside a packet begins a packet and drops the line that was being typed. Every other
 * byte outside a packet is text. A packet is damaged if it has no second 0xFF, a bad LENGTH, a bad
 * checksum, or if the host is silent for HOST_SILENCE_US before its end. A damaged packet is not
 * passed on: its ID may not be the one that was meant. The bytes of a damaged packet are searched
 * again; a good packet among them is passed on unless it is older than HOST_SILENCE_US, since the
 * client has given up waiting for the reply by then. For the same reason a packet that the bridge
 * cannot take in that time is dropped.
 *
 * A Ctrl-X (0x18) in a damaged packet is a stop. A Ctrl-X inside a good packet is none, also if the
 * packet is dropped as late. A packet that waits for the bridge is dropped too when a Ctrl-X comes
 * behind it. docs/bridge.md has the rules for text. Manual: 2.2; ruling R27. Main context. */
#ifndef CONTROLLER_HOST_DEMUX_H
#define CONTROLLER_HOST_DEMUX_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/packet.h" // CDS_LENGTH_MAX
#include "cds55xx/ring.h"   // struct cds_ring

#define HOST_PACKET_MAX (CDS_LENGTH_MAX + 4) // bytes

/* Less than clients wait for a reply if nobody shortened it: DynamixelSDK waits 34 ms or more. */
#define HOST_SILENCE_US 15000

/* Bytes in the ring of text that the host cannot have said: where they stand, the line so far is
 * gone, because a packet began; or because something was lost, which has to be answered. */
enum host_mark { HOST_MARK_DROPPED = 0xF8, HOST_MARK_LOST = 0xF9 } __attribute__((packed));

/* Counted modulo 65536. */
struct host_demux_counters {
    uint16_t packets;   // whole ones
    uint16_t malformed; // dropped: LENGTH or checksum
    uint16_t silent;    // dropped: the host was silent before the end
    uint16_t gaps;      // where something was lost, before or behind the rings
    uint16_t late;      // good packets dropped: the client has given up waiting
    uint16_t stops;     // Ctrl-X found in damaged packets and behind them in the line
};

/* All state of the link. Zero it (static storage is), then host_demux_open(). */
struct host_demux {
    struct cds_ring *input; // from the host
    struct cds_ring *text;  // for the console
    uint8_t *bytes;         // HOST_PACKET_MAX of them
    uint16_t from, count;   // what is or may become a packet stands at from ... count - 1,
    uint16_t seen;          // and this is the next of these bytes to be examined
    uint16_t end;           // where the packet will end, 0 until its LENGTH is known
    uint8_t sum;            // of the bytes from the ID on
    uint8_t head;           // of the input ring when it was last looked at
    uint8_t old;            // bytes in the input ring that came too long ago for a packet
    uint32_t heard_us;      // when the input ring last had a new byte
    uint32_t begun_us;      // when the first of the bytes was taken
    uint32_t whole_us;      // when the packet was whole
    bool stale;             // the host was silent since: packets in the bytes are dropped
    bool late;              // the first of the bytes was among the old ones: likewise
    bool searched_again;    // the bytes stand behind the beginning of a damaged packet
    bool whole;             // a packet stands there; only text is taken until host_demux_take()
    bool typing;            // the text so far ends within a line
    bool suspect;           // ... which may be the rest of a packet that was broken
    bool lost;              // a gap was met; HOST_MARK_LOST is due
    bool skipping;          // ... and what follows is dropped
    bool stop;              // Ctrl-X came, wherever the text is now; the caller clears it
    struct host_demux_counters counters;
};

/* `bytes`: HOST_PACKET_MAX of them. */
void host_demux_open(struct host_demux *demux, struct cds_ring *input, struct cds_ring *text,
                     uint8_t *bytes);

/* Looks at what came, some bytes at a time; demux->whole says whether there is a packet. True: one
 * is coming in, without a pause so far. */
bool host_demux_poll(struct host_demux *demux);

/* There is a gap behind all that was taken. */
void host_demux_gap(struct host_demux *demux);

/* Hands over the packet, only while demux->whole: it is the first bytes of the buffer returned, of
 * the size that its LENGTH says. `other`, a buffer of HOST_PACKET_MAX, takes the place of it. */
uint8_t *host_demux_take(struct host_demux *demux, uint8_t *other);

/* Nothing to do before more comes? Then no packet has begun either. */
bool host_demux_idle(const struct host_demux *demux);

#endif
