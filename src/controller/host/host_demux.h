/* Separates the bytes of the host into protocol packets and text, in any order.
 *
 * A byte 0xFF outside a packet begins a packet and drops the line that was being typed. Every other
 * byte outside a packet is text. A packet is damaged if it has no second 0xFF, a wrong LENGTH, a
 * wrong checksum, or if the host is silent for HOST_SILENCE_US before its end. The demux drops a
 * damaged packet, since its ID may be wrong, and searches its bytes again. A good packet among them
 * is passed on unless it is older than HOST_SILENCE_US: by then the client has given up waiting for
 * the reply. A packet that waits that long for the bridge is dropped, too.
 *
 * Ctrl-X (0x18) in a damaged packet is a stop; inside a good packet it is data, even if that packet
 * is dropped as late. Ctrl-X after a packet that waits for the bridge drops that packet.
 * docs/bridge.md has the rules for text. Manual: 2.2; ruling R27. Main context. */
#ifndef CONTROLLER_HOST_DEMUX_H
#define CONTROLLER_HOST_DEMUX_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/packet.h" // CDS_LENGTH_MAX
#include "cds55xx/ring.h"   // struct cds_ring

#define HOST_PACKET_MAX (CDS_LENGTH_MAX + 4) // bytes

/* Less than a client waits for a reply by default: DynamixelSDK waits 34 ms or more. */
#define HOST_SILENCE_US 15000

/* Marks that the demux puts into the ring of text; it never passes on these bytes from the host.
 * Either mark ends the line before it. DROPPED: a packet began. LOST: bytes were lost, and the
 * console answers with an error. */
enum host_mark { HOST_MARK_DROPPED = 0xF8, HOST_MARK_LOST = 0xF9 } __attribute__((packed));

/* Each counts modulo 65536. */
struct host_demux_counters {
    uint16_t packets;   // good packets passed on
    uint16_t malformed; // packets dropped: wrong LENGTH or checksum
    uint16_t silent;    // packets dropped: the host was silent before their end
    uint16_t gaps;      // times that bytes were lost, before or after the rings
    uint16_t late;      // good packets dropped: older than HOST_SILENCE_US
    uint16_t stops;     // Ctrl-X found in damaged packets and in the rest of their line
};

/* All state of the link. Zero it (static storage is), then host_demux_open(). */
struct host_demux {
    struct cds_ring *input; // from the host
    struct cds_ring *text;  // for the console
    uint8_t *bytes;         // HOST_PACKET_MAX bytes
    uint16_t from;          // where in `bytes` a packet begins, or may begin
    uint16_t count;         // end of the bytes that are there
    uint16_t seen;          // the next byte to be examined
    uint16_t end;           // end of the packet, 0 until its LENGTH is known
    uint8_t sum;            // of the bytes from the ID on
    uint8_t head;           // of the input ring at the last poll
    uint8_t old;            // bytes in the input ring that are too old for a packet
    uint32_t heard_us;      // when the input ring last had a new byte
    uint32_t begun_us;      // when the first byte in `bytes` was taken
    uint32_t whole_us;      // when the packet was whole
    bool stale;             // the host was silent since then: packets in `bytes` are dropped
    bool late;              // the first byte in `bytes` was too old: its packet is dropped
    bool searched_again;    // `from` stands behind the beginning of a damaged packet
    bool whole;             // a good packet stands at `from`; only text is taken until it is
    bool typing;            // the text so far ends within a line
    bool suspect;           // the text so far may be the rest of a damaged packet
    bool lost;              // bytes were lost; HOST_MARK_LOST is due
    bool skipping;          // bytes were lost; text is dropped up to the end of the line
    bool stop;              // Ctrl-X came, wherever the text stands now; the caller clears it
    struct host_demux_counters counters;
};

/* `bytes`: a buffer of HOST_PACKET_MAX bytes. */
void host_demux_open(struct host_demux *demux, struct cds_ring *input, struct cds_ring *text,
                     uint8_t *bytes);

/* Takes some of the bytes that came; demux->whole tells if a packet is ready. Returns true if it
 * has taken bytes and a packet is coming in: poll again soon. */
bool host_demux_poll(struct host_demux *demux);

/* Bytes were lost after the last byte that was taken. */
void host_demux_gap(struct host_demux *demux);

/* Hands over the packet; call it only if demux->whole. The packet stands at the beginning of the
 * buffer returned, and its LENGTH tells its size. `other`, a buffer of HOST_PACKET_MAX bytes,
 * replaces that buffer. */
uint8_t *host_demux_take(struct host_demux *demux, uint8_t *other);

/* True if there is nothing to do until the next byte comes, and no packet has begun. */
bool host_demux_idle(const struct host_demux *demux);

#endif
