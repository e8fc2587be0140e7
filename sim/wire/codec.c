/* SPDX-License-Identifier: MIT */
#include "wire/codec.h"

#include <stdbool.h>
#include <string.h>

enum {
    HEADER = 0xFF,
    OFFSET_ID = 2,
    OFFSET_LENGTH = 3,
    OFFSET_INSTRUCTION = 4,
    OFFSET_PARAMETERS = 5
};

static uint8_t sum(const uint8_t *bytes, size_t count)
{
    unsigned total = 0;
    while (count--) {
        total += *bytes++;
    }
    return (uint8_t)total;
}

/* R27: an ID is never 0xFF. Any number of 0xFF before an ID is therefore one header. */
static bool may_be_packet(const uint8_t *bytes, size_t count)
{
    return bytes[0] == HEADER && (count <= 1 || bytes[1] == HEADER) &&
           (count <= OFFSET_ID || bytes[OFFSET_ID] != HEADER) &&
           (count <= OFFSET_LENGTH ||
            (bytes[OFFSET_LENGTH] >= CODEC_LENGTH_MIN && bytes[OFFSET_LENGTH] <= CODEC_LENGTH_MAX));
}

void codec_reset(struct codec *codec)
{
    codec->first = 0;
    codec->size = 0;
    codec->before_pause = 0;
}

void codec_pause(struct codec *codec)
{
    codec->before_pause = codec->size;
}

void codec_put(struct codec *codec, uint8_t byte)
{
    if (codec->first > 0) {
        codec->size = (uint16_t)(codec->size - codec->first);
        memmove(codec->bytes, codec->bytes + codec->first, codec->size);
        codec->before_pause =
            codec->before_pause > codec->first ? (uint16_t)(codec->before_pause - codec->first) : 0;
        codec->first = 0;
    }
    codec->bytes[codec->size++] = byte;
}

enum codec_event codec_next(struct codec *codec, struct codec_packet *packet)
{
    for (; codec->first < codec->size; codec->first++) {
        const uint8_t *bytes = codec->bytes + codec->first;
        size_t received = (size_t)(codec->size - codec->first);
        if (!may_be_packet(bytes, received)) {
            continue;
        }
        if (received <= OFFSET_LENGTH ||
            received < OFFSET_INSTRUCTION + (size_t)bytes[OFFSET_LENGTH]) {
            return CODEC_NOTHING;
        }
        if (codec->first + OFFSET_INSTRUCTION + bytes[OFFSET_LENGTH] <= codec->before_pause) {
            continue;
        }
        packet->id = bytes[OFFSET_ID];
        packet->instruction = bytes[OFFSET_INSTRUCTION];
        packet->count = (uint8_t)(bytes[OFFSET_LENGTH] - CODEC_LENGTH_MIN);
        packet->parameters = bytes + OFFSET_PARAMETERS;
        packet->size = (uint16_t)(OFFSET_INSTRUCTION + bytes[OFFSET_LENGTH]);
        /* The checksum is the complement of the sum of ID, LENGTH, instruction and parameters.
         * Their sum with the checksum is 0xFF. */
        if (sum(bytes + OFFSET_ID, packet->size - (size_t)OFFSET_ID) == 0xFF) {
            codec->first = (uint16_t)(codec->first + packet->size);
            return CODEC_PACKET;
        }
        codec->first++;
        return CODEC_DAMAGED;
    }
    return CODEC_NOTHING;
}

uint16_t codec_status(uint8_t *bytes, uint8_t id, uint8_t error, const uint8_t *parameters,
                      uint8_t count)
{
    bytes[0] = HEADER;
    bytes[1] = HEADER;
    bytes[OFFSET_ID] = id;
    bytes[OFFSET_LENGTH] = (uint8_t)(count + CODEC_LENGTH_MIN);
    bytes[OFFSET_INSTRUCTION] = error;
    if (count > 0) {
        memcpy(bytes + OFFSET_PARAMETERS, parameters, count);
    }
    bytes[OFFSET_PARAMETERS + count] = (uint8_t)~sum(bytes + OFFSET_ID, 3u + count);
    return (uint16_t)(OFFSET_PARAMETERS + count + 1);
}
