/* One servo's instructions; see servo.h. */
#include "cds55xx/servo.h"

/* Instead of that of repeat.c, where nothing is repeated. */
__attribute__((weak)) uint8_t cds_bus_repeats_of_(const struct cds_bus *bus, const uint8_t *bytes)
{
    (void)bus, (void)bytes;
    return 0;
}

/* In each of what follows: a request on its way must not be built over, for its buffer is to be
 * sent; and of a packet that is found good the header is on the wire while the rest is built. */

/* It is built. */
static enum cds_result follow(struct cds_bus *bus, struct cds_request *request, bool begun)
{
    request->repeats = cds_bus_repeats_of_(bus, request->packet.bytes);
    return (enum cds_result)cds_bus_follow_(bus, request, begun);
}

static enum cds_result bare(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                            uint8_t instruction)
{
    uint8_t result;
    bool begun;

    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    result = cds_packet_may_be_bare_(&request->packet, id);
    if (result != CDS_OK)
        return (enum cds_result)result;
    request->reply_parameters = 0;
    if (id == CDS_BROADCAST_ID && instruction != CDS_PING) // who answers to that? (R1)
        request->reply_parameters = CDS_REPLY_NONE;
    else if (!cds_bus_has_room_(request, 0))
        return CDS_NO_ROOM;
    begun = cds_bus_begin_(bus);
    cds_packet_build_bare_(&request->packet, id, instruction);
    return follow(bus, request, begun);
}

enum cds_result cds_servo_ping(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    return bare(bus, request, id, CDS_PING);
}

enum cds_result cds_servo_action(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    return bare(bus, request, id, CDS_ACTION);
}

enum cds_result cds_servo_reset(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    return bare(bus, request, id, CDS_RESET);
}

enum cds_result cds_servo_read(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                               uint8_t address, uint8_t length)
{
    uint8_t result;
    bool begun;

    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    result = cds_packet_may_read_(&request->packet, id, address, length);
    if (result != CDS_OK)
        return (enum cds_result)result;
    if ((length > CDS_PACKET_SIZE(2) || request->any_length) && !cds_bus_has_room_(request, length))
        return CDS_NO_ROOM;
    begun = cds_bus_begin_(bus);
    request->reply_parameters = length;
    cds_packet_build_read_(&request->packet, id, address, length);
    return follow(bus, request, begun);
}

static enum cds_result with_data(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                 uint8_t instruction, uint8_t address, const uint8_t *data,
                                 uint8_t length)
{
    uint8_t result;
    bool begun;

    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    result = cds_packet_may_write_(&request->packet, id, address, length);
    if (result != CDS_OK)
        return (enum cds_result)result;
    request->reply_parameters = CDS_REPLY_NONE;
    if (id != CDS_BROADCAST_ID) { // R1
        request->reply_parameters = 0;
        if (!cds_bus_has_room_(request, 0))
            return CDS_NO_ROOM;
    }
    begun = cds_bus_begin_(bus);
    cds_packet_build_write_(&request->packet, id, instruction, address, data, length);
    return follow(bus, request, begun);
}

enum cds_result cds_servo_write(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                uint8_t address, const uint8_t *data, uint8_t length)
{
    return with_data(bus, request, id, CDS_WRITE, address, data, length);
}

enum cds_result cds_servo_write_byte(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                     uint8_t address, uint8_t value)
{
    return cds_servo_write(bus, request, id, address, &value, 1);
}

enum cds_result cds_servo_write_word(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                     uint8_t address, uint16_t value)
{
    uint8_t data[2] = {(uint8_t)value, (uint8_t)(value >> 8)};

    return cds_servo_write(bus, request, id, address, data, sizeof data);
}

enum cds_result cds_servo_reg_write(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                    uint8_t address, const uint8_t *data, uint8_t length)
{
    return with_data(bus, request, id, CDS_REG_WRITE, address, data, length);
}
