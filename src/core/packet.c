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

/* Ended already, and nothing put behind it? LENGTH is 0 until then. */
static bool is_ended(const struct cds_packet *packet)
{
    return packet->size > CDS_AT_LENGTH && packet->size <= packet->room &&
           packet->bytes[CDS_AT_LENGTH] + LENGTH_OFFSET == packet->size;
}

enum cds_result cds_packet_end(struct cds_packet *packet)
{
    uint16_t size = packet->size; // without the checksum

    if (is_ended(packet))
        return CDS_OK;
    if (size == CDS_PACKET_REFUSED || (size < packet->room && packet->bytes[CDS_AT_LENGTH] != 0))
        return CDS_BAD_ARGUMENT;
    if (size >= packet->room || size + 1u - LENGTH_OFFSET > CDS_LENGTH_MAX)
        return CDS_NO_ROOM;
    if (packet->bytes[CDS_AT_ID] > CDS_BROADCAST_ID)
        return CDS_BAD_ARGUMENT;
    packet->bytes[CDS_AT_LENGTH] = (uint8_t)(size + 1u - LENGTH_OFFSET);
    cds_packet_put(packet, cds_packet_checksum(packet->bytes));
    return CDS_OK;
}

/* The short ones, of a size known beforehand, need no counting of room byte by byte. Returns where
 * the parameters belong, or NULL if there is no room. */
static uint8_t *open(struct cds_packet *packet, uint8_t id, uint8_t instruction, uint8_t parameters)
{
    uint8_t *bytes = packet->bytes;

    packet->size = (uint16_t)CDS_PACKET_SIZE(parameters);
    if (packet->size > packet->room)
        return NULL;
    *bytes++ = CDS_HEADER;
    *bytes++ = CDS_HEADER;
    *bytes++ = id;
    *bytes++ = (uint8_t)(parameters + CDS_LENGTH_MIN);
    *bytes++ = instruction;
    return bytes;
}

/* Its parameters end before `checksum`. */
static enum cds_result close(const struct cds_packet *packet, uint8_t *checksum)
{
    *checksum = cds_packet_checksum(packet->bytes);
    return CDS_OK;
}

static enum cds_result bare(struct cds_packet *packet, uint8_t id, uint8_t instruction)
{
    uint8_t *parameters;

    if (id > CDS_BROADCAST_ID)
        return CDS_BAD_ARGUMENT;
    parameters = open(packet, id, instruction, 0);
    return parameters ? close(packet, parameters) : CDS_NO_ROOM;
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

/* Is there anything to transfer, and does it lie within the control table? */
static bool in_table(uint8_t address, uint8_t length)
{
    return length > 0 && length <= CDS_TABLE_SIZE && address <= CDS_TABLE_SIZE - length;
}

enum cds_result cds_packet_read(struct cds_packet *packet, uint8_t id, uint8_t address,
                                uint8_t length)
{
    uint8_t *parameters;

    if (!in_table(address, length) || id > CDS_ID_MAX)
        return CDS_BAD_ARGUMENT;
    parameters = open(packet, id, CDS_READ, 2);
    if (!parameters)
        return CDS_NO_ROOM;
    *parameters++ = address;
    *parameters++ = length;
    return close(packet, parameters);
}

static enum cds_result with_data(struct cds_packet *packet, uint8_t id, uint8_t instruction,
                                 uint8_t address, const uint8_t *data, uint8_t length)
{
    uint8_t *parameters;

    if (!in_table(address, length) || id > CDS_BROADCAST_ID)
        return CDS_BAD_ARGUMENT;
    parameters = open(packet, id, instruction, (uint8_t)(length + 1u));
    if (!parameters)
        return CDS_NO_ROOM;
    *parameters++ = address;
    for (; length; length--)
        *parameters++ = *data++;
    return close(packet, parameters);
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
    if (!in_table(address, length)) {
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
