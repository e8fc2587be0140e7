/* Compare, write if it differs, read back; see setup.h. */
#include "cds55xx/setup.h"

#include <stdbool.h>
#include <string.h>

#include "cds55xx/servo.h"     // cds_servo_read(), cds_servo_write()
#include "compiler.h"          // OPTIMIZER_BARRIER(), DECLARED_NOINLINE()
#include "service/operation.h" // cds_was_not_sent()

enum setup_phase { COMPARE, WRITE, READ_BACK };

DECLARED_NOINLINE(cds_setup_write_begin);

enum cds_result cds_setup_write_begin(struct cds_setup *setup, struct cds_bus *bus,
                                      struct cds_request *request, uint8_t id, uint8_t address,
                                      const uint8_t *data, uint8_t length)
{
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    if (bus->byte_time_us == 0 || id > CDS_ID_MAX || length == 0 || length >= CDS_TABLE_SIZE ||
        address > (uint8_t)(CDS_TABLE_SIZE - length) ||
        (address <= CDS_REG_BAUD_RATE && address + length > CDS_REG_ID))
        return CDS_BAD_ARGUMENT;
    if (request->packet.room < CDS_PACKET_SIZE(length + 1u))
        return CDS_NO_ROOM;
    *setup = (struct cds_setup){
        .bus = bus,
        .request = request,
        .data = data,
        .id = id,
        .address = address,
        .length = length,
        .phase = COMPARE,
        .result = CDS_PENDING,
    };
    return CDS_OK;
}

static enum cds_result begin_byte(struct cds_setup *setup, struct cds_bus *bus,
                                  struct cds_request *request, uint8_t id, uint8_t address,
                                  uint8_t value)
{
    enum cds_result result =
        cds_setup_write_begin(setup, bus, request, id, address, &setup->own, 1);

    if (result == CDS_OK)
        setup->own = value;
    return result;
}

enum cds_result cds_setup_return_delay_begin(struct cds_setup *setup, struct cds_bus *bus,
                                             struct cds_request *request, uint8_t id,
                                             uint16_t delay_us)
{
    if (delay_us > bus->return_delay_us || delay_us > CDS_RETURN_DELAY_MAX_US)
        return CDS_BAD_ARGUMENT; // the bus would not wait for it
    return begin_byte(setup, bus, request, id, CDS_REG_RETURN_DELAY,
                      (uint8_t)((delay_us + 1u) / 2u));
}

enum cds_result cds_setup_lock_begin(struct cds_setup *setup, struct cds_bus *bus,
                                     struct cds_request *request, uint8_t id)
{
    return begin_byte(setup, bus, request, id, CDS_REG_LOCK, 1);
}

/* Does the servo hold the value? CDS_OK: yes; CDS_PENDING: another one; else it was not read. */
static enum cds_result compare(const struct cds_setup *setup)
{
    const struct cds_request *request = setup->request;

    if (request->result != CDS_OK)
        return (enum cds_result)request->result;
    if (request->length != setup->length)
        return CDS_REFUSED;
    return memcmp(request->packet.bytes, setup->data, setup->length) == 0 ? CDS_OK : CDS_PENDING;
}

static bool has_refused(const struct cds_setup *setup)
{
    return setup->phase == READ_BACK && setup->error & CDS_ERRORS_OF_PACKET;
}

/* What became of the WRITE is for the reading back to say. Even if the servo has refused: perhaps
 * it had carried it out before, and was asked once more. */
static void written(struct cds_setup *setup)
{
    setup->reason = setup->request->result;
    setup->written = !cds_was_not_sent(setup->reason);
    setup->phase = READ_BACK;
    if (setup->reason == CDS_OK)
        setup->reason = CDS_REFUSED; // if it does not hold it then
}

static void exchange_ended(struct cds_setup *setup)
{
    enum cds_result held;

    if (setup->request->result == CDS_OK && !has_refused(setup))
        setup->error = setup->request->error;
    if (setup->request->result == CDS_CANCELLED) {
        setup->result = CDS_CANCELLED;
        return;
    }
    if (setup->phase == WRITE) {
        written(setup);
        return;
    }
    held = compare(setup);
    if (held == CDS_OK)
        setup->error = setup->request->error;
    if (held != CDS_PENDING && (held == CDS_OK || !has_refused(setup)))
        setup->result = (uint8_t)held;
    else if (setup->phase == COMPARE)
        setup->phase = WRITE;
    else
        setup->result = setup->reason;
}

static void send(struct cds_setup *setup)
{
    enum cds_result submitted;

    if (setup->phase == WRITE) {
        submitted = cds_servo_write(setup->bus, setup->request, setup->id, setup->address,
                                    setup->data, setup->length);
    } else {
        submitted =
            cds_servo_read(setup->bus, setup->request, setup->id, setup->address, setup->length);
    }
    setup->in_flight = submitted == CDS_OK;
    if (setup->in_flight && setup->phase == WRITE)
        setup->written = 1;
    if (submitted != CDS_OK &&
        submitted != CDS_BUSY) // the bus's observer: it is not for that servo
        setup->result = (uint8_t)submitted;
}

DECLARED_NOINLINE(cds_setup_poll);

enum cds_result cds_setup_poll(struct cds_setup *setup)
{
    OPTIMIZER_BARRIER(setup);
    if (setup->in_flight) {
        if (setup->request->result == CDS_PENDING)
            return CDS_PENDING;
        setup->in_flight = 0;
        exchange_ended(setup);
    }
    if (setup->result == CDS_PENDING)
        send(setup);
    return (enum cds_result)setup->result;
}
