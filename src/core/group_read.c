/* READs of many servos back to back; see group_read.h. */
#include "cds55xx/group_read.h"

#include "cds55xx/servo.h" // cds_servo_follow_read_()

#include "opaque.h" // CDS_APART

#define COPIED_IN_TIME 12 // bytes: what follows the header has but two byte times

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
        .result = count ? CDS_OK : CDS_BAD_ARGUMENT,
    };
    for (uint8_t i = 0; i < count; i++)
        answers[i].result = CDS_PENDING;
}

/* Servo `next` is done with, so or so. */
static inline void done(struct cds_group_read *read, uint8_t result)
{
    if (read->result == CDS_OK)
        read->result = result;
    read->next++;
    read->sent = false;
}

/* Copies what servo `next` has answered, for its packet will be built over. */
static uint8_t take_data(struct cds_group_read *read)
{
    const uint8_t *from = read->request->packet.bytes;
    uint8_t left = read->length;
    uint8_t *to = &read->data[(uint16_t)read->next * left];

    if (read->request->length != left)
        return CDS_REFUSED;
    do {
        *to++ = *from++;
    } while (--left);
    return CDS_OK;
}

static uint8_t may_send(const struct cds_group_read *read, uint8_t which)
{
    return cds_servo_may_read_(read->request, read->ids[which], read->address, read->length);
}

/* Asks servo `next`, if it may be; its header may be on the wire already. */
static void send(struct cds_group_read *read, uint8_t result, uint8_t begun)
{
    if (result == CDS_OK) {
        if (!begun)
            begun = cds_bus_begin_(read->bus);
        result = cds_servo_follow_read_(read->bus, read->request, begun, read->ids[read->next],
                                        read->address, read->length);
    }
    if (result == CDS_OK) {
        read->sent = true;
    } else if (result != CDS_BUSY) { // an argument: nothing was sent to this servo
        read->answers[read->next].result = result;
        done(read, result);
    }
}

/* The exchange is over. The next one is first, as the bus is idle meanwhile: a short answer is
 * copied while its header is on the wire. */
static void exchange_ended(struct cds_group_read *read)
{
    uint8_t result = read->request->result, error = read->request->error, ended = read->next;
    bool answers = result == CDS_OK, more = (uint8_t)(ended + 1u) < read->count;
    uint8_t may = more ? may_send(read, (uint8_t)(ended + 1u)) : CDS_BUSY, begun = 0;
    struct cds_group_answer *answer;

    if (may == CDS_OK && read->length <= COPIED_IN_TIME)
        begun = cds_bus_begin_(read->bus);
    if (answers)
        result = take_data(read);
    done(read, result);
    if (more)
        send(read, may, begun);
    answer = &read->answers[ended];
    answer->result = result;
    if (answers)
        answer->error = error;
    if (result == CDS_OK) {
        answer->time_us = cds_port_now_us();
        answer->known = true;
    }
}

/* Apart, so that asking while the exchange goes on needs no frame. */
CDS_APART static enum cds_result go_on(struct cds_group_read *read)
{
    if (read->sent)
        exchange_ended(read);
    else if (read->next < read->count)
        send(read, may_send(read, read->next), 0);
    return read->next < read->count ? CDS_PENDING : (enum cds_result)read->result;
}

enum cds_result cds_group_read_poll(struct cds_group_read *read)
{
    if (read->sent && read->request->result == CDS_PENDING)
        return CDS_PENDING;
    return go_on(read);
}

uint32_t cds_group_read_age_us(const struct cds_group_answer *answer)
{
    return answer->known ? cds_port_now_us() - answer->time_us : CDS_GROUP_READ_NEVER;
}
