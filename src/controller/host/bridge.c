/* SPDX-License-Identifier: MIT */
/* Packets of the host; see bridge.h. */
#include "host/bridge.h"

#include "cds55xx/port.h" // cds_port_now_us()
#include "compiler.h"     // NOINLINE

void bridge_open(struct bridge *bridge, struct cds_bus *bus, struct host_demux *host,
                 struct device *device, struct cds_ring *output, uint8_t *bytes)
{
    OPTIMIZER_BARRIER(bridge);
    *bridge = (struct bridge){.bus = bus, .host = host, .device = device, .output = output};
    bridge->request.packet.bytes = bytes;
    bridge->request.packet.capacity = HOST_PACKET_MAX;
    bridge->request.reply = bridge->reply + STATUS_PACKET_HEAD;
    bridge->request.reply_capacity = CDS_REPLY_ANY;
    bridge->request.any_length = true;
    bridge->request.no_retry = true;
    bulk_read_open(&bridge->bulk_read, bus, device, output);
}

/* Begins a status packet to the host. */
NOINLINE static void answer(struct bridge *bridge, uint8_t error, uint8_t *parameters,
                            uint8_t length)
{
    status_packet_begin(&bridge->status, bridge->request.id, error, parameters, length);
    bridge->state = BRIDGE_ANSWERING;
}

/* ---- packets for the bus ---- */

_Static_assert(CDS_RESERVED == CDS_TOO_EARLY + 1, "refuse() answers these two, the last results");

/* The bus has refused the packet, at the submit or when its turn came. */
static void refuse(struct bridge *bridge, uint8_t result)
{
    bridge->counters.refused++;
    if (result >= CDS_TOO_EARLY && bridge->request.id != CDS_BROADCAST_ID &&
        !bridge->request.is_muted)
        answer(bridge, CDS_ERROR_RANGE, bridge->request.reply, 0);
}

static void pass(struct bridge *bridge)
{
    struct cds_request *request = &bridge->request;
    enum cds_result result;

    request->reply_parameters = status_packet_due(request->packet.bytes);
    result = cds_bus_submit(bridge->bus, request);
    if (result != CDS_OK) {
        refuse(bridge, (uint8_t)result);
        return;
    }
    bridge->counters.passed++;
    bridge->state = BRIDGE_WAITING;
}

/* Takes back a packet that still waits for its turn on the bus after HOST_SILENCE_US. */
static void drop_expired(struct bridge *bridge)
{
    if (!host_is_late(bridge->taken_us) || cds_bus_cancel(bridge->bus, &bridge->request) != CDS_OK)
        return;
    bridge->host->counters.late++;
    bridge->state = BRIDGE_IDLE;
}

static void await_reply(struct bridge *bridge)
{
    const struct cds_request *request = &bridge->request;

    if (request->result == CDS_PENDING) {
        drop_expired(bridge);
        return;
    }
    bridge->state = BRIDGE_IDLE;
    if (request->result > CDS_LINE_BUSY) { // the permit has refused the packet: result.h
        refuse(bridge, request->result);
        return;
    }
    if (request->reply_parameters == CDS_REPLY_NONE || request->is_muted)
        return;
    if (request->result == CDS_OK) {
        bridge->counters.answered++;
        answer(bridge, request->error, request->reply, request->length);
    } else {
        bridge->counters.unanswered++;
    }
}

/* ---- packets for the device, SYNC READ and BULK READ ---- */

static void ask_device(struct bridge *bridge)
{
    struct device *device = bridge->device;

    bridge->state = BRIDGE_DEVICE;
    if (device_obey(device, bridge->request.packet.bytes))
        answer(bridge, device->error, bridge->request.packet.bytes, device->length);
}

static void poll_bulk_read(struct bridge *bridge)
{
    switch (bulk_read_poll(&bridge->bulk_read)) {
    case BULK_READ_MORE: break;
    case BULK_READ_DROPPED: bridge->host->counters.late++; // fall through
    case BULK_READ_DONE: bridge->state = BRIDGE_IDLE; break;
    case BULK_READ_ANSWER:
        bridge->request.id = bridge->bulk_read.device_id;
        answer(bridge, bridge->bulk_read.error, bridge->request.packet.bytes,
               bridge->bulk_read.data_length);
        break;
    }
}

static void begin_bulk_read(struct bridge *bridge, uint8_t own)
{
    if (bulk_read_begin(&bridge->bulk_read, own, bridge->request.packet.bytes))
        bridge->state = BRIDGE_BULK_READ;
    else
        bridge->counters.refused++;
}

/* Takes the packet of the host and gives it to bulk read, device or bus. NOINLINE: a poll during a
 * bulk read saves no registers for this function. */
NOINLINE static void take(struct bridge *bridge)
{
    struct cds_packet *packet = &bridge->request.packet;
    uint8_t own = device_id(bridge->device);
    uint8_t id, instruction;

    packet->bytes = host_demux_take(bridge->host, packet->bytes);
    bridge->taken_us = bridge->host->packet_us;
    packet->size = (uint16_t)(packet->bytes[CDS_AT_LENGTH] + CDS_AT_LENGTH + 1);
    id = packet->bytes[CDS_AT_ID];
    bridge->request.id = id; // a packet that changes the ID is answered with the old one (R2)
    instruction = packet->bytes[CDS_AT_INSTRUCTION];
    if (own <= CDS_ID_MAX && bulk_read_handles(own, id, instruction))
        begin_bulk_read(bridge, own);
    else if (own <= CDS_ID_MAX && id == own)
        ask_device(bridge);
    else
        pass(bridge);
}

void bridge_poll(struct bridge *bridge)
{
    OPTIMIZER_BARRIER(bridge);
    switch (bridge->state) {
    case BRIDGE_IDLE:
        if (bridge->host->has_packet)
            take(bridge);
        break;
    case BRIDGE_WAITING: await_reply(bridge); break;
    case BRIDGE_DEVICE: ask_device(bridge); break;
    case BRIDGE_BULK_READ: poll_bulk_read(bridge); break;
    default: break;
    }
    if (bridge->state == BRIDGE_ANSWERING && status_packet_put(&bridge->status, bridge->output))
        bridge->state = BRIDGE_IDLE;
}

/* A bulk read that waits for the bus still hands over a status packet that has come. A WRITE to the
 * device waits, since it may change the rate of the bus. */
NOINLINE bool bridge_goes_on(struct bridge *bridge)
{
    OPTIMIZER_BARRIER(bridge);
    if (bridge->state == BRIDGE_BULK_READ) {
        if (!host_is_late(bridge->taken_us))
            return bulk_read_talks(&bridge->bulk_read);
        bulk_read_abort(&bridge->bulk_read);
        return true;
    }
    if (bridge->state == BRIDGE_DEVICE && bridge->device->unsettled) {
        if (host_is_late(bridge->taken_us)) { // the WRITE is carried out; the host waits no longer
            device_drop_answer(bridge->device);
            bridge->host->counters.late++;
            bridge->state = BRIDGE_IDLE;
        }
        return false;
    }
    return bridge->state != BRIDGE_IDLE;
}

bool bridge_talks(const struct bridge *bridge)
{
    return bridge->state == BRIDGE_ANSWERING ||
           (bridge->state == BRIDGE_BULK_READ && bulk_read_talks(&bridge->bulk_read));
}

bool bridge_idle(const struct bridge *bridge)
{
    return bridge->state == BRIDGE_IDLE && !bridge->host->has_packet;
}
