/* What becomes of the host's packets; see bridge.h. */
#include "host/bridge.h"

#include "cds55xx/port.h" // cds_port_now_us()
#include "compiler.h"     // NOINLINE

void bridge_open(struct bridge *bridge, struct cds_bus *bus, struct host *host,
                 struct device *device, struct cds_ring *output, uint8_t *bytes)
{
    OPTIMIZER_BARRIER(bridge);
    *bridge = (struct bridge){.host = host};
    bridge->request.packet.bytes = bytes;
    bridge->request.packet.capacity = HOST_PACKET_MAX;
    bridge->request.reply = bridge->reply + ANSWER_BEFORE;
    bridge->request.reply_capacity = CDS_REPLY_ANY;
    bridge->request.any_length = true;
    bridge->request.no_retry = true;
    gather_open(&bridge->gather, bus, device, output);
}

NOINLINE static void answer(struct bridge *bridge, uint8_t error, uint8_t *parameters,
                            uint8_t length)
{
    answer_begin(&bridge->answer, bridge->request.id, error, parameters, length);
    bridge->state = BRIDGE_ANSWERING;
}

/* --- through the bus ---------------------------------------------------------------------------
 */

/* The bus does not send the packet, at once or when its turn has come. */
static void refuse(struct bridge *bridge, uint8_t result)
{
    bridge->counters.refused++;
    if (result == CDS_TOO_EARLY && bridge->request.id != CDS_BROADCAST_ID)
        answer(bridge, CDS_ERROR_RANGE, bridge->request.reply, 0);
}

static void pass(struct bridge *bridge)
{
    struct cds_request *request = &bridge->request;
    enum cds_result result;

    request->reply_parameters = gather_reply_due(request->packet.bytes);
    result = cds_bus_submit(bridge->gather.bus, request);
    if (result != CDS_OK) {
        refuse(bridge, (uint8_t)result);
        return;
    }
    bridge->counters.passed++;
    bridge->state = BRIDGE_WAITING;
}

/* A packet that still waits for its turn on the bus when the client has given up is not sent. */
static void give_up_late(struct bridge *bridge)
{
    if (cds_port_now_us() - bridge->taken_us < HOST_SILENCE_US ||
        cds_bus_cancel(bridge->gather.bus, &bridge->request) != CDS_OK)
        return;
    bridge->host->counters.late++;
    bridge->state = BRIDGE_IDLE;
}

static void await_reply(struct bridge *bridge)
{
    const struct cds_request *request = &bridge->request;

    if (request->result == CDS_PENDING) {
        give_up_late(bridge);
        return;
    }
    bridge->state = BRIDGE_IDLE;
    if (request->result > CDS_LINE_BUSY) { // the observer has changed its mind
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

/* --- the device --------------------------------------------------------------------------------
 */

static void ask_device(struct bridge *bridge)
{
    struct device *device = bridge->gather.device;

    bridge->state = BRIDGE_DEVICE;
    if (device_obey(device, bridge->request.packet.bytes))
        answer(bridge, device->error, bridge->request.packet.bytes, device->length);
}

static void gather(struct bridge *bridge)
{
    switch (gather_poll(&bridge->gather)) {
    case GATHER_MORE: break;
    case GATHER_DONE: bridge->state = BRIDGE_IDLE; break;
    case GATHER_ANSWER:
        bridge->request.id = bridge->gather.device_id;
        answer(bridge, bridge->gather.error, bridge->request.packet.bytes, bridge->gather.length);
        break;
    }
}

static void begin_gathering(struct bridge *bridge, uint8_t own)
{
    if (gather_begin(&bridge->gather, own, bridge->request.packet.bytes))
        bridge->state = BRIDGE_GATHERING;
    else
        bridge->counters.refused++;
}

/* Whose is it? Apart: a gathering shall not save registers for it. */
NOINLINE static void take(struct bridge *bridge)
{
    struct cds_packet *packet = &bridge->request.packet;
    uint8_t own = device_id(bridge->gather.device);
    uint8_t id, instruction;

    packet->bytes = host_take(bridge->host, packet->bytes);
    bridge->taken_us = bridge->host->whole_us;
    packet->size = (uint16_t)(packet->bytes[CDS_AT_LENGTH] + CDS_AT_LENGTH + 1);
    id = packet->bytes[CDS_AT_ID];
    bridge->request.id = id; // the answer to a packet that changes it has the old one (R2)
    instruction = packet->bytes[CDS_AT_INSTRUCTION];
    if (own <= CDS_ID_MAX && gather_knows(own, id, instruction))
        begin_gathering(bridge, own);
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
        if (bridge->host->whole)
            take(bridge);
        break;
    case BRIDGE_WAITING: await_reply(bridge); break;
    case BRIDGE_DEVICE: ask_device(bridge); break;
    case BRIDGE_GATHERING: gather(bridge); break;
    default: break;
    }
    if (bridge->state == BRIDGE_ANSWERING && answer_put(&bridge->answer, bridge->gather.output))
        bridge->state = BRIDGE_IDLE;
}

bool bridge_talks(const struct bridge *bridge)
{
    return bridge->state == BRIDGE_ANSWERING ||
           (bridge->state == BRIDGE_GATHERING && gather_talks(&bridge->gather));
}

bool bridge_idle(const struct bridge *bridge)
{
    return bridge->state == BRIDGE_IDLE && !bridge->host->whole;
}
