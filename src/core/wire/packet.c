/* SPDX-License-Identifier: MIT */
/* Building instruction packets; see packet.h. */
#include "cds55xx/packet.h"

#include <stdbool.h>
#include <stddef.h>

#include "compiler.h"             // NOINLINE
#include "wire/packet_internal.h" // cds_packet_append()

#define LENGTH_OFFSET 4u // LENGTH counts what follows it: packet size less four

#define BUILDING     (CDS_PACKET_BUILDING + CDS_AT_PARAMETERS) // `size`: all but parameters was put
#define LOW_BYTE_LAG 2u // the bytes put are the low byte of `size` plus 2

/* While a packet grows, the sum of its other bytes from the ID on stands in the place of LENGTH: so
 * its end costs the same however long it is. */

NOINLINE void cds_packet_refuse(struct cds_packet *packet)
{
    packet->size |= CDS_PACKET_REFUSED;
}

static inline void add(uint8_t *bytes, uint16_t at, const uint8_t *data, uint8_t count)
{
    uint8_t sum = 0, *to = bytes + at;

    if (!count)
        return; // a packet was begun, to see whether there is room
    do {
        uint8_t byte = *data++;

        sum = (uint8_t)(sum + byte);
        *to++ = byte;
    } while (--count);
    bytes[CDS_AT_LENGTH] = (uint8_t)(bytes[CDS_AT_LENGTH] + sum);
}

NOINLINE uint8_t *cds_packet_append(struct cds_packet *packet, const uint8_t *data, uint8_t count)
{
    uint16_t size, end;
    uint8_t *bytes;

    OPTIMIZER_BARRIER(packet);
    size = packet->size;
    if (cds_packet_is_building(packet)) { // else it was ended, never begun, or refused
        end = (uint16_t)(size + count);
        if (!(end & 0x100) && end < (uint16_t)(packet->capacity + CDS_PACKET_BUILDING)) {
            packet->size = end;
            bytes = packet->bytes;
            add(bytes, (uint16_t)(size - CDS_PACKET_BUILDING), data, count);
            return bytes;
        }
        size |= CDS_PACKET_NO_ROOM;
    }
    packet->size = size | CDS_PACKET_REFUSED;
    return NULL;
}

void cds_packet_put(struct cds_packet *packet, uint8_t byte)
{
    cds_packet_append(packet, &byte, 1);
}

void cds_packet_put_word(struct cds_packet *packet, uint16_t word)
{
    cds_packet_put(packet, (uint8_t)word);
    cds_packet_put(packet, (uint8_t)(word >> 8));
}

/* Writes the bytes before the parameters. Returns where the parameters begin. */
static inline uint8_t *put_head(uint8_t *bytes, uint8_t id, uint8_t length, uint8_t instruction)
{
    *bytes++ = CDS_HEADER;
    *bytes++ = CDS_HEADER;
    *bytes++ = id;
    *bytes++ = length;
    *bytes++ = instruction;
    return bytes;
}

void cds_packet_start(struct cds_packet *packet, const uint8_t *data, uint8_t count, uint8_t id,
                      uint8_t instruction)
{
    uint16_t size = BUILDING;

    if (packet->capacity >= CDS_PACKET_SIZE(0))
        put_head(packet->bytes, id, (uint8_t)(id + instruction), instruction);
    OPTIMIZER_BARRIER(size); // or gcc loads both bytes again
    if (id == CDS_NO_ID)
        size |= CDS_PACKET_REFUSED;
    packet->size = size;
    cds_packet_append(packet, data, count); // or finds that there is no room
}

void cds_packet_begin(struct cds_packet *packet, uint8_t id, uint8_t instruction)
{
    cds_packet_start(packet, NULL, 0, id, instruction);
}

uint8_t cds_packet_checksum(const uint8_t *bytes)
{
    uint8_t left = (uint8_t)(bytes[CDS_AT_LENGTH] + 1u), sum = 0;

    bytes += CDS_AT_ID;
    do {
        sum = (uint8_t)(sum + *bytes++);
    } while (--left);
    return (uint8_t)~sum;
}

static inline void close(struct cds_packet *packet)
{
    uint8_t *bytes = packet->bytes, at = (uint8_t)packet->size;
    uint8_t length = (uint8_t)(at + LOW_BYTE_LAG + 1 - LENGTH_OFFSET);
    uint8_t sum = (uint8_t)(bytes[CDS_AT_LENGTH] + length);

    packet->size = (uint16_t)(at + LOW_BYTE_LAG + 1);
    bytes[CDS_AT_LENGTH] = length;
    bytes[at + LOW_BYTE_LAG] = (uint8_t)~sum;
}

enum cds_result cds_packet_end(struct cds_packet *packet)
{
    uint16_t size = packet->size;

    if (cds_packet_is_building(packet)) { // all was judged when it was put
        close(packet);
        return CDS_OK;
    }
    if (size & CDS_PACKET_NO_ROOM & ~CDS_PACKET_REFUSED)
        return CDS_NO_ROOM;
    if ((int16_t)size >= (int16_t)LENGTH_OFFSET &&
        packet->bytes[CDS_AT_LENGTH] == (uint8_t)(size - LENGTH_OFFSET))
        return CDS_OK; // it was ended before
    return CDS_BAD_ARGUMENT;
}

static enum cds_result bare(struct cds_packet *packet, uint8_t id, uint8_t instruction)
{
    cds_packet_begin(packet, id, instruction);
    return cds_packet_end(packet);
}

enum cds_result cds_packet_ping(struct cds_packet *packet, uint8_t id)
{
    return bare(packet, id, CDS_PING);
}

enum cds_result cds_packet_action(struct cds_packet *packet, uint8_t id)
{
    return bare(packet, id, CDS_ACTION);
}

enum cds_result cds_packet_reset(struct cds_packet *packet, uint8_t id)
{
    return bare(packet, id, CDS_RESET);
}

/* The packet that is sent most is built at once. */
enum cds_result cds_packet_read(struct cds_packet *packet, uint8_t id, uint8_t address,
                                uint8_t length)
{
    uint8_t *to;

    if (!cds_packet_is_length(length) || !cds_packet_is_within(address, length) || id > CDS_ID_MAX)
        return CDS_BAD_ARGUMENT;
    if (packet->capacity < CDS_PACKET_SIZE(2))
        return CDS_NO_ROOM;
    packet->size = CDS_PACKET_SIZE(2);
    to = put_head(packet->bytes, id, CDS_LENGTH_MIN + 2, CDS_READ);
    *to++ = address;
    *to++ = length;
    *to = (uint8_t) ~(id + CDS_LENGTH_MIN + 2 + CDS_READ + address + length);
    return CDS_OK;
}

void cds_packet_begin_write(struct cds_packet *packet, uint8_t id, uint8_t instruction,
                            uint8_t address, const uint8_t *data, uint8_t length)
{
    if (!cds_packet_is_length(length) || !cds_packet_is_within(address, length))
        id = cds_packet_refused_id(packet, id);
    cds_packet_start(packet, &address, 1, id, instruction);
    cds_packet_append(packet, data, length);
}

enum cds_result cds_packet_write(struct cds_packet *packet, uint8_t id, uint8_t address,
                                 const uint8_t *data, uint8_t length)
{
    cds_packet_begin_write(packet, id, CDS_WRITE, address, data, length);
    return cds_packet_end(packet);
}

enum cds_result cds_packet_reg_write(struct cds_packet *packet, uint8_t id, uint8_t address,
                                     const uint8_t *data, uint8_t length)
{
    cds_packet_begin_write(packet, id, CDS_REG_WRITE, address, data, length);
    return cds_packet_end(packet);
}

enum cds_result cds_packet_sync_begin(struct cds_packet *packet, uint8_t address, uint8_t length)
{
    uint8_t where[2] = {address, length};
    enum cds_result result = CDS_OK;
    uint8_t id = CDS_BROADCAST_ID;

    if (!cds_packet_is_length(length) || !cds_packet_is_within(address, length)) {
        id = cds_packet_refused_id(packet, id);
        result = CDS_BAD_ARGUMENT;
    }
    cds_packet_start(packet, where, 2, id, CDS_SYNC_WRITE);
    return result;
}

void cds_packet_sync_add(struct cds_packet *packet, uint8_t id, const uint8_t *data)
{
    // no length stands in the buffer where nothing was begun, or was refused
    bool begun = (int16_t)packet->size > (int16_t)CDS_PACKET_BUILDING + CDS_AT_SYNC_LENGTH;

    if (id > CDS_ID_MAX || !begun) {
        cds_packet_refuse(packet);
        return;
    }
    cds_packet_append(packet, &id, 1);
    cds_packet_append(packet, data, packet->bytes[CDS_AT_SYNC_LENGTH]);
}
