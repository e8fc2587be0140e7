/* SPDX-License-Identifier: MIT */
/* SYNC READ and BULK READ; see bulk_read.h. */
#include "host/bulk_read.h"

#include <string.h>

#include "host/status_packet.h"
#include "compiler.h" // NOINLINE, OPTIMIZER_BARRIER()

#define PACKET_MAX (CDS_LENGTH_MAX + 4)
#define DATA_MAX   (CDS_LENGTH_MAX - CDS_LENGTH_MIN)
#define MISSING    UINT8_MAX // each byte of a servo that failed
#define BULK_ITEM  3         // bytes of a BULK READ for each servo: length, ID, address

bool bulk_read_handles(uint8_t device_id, uint8_t id, uint8_t instruction)
{
    bool to_all = id == CDS_BROADCAST_ID;

    return (instruction == INSTRUCTION_SYNC_READ && (to_all || id == device_id)) ||
           (instruction == INSTRUCTION_BULK_READ && to_all);
}

uint8_t status_packet_due(const uint8_t *packet)
{
    uint8_t instruction = packet[CDS_AT_INSTRUCTION];
    uint8_t count = packet[CDS_AT_PARAMETERS + 1];

    if (packet[CDS_AT_ID] == CDS_BROADCAST_ID)
        return instruction == CDS_PING ? 0 : CDS_REPLY_NONE;
    if (instruction != CDS_READ || packet[CDS_AT_LENGTH] != CDS_LENGTH_MIN + 2)
        return 0;
    return count <= CDS_REPLY_MAX ? count : 0; // a servo refuses a longer READ
}

/* ---- the packet of the host ---- */

static void begin_sync(struct bulk_read *bulk, uint8_t *packet)
{
    uint8_t parameters = (uint8_t)(packet[CDS_AT_LENGTH] - CDS_LENGTH_MIN);
    uint16_t size;

    bulk->to = packet;
    bulk->is_bulk = false;
    bulk->error = CDS_ERROR_RANGE;
    bulk->data_length = 0;
    bulk->servos = 0;
    if (parameters < 3)
        return;
    bulk->address = packet[CDS_AT_PARAMETERS];
    bulk->length = packet[CDS_AT_PARAMETERS + 1];
    parameters = (uint8_t)(parameters - 2);
    size = (uint16_t)(bulk->length * parameters);
    if (size == 0 || size > DATA_MAX)
        return;
    bulk->error = 0;
    bulk->servos = parameters;
    bulk->data_length = (uint8_t)size;
    /* The data grow from the front of the buffer, and at least as fast as IDs are used up: the IDs
     * move to its end. */
    bulk->next =
        memmove(packet + PACKET_MAX - parameters, packet + CDS_AT_PARAMETERS + 2, parameters);
}

static void begin_bulk(struct bulk_read *bulk, const uint8_t *packet)
{
    uint8_t left = (uint8_t)(packet[CDS_AT_LENGTH] - CDS_LENGTH_MIN - 1);
    const uint8_t *item = packet + CDS_AT_PARAMETERS + 1;
    uint8_t servos = 0;

    bulk->is_bulk = true;
    bulk->servos = 0;
    bulk->next = item;
    if (left > DATA_MAX)
        return;
    for (; left >= BULK_ITEM; left = (uint8_t)(left - BULK_ITEM)) {
        if (item[1] > CDS_ID_MAX)
            return;
        item += BULK_ITEM;
        servos++;
    }
    if (left == 0)
        bulk->servos = servos;
}

/* ---- one servo after the other ---- */

/* The next READ of the pipeline. */
static bool next(void *context, struct cds_read_item *item)
{
    struct bulk_read *bulk = context;
    const uint8_t *from = bulk->next;

    if (bulk->is_bulk) {
        *item = (struct cds_read_item){.length = from[0], .id = from[1], .address = from[2]};
        bulk->next = from + BULK_ITEM;
    } else {
        *item = (struct cds_read_item){from[0], bulk->address, bulk->length};
        bulk->next = from + 1;
    }
    return item->id != bulk->device_id && item->id <= CDS_ID_MAX;
}

/* The device answers its own READ. False: it cannot yet. Its data are no longer than a servo's. */
static bool ask_device(struct bulk_read *bulk, struct cds_request *read)
{
    struct device *device = bulk->device;

    if (read->reply_parameters == 0) {
        read->error = CDS_ERROR_RANGE;
        return true;
    }
    if (!device_is_busy(device))
        memcpy(read->reply, read->packet.bytes, CDS_PACKET_SIZE(2));
    if (!device_obey(device, read->reply))
        return false;
    read->error = device->error;
    read->length = device->length;
    return true;
}

/* Keeps the data of a SYNC READ, or notes that a servo failed. NOINLINE: a BULK READ without a
 * failure saves no registers for it. */
NOINLINE static void keep(struct bulk_read *bulk, const struct cds_request *read)
{
    uint8_t length = bulk->length;
    bool is_good = read->result == CDS_OK && read->length == length;

    if (!is_good)
        device_note_failure(bulk->device, read->id);
    if (bulk->is_bulk)
        return;
    if (is_good) {
        memcpy(bulk->to, read->reply, length);
    } else {
        memset(bulk->to, MISSING, length);
        bulk->error = BULK_READ_ERROR_FAILED;
    }
    bulk->to += length;
}

/* Takes over the outcome of a READ. False: the device or the ring to the host is not ready. */
static bool take(void *context, struct cds_request *read)
{
    struct bulk_read *bulk = context;

    if (read->id == bulk->device_id && !ask_device(bulk, read))
        return false;
    if (bulk->is_bulk && read->result == CDS_OK)
        return status_packet_put_whole(bulk->output, read->id, read->error, read->reply,
                                       read->length);
    keep(bulk, read);
    return true;
}

/* ---- calls ---- */

void bulk_read_open(struct bulk_read *bulk, struct cds_bus *bus, struct device *device,
                    struct cds_ring *output)
{
    OPTIMIZER_BARRIER(bulk);
    bulk->bus = bus;
    bulk->device = device;
    bulk->output = output;
    for (uint8_t i = 0; i < 2; i++) {
        bulk->requests[i].packet.bytes = bulk->packets[i];
        bulk->requests[i].packet.capacity = sizeof bulk->packets[i];
        bulk->requests[i].reply = bulk->replies[i];
        bulk->requests[i].reply_capacity = sizeof bulk->replies[i];
    }
}

bool bulk_read_begin(struct bulk_read *bulk, uint8_t device_id, uint8_t *packet)
{
    OPTIMIZER_BARRIER(bulk);
    bulk->device_id = device_id;
    bulk->pipeline.result = CDS_OK;
    if (packet[CDS_AT_INSTRUCTION] == INSTRUCTION_SYNC_READ)
        begin_sync(bulk, packet);
    else
        begin_bulk(bulk, packet);
    bulk->requests[0].no_retry = bulk->requests[1].no_retry = bulk->is_bulk;
    if (bulk->servos) {
        cds_read_pipeline_begin(
            &bulk->pipeline, &(struct cds_read_pipeline_config){.bus = bulk->bus,
                                                                .requests = bulk->requests,
                                                                .count = bulk->servos,
                                                                .longest = CDS_REPLY_MAX,
                                                                .stops_on_failure = bulk->is_bulk,
                                                                .context = bulk,
                                                                .next = next,
                                                                .take = take});
        cds_read_pipeline_poll(&bulk->pipeline);
    }
    device_forget_failures(bulk->device); // while the first servo is asked
    return bulk->servos || !bulk->is_bulk;
}

void bulk_read_abort(struct bulk_read *bulk)
{
    OPTIMIZER_BARRIER(bulk);
    cds_read_pipeline_abort(&bulk->pipeline);
}

enum bulk_read_progress bulk_read_poll(struct bulk_read *bulk)
{
    enum cds_result result = cds_read_pipeline_poll(&bulk->pipeline);

    if (result == CDS_PENDING)
        return BULK_READ_MORE;
    if (result != CDS_OK)
        return BULK_READ_DROPPED;
    return bulk->is_bulk ? BULK_READ_DONE : BULK_READ_ANSWER;
}
