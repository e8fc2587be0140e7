/* READs of many servos back to back; see group_read.h. */
#include "cds55xx/group_read.h"

#include <string.h>

#include "bus/steps_internal.h" // cds_steps_poll()
#include "cds55xx/servo.h"      // cds_servo_read()

enum cds_result cds_group_read_begin(struct cds_group_read *read,
                                     const struct cds_group_read_config *config)
{
    enum cds_result result =
        cds_steps_check(config->bus, config->request, CDS_PACKET_SIZE(2), config->length);

    if (config->count == 0)
        result = CDS_BAD_ARGUMENT;
    if (result != CDS_OK)
        return result;
    *read = (struct cds_group_read){.config = *config};
    for (uint8_t i = 0; i < config->count; i++)
        config->answers[i].result = CDS_PENDING;
    cds_steps_begin(&read->steps, config->bus, config->request);
    return CDS_OK;
}

void cds_group_read_abort(struct cds_group_read *read)
{
    cds_steps_abort(&read->steps);
}

static enum cds_result send(void *operation)
{
    struct cds_group_read *read = (struct cds_group_read *)operation;
    const struct cds_group_read_config *config = &read->config;

    return cds_servo_read(config->bus, config->request, config->ids[read->next], config->address,
                          config->length);
}

/* Copies the reply of the servo before `next`, after the READ of the next servo was sent: that has
 * its own packet, and its reply cannot come before the next poll of the bus. */
static void copy(struct cds_group_read *read)
{
    uint8_t index = (uint8_t)(read->next - 1u), length = read->config.length;
    struct cds_group_answer *answer = &read->config.answers[index];

    memcpy(&read->config.data[(uint16_t)index * length], read->config.request->reply, length);
    answer->time_us = cds_port_now_us();
    answer->known = true;
    read->has_data = false;
}

static void ended(void *operation, enum cds_result result)
{
    struct cds_group_read *read = (struct cds_group_read *)operation;
    const struct cds_request *request = read->config.request;
    struct cds_group_answer *answer = &read->config.answers[read->next];

    if (read->has_data) // the submit to servo `next` was refused
        copy(read);
    answer->result = (uint8_t)result;
    if (read->steps.is_sent && request->result == CDS_OK)
        answer->error = request->error;
    read->has_data = result == CDS_OK;
    if (read->first_result == CDS_OK)
        read->first_result = (uint8_t)result;
    read->next++;
    if (read->next == read->config.count)
        cds_steps_end(&read->steps, (enum cds_result)read->first_result);
}

enum cds_result cds_group_read_poll(struct cds_group_read *read)
{
    enum cds_result result = cds_steps_poll(&read->steps, read, send, ended);

    if (read->has_data)
        copy(read);
    return result;
}

uint32_t cds_group_read_age_us(const struct cds_group_answer *answer)
{
    return answer->known ? cds_port_now_us() - answer->time_us : CDS_GROUP_READ_NEVER;
}
