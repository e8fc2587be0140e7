/* One servo's instructions; see servo.h. */
#include "cds55xx/servo.h"

/* Instead of that of repeat.c, where nothing is repeated. */
__attribute__((weak)) uint8_t cds_bus_repeats_of_(const struct cds_bus *bus, const uint8_t *bytes)
{
    (void)bus, (void)bytes;
    return 0;
}

/* In each of what follows: a request on its way must not be built over, for its buffer is to be
 * sent. */

/* Submits the packet just built, if it was. Broadcast is answered to PING only (R1). */
static enum cds_result submit(struct cds_bus *bus, struct cds_request *request,
                              enum cds_result built)
{
    const uint8_t *bytes = request->packet.bytes;

    if (built != CDS_OK)
        return built;
    request->reply_parameters = 0;
    if (bytes[CDS_AT_ID] == CDS_BROADCAST_ID && bytes[CDS_AT_INSTRUCTION] != CDS_PING)
        request->reply_parameters = CDS_REPLY_NONE;
    request->repeats = cds_bus_repeats_of_(bus, bytes);
    return cds_bus_submit(bus, request);
}

enum cds_result cds_servo_ping(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    return submit(bus, request, cds_packet_ping(&request->packet, id));
}

uint8_t cds_servo_may_read_(const struct cds_request *request, uint8_t id, uint8_t address,
                            uint8_t length)
{
    uint8_t result;

    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    result = cds_packet_may_read_(&request->packet, id, address, length);
    if (result != CDS_OK)
        return result;
    if ((length > CDS_PACKET_SIZE(2) || request->any_length) && !cds_bus_has_room_(request, length))
        return CDS_NO_ROOM;
    return CDS_OK;
}

uint8_t cds_servo_follow_read_(struct cds_bus *bus, struct cds_request *request, uint8_t begun,
                               uint8_t id, uint8_t address, uint8_t length)
{
    request->reply_parameters = length;
    cds_packet_build_read_(&request->packet, id, address, length);
    request->repeats = cds_bus_repeats_of_(bus, request->packet.bytes);
    return cds_bus_follow_(bus, request, begun);
}

/* For the one that is asked most the header is on the wire while the rest is built. */
enum cds_result cds_servo_read(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                               uint8_t address, uint8_t length)
{
    uint8_t result = cds_servo_may_read_(request, id, address, length);

    if (result == CDS_OK)
        result = cds_servo_follow_read_(bus, request, cds_bus_begin_(bus), id, address, length);
    return (enum cds_result)result;
}

enum cds_result cds_servo_write(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                uint8_t address, const uint8_t *data, uint8_t length)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    return submit(bus, request, cds_packet_write(&request->packet, id, address, data, length));
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
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    return submit(bus, request, cds_packet_reg_write(&request->packet, id, address, data, length));
}

enum cds_result cds_servo_action(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    return submit(bus, request, cds_packet_action(&request->packet, id));
}

enum cds_result cds_servo_reset(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    return submit(bus, request, cds_packet_reset(&request->packet, id));
}
