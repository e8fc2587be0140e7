/* The exchange in flight and the queue behind it; see bus.h. */
#include "cds55xx/bus.h"

#include <stddef.h>
#include <string.h>

#include "opaque.h" // CDS_APART

#define NOBODY    UINT8_MAX // no ID
#define RING_MASK (CDS_RING_SIZE - 1)

/* Kept out of the way of what runs for every byte and every exchange. */
#define SELDOM __attribute__((noinline, cold))

/* Not copied for a bus that is known when the program is linked: by a pointer, an AVR reaches the
 * fields in half as many words. What is only CDS_APART may be copied so: a pointer less, where the
 * time for a byte counts. */
#define ONE_COPY __attribute__((noclone, noinline))

/* What a program does not use: account.c, repeat.c and late.c have those that do something. */
#define UNUSED __attribute__((weak))

UNUSED bool cds_bus_is_watched_(const struct cds_bus *bus)
{
    (void)bus;
    return false;
}

UNUSED uint8_t cds_bus_judge_(struct cds_bus *bus, struct cds_request *request)
{
    (void)bus, (void)request;
    return CDS_OK;
}

UNUSED void cds_bus_note_sent_(struct cds_bus *bus)
{
    (void)bus;
}

UNUSED void cds_bus_note_end_(struct cds_bus *bus, uint8_t result)
{
    (void)bus, (void)result;
}

UNUSED void cds_bus_note_break_(struct cds_bus *bus)
{
    (void)bus;
}

UNUSED void cds_bus_note_undue_(struct cds_bus *bus)
{
    (void)bus;
}

UNUSED void cds_bus_count_(uint16_t *counter)
{
    (void)counter;
}

UNUSED bool cds_bus_repeats_(struct cds_request *request)
{
    (void)request;
    return false;
}

UNUSED void cds_bus_note_given_up_(struct cds_bus *bus)
{
    (void)bus;
}

UNUSED bool cds_bus_owes_(struct cds_bus *bus, uint8_t id)
{
    (void)bus, (void)id;
    return false;
}

static void cancel_all(struct cds_bus *bus)
{
    while (bus->request) {
        bus->request->result = CDS_CANCELLED;
        bus->request = bus->request->next;
    }
}

/* A byte is ten bits of (baud + 1) / 2 us. */
static ONE_COPY void set_rate(struct cds_bus *bus, uint8_t baud)
{
    bus->baud = baud;
    bus->byte_time_us = (uint16_t)(5u * (baud + 1u));
}

static bool give_back(struct cds_bus *bus);

/* From now on it must be quiet for so long. */
static ONE_COPY void hush(struct cds_bus *bus, uint16_t us)
{
    bus->heard_us = cds_port_short_us();
    bus->quiet_us = us;
}

void cds_bus_open(struct cds_bus *bus, uint8_t port, uint8_t baud)
{
    struct cds_bus_observer *observer = bus->observer;
    bool again = bus->flight != CDS_BUS_CLOSED;

    cds_port_open(port, baud); // first: no handler may run while the struct is cleared
    if (bus->flight >= CDS_BUS_FITS)
        give_back(bus);
    cancel_all(bus);
    memset(bus, 0, sizeof *bus);
    bus->observer = observer;
    bus->port = port;
    set_rate(bus, baud);
    bus->return_delay_us = CDS_RETURN_DELAY_MAX_US;
    bus->last_id = NOBODY;
    bus->flight = CDS_BUS_IDLE;
    if (again) { // what was asked before may be answered yet
        bus->line = CDS_BUS_BUSY;
        hush(bus, CDS_RETURN_DELAY_MAX_US + CDS_REPLY_MARGIN_US);
    }
    cds_link_open(&bus->link, port);
}

enum cds_result cds_bus_set_baud(struct cds_bus *bus, uint8_t baud)
{
    if (bus->flight == CDS_BUS_CLOSED || baud > CDS_BAUD_MAX)
        return CDS_BAD_ARGUMENT;
    if (bus->request)
        return CDS_BUSY;
    if (bus->baud == baud)
        return CDS_OK;
    cds_port_open(bus->port, baud);
    set_rate(bus, baud);
    bus->line = CDS_BUS_OK;
    bus->last_id = NOBODY; // what was asked at the old rate is not answered at this one
    bus->owed = false;
    cds_link_open(&bus->link, bus->port);
    return CDS_OK;
}

static bool reply_is_due(const struct cds_request *request)
{
    return request->reply_parameters != CDS_REPLY_NONE;
}

/* May what begins with this ID and LENGTH be the reply that is due? A servo that refuses sends its
 * error bits and no parameters. */
static bool may_be_reply(const struct cds_bus *bus)
{
    const struct cds_request *request = bus->request;
    const struct cds_parser *parser = &bus->parser;
    uint8_t parameters = (uint8_t)(parser->length - CDS_LENGTH_MIN);

    if (request->id == CDS_BROADCAST_ID ? parser->id > CDS_ID_MAX : parser->id != request->id)
        return false;
    return parameters == request->reply_parameters || parameters == 0 || request->any_length;
}

/* It was too soon: the packet stands again as it was sent, and what was taken is looked at as any
 * other bytes, from the next poll on. True. */
static SELDOM bool give_back(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;

    bus->parser.id = request->id;
    bus->parser.length = (uint8_t)(request->length + CDS_LENGTH_MIN);
    bus->parser.sum = (uint8_t)(request->id + bus->parser.length);
    bus->parser.seen = CDS_AT_ERROR;
    request->id = bus->asked;
    request->length = request->reply_parameters;
    if (bus->to) {
        cds_packet_build_read_(&request->packet, bus->asked, bus->address, request->length);
        bus->to = request->packet.bytes;
    }
    bus->flight = CDS_BUS_ASKS;
    return true;
}

/* Something has come of a candidate that is not, or was not found to be, the reply that is due. */
static ONE_COPY void decide(struct cds_bus *bus, uint8_t parsed)
{
    if (parsed == CDS_PARSED_REFUTED) {
        cds_bus_count_(&bus->counters.refuted);
        bus->damaged = 1;
        return;
    }
    cds_bus_note_undue_(bus);
    cds_parser_accept(&bus->parser, &bus->link.rx);
}

/* Bytes were damaged or lost: what stands on both sides of one must never be joined. All from the
 * first to the last of them goes, and the search begins anew behind it. */
static SELDOM void drop_broken(struct cds_bus *bus)
{
    struct cds_link *link = &bus->link;

    do {
        cds_bus_note_break_(bus);
        link->broken = CDS_LINK_WHOLE;
        link->rx.tail = link->whole_from;
    } while (link->broken); // broken again meanwhile: then its first mark is not the first
    cds_parser_begin(&bus->parser, bus->parser.longest);
    bus->damaged = 1;
}

/* Index of the next byte to be examined. */
static uint8_t looked_to(const struct cds_bus *bus)
{
    return (uint8_t)(bus->link.rx.tail + bus->parser.seen);
}

/* Is there anything in the ring that was not looked at yet? */
static inline __attribute__((always_inline)) uint8_t heard(const struct cds_bus *bus)
{
    return (uint8_t)(bus->link.broken | (looked_to(bus) ^ bus->link.rx.head));
}

/* The deadline is over: returns the end of what had come when a poll first saw that. It is still
 * looked at, and nothing behind it, or a line never quiet would let the deadline slip. */
static SELDOM uint8_t end_at_deadline(const struct cds_bus *bus)
{
    uint8_t left = (uint8_t)(bus->close_at - looked_to(bus));

    return left > CDS_RING_SIZE ? looked_to(bus) : bus->close_at; // damage was passed over
}

/* Parses what has been heard by now, or by the deadline if that is over, before and behind the
 * damage there may be, but no more than the poll may still look at: neither a long reply nor a
 * babbling line holds up the caller. True: the reply that is due seems to stand at the ring's tail,
 * by its ID and LENGTH. */
static ONE_COPY bool parse(struct cds_bus *bus)
{
    struct cds_link *link = &bus->link;

    bus->parser.left = CDS_BUS_BYTES_PER_POLL;
    for (;;) {
        uint8_t end = link->rx.head; // before `broken`: a break after this lies behind it
        bool broken;
        uint8_t parsed;

        if (bus->closing)
            end = end_at_deadline(bus);
        broken = link->broken;
        if (broken)
            end = link->broken_at;
        do {
            parsed = cds_parser_scan(&bus->parser, &link->rx, end);
            if (parsed > CDS_PARSED_HEAD)
                decide(bus, parsed);
            else if (parsed && bus->flight == CDS_BUS_ASKS && may_be_reply(bus))
                return true;
        } while (parsed);
        if (!broken || looked_to(bus) != end)
            return false;
        drop_broken(bus);
    }
}

/* Sets the alarm to the longest that so many bytes may take, with a return delay in between. */
static ONE_COPY void allow(struct cds_bus *bus, uint16_t from_us, uint16_t bytes,
                           uint16_t return_delay_us)
{
    bus->laps = cds_port_set_alarm(bus->port, from_us,
                                   (uint32_t)bytes * bus->byte_time_us +
                                       (uint16_t)(return_delay_us + CDS_REPLY_MARGIN_US));
}

/* The alarm rings: is that time over? */
static bool is_over(struct cds_bus *bus)
{
    if (bus->laps == 0)
        return true;
    bus->laps--;
    cds_port_silence_alarm(bus->port);
    return false;
}

/* The packet of the first request goes on from its header, which is on the wire. No more than must
 * be: the caller waits, and there is time while the packet is sent. CDS_OK. */
static ONE_COPY uint8_t send_rest(struct cds_bus *bus, const struct cds_request *request,
                                  uint8_t begun)
{
    const struct cds_packet *packet = &request->packet;

    cds_link_follow(&bus->link, bus->port, packet->bytes, packet->size, begun);
    bus->flight = CDS_BUS_BEGUN;
    bus->heard_us = cds_port_short_us(); // the deadline is counted from here
    cds_bus_note_sent_(bus);
    return CDS_OK;
}

/* Can the packet in flight be built again, when the parameters of the reply that is due have
 * overwritten it? Then nothing may stand behind it but what stood there before. */
static inline __attribute__((always_inline)) bool is_read(const uint8_t *bytes, uint8_t due)
{
    return due <= CDS_PACKET_SIZE(2) && bytes[CDS_AT_INSTRUCTION] == CDS_READ &&
           bytes[CDS_AT_LENGTH] == CDS_LENGTH_MIN + 2 && bytes[CDS_AT_PARAMETERS + 1] == due;
}

/* What is due for the packet that has begun, and by when. */
ONE_COPY void cds_bus_expect_(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;
    const uint8_t *bytes = request->packet.bytes;
    uint16_t size = request->packet.size, return_delay_us = 0;
    uint8_t longest = CDS_LENGTH_MIN, flight = CDS_BUS_TELLS, due = request->reply_parameters;

    if (!cds_bus_is_watched_(bus)) // else it was asked
        request->return_delay_us = bus->return_delay_us;
    bus->asked = request->id = bytes[CDS_AT_ID];
    bus->address = bytes[CDS_AT_PARAMETERS];
    bus->to = is_read(bytes, due) ? request->packet.bytes : NULL;
    bus->due_id = request->id == CDS_BROADCAST_ID ? NOBODY : request->id;
    bus->due_length = (uint8_t)(due + CDS_LENGTH_MIN);
    request->length = 0;
    request->error = 0;
    if (reply_is_due(request)) { // no servo sends more than it was asked for
        flight = CDS_BUS_ASKS;
        request->length = due;
        longest = bus->due_length;
        if (request->any_length)
            longest = CDS_PARSER_LENGTH_MAX;
        size = (uint16_t)(size + CDS_PACKET_SIZE(due));
        return_delay_us = request->return_delay_us;
    }
    bus->flight = flight;
    bus->damaged = 0;
    bus->closing = false;
    cds_parser_begin(&bus->parser, longest);
    allow(bus, bus->heard_us, size, return_delay_us);
}

/* Looks at the line while nothing of ours is on it. After a byte, or when low, it must be high for
 * two byte times; low for so long without a byte is no use of it but a fault. */
static ONE_COPY bool is_quiet(struct cds_bus *bus)
{
    bool high = cds_port_line_is_high(bus->port);
    uint8_t used = heard(bus);

    if (bus->owed)
        cds_bus_owes_(bus, NOBODY); // not for ever
    if (used) {
        bus->parser.longest = CDS_PARSER_LENGTH_MAX; // a candidate begun stays one: it may be late
        bus->closing = false;
        parse(bus);
    }
    if (used || (!high && bus->line != CDS_BUS_BUSY)) {
        uint16_t quiet_us = (uint16_t)(2u * bus->byte_time_us);

        if (bus->line != CDS_BUS_OK && bus->quiet_us > quiet_us)
            quiet_us = bus->quiet_us; // of what was asked before cds_bus_open()
        if (used || bus->line == CDS_BUS_OK)
            bus->line = CDS_BUS_BUSY;
        hush(bus, quiet_us);
    } else if (bus->line != CDS_BUS_OK &&
               ((cds_port_short_us() - bus->heard_us) & CDS_PORT_SHORT_MAX) >= bus->quiet_us) {
        bus->line = high ? CDS_BUS_OK : CDS_BUS_FAULT;
    }
    return bus->line == CDS_BUS_OK;
}

/* Is there nothing to be waited for? A request waits only where the observer, the line or an old
 * answer make it. */
static inline __attribute__((always_inline)) bool is_free(const struct cds_bus *bus)
{
    if (bus->flight != CDS_BUS_IDLE || (uint8_t)(bus->line | bus->owed) || heard(bus))
        return false;
    return cds_port_line_is_high(bus->port);
}

/* Sends the first request if the line and old answers let it. */
static ONE_COPY bool send_if_quiet(struct cds_bus *bus)
{
    const struct cds_request *request = bus->request;

    if (!is_free(bus) &&
        (!is_quiet(bus) || (reply_is_due(request) && cds_bus_owes_(bus, request->id))))
        return false;
    send_rest(bus, request, cds_link_begin(bus->port, CDS_HEADER));
    return true;
}

/* It is the first request's turn, but it must wait, for a quiet line or until an old answer can no
 * longer come: for as long as the longest exchange may take. */
static ONE_COPY void wait_for_turn(struct cds_bus *bus)
{
    bus->flight = CDS_BUS_WAITS; // and nobody begins before it, not even on a free line
    allow(bus, cds_port_short_us(), CDS_PACKET_SIZE(CDS_REPLY_MAX), CDS_RETURN_DELAY_MAX_US);
}

/* The turn of the first request begins, which was found good. */
static ONE_COPY void begin_turn(struct cds_bus *bus)
{
    if (!send_if_quiet(bus))
        wait_for_turn(bus);
}

/* The same of the next one, if there is one. If the observer has changed its mind, the next poll
 * sees. */
static ONE_COPY void begin_next(struct cds_bus *bus)
{
    if (!bus->request)
        return;
    if (cds_bus_judge_(bus, bus->request) == CDS_OK)
        begin_turn(bus);
    else
        wait_for_turn(bus);
}

/* Puts the request into the queue, before those that are less urgent than `urgent`, but never
 * before one in flight, which is the first. */
static ONE_COPY void insert(struct cds_bus *bus, struct cds_request *request, uint8_t urgent)
{
    struct cds_request **place = cds_bus_is_in_flight_(bus) ? &bus->request->next : &bus->request;

    while (*place && (*place)->urgent >= urgent)
        place = &(*place)->next;
    request->next = *place;
    *place = request;
}

/* It is not its turn yet, as far as is known. */
static SELDOM uint8_t enqueue(struct cds_bus *bus, struct cds_request *request)
{
    uint8_t result;

    if (bus->byte_time_us == 0)
        return CDS_BAD_ARGUMENT;
    request->return_delay_us = bus->return_delay_us;
    result = cds_bus_judge_(bus, request);
    if (result != CDS_OK)
        return result;
    request->result = CDS_PENDING;
    request->id = request->packet.bytes[CDS_AT_ID];
    insert(bus, request, request->urgent);
    if (bus->request == request)
        begin_turn(bus);
    return CDS_OK;
}

/* Is there room for a reply of so many parameters, or of any length? */
static bool has_room(const struct cds_request *request, uint8_t parameters)
{
    return (request->any_length ? CDS_REPLY_ANY : parameters) <= request->packet.room;
}

static inline __attribute__((always_inline)) uint8_t begin_if_free(struct cds_bus *bus)
{
    return is_free(bus) ? cds_link_begin(bus->port, CDS_HEADER) : 0;
}

ONE_COPY uint8_t cds_bus_begin_(struct cds_bus *bus)
{
    return cds_bus_is_watched_(bus) ? 0 : begin_if_free(bus);
}

ONE_COPY uint8_t cds_bus_begin_judged_(struct cds_bus *bus)
{
    return begin_if_free(bus);
}

ONE_COPY uint8_t cds_bus_follow_(struct cds_bus *bus, struct cds_request *request, uint8_t begun)
{
    if (!begun)
        return enqueue(bus, request);
    bus->request = request;
    request->result = CDS_PENDING;
    request->next = NULL;
    return send_rest(bus, request, begun);
}

enum cds_result cds_bus_submit(struct cds_bus *bus, struct cds_request *request)
{
    uint8_t due = request->reply_parameters;

    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    if (request->packet.size > CDS_LENGTH_MAX + CDS_AT_INSTRUCTION)
        return CDS_BAD_ARGUMENT;
    if (due != CDS_REPLY_NONE) {
        if (due > CDS_REPLY_MAX)
            return CDS_BAD_ARGUMENT;
        if (!has_room(request, due))
            return CDS_NO_ROOM;
    }
    return (enum cds_result)cds_bus_follow_(bus, request, cds_bus_begin_(bus));
}

enum cds_result cds_bus_cancel(struct cds_bus *bus, struct cds_request *request)
{
    struct cds_request **place = &bus->request;

    while (*place && *place != request)
        place = &(*place)->next;
    if (!*place)
        return CDS_BAD_ARGUMENT;
    if (cds_bus_is_in_flight_(bus) && *place == bus->request)
        return CDS_BUSY;
    *place = request->next;
    request->result = CDS_CANCELLED;
    if (place == &bus->request) {
        bus->flight = CDS_BUS_IDLE;
        begin_next(bus); // it has waited for nothing yet
    }
    return CDS_OK;
}

/* The first request is over, and another waits or somebody is to be told. The next one begins
 * before on_end runs, so that what on_end submits takes its turn like any other; but behind a bad
 * end a poll has done enough, and the next one looks whether the line is quiet. */
static ONE_COPY bool go_further(struct cds_bus *bus, struct cds_request *ended)
{
    if (ended->result == CDS_OK)
        begin_next(bus);
    else if (bus->request)
        wait_for_turn(bus);
    if (ended->on_end)
        ended->on_end(ended);
    return bus->request;
}

/* The first request is over. Returns whether there is more to do, as all below. */
static inline __attribute__((always_inline)) bool finish(struct cds_bus *bus, uint8_t result)
{
    struct cds_request *request = bus->request;
    struct cds_request *next = request->next;

    bus->request = next;
    request->result = result;
    if (next)
        return go_further(bus, request);
    if (request->on_end)
        return go_further(bus, request);
    return false;
}

/* ... not well. */
static SELDOM bool finish_badly(struct cds_bus *bus, uint8_t result)
{
    struct cds_request *request = bus->request;

    bus->flight = CDS_BUS_IDLE;
    bus->request = request->next;
    request->result = result;
    return go_further(bus, request);
}

/* The exchange in flight has ended. */
static void land(struct cds_bus *bus, uint8_t result)
{
    cds_bus_note_end_(bus, result);
    bus->flight = CDS_BUS_IDLE;
}

/* ... without a good reply: it is sent again, if it may be. */
static bool fail(struct cds_bus *bus, uint8_t result)
{
    struct cds_request *request = bus->request;

    request->length = 0;
    request->error = 0;
    if (bus->flight != CDS_BUS_TELLS)
        cds_bus_note_given_up_(bus);
    if (result == CDS_CORRUPT) { // and the line may be so still
        bus->line = CDS_BUS_BUSY;
        hush(bus, (uint16_t)(2u * bus->byte_time_us));
    }
    land(bus, result);
    if (!cds_bus_repeats_(request))
        return finish_badly(bus, result);
    cds_bus_count_(&bus->counters.repeated);
    bus->request = request->next;
    insert(bus, request, (uint8_t)(request->urgent + 1u)); // only what is more urgent goes before
    wait_for_turn(bus);
    return true;
}

/* ... well. */
CDS_APART static bool end_well(struct cds_bus *bus)
{
    land(bus, CDS_OK);
    return finish(bus, CDS_OK);
}

/* Does the reply that is taken end before byte `end` of the ring? */
static bool is_whole(const struct cds_bus *bus, uint8_t end)
{
    uint8_t tail = bus->link.rx.tail;

    return (uint8_t)(bus->last - tail) < (uint8_t)(end - tail);
}

/* How the exchange in flight stands, now that its deadline is over and all was looked at that a
 * poll may look at. */
static uint8_t outcome_late(struct cds_bus *bus)
{
    if (bus->link.state != CDS_LINK_LISTENING) {
        cds_link_abort(&bus->link, bus->port);
        return CDS_TIMEOUT;
    }
    if (bus->flight == CDS_BUS_TELLS) // out in this very moment: the next poll ends it
        return CDS_PENDING;
    if (!bus->closing) {
        bus->closing = true;
        bus->close_at = bus->link.rx.head;
    }
    if (bus->flight >= CDS_BUS_FITS) {
        if (is_whole(bus, bus->close_at))
            return CDS_PENDING; // the next poll takes more of it
        give_back(bus);
    }
    if (looked_to(bus) != end_at_deadline(bus))
        return CDS_PENDING;
    if (bus->damaged || (bus->link.broken && bus->link.broken_at == bus->close_at))
        return CDS_CORRUPT; // of several bytes, or the last
    return CDS_TIMEOUT;
}

/* The alarm has rung. */
CDS_APART static bool look_at_deadline(struct cds_bus *bus)
{
    uint8_t result;

    if (!is_over(bus))
        return true;
    result = outcome_late(bus);
    if (result == CDS_PENDING)
        return true;
    return fail(bus, result);
}

/* Nothing has ended: but is there still time? Asked after parsing: what came by then is not late.
 */
static inline __attribute__((always_inline)) bool go_on(struct cds_bus *bus)
{
    return cds_port_alarm_rings(bus->port) ? look_at_deadline(bus) : true;
}

/* The first request waits for a quiet line. */
static bool wait_for_quiet(struct cds_bus *bus)
{
    uint8_t result = cds_bus_judge_(bus, bus->request);

    if (result == CDS_OK) {
        if (send_if_quiet(bus) || !cds_port_alarm_rings(bus->port) || !is_over(bus))
            return true;
        cds_bus_count_(&bus->counters.unsent);
        result = CDS_LINE_BUSY;
    }
    return finish_badly(bus, result);
}

/* Nothing is in flight. */
static bool poll_idle(struct cds_bus *bus)
{
    if (bus->request)
        return wait_for_quiet(bus);
    if (bus->flight != CDS_BUS_CLOSED)
        is_quiet(bus);
    return false;
}

/* All of a reply has come: is its checksum right? Only then parameters take the place of an
 * instruction packet that could not be built again: one that fails can be sent again. */
CDS_APART static bool end_taking(struct cds_bus *bus, uint8_t end)
{
    const volatile uint8_t *ring = bus->link.rx.bytes;
    struct cds_request *request = bus->request;

    if (!cds_parser_ends_well(&bus->parser, ring[end & RING_MASK]))
        return give_back(bus);
    if (!bus->to) {
        uint8_t *to = request->packet.bytes;

        for (uint8_t at = (uint8_t)(bus->link.rx.tail + CDS_AT_PARAMETERS); at != end; at++)
            *to++ = ring[at & RING_MASK];
    }
    bus->link.rx.tail = (uint8_t)(end + 1u);
    return end_well(bus);
}

/* Takes the parameters from byte `at` of the ring on, up to byte `end`, at least one of them. */
CDS_APART static bool take(struct cds_bus *bus, uint8_t at, uint8_t end)
{
    uint8_t last = bus->last, sum = bus->parser.sum, stop = end;
    uint8_t *to = bus->to;

    if ((uint8_t)(end - at) > (uint8_t)(last - at))
        stop = last;
    if ((uint8_t)(stop - at) > CDS_BUS_BYTES_PER_POLL)
        stop = (uint8_t)(at + CDS_BUS_BYTES_PER_POLL);
    do {
        uint8_t byte = bus->link.rx.bytes[at & RING_MASK];

        sum = (uint8_t)(sum + byte);
        if (to)
            *to++ = byte;
        at++;
    } while (at != stop);
    bus->parser.sum = sum;
    bus->at = at;
    bus->to = to;
    if (at == last) {
        bus->flight = CDS_BUS_ENDS;
        if (at != end && (to || bus->request->length <= CDS_BUS_BYTES_PER_POLL))
            return end_taking(bus, at); // of the others all are copied then: a poll of its own
    }
    return go_on(bus);
}

/* Takes ERROR, byte `at` of the ring, and what has come behind it, up to byte `end`. */
CDS_APART static bool take_error(struct cds_bus *bus, uint8_t at, uint8_t end)
{
    struct cds_request *request = bus->request;
    uint8_t error = bus->link.rx.bytes[at & RING_MASK];

    request->error = error;
    if (error & CDS_ERROR_NONE_SUCH || (request->length != request->reply_parameters &&
                                        !request->any_length && !(error & CDS_ERRORS_OF_PACKET)))
        return give_back(bus);
    bus->parser.sum = (uint8_t)(bus->parser.sum + error);
    bus->at = ++at;
    bus->flight = at == bus->last ? CDS_BUS_ENDS : CDS_BUS_TAKES;
    if (at == end)
        return go_on(bus);
    return at == bus->last ? end_taking(bus, at) : take(bus, at, end);
}

/* The reply that is due seems to stand at the ring's tail, `size` bytes without its checksum: it is
 * taken from now on. True. */
static inline __attribute__((always_inline)) bool begin_taking(struct cds_bus *bus, uint8_t tail,
                                                               uint8_t sum, uint8_t size)
{
    bus->parser.sum = sum;
    bus->parser.seen = 0;
    bus->at = (uint8_t)(tail + CDS_AT_ERROR);
    bus->last = (uint8_t)(tail + size);
    bus->flight = CDS_BUS_FITS;
    return true;
}

/* Does what has come begin just as it should, with the first byte? Almost always, and at 1 Mbps
 * there were no time to look at it as at any other bytes. Returns whether it is taken. */
CDS_APART static bool begins_as_due(struct cds_bus *bus)
{
    const volatile uint8_t *ring = bus->link.rx.bytes;
    uint8_t tail = bus->link.rx.tail, id = bus->due_id, length = bus->due_length;

    if (ring[tail & RING_MASK] != CDS_HEADER ||
        ring[(uint8_t)(tail + 1) & RING_MASK] != CDS_HEADER ||
        ring[(uint8_t)(tail + CDS_AT_ID) & RING_MASK] != id ||
        ring[(uint8_t)(tail + CDS_AT_LENGTH) & RING_MASK] != length || id == NOBODY)
        return false;
    return begin_taking(bus, tail, (uint8_t)(id + length), (uint8_t)(length + CDS_AT_LENGTH));
}

/* Something is in flight for which no reply is taken yet. Searches what comes for one. */
CDS_APART static bool wait_for_reply(struct cds_bus *bus)
{
    uint8_t end = bus->link.rx.head; // before `broken`, as in parse()

    if (bus->link.state != CDS_LINK_LISTENING)
        return go_on(bus);
    if (bus->flight == CDS_BUS_TELLS)
        return end_well(bus);
    if (!(uint8_t)(bus->closing | bus->link.broken | bus->parser.seen)) {
        if ((uint8_t)(end - bus->link.rx.tail) < CDS_AT_ERROR)
            return go_on(bus); // nothing can be said yet
        if (begins_as_due(bus))
            return end == bus->at ? go_on(bus) : take_error(bus, bus->at, end);
    }
    if (!parse(bus))
        return go_on(bus);
    bus->request->id = bus->parser.id;
    bus->request->length = (uint8_t)(bus->parser.length - CDS_LENGTH_MIN);
    begin_taking(bus, bus->link.rx.tail, bus->parser.sum,
                 (uint8_t)(bus->parser.length + CDS_AT_LENGTH));
    end = bus->link.rx.head;
    return bus->link.broken || end == bus->at ? true : take_error(bus, bus->at, end);
}

/* Something has just begun. */
static bool poll_begun(struct cds_bus *bus)
{
    cds_bus_expect_(bus);
    return wait_for_reply(bus);
}

bool cds_bus_poll(struct cds_bus *bus)
{
    uint8_t flight = bus->flight, at, end;

    if (flight < CDS_BUS_FITS) {
        if (flight > CDS_BUS_BEGUN)
            return wait_for_reply(bus);
        return flight == CDS_BUS_BEGUN ? poll_begun(bus) : poll_idle(bus);
    }
    end = bus->link.rx.head; // before `broken`, as in parse()
    at = bus->at;
    if (end == at)
        return go_on(bus);
    if (bus->link.broken) {
        end = bus->link.broken_at;
        if (!is_whole(bus, end)) // what stands before damaged bytes may be all there is to take
            return give_back(bus);
    }
    if (flight == CDS_BUS_ENDS)
        return end_taking(bus, at);
    return flight == CDS_BUS_TAKES ? take(bus, at, end) : take_error(bus, at, end);
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
    const uint8_t *at;

    if (request->result != CDS_OK)
        return (enum cds_result)request->result;
    if (index + 1u >= request->length)
        return CDS_REFUSED;
    at = request->packet.bytes + index;
    *out = (uint16_t)(at[0] | (uint16_t)at[1] << 8);
    return CDS_OK;
}
