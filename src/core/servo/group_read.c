/* READs of many servos back to back; see group_read.h. */
#include "cds55xx/group_read.h"

#include "cds55xx/servo.h" // cds_servo_follow_read_()

#include "compiler.h" // NOINLINE

/* Of the READ of servo `next`. */
enum state {
    TO_SEND,
    SENT,
    FOLLOWED, // SENT, and that of the servo behind it may begin as soon as it is over
};

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
        .next = 0,
        .state = TO_SEND,
        .result = count ? CDS_OK : CDS_BAD_ARGUMENT,
    };
    for (; count; count--)
        answers++->result = CDS_PENDING;
}

/* Servo `next` is done with, so or so. */
static inline void done(struct cds_group_read *read, uint8_t result)
{
    if (read->result == CDS_OK)
        read->result = result;
    read->next++;
    read->state = TO_SEND;
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

/* Servo `next` was asked: what may be known of the one behind it is looked up while there is time.
 * What is right of address, length and buffer for the one is for the other. */
static void look_ahead(struct cds_group_read *read)
{
    uint8_t behind = (uint8_t)(read->next + 1u);

    read->state = SENT;
    if (read->length <= COPIED_IN_TIME && behind < read->count && read->ids[behind] <= CDS_ID_MAX)
        read->state = FOLLOWED;
}

/* Asks servo `next`, if it may be; its header may be on the wire already. */
static void send(struct cds_group_read *read, uint8_t begun)
{
    uint8_t id = read->ids[read->next], result = CDS_OK;

    if (!begun) {
        result = cds_servo_may_read_(read->request, id, read->address, read->length);
        if (result == CDS_OK)
            begun = cds_bus_begin_(read->bus);
    }
    if (result == CDS_OK)
        result = cds_servo_follow_read_(read->bus, read->request, begun, id, read->address,
                                        read->length);
    if (result == CDS_OK) {
        look_ahead(read);
    } else if (result != CDS_BUSY) { // an argument: nothing was sent to this servo
        read->answers[read->next].result = result;
        done(read, result);
    }
}

/* The exchange is over. A short answer is copied while the header of the next READ is on the wire.
 */
static void exchange_ended(struct cds_group_read *read, uint8_t begun)
{
    uint8_t result = read->request->result, error = read->request->error, ended = read->next;
    bool answers = result == CDS_OK;
    struct cds_group_answer *answer;

    if (answers)
        result = take_data(read);
    done(read, result);
    if (read->next < read->count)
        send(read, begun);
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
NOINLINE static enum cds_result go_on(struct cds_group_read *read, uint8_t begun)
{
    if (read->state != TO_SEND)
        exchange_ended(read, begun);
    else if (read->next < read->count)
        send(read, 0);
    return read->next < read->count ? CDS_PENDING : (enum cds_result)read->result;
}

/* When an exchange is over the next one is first, as the bus is idle meanwhile. */
enum cds_result cds_group_read_poll(struct cds_group_read *read)
{
    uint8_t begun = 0;

    if (read->state != TO_SEND) {
        if (read->request->result == CDS_PENDING)
            return CDS_PENDING;
        if (read->state == FOLLOWED)
            begun = cds_bus_begin_(read->bus);
    }
    return go_on(read, begun);
}

uint32_t cds_group_read_age_us(const struct cds_group_answer *answer)
{
    return answer->known ? cds_port_now_us() - answer->time_us : CDS_GROUP_READ_NEVER;
}
