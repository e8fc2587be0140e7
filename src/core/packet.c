/* Building instruction packets; see packet.h. */
#include "cds55xx/packet.h"

#include <stdbool.h>
#include <stddef.h>

#include "cds55xx/control_table.h" // CDS_TABLE_SIZE
#include "opaque.h"                // CDS_OPAQUE()

#define LENGTH_OFFSET 4u // LENGTH counts what follows it: packet size less four
#define GROWN_MAX     (CDS_PACKET_GROWS + LENGTH_OFFSET + CDS_LENGTH_MAX - 1) // `size`
#define NO_ADDRESS    UINT8_MAX

/* Not copied for a packet that is known when the program is linked: see opaque.h. */
#define ONE_COPY __attribute__((noclone, noinline))

/* While a packet grows, the sum of its other bytes from the ID on stands in the place of LENGTH: so
 * its end costs the same however long it is. */

/* An argument is wrong. Where something was wrong before, that is the reason. */
static inline void refuse(struct cds_packet *packet)
{
    packet->size =
        cds_packet_grows_(packet) ? CDS_PACKET_REFUSED : packet->size | CDS_PACKET_REFUSED;
}

static inline void add(uint8_t *bytes, uint16_t at, const uint8_t *data, uint8_t count)
{
    uint8_t sum = bytes[CDS_AT_LENGTH], *to = bytes + at;

    do {
        uint8_t byte = *data++;

        sum = (uint8_t)(sum + byte);
        *to++ = byte;
    } while (--count);
    bytes[CDS_AT_LENGTH] = sum;
}

ONE_COPY void cds_packet_append_(struct cds_packet *packet, const uint8_t *data, uint8_t count)
{
    uint16_t size = packet->size, end = (uint16_t)(size + count);

    if (!(size & CDS_PACKET_GROWS)) { // it was ended, never begun, or refused
        packet->size = size | CDS_PACKET_REFUSED;
    } else if (end >= (uint16_t)(packet->room + CDS_PACKET_GROWS) || end > GROWN_MAX) {
        packet->size = CDS_PACKET_NO_ROOM;
    } else {
        packet->size = end;
        add(packet->bytes, (uint16_t)(size - CDS_PACKET_GROWS), data, count);
    }
}

void cds_packet_put(struct cds_packet *packet, uint8_t byte)
{
    cds_packet_append_(packet, &byte, 1);
}

void cds_packet_put_word(struct cds_packet *packet, uint16_t word)
{
    cds_packet_put(packet, (uint8_t)word);
    cds_packet_put(packet, (uint8_t)(word >> 8));
}

/* What stands before the parameters; returns where they belong. */
static inline uint8_t *put_head(uint8_t *bytes, uint8_t id, uint8_t length, uint8_t instruction)
{
    *bytes++ = CDS_HEADER;
    *bytes++ = CDS_HEADER;
    *bytes++ = id;
    *bytes++ = length;
    *bytes++ = instruction;
    return bytes;
}

/* With the first parameter, which is an address, or NO_ADDRESS. */
ONE_COPY static void begin_at(struct cds_packet *packet, uint8_t id, uint8_t instruction,
                              uint8_t address)
{
    uint16_t size = CDS_PACKET_GROWS + CDS_AT_PARAMETERS + 1;

    if (address == NO_ADDRESS) {
        size--;
        address = 0; // nothing to the sum
    }
    if (id > CDS_BROADCAST_ID)
        size = CDS_PACKET_REFUSED;
    else if (packet->room < CDS_PACKET_SIZE(0))
        size = CDS_PACKET_NO_ROOM;
    packet->size = size;
    if (size & CDS_PACKET_GROWS)
        *put_head(packet->bytes, id, (uint8_t)(id + instruction + address), instruction) = address;
}

void cds_packet_begin(struct cds_packet *packet, uint8_t id, uint8_t instruction)
{
    begin_at(packet, id, instruction, NO_ADDRESS);
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

void cds_packet_close_(struct cds_packet *packet)
{
    uint16_t size = packet->size;
    uint8_t length = (uint8_t)(size + 1u - LENGTH_OFFSET), sum;
    uint8_t *bytes;

    packet->size = (uint16_t)(size + 1u - CDS_PACKET_GROWS);
    bytes = packet->bytes;
    sum = (uint8_t)(bytes[CDS_AT_LENGTH] + length);
    bytes[CDS_AT_LENGTH] = length;
    bytes[(uint16_t)(size - CDS_PACKET_GROWS)] = (uint8_t)~sum;
}

enum cds_result cds_packet_end(struct cds_packet *packet)
{
    uint16_t size = packet->size;

    if (cds_packet_grows_(packet)) { // all was judged when it was put
        cds_packet_close_(packet);
        return CDS_OK;
    }
    if (size >= CDS_PACKET_NO_ROOM)
        return CDS_NO_ROOM;
    if ((int16_t)size >= (int16_t)LENGTH_OFFSET &&
        packet->bytes[CDS_AT_LENGTH] == (uint8_t)(size - LENGTH_OFFSET))
        return CDS_OK; // it was ended before
    return CDS_BAD_ARGUMENT;
}

/* Is there anything to transfer, and does it lie within the control table? */
static inline bool is_length(uint8_t length)
{
    return (uint8_t)(length - 1u) < CDS_TABLE_SIZE;
}

static inline bool is_within(uint8_t address, uint8_t length)
{
    return address <= (uint8_t)(CDS_TABLE_SIZE - length);
}

uint8_t cds_packet_may_read_(const struct cds_packet *packet, uint8_t id, uint8_t address,
                             uint8_t length)
{
    if (!is_length(length) || !is_within(address, length) || id > CDS_ID_MAX)
        return CDS_BAD_ARGUMENT;
    return packet->room < CDS_PACKET_SIZE(2) ? CDS_NO_ROOM : CDS_OK;
}

void cds_packet_build_read_(struct cds_packet *packet, uint8_t id, uint8_t address, uint8_t length)
{
    uint8_t *to = put_head(packet->bytes, id, CDS_LENGTH_MIN + 2, CDS_READ);

    packet->size = CDS_PACKET_SIZE(2);
    *to++ = address;
    *to++ = length;
    *to = (uint8_t) ~(id + CDS_LENGTH_MIN + 2 + CDS_READ + address + length);
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

enum cds_result cds_packet_read(struct cds_packet *packet, uint8_t id, uint8_t address,
                                uint8_t length)
{
    uint8_t result = cds_packet_may_read_(packet, id, address, length);

    if (result == CDS_OK)
        cds_packet_build_read_(packet, id, address, length);
    return (enum cds_result)result;
}

void cds_packet_begin_write_(struct cds_packet *packet, uint8_t id, uint8_t instruction,
                             uint8_t address, const uint8_t *data, uint8_t length)
{
    begin_at(packet, id, instruction, address);
    if (is_length(length) && is_within(address, length))
        cds_packet_append_(packet, data, length);
    else
        refuse(packet);
}

enum cds_result cds_packet_write(struct cds_packet *packet, uint8_t id, uint8_t address,
                                 const uint8_t *data, uint8_t length)
{
    cds_packet_begin_write_(packet, id, CDS_WRITE, address, data, length);
    return cds_packet_end(packet);
}

enum cds_result cds_packet_reg_write(struct cds_packet *packet, uint8_t id, uint8_t address,
                                     const uint8_t *data, uint8_t length)
{
    cds_packet_begin_write_(packet, id, CDS_REG_WRITE, address, data, length);
    return cds_packet_end(packet);
}

enum cds_result cds_packet_sync_begin(struct cds_packet *packet, uint8_t address, uint8_t length)
{
    begin_at(packet, CDS_BROADCAST_ID, CDS_SYNC_WRITE, address);
    if (!is_length(length) || !is_within(address, length)) {
        refuse(packet);
        return CDS_BAD_ARGUMENT;
    }
    cds_packet_put(packet, length);
    return CDS_OK;
}

void cds_packet_sync_add(struct cds_packet *packet, uint8_t id, const uint8_t *data)
{
    // no length stands in the buffer where nothing was begun, or was refused
    bool begun = (int16_t)packet->size > (int16_t)CDS_PACKET_GROWS + CDS_AT_SYNC_LENGTH;

    if (id > CDS_ID_MAX || !begun) {
        refuse(packet);
        return;
    }
    cds_packet_append_(packet, &id, 1);
    cds_packet_append_(packet, data, packet->bytes[CDS_AT_SYNC_LENGTH]);
}
