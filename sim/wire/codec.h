/* SPDX-License-Identifier: MIT */
/* Finds instruction packets in the bytes that a servo receives, and builds status packets. The
 * controller's library has its own codec. The two share no code, so an error in one does not hide
 * in the other. */
#ifndef SIM_CODEC_H
#define SIM_CODEC_H

#include <stddef.h>
#include <stdint.h>

#define CODEC_LENGTH_MIN 2   // instruction and checksum
#define CODEC_LENGTH_MAX 254 // R27
#define CODEC_PACKET_MAX (4 + CODEC_LENGTH_MAX)

/* The bytes from bytes[first] to bytes[size - 1] may still become a packet. */
struct codec {
    uint16_t first;
    uint16_t size;
    uint16_t before_pause; // bytes[0 ... before_pause - 1] came before the latest pause
    uint8_t bytes[CODEC_PACKET_MAX];
};

/* A view into the codec's bytes. It is valid until the next codec_put(). */
struct codec_packet {
    uint8_t id;
    uint8_t instruction;
    uint8_t count; // number of parameters
    const uint8_t *parameters;
    uint16_t size; // bytes of the whole packet with header and checksum
};

enum codec_event {
    CODEC_NOTHING, // no further packet ends in the bytes so far
    CODEC_PACKET,
    CODEC_DAMAGED, // complete, but the checksum is wrong; the bytes are searched again
};

/* Drops all bytes. Use it when a byte was lost or had a framing error. */
void codec_reset(struct codec *codec);

/* Marks a pause of the line after the bytes so far. A packet that stands inside a damaged packet
 * and ended before the pause is dropped. A packet that ends after the pause is found as usual. */
void codec_pause(struct codec *codec);

/* Adds one byte. Call codec_next() until it returns CODEC_NOTHING before the next codec_put():
 * several packets can stand inside a damaged packet, and codec_next() finds them at its end. */
void codec_put(struct codec *codec, uint8_t byte);
enum codec_event codec_next(struct codec *codec, struct codec_packet *packet);

/* Writes a status packet of 6 + count bytes. Returns its size. */
uint16_t codec_status(uint8_t *bytes, uint8_t id, uint8_t error, const uint8_t *parameters,
                      uint8_t count);

#endif
