/* The exchange in flight and the queue behind it; see bus.h. */
#include "cds55xx/bus.h"

#include <stddef.h>

static void cancel_all(struct cds_bus *bus)
{
    while (bus->request) {
        bus->request->result = CDS_CANCELLED;
        bus->request = bus->request->next;
    }
}

/* Ten bits of (baud + 1) / 2 us. */
static uint16_t byte_time_us(uint8_t baud)
{
    return (uint16_t)(5u * (baud + 1u));
}

void cds_bus_open(struct cds_bus *bus, uint8_t port, uint8_t baud)
{
    cds_port_open(port, baud); // first: no handler may run while the struct is cleared
    cancel_all(bus);
    *bus = (struct cds_bus){
        .port = port,
        .baud = baud,
        .byte_time_us = byte_time_us(baud),
        .return_delay_us = CDS_RETURN_DELAY_MAX_US,
    };
    cds_link_open(&bus->link, port);
}

enum cds_result cds_bus_set_baud(struct cds_bus *bus, uint8_t baud)
{
    if (bus->byte_time_us == 0 || baud > CDS_BAUD_MAX)
        return CDS_BAD_ARGUMENT;
    if (bus->request)
        return CDS_BUSY;
    cds_port_open(bus->port, baud);
    bus->baud = baud;
    bus->byte_time_us = byte_time_us(baud);
    cds_link_open(&bus->link, bus->port);
    return CDS_OK;
}

void cds_bus_set_repeats(struct cds_bus *bus, uint8_t repeats)
{
    bus->repeats = repeats;
}

void cds_bus_set_return_delay(struct cds_bus *bus, uint16_t return_delay_us)
{
    bus->return_delay_us = return_delay_us;
}

/* The longest this exchange may take from now on, in microseconds. */
static uint32_t time_allowed_us(const struct cds_bus *bus, const struct cds_request *request)
{
    uint16_t bytes = request->packet.size;
    uint32_t time_us = CDS_REPLY_MARGIN_US;

    if (request->reply_parameters != CDS_REPLY_NONE) {
        bytes = (uint16_t)(bytes + CDS_PACKET_SIZE(request->reply_parameters));
        time_us += bus->return_delay_us;
    }
    return time_us + (uint32_t)bytes * bus->byte_time_us;
}

/* LENGTH of the reply that is due: no servo sends more than it was asked for. */
static uint8_t longest_reply(uint8_t due)
{
    return due == CDS_REPLY_NONE ? CDS_LENGTH_MIN : (uint8_t)(due + CDS_LENGTH_MIN);
}

/* Sends the packet of the request at the head of the queue. */
static void start(struct cds_bus *bus)
{
    const struct cds_request *request = bus->request;

    bus->damaged = 0;
    bus->counters.sent++;
    cds_parser_begin(&bus->parser, longest_reply(request->reply_parameters));
    bus->deadline_us = cds_port_now_us() + time_allowed_us(bus, request);
    cds_link_talk(&bus->link, bus->port, request->packet.bytes, request->packet.size);
}

/* Where in the queue the request belongs; never before the one in flight, which is its head. */
static struct cds_request **place_for(struct cds_bus *bus, const struct cds_request *request)
{
    struct cds_request **place = &bus->request->next;

    while (*place && ((*place)->urgent || !request->urgent))
        place = &(*place)->next;
    return place;
}

enum cds_result cds_bus_submit(struct cds_bus *bus, struct cds_request *request)
{
    uint8_t due = request->reply_parameters;
    struct cds_request **place;

    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    if (bus->byte_time_us == 0 || (due > CDS_REPLY_MAX && due != CDS_REPLY_NONE))
        return CDS_BAD_ARGUMENT;
    if (due != CDS_REPLY_NONE && due > request->packet.room)
        return CDS_NO_ROOM;
    request->result = CDS_PENDING;
    request->id = request->packet.bytes[CDS_AT_ID];
    request->error = 0;
    request->length = 0;
    if (!bus->request) {
        request->next = NULL;
        bus->request = request;
        start(bus);
    } else {
        place = place_for(bus, request);
        request->next = *place;
        *place = request;
    }
    return CDS_OK;
}

enum cds_result cds_bus_cancel(struct cds_bus *bus, struct cds_request *request)
{
    struct cds_request **place = &bus->request;

    while (*place && *place != request)
        place = &(*place)->next;
    if (!*place)
        return CDS_BAD_ARGUMENT;
    if (place == &bus->request)
        return CDS_BUSY;
    *place = request->next;
    request->result = CDS_CANCELLED;
    return CDS_OK;
}

static void count_end(struct cds_bus *bus, enum cds_result result)
{
    if (result == CDS_OK)
        bus->counters.ok++;
    else if (result == CDS_CORRUPT)
        bus->counters.corrupt++;
    else
        bus->counters.timeouts++;
}

/* The exchange in flight has ended: sends it again if it may be, else tells and goes on with the
 * next one. That begins before on_end runs, so that what on_end submits takes its turn like any
 * other. */
static void finish(struct cds_bus *bus, enum cds_result result)
{
    struct cds_request *request = bus->request;

    count_end(bus, result);
    if (result != CDS_OK && request->repeats) {
        request->repeats--;
        bus->counters.repeated++;
        start(bus);
        return;
    }
    bus->request = request->next;
    request->result = (uint8_t)result;
    if (bus->request)
        start(bus);
    if (request->on_end)
        request->on_end(request);
}

/* Is the packet at the ring's tail the reply that is due? A servo that refuses sends its error bits
 * and no parameters. */
static bool is_reply(const struct cds_bus *bus)
{
    const struct cds_request *request = bus->request;
    uint8_t id = cds_ring_peek(&bus->link.rx, CDS_AT_ID);
    uint8_t error = cds_ring_peek(&bus->link.rx, CDS_AT_ERROR);
    uint8_t parameters = (uint8_t)(bus->parser.length - CDS_LENGTH_MIN);

    if (request->id == CDS_BROADCAST_ID ? id > CDS_ID_MAX : id != request->id)
        return false;
    if (error & CDS_ERROR_NONE_SUCH)
        return false;
    return parameters == request->reply_parameters ||
           (parameters == 0 && error & CDS_ERRORS_OF_PACKET);
}

/* The instruction packet has served: the reply's parameters take its place in the buffer. */
static void take_reply(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;
    const struct cds_ring *rx = &bus->link.rx;

    request->id = cds_ring_peek(rx, CDS_AT_ID);
    request->error = cds_ring_peek(rx, CDS_AT_ERROR);
    request->length = (uint8_t)(bus->parser.length - CDS_LENGTH_MIN);
    for (uint8_t i = 0; i < request->length; i++)
        request->packet.bytes[i] = cds_ring_peek(rx, (uint8_t)(CDS_AT_PARAMETERS + i));
}

/* Examines one byte. True when the exchange has ended well. */
static bool parse_byte(struct cds_bus *bus)
{
    enum cds_parsed parsed = cds_parser_step(&bus->parser, &bus->link.rx);
    bool ended = false;

    if (parsed == CDS_PARSED_REFUTED) {
        bus->counters.refuted++;
        bus->damaged = 1;
    } else if (parsed == CDS_PARSED_PACKET) {
        ended = is_reply(bus);
        if (ended)
            take_reply(bus);
        else
            bus->counters.foreign++;
        cds_parser_accept(&bus->parser, &bus->link.rx);
    }
    return ended;
}

/* Bytes were damaged or lost: what stands on both sides of one must never be joined. All from the
 * first to the last of them goes, and the search begins anew behind it. */
static void drop_broken(struct cds_bus *bus)
{
    struct cds_link *link = &bus->link;

    do {
        link->broken = 0;
        link->rx.tail = link->whole_from;
    } while (link->broken); // broken again meanwhile: then its first mark is not the first
    cds_parser_begin(&bus->parser, bus->parser.longest);
    bus->damaged = 1;
}

/* Parses up to `end`, an index of the ring. True when the exchange has ended well. */
static bool parse_to(struct cds_bus *bus, uint8_t end)
{
    while ((uint8_t)(bus->link.rx.tail + bus->parser.seen) != end) {
        if (parse_byte(bus))
            return true;
    }
    return false;
}

/* Parses what has been heard by now, before and behind the damage there may be: at most a ring
 * full, so that a babbling line cannot hold up the caller. True when the exchange has ended well.
 */
static bool parse(struct cds_bus *bus)
{
    struct cds_link *link = &bus->link;

    for (uint8_t part = 0; part < 2; part++) {
        uint8_t end = link->rx.head; // before `broken`: a break after this lies behind it
        bool broken = link->broken;

        if (parse_to(bus, broken ? link->broken_at : end))
            return true;
        if (!broken)
            break;
        drop_broken(bus);
    }
    return false;
}

/* How the exchange in flight stands, seen at `now_us`. */
static enum cds_result outcome(struct cds_bus *bus, uint32_t now_us)
{
    bool listening = bus->link.state == CDS_LINK_LISTENING;

    if (listening && (bus->request->reply_parameters == CDS_REPLY_NONE || parse(bus)))
        return CDS_OK;
    if ((int32_t)(now_us - bus->deadline_us) < 0)
        return CDS_PENDING;
    if (!listening)
        cds_link_abort(&bus->link, bus->port);
    return bus->damaged ? CDS_CORRUPT : CDS_TIMEOUT;
}

bool cds_bus_poll(struct cds_bus *bus)
{
    uint32_t now_us = cds_port_now_us(); // before parsing: what came by then is not late
    enum cds_result result;

    if (!bus->request) {
        bus->link.rx.tail = bus->link.rx.head; // nothing is due: whatever it is, it is not ours
        return false;
    }
    result = outcome(bus, now_us);
    if (result != CDS_PENDING)
        finish(bus, result);
    return bus->request;
}

void cds_bus_counters(const struct cds_bus *bus, struct cds_counters *out)
{
    *out = bus->counters;
    out->framing_errors = cds_link_count(&bus->link.framing_errors);
    out->overruns = cds_link_count(&bus->link.overruns);
    out->ring_overflows = cds_link_count(&bus->link.ring_overflows);
    out->echo_errors = cds_link_count(&bus->link.echo_errors);
}

enum cds_result cds_request_byte(const struct cds_request *request, uint8_t index, uint8_t *out)
{
    if (request->result != CDS_OK)
        return (enum cds_result)request->result;
    if (index >= request->length)
        return CDS_REFUSED;
    *out = request->packet.bytes[index];
    return CDS_OK;
}

enum cds_result cds_request_word(const struct cds_request *request, uint8_t index, uint16_t *out)
{
    uint8_t low = 0, high = 0;
    enum cds_result result = cds_request_byte(request, index, &low);

    if (result == CDS_OK)
        result = cds_request_byte(request, (uint8_t)(index + 1), &high);
    if (result == CDS_OK)
        *out = (uint16_t)(low | (uint16_t)high << 8);
    return result;
}
