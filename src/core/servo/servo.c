/* SPDX-License-Identifier: MIT */
/* One servo's instructions; see servo.h. */
#include "cds55xx/servo.h"

#include <stddef.h>

#include "bus/bus_internal.h"     // cds_bus_submit_valid()
#include "compiler.h"             // OPTIMIZER_BARRIER()
#include "servo/servo_internal.h" // cds_servo_send()
#include "wire/packet_internal.h" // cds_packet_start()

NOINLINE void cds_servo_start(struct cds_request *request, const uint8_t *data, uint8_t count,
                              uint8_t id, uint8_t instruction)
{
    if (request->result != CDS_PENDING)
        cds_packet_start(&request->packet, data, count, id, instruction);
}

/* No earlier result stays, which would be taken for the answer to this call. */
static enum cds_result refuse(struct cds_request *request, enum cds_result result)
{
    request->result = result;
    return result;
}

NOINLINE enum cds_result cds_servo_send(struct cds_bus *bus, struct cds_request *request)
{
    enum cds_result result;
    const uint8_t *bytes;

    OPTIMIZER_BARRIER(request);
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    result = cds_packet_end(&request->packet);
    if (result != CDS_OK)
        return refuse(request, result);
    bytes = request->packet.bytes;
    request->reply_parameters = 0;
    if (bytes[CDS_AT_ID] == CDS_BROADCAST_ID && bytes[CDS_AT_INSTRUCTION] != CDS_PING)
        request->reply_parameters = CDS_REPLY_NONE; // only PING is answered (R1)
    request->any_length = false;
    return cds_bus_submit_valid(bus, request);
}

static NOINLINE enum cds_result bare(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                     uint8_t instruction)
{
    cds_servo_start(request, NULL, 0, id, instruction);
    return cds_servo_send(bus, request);
}

enum cds_result cds_servo_ping(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    return bare(bus, request, id, CDS_PING);
}

enum cds_result cds_servo_read(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                               uint8_t address, uint8_t length)
{
    struct cds_request *fields = request;
    enum cds_result result;

    OPTIMIZER_BARRIER(fields); // `request` stays where cds_bus_send() gets it: saves 10 cycles
    if (fields->result == CDS_PENDING)
        return CDS_BUSY;
    fields->reply_parameters = length; // before the packet is built: saves 12 cycles
    fields->any_length = false;
    if (!cds_packet_is_length(length))
        return refuse(request, CDS_BAD_ARGUMENT);
    if (length > fields->reply_capacity)
        return refuse(request, CDS_NO_ROOM);
    result = cds_packet_read(&fields->packet, id, address, length);
    if (result == CDS_OK)
        return cds_bus_submit_valid(bus, request);
    return refuse(request, result);
}

static NOINLINE enum cds_result with_data(struct cds_bus *bus, struct cds_request *request,
                                          uint8_t id, uint8_t instruction, uint8_t address,
                                          const uint8_t *data, uint8_t length)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    cds_packet_begin_write(&request->packet, id, instruction, address, data, length);
    return cds_servo_send(bus, request);
}

enum cds_result cds_servo_write(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                uint8_t address, const uint8_t *data, uint8_t length)
{
    return with_data(bus, request, id, CDS_WRITE, address, data, length);
}

/* A WRITE of `count` bytes. data[0] is the address of the first byte; the bytes follow. */
static enum cds_result write_few(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                 const uint8_t *data, uint8_t count)
{
    if (!cds_packet_is_within(data[0], count))
        id = cds_packet_refused_id(&request->packet, id);
    cds_servo_start(request, data, (uint8_t)(1 + count), id, CDS_WRITE);
    return cds_servo_send(bus, request);
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
