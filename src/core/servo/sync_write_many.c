/* SYNC WRITE in as many packets as it takes; see sync_write_many.h. */
#include "cds55xx/sync_write_many.h"

#include "cds55xx/sync_write.h" // cds_sync_write_begin() and its like

#include "wire/packet_internal.h" // CDS_PACKET_BUILDING

#define CHECKSUM_SIZE 1 // bytes that cds_sync_write_send() adds

void cds_sync_write_many_begin(struct cds_sync_write_many *write, struct cds_bus *bus,
                               struct cds_request *request, const uint8_t *ids, uint8_t count,
                               uint8_t address, uint8_t length, const uint8_t *data)
{
    *write = (struct cds_sync_write_many){
        .bus = bus,
        .request = request,
        .ids = ids,
        .data = data,
        .longest = CDS_SYNC_WRITE_MANY_LONGEST,
        .count = count,
        .address = address,
        .length = length,
        .result = CDS_PENDING,
    };
}

void cds_sync_write_many_set_longest(struct cds_sync_write_many *write, uint16_t bytes)
{
    write->longest = bytes;
}

/* A bad servo in the last packet must not be found when the first is out. Address and length are
 * judged by the first packet itself. */
static enum cds_result check(struct cds_sync_write_many *write)
{
    if (write->count == 0)
        return CDS_BAD_ARGUMENT;
    for (uint8_t i = 0; i < write->count; i++)
        if (write->ids[i] > CDS_ID_MAX)
            return CDS_BAD_ARGUMENT;
    if (write->longest > CDS_SYNC_WRITE_MANY_LONGEST)
        write->longest = CDS_SYNC_WRITE_MANY_LONGEST;
    if (write->longest > write->request->packet.capacity)
        write->longest = write->request->packet.capacity;
    return CDS_PENDING;
}

/* As many of the servos that are left as this packet may hold. The bus is idle meanwhile. */
static void fill(struct cds_sync_write_many *write)
{
    struct cds_packet *packet = &write->request->packet;
    uint8_t length = write->length, end = write->next;
    const uint8_t *data = write->data + (uint16_t)end * length;
    // where the last block that fits begins
    uint16_t last = (uint16_t)(CDS_PACKET_BUILDING + write->longest - CHECKSUM_SIZE - 1u - length);

    for (; end < write->count && packet->size <= last; end++) {
        cds_packet_sync_add(packet, write->ids[end], data);
        data += length;
    }
    write->end = end;
}

static enum cds_result send(struct cds_sync_write_many *write)
{
    enum cds_result result = cds_sync_write_begin(write->request, write->address, write->length);

    if (result != CDS_OK)
        return result;
    if (write->longest < CDS_SYNC_WRITE_SIZE(1, write->length))
        return CDS_NO_ROOM;
    fill(write);
    return cds_sync_write_send(write->bus, write->request);
}

static void send_next(struct cds_sync_write_many *write)
{
    enum cds_result result = send(write);

    if (result == CDS_OK)
        write->sent = true;
    else if (result != CDS_BUSY)
        write->result = (uint8_t)result;
}

static void packet_ended(struct cds_sync_write_many *write)
{
    write->sent = false;
    if (write->request->result != CDS_OK) {
        write->result = write->request->result;
        return;
    }
    write->packets++;
    write->next = write->end;
    if (write->next == write->count)
        write->result = CDS_OK;
}

enum cds_result cds_sync_write_many_poll(struct cds_sync_write_many *write)
{
    if (!write->checked) {
        write->checked = true;
        write->result = (uint8_t)check(write);
    }
    if (write->sent && write->request->result != CDS_PENDING)
        packet_ended(write);
    if (write->result == CDS_PENDING && !write->sent)
        send_next(write);
    return (enum cds_result)write->result;
}
