/* Many servos in one packet; see sync_write.h. */
#include "cds55xx/sync_write.h"

#include "servo/servo_internal.h" // cds_servo_send()
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
    return (enum cds_result)cds_servo_send(bus, request);
}
