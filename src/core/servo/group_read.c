/* READs of many servos back to back; see group_read.h. */
#include "cds55xx/group_read.h"

#include <string.h>

#include "bus/steps_internal.h"   // cds_steps_poll()
#include "cds55xx/servo.h"        // cds_servo_read()
#include "wire/packet_internal.h" // cds_packet_set_id()

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

/* The first READ is built. Each of the others is the READ before it with another ID. */
static enum cds_result send(void *operation)
{
    struct cds_group_read *read = (struct cds_group_read *)operation;
    const struct cds_group_read_config *config = &read->config;
    struct cds_request *request = config->request;
    uint8_t id = config->ids[read->next];
    enum cds_result result;

    if (read->is_built && id <= CDS_ID_MAX) {
        cds_packet_set_id(&request->packet, id);
        return cds_bus_submit(config->bus, request);
    }
    result = cds_servo_read(config->bus, request, id, config->address, config->length);
    read->is_built = result == CDS_OK;
    return result;
}

/* Notes the outcome of the READ of the servo before `next`, and copies its reply. */
static void take(struct cds_group_read *read)
{
    uint8_t index = (uint8_t)(read->next - 1u), length = read->config.length;
    struct cds_group_answer *answer = &read->config.answers[index];
    uint8_t result = read->last_result;

    read->is_ended = false;
    if (read->first_result == CDS_OK)
        read->first_result = result;
    answer->result = result;
    if (result == CDS_OK || result == CDS_REFUSED)
        answer->error = read->config.request->error;
    if (result != CDS_OK)
        return;
    memcpy(&read->config.data[(uint16_t)index * length], read->config.request->reply, length);
    answer->time_us = cds_port_now_us();
    answer->known = true;
}

static void ended(void *operation, enum cds_result result)
{
    struct cds_group_read *read = (struct cds_group_read *)operation;

    if (read->is_ended) // the submit to servo `next` was refused
        take(read);
    read->last_result = (uint8_t)result;
    read->is_ended = true;
    read->next++;
    if (read->next < read->config.count)
        return;
    take(read);
    cds_steps_end(&read->steps, (enum cds_result)read->first_result);
}

/* The next READ is on its way before the reply of the last one is copied: error and reply of the
 * request stay until the next poll of the bus. */
enum cds_result cds_group_read_poll(struct cds_group_read *read)
{
    enum cds_result result = cds_steps_poll(&read->steps, read, send, ended);

    if (read->is_ended)
        take(read);
    return result;
}

uint32_t cds_group_read_age_us(const struct cds_group_answer *answer)
{
    return answer->known ? cds_port_now_us() - answer->time_us : CDS_GROUP_READ_NEVER;
}
