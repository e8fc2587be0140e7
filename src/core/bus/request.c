/* SPDX-License-Identifier: MIT */
/* A request before and after its transaction; see bus.h. */
#include "bus/bus_internal.h" // cds_request_check()
#include "cds55xx/bus.h"
#include "wire/word_internal.h" // cds_word_at()

NOCLONE enum cds_result cds_request_check(const struct cds_request *request)
{
    uint16_t size = request->packet.size;
    uint8_t due = request->reply_parameters;

    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    if (size < CDS_PACKET_SIZE(0) || size > CDS_LENGTH_MAX + 4u)
        return CDS_BAD_ARGUMENT;
    if (due == CDS_REPLY_NONE)
        return CDS_OK;
    if (due > CDS_REPLY_MAX)
        return CDS_BAD_ARGUMENT;
    if (request->any_length)
        due = CDS_REPLY_ANY;
    return due > request->reply_capacity ? CDS_NO_ROOM : CDS_OK;
}

enum cds_result cds_request_byte(const struct cds_request *request, uint8_t index, uint8_t *out)
{
    if (request->result != CDS_OK)
        return (enum cds_result)request->result;
    if (index >= request->length)
        return CDS_REFUSED;
    *out = request->reply[index];
    return CDS_OK;
}

enum cds_result cds_request_word(const struct cds_request *request, uint8_t index, uint16_t *out)
{
    const uint8_t *at;

    if (request->result != CDS_OK)
        return (enum cds_result)request->result;
    if (index + 1u >= request->length)
        return CDS_REFUSED;
    at = request->reply + index;
    *out = cds_word_at(at);
    return CDS_OK;
}
