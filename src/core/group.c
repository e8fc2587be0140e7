/* Many servos in one packet; see group.h. */
#include "cds55xx/group.h"

#include "cds55xx/servo.h" // cds_servo_send_()
#include "goal.h"          // cds_goal_put()

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

    if (request->result == CDS_PENDING)
        return;
    block[0] = id;
    if ((position | speed) > CDS_VALUE_MAX) // all bits of it are 1
        block[0] = CDS_BROADCAST_ID;        // for which no block may be
    cds_goal_put(block + 1, position, speed);
    cds_packet_sync_put_(&request->packet, block, CDS_GOAL_SIZE);
}

enum cds_result cds_group_sync_send(struct cds_bus *bus, struct cds_request *request)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    return (enum cds_result)cds_servo_send_(bus, request);
}
