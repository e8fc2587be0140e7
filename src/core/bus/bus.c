/* The transaction in flight; see bus.h. */
#include "cds55xx/bus.h"

#include <stddef.h>
#include <string.h>

#include "bus/bus_internal.h" // cds_stats_add_link()
#include "compiler.h"         // NOINLINE

/* Bits of `gate`: why a packet may not leave at once. */
enum {
    GATE_SUSPECT = 1, // the line was used or low within two byte times
    GATE_FAULT = 2,   // it was low when they were over
    GATE_STALE = 4,   // a stale reply may come: packets that expect a reply wait
    GATE_LOCKED = 8,  // an operation holds the bus
    GATE_LOW = 16,    // it was low since these two byte times began
    GATE_LINE = GATE_SUSPECT | GATE_FAULT | GATE_LOW,
};

/* How far the wait for a quiet line is: `wait`. */
enum {
    WAIT_BEGINS,    // the next poll sets the timer
    WAIT_TIMED,     // until the timer expires
    WAIT_LAST_LOOK, // two byte times more, for a poll that comes late
};

/* ---- time ---- */

static uint16_t now_65ms(void)
{
    return (uint16_t)(cds_port_now_us() >> 16);
}

/* Sets the timer to the longest time `bytes` bytes and `more_us` may take after `from`. */
static NOCLONE void set_deadline(struct cds_bus *bus, uint16_t from, uint16_t bytes,
                                 uint16_t more_us)
{
    bus->timer_wraps = cds_port_set_timer(bus->port, from, bytes, bus->byte_time_us, more_us);
    if (bus->timer_wraps)
        bus->deadline_65ms = (uint16_t)(now_65ms() + bus->timer_wraps + 1u);
}

/* The timer has expired: true if it was for the last time. A poll that comes more than a wrap late
 * sees one expiry of several: then the clock decides. */
static NOCLONE bool is_last_expiry(struct cds_bus *bus)
{
    if (bus->timer_wraps == 0 || (int16_t)(now_65ms() - bus->deadline_65ms) >= 0)
        return true;
    bus->timer_wraps--;
    cds_port_restart_timer(bus->port);
    return false;
}

ALWAYS_INLINE bool deadline_is_over(struct cds_bus *bus)
{
    return cds_port_timer_expired(bus->port) && is_last_expiry(bus);
}

/* ---- the line ---- */

static uint16_t two_byte_times_us(const struct cds_bus *bus)
{
    return (uint16_t)(2u * bus->byte_time_us);
}

/* Microseconds since the rest began, 65535 at the most. */
static NOCLONE uint16_t rested_us(const struct cds_bus *bus)
{
    uint32_t elapsed_us = cds_port_now_us() - bus->rest_from_us;

    return elapsed_us > UINT16_MAX ? UINT16_MAX : (uint16_t)elapsed_us;
}

/* The line was used, or a reply failed: from now on every packet waits for two byte times, and one
 * that expects a reply for `stale_us`, if that is longer. A longer wait under way goes on. */
static NOCLONE void rest(struct cds_bus *bus, uint16_t stale_us)
{
    uint16_t elapsed_us = rested_us(bus), left_us = bus->rest_us;

    left_us = left_us > elapsed_us ? (uint16_t)(left_us - elapsed_us) : 0;
    bus->rest_us = left_us > stale_us ? left_us : stale_us;
    bus->rest_from_us = cds_port_now_us();
    bus->gate = (uint8_t)((bus->gate & ~GATE_LOW) | GATE_SUSPECT | GATE_STALE);
}

/* True if the receiver has stored or damaged bytes since the last search. */
ALWAYS_INLINE uint8_t has_unread_bytes(const struct cds_bus *bus)
{
    return (uint8_t)(bus->link.broken | (bus->parser.position ^ cds_ring_end(&bus->link.rx)));
}

/* A good packet that is not the reply due. */
static COLD void note_unexpected(struct cds_bus *bus)
{
    uint16_t *counter = &bus->stats.unexpected_packets;
    enum cds_bus_event event = CDS_EVENT_UNEXPECTED_PACKET;
    uint8_t id = bus->parser.id;

    if (bus->last_id == id || bus->last_id == CDS_BROADCAST_ID) {
        event = CDS_EVENT_STALE_REPLY;
        counter = &bus->stats.stale_replies;
        if (bus->last_result == CDS_OK) {
            event = CDS_EVENT_DUPLICATE_REPLY;
            counter = &bus->stats.duplicate_replies;
        }
    }
    ++*counter;
    if (bus->hooks)
        bus->hooks->on_packet(bus->hooks->context, event, id, bus->parser.error);
}

/* Bytes were damaged or lost: what stands on both sides of them must never be joined. All up to the
 * last of them goes, and the search begins anew behind it. */
static COLD void drop_damage(struct cds_bus *bus)
{
    struct cds_link *link = &bus->link;

    do {
        cds_stats_add_link(bus);
        link->broken = CDS_LINK_WHOLE;
        cds_parser_skip_damage(&bus->parser, &link->rx, link->whole_from);
    } while (link->broken); // broken again meanwhile: its first mark is not the first
    if (cds_ring_distance(cds_ring_begin(&link->rx), bus->closing_end) > CDS_RING_SIZE)
        bus->closing_end = cds_ring_begin(&link->rx); // the damage reached beyond it
}

/* Gives the parser the bytes up to damage or deadline, if there is any. */
static NOCLONE uint8_t examine(struct cds_bus *bus)
{
    struct cds_link *link = &bus->link;
    // in this order: what breaks meanwhile lies behind the end
    uint8_t end = bus->is_closing ? bus->closing_end : cds_ring_end(&link->rx);
    uint8_t broken = link->broken;
    uint8_t parsed;

    if (broken) {
        if (cds_ring_distance(link->broken_at, end) > CDS_RING_SIZE)
            broken = CDS_LINK_WHOLE; // as far as the end
        else
            end = link->broken_at;
    }
    if (bus->parser.is_in_packet)
        parsed = cds_parser_take(&bus->parser, &link->rx, end);
    else
        parsed = cds_parser_find(&bus->parser, &link->rx, end);
    if (parsed == CDS_PARSED_MALFORMED)
        bus->stats.malformed++;
    if (parsed == CDS_PARSED_MORE && broken) {
        drop_damage(bus);
        parsed = CDS_PARSED_MALFORMED;
    }
    return parsed;
}

/* Bytes came that no request asked for. */
static COLD void examine_unasked(struct cds_bus *bus)
{
    bus->parser.longest = CDS_PARSER_LENGTH_MAX;
    bus->is_closing = false;
    if (examine(bus) == CDS_PARSED_PACKET)
        note_unexpected(bus);
    rest(bus, 0);
    bus->gate &= (uint8_t)~GATE_FAULT;
}

/* The line was in doubt or a reply failed. Opens the gate if the time for that is over. */
static COLD void check_rest(struct cds_bus *bus)
{
    uint16_t elapsed_us = rested_us(bus);
    uint8_t gate = bus->gate;

    if (elapsed_us >= bus->rest_us) {
        bus->rest_us = 0;
        gate &= (uint8_t)~GATE_STALE;
    }
    bus->gate = gate;
    if (cds_port_line_is_high(bus->port)) {
        if (elapsed_us < two_byte_times_us(bus))
            return;
        if (gate & GATE_LOW)
            rest(bus, 0); // high for two byte times from now on
        else
            bus->gate &= (uint8_t)~GATE_LINE;
    } else if (!(gate & GATE_LINE)) {
        rest(bus, 0);
    } else if (gate & GATE_FAULT || elapsed_us >= two_byte_times_us(bus)) {
        rest(bus, 0);
        bus->gate |= GATE_FAULT;
    } else {
        bus->gate |= GATE_LOW;
    }
}

/* Looks at the line while no packet of ours is on it. */
static NOCLONE void watch_line(struct cds_bus *bus)
{
    if (has_unread_bytes(bus))
        examine_unasked(bus);
    else if (bus->gate & (GATE_LINE | GATE_STALE))
        check_rest(bus);
    else if (!cds_port_line_is_high(bus->port))
        rest(bus, 0);
}

/* ---- open, rate, settings ---- */

static void cancel_all(struct cds_bus *bus)
{
    if (bus->request)
        bus->request->result = CDS_CANCELLED;
    if (bus->hooks)
        bus->hooks->cancel(bus->hooks->context, NULL);
}

static void set_rate(struct cds_bus *bus, uint8_t baud_reg)
{
    cds_port_open(bus->port, baud_reg);
    bus->baud_reg = baud_reg;
    bus->byte_time_us = (uint16_t)(5u * (baud_reg + 1u)); // ten bits of (baud_reg + 1) / 2 us
    bus->last_id = CDS_NO_ID; // what was asked before is not answered at this rate
}

void cds_bus_open(struct cds_bus *bus, uint8_t port, uint8_t baud_reg)
{
    const struct cds_bus_hooks *hooks = bus->hooks;
    bool again = bus->state != CDS_BUS_CLOSED;

    cds_port_open(port, baud_reg); // first: no handler may run while the struct is cleared
    cancel_all(bus);
    memset(bus, 0, sizeof *bus);
    bus->hooks = hooks;
    bus->port = port;
    set_rate(bus, baud_reg);
    bus->return_delay_us = CDS_RETURN_DELAY_MAX_US;
    bus->state = CDS_BUS_IDLE;
    if (again)
        rest(bus, CDS_STALE_REPLY_US); // what was asked before may be answered yet
    cds_link_open(&bus->link, port);
}

enum cds_result cds_bus_set_baud(struct cds_bus *bus, uint8_t baud_reg)
{
    if (bus->state == CDS_BUS_CLOSED || baud_reg > CDS_BAUD_MAX)
        return CDS_BAD_ARGUMENT;
    if (bus->request)
        return CDS_BUSY;
    if (bus->baud_reg == baud_reg)
        return CDS_OK;
    set_rate(bus, baud_reg);
    bus->gate &= (uint8_t)~GATE_LINE;
    cds_link_open(&bus->link, bus->port);
    return CDS_OK;
}

enum cds_result cds_bus_attach(struct cds_bus *bus, const struct cds_bus_hooks *hooks)
{
    if (bus->request || (bus->hooks && bus->hooks != hooks))
        return CDS_BUSY;
    bus->hooks = hooks;
    return CDS_OK;
}

enum cds_result cds_bus_lock(struct cds_bus *bus, const struct cds_bus_lock *lock)
{
    if (bus->state == CDS_BUS_CLOSED)
        return CDS_BAD_ARGUMENT;
    if (bus->lock && bus->lock != lock)
        return CDS_BUSY;
    bus->lock = lock;
    bus->gate |= GATE_LOCKED;
    return CDS_OK;
}

void cds_bus_unlock(struct cds_bus *bus, const struct cds_bus_lock *lock)
{
    if (bus->lock != lock)
        return;
    bus->lock = NULL;
    bus->gate &= (uint8_t)~GATE_LOCKED;
}

bool cds_bus_is_resting(const struct cds_bus *bus)
{
    return bus->gate & GATE_STALE;
}

enum cds_bus_line cds_bus_line(const struct cds_bus *bus)
{
    if (bus->gate & GATE_FAULT)
        return CDS_BUS_LINE_FAULT;
    return bus->gate & GATE_SUSPECT ? CDS_BUS_LINE_SUSPECT : CDS_BUS_LINE_QUIET;
}

/* ---- a packet begins ---- */

static bool reply_is_due(const struct cds_request *request)
{
    return request->reply_parameters != CDS_REPLY_NONE && !request->is_muted;
}

/* The one function that begins a packet. CDS_OK: it is on its way; CDS_LINE_BUSY, CDS_PENDING: not
 * now; else the permit refuses it. */
static NOCLONE uint8_t begin_packet(struct cds_bus *bus, struct cds_request *request)
{
    if (bus->hooks) {
        uint8_t result = (uint8_t)bus->hooks->permit(bus->hooks->context, request);

        if (result != CDS_OK)
            return result;
    }
    if (has_unread_bytes(bus))
        return CDS_LINE_BUSY;
    if (!cds_port_line_is_high(bus->port)) {
        rest(bus, 0); // amid a byte, which may be high at the next look
        return CDS_LINE_BUSY;
    }
    cds_link_talk(&bus->link, bus->port, request->packet.bytes, request->packet.size);
    bus->begun_ticks = cds_port_ticks(); // the deadline counts from here
    bus->request = request;
    bus->state = CDS_BUS_SENDING;
    bus->stats.sent++;
    return CDS_OK;
}

/* The request waits until line and permit agree. */
static void wait_for_line(struct cds_bus *bus, struct cds_request *request)
{
    bus->request = request;
    bus->state = CDS_BUS_WAITING_FOR_LINE;
    bus->wait = WAIT_BEGINS;
}

void cds_bus_start(struct cds_bus *bus, struct cds_request *request)
{
    if (bus->gate & (GATE_LINE | GATE_STALE) || begin_packet(bus, request) != CDS_OK)
        wait_for_line(bus, request);
}

/* The packet cannot leave at once. */
static COLD uint8_t submit_later(struct cds_bus *bus, struct cds_request *request)
{
    if (bus->state == CDS_BUS_CLOSED)
        return CDS_BAD_ARGUMENT;
    if (bus->gate & GATE_LOCKED && !request->passes_lock)
        return CDS_BUSY;
    if (bus->hooks)
        return (uint8_t)bus->hooks->submit(bus->hooks->context, request);
    if (bus->request)
        return CDS_BUSY;
    request->result = CDS_PENDING;
    cds_bus_start(bus, request);
    return CDS_OK;
}

/* CDS_OK, or what is wrong with the request. */
ALWAYS_INLINE uint8_t check(const struct cds_request *request)
{
    uint8_t due = request->reply_parameters;

    if ((uint16_t)(request->packet.size - CDS_PACKET_SIZE(0)) > CDS_LENGTH_MAX - CDS_LENGTH_MIN)
        return CDS_BAD_ARGUMENT;
    if (due != CDS_REPLY_NONE) {
        if (due > CDS_REPLY_MAX)
            return CDS_BAD_ARGUMENT;
        if ((request->any_length ? CDS_REPLY_ANY : due) > request->reply_capacity)
            return CDS_NO_ROOM;
    }
    return CDS_OK;
}

enum cds_result cds_bus_submit(struct cds_bus *bus, struct cds_request *request)
{
    return cds_bus_submit_checked(bus, request, 0);
}

enum cds_result cds_bus_submit_checked(struct cds_bus *bus, struct cds_request *request,
                                       uint16_t check_epoch)
{
    uint8_t result;

    OPTIMIZER_BARRIER(bus);
    if (request->result == CDS_PENDING)
        return CDS_BUSY;
    result = check(request);
    if (result == CDS_OK) {
        result = CDS_LINE_BUSY;
        request->retries = 0;
        request->check = check_epoch;
        if (bus->state == CDS_BUS_IDLE && bus->gate == 0)
            result = begin_packet(bus, request);
        if (result == CDS_LINE_BUSY || result == CDS_PENDING)
            result = submit_later(bus, request);
        else if (result == CDS_OK)
            request->result = CDS_PENDING;
    }
    if (result != CDS_OK)
        request->result = result;
    return (enum cds_result)result;
}

struct cds_request *cds_bus_take_back(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;

    if (bus->state != CDS_BUS_WAITING_FOR_LINE)
        return NULL;
    bus->request = NULL;
    bus->state = CDS_BUS_IDLE;
    return request;
}

enum cds_result cds_bus_cancel(struct cds_bus *bus, struct cds_request *request)
{
    const struct cds_bus_hooks *hooks = bus->hooks;

    if (bus->request != request)
        return hooks && hooks->cancel(hooks->context, request) ? CDS_OK : CDS_BAD_ARGUMENT;
    if (!cds_bus_take_back(bus))
        return CDS_BUSY;
    request->result = CDS_CANCELLED;
    if (hooks)
        hooks->on_end(hooks->context, request, CDS_CANCELLED);
    return CDS_OK;
}

/* The packet is on the wire: what is due for it, and by when. */
static NOCLONE void expect_reply(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;
    uint16_t bytes = request->packet.size, more_us = CDS_REPLY_MARGIN_US;
    uint8_t due = request->reply_parameters;

    if (!bus->hooks) { // else the permit has set them
        request->return_delay_us = bus->return_delay_us;
        request->is_muted = false;
    }
    bus->asked_id = request->packet.bytes[CDS_AT_ID];
    request->id = bus->asked_id;
    request->length = 0;
    request->error = 0;
    bus->state = CDS_BUS_SENDING_ONLY;
    if (reply_is_due(request)) {
        bus->state = CDS_BUS_AWAITING_REPLY;
        bytes = (uint16_t)(bytes + CDS_PACKET_SIZE(due));
        more_us = (uint16_t)(more_us + request->return_delay_us);
    }
    bus->is_closing = false;
    bus->parser.longest = (uint8_t)(due + CDS_LENGTH_MIN); // no servo sends more than it was asked
    if (request->any_length)
        bus->parser.longest = CDS_PARSER_LENGTH_MAX;
    bus->parser.is_clean = true;
    cds_parser_reset(&bus->parser, &bus->link.rx);
    set_deadline(bus, bus->begun_ticks, bytes, more_us);
}

void cds_bus_set_return_delay(struct cds_bus *bus, uint16_t return_delay_us)
{
    if (bus->state == CDS_BUS_SENDING)
        expect_reply(bus); // its delay is the one it has begun with
    bus->return_delay_us = return_delay_us;
}

/* ---- a transaction ends ---- */

/* The request has ended as `result`, its packet sent or not. True while there is more to do. */
static NOCLONE bool finish(struct cds_bus *bus, uint8_t result)
{
    struct cds_request *request = bus->request;
    const struct cds_bus_hooks *hooks = bus->hooks;

    bus->request = NULL;
    bus->state = CDS_BUS_IDLE;
    if (hooks && hooks->on_end(hooks->context, request, (enum cds_result)result)) {
        bus->stats.retried++;
        return true;
    }
    request->result = result;
    if (request->on_end)
        request->on_end(request);
    return bus->request;
}

/* The transaction has ended as `result`. */
static NOCLONE bool end(struct cds_bus *bus, uint8_t result)
{
    if (bus->state != CDS_BUS_SENDING_ONLY) {
        bus->last_id = bus->asked_id;
        bus->last_result = result;
    }
    return finish(bus, result);
}

static NOCLONE bool end_well(struct cds_bus *bus)
{
    bus->stats.ok++;
    return end(bus, CDS_OK);
}

/* The deadline is over. */
static COLD bool fail(struct cds_bus *bus)
{
    uint16_t waited_us = (uint16_t)(bus->request->return_delay_us + CDS_REPLY_MARGIN_US);
    uint16_t stale_us = 0;
    uint8_t result = CDS_TIMEOUT;

    bus->parser.to = NULL; // a late reply must not be stored
    if (bus->state != CDS_BUS_SENDING_ONLY && waited_us < CDS_STALE_REPLY_US)
        stale_us = (uint16_t)(CDS_STALE_REPLY_US - waited_us);
    rest(bus, stale_us);
    if (bus->parser.is_clean) {
        bus->stats.timeouts++;
    } else {
        result = CDS_CORRUPT;
        bus->stats.corrupt++;
    }
    return end(bus, result);
}

/* The deadline is over, and what came by then is not examined yet. */
static COLD bool close_reception(struct cds_bus *bus)
{
    if (bus->link.state != CDS_LINK_LISTENING) {
        cds_link_abort(&bus->link, bus->port);
        return fail(bus);
    }
    if (bus->state == CDS_BUS_SENDING_ONLY)
        return true; // it has left just now, and the next poll finds it so
    bus->is_closing = true;
    bus->closing_end = cds_ring_end(&bus->link.rx);
    return true;
}

/* ---- polls ---- */

/* True if the packet whose head was found is the reply due. A servo that refuses sends its error
 * bits and no parameters. */
ALWAYS_INLINE bool is_due(const struct cds_bus *bus)
{
    const struct cds_parser *parser = &bus->parser;
    const struct cds_request *request = bus->request;
    uint8_t parameters = (uint8_t)(parser->length - CDS_LENGTH_MIN);

    if (bus->asked_id == CDS_BROADCAST_ID ? parser->id > CDS_ID_MAX : parser->id != bus->asked_id)
        return false;
    if (parser->error & CDS_ERROR_NONE_SUCH)
        return false;
    if (parameters == request->reply_parameters || request->any_length)
        return true;
    return parameters == 0 && parser->error & CDS_ERRORS_OF_PACKET;
}

static void begin_reply(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;

    if (!is_due(bus))
        return;
    cds_parser_keep(&bus->parser, request->reply);
    request->id = bus->parser.id;
    request->length = (uint8_t)(bus->parser.length - CDS_LENGTH_MIN);
    request->error = bus->parser.error;
    bus->state = CDS_BUS_RECEIVING;
}

/* Examines what has come. The deadline is judged after that: what came by then is not late. */
static bool receive(struct cds_bus *bus)
{
    if (bus->link.state != CDS_LINK_LISTENING)
        return deadline_is_over(bus) ? close_reception(bus) : true;
    switch (examine(bus)) {
    case CDS_PARSED_HEAD: begin_reply(bus); break;
    case CDS_PARSED_PACKET:
        if (bus->state == CDS_BUS_RECEIVING)
            return end_well(bus);
        note_unexpected(bus);
        break;
    case CDS_PARSED_MALFORMED:
        bus->state = CDS_BUS_AWAITING_REPLY;
        bus->request->length = bus->request->error = 0;
        break;
    case CDS_PARSED_MORE:
        if (bus->is_closing)
            return fail(bus);
        break;
    default: break;
    }
    if (!bus->is_closing && deadline_is_over(bus))
        return close_reception(bus);
    return true;
}

/* The packet of the waiting request leaves, if line and permit agree, or it has waited too long. */
static COLD bool wait_on(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;
    uint8_t result = CDS_PENDING;

    if (bus->wait == WAIT_BEGINS) {
        bus->wait = WAIT_TIMED;
        set_deadline(bus, cds_port_ticks(), CDS_PACKET_SIZE(CDS_REPLY_MAX) - 2u,
                     (uint16_t)(CDS_RETURN_DELAY_MAX_US + CDS_REPLY_MARGIN_US + bus->rest_us));
    }
    watch_line(bus);
    if (!(bus->gate & GATE_LINE) &&
        (!(bus->gate & GATE_STALE) || request->ignores_stale || !reply_is_due(request)))
        result = begin_packet(bus, request);
    if (result != CDS_PENDING && result != CDS_LINE_BUSY)
        return result == CDS_OK ? true : finish(bus, result);
    if (!deadline_is_over(bus))
        return true;
    if (bus->wait == WAIT_TIMED) { // what this poll saw may be old
        bus->wait = WAIT_LAST_LOOK;
        set_deadline(bus, cds_port_ticks(), 2, 0);
        return true;
    }
    bus->stats.line_busy++;
    return finish(bus, CDS_LINE_BUSY);
}

static bool poll_sending_only(struct cds_bus *bus)
{
    if (bus->hooks && bus->hooks->on_sending(bus->hooks->context, bus->request))
        return true;
    if (bus->link.state == CDS_LINK_LISTENING)
        return end_well(bus);
    return deadline_is_over(bus) ? close_reception(bus) : true;
}

bool cds_bus_poll(struct cds_bus *bus)
{
    uint8_t state;

    OPTIMIZER_BARRIER(bus);
    state = bus->state;

    if (state >= CDS_BUS_AWAITING_REPLY) {
        if (!has_unread_bytes(bus) && !bus->is_closing && !cds_port_timer_expired(bus->port))
            return true;
        return receive(bus);
    }
    switch (state) {
    case CDS_BUS_SENDING_ONLY: return poll_sending_only(bus);
    case CDS_BUS_SENDING: expect_reply(bus); return true;
    case CDS_BUS_WAITING_FOR_LINE: return wait_on(bus);
    case CDS_BUS_IDLE: watch_line(bus); return bus->request;
    default: return false;
    }
}

/* ---- the reply ---- */

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
    *out = (uint16_t)(at[0] | (uint16_t)at[1] << 8);
    return CDS_OK;
}
