/* Packet builders: any arguments, any data, buffers of every size from 0 to 258 bytes. */
#include "cds55xx/packet.h"

#include "any.h"

#define PACKET_MAX 258u
#define ROOM_MAX   0xBFFFu
#define SMALL_ROOM 60u // a larger room no longer matters to a packet for one servo

static uint8_t data[CDS_TABLE_SIZE + 1];

static void fill_data(void)
{
    for (uint8_t i = 0; i < sizeof data; i++)
        data[i] = any_byte();
}

static uint8_t area[PACKET_MAX];

/* A buffer of `room` bytes, at the end of `area`: Eva reports each access beyond it. */
static uint8_t *buffer_of(uint16_t room)
{
    return area + PACKET_MAX - room;
}

/* A length of data bytes: 0, 1 to 50, or more. Eva does not derive these ranges from
 * (uint8_t)(length - 1u) < CDS_TABLE_SIZE. */
static uint8_t any_length(void)
{
    if (any_bool())
        return 0;
    return any_bool() ? (uint8_t)any_in(1, CDS_TABLE_SIZE)
                      : (uint8_t)any_in(CDS_TABLE_SIZE + 1, 255);
}

static struct cds_packet packet;

/* Each instruction as one call. */
void eva_packet_whole(void)
{
    uint16_t room = any_in(0, ROOM_MAX);
    uint8_t id, address, length;

    fill_data();
    packet.bytes = area;
    if (room <= SMALL_ROOM) {
        //@ split room;
        packet.bytes = buffer_of(room);
    }
    packet.room = room;
    id = any_byte();
    address = any_byte();
    length = any_length();
    //@ split length == 0;
    //@ split length > CDS_TABLE_SIZE;
    //@ dynamic_split packet.size >= CDS_PACKET_REFUSED;
    switch (any_in(0, 6)) {
    case 0: cds_packet_ping(&packet, id); break;
    case 1: cds_packet_action(&packet, id); break;
    case 2: cds_packet_reset(&packet, id); break;
    case 3: cds_packet_read(&packet, id, address, length); break;
    case 4: cds_packet_write(&packet, id, address, data, length); break;
    case 5: cds_packet_reg_write(&packet, id, address, data, length); break;
    default: cds_packet_sync_begin(&packet, address, length);
    }
}

/* A packet of any size that grows, was refused, was never begun or has ended, in `room` bytes. */
static void any_packet(uint16_t kind, uint16_t room, uint16_t put)
{
    packet.bytes = buffer_of(room);
    packet.room = room;
    if (kind == 0)
        packet.size = CDS_PACKET_GROWS + put;
    else if (kind == 1)
        packet.size = any_in(CDS_PACKET_REFUSED, UINT16_MAX);
    else
        packet.size = any_in(0, room);
}

/* What any_packet() assumes is true of the packet again. So it is true after any number of steps.
 */
static void check_packet(uint16_t room)
{
    if (cds_packet_grows_(&packet)) {
        //@ assert packet.size < CDS_PACKET_GROWS + room;
        //@ assert packet.size < 0x4100;
    } else {
        //@ assert packet.size >= CDS_PACKET_REFUSED || packet.size <= room;
    }
}

static void fill_area(void)
{
    for (uint16_t i = 0; i < PACKET_MAX; i++)
        area[i] = any_byte();
}

/* One step: a parameter or a word is put, or the packet ends. Buffers of 6 to 258 bytes. */
void eva_packet_step(void)
{
    uint16_t room = any_in(CDS_PACKET_SIZE(0), PACKET_MAX), put, kind = any_in(0, 2);

    fill_area();
    //@ split room;
    put = any_in(CDS_AT_PARAMETERS, room - 1);
    //@ split kind;
    any_packet(kind, room, put);
    switch (any_in(0, 2)) {
    case 0: cds_packet_put(&packet, any_byte()); break;
    case 1: cds_packet_put_word(&packet, any_word()); break;
    default: cds_packet_end(&packet);
    }
    check_packet(room);
}

/* One block of a SYNC WRITE. Eva must know both sizes here, and that takes long: so it considers
 * buffers in which nearly no block fits, in which the longest one just fits, and the largest one.
 * Not a larger `room`: Eva learns nothing about `end` from !(end & 0x100). */
void eva_packet_sync_add(void)
{
    uint16_t room = PACKET_MAX;
    uint16_t put, kind = any_in(0, 2);

    fill_data();
    fill_area();
    switch (any_in(0, 2)) {
    case 0: room = any_in(CDS_PACKET_SIZE(0), 12); break;
    case 1: room = any_in(SMALL_ROOM - 4, SMALL_ROOM);
    }
    //@ split room;
    put = any_in(CDS_AT_PARAMETERS, room - 1);
    //@ split kind;
    if (kind)
        put = 0; // without meaning
    //@ split put;
    //@ dynamic_split packet.size >= CDS_PACKET_REFUSED;
    any_packet(kind, room, put);
    if (room > CDS_AT_SYNC_LENGTH)
        packet.bytes[CDS_AT_SYNC_LENGTH] =
            (uint8_t)any_in(1, CDS_TABLE_SIZE); // cds_packet_sync_begin()
    cds_packet_sync_add(&packet, any_byte(), data);
    check_packet(room);
}
