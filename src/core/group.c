/* Many servos in one packet; see group.h. */
#include "cds55xx/group.h"

#include <stdbool.h>

#include "goal.h" // cds_goal_put()

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

/* Does a block of this SYNC WRITE hold as many bytes as a goal has? One that did not even have room
 * for address and length is too long already. */
static bool takes_goals(const struct cds_packet *packet)
{
    return packet->room <= CDS_AT_PARAMETERS + 1 ||
           packet->bytes[CDS_AT_PARAMETERS + 1] == CDS_GOAL_SIZE;
}

void cds_group_sync_add_goal(struct cds_request *request, uint8_t id, uint16_t position,
                             uint16_t speed)
{
    uint8_t data[CDS_GOAL_SIZE];

    if (request->result == CDS_PENDING)
        return;
    if (position > CDS_VALUE_MAX || speed > CDS_VALUE_MAX || !takes_goals(&request->packet))
        request->packet.size = CDS_PACKET_REFUSED;
    cds_goal_put(data, position, speed);
    cds_group_sync_add(request, id, data);
}

enum cds_result cds_group_sync_send(struct cds_bus *bus, struct cds_request *request)
{
    uint8_t result;
    uint8_t begun;

    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    result = cds_packet_may_end_(&request->packet);
    if (result != CDS_OK)
        return (enum cds_result)result;
    begun = cds_bus_begin_(bus);
    cds_packet_fill_(&request->packet);
    request->reply_parameters = CDS_REPLY_NONE;
    request->repeats = 0;
    result = cds_bus_follow_(bus, request, begun);
    cds_packet_seal_(&request->packet); // its turn on the wire comes last
    return (enum cds_result)result;
}
