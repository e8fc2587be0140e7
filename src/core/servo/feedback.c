/* SPDX-License-Identifier: MIT */
/* What a servo reports of itself; see feedback.h. */
#include "cds55xx/feedback.h"

#include "cds55xx/servo.h"      // cds_servo_read(), CDS_REG_*
#include "compiler.h"           // DECLARED_NOINLINE()
#include "wire/word_internal.h" // cds_word_at()

/* Half the clock's round: beyond it an old time would soon look like a new one. */
#define TOO_OLD_US 0x80000000u

enum cds_result cds_feedback_read(struct cds_bus *bus, struct cds_request *request, uint8_t id)
{
    return cds_servo_read(bus, request, id, CDS_REG_PRESENT_POSITION, CDS_FEEDBACK_SIZE);
}

/* Where a register stands in what was read. */
#define AT(name) (CDS_REG_##name - CDS_REG_PRESENT_POSITION)

void cds_feedback_decode(struct cds_feedback *feedback, const uint8_t *bytes)
{
    feedback->position = cds_word_at(bytes);
    feedback->speed = cds_word_at(&bytes[AT(PRESENT_SPEED)]);
    feedback->load = cds_word_at(&bytes[AT(PRESENT_LOAD)]);
    feedback->voltage = bytes[AT(PRESENT_VOLTAGE)];
    feedback->temperature = bytes[AT(PRESENT_TEMPERATURE)];
    feedback->registered = bytes[AT(REGISTERED_INSTRUCTION)] != 0;
    feedback->moving = bytes[AT(MOVING)] != 0;
}

DECLARED_NOINLINE(cds_feedback_take);

enum cds_result cds_feedback_take(struct cds_feedback *feedback, const struct cds_request *request,
                                  uint32_t time_us)
{
    uint8_t result = request->result;

    if (result == CDS_PENDING)
        return CDS_PENDING;
    if (result == CDS_OK) {
        feedback->error = request->error;
        if (request->length != CDS_FEEDBACK_SIZE)
            result = CDS_REFUSED;
    }
    feedback->result = result & 31u;
    if (result == CDS_OK) {
        cds_feedback_decode(feedback, request->reply);
        feedback->time_us = time_us;
        feedback->known = true;
    } else if (time_us - feedback->time_us >= TOO_OLD_US) {
        feedback->known = false;
    }
    return (enum cds_result)result;
}

uint32_t cds_feedback_age_us(const struct cds_feedback *feedback)
{
    return feedback->known ? cds_port_now_us() - feedback->time_us : CDS_FEEDBACK_NEVER;
}
