/* One servo's instructions; see servo.h. */
#include "cds55xx/servo.h"

#include <stddef.h>

#include "compiler.h" // NOINLINE

/* Instead of that of repeat.c, where nothing is repeated. */
__attribute__((weak)) uint8_t cds_bus_repeats_of_(const struct cds_bus *bus, const uint8_t *bytes)
{
    (void)bus, (void)bytes;
    return 0;
}

/* A request on its way must not be built over, for its buffer is to be sent. */
NOINLINE void cds_servo_start_(struct cds_request *request, const uint8_t *data, uint8_t count,
                               uint8_t id, uint8_t instruction)
{
    if (request->result != CDS_PENDING)
        cds_packet_start_(&request->packet, data, count, id, instruction);
}

/* Whole before its header leaves, if that has not begun: between the two a program with slow
 * handlers would let the line idle for longer than a servo waits. */
NOINLINE uint8_t cds_servo_send_(struct cds_bus *bus, struct cds_request *request, uint8_t begun)
{
    uint8_t result;
    const uint8_t *bytes;

    OPTIMIZER_BARRIER(request);
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    result = (uint8_t)cds_packet_end(&request->packet);
    if (result != CDS_OK)
        return result;
    bytes = request->packet.bytes;
    request->reply_parameters = 0;
    if (bytes[CDS_AT_ID] == CDS_BROADCAST_ID && bytes[CDS_AT_INSTRUCTION] != CDS_PING)
        request->reply_parameters = CDS_REPLY_NONE; // it is answered to PING only (R1)
    request->any_length = false;                    // there is room for what is due
    request->repeats = cds_bus_repeats_of_(bus, bytes);
    if (!begun)
        begun = cds_bus_begin_(bus);
    return cds_bus_follow_(bus, request, begun);
}

static enum cds_result bare(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                            uint8_t instruction)
{
    cds_servo_start_(request, NULL, 0, id, instruction);
    return (enum cds_result)cds_servo_send_(bus, request, 0);
}

enum cds_result cds_servo_ping(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    return bare(bus, request, id, CDS_PING);
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
    if (length > CDS_PACKET_SIZE(2) && length > request->packet.room)
        return CDS_NO_ROOM;
    return CDS_OK;
}

uint8_t cds_servo_follow_read_(struct cds_bus *bus, struct cds_request *request, uint8_t begun,
                               uint8_t id, uint8_t address, uint8_t length)
{
    request->reply_parameters = length;
    request->any_length = false; // there is room for what is due
    cds_packet_build_read_(&request->packet, id, address, length);
    request->repeats = cds_bus_repeats_of_(bus, request->packet.bytes);
    return cds_bus_follow_(bus, request, begun);
}

/* For the one that is asked most the header is on the wire while the rest is built. */
enum cds_result cds_servo_read(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                               uint8_t address, uint8_t length)
{
    uint8_t result = cds_servo_may_read_(request, id, address, length);

    if (result == CDS_OK) {
        uint8_t begun = cds_bus_begin_(bus);

        OPTIMIZER_BARRIER(request);
        result = cds_servo_follow_read_(bus, request, begun, id, address, length);
    }
    return (enum cds_result)result;
}

static enum cds_result with_data(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                 uint8_t instruction, uint8_t address, const uint8_t *data,
                                 uint8_t length)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    cds_packet_begin_write_(&request->packet, id, instruction, address, data, length);
    return (enum cds_result)cds_servo_send_(bus, request, 0);
}

enum cds_result cds_servo_write(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                uint8_t address, const uint8_t *data, uint8_t length)
{
    return with_data(bus, request, id, CDS_WRITE, address, data, length);
}

/* A WRITE of `count` bytes from `address` on, which `data` begins with. */
static enum cds_result write_few(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                 const uint8_t *data, uint8_t count)
{
    if (!cds_packet_is_within_(data[0], count))
        id = cds_packet_refused_id_(&request->packet, id);
    cds_servo_start_(request, data, (uint8_t)(1 + count), id, CDS_WRITE);
    return (enum cds_result)cds_servo_send_(bus, request, 0);
}

enum cds_result cds_servo_write_byte(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                     uint8_t address, uint8_t value)
{
    uint8_t data[2] = {address, value};

    return write_few(bus, request, id, data, 1);
}

enum cds_result cds_servo_write_word(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                     uint8_t address, uint16_t value)
{
    uint8_t data[3] = {address, (uint8_t)value, (uint8_t)(value >> 8)};

    return write_few(bus, request, id, data, 2);
}

enum cds_result cds_servo_reg_write(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                    uint8_t address, const uint8_t *data, uint8_t length)
{
    return with_data(bus, request, id, CDS_REG_WRITE, address, data, length);
}

enum cds_result cds_servo_action(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    return bare(bus, request, id, CDS_ACTION);
}

enum cds_result cds_servo_reset(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    return bare(bus, request, id, CDS_RESET);
}
