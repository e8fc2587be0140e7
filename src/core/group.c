/* Many servos in one packet; see group.h. */
#include "cds55xx/group.h"

#include "cds55xx/servo.h" // cds_servo_send_()
#include "goal.h"          // cds_goal_put()
#include "opaque.h"        // CDS_OPAQUE()

enum cds_result cds_group_sync_begin(struct cds_request *request, uint8_t address, uint8_t length)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY; // its packet is to be sent as it is
    return cds_packet_sync_begin(&request->packet, address, length);
}

void cds_group_sync_add(struct cds_request *request, uint8_t id, const uint8_t *data)
{
    if (request->result != CDS_PENDING)
        cds_packet_sync_add(&request->packet, id, data);
}

void cds_group_sync_add_goal(struct cds_request *request, uint8_t id, uint16_t position,
                             uint16_t speed)
{
    uint8_t block[1 + CDS_GOAL_SIZE];
    struct cds_packet *packet = &request->packet;
    uint8_t high = (uint8_t)(position >> 8);

    if (request->result == CDS_PENDING)
        return;
    CDS_OPAQUE(high); // or gcc compares words all the same
    high = (uint8_t)(high | speed >> 8);
    block[0] = id;
    cds_goal_put(block + 1, position, speed);
    cds_packet_append_(packet, block, sizeof block);
    if (!cds_packet_grows_(packet))
        return; // refused: perhaps no byte in the buffer says how long a block is
    if (id > CDS_ID_MAX || high > CDS_VALUE_MAX >> 8 || // all its bits are 1
        packet->bytes[CDS_AT_SYNC_LENGTH] != CDS_GOAL_SIZE)
        packet->size = CDS_PACKET_REFUSED;
}

/* Goals may be many, and late: so the header is first. Nobody answers, and nothing is repeated. */
enum cds_result cds_group_sync_send(struct cds_bus *bus, struct cds_request *request)
{
    uint8_t begun;

    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    if (!cds_packet_grows_(&request->packet))
        return cds_servo_send_(bus, request); // once more, or it was refused
    begun = cds_bus_begin_(bus);
    cds_packet_close_(&request->packet);
    request->reply_parameters = CDS_REPLY_NONE;
    request->repeats = 0;
    return (enum cds_result)cds_bus_follow_(bus, request, begun);
}
