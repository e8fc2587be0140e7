/* One servo's instructions; see servo.h. */
#include "cds55xx/servo.h"

static bool writes_to(uint8_t address, uint8_t first, uint8_t last)
{
    return first <= address && address <= last;
}

/* May the packet be sent again when nobody knows whether it was carried out? Not if that does
 * something twice, if the servo may answer under another ID or at another rate by then, or if it
 * refuses the second one: a lock is set once (R6). */
static bool bears_repeating(const uint8_t *bytes)
{
    uint8_t first = bytes[CDS_AT_PARAMETERS];
    uint8_t last = (uint8_t)(first + bytes[CDS_AT_LENGTH] - CDS_LENGTH_MIN - 2);

    switch (bytes[CDS_AT_INSTRUCTION]) {
    case CDS_PING:
    case CDS_READ: return true;
    case CDS_WRITE:
        return !writes_to(CDS_REG_ID, first, last) && !writes_to(CDS_REG_BAUD_RATE, first, last) &&
               !writes_to(CDS_REG_LOCK, first, last);
    default: return false;
    }
}

/* Submits the packet just built, if it was. Broadcast is answered to PING only (R1). */
static enum cds_result submit(struct cds_bus *bus, struct cds_request *request,
                              enum cds_result built, uint8_t reply_parameters)
{
    const uint8_t *bytes = request->packet.bytes;

    if (built != CDS_OK)
        return built;
    if (bytes[CDS_AT_ID] == CDS_BROADCAST_ID && bytes[CDS_AT_INSTRUCTION] != CDS_PING)
        reply_parameters = CDS_REPLY_NONE;
    request->reply_parameters = reply_parameters;
    request->repeats = bears_repeating(bytes) ? bus->repeats : 0;
    return cds_bus_submit(bus, request);
}

/* In each: a request on its way must not be built over, for its buffer is to be sent. */

enum cds_result cds_servo_ping(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    return submit(bus, request, cds_packet_ping(&request->packet, id), 0);
}

enum cds_result cds_servo_read(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                               uint8_t address, uint8_t length)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    return submit(bus, request, cds_packet_read(&request->packet, id, address, length), length);
}

enum cds_result cds_servo_write(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                uint8_t address, const uint8_t *data, uint8_t length)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    return submit(bus, request, cds_packet_write(&request->packet, id, address, data, length), 0);
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
    return submit(bus, request, cds_packet_reg_write(&request->packet, id, address, data, length),
                  0);
}

enum cds_result cds_servo_action(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    return submit(bus, request, cds_packet_action(&request->packet, id), 0);
}

enum cds_result cds_servo_reset(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    return submit(bus, request, cds_packet_reset(&request->packet, id), 0);
}
