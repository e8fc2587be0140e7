/* SPDX-License-Identifier: MIT */
/* Many servos in one packet, or in several; see sync_write.h. */
#include "cds55xx/sync_write.h"

#include "servo/servo_internal.h" // cds_servo_send()
#include "bus/steps_internal.h"   // cds_steps_poll()
#include "wire/packet_internal.h" // cds_packet_append()
#include "servo/goal.h"           // cds_goal_put()
#include "compiler.h"             // OPTIMIZER_BARRIER()

enum cds_result cds_sync_write_begin(struct cds_request *request, uint8_t address, uint8_t length)
{
    uint8_t where[2] = {address, length};
    enum cds_result result = CDS_OK;
    uint8_t id = CDS_BROADCAST_ID;

    if (!cds_packet_is_length(length) || !cds_packet_is_within(address, length)) {
        id = cds_packet_refused_id(&request->packet, id);
        result = CDS_BAD_ARGUMENT;
    }
    cds_servo_start(request, where, 2, id, CDS_SYNC_WRITE);
    if (request->result == CDS_PENDING)
        return CDS_BUSY; // its packet is to be sent as it is
    return result;
}

void cds_sync_write_add(struct cds_request *request, uint8_t id, const uint8_t *data)
{
    if (request->result != CDS_PENDING)
        cds_packet_sync_add(&request->packet, id, data);
}

void cds_sync_write_add_goal(struct cds_request *request, uint8_t id, uint16_t position,
                             uint16_t speed)
{
    uint8_t block[1 + CDS_GOAL_SIZE];
    struct cds_packet *packet = &request->packet;
    uint8_t high = (uint8_t)(position >> 8);
    const uint8_t *bytes;

    if (request->result == CDS_PENDING)
        return;
    OPTIMIZER_BARRIER(high); // or gcc compares words all the same
    high = (uint8_t)(high | speed >> 8);
    block[0] = id;
    cds_goal_put(block + 1, position, speed);
    bytes = cds_packet_append(packet, block, sizeof block);
    if (!bytes)
        return; // refused: perhaps no byte in the buffer says how long a block is
    if (id > CDS_ID_MAX || high > CDS_VALUE_MAX >> 8 || // all its bits are 1
        bytes[CDS_AT_SYNC_LENGTH] != CDS_GOAL_SIZE)
        packet->size = CDS_PACKET_REFUSED;
}

enum cds_result cds_sync_write_send(struct cds_bus *bus, struct cds_request *request)
{
    return cds_servo_send(bus, request);
}

/* ---- as many packets as it takes ---- */

#define CHECKSUM_SIZE 1 // bytes that cds_sync_write_send() adds

enum cds_result cds_sync_write_many_begin(struct cds_sync_write_many *write,
                                          const struct cds_sync_write_many_config *config)
{
    uint16_t max = config->packet_max, capacity = config->request->packet.capacity;
    uint8_t length = config->length;
    enum cds_result result;

    if (config->count == 0 || !cds_packet_is_length(length) ||
        !cds_packet_is_within(config->address, length))
        return CDS_BAD_ARGUMENT;
    for (uint8_t i = 0; i < config->count; i++) // before the first packet is out
        if (config->ids[i] > CDS_ID_MAX)
            return CDS_BAD_ARGUMENT;
    if (max == 0 || max > CDS_SYNC_WRITE_PACKET_MAX)
        max = CDS_SYNC_WRITE_PACKET_MAX;
    if (max > capacity)
        max = capacity;
    result = cds_steps_check(config->bus, config->request, 0, 0);
    if (result == CDS_OK && max < CDS_SYNC_WRITE_SIZE(1, length))
        result = CDS_NO_ROOM;
    if (result != CDS_OK)
        return result;
    *write = (struct cds_sync_write_many){.config = *config};
    write->config.packet_max = max;
    cds_steps_begin(&write->steps, config->bus, config->request);
    return CDS_OK;
}

void cds_sync_write_many_abort(struct cds_sync_write_many *write)
{
    cds_steps_abort(&write->steps);
}

/* Adds as many of the remaining servos as this packet may hold. The request is not on its way. */
static void fill(struct cds_sync_write_many *write)
{
    const struct cds_sync_write_many_config *config = &write->config;
    struct cds_packet *packet = &config->request->packet;
    uint8_t length = config->length, end = write->next;
    const uint8_t *data = config->data + (uint16_t)end * length;
    // the size before the last block that fits
    uint16_t last =
        (uint16_t)(CDS_PACKET_BUILDING + config->packet_max - CHECKSUM_SIZE - 1u - length);

    for (; end < config->count && packet->size <= last; end++) {
        cds_packet_sync_add(packet, config->ids[end], data);
        data += length;
    }
    write->end = end;
}

static enum cds_result send_packet(void *operation)
{
    struct cds_sync_write_many *write = (struct cds_sync_write_many *)operation;
    const struct cds_sync_write_many_config *config = &write->config;
    enum cds_result result = cds_sync_write_begin(config->request, config->address, config->length);

    if (result != CDS_OK)
        return result;
    fill(write);
    return cds_sync_write_send(config->bus, config->request);
}

static void packet_ended(void *operation, enum cds_result result)
{
    struct cds_sync_write_many *write = (struct cds_sync_write_many *)operation;

    if (result == CDS_OK) {
        write->packets++;
        write->next = write->end;
        if (write->next < write->config.count)
            return;
    }
    cds_steps_end(&write->steps, result);
}

enum cds_result cds_sync_write_many_poll(struct cds_sync_write_many *write)
{
    return cds_steps_poll(&write->steps, write, send_packet, packet_ended);
}
