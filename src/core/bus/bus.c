/* The exchange in flight; see bus.h. */
#include "cds55xx/bus.h"

#include <stddef.h>
#include <string.h>

#include "compiler.h" // NOINLINE, NOCLONE, COLD, ALWAYS_INLINE

#define RING_MASK (CDS_RING_SIZE - 1)

/* What a program does not use: account.c, asked.c, queue.c and repeat.c have those that do
 * something. Here, so that the linker looks for none of those. */
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

UNUSED void cds_bus_note_packet_(struct cds_bus *bus)
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

UNUSED bool cds_bus_repeat_(struct cds_bus *bus)
{
    (void)bus;
    return false;
}

UNUSED struct cds_request *cds_bus_next_of_(const struct cds_request *request)
{
    (void)request;
    return NULL;
}

UNUSED bool cds_bus_queues_(const struct cds_bus *bus)
{
    (void)bus;
    return false;
}

UNUSED bool cds_bus_insert_(struct cds_bus *bus, struct cds_request *request, uint8_t urgent)
{
    (void)urgent;
    bus->request = request;
    request->next = NULL;
    return true;
}

UNUSED void cds_bus_begin_next_(struct cds_bus *bus, uint8_t result)
{
    (void)bus, (void)result;
}

static void cancel_all(struct cds_bus *bus)
{
    for (; bus->request; bus->request = cds_bus_next_of_(bus->request))
        bus->request->result = CDS_CANCELLED;
}

/* Times are 32 bits wide: a main loop may turn less often than 16 bits of cds_port_ticks() wrap. */
static NOCLONE void set_time(uint32_t *time_us, uint16_t from_now_us)
{
    *time_us = cds_port_now_us() + from_now_us;
}

/* Is that time still to come? A time more than 65 ms ahead is over, also where the bus was not
 * polled for half an hour: nothing waits that long. */
static NOCLONE bool is_to_come(const uint32_t *time_us)
{
    return (uint16_t)((uint32_t)(*time_us - cds_port_now_us() - 1u) >> 16) == 0;
}

/* The rest begins. The reply that was given up had `waited_us` to begin, besides the time its bytes
 * take. */
ALWAYS_INLINE void begin_rest(struct cds_bus *bus, uint16_t waited_us)
{
    if (waited_us >= CDS_STALE_REPLY_US)
        return;
    bus->rests = true;
    set_time(&bus->rest_until_us, CDS_STALE_REPLY_US - waited_us);
}

/* A byte is ten bits of (baud + 1) / 2 us. */
static uint16_t byte_time_us(uint8_t baud)
{
    return (uint16_t)(5u * (baud + 1u));
}

static void set_rate(struct cds_bus *bus, uint8_t baud)
{
    bus->baud = baud;
    bus->byte_time_us = byte_time_us(baud);
}

/* The line is used, or was not free of doubt. From here on it must be quiet for two byte times. */
static NOCLONE void doubt(struct cds_bus *bus, uint8_t line)
{
    bus->line = line;
    set_time(&bus->quiet_from_us, 2u * bus->byte_time_us);
}

void cds_bus_open(struct cds_bus *bus, uint8_t port, uint8_t baud)
{
    bool again = bus->flight != CDS_BUS_CLOSED;

    cds_port_open(port, baud); // first: no handler may run while the struct is cleared
    cancel_all(bus);
    memset(bus, 0, offsetof(struct cds_bus, observer));
    bus->port = port;
    set_rate(bus, baud);
    bus->return_delay_us = CDS_RETURN_DELAY_MAX_US;
    bus->flight = CDS_BUS_IDLE;
    if (again) { // what was asked before may be answered yet
        doubt(bus, CDS_BUS_BUSY);
        begin_rest(bus, 0);
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
    bus->has_ended = false; // what was asked at the old rate is not answered at this one
    cds_link_open(&bus->link, bus->port);
    return CDS_OK;
}

static bool reply_is_due(const struct cds_request *request)
{
    return request->reply_parameters != CDS_REPLY_NONE;
}

/* Is the packet whose head was found the reply that is due? A servo that refuses sends its error
 * bits and no parameters. */
ALWAYS_INLINE bool is_due(const struct cds_bus *bus)
{
    const struct cds_request *request = bus->request;
    uint8_t parameters = (uint8_t)(bus->parser.length - CDS_LENGTH_MIN), id = bus->parser.id;

    if (bus->asked == CDS_BROADCAST_ID ? id > CDS_ID_MAX : id != bus->asked)
        return false;
    if (bus->parser.error & CDS_ERROR_NONE_SUCH)
        return false;
    if (parameters == request->reply_parameters || request->any_length)
        return true;
    if (parameters != 0)
        return false;
    return bus->parser.error & CDS_ERRORS_OF_PACKET;
}

/* The reply that is due is taken from here on, whether all of it is there or not. */
ALWAYS_INLINE void begin_taking(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;
    uint8_t tail = bus->link.rx.tail, id = bus->parser.id, length = bus->parser.length,
            error = bus->parser.error;

    bus->at = (uint8_t)(tail + CDS_AT_PARAMETERS);
    bus->last = (uint8_t)(tail + length + CDS_AT_LENGTH);
    bus->sum = (uint8_t)(id + length + error);
    bus->flight = CDS_BUS_TAKES;
    request->id = id;
    request->length = (uint8_t)(length - CDS_LENGTH_MIN);
    request->error = error;
}

/* Bytes were damaged or lost: what stands on both sides of one must never be joined. All from the
 * first to the last of them goes, and the search begins anew behind it. */
ALWAYS_INLINE void drop_broken(struct cds_bus *bus)
{
    struct cds_link *link = &bus->link;

    do {
        cds_bus_note_break_(bus);
        link->broken = CDS_LINK_WHOLE;
        link->rx.tail = link->whole_from;
    } while (link->broken); // broken again meanwhile: then its first mark is not the first
    bus->parser.is_clean = false;
}

/* A packet begins at the ring's tail; what comes behind `end` is none of it if it is `cut` there.
 * If it is the reply that is due, it is taken from here on; another one is noted when it is whole.
 * False: it depends on bytes that are not there. */
ALWAYS_INLINE bool meet(struct cds_bus *bus, uint8_t end, uint8_t cut)
{
    bool whole = cds_parser_is_whole(&bus->parser, &bus->link.rx, end);

    if (cut && !whole)
        return false;
    if (bus->flight == CDS_BUS_ASKS && is_due(bus)) {
        begin_taking(bus);
        return true;
    }
    if (!whole)
        return false;
    if (cds_parser_take(&bus->parser, &bus->link.rx))
        cds_bus_note_undue_(bus);
    else
        cds_bus_count_(&bus->counters.refuted);
    bus->looked_to = bus->link.rx.tail;
    return true;
}

/* Is there anything in the ring that was not looked at yet? */
ALWAYS_INLINE uint8_t heard(const struct cds_bus *bus)
{
    return (uint8_t)(bus->link.broken | (bus->looked_to ^ bus->link.rx.head));
}

/* Searches what has been heard by now, or by the deadline if that is over, for a packet, up to the
 * damage there may be; but no more than a poll may: neither a long reply nor a babbling line holds
 * up the caller. */
static NOCLONE void search(struct cds_bus *bus)
{
    struct cds_link *link = &bus->link;
    // in this order: what breaks meanwhile lies behind the end
    uint8_t end = bus->closing ? bus->close_at : link->rx.head;
    uint8_t broken = link->broken, at = link->broken_at, parsed;

    if ((uint8_t)(end - at) > CDS_RING_SIZE) // before it
        broken = CDS_LINK_WHOLE;             // as far as is looked at
    if (broken)
        end = at;
    parsed = cds_parser_step(&bus->parser, &link->rx, end);
    bus->looked_to = link->rx.tail;
    if (parsed == CDS_PARSED_REFUTED)
        cds_bus_count_(&bus->counters.refuted);
    if (parsed >= CDS_PARSED_SKIPPED)
        return;
    if (parsed == CDS_PARSED_HEAD && meet(bus, end, (uint8_t)(broken | bus->closing)))
        return;
    bus->looked_to = end; // what stands there depends on bytes that have not come
    if (broken)
        drop_broken(bus);
}

/* The time in units of 2^16 us, two wraps of the timer. */
static uint16_t now_65ms(void)
{
    return (uint16_t)(cds_port_now_us() >> 16);
}

/* Sets the timer to the longest that so many bytes may take, with a return delay in between. */
static NOCLONE void allow(struct cds_bus *bus, uint16_t from, uint16_t bytes,
                          uint16_t return_delay_us)
{
    bus->laps = cds_port_set_timer(bus->port, from, bytes, bus->byte_time_us,
                                   (uint16_t)(return_delay_us + CDS_REPLY_MARGIN_US));
    if (bus->laps)
        bus->over_at = (uint16_t)(now_65ms() + bus->laps + 1u);
}

/* The timer has expired: is that time over? Polls more than a wrap apart see only one expiry of
 * several: for them the clock tells. */
static NOCLONE bool is_over(struct cds_bus *bus)
{
    if (bus->laps == 0 || (int16_t)(now_65ms() - bus->over_at) >= 0)
        return true;
    bus->laps--;
    cds_port_restart_timer(bus->port);
    return false;
}

/* The packet of the first request goes on from its header, which is on the wire. No more than must
 * be: the caller waits, and there is time while the packet is sent. CDS_OK. */
static NOCLONE uint8_t send_rest(struct cds_bus *bus, const struct cds_request *request,
                                 uint8_t begun)
{
    const struct cds_packet *packet = &request->packet;

    cds_link_follow(&bus->link, bus->port, packet->bytes, packet->size, begun);
    bus->flight = CDS_BUS_BEGUN;
    bus->begun_at = cds_port_ticks(); // the deadline is counted from here
    cds_bus_note_sent_(bus);
    return CDS_OK;
}

/* A reply is due, and nothing of it was taken: all that has come is looked at, from the next poll
 * on. True. */
static COLD bool look(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;

    bus->flight = CDS_BUS_ASKS;
    bus->to = request->packet.bytes;
    request->id = bus->asked;
    request->length = 0;
    request->error = 0;
    return true;
}

/* By when the reply must be here, if one is due, and how long it may be. */
ALWAYS_INLINE void set_deadline(struct cds_bus *bus, struct cds_request *request)
{
    uint16_t size = request->packet.size, return_delay_us = bus->return_delay_us;
    uint8_t due = request->reply_parameters;

    if (cds_bus_is_watched_(bus))
        return_delay_us = request->return_delay_us; // the observer was asked
    request->return_delay_us = return_delay_us;
    if (due == CDS_REPLY_NONE) {
        bus->flight = CDS_BUS_TELLS;
        return_delay_us = 0;
    } else { // no servo sends more than it was asked for
        bus->parser.longest = (uint8_t)(due + CDS_LENGTH_MIN);
        if (request->any_length)
            bus->parser.longest = CDS_PARSER_LENGTH_MAX;
        size = (uint16_t)(size + CDS_PACKET_SIZE(due));
    }
    allow(bus, bus->begun_at, size, return_delay_us);
}

/* What is due for the packet that has begun. */
NOCLONE void cds_bus_expect_(struct cds_bus *bus)
{
    bus->asked = bus->request->packet.bytes[CDS_AT_ID];
    cds_bus_note_packet_(bus);
    look(bus);
    bus->parser.is_clean = true;
    bus->closing = false;
    bus->looked_to = bus->link.rx.tail;
    set_deadline(bus, bus->request);
}

/* Looks at the line while nothing of ours is on it. After a byte, or when low, it must be high for
 * two byte times; low for so long without a byte is no use of it but a fault. */
static NOCLONE uint8_t is_quiet(struct cds_bus *bus)
{
    uint8_t line = bus->line;

    if (bus->rests)
        bus->rests = is_to_come(&bus->rest_until_us);
    if (heard(bus)) {
        bus->parser.longest = CDS_PARSER_LENGTH_MAX; // a candidate begun stays one: it may be late
        bus->closing = false;
        search(bus);
        line = CDS_BUS_BUSY;
    } else if (line == CDS_BUS_OK) {
        if (cds_port_line_is_high(bus->port))
            return true;
        line = CDS_BUS_BUSY;
    } else if (cds_port_line_is_high(bus->port) || line != CDS_BUS_FAULT) {
        if (is_to_come(&bus->quiet_from_us))
            return false;
        if (cds_port_line_is_high(bus->port)) {
            bus->line = CDS_BUS_OK;
            return true;
        }
        line = CDS_BUS_FAULT;
    }
    doubt(bus, line);
    return false;
}

/* Puts the header of a packet on the wire; 0: the line or the rest may make it wait. */
ALWAYS_INLINE uint8_t begin_if_quiet(const struct cds_bus *bus)
{
    if ((uint8_t)(bus->line | bus->rests) || heard(bus) || !cds_port_line_is_high(bus->port))
        return 0;
    return cds_link_begin(bus->port, CDS_HEADER);
}

/* Must the first request wait for the end of the rest? */
ALWAYS_INLINE bool must_rest(const struct cds_bus *bus)
{
    return bus->rests && reply_is_due(bus->request) && !bus->request->skips_rest;
}

/* The first request waits for a quiet line, for as long as the longest transaction may take: all
 * but two byte times of it, and then the last look. */
NOCLONE void cds_bus_wait_for_turn_(struct cds_bus *bus)
{
    bus->flight = CDS_BUS_WAITS; // and nobody begins before it, not even on a free line
    bus->last_look = false;
    allow(bus, cds_port_ticks(), CDS_PACKET_SIZE(CDS_REPLY_MAX) - 2u, CDS_RETURN_DELAY_MAX_US);
}

/* The time to wait is over, and this poll did not find the line quiet. What it found may be old, if
 * the poll before was long ago: so the line has two byte times more. False: it had them already. */
ALWAYS_INLINE bool look_once_more(struct cds_bus *bus)
{
    if (bus->last_look)
        return false;
    bus->last_look = true;
    allow(bus, cds_port_ticks(), 2, (uint16_t)-CDS_REPLY_MARGIN_US); // no margin
    return true;
}

/* The first request, which was found good, is sent or waits for that. False: it has waited for too
 * long. In a rest the time to wait for a quiet line begins anew with each poll. */
NOCLONE bool cds_bus_begin_turn_(struct cds_bus *bus)
{
    if (is_quiet(bus)) {
        if (must_rest(bus))
            cds_bus_wait_for_turn_(bus);
        else
            send_rest(bus, bus->request, cds_link_begin(bus->port, CDS_HEADER));
        return true;
    }
    if (bus->flight == CDS_BUS_IDLE)
        cds_bus_wait_for_turn_(bus);
    else if (cds_port_timer_expired(bus->port) && is_over(bus))
        return look_once_more(bus);
    return true;
}

/* It is not its turn yet, as far as is known: it waits behind others, for a quiet line or for the
 * end of a rest, if not only for what the observer says. */
static COLD uint8_t enqueue(struct cds_bus *bus, struct cds_request *request)
{
    uint8_t result = CDS_BAD_ARGUMENT;

    if (bus->flight != CDS_BUS_CLOSED) {
        result = CDS_BUSY;
        if (!bus->request || cds_bus_queues_(bus))
            result = cds_bus_judge_(bus, request);
    }
    request->result = result; // of old, there is no value where the packet was built anew
    if (result != CDS_OK)
        return result;
    request->result = CDS_PENDING;
    if (cds_bus_insert_(bus, request, request->urgent))
        cds_bus_begin_turn_(bus);
    return CDS_OK;
}

/* Is there room for a reply of so many parameters, or of any length? */
static bool has_room(const struct cds_request *request, uint8_t parameters)
{
    return (request->any_length ? CDS_REPLY_ANY : parameters) <= request->packet.room;
}

ALWAYS_INLINE uint8_t begin_if_free(struct cds_bus *bus)
{
    return bus->flight == CDS_BUS_IDLE ? begin_if_quiet(bus) : 0;
}

NOCLONE uint8_t cds_bus_begin_(struct cds_bus *bus)
{
    return cds_bus_is_watched_(bus) ? 0 : begin_if_free(bus);
}

NOCLONE uint8_t cds_bus_begin_judged_(struct cds_bus *bus)
{
    return begin_if_free(bus);
}

NOCLONE uint8_t cds_bus_follow_(struct cds_bus *bus, struct cds_request *request, uint8_t begun)
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
    if ((uint16_t)(request->packet.size - CDS_PACKET_SIZE(0)) > CDS_LENGTH_MAX - CDS_LENGTH_MIN)
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
        cds_bus_begin_next_(bus, CDS_OK); // it has waited for nothing yet
    }
    return CDS_OK;
}

/* A request is over, and who has submitted it may be told: once the next one has begun, so that
 * what on_end submits takes its turn like any other. */
NOINLINE static bool tell_end(struct cds_bus *bus, struct cds_request *ended)
{
    if (ended->on_end)
        ended->on_end(ended);
    return bus->request;
}

/* The first request is over. Returns whether there is more to do, as all below. */
static NOCLONE bool finish(struct cds_bus *bus, uint8_t result)
{
    struct cds_request *request = bus->request;

    bus->flight = CDS_BUS_IDLE;
    bus->request = cds_bus_next_of_(request);
    request->result = result;
    cds_bus_begin_next_(bus, result);
    return tell_end(bus, request);
}

/* The exchange in flight has ended without a good reply: it is sent again, if it may be. */
ALWAYS_INLINE bool fail(struct cds_bus *bus)
{
    uint8_t result = CDS_TIMEOUT;

    if (bus->flight != CDS_BUS_TELLS)
        begin_rest(bus, (uint16_t)(bus->request->return_delay_us + CDS_REPLY_MARGIN_US));
    if (!bus->parser.is_clean) {
        result = CDS_CORRUPT;
        doubt(bus, CDS_BUS_BUSY); // it may be so still
    }
    cds_bus_note_end_(bus, result);
    return cds_bus_repeat_(bus) ? true : finish(bus, result);
}

/* ... well: `next` is the first now. */
ALWAYS_INLINE void note_good(struct cds_bus *bus, struct cds_request *request,
                             struct cds_request *next)
{
    cds_bus_note_end_(bus, CDS_OK);
    bus->flight = CDS_BUS_IDLE;
    bus->request = next;
    request->result = CDS_OK;
}

/* Another one waits. Unless somebody must be told first, its header is on the wire before anything
 * else is done; if the line does not let it, this poll has done enough, and the next one looks. */
NOINLINE static bool end_before(struct cds_bus *bus, struct cds_request *request,
                                struct cds_request *next)
{
    bool watched = cds_bus_is_watched_(bus);
    uint8_t begun = watched ? 0 : begin_if_quiet(bus);

    note_good(bus, request, next);
    if (watched)
        cds_bus_begin_next_(bus, CDS_OK);
    else if (begun)
        send_rest(bus, next, begun);
    else
        cds_bus_wait_for_turn_(bus);
    return tell_end(bus, request);
}

NOINLINE static bool end_well(struct cds_bus *bus)
{
    struct cds_request *request = bus->request, *next = cds_bus_next_of_(request);

    if (next)
        return end_before(bus, request, next);
    note_good(bus, request, NULL);
    return request->on_end ? tell_end(bus, request) : false;
}

/* The timer has expired. Once that is the deadline, what has come by then is still looked at, and
 * nothing behind it, or a line never quiet would let the deadline slip. */
static COLD bool look_at_deadline(struct cds_bus *bus)
{
    if (bus->laps && !is_over(bus))
        return true;
    if (bus->link.state != CDS_LINK_LISTENING) {
        cds_link_abort(&bus->link, bus->port);
    } else {
        if (bus->flight == CDS_BUS_TELLS)
            return true; // it has left just now, and the next poll finds it so
        if (!bus->closing) {
            bus->closing = true;
            bus->close_at = bus->link.rx.head;
            look(bus); // what is taken is all there by now, or it is none
        }
        if (bus->flight == CDS_BUS_ASKS && heard(bus))
            search(bus);
        if (bus->flight != CDS_BUS_ASKS || bus->looked_to != bus->close_at)
            return true;
    }
    return fail(bus);
}

/* Nothing has ended: but is there still time? Asked after the search: what came by then is not
 * late. */
ALWAYS_INLINE bool go_on(struct cds_bus *bus)
{
    return cds_port_timer_expired(bus->port) ? look_at_deadline(bus) : true;
}

/* The first request waits for its turn. */
ALWAYS_INLINE bool wait_on(struct cds_bus *bus)
{
    uint8_t result = cds_bus_judge_(bus, bus->request);

    if (result == CDS_OK) {
        if (cds_bus_begin_turn_(bus))
            return true;
        cds_bus_count_(&bus->counters.unsent);
        result = CDS_LINE_BUSY;
    }
    return finish(bus, result);
}

/* Nothing is in flight. */
static COLD bool poll_idle(struct cds_bus *bus)
{
    if (bus->request)
        return wait_on(bus);
    if (bus->flight != CDS_BUS_CLOSED)
        is_quiet(bus);
    return false;
}

/* All of a reply has come, and its checksum makes the sum wrong. True. */
static COLD bool refute(struct cds_bus *bus)
{
    cds_bus_count_(&bus->counters.refuted);
    cds_parser_refute(&bus->parser, &bus->link.rx);
    return look(bus);
}

/* No reply is taken yet. Of one that may be due the first four bytes say nothing. */
NOINLINE static bool poll_other(struct cds_bus *bus)
{
    uint8_t flight = bus->flight;

    if (flight < CDS_BUS_BEGUN)
        return poll_idle(bus);
    if (flight == CDS_BUS_BEGUN) {
        cds_bus_expect_(bus);
        flight = bus->flight;
    }
    if (flight == CDS_BUS_TELLS && bus->link.state == CDS_LINK_LISTENING)
        return end_well(bus);
    if (cds_port_timer_expired(bus->port))
        return look_at_deadline(bus);
    if ((bus->link.broken || cds_ring_count(&bus->link.rx) > CDS_AT_ERROR) &&
        bus->link.state == CDS_LINK_LISTENING)
        search(bus);
    return true;
}

/* Takes the reply that is due as far as it is there. */
ALWAYS_INLINE bool take(struct cds_bus *bus)
{
    uint8_t at, last = bus->last;

    do {
        uint8_t sum = bus->sum, *to = bus->to, count;

        at = bus->at;
        count = (uint8_t)(bus->link.rx.head - at); // before `broken`, as in search()
        if (count == 0)
            break;
        if (bus->link.broken && (uint8_t)(bus->link.broken_at - at) <= (uint8_t)(last - at))
            return look(bus); // but what stands before damaged bytes may be all of it
        if (count > CDS_BUS_BYTES_PER_POLL)
            count = CDS_BUS_BYTES_PER_POLL;
        do {
            uint8_t byte = bus->link.rx.bytes[at & RING_MASK];

            sum = (uint8_t)(sum + byte);
            if (at == last) {
                if (sum != UINT8_MAX) // the checksum is ~ of the rest
                    return refute(bus);
                at++;
                bus->link.rx.tail = at;
                bus->looked_to = at;
                return end_well(bus);
            }
            at++;
            *to++ = byte;
        } while (--count);
        bus->sum = sum;
        bus->at = at;
        bus->to = to;
    } while (at == last); // the last byte may have come meanwhile
    return go_on(bus);
}

bool cds_bus_poll(struct cds_bus *bus)
{
    if (bus->flight != CDS_BUS_TAKES) {
        bool busy = poll_other(bus);

        if (bus->flight != CDS_BUS_TAKES)
            return busy;
    }
    return take(bus);
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
