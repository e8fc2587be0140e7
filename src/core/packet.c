/* Building instruction packets; see packet.h. */
#include "cds55xx/packet.h"

#include <stdbool.h>
#include <stddef.h>

#include "cds55xx/control_table.h" // CDS_TABLE_SIZE

#define LENGTH_OFFSET  4u // LENGTH counts what follows it: packet size less four
#define SYNC_LENGTH_AT (CDS_AT_PARAMETERS + 1) // of a SYNC WRITE: bytes for each servo

void cds_packet_put(struct cds_packet *packet, uint8_t byte)
{
    if (packet->size < packet->room)
        packet->bytes[packet->size] = byte;
    if (packet->size < CDS_PACKET_REFUSED - 1)
        packet->size++;
}

void cds_packet_put_word(struct cds_packet *packet, uint16_t word)
{
    cds_packet_put(packet, (uint8_t)word);
    cds_packet_put(packet, (uint8_t)(word >> 8));
}

/* Judged once if all of it fits: a SYNC WRITE of 50 servos is 250 bytes of this. */
static void put_all(struct cds_packet *packet, const uint8_t *data, uint8_t length)
{
    if (packet->size <= packet->room && packet->room - packet->size >= length) {
        uint8_t *to = packet->bytes + packet->size;

        packet->size = (uint16_t)(packet->size + length);
        for (; length; length--)
            *to++ = *data++;
        return;
    }
    for (uint8_t i = 0; i < length; i++)
        cds_packet_put(packet, data[i]);
}

void cds_packet_begin(struct cds_packet *packet, uint8_t id, uint8_t instruction)
{
    packet->size = 0;
    cds_packet_put(packet, CDS_HEADER);
    cds_packet_put(packet, CDS_HEADER);
    cds_packet_put(packet, id);
    cds_packet_put(packet, 0); // LENGTH is known at the end
    cds_packet_put(packet, instruction);
}

uint8_t cds_packet_checksum(const uint8_t *bytes)
{
    const uint8_t *end = bytes + bytes[CDS_AT_LENGTH] + CDS_AT_LENGTH;
    uint8_t sum = 0;

    for (const uint8_t *at = bytes + CDS_AT_ID; at < end; at++)
        sum = (uint8_t)(sum + *at);
    return (uint8_t)~sum;
}

uint8_t cds_packet_may_end_(const struct cds_packet *packet)
{
    const uint8_t *bytes = packet->bytes;
    uint16_t size = packet->size; // without the checksum

    if (size < packet->room && bytes[CDS_AT_LENGTH] == 0) {
        if ((uint16_t)(size + 1u - LENGTH_OFFSET) > CDS_LENGTH_MAX)
            return CDS_NO_ROOM;
        return bytes[CDS_AT_ID] > CDS_BROADCAST_ID ? CDS_BAD_ARGUMENT : CDS_OK;
    }
    if (size > CDS_AT_LENGTH && size <= packet->room &&
        bytes[CDS_AT_LENGTH] + LENGTH_OFFSET == size) // ended already, and nothing put behind it
        return CDS_OK;
    return size < packet->room || size == CDS_PACKET_REFUSED ? CDS_BAD_ARGUMENT : CDS_NO_ROOM;
}

void cds_packet_fill_(struct cds_packet *packet)
{
    uint16_t size = packet->size;

    if (packet->bytes[CDS_AT_LENGTH] != 0)
        return; // it was ended before
    packet->bytes[CDS_AT_LENGTH] = (uint8_t)(size + 1u - LENGTH_OFFSET);
    packet->size = (uint16_t)(size + 1u);
}

void cds_packet_seal_(const struct cds_packet *packet)
{
    packet->bytes[packet->size - 1] = cds_packet_checksum(packet->bytes);
}

enum cds_result cds_packet_end(struct cds_packet *packet)
{
    uint8_t result = cds_packet_may_end_(packet);

    if (result == CDS_OK) {
        cds_packet_fill_(packet);
        cds_packet_seal_(packet);
    }
    return (enum cds_result)result;
}

/* The short ones are of a size known beforehand: room need not be counted byte by byte. */
static uint8_t claim(const struct cds_packet *packet, uint8_t parameters)
{
    return CDS_PACKET_SIZE(parameters) > packet->room ? CDS_NO_ROOM : CDS_OK;
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
    return claim(packet, 2);
}

/* What stands before the parameters, of which there are so many; returns where they belong. */
static uint8_t *put_head(struct cds_packet *packet, uint8_t id, uint8_t parameters,
                         uint8_t instruction)
{
    uint8_t *bytes = packet->bytes;

    packet->size = (uint16_t)CDS_PACKET_SIZE(parameters);
    *bytes++ = CDS_HEADER;
    *bytes++ = CDS_HEADER;
    *bytes++ = id;
    *bytes++ = (uint8_t)(parameters + CDS_LENGTH_MIN);
    *bytes++ = instruction;
    return bytes;
}

void cds_packet_build_read_(struct cds_packet *packet, uint8_t id, uint8_t address, uint8_t length)
{
    uint8_t *to = put_head(packet, id, 2, CDS_READ);

    *to++ = address;
    *to++ = length;
    *to = (uint8_t) ~(id + CDS_LENGTH_MIN + 2 + CDS_READ + address + length);
}

static enum cds_result bare(struct cds_packet *packet, uint8_t id, uint8_t instruction)
{
    if (id > CDS_BROADCAST_ID)
        return CDS_BAD_ARGUMENT;
    if (claim(packet, 0) != CDS_OK)
        return CDS_NO_ROOM;
    put_head(packet, id, 0, instruction);
    cds_packet_seal_(packet);
    return CDS_OK;
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

static enum cds_result with_data(struct cds_packet *packet, uint8_t id, uint8_t instruction,
                                 uint8_t address, const uint8_t *data, uint8_t length)
{
    uint8_t *to;

    if (!is_length(length) || !is_within(address, length) || id > CDS_BROADCAST_ID)
        return CDS_BAD_ARGUMENT;
    if (claim(packet, (uint8_t)(length + 1u)) != CDS_OK)
        return CDS_NO_ROOM;
    to = put_head(packet, id, (uint8_t)(length + 1u), instruction);
    *to++ = address;
    for (; length; length--)
        *to++ = *data++;
    cds_packet_seal_(packet);
    return CDS_OK;
}

enum cds_result cds_packet_write(struct cds_packet *packet, uint8_t id, uint8_t address,
                                 const uint8_t *data, uint8_t length)
{
    return with_data(packet, id, CDS_WRITE, address, data, length);
}

enum cds_result cds_packet_reg_write(struct cds_packet *packet, uint8_t id, uint8_t address,
                                     const uint8_t *data, uint8_t length)
{
    return with_data(packet, id, CDS_REG_WRITE, address, data, length);
}

enum cds_result cds_packet_sync_begin(struct cds_packet *packet, uint8_t address, uint8_t length)
{
    if (!is_length(length) || !is_within(address, length)) {
        packet->size = CDS_PACKET_REFUSED;
        return CDS_BAD_ARGUMENT;
    }
    cds_packet_begin(packet, CDS_BROADCAST_ID, CDS_SYNC_WRITE);
    cds_packet_put(packet, address);
    cds_packet_put(packet, length);
    return CDS_OK;
}

void cds_packet_sync_add(struct cds_packet *packet, uint8_t id, const uint8_t *data)
{
    if (id > CDS_ID_MAX)
        packet->size = CDS_PACKET_REFUSED;
    if (packet->size == CDS_PACKET_REFUSED)
        return; // then no length stands in the buffer either
    cds_packet_put(packet, id);
    if (packet->room > SYNC_LENGTH_AT) // else it stands nowhere, and the packet is too long already
        put_all(packet, data, packet->bytes[SYNC_LENGTH_AT]);
}
