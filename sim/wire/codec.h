/* Framing on the servo's side: finding instruction packets in what the receiver heard, and building
 * status packets. The controller's library has a codec of its own; the two share no line.
 */
#ifndef SIM_CODEC_H
#define SIM_CODEC_H

#include <stddef.h>
#include <stdint.h>

#define CODEC_LENGTH_MIN 2   // instruction and checksum
#define CODEC_LENGTH_MAX 254 // R27
#define CODEC_PACKET_MAX (4 + CODEC_LENGTH_MAX)

/* What may still become a packet: bytes[first] up to bytes[size]. */
struct codec {
    uint16_t first;
    uint16_t size;
    uint16_t before_pause; // bytes[0 ... before_pause - 1] were heard before the latest pause
    uint8_t bytes[CODEC_PACKET_MAX];
};

/* A view into the codec's bytes, valid until the next codec_put(). */
struct codec_packet {
    uint8_t id;
    uint8_t instruction;
    uint8_t count; // of parameters
    const uint8_t *parameters;
    uint16_t size; // of the whole packet, header and checksum included
};

enum codec_event {
    CODEC_NOTHING, // no further packet ends in what was heard so far
    CODEC_PACKET,
    CODEC_DAMAGED, // complete, but the checksum is wrong; its bytes are searched again
};

/* Forgets what was heard: a byte was lost or came with a framing error. */
void codec_reset(struct codec *codec);

/* The line paused behind the bytes heard so far. A packet that stands inside a damaged one and
 * ended before the pause is dropped. A packet that ends behind the pause is found as usual. */
void codec_pause(struct codec *codec);

/* Takes one byte. Call codec_next() until it returns CODEC_NOTHING before the next byte: the end of
 * a damaged packet can bring several packets to light that stood inside it. */
void codec_put(struct codec *codec, uint8_t byte);
enum codec_event codec_next(struct codec *codec, struct codec_packet *packet);

/* Writes a status packet of 6 + count bytes; returns its size. */
uint16_t codec_status(uint8_t *bytes, uint8_t id, uint8_t error, const uint8_t *parameters,
                      uint8_t count);

#endif
