/* The exchange in flight and the queue behind it; see bus.h. */
#include "cds55xx/bus.h"

#include <stddef.h>
#include <string.h>

#include "opaque.h" // CDS_APART

#define NOBODY         UINT8_MAX // no ID
#define RING_MASK      (CDS_RING_SIZE - 1)
#define TAKEN_PER_POLL 16 // bytes of a reply that is taken as it comes

/* Kept out of the way of what runs for every byte and every exchange. */
#define SELDOM __attribute__((noinline, cold))

/* Not copied for a bus that is known when the program is linked: by a pointer, an AVR reaches the
 * fields in half as many words. What is only CDS_APART may be copied so: a pointer less, where the
 * time for a byte counts. */
#define ONE_COPY __attribute__((noclone, noinline))

/* What a program does not use: account.c and repeat.c have those that do something. */
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

static void expect(struct cds_bus *bus);
static bool give_back(struct cds_bus *bus);

/* The exchange in flight is given up: notes until when its answer may still come. */
static void give_up(struct cds_bus *bus, uint8_t result)
{
    if (bus->flight == CDS_BUS_BEGUN)
        expect(bus);
    if (bus->flight < CDS_BUS_HOPES)
        return;
    if (bus->flight >= CDS_BUS_TAKES)
        give_back(bus);
    bus->last_id = bus->asked;
    bus->last_result = result;
    bus->owed = true;
    bus->late_us = bus->deadline_us + CDS_RETURN_DELAY_MAX_US - bus->request->return_delay_us;
}

void cds_bus_open(struct cds_bus *bus, uint8_t port, uint8_t baud)
{
    bool same = bus->byte_time_us && bus->port == port && bus->baud == baud;
    struct cds_bus_observer *observer = bus->observer;
    uint32_t late_us;
    uint8_t last_id = NOBODY, last_result;
    bool owed = false;

    cds_port_open(port, baud); // first: no handler may run while the struct is cleared
    give_up(bus, CDS_CANCELLED);
    cancel_all(bus);
    late_us = bus->late_us;
    last_result = bus->last_result;
    if (same) { // at another rate no old answer is understood
        last_id = bus->last_id;
        owed = bus->owed;
    }
    memset(bus, 0, sizeof *bus);
    bus->observer = observer;
    bus->port = port;
    set_rate(bus, baud);
    bus->return_delay_us = CDS_RETURN_DELAY_MAX_US;
    bus->late_us = late_us;
    bus->last_id = last_id;
    bus->last_result = last_result;
    bus->owed = owed;
    bus->flight = CDS_BUS_IDLE;
    cds_parser_begin(&bus->parser, CDS_PARSER_LENGTH_MAX); // any packet is of interest: none is due
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

void cds_bus_set_return_delay(struct cds_bus *bus, uint16_t return_delay_us)
{
    bus->return_delay_us = return_delay_us;
}

static bool reply_is_due(const struct cds_request *request)
{
    return request->reply_parameters != CDS_REPLY_NONE;
}

/* Is the packet just found the reply that is due? A servo that refuses sends its error bits and no
 * parameters. */
static bool is_reply(const struct cds_bus *bus)
{
    const struct cds_request *request = bus->request;
    const struct cds_parser *parser = &bus->parser;
    uint8_t parameters = (uint8_t)(parser->length - CDS_LENGTH_MIN);

    if (request->id == CDS_BROADCAST_ID ? parser->id > CDS_ID_MAX : parser->id != request->id)
        return false;
    if (parser->error & CDS_ERROR_NONE_SUCH)
        return false;
    return parameters == request->reply_parameters || request->any_length ||
           (parameters == 0 && parser->error & CDS_ERRORS_OF_PACKET);
}

/* It was too soon, as no reply has come of it: the packet stands again as it was sent, and what was
 * taken is looked at as any other bytes, from the next poll on. True. */
static SELDOM bool give_back(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;

    if (request->length)
        cds_packet_build_read_(&request->packet, bus->asked, bus->address, request->length);
    bus->parser.error = request->error;
    request->id = bus->asked;
    request->error = 0;
    request->length = 0;
    bus->parser.seen = (uint8_t)(bus->at - bus->link.rx.tail);
    bus->parser.id = bus->asked;
    bus->flight = CDS_BUS_ASKS;
    return true;
}

/* Can the packet in flight be built again, when the parameters of the reply that is due have
 * overwritten it? Then nothing may stand behind it but what stood there before. */
static bool is_read(struct cds_bus *bus)
{
    const uint8_t *bytes = bus->request->packet.bytes;
    uint8_t due = bus->request->reply_parameters;

    bus->address = bytes[CDS_AT_PARAMETERS];
    return due <= CDS_PACKET_SIZE(2) && bytes[CDS_AT_INSTRUCTION] == CDS_READ &&
           bytes[CDS_AT_LENGTH] == CDS_LENGTH_MIN + 2 && bytes[CDS_AT_PARAMETERS + 1] == due;
}

/* The reply at the ring's tail, of this ID and LENGTH, is taken from ERROR on: the instruction
 * packet has served, and the parameters take its place in the buffer. True. */
static inline __attribute__((always_inline)) bool start_taking(struct cds_bus *bus, uint8_t id,
                                                               uint8_t length)
{
    struct cds_request *request = bus->request;

    request->id = id;
    request->length = (uint8_t)(length - CDS_LENGTH_MIN);
    bus->to = request->packet.bytes;
    bus->parser.length = length;
    bus->parser.sum = (uint8_t)(id + length);
    bus->count = length;
    bus->at = (uint8_t)(bus->link.rx.tail + CDS_AT_ERROR);
    bus->flight = CDS_BUS_TAKES;
    return true;
}

/* If what has come begins just as the reply that is due, up to LENGTH, it is taken as it comes: at
 * 1 Mbps there were no time to search byte by byte. False: it must be searched for. */
CDS_APART static bool begin_taking(struct cds_bus *bus)
{
    const volatile uint8_t *ring = bus->link.rx.bytes;
    uint8_t tail = bus->link.rx.tail, asked = bus->asked;
    uint8_t length = (uint8_t)(bus->request->reply_parameters + CDS_LENGTH_MIN);

    if (ring[tail & RING_MASK] != CDS_HEADER ||
        ring[(uint8_t)(tail + 1) & RING_MASK] != CDS_HEADER ||
        ring[(uint8_t)(tail + CDS_AT_ID) & RING_MASK] != asked ||
        ring[(uint8_t)(tail + CDS_AT_LENGTH) & RING_MASK] != length)
        return false;
    return start_taking(bus, asked, length);
}

/* A candidate has become something. True when that is the reply that is due. Not inlined: what it
 * needs would be saved and restored for each byte. */
static ONE_COPY bool decide(struct cds_bus *bus, enum cds_parsed parsed)
{
    if (parsed == CDS_PARSED_REFUTED) {
        cds_bus_count_(&bus->counters.refuted);
        bus->damaged = 1;
        return false;
    }
    if (bus->flight == CDS_BUS_ASKS && is_reply(bus))
        return true;
    cds_bus_note_undue_(bus);
    cds_parser_accept(&bus->parser, &bus->link.rx);
    return false;
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
 * babbling line holds up the caller. True: the reply that is due stands at the ring's tail. */
static ONE_COPY bool parse(struct cds_bus *bus)
{
    struct cds_link *link = &bus->link;

    do {
        uint8_t end = link->rx.head; // before `broken`: a break after this lies behind it
        bool broken;

        if (bus->closing)
            end = end_at_deadline(bus);
        broken = link->broken;
        if (broken)
            end = link->broken_at;
        for (; looked_to(bus) != end; bus->count++) {
            enum cds_parsed parsed;

            if (bus->count >= CDS_BUS_BYTES_PER_POLL)
                return false;
            parsed = cds_parser_step(&bus->parser, &link->rx);
            if (parsed != CDS_PARSED_MORE && decide(bus, parsed))
                return true;
        }
        if (!broken)
            return false;
        drop_broken(bus);
    } while (bus->count++ < CDS_BUS_BYTES_PER_POLL);
    return false;
}

/* The longest an exchange may take, of so many bytes both ways, with a reply after so long. */
static uint32_t time_allowed_us(const struct cds_bus *bus, uint16_t bytes, uint16_t return_delay_us)
{
    return (uint32_t)bytes * bus->byte_time_us + (uint16_t)(return_delay_us + CDS_REPLY_MARGIN_US);
}

/* The packet of the first request goes on from its header, which is on the wire. No more than must
 * be: the caller waits, and there is time while the packet is sent. */
static ONE_COPY void send_rest(struct cds_bus *bus, uint8_t begun)
{
    const struct cds_packet *packet = &bus->request->packet;

    cds_link_follow(&bus->link, bus->port, packet->bytes, packet->size, begun);
    bus->flight = CDS_BUS_BEGUN;
    bus->deadline_us = cds_port_now_us(); // to be counted from here
    cds_bus_note_sent_(bus);
}

/* What is due for the packet that has begun, and by when. */
static ONE_COPY void expect(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;
    uint16_t size = request->packet.size, return_delay_us = 0;
    uint8_t longest = CDS_LENGTH_MIN, flight = CDS_BUS_TELLS;

    bus->asked = request->id;
    request->error = 0;
    request->length = 0;
    if (reply_is_due(request)) { // no servo sends more than it was asked for
        flight = CDS_BUS_ASKS;
        longest = (uint8_t)(request->reply_parameters + CDS_LENGTH_MIN);
        if (bus->asked != CDS_BROADCAST_ID && (longest == CDS_LENGTH_MIN || is_read(bus)))
            flight = CDS_BUS_HOPES;
        if (request->any_length)
            longest = CDS_PARSER_LENGTH_MAX;
        size = (uint16_t)(size + CDS_PACKET_SIZE(request->reply_parameters));
        return_delay_us = request->return_delay_us;
    }
    bus->flight = flight;
    bus->damaged = 0;
    bus->closing = false;
    cds_parser_begin(&bus->parser, longest);
    bus->deadline_us += time_allowed_us(bus, size, return_delay_us);
    cds_port_set_alarm(bus->port, bus->deadline_us);
}

bool cds_bus_may_answer_late(const struct cds_bus *bus, uint8_t id, uint32_t now_us)
{
    return bus->owed &&
           (id == bus->last_id || id == CDS_BROADCAST_ID || bus->last_id == CDS_BROADCAST_ID) &&
           (int32_t)(now_us - bus->late_us) < 0;
}

/* Looks at the line while nothing of ours is on it. After a byte, or when low, it must be high for
 * two byte times; low for so long without a byte is no use of it but a fault. */
static ONE_COPY bool is_quiet(struct cds_bus *bus, uint32_t now_us)
{
    bool high = cds_port_line_is_high(bus->port);
    uint8_t used = heard(bus);

    if (bus->owed && (int32_t)(now_us - bus->late_us) >= 0)
        bus->owed = false; // for good: half an hour later the clock would not tell
    if (used) {
        bus->parser.longest = CDS_PARSER_LENGTH_MAX; // a candidate begun stays one: it may be late
        bus->closing = false;
        parse(bus);
        bus->line = CDS_BUS_BUSY;
    } else if (!high && bus->line == CDS_BUS_OK) {
        bus->line = CDS_BUS_BUSY;
        used = 1;
    }
    if (used || (!high && bus->line == CDS_BUS_FAULT))
        bus->heard_us = (uint16_t)now_us;
    else if (bus->line != CDS_BUS_OK &&
             (uint16_t)(now_us - bus->heard_us) >= 2u * bus->byte_time_us)
        bus->line = high ? CDS_BUS_OK : CDS_BUS_FAULT;
    return bus->line == CDS_BUS_OK;
}

/* Sends the first request if the line lets it. If it is not to wait any longer, as it was not let
 * before and its time is over, false. `anew`: it begins to wait, for a quiet line or until an old
 * answer can no longer come, for as long as the longest exchange may take. */
static ONE_COPY bool send_if_quiet(struct cds_bus *bus, bool anew)
{
    const struct cds_request *request = bus->request;
    uint32_t now_us = cds_port_now_us();

    if (is_quiet(bus, now_us) &&
        !(reply_is_due(request) && cds_bus_may_answer_late(bus, request->id, now_us))) {
        send_rest(bus, cds_link_begin(bus->port, CDS_HEADER));
        return true;
    }
    if (anew)
        bus->deadline_us =
            now_us + time_allowed_us(bus, CDS_PACKET_SIZE(CDS_REPLY_MAX), CDS_RETURN_DELAY_MAX_US);
    return (int32_t)(now_us - bus->deadline_us) < 0;
}

/* The turn of the first request begins. If the observer has changed its mind, the next poll sees.
 */
static ONE_COPY void begin_turn(struct cds_bus *bus)
{
    if (bus->request && cds_bus_judge_(bus, bus->request) == CDS_OK)
        send_if_quiet(bus, true);
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

/* Is there nothing to be waited for? A request waits only where the observer, the line or an old
 * answer make it. */
static inline __attribute__((always_inline)) bool is_free(const struct cds_bus *bus)
{
    if (bus->flight != CDS_BUS_IDLE || (uint8_t)(bus->line | bus->owed) || heard(bus))
        return false;
    return cds_port_line_is_high(bus->port);
}

/* It is not its turn yet, as far as is known. */
static SELDOM uint8_t enqueue(struct cds_bus *bus, struct cds_request *request)
{
    uint8_t result;

    if (bus->byte_time_us == 0)
        return CDS_BAD_ARGUMENT;
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
ONE_COPY bool cds_bus_has_room_(const struct cds_request *request, uint8_t parameters)
{
    return (request->any_length ? CDS_REPLY_ANY : parameters) <= request->packet.room;
}

ONE_COPY uint8_t cds_bus_begin_(struct cds_bus *bus)
{
    if (cds_bus_is_watched_(bus) || !is_free(bus))
        return 0;
    return cds_link_begin(bus->port, CDS_HEADER);
}

ONE_COPY uint8_t cds_bus_follow_(struct cds_bus *bus, struct cds_request *request, uint8_t begun)
{
    request->return_delay_us = bus->return_delay_us;
    if (!begun)
        return enqueue(bus, request);
    bus->request = request;
    send_rest(bus, begun); // first: the line waits for it
    request->result = CDS_PENDING;
    request->id = request->packet.bytes[CDS_AT_ID];
    request->next = NULL;
    return CDS_OK;
}

enum cds_result cds_bus_submit(struct cds_bus *bus, struct cds_request *request)
{
    uint8_t due = request->reply_parameters;

    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    if (due != CDS_REPLY_NONE) {
        if (due > CDS_REPLY_MAX)
            return CDS_BAD_ARGUMENT;
        if (!cds_bus_has_room_(request, due))
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
    if (place == &bus->request)
        begin_turn(bus); // it has waited for nothing yet
    return CDS_OK;
}

/* The first request is over, and another waits or somebody is to be told. The next one begins
 * before on_end runs, so that what on_end submits takes its turn like any other. */
static ONE_COPY bool go_further(struct cds_bus *bus, struct cds_request *ended)
{
    if (bus->request)
        begin_turn(bus);
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
    return finish(bus, result);
}

/* The exchange in flight has ended. */
static void land(struct cds_bus *bus, uint8_t result)
{
    cds_bus_note_end_(bus, result);
    bus->flight = CDS_BUS_IDLE;
}

/* ... without a good reply: it is sent again, if it may be. */
static bool fail(struct cds_bus *bus, uint8_t result, uint32_t now_us)
{
    struct cds_request *request = bus->request;

    give_up(bus, result);
    if (result == CDS_CORRUPT) { // and the line may be so still
        bus->line = CDS_BUS_BUSY;
        bus->heard_us = (uint16_t)now_us;
    }
    land(bus, result);
    if (!cds_bus_repeats_(request))
        return finish_badly(bus, result);
    cds_bus_count_(&bus->counters.repeated);
    bus->request = request->next;
    insert(bus, request, (uint8_t)(request->urgent + 1u)); // only what is more urgent goes before
    begin_turn(bus);
    return true;
}

/* ... well. */
CDS_APART static bool end_well(struct cds_bus *bus)
{
    land(bus, CDS_OK);
    return finish(bus, CDS_OK);
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
    if (bus->flight >= CDS_BUS_TAKES) {
        if ((int8_t)(bus->close_at - bus->at) > 0)
            return CDS_PENDING; // the next poll takes more of it
        give_back(bus);
    }
    bus->flight = CDS_BUS_ASKS;
    if (looked_to(bus) != end_at_deadline(bus))
        return CDS_PENDING;
    if (bus->damaged || (bus->link.broken && bus->link.broken_at == bus->close_at))
        return CDS_CORRUPT; // of several bytes, or the last
    return CDS_TIMEOUT;
}

/* The alarm has rung, perhaps too early. */
CDS_APART static bool look_at_deadline(struct cds_bus *bus)
{
    uint32_t now_us = cds_port_now_us();
    uint8_t result;

    if ((int32_t)(now_us - bus->deadline_us) < 0) {
        cds_port_set_alarm(bus->port, bus->deadline_us);
        return true;
    }
    result = outcome_late(bus);
    if (result == CDS_PENDING)
        return true;
    return fail(bus, result, now_us);
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
        if (send_if_quiet(bus, false))
            return true;
        cds_bus_count_(&bus->counters.unsent);
        result = CDS_LINE_BUSY;
    }
    return finish_badly(bus, result);
}

/* Nothing is in flight. */
static bool poll_idle(struct cds_bus *bus)
{
    bus->count = 0;
    if (bus->request)
        return wait_for_quiet(bus);
    if (bus->flight != CDS_BUS_CLOSED)
        is_quiet(bus, cds_port_now_us());
    return false;
}

/* All of a reply has come: is its checksum right? */
CDS_APART static bool end_taking(struct cds_bus *bus, uint8_t at)
{
    if (!cds_parser_ends_well(&bus->parser, bus->link.rx.bytes[at & RING_MASK]))
        return give_back(bus);
    bus->link.rx.tail = (uint8_t)(at + 1u);
    bus->owed = false;
    return end_well(bus);
}

/* Takes ERROR and parameters up to byte `end` of the ring, at least one of them. */
CDS_APART static bool take(struct cds_bus *bus, uint8_t end)
{
    uint8_t at = bus->at, left = bus->count, sum = bus->parser.sum, length = bus->parser.length;
    uint8_t count = (uint8_t)(end - at);
    uint8_t *to = bus->to;

    if (count > TAKEN_PER_POLL)
        count = TAKEN_PER_POLL;
    do {
        uint8_t byte = bus->link.rx.bytes[at & RING_MASK];

        sum = (uint8_t)(sum + byte);
        if (left != length) {
            *to++ = byte;
        } else if (byte & CDS_ERROR_NONE_SUCH) {
            return give_back(bus);
        } else {
            bus->request->error = byte;
        }
        at++;
        left--;
        count--;
    } while (left != 1 && count);
    bus->parser.sum = sum;
    bus->count = left;
    bus->at = at;
    bus->to = to;
    if (left == 1) {
        bus->flight = CDS_BUS_ENDS;
        if (count)
            return end_taking(bus, at);
    }
    return go_on(bus);
}

/* Searches what comes for the reply from here on. One that is found is taken; a long one by the
 * next polls. */
CDS_APART static bool search(struct cds_bus *bus)
{
    uint8_t length;

    bus->flight = CDS_BUS_ASKS;
    bus->count = 0;
    if (!parse(bus))
        return go_on(bus);
    length = bus->parser.length;
    bus->parser.seen = 0;
    start_taking(bus, bus->parser.id, length);
    return length > CDS_BUS_BYTES_PER_POLL ? true : take(bus, (uint8_t)(bus->at + length));
}

/* Something is in flight for which no reply is taken yet. */
CDS_APART static bool wait_for_reply(struct cds_bus *bus)
{
    uint8_t end;

    if (bus->link.state != CDS_LINK_LISTENING)
        return go_on(bus);
    end = bus->link.rx.head; // before `broken`, as in parse()
    if (bus->flight == CDS_BUS_HOPES && !bus->link.broken) {
        if ((uint8_t)(end - bus->link.rx.tail) < CDS_AT_ERROR)
            return go_on(bus);
        if (begin_taking(bus))
            return end == bus->at ? go_on(bus) : take(bus, end);
    }
    return bus->flight == CDS_BUS_TELLS ? end_well(bus) : search(bus);
}

/* Something has just begun. */
static bool poll_begun(struct cds_bus *bus)
{
    expect(bus);
    return wait_for_reply(bus);
}

/* What stands before damaged bytes may be all there is to take. */
static SELDOM bool take_before_damage(struct cds_bus *bus, uint8_t at)
{
    uint8_t end = bus->link.broken_at;

    if (end == at)
        return give_back(bus);
    return bus->flight == CDS_BUS_ENDS ? end_taking(bus, at) : take(bus, end);
}

bool cds_bus_poll(struct cds_bus *bus)
{
    uint8_t flight = bus->flight, at, end;

    if (flight < CDS_BUS_TAKES) {
        if (flight > CDS_BUS_BEGUN)
            return wait_for_reply(bus);
        return flight == CDS_BUS_BEGUN ? poll_begun(bus) : poll_idle(bus);
    }
    end = bus->link.rx.head; // before `broken`, as in parse()
    at = bus->at;
    if (end == at)
        return go_on(bus);
    if (bus->link.broken)
        return take_before_damage(bus, at);
    return flight == CDS_BUS_ENDS ? end_taking(bus, at) : take(bus, end);
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
