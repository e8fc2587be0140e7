/* SPDX-License-Identifier: MIT */
/* Building packets step by step, for modules of the core; not installed. Main context. */
#ifndef CDS_PACKET_INTERNAL_H
#define CDS_PACKET_INTERNAL_H

#include "cds55xx/packet.h" // struct cds_packet

/* Values of `size` of a packet that is not ended. Building: CDS_PACKET_BUILDING plus the bytes put
 * so far; for 5 to 257 bytes the high byte is the same, and one test of it says so. Refused: for
 * want of capacity, or for an argument. */
#define CDS_PACKET_BUILDING 0x3FFEu
#define CDS_PACKET_REFUSED  0x8000u // this bit, whatever the others are
#define CDS_PACKET_NO_ROOM  0xA000u

/* True while parameters may be put. Tests one byte of `size`. */
static inline bool cds_packet_is_building(const struct cds_packet *packet)
{
    return (int8_t)(packet->size >> 8) >= 0x40;
}

/* Begins a packet with its first `count` parameters. `id` CDS_NO_ID: the packet is refused. */
void cds_packet_start(struct cds_packet *packet, const uint8_t *data, uint8_t count, uint8_t id,
                      uint8_t instruction);

/* The ID to begin a packet with whose other arguments are wrong: CDS_NO_ID, but `id` where the
 * capacity is too small for any packet, which then is the reason. */
static inline uint8_t cds_packet_refused_id(const struct cds_packet *packet, uint8_t id)
{
    return packet->capacity < CDS_PACKET_SIZE(0) ? id : CDS_NO_ID;
}

/* Appends `count` bytes, 0 to 51: all of them, or none. Returns the buffer, or NULL: none. */
uint8_t *cds_packet_append(struct cds_packet *packet, const uint8_t *data, uint8_t count);

/* True if `length` is 1 to 50. */
static inline bool cds_packet_is_length(uint8_t length)
{
    return (uint8_t)(length - 1u) < CDS_TABLE_SIZE;
}

/* True if they lie within the control table. */
static inline bool cds_packet_is_within(uint8_t address, uint8_t length)
{
    return address <= (uint8_t)(CDS_TABLE_SIZE - length);
}

/* Refuses the packet for an argument. What was wrong before stays the reason. */
void cds_packet_refuse(struct cds_packet *packet);

/* Changes the ID of a packet that is ended, and its checksum. */
static inline void cds_packet_set_id(struct cds_packet *packet, uint8_t id)
{
    uint8_t *bytes = packet->bytes, *checksum = &bytes[packet->size - 1u];

    *checksum = (uint8_t)(*checksum + bytes[CDS_AT_ID] - id);
    bytes[CDS_AT_ID] = id;
}

/* Begins a WRITE or REG WRITE and puts all its data. */
void cds_packet_begin_write(struct cds_packet *packet, uint8_t id, uint8_t instruction,
                            uint8_t address, const uint8_t *data, uint8_t length);

#endif
