/* SPDX-License-Identifier: MIT */
/* Compare, write if it differs, read back; see setup.h. */
#include "cds55xx/setup.h"

#include <string.h>

#include "bus/steps_internal.h" // cds_steps_poll(), cds_was_not_sent()
#include "cds55xx/servo.h"      // cds_servo_read(), cds_servo_write()

enum setup_phase { COMPARE, WRITE, READ_BACK } __attribute__((packed));

/* Sets address, length and data. CDS_OK, or CDS_BAD_ARGUMENT. */
static enum cds_result set_value(struct cds_setup *setup, const struct cds_setup_config *config)
{
    uint16_t delay_us = config->return_delay_us;

    setup->length = 1;
    switch (config->setting) {
    case CDS_SETUP_REGISTERS:
        setup->address = config->address;
        setup->length = config->length;
        setup->data = config->data;
        break;
    case CDS_SETUP_RETURN_DELAY:
        if (delay_us > config->bus->return_delay_us || delay_us > CDS_RETURN_DELAY_MAX_US)
            return CDS_BAD_ARGUMENT; // the bus would not wait for it
        setup->address = CDS_REG_RETURN_DELAY;
        setup->own = (uint8_t)((delay_us + 1u) / 2u);
        break;
    case CDS_SETUP_LOCK:
        setup->address = CDS_REG_LOCK;
        setup->own = 1;
        break;
    default: return CDS_BAD_ARGUMENT;
    }
    return setup->id > CDS_ID_MAX || setup->length == 0 || setup->length >= CDS_TABLE_SIZE ||
                   setup->address > (uint8_t)(CDS_TABLE_SIZE - setup->length) ||
                   (setup->address <= CDS_REG_BAUD_RATE &&
                    setup->address + setup->length > CDS_REG_ID)
               ? CDS_BAD_ARGUMENT
               : CDS_OK;
}

enum cds_result cds_setup_begin(struct cds_setup *setup, const struct cds_setup_config *config)
{
    struct cds_setup begun = {.id = config->id, .phase = COMPARE};
    enum cds_result result = set_value(&begun, config);

    if (result == CDS_OK)
        result = cds_steps_check(config->bus, config->request, CDS_PACKET_SIZE(begun.length + 1u),
                                 begun.length);
    if (result != CDS_OK)
        return result;
    *setup = begun;
    cds_steps_begin(&setup->steps, config->bus, config->request);
    return CDS_OK;
}

void cds_setup_abort(struct cds_setup *setup)
{
    cds_steps_abort(&setup->steps);
}

static const uint8_t *data_of(const struct cds_setup *setup)
{
    return setup->data ? setup->data : &setup->own;
}

/* Only the next READ says what became of the WRITE, even if the servo refused it: perhaps it had
 * carried out the first of two. */
static void write_ended(struct cds_setup *setup, enum cds_result result)
{
    setup->is_written = !cds_was_not_sent((uint8_t)result);
    setup->reason = (uint8_t)(result == CDS_OK ? CDS_REFUSED : result);
    setup->phase = READ_BACK;
}

static void ended(void *operation, enum cds_result result)
{
    struct cds_setup *setup = (struct cds_setup *)operation;
    const struct cds_request *request = setup->steps.request;
    bool was_refused = setup->phase == READ_BACK && setup->error & CDS_ERRORS_OF_PACKET;
    bool holds = result == CDS_OK && setup->phase != WRITE &&
                 memcmp(request->reply, data_of(setup), setup->length) == 0;

    if (request->result == CDS_OK && (holds || !was_refused))
        setup->error = request->error;
    if (!setup->steps.is_submitted || result == CDS_CANCELLED)
        cds_steps_end(&setup->steps, result);
    else if (setup->phase == WRITE)
        write_ended(setup, result);
    else if (holds)
        cds_steps_end(&setup->steps, CDS_OK);
    else if (setup->phase == READ_BACK && (result == CDS_OK || was_refused))
        cds_steps_end(&setup->steps, (enum cds_result)setup->reason);
    else if (result != CDS_OK)
        cds_steps_end(&setup->steps, result);
    else
        setup->phase = WRITE;
}

static enum cds_result send(void *operation)
{
    struct cds_setup *setup = (struct cds_setup *)operation;
    struct cds_steps *steps = &setup->steps;

    if (setup->phase == WRITE)
        return cds_servo_write(steps->bus, steps->request, setup->id, setup->address,
                               data_of(setup), setup->length);
    return cds_servo_read(steps->bus, steps->request, setup->id, setup->address, setup->length);
}

enum cds_result cds_setup_poll(struct cds_setup *setup)
{
    return cds_steps_poll(&setup->steps, setup, send, ended);
}
