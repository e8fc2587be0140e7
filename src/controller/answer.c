/* A status packet for the host; see answer.h. */
#include "answer.h"

#include "cds55xx/packet.h" // CDS_AT_*

void answer_begin(struct answer *answer, uint8_t id, uint8_t error, const uint8_t *parameters,
                  uint8_t length)
{
    *answer = (struct answer){.parameters = parameters, .id = id, .error = error, .length = length};
}

static uint8_t byte_at(const struct answer *answer, uint16_t at)
{
    if (at >= (uint16_t)(CDS_AT_PARAMETERS + answer->length))
        return (uint8_t)~answer->sum;
    switch (at) {
    case CDS_AT_ID: return answer->id;
    case CDS_AT_LENGTH: return (uint8_t)(answer->length + CDS_LENGTH_MIN);
    case CDS_AT_ERROR: return answer->error;
    default: return at < CDS_AT_ID ? CDS_HEADER : answer->parameters[at - CDS_AT_PARAMETERS];
    }
}

bool answer_put(struct answer *answer, struct cds_ring *ring)
{
    uint16_t end = (uint16_t)CDS_PACKET_SIZE(answer->length);

    while (answer->at < end) {
        uint8_t byte = byte_at(answer, answer->at);

        if (!cds_ring_put(ring, byte))
            return false;
        if (answer->at++ >= CDS_AT_ID)
            answer->sum = (uint8_t)(answer->sum + byte);
    }
    return true;
}
