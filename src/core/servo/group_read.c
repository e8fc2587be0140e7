/* SPDX-License-Identifier: MIT */
/* The same registers of many servos; see group_read.h. */
#include "cds55xx/group_read.h"

#include <string.h>

#include "cds55xx/port.h"         // cds_port_now_us()
#include "compiler.h"             // OPTIMIZER_BARRIER()
#include "wire/packet_internal.h" // cds_packet_is_length()

static bool is_possible(const struct cds_group_read_config *config, uint8_t id)
{
    return id <= CDS_ID_MAX && cds_packet_is_length(config->length) &&
           cds_packet_is_within(config->address, config->length);
}

static bool next(void *context, struct cds_read_item *item)
{
    struct cds_group_read *read = (struct cds_group_read *)context;
    const struct cds_group_read_config *config = &read->config;
    uint8_t id = config->ids[read->built++];

    *item = (struct cds_read_item){id, config->address, config->length};
    return is_possible(config, id);
}

static uint8_t result_of(const struct cds_group_read *read, const struct cds_request *ended)
{
    if (!is_possible(&read->config, ended->id))
        return CDS_BAD_ARGUMENT;
    if (ended->result == CDS_OK && ended->error & CDS_ERRORS_OF_PACKET)
        return CDS_REFUSED;
    return ended->result;
}

/* Notes the outcome of the READ, and copies the data. */
static bool take(void *context, struct cds_request *ended)
{
    struct cds_group_read *read = (struct cds_group_read *)context;
    uint8_t index, length, result;
    struct cds_group_answer *answer;

    OPTIMIZER_BARRIER(read);
    index = read->taken++;
    length = read->config.length;
    answer = &read->config.answers[index];
    result = result_of(read, ended);
    if (read->first_result == CDS_OK)
        read->first_result = result;
    answer->result = result;
    if (result == CDS_OK || result == CDS_REFUSED)
        answer->error = ended->error;
    if (result == CDS_OK) {
        memcpy(&read->config.data[(uint16_t)index * length], ended->reply, length);
        answer->time_us = cds_port_now_us();
        answer->known = true;
    }
    return true;
}

enum cds_result cds_group_read_begin(struct cds_group_read *read,
                                     const struct cds_group_read_config *config)
{
    const struct cds_read_pipeline_config pipeline = {.bus = config->bus,
                                                      .requests = config->requests,
                                                      .count = config->count,
                                                      .longest = config->length,
                                                      .context = read,
                                                      .next = next,
                                                      .take = take};
    enum cds_result result = cds_read_pipeline_begin(&read->pipeline, &pipeline);

    if (result != CDS_OK)
        return result;
    read->config = *config;
    read->built = read->taken = 0;
    read->first_result = CDS_OK;
    for (uint8_t i = 0; i < config->count; i++)
        config->answers[i].result = CDS_PENDING;
    return CDS_OK;
}

void cds_group_read_abort(struct cds_group_read *read)
{
    cds_read_pipeline_abort(&read->pipeline);
}

enum cds_result cds_group_read_poll(struct cds_group_read *read)
{
    enum cds_result result;

    OPTIMIZER_BARRIER(read);
    if (cds_read_pipeline_is_awaiting(&read->pipeline) &&
        read->pipeline.current->result == CDS_PENDING) // else it was cancelled
        return CDS_PENDING;
    result = cds_read_pipeline_poll(&read->pipeline);
    return result == CDS_OK ? (enum cds_result)read->first_result : result;
}

uint32_t cds_group_read_age_us(const struct cds_group_answer *answer)
{
    return answer->known ? cds_port_now_us() - answer->time_us : CDS_GROUP_READ_NEVER;
}
