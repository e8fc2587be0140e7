/* READs of many servos back to back; see group_read.h. */
#include "cds55xx/group_read.h"

#include <string.h>

#include "cds55xx/servo.h" // cds_servo_read()
#include "compiler.h"      // NOINLINE

void cds_group_read_begin(struct cds_group_read *read, struct cds_bus *bus,
                          struct cds_request *request, const uint8_t *ids, uint8_t count,
                          uint8_t address, uint8_t length, uint8_t *data,
                          struct cds_group_answer *answers)
{
    *read = (struct cds_group_read){
        .bus = bus,
        .request = request,
        .ids = ids,
        .data = data,
        .answers = answers,
        .count = count,
        .address = address,
        .length = length,
        .next = 0,
        .result = count ? CDS_OK : CDS_BAD_ARGUMENT,
    };
    for (; count; count--)
        answers++->result = CDS_PENDING;
}

/* The READ of servo `next` has ended, or was never sent. */
static void note_result(struct cds_group_read *read, uint8_t result)
{
    read->answers[read->next].result = result;
    if (read->result == CDS_OK)
        read->result = result;
    read->next++;
    read->is_sent = false;
}

static void send(struct cds_group_read *read)
{
    uint8_t result;

    if (read->next == read->count)
        return;
    result = (uint8_t)cds_servo_read(read->bus, read->request, read->ids[read->next], read->address,
                                     read->length);
    if (result == CDS_OK)
        read->is_sent = true;
    else if (result != CDS_BUSY) // nothing was sent to this servo
        note_result(read, result);
}

/* The READ has ended. The next one is sent before the data are copied: its reply cannot come before
 * the next poll of the bus. */
static void take(struct cds_group_read *read)
{
    const struct cds_request *request = read->request;
    struct cds_group_answer *answer = &read->answers[read->next];
    uint8_t *data = &read->data[(uint16_t)read->next * read->length];
    uint8_t result = request->result, error = request->error;

    if (result == CDS_OK && request->length != read->length)
        result = CDS_REFUSED;
    if (request->result == CDS_OK)
        answer->error = error;
    note_result(read, result);
    send(read);
    if (result != CDS_OK)
        return;
    memcpy(data, request->reply, read->length);
    answer->time_us = cds_port_now_us();
    answer->known = true;
}

NOINLINE static enum cds_result go_on(struct cds_group_read *read)
{
    if (read->is_sent)
        take(read);
    else
        send(read);
    return read->next < read->count ? CDS_PENDING : (enum cds_result)read->result;
}

enum cds_result cds_group_read_poll(struct cds_group_read *read)
{
    if (read->is_sent && read->request->result == CDS_PENDING)
        return CDS_PENDING;
    return go_on(read);
}

uint32_t cds_group_read_age_us(const struct cds_group_answer *answer)
{
    return answer->known ? cds_port_now_us() - answer->time_us : CDS_GROUP_READ_NEVER;
}
