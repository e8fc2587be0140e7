/* SPDX-License-Identifier: MIT */
/* The transaction in flight; see bus.h. */
#include "cds55xx/bus.h"

#include <stddef.h>

#include "bus/bus_internal.h"  // cds_stats_add_link()
#include "bus/line_internal.h" // cds_line_rest()
#include "compiler.h"          // NOINLINE

/* bus->phase has two meanings. While the state is WAITING_FOR_LINE, it is one of these values. */
enum {
    WAIT_BEGINS,    // the next poll sets the timer
    WAIT_TIMED,     // the request waits until the timer expires
    WAIT_LAST_LOOK, // The wait is over. The bus watches the line for two more byte times, because
                    // the previous poll may be old.
};

#define LAST_LOOK_BYTES 2

/* From AWAITING_REPLY or SENDING_ONLY to the end of the transaction, bus->phase is a sum of these
 * bits. */
enum {
    RECEPTION_CLOSING = 1, // the deadline is over; bytes before `closing_end` are still examined
    END_IS_QUIET = 2,      // neither hooks nor on_end are called at the end
    REPLY_IS_FOUND = 4,    // the state is RECEIVING
};

/* Bytes in the ring from which on a poll searches for the head of a reply. A head has one byte
 * more: header, ID and LENGTH are checked while ERROR is still on the wire. */
#define SEARCH_FROM_BYTES CDS_AT_ERROR

/* A stale reply may come for this time, less the return delay, after the deadline. */
#define STALE_US (CDS_STALE_REPLY_US - CDS_REPLY_MARGIN_US)

/* ---- a packet begins ---- */

/* No bool: saves 20 bytes. */
static uint8_t no_reply_is_due(const struct cds_request *request)
{
    return request->reply_parameters == CDS_REPLY_NONE ? 1 : request->is_muted;
}

/* Returns the gate bits that hold this packet back; 0: it may leave. */
static NOCLONE uint8_t must_rest(const struct cds_bus *bus, const struct cds_request *request)
{
    uint8_t gate = bus->gate & (GATE_LINE | GATE_STALE);

    if (gate == GATE_STALE && (request->ignores_stale || no_reply_is_due(request)))
        gate = 0;
    return gate;
}

/* The request waits until the line is quiet and the permit agrees. */
static NOCLONE enum cds_result wait_for_line(struct cds_bus *bus, struct cds_request *request)
{
    if (bus->state != CDS_BUS_WAITING_FOR_LINE)
        bus->phase = WAIT_BEGINS;
    bus->state = CDS_BUS_WAITING_FOR_LINE;
    bus->request = request;
    request->result = CDS_PENDING;
    return CDS_OK;
}

static COLD enum cds_result line_is_in_use(struct cds_bus *bus, struct cds_request *request)
{
    if (cds_line_has_unread_bytes(bus))
        bus->gate |= GATE_SUSPECT; // the next poll examines the bytes and begins a rest
    else
        cds_line_rest(bus, 0); // the line is low within a byte: it may be high at the next look
    return wait_for_line(bus, request);
}

/* Sends the packet from byte `begun` on: so many bytes of the header are on the wire. */
static NOCLONE enum cds_result send_remainder(struct cds_bus *bus, struct cds_request *request,
                                              uint8_t begun)
{
    bus->begun_ticks = cds_port_ticks(); // the deadline counts from here
    cds_link_follow(&bus->link, bus->port, request->packet.bytes, request->packet.size, begun);
    bus->request = request;
    bus->state = CDS_BUS_SENDING;
    bus->stats.sent++;
    request->result = CDS_PENDING;
    return CDS_OK;
}

/* Checks the line as the last step, 40 cycles before the header leaves. */
NOINLINE enum cds_result cds_bus_send(struct cds_bus *bus, struct cds_request *request)
{
    if (cds_line_has_unread_bytes(bus) || !cds_port_line_is_high(bus->port))
        return line_is_in_use(bus, request);
    return send_remainder(bus, request, cds_link_begin(bus->port));
}

/* Sends the packet if the permit agrees, the bus is free and the line is quiet. CDS_PENDING: not
 * now. Any other result but CDS_OK says why the packet must not leave. */
static NOCLONE uint8_t send_if_permitted(struct cds_bus *bus, struct cds_request *request)
{
    uint8_t result;

    if (bus->gate & GATE_PERMIT) {
        result = (uint8_t)bus->hooks->permit(bus->hooks->context, request);
        if (result == CDS_OK && bus->request && bus->request != request)
            result = CDS_PENDING;
        if (result != CDS_OK)
            return result;
    }
    if (must_rest(bus, request))
        return CDS_PENDING;
    return (uint8_t)cds_bus_send(bus, request);
}

void cds_bus_start(struct cds_bus *bus, struct cds_request *request)
{
    if (send_if_permitted(bus, request) != CDS_OK)
        wait_for_line(bus, request);
}

NOCLONE enum cds_result cds_bus_send_or_wait(struct cds_bus *bus, struct cds_request *request,
                                             uint16_t prechecked_epoch)
{
    const struct cds_bus_hooks *hooks;
    uint8_t result;

    request->permit_epoch = prechecked_epoch;
    if (bus->gate & GATE_LOCKED && !request->passes_lock)
        result = CDS_BUSY;
    else if (!(bus->gate & GATE_PERMIT) && bus->request)
        result = CDS_PENDING;
    else if (bus->state == CDS_BUS_CLOSED)
        result = CDS_BAD_ARGUMENT;
    else
        result = send_if_permitted(bus, request);
    if (result == CDS_PENDING) {
        hooks = bus->hooks;
        if (!bus->request)
            result = (uint8_t)wait_for_line(bus, request);
        else
            result = (uint8_t)(hooks ? hooks->submit(hooks->context, request) : CDS_BUSY);
    }
    if (result != CDS_OK)
        request->result = result;
    return (enum cds_result)result;
}

/* The fast path: a request whose fields are valid and that expects a reply. */
enum cds_result cds_bus_submit(struct cds_bus *bus, struct cds_request *request)
{
    struct cds_request *fields = request;
    uint16_t size;
    uint8_t due;

    OPTIMIZER_BARRIER(fields); // `request` stays where cds_bus_send() gets it
    size = fields->packet.size;
    due = fields->reply_parameters;
    if (size < CDS_PACKET_SIZE(0) || size > CDS_LENGTH_MAX + 4u || due > CDS_REPLY_MAX ||
        due > fields->reply_capacity || fields->any_length || fields->result == CDS_PENDING)
        return cds_bus_submit_prechecked(bus, request, CDS_NOT_PRECHECKED);
    return cds_bus_submit_valid(bus, request);
}

NOINLINE enum cds_result cds_bus_submit_prechecked(struct cds_bus *bus, struct cds_request *request,
                                                   uint16_t prechecked_epoch)
{
    enum cds_result result = cds_request_check(request);

    if (result == CDS_OK)
        return cds_bus_send_or_wait(bus, request, prechecked_epoch);
    if (request->result != CDS_PENDING)
        request->result = (uint8_t)result;
    return result;
}

/* Forgets the part of the reply that was received. */
static NOCLONE void forget_reply(struct cds_request *request)
{
    request->id = request->packet.bytes[CDS_AT_ID];
    request->error = 0;
    request->length = 0;
}

/* The packet is on the wire: sets which reply is due, and its deadline. */
static NOCLONE void expect_reply(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;
    uint16_t bytes = request->packet.size, more_us = CDS_REPLY_MARGIN_US;
    uint8_t due = request->reply_parameters;

    if (!(bus->gate & GATE_PERMIT)) { // else the permit has set these fields
        request->return_delay_us = bus->return_delay_us;
        request->is_muted = false;
    }
    forget_reply(request);
    bus->state = CDS_BUS_SENDING_ONLY;
    if (!no_reply_is_due(request)) {
        bus->state = CDS_BUS_AWAITING_REPLY;
        bytes = (uint16_t)(bytes + CDS_PACKET_SIZE(due));
        more_us = (uint16_t)(more_us + request->return_delay_us);
    }
    bus->phase = bus->hooks || request->on_end ? 0 : END_IS_QUIET;
    bus->parser.longest = (uint8_t)(due + CDS_LENGTH_MIN); // a servo sends no more than asked for
    if (request->any_length)
        bus->parser.longest = CDS_PARSER_LENGTH_MAX;
    bus->parser.is_clean = true;
    cds_parser_reset(&bus->parser, &bus->link.rx);
    cds_line_set_deadline(bus, bus->begun_ticks, bytes, more_us);
}

void cds_bus_set_return_delay(struct cds_bus *bus, uint16_t return_delay_us)
{
    if (bus->state == CDS_BUS_SENDING)
        expect_reply(bus); // a packet under way keeps the delay that it began with
    bus->return_delay_us = return_delay_us;
}

/* ---- a request ends ---- */

/* The request has ended as `result`, whether its packet was sent or not. True if the bus has a
 * request again: a retry, or the next one of a queue or of on_end. */
static NOCLONE bool finish(struct cds_bus *bus, uint8_t result)
{
    struct cds_request *request = bus->request;
    const struct cds_bus_hooks *hooks = bus->hooks;

    bus->state = CDS_BUS_IDLE;
    bus->request = NULL;
    if (hooks) {
        result = (uint8_t)hooks->request_ended(hooks->context, request, (enum cds_result)result);
        if (result == CDS_PENDING) {
            bus->stats.retried++;
            return true;
        }
    }
    request->result = result;
    if (request->on_end)
        request->on_end(request);
    return bus->request;
}

/* The deadline is over. */
static COLD bool fail(struct cds_bus *bus)
{
    const struct cds_request *request = bus->request;
    uint16_t stale_us = 0;
    uint8_t result = bus->parser.is_clean ? CDS_TIMEOUT : CDS_CORRUPT;

    bus->parser.to = NULL; // a late reply must not be stored
    if (result == CDS_TIMEOUT)
        bus->stats.timeouts++;
    else
        bus->stats.corrupt++;
    if (bus->state != CDS_BUS_SENDING_ONLY) {
        bus->last_id = request->packet.bytes[CDS_AT_ID];
        bus->last_result = result;
        if (request->return_delay_us < STALE_US)
            stale_us = (uint16_t)(STALE_US - request->return_delay_us);
    }
    cds_line_rest(bus, stale_us);
    return finish(bus, result);
}

/* The packet is still leaving. The transaction fails if the packet has not left by the deadline. */
static COLD bool wait_until_sent(struct cds_bus *bus)
{
    if (!cds_line_check_deadline(bus) || bus->link.state == CDS_LINK_LISTENING)
        return true; // the packet may have left just now: the next poll finds it sent
    cds_link_abort(&bus->link, bus->port);
    return fail(bus);
}

/* ---- bytes that come ---- */

/* Counts a good packet that is not the reply due. */
static COLD bool note_unexpected(struct cds_bus *bus)
{
    uint8_t id = bus->parser.id, event = CDS_EVENT_UNEXPECTED_PACKET;

    if (bus->last_id == id || bus->last_id == CDS_BROADCAST_ID)
        event = bus->last_result == CDS_OK ? CDS_EVENT_DUPLICATE_REPLY : CDS_EVENT_STALE_REPLY;
    bus->stats.not_due[event]++;
    if (bus->gate & GATE_PERMIT)
        bus->hooks->on_packet(bus->hooks->context, (enum cds_bus_event)event, id,
                              bus->parser.error);
    return true;
}

/* A good packet has been received. */
static NOCLONE bool end_packet(struct cds_bus *bus)
{
    return bus->state == CDS_BUS_RECEIVING ? finish(bus, CDS_OK) : note_unexpected(bus);
}

/* The head that was found begins no packet, or its packet was damaged: the search goes on. */
static COLD bool await_another(struct cds_bus *bus)
{
    if (bus->state == CDS_BUS_RECEIVING) {
        bus->state = CDS_BUS_AWAITING_REPLY;
        bus->phase &= (uint8_t)~REPLY_IS_FOUND;
        bus->last_result = CDS_CORRUPT;
        forget_reply(bus->request);
    }
    return true;
}

static COLD bool note_malformed(struct cds_bus *bus)
{
    bus->stats.malformed++;
    return await_another(bus);
}

/* Bytes were damaged or lost. Bytes before and after the damage must never be joined to one packet:
 * drops all bytes up to the last damage. The search begins again behind it. */
static COLD bool drop_damage(struct cds_bus *bus)
{
    struct cds_link *link = &bus->link;

    do {
        cds_stats_add_link(bus);
        link->broken = CDS_LINK_WHOLE;
        cds_parser_skip_damage(&bus->parser, &link->rx, link->whole_from);
    } while (link->broken); // new damage came meanwhile: drop the bytes before it, too
    if (cds_ring_distance(cds_ring_begin(&link->rx), bus->closing_end) > CDS_RING_SIZE)
        bus->closing_end = cds_ring_begin(&link->rx); // the damage reached beyond it
    return await_another(bus);
}

/* Takes bytes before position `end` of the packet whose head was found. */
static NOINLINE bool take(struct cds_bus *bus, uint8_t end)
{
    switch (cds_parser_take_some(&bus->parser, &bus->link.rx, end)) {
    case CDS_PARSED_PACKET:
        if (bus->phase == (END_IS_QUIET | REPLY_IS_FOUND)) { // one comparison for most replies
            bus->state = CDS_BUS_IDLE;
            bus->phase = 0; // else the next packet would be taken for a reply
            bus->request->result = CDS_OK;
            bus->request = NULL;
            return false;
        }
        return end_packet(bus);
    case CDS_PARSED_MALFORMED: return note_malformed(bus);
    default: return true;
    }
}

/* Takes the head for that of the reply due if ID and length fit. A servo that refuses sends error
 * bits and no parameters. */
ALWAYS_INLINE void begin_reply(struct cds_bus *bus, struct cds_request *request)
{
    uint8_t id = bus->parser.id, error = bus->parser.error, asked_id;
    uint8_t parameters = (uint8_t)(bus->parser.length - CDS_LENGTH_MIN);

    if (bus->state != CDS_BUS_AWAITING_REPLY || error & CDS_ERROR_NONE_SUCH)
        return;
    asked_id = request->id;
    if (id > CDS_ID_MAX || (id != asked_id && asked_id != CDS_BROADCAST_ID))
        return;
    if (parameters != request->reply_parameters && !request->any_length &&
        (parameters != 0 || !(error & CDS_ERRORS_OF_PACKET)))
        return;
    cds_parser_keep(&bus->parser, request->reply);
    bus->state = CDS_BUS_RECEIVING;
    bus->phase |= REPLY_IS_FOUND;
    bus->last_id = asked_id;
    bus->last_result = CDS_OK; // until the packet turns out malformed
    request->id = id;
    request->length = parameters;
    request->error = error;
}

/* Examines bytes before position `end`. */
static NOINLINE bool examine(struct cds_bus *bus, uint8_t end)
{
    if (bus->parser.found == CDS_FOUND_HEAD)
        return bus->parser.position == end ? true : take(bus, end);
    switch (cds_parser_find(&bus->parser, &bus->link.rx, end)) {
    case CDS_PARSED_HEAD: begin_reply(bus, bus->request); return true;
    case CDS_PARSED_MALFORMED: return note_malformed(bus);
    default: return true;
    }
}

/* Examines the bytes before the first damage and, if the deadline is over, the bytes that came
 * before the poll that found it over: they are in time. Then drops the damage, or ends the
 * transaction. */
static COLD bool examine_to_end(struct cds_bus *bus)
{
    struct cds_link *link = &bus->link;
    // `end` is read before `broken`: damage that comes between the two lies behind `end`
    uint8_t end = cds_ring_end(&link->rx);
    uint8_t is_broken = link->broken, is_closing = 0;

    if (bus->state >= CDS_BUS_AWAITING_REPLY) {
        if (link->state != CDS_LINK_LISTENING)
            return wait_until_sent(bus); // no reply before the packet has left
        is_closing = bus->phase & RECEPTION_CLOSING;
        if (is_closing) {
            end = bus->closing_end;
        } else if (cds_line_check_deadline(bus)) {
            is_closing = RECEPTION_CLOSING;
            bus->phase |= RECEPTION_CLOSING;
            bus->closing_end = end;
        }
    }
    if (is_broken && cds_ring_distance(link->broken_at, end) > CDS_RING_SIZE)
        is_broken = 0; // the damage lies behind `end`
    if (is_broken)
        end = link->broken_at;
    if (end != bus->parser.position) {
        examine(bus, end);
        return bus->request; // the next poll goes on, or the transaction has ended
    }
    if (is_broken)
        return drop_damage(bus);
    return is_closing ? fail(bus) : true;
}

/* ---- polls ---- */

/* No packet of the controller is on the wire. Checks the line, and examines bytes that no request
 * asked for. */
static NOCLONE void listen(struct cds_bus *bus)
{
    if (cds_line_has_unread_bytes(bus)) {
        cds_line_rest(bus, 0);
        bus->gate &= (uint8_t)~GATE_FAULT;
        bus->parser.longest = CDS_PARSER_LENGTH_MAX;
        examine_to_end(bus);
    } else if (bus->gate & (GATE_LINE | GATE_STALE)) {
        cds_line_check_rest(bus);
    } else if (!cds_port_line_is_high(bus->port)) {
        cds_line_rest(bus, 0);
    }
}

/* Sends the packet of the waiting request if line and permit agree. The request fails if it has
 * waited too long. */
static COLD bool wait_on(struct cds_bus *bus)
{
    struct cds_request *request = bus->request;
    uint8_t result = CDS_PENDING, phase = bus->phase;
    uint16_t from = cds_port_ticks();
    uint16_t bytes = LAST_LOOK_BYTES, more_us = 0;

    // Unread bytes at WAIT_LAST_LOOK show that the line is in use. This poll may then end the
    // request, so a later poll examines the bytes: a poll does one thing of bounded length.
    if (phase != WAIT_LAST_LOOK || !cds_line_has_unread_bytes(bus))
        listen(bus);
    if (!(bus->gate & GATE_LINE)) {
        result = send_if_permitted(bus, request);
        if (result == CDS_PENDING)
            bus->phase =
                WAIT_BEGINS; // a stale reply or a check: not counted as a wait for the line
        return result == CDS_OK || result == CDS_PENDING ? true : finish(bus, result);
    }
    if (phase == WAIT_BEGINS) {
        bytes = CDS_LINE_WAIT_BYTES - LAST_LOOK_BYTES;
        more_us = CDS_LINE_WAIT_US;
    } else if (!cds_line_check_deadline(bus)) {
        return true;
    } else if (phase == WAIT_LAST_LOOK) {
        bus->stats.line_busy++;
        return finish(bus, CDS_LINE_BUSY);
    } else {
        from = cds_port_ticks();
    }
    bus->phase = (uint8_t)(phase + 1u);
    cds_line_set_deadline(bus, from, bytes, more_us);
    return true;
}

static COLD bool poll_sending_only(struct cds_bus *bus)
{
    if (bus->gate & GATE_PERMIT && bus->hooks->on_sending(bus->hooks->context, bus->request))
        return true;
    if (bus->link.state == CDS_LINK_LISTENING)
        return finish(bus, CDS_OK);
    return wait_until_sent(bus);
}

/* Polls in a state in which the bus does not search for a reply. */
static NOCLONE bool poll_other(struct cds_bus *bus)
{
    switch (bus->state) {
    case CDS_BUS_CLOSED: return false;
    case CDS_BUS_IDLE: listen(bus); return bus->request;
    case CDS_BUS_WAITING_FOR_LINE: return wait_on(bus);
    case CDS_BUS_SENDING: expect_reply(bus); return true;
    default: return poll_sending_only(bus);
    }
}

bool cds_bus_poll(struct cds_bus *bus)
{
    uint8_t state = bus->state, end = cds_ring_end(&bus->link.rx);

    if (state == CDS_BUS_RECEIVING) {
        if (end != bus->parser.position && !bus->link.broken && !cds_port_timer_expired(bus->port))
            return take(bus, end);
    } else if (state == CDS_BUS_AWAITING_REPLY) {
        if (cds_ring_distance(cds_ring_begin(&bus->link.rx), end) >= SEARCH_FROM_BYTES &&
            bus->link.state == CDS_LINK_LISTENING && !bus->link.broken &&
            !cds_port_timer_expired(bus->port))
            return examine(bus, end);
    } else {
        return poll_other(bus);
    }
    if (bus->link.broken || cds_port_timer_expired(bus->port))
        return examine_to_end(bus);
    return true;
}
