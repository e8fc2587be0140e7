/* SPDX-License-Identifier: MIT */
/* Separates the bytes of the host into protocol packets and text, in any order.
 *
 * Two bytes 0xFF outside a packet begin a packet and drop the unfinished line of text. One 0xFF in
 * a line drops this line up to its end. One 0xFF is ignored before a line, or if HOST_SILENCE_US of
 * silence follow. Every other byte outside a packet is text. A packet is damaged if it has a wrong
 * LENGTH or a wrong checksum, or if the host is silent for HOST_SILENCE_US before its end. The
 * demux drops a damaged packet, since its ID may be wrong, and searches its bytes for another
 * packet. A good packet there is passed on, unless it is HOST_SILENCE_US old: the client has then
 * given up waiting for the reply. A packet that waits that long for the bridge is dropped, too.
 *
 * Ctrl-X (0x18) in text or in a damaged packet is a stop. In a good packet it is data, even if the
 * packet is dropped as late. If Ctrl-X comes after packets that wait for the bridge, they are
 * dropped: one of them may be a release. Rules for text: docs/bridge.md. Manual: 2.2; R27. Main
 * context. */
#ifndef CONTROLLER_HOST_DEMUX_H
#define CONTROLLER_HOST_DEMUX_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/packet.h" // CDS_LENGTH_MAX
#include "cds55xx/ring.h"   // struct cds_ring

#define HOST_PACKET_MAX (CDS_LENGTH_MAX + 4) // bytes

/* Shorter than the time that a client waits for a reply: DynamixelSDK waits 34 ms or more. */
#define HOST_SILENCE_US 15000

/* Marks that the demux puts into the ring of text. The demux drops such bytes if the host sends
 * them. Each mark ends the line before it. DROPPED: 0xFF came in the line. LOST: bytes were lost,
 * and the console answers with an error. */
enum host_mark { HOST_MARK_DROPPED = 0xF8, HOST_MARK_LOST = 0xF9 } __attribute__((packed));

/* Each counts modulo 65536. */
struct host_demux_counters {
    uint16_t packets;   // good packets passed on
    uint16_t malformed; // packets dropped: wrong LENGTH or checksum
    uint16_t silent;    // packets dropped: the host was silent before their end
    uint16_t gaps;      // times that bytes were lost: in the receiver, or because a ring was full
    uint16_t late;      // good packets dropped: too old, or a Ctrl-X or a gap came after them
    uint16_t stops;     // Ctrl-X found in damaged packets and in the text after them, up to the
                        // end of the line
};

/* State of the demux. Zero it (static storage is), then host_demux_open(). */
struct host_demux {
    struct cds_ring *input; // from the host
    struct cds_ring *text;  // for the console
    uint8_t *bytes;         // HOST_PACKET_MAX bytes
    uint16_t from;          // index in `bytes` at which a packet begins, or may begin
    uint16_t count;         // number of bytes in `bytes`
    uint16_t seen;          // index of the next byte to examine
    uint16_t end;           // index behind the packet; 0: its LENGTH is not known yet
    uint8_t sum;            // sum of the packet's bytes, from the ID on
    uint8_t head;           // head of the input ring at the last poll
    uint8_t searched;       // position in the input ring up to which there is no Ctrl-X, while a
                            // packet waits for the bridge
    uint8_t old;            // number of bytes in the input ring that are too old for a packet: they
                            // came while a packet waited HOST_SILENCE_US for the bridge
    uint32_t heard_us;      // time of the newest byte in the input ring
    uint32_t begun_us;      // time at which the first byte in `bytes` was taken
    uint32_t packet_us;     // time at which the packet of `has_packet` was complete
    bool is_cut_off;        // after the newest byte in `bytes` the host was silent for
                            // HOST_SILENCE_US, or bytes were lost: packets in `bytes` are dropped
    bool late;              // the first byte in `bytes` was one of the `old` bytes: the packet that
                            // begins there is dropped
    bool searched_again; // the search goes on within a damaged packet: `from` is behind its begin
    bool has_packet;     // a good packet stands at `from` and waits for host_demux_take();
                         // meanwhile only text after it is taken
    bool typing;         // the last line of text has no end yet
    bool suspect;        // a packet was malformed: the text after it may belong to it
    bool lost;           // bytes were lost: HOST_MARK_LOST is still to be put into the text
    bool skipping;       // bytes were lost, or one 0xFF came: text is dropped up to the end of the
                         // line
    bool stop;           // Ctrl-X has come; the caller stops the robot and clears it
    struct host_demux_counters counters;
};

/* Opens the demux. `input`: bytes of the host; `text`: where the text goes; `bytes`: a buffer of
 * HOST_PACKET_MAX bytes. */
void host_demux_open(struct host_demux *demux, struct cds_ring *input, struct cds_ring *text,
                     uint8_t *bytes);

/* Takes some bytes from the input ring. demux->has_packet is true if a packet is ready. Returns
 * true if it has taken bytes of a packet that is still coming in, or text for which its ring has
 * room: poll again soon. */
bool host_demux_poll(struct host_demux *demux);

/* Notes that bytes were lost after the last byte that the demux has taken. */
void host_demux_gap(struct host_demux *demux);

/* Hands over the packet; call it only if demux->has_packet. Returns the buffer, at whose beginning
 * the packet stands; LENGTH of the packet tells its size. `other`, a buffer of HOST_PACKET_MAX
 * bytes, becomes the buffer of the demux. */
uint8_t *host_demux_take(struct host_demux *demux, uint8_t *other);

/* True if HOST_SILENCE_US have passed since `from_us`, at most 35 min ago. */
bool host_is_late(uint32_t from_us);

/* True if there is nothing to do until the next byte comes, and no packet has begun. */
bool host_demux_idle(const struct host_demux *demux);

#endif
