/* SPDX-License-Identifier: MIT */
/* Compares a bus and its queue with a model, on this machine under the sanitizers.
 * Requests, servos and line are random. The model decides for each request which outcomes are
 * allowed.
 *
 * usage: bus_random TRANSACTIONS [SEED [TRACE_FROM]]
 *
 * Every reply carries the tag of the packet that it answers, so that the model notices a stale
 * reply taken for a new one. Replies are in time, late, damaged, cut, doubled or missing. Other
 * bytes come before a reply or at any time. The line is held low; polls are late; requests have
 * priorities, are retried and cancelled; rate, lock and return delays change; the bus is opened
 * again; the clock wraps. Checked: outcome, value, buffers, order, retries, deadlines, events,
 * stats, and that no packet begins while the line is in use. On a failure prints the broken rule
 * and the seed; exit status 1. */
#include "cds55xx/bus.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cds55xx/queue.h"
#include "port_fake.h"

#define PORT           0
#define JOBS           6
#define SERVOS         5
#define EVENTS         1024
#define EMISSIONS      64
#define UNREPORTED_MAX 64
#define NO_INDEX       0xFF
#define FALSE_HEADER   EMISSIONS // in place of an emission: a false header that may hide a reply
#define SAFE_HEADER                                                                                \
    (EMISSIONS + 1) // in place of an emission: a false header that cannot hide a reply
#define STALE_US   (CDS_STALE_REPLY_US - 10) // the latest start of a reply in this model
#define STRANGER   77                        // an ID that no request is sent to
#define POISON     0xEE
#define OVERDUE    80 // polls after the deadline: a full ring is examined in pieces
#define WAIT_BYTES 56
#define LATE_US    140000 // allowance if polls are more than 30 ms apart

enum mode { QUIET, WITHOUT_QUEUE, WITH_QUEUE, WITH_PERMIT }; // QUIET: no queue and no on_end
enum harm { WHOLE, FLIPPED, LOST, MARKED, SPLICED, CUT, BAD_SUM };

/* A packet of a servo on the line. */
struct emission {
    uint32_t tag;
    uint8_t id, error, length, size, harm, delivered;
    bool is_reply; // the reply to the packet with that tag
    bool is_whole; // no byte is lost so far
    bool is_first; // no earlier byte can hide it
};

/* A byte on the line. */
struct event {
    uint32_t end_us;
    uint8_t byte, errors, baud_reg, emission, index;
};

/* A request and what the model knows of it. */
struct job {
    struct cds_request request;
    uint8_t buffer[CDS_PACKET_SIZE(6)], sent[CDS_PACKET_SIZE(6)];
    uint8_t *reply; // CDS_REPLY_ANY bytes; the request uses the last ones
    bool is_submitted, waits, is_idempotent, mutes;
    uint8_t retries, permit_result, permit_polls; // permit_result: enum cds_result
    // the packet in flight:
    uint32_t tag, begun_us, first_poll_us, complete_us, good_us, delay_us, longest_gap_us;
    uint8_t error, length, id;
    bool has_left, is_stuck, is_hit, is_polled, is_closed, drains;
    bool is_good, must_be_ok, is_dirty, is_hidden, must_be_corrupt;
    uint16_t overdue, idle_overdue;
    uint32_t closed_us;
};

static struct cds_bus bus;
static struct cds_queue queue;
static struct cds_bus_hooks hooks;
static struct job jobs[JOBS];
static struct job *waiting[JOBS], *flying;
static uint8_t waiting_count;
static struct event events[EVENTS];
static uint16_t event_count, event_next;
static struct emission emissions[EMISSIONS];
static uint32_t emission_count;
static struct {
    uint32_t tag;
    uint8_t id, error;
} unreported[UNREPORTED_MAX]; // whole packets that the bus has not reported yet
static uint8_t unreported_count;
static uint16_t return_delays_us[SERVOS], bus_delay_us;
static enum mode mode;
static uint8_t max_retries;
static bool is_locked;
static const struct cds_bus_lock lock;

/* The state of the line, as far as the bus can know it. */
static uint32_t last_rx_us, low_us, failed_us, stale_floor_us, stale_until_us, active_us, hold_us;
static bool is_rx_exempt, is_low_known, is_failure_known, is_stale, is_active, holds;
static bool was_low, wire_is_clean, is_harmed, permit_pending, sending_goes_on, sending_was_asked;
static struct job *permitted;
static uint8_t last_id;
static enum cds_result last_result;

static struct cds_stats count; // what the stats must be
static uint32_t first_seed, trace_from = UINT32_MAX, state, tags, transactions, rounds;
static uint32_t outcomes[16], ends, certain[3];

/* ---- random numbers and failures ---- */

static uint32_t any(uint32_t limit)
{
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state % limit;
}

static bool one_in(uint32_t limit)
{
    return any(limit) == 0;
}

__attribute__((format(printf, 2, 3), noreturn)) static void broken(const struct job *job,
                                                                   const char *text, ...)
{
    va_list list;

    va_start(list, text);
    printf("FAILED: seed %u, round %u, transaction %u, %u us: ", first_seed, rounds, transactions,
           port_fake.now_us);
    vprintf(text, list);
    va_end(list);
    if (job)
        printf(" (request %d: instruction %u of servo %u, tag %u, begun %u us)", (int)(job - jobs),
               job->sent[4], job->sent[2], job->tag, job->begun_us);
    puts("");
    exit(1);
}

/* Prints each step from transaction TRACE_FROM on. */
#define TRACE(...)                                                                                 \
    do {                                                                                           \
        if (transactions >= trace_from) {                                                          \
            printf("%10u us: ", port_fake.now_us);                                                 \
            printf(__VA_ARGS__);                                                                   \
        }                                                                                          \
    } while (0)

#define RULE(condition, job, ...)                                                                  \
    do {                                                                                           \
        if (!(condition))                                                                          \
            broken(job, __VA_ARGS__);                                                              \
    } while (0)

/* ---- time ---- */

static int32_t since(uint32_t us)
{
    return (int32_t)(port_fake.now_us - us);
}

static uint16_t byte_us(uint8_t baud_reg)
{
    return (uint16_t)(5 * (baud_reg + 1));
}

static int32_t quiet_us(void)
{
    return 2 * byte_us(bus.baud_reg);
}

static bool reply_is_due(const struct job *job)
{
    return job->request.reply_parameters != CDS_REPLY_NONE &&
           !(mode == WITH_PERMIT && job->request.is_muted);
}

static uint32_t left_at_us(const struct job *job)
{
    return job->begun_us + (uint32_t)job->request.packet.size * byte_us(bus.baud_reg);
}

static uint32_t duration_us(const struct job *job)
{
    uint32_t bytes = job->request.packet.size, more_us = CDS_REPLY_MARGIN_US;

    if (reply_is_due(job)) {
        bytes += CDS_PACKET_SIZE(job->request.reply_parameters);
        more_us += job->delay_us;
    }
    return bytes * byte_us(bus.baud_reg) + more_us;
}

static uint32_t deadline_us(const struct job *job)
{
    return job->begun_us + duration_us(job);
}

static bool is_in_time(const struct job *job)
{
    return since(deadline_us(job)) <= 0;
}

/* ---- bytes of servos ---- */

static uint8_t value(uint32_t tag, uint8_t index)
{
    if (index < 3)
        return (uint8_t)(tag >> 7 * index) & 0x7F;
    return (uint8_t)(tag * 37 + index * 11u) & 0x7F;
}

static void push(uint32_t *at_us, uint8_t byte, uint8_t errors, uint8_t emission, uint8_t index)
{
    RULE(event_count < EVENTS, NULL, "the driver has too few events");
    *at_us += byte_us(bus.baud_reg);
    events[event_count++] = (struct event){*at_us, byte, errors, bus.baud_reg, emission, index};
}

/* Returns the first time from `at_us` on at which all earlier bytes have ended. */
static uint32_t free_from(uint32_t at_us)
{
    if (event_next != event_count && (int32_t)(events[event_count - 1].end_us - at_us) > 0)
        at_us = events[event_count - 1].end_us;
    if (holds && (int32_t)(hold_us - at_us) > 0)
        at_us = hold_us;
    return at_us;
}

/* Pushes what arrives instead of the damaged byte `index`. */
static void push_harmed(uint32_t *at_us, uint8_t byte, uint8_t harm, uint8_t emission,
                        uint8_t index)
{
    switch (harm) {
    case FLIPPED: push(at_us, (uint8_t)(byte ^ 1u << any(8)), 0, emission, index); break;
    case MARKED: push(at_us, byte, (uint8_t)(1 + any(3)), emission, index); break;
    case SPLICED:
        push(at_us, byte, (uint8_t)(1 + any(3)), emission, index);
        push(at_us, byte, 0, emission, index);
        break;
    default: break; // lost
    }
}

/* Builds a packet; returns its size. */
static uint8_t fill(uint8_t *bytes, const struct emission *what)
{
    uint8_t size = (uint8_t)(what->length + 6), sum = 0;

    bytes[0] = bytes[1] = 0xFF;
    bytes[2] = what->id;
    bytes[3] = (uint8_t)(what->length + 2);
    bytes[4] = what->error;
    for (uint8_t i = 0; i < what->length; i++)
        bytes[5 + i] = value(what->tag, i);
    for (uint8_t i = 2; i < size - 1; i++)
        sum = (uint8_t)(sum + bytes[i]);
    bytes[size - 1] = (uint8_t)~sum;
    return size;
}

static void push_packet(uint32_t *at_us, const struct emission *what)
{
    uint8_t bytes[6 + CDS_REPLY_ANY], size = fill(bytes, what), harmed = NO_INDEX;
    uint8_t slot = (uint8_t)(emission_count++ % EMISSIONS);
    struct emission *emission = &emissions[slot];

    *emission = *what;
    emission->size = size;
    emission->delivered = 0;
    emission->is_whole = what->harm == WHOLE;
    if (what->harm == BAD_SUM) {
        bytes[size - 1]++;
    } else if (what->harm != WHOLE) {
        harmed = (uint8_t)(what->harm >= MARKED ? 1 + any(size - 1u) : 4 + any(size - 4u));
        if (what->harm == LOST && bytes[harmed] == 0xFF)
            harmed = 4;
        is_harmed = true;
    }
    for (uint8_t i = 0; i < size; i++) {
        if (i != harmed)
            push(at_us, bytes[i], 0, slot, i);
        else if (what->harm == CUT)
            break;
        else
            push_harmed(at_us, bytes[i], what->harm, slot, i);
    }
}

/* Pushes bytes that begin no packet. */
static void push_noise(uint32_t *at_us)
{
    uint8_t bytes = (uint8_t)(1 + any(one_in(20) ? 90 : 6)), last = 0xFF;

    for (uint8_t i = 0; i < bytes; i++) {
        uint8_t byte = (uint8_t)(last != 0xFF && one_in(4) ? 0xFF : 0x80 + any(0x7F));

        push(at_us, byte, one_in(20) ? CDS_LINE_FRAMING : 0, NO_INDEX, 0);
        last = byte;
    }
}

/* True if a reply that begins then is later than the library allows (CDS_STALE_REPLY_US). */
static bool is_too_late(uint32_t at_us)
{
    return (int32_t)(at_us - port_fake.now_us) > STALE_US;
}

/* True if a false header with this LENGTH before `reply` is known to be no packet once the whole
 * reply has arrived. */
static bool is_malformed_with(const struct emission *reply, uint8_t length)
{
    uint8_t bytes[6 + CDS_REPLY_ANY], size = fill(bytes, reply), sum = (uint8_t)(STRANGER + length);

    if (length < 2 || length > size || reply->harm != WHOLE)
        return false;
    for (uint8_t i = 0; i < length; i++)
        sum = (uint8_t)(sum + bytes[i]);
    return sum != 0xFF;
}

/* Pushes a false header: header, ID and LENGTH of a packet that ends there. LENGTH covers bytes of
 * the reply after it. No servo has the ID. */
static void push_false_header(uint32_t *at_us, const struct emission *reply)
{
    uint8_t length = (uint8_t)(one_in(2) ? 2 + any(5) : 2 + any(70));
    const uint8_t bytes[] = {0xFF, 0xFF, STRANGER, length};
    bool is_safe =
        is_malformed_with(reply, length) && !is_too_late(*at_us + 4u * byte_us(bus.baud_reg));
    uint8_t kind = is_safe ? SAFE_HEADER : FALSE_HEADER;

    for (uint8_t i = 0; i < sizeof bytes; i++)
        push(at_us, bytes[i], 0, kind, 0);
}

/* Pushes bytes that come before the reply and are not the reply. */
static void push_first(uint32_t *at_us, const struct job *job, const struct emission *reply)
{
    struct emission other = *reply;

    other.is_reply = false;
    other.tag = reply->tag + 0x1FFF;
    switch (any(8)) {
    case 0: push(at_us, 0, CDS_LINE_FRAMING, NO_INDEX, 0); return;
    case 1: push_noise(at_us); return;
    case 2:
        if (job->sent[2] != CDS_BROADCAST_ID)
            push_false_header(at_us, reply);
        return;
    case 3: other.error = CDS_ERROR_NONE_SUCH; break;
    case 4:
        if (job->sent[2] == CDS_BROADCAST_ID || one_in(2)) {
            other.harm = BAD_SUM; // begins as the reply does
            push_packet(at_us, &other);
            other.error = CDS_ERROR_NONE_SUCH;
        }
        other.id = STRANGER;
        break;
    case 5:
        if (job->request.any_length || reply->length != job->request.reply_parameters)
            return;
        other.length = (uint8_t)(reply->length + 1);
        break;
    default:
        if (job->request.any_length || job->request.reply_parameters < 2)
            return;
        other.length = (uint8_t)any(job->request.reply_parameters);
        other.error = other.length == 0 ? CDS_ERROR_OVERLOAD : CDS_ERROR_RANGE;
        break;
    }
    other.harm = WHOLE;
    push_packet(at_us, &other);
}

/* Returns the time from the packet to the reply. */
static uint32_t reply_delay_us(const struct job *job, uint8_t size)
{
    uint32_t slack_us = job->delay_us + CDS_REPLY_MARGIN_US, reply_us;

    reply_us = (uint32_t)size * byte_us(bus.baud_reg);
    switch (any(8)) {
    case 0: return any(STALE_US);
    case 1: return slack_us + any(reply_us); // a part of the reply arrives by the deadline
    case 2: return slack_us > 30 ? slack_us - any(30) : 0;
    case 3: return one_in(2) ? 0 : any(20);
    default: return any(slack_us);
    }
}

/* The servo answers. */
static void answer(struct job *job)
{
    struct emission reply = {.tag = job->tag, .id = job->sent[2], .is_reply = true};
    uint32_t at_us;

    if (reply.id == CDS_BROADCAST_ID)
        reply.id = (uint8_t)(1 + any(SERVOS));
    reply.error = (uint8_t)(one_in(5) ? any(0x80) : 0);
    reply.length = job->request.reply_parameters;
    if (job->request.any_length)
        reply.length = (uint8_t)any(job->request.reply_parameters + 1u);
    if (reply.error & CDS_ERRORS_OF_PACKET && one_in(2))
        reply.length = 0;
    job->error = reply.error;
    job->length = reply.length;
    job->id = reply.id;
    at_us = free_from(port_fake.now_us + reply_delay_us(job, (uint8_t)(reply.length + 6)));
    reply.harm = one_in(6) ? (uint8_t)(1 + any(CUT)) : WHOLE;
    if (one_in(6) && !is_too_late(at_us))
        push_first(&at_us, job, &reply);
    if (is_too_late(at_us))
        return;
    push_packet(&at_us, &reply);
    if (reply.harm == WHOLE && one_in(12)) { // two servos have the ID
        if (job->sent[2] == CDS_BROADCAST_ID) {
            reply.is_reply = false;
            reply.id = STRANGER;
            reply.length = 1; // if the first reply is lost, this one must not be a reply
        }
        at_us += any(2u * byte_us(bus.baud_reg));
        push_packet(&at_us, &reply);
    }
}

/* Pushes bytes that belong to no transaction, or holds the line low. */
static void disturb(void)
{
    struct emission stranger = {.tag = any(1000), .id = STRANGER, .length = (uint8_t)(1 + any(9))};
    uint32_t at_us = free_from(port_fake.now_us + any(3u * byte_us(bus.baud_reg)));

    if (is_harmed || event_count > EVENTS / 2)
        return;
    switch (any(4)) {
    case 0: push_noise(&at_us); break;
    case 1: push_packet(&at_us, &stranger); break;
    case 2:
        if (event_next == event_count && !flying) {
            holds = true;
            hold_us = at_us + any(one_in(8) ? 12000 : 200);
        }
        break;
    default: push(&at_us, 0, CDS_LINE_FRAMING, NO_INDEX, 0); break;
    }
}

/* ---- the line ---- */

static bool level_is_low(void)
{
    const struct event *event = &events[event_next];
    uint32_t bit_us, start_us;
    int32_t bit;

    if (holds && since(hold_us) < 0)
        return true;
    holds = false;
    if (event_next == event_count)
        return false;
    bit_us = byte_us(event->baud_reg);
    start_us = event->end_us - bit_us;
    if (since(start_us) < 0)
        return false;
    bit = since(start_us) * 10 / (int32_t)bit_us;
    return bit == 0 || (bit <= 8 && !(event->byte >> (bit - 1) & 1));
}

static void note_harm(bool is_mark)
{
    wire_is_clean = false;
    unreported_count = 0; // the bus drops bytes between two damaged bytes
    if (!flying || !flying->has_left)
        return;
    flying->is_dirty = flying->is_hidden = true;
    if (is_mark && is_in_time(flying) && reply_is_due(flying))
        flying->must_be_corrupt = true;
}

static bool awaits_reply(void)
{
    return flying && flying->has_left && reply_is_due(flying);
}

static void expect_packet(const struct emission *emission, uint32_t tag)
{
    if (!wire_is_clean || unreported_count == UNREPORTED_MAX)
        return;
    unreported[unreported_count].tag = tag;
    unreported[unreported_count].id = emission->id;
    unreported[unreported_count++].error = emission->error;
}

static void remove_unreported(uint8_t at)
{
    unreported_count--;
    memmove(&unreported[at], &unreported[at + 1],
            (size_t)(unreported_count - at) * sizeof *unreported);
}

/* The LENGTH of a packet has arrived: malformed if it has more parameters than are due. */
static void check_length(const struct emission *emission)
{
    if (awaits_reply() && !flying->request.any_length &&
        emission->length > flying->request.reply_parameters)
        note_harm(emission->is_first && is_in_time(flying));
}

static void complete(struct emission *emission)
{
    bool is_due = emission->is_reply && awaits_reply() && emission->tag == flying->tag;

    if (is_due && !flying->is_good) {
        flying->is_good = true;
        flying->good_us = port_fake.now_us;
        flying->must_be_ok = emission->is_first && is_in_time(flying);
        expect_packet(emission, emission->tag);
    } else {
        expect_packet(emission, 0);
    }
}

/* A byte of a servo's packet has arrived; `is_heard`: undamaged. */
static void follow(struct emission *emission, const struct event *event, bool is_heard)
{
    if (event->index == 0)
        emission->is_first = is_heard && wire_is_clean && !(flying && flying->is_hidden);
    if (!is_heard || event->index != emission->delivered)
        emission->is_whole = false;
    emission->delivered = (uint8_t)(event->index + 1);
    if (event->index == CDS_AT_LENGTH)
        check_length(emission);
    if (emission->harm == FLIPPED && is_heard && emission->delivered == emission->size &&
        emission->is_first && awaits_reply() && emission->tag == flying->tag)
        note_harm(true);
    if (emission->harm == BAD_SUM && is_heard) {
        if (flying)
            flying->is_dirty = true; // malformed; it hides no other packet
    } else if (!emission->is_whole) {
        wire_is_clean = false;
        if (flying)
            flying->is_dirty = flying->is_hidden = true;
    } else if (emission->delivered == emission->size) {
        complete(emission);
    }
}

static void count_damage(uint8_t errors)
{
    if (errors & CDS_LINE_FRAMING)
        count.framing_errors++;
    if (errors & CDS_LINE_OVERRUN)
        count.overruns++;
}

static void deliver(const struct event *event)
{
    struct emission *emission = event->emission < EMISSIONS ? &emissions[event->emission] : NULL;
    uint32_t start_us = event->end_us - byte_us(event->baud_reg);
    bool is_full = cds_ring_count(&bus.link.rx) == CDS_RING_SIZE, is_heard;
    uint8_t errors = event->errors;

    if (port_fake.lines[PORT] != FAKE_LISTEN && !(flying && flying->drains)) {
        if (flying)
            flying->is_hit = true;
        if (emission)
            emission->is_whole = false;
        return;
    }
    if (event->baud_reg != bus.baud_reg ||
        (flying && flying->has_left && (int32_t)(start_us - left_at_us(flying)) < 0))
        errors = CDS_LINE_FRAMING;
    is_heard = errors == 0 && !is_full;
    TRACE("byte %02X, %s, packet %u, its byte %u\n", event->byte,
          errors    ? "damaged"
          : is_full ? "no room"
                    : "heard",
          event->emission, event->index);
    cds_link_on_rx(&bus.link, event->byte, errors);
    count_damage(errors);
    count.ring_overflows = (uint16_t)(count.ring_overflows + (!errors && is_full));
    last_rx_us = port_fake.now_us;
    is_rx_exempt = false;
    if (emission)
        follow(emission, event, is_heard);
    else if (event->emission == FALSE_HEADER)
        note_harm(false);
    else if (event->emission == SAFE_HEADER && flying)
        flying->is_dirty = true;
    if (!is_heard)
        note_harm(true);
}

/* The last bit of the packet is sent. */
static void leave(void)
{
    struct job *job = flying;

    RULE(port_fake_drain(&bus.link, PORT), job, "the packet has no end");
    RULE(port_fake.sent_size == job->request.packet.size &&
             memcmp(port_fake.sent, job->sent, port_fake.sent_size) == 0,
         job, "other bytes were sent than were submitted");
    job->has_left = true;
    job->drains = one_in(30);
    job->complete_us = port_fake.now_us + any(90);
    if (!job->drains)
        cds_link_on_tx_complete(&bus.link, PORT);
    if (reply_is_due(job) && !job->is_hit && !one_in(12))
        answer(job);
}

/* Runs the delayed handler of "transmit complete". After a packet without reply it may also run
 * during the poll that sees the deadline. */
static void complete_sending(void)
{
    if (!flying || !flying->drains || since(flying->complete_us) < 0)
        return;
    if (!reply_is_due(flying) && flying->tag & 1 && flying->longest_gap_us < 10000)
        return;
    flying->drains = false;
    cds_link_on_tx_complete(&bus.link, PORT);
}

/* Advances the clock by `us`. Packets end and bytes arrive in the order of their times. */
static void pass(uint32_t us)
{
    uint32_t until_us = port_fake.now_us + us;

    for (;;) {
        bool leaves = flying && !flying->has_left && !flying->is_stuck;
        bool comes = event_next != event_count;

        if (leaves && comes && (int32_t)(events[event_next].end_us - left_at_us(flying)) < 0)
            leaves = false;
        if (leaves && (int32_t)(left_at_us(flying) - until_us) <= 0) {
            port_fake.now_us = left_at_us(flying);
            leave();
        } else if (!leaves && comes && (int32_t)(events[event_next].end_us - until_us) <= 0) {
            port_fake.now_us = events[event_next].end_us;
            deliver(&events[event_next++]);
        } else {
            break;
        }
    }
    if (event_next == event_count)
        event_next = event_count = 0;
    port_fake.now_us = until_us;
    complete_sending();
    if (flying && us > flying->longest_gap_us)
        flying->longest_gap_us = us;
    if (us > 900000) { // all marks are long ago, and the clock may wrap
        is_rx_exempt = true;
        is_low_known = is_failure_known = is_stale = is_active = false;
        low_us = port_fake.now_us - 900000;
    }
}

/* ---- the model's queue ---- */

#define BEFORE_ALL UINT8_MAX

static void wait_before(struct job *job, uint8_t priority)
{
    uint8_t at = 0;

    while (at < waiting_count && waiting[at]->request.priority >= priority)
        at++;
    memmove(&waiting[at + 1], &waiting[at], (size_t)(waiting_count - at) * sizeof *waiting);
    waiting[at] = job;
    waiting_count++;
    job->waits = true;
}

static void wait_no_more(struct job *job)
{
    uint8_t at = 0;

    while (waiting[at] != job)
        at++;
    waiting_count--;
    memmove(&waiting[at], &waiting[at + 1], (size_t)(waiting_count - at) * sizeof *waiting);
    job->waits = false;
}

/* A submitted job waits. The one that waits for the line stays first unless it is overtaken: while
 * the line is in use only torque off does that. */
static void wait_in_turn(struct job *job)
{
    struct job *first = bus.state == CDS_BUS_WAITING_FOR_LINE ? waiting[0] : NULL;
    uint8_t priority = job->request.priority;

    if (first)
        wait_no_more(first);
    wait_before(job, priority);
    if (!first)
        return;
    if (priority > first->request.priority &&
        (priority == CDS_PRIORITY_TORQUE_OFF || cds_bus_line(&bus) == CDS_BUS_LINE_QUIET))
        wait_before(first, (uint8_t)(first->request.priority + 1));
    else
        wait_before(first, BEFORE_ALL);
}

/* ---- a packet begins ---- */

/* False if the line certainly was in use less than two byte times ago. The bus tests the line at
 * times that the model does not know, so it may see the line in use for longer: is_active. */
static bool line_may_be_quiet(void)
{
    return !level_is_low() && (is_rx_exempt || since(last_rx_us) >= quiet_us()) &&
           (!is_low_known || since(low_us) >= quiet_us()) &&
           (!is_failure_known || since(failed_us) >= quiet_us());
}

static void check_line(const struct job *job)
{
    RULE(!level_is_low(), job, "sent into a low line");
    RULE(is_rx_exempt || since(last_rx_us) >= quiet_us(), job,
         "sent %d us after a byte that no request asked for", since(last_rx_us));
    RULE(!is_low_known || since(low_us) >= quiet_us(), job, "sent %d us after the line was low",
         since(low_us));
    RULE(!is_failure_known || since(failed_us) >= quiet_us(), job, "sent %d us after a failure",
         since(failed_us));
    RULE(!is_stale || !reply_is_due(job) || job->request.ignores_stale ||
             since(stale_floor_us) >= 0,
         job, "sent %d us before the last stale reply may come", -since(stale_floor_us));
    RULE(unreported_count == 0 || mode != WITH_PERMIT, job,
         "sent while a packet of servo %u was unread", unreported[0].id);
}

static void note_begin(void)
{
    struct job *job = (struct job *)bus.request->context;

    RULE(waiting_count && waiting[0] == job, job, "sent before its turn");
    RULE(mode != WITH_PERMIT || permitted == job, job, "sent without asking the permit");
    check_line(job);
    wait_no_more(job);
    flying = job;
    job->tag = ++tags;
    job->begun_us = port_fake.now_us;
    job->delay_us = mode == WITH_PERMIT ? job->request.return_delay_us : bus_delay_us;
    job->has_left = job->is_hit = job->is_polled = false;
    job->longest_gap_us = 0;
    job->is_good = job->must_be_ok = job->is_dirty = job->must_be_corrupt = false;
    job->overdue = job->idle_overdue = 0;
    job->is_closed = job->drains = job->is_hidden = false;
    job->is_stuck = one_in(60);
    wire_is_clean = true;
    is_harmed = event_next != event_count;
    TRACE("request %d begins, tag %u, to servo %u, deadline at %u us\n", (int)(job - jobs),
          job->tag, job->sent[2], deadline_us(job));
    unreported_count = 0;
    holds = false;
    transactions++;
    count.sent++;
}

/* The bus has tested the line and found it low. */
static void note_low(void)
{
    if (port_fake.low_seen) {
        is_low_known = is_active = true;
        low_us = active_us = port_fake.now_us;
        port_fake.low_seen = 0;
        was_low = true;
    }
}

/* Call it after each call that can begin a packet. */
static void note_line_and_begin(void)
{
    note_low();
    if (port_fake.lines[PORT] == FAKE_TALK && !flying)
        note_begin();
    permitted = NULL;
}

/* ---- a transaction ends ---- */

static struct job *wait_job; // the request that has waited for the line
static uint32_t wait_from_us, wait_least_us, wait_last_us, wait_overdue_us;
static uint16_t wait_overdue;
static bool wait_is_sloppy, wait_is_last, wait_restarts;

static void check_value(const struct job *job)
{
    const struct cds_request *request = &job->request;

    if (!reply_is_due(job)) {
        RULE(job->has_left, job, "ended well before it was sent");
        RULE(mode != WITH_PERMIT || (sending_was_asked && !sending_goes_on), job,
             "ended while on_sending had more to do");
        RULE(request->length == 0 && request->error == 0, job, "a reply where none was due");
        return;
    }
    RULE(job->is_good, job, "ended well without a whole reply");
    RULE(!job->is_closed || (int32_t)(job->good_us - job->closed_us) <= 0, job,
         "took a reply that ended after its deadline");
    RULE(bus.link.state == CDS_LINK_LISTENING, job, "took a reply while its packet was sent");
    RULE(request->id == job->id, job, "servo %u answered, not %u", job->id, request->id);
    RULE(request->error == job->error, job, "wrong error bits");
    RULE(request->length == job->length, job, "%u parameters, not %u", request->length,
         job->length);
    for (uint8_t i = 0; i < job->length; i++)
        RULE(request->reply[i] == value(job->tag, i), job, "parameter %u is not this reply's", i);
}

static void check_failure(const struct job *job, enum cds_result result)
{
    RULE(since(deadline_us(job)) >= 0, job, "failed %d us early", -since(deadline_us(job)));
    RULE(!job->must_be_ok, job, "failed though its reply came in time");
    if (!reply_is_due(job)) {
        RULE(job->is_stuck && result == CDS_TIMEOUT, job, "failed though it was sent");
        return;
    }
    RULE(result == CDS_TIMEOUT || job->is_dirty, job, "corrupt without damage");
    RULE(result == CDS_CORRUPT || !job->must_be_corrupt, job, "no reply though one was damaged");
    certain[2] += job->must_be_corrupt;
}

static void note_failure(const struct job *job)
{
    uint32_t waited_us = job->delay_us + CDS_REPLY_MARGIN_US, until_us = port_fake.now_us;

    is_failure_known = is_active = true;
    failed_us = active_us = port_fake.now_us;
    if (!reply_is_due(job))
        return;
    if (waited_us < CDS_STALE_REPLY_US)
        until_us += CDS_STALE_REPLY_US - waited_us;
    if (!is_stale || (int32_t)(until_us - stale_until_us) > 0)
        stale_until_us = until_us;
    until_us = left_at_us(job) + CDS_STALE_REPLY_US;
    if (!is_stale || (int32_t)(until_us - stale_floor_us) > 0)
        stale_floor_us = until_us;
    is_stale = true;
}

static void check_end_of_attempt(struct job *job, enum cds_result result)
{
    flying = NULL;
    if (result == CDS_OK) {
        check_value(job);
        for (uint8_t i = 0; i < unreported_count; i++)
            if (reply_is_due(job) && unreported[i].tag == job->tag)
                remove_unreported(i--);
        certain[0] += job->must_be_ok;
        if (reply_is_due(job) && job->good_us == last_rx_us)
            is_rx_exempt = true;
        count.ok++;
    } else {
        RULE(result == CDS_TIMEOUT || result == CDS_CORRUPT, job, "ended as %u", result);
        check_failure(job, result);
        note_failure(job);
        if (result == CDS_CORRUPT)
            count.corrupt++;
        else
            count.timeouts++;
    }
    if (reply_is_due(job)) {
        last_id = job->sent[2];
        last_result = result;
    }
}

static void check_end_unsent(struct job *job, enum cds_result result)
{
    wait_no_more(job);
    if (result == CDS_LINE_BUSY) {
        bool rests = is_stale && reply_is_due(job) && !job->request.ignores_stale &&
                     since(stale_until_us) < 0;

        RULE((is_active && since(active_us) < quiet_us()) || rests, job,
             "given up on a quiet line");
        RULE(wait_job == job && wait_is_last && since(wait_last_us) >= quiet_us(), job,
             "given up too early, or without a last look");
        count.line_busy++;
    } else {
        RULE(mode == WITH_PERMIT && job->permit_result == result, job, "ended unsent as %u",
             result);
    }
}

/* True if the queue must send the request again. */
static bool is_sent_again(struct job *job, enum cds_result result)
{
    if ((result != CDS_TIMEOUT && result != CDS_CORRUPT) || !job->is_idempotent ||
        job->request.no_retry || job->retries >= max_retries)
        return false;
    job->retries++;
    wait_before(job, (uint8_t)(job->request.priority + 1));
    count.retried++;
    return true;
}

static void check_end(struct job *job, enum cds_result result)
{
    outcomes[result]++;
    ends++;
    TRACE("request %d ends as %u\n", (int)(job - jobs), result);
    note_low();
    if (flying == job)
        check_end_of_attempt(job, result);
    else
        check_end_unsent(job, result);
    if (wait_job == job)
        wait_job = NULL;
}

/* ---- hooks ---- */

static enum cds_result permit_hook(void *context, struct cds_request *request)
{
    struct job *job = (struct job *)request->context;

    (void)context;
    request->return_delay_us = return_delays_us[request->packet.bytes[2] % SERVOS];
    request->is_muted = job->mutes;
    if (job->permit_result == CDS_PENDING && job->permit_polls-- == 0)
        job->permit_result = CDS_OK;
    if (job->permit_result == CDS_PENDING)
        permit_pending = true;
    permitted = job->permit_result == CDS_OK ? job : NULL;
    return (enum cds_result)job->permit_result;
}

static enum cds_result submit_hook(void *context, struct cds_request *request)
{
    enum cds_result result = CDS_OK;

    if (mode == WITH_PERMIT)
        result = permit_hook(context, request);
    if (result != CDS_OK && result != CDS_PENDING)
        return result;
    return queue.hooks.submit(context, request);
}

static bool cancel_hook(void *context, struct cds_request *request)
{
    return queue.hooks.cancel(context, request);
}

static bool on_sending(void *context, struct cds_request *request)
{
    (void)context, (void)request;
    sending_was_asked = true;
    sending_goes_on = one_in(8);
    return sending_goes_on;
}

static enum cds_result on_end_hook(void *context, struct cds_request *request,
                                   enum cds_result result)
{
    struct job *job = (struct job *)request->context;
    enum cds_result final;
    bool expected;

    if (result == CDS_CANCELLED)
        return queue.hooks.request_ended(context, request, result);
    check_end(job, result);
    expected = is_sent_again(job, result);
    final = queue.hooks.request_ended(context, request, result);
    RULE((final == CDS_PENDING) == expected, job, expected ? "not sent again" : "sent again");
    note_line_and_begin();
    return final;
}

static enum cds_bus_event event_of(uint8_t id, uint8_t asked_id, enum cds_result result)
{
    if (asked_id != id && asked_id != CDS_BROADCAST_ID)
        return CDS_EVENT_UNEXPECTED_PACKET;
    return result == CDS_OK ? CDS_EVENT_DUPLICATE_REPLY : CDS_EVENT_STALE_REPLY;
}

/* True if `event` is right for a packet of servo `id`: by the last transaction that has ended, or
 * by the one in flight if a part of its reply was damaged. */
static bool is_event(enum cds_bus_event event, uint8_t id)
{
    if (event == event_of(id, last_id, last_result))
        return true;
    return awaits_reply() && flying->is_dirty &&
           event == event_of(id, flying->sent[2], CDS_CORRUPT);
}

static void on_packet(void *context, enum cds_bus_event event, uint8_t id, uint8_t error)
{
    uint8_t at = 0;

    (void)context;
    RULE(is_event(event, id), NULL, "packet of servo %u reported as %u", id, event);
    count.stale_replies = (uint16_t)(count.stale_replies + (event == CDS_EVENT_STALE_REPLY));
    count.duplicate_replies =
        (uint16_t)(count.duplicate_replies + (event == CDS_EVENT_DUPLICATE_REPLY));
    count.unexpected_packets =
        (uint16_t)(count.unexpected_packets + (event == CDS_EVENT_UNEXPECTED_PACKET));
    while (at < unreported_count && (unreported[at].id != id || unreported[at].error != error))
        at++;
    RULE(at < unreported_count || !wire_is_clean, NULL, "a packet of servo %u that was not sent",
         id);
    if (at == unreported_count)
        return;
    RULE(at == 0, NULL, "a packet of servo %u was not reported", unreported[0].id);
    remove_unreported(0);
    certain[1]++;
}

static void submit(struct job *job);

static void on_end(struct cds_request *request)
{
    struct job *job = (struct job *)request->context;

    RULE(job->is_submitted, job, "on_end without an end");
    if (mode <= WITHOUT_QUEUE)
        check_end(job, (enum cds_result)request->result);
    RULE(!job->waits && flying != job, job, "on_end before the end");
    job->is_submitted = false;
    memset(job->reply, POISON, CDS_REPLY_ANY);
    if (one_in(2))
        submit(&jobs[any(JOBS)]);
}

/* ---- requests ---- */

static bool covers(uint8_t first, uint8_t length, uint8_t reg)
{
    return first <= reg && reg < first + length;
}

static void build_write(struct job *job, uint8_t id)
{
    static const uint8_t data[3] = {0};
    uint8_t address = (uint8_t)any(CDS_TABLE_SIZE - 3), length = (uint8_t)(1 + any(3));

    if (one_in(3))
        address = one_in(2) ? CDS_REG_ID - 1 : CDS_REG_LOCK - 1;
    cds_packet_write(&job->request.packet, id, address, data, length);
    job->is_idempotent = !covers(address, length, 0x03) && !covers(address, length, 0x04) &&
                         !covers(address, length, 0x2F);
}

static void build_read(struct job *job, uint8_t id)
{
    uint8_t length = (uint8_t)(1 + any(one_in(6) ? CDS_REPLY_MAX : 9));

    cds_packet_read(&job->request.packet, id, 0, length);
    job->request.reply_parameters = length;
    job->request.any_length = one_in(8);
}

static void build_broadcast(struct job *job)
{
    static const uint8_t data[2] = {0};
    struct cds_request *request = &job->request;

    request->reply_parameters = CDS_REPLY_NONE;
    job->is_idempotent = false;
    switch (any(3)) {
    case 0: cds_packet_action(&request->packet, CDS_BROADCAST_ID); break;
    case 1:
        cds_packet_write(&request->packet, CDS_BROADCAST_ID, 0x18, data, 1);
        job->is_idempotent = true;
        break;
    default:
        cds_packet_ping(&request->packet, CDS_BROADCAST_ID);
        request->reply_parameters = 0;
        job->is_idempotent = true;
        break;
    }
}

/* A PING to an ID that was not used for so long that no stale reply can come, as in a scan. */
static void build_probe(struct job *job)
{
    static uint8_t last;

    last = (uint8_t)((last + 1) % 150);
    cds_packet_ping(&job->request.packet, (uint8_t)(100 + last));
    job->request.ignores_stale = true;
    job->request.no_retry = true;
}

static void build(struct job *job)
{
    static const uint8_t data[4] = {0};
    struct cds_request *request = &job->request;
    uint8_t id = (uint8_t)(1 + any(SERVOS));

    request->reply_parameters = 0;
    request->any_length = request->ignores_stale = false;
    request->no_retry = one_in(4);
    job->is_idempotent = true;
    switch (any(8)) {
    case 0: cds_packet_ping(&request->packet, id); break;
    case 1: build_write(job, id); break;
    case 2: build_broadcast(job); break;
    case 3: build_probe(job); break;
    case 4:
        cds_packet_reg_write(&request->packet, id, 0x1E, data, 4);
        job->is_idempotent = false;
        break;
    default: build_read(job, id); break;
    }
    memcpy(job->sent, job->buffer, request->packet.size);
}

/* Gives the request the shortest allowed reply buffer, at the end of the allocation. */
static void lend_reply(struct job *job)
{
    struct cds_request *request = &job->request;

    request->reply_capacity = request->any_length ? CDS_REPLY_ANY : request->reply_parameters;
    if (request->reply_parameters == CDS_REPLY_NONE)
        request->reply_capacity = 0;
    request->reply = job->reply + CDS_REPLY_ANY - request->reply_capacity;
}

static void choose_permit_result(struct job *job)
{
    static const uint8_t refusals[] = {CDS_LIMIT, CDS_INHIBITED, CDS_TOO_EARLY, CDS_NO_REPLY_DUE};

    job->mutes = one_in(10);
    job->permit_result = CDS_OK;
    if (one_in(10))
        job->permit_result = CDS_PENDING;
    else if (one_in(15))
        job->permit_result = refusals[any(sizeof refusals)];
    job->permit_polls = (uint8_t)any(12);
}

static enum cds_result expected_of_submit(const struct job *job)
{
    bool is_busy = flying || waiting_count;

    if (job->is_submitted)
        return CDS_BUSY;
    if (is_locked && !job->request.passes_lock)
        return CDS_BUSY;
    if (mode <= WITHOUT_QUEUE && is_busy)
        return CDS_BUSY;
    if (mode == WITH_PERMIT && job->permit_result != CDS_PENDING)
        return (enum cds_result)job->permit_result;
    return CDS_OK;
}

static void check_poison(const struct job *job)
{
    for (uint8_t i = 0; i < CDS_REPLY_ANY; i++)
        RULE(job->reply[i] == POISON, job, "stored behind the end of its transaction");
}

static void prepare(struct job *job)
{
    check_poison(job);
    if (job->request.packet.size == 0 || job->request.ignores_stale || !one_in(4))
        build(job); // else the packet is submitted again unchanged
    lend_reply(job);
    job->retries = 0;
    job->request.priority = (uint8_t)(one_in(2) ? 0 : any(3));
    job->request.passes_lock = one_in(2);
    choose_permit_result(job);
}

/* Forgets wait_job if another request waits for the line now. */
static void check_waiter(void)
{
    if (wait_job && (bus.state != CDS_BUS_WAITING_FOR_LINE || bus.request != &wait_job->request))
        wait_job = NULL;
}

static void submit(struct job *job)
{
    bool was_submitted = job->is_submitted;
    enum cds_result expected, result;

    if (!was_submitted)
        prepare(job);
    expected = expected_of_submit(job);
    if (!was_submitted && expected == CDS_OK) {
        wait_in_turn(job);
        job->is_submitted = true;
    }
    port_fake.low = level_is_low();
    result = cds_bus_submit(&bus, &job->request);
    RULE(result == expected, job, "submit gives %u, not %u", result, expected);
    if (result != CDS_OK && !was_submitted)
        RULE(job->request.result == result, job, "its result is not that of its submit");
    note_line_and_begin();
    check_waiter();
}

static void cancel(struct job *job)
{
    enum cds_result expected = CDS_BAD_ARGUMENT, result;

    if (job->waits)
        expected = CDS_OK;
    else if (flying == job)
        expected = CDS_BUSY;
    if (job->waits)
        wait_no_more(job);
    port_fake.low = level_is_low();
    result = cds_bus_cancel(&bus, &job->request);
    RULE(result == expected, job, "cancel gives %u, not %u", result, expected);
    if (result == CDS_OK) {
        RULE(job->request.result == CDS_CANCELLED, job, "not cancelled");
        job->is_submitted = false;
        memset(job->reply, POISON, CDS_REPLY_ANY);
        if (wait_job == job)
            wait_job = NULL;
    }
    note_line_and_begin();
    check_waiter();
}

/* ---- what else a program does ---- */

static uint8_t any_rate(void)
{
    static const uint8_t rates[] = {0, 1, 1, 1, 3, 7, 34};

    return one_in(40) ? CDS_BAUD_MAX : rates[any(sizeof rates)];
}

static void open_bus(void)
{
    bool again = bus.state != CDS_BUS_CLOSED;

    cds_bus_open(&bus, PORT, any_rate());
    for (uint8_t i = 0; i < JOBS; i++) {
        RULE(jobs[i].request.result ==
                 (jobs[i].is_submitted ? CDS_CANCELLED : jobs[i].request.result),
             &jobs[i], "not cancelled by open");
        jobs[i].is_submitted = jobs[i].waits = false;
        memset(jobs[i].reply, POISON, CDS_REPLY_ANY);
    }
    memset(&count, 0, sizeof count);
    flying = NULL;
    wait_job = NULL;
    waiting_count = unreported_count = 0;
    is_locked = is_low_known = wire_is_clean = false;
    is_rx_exempt = true;
    bus_delay_us = CDS_RETURN_DELAY_MAX_US;
    last_id = CDS_NO_ID;
    is_stale = is_failure_known = is_active = again;
    failed_us = active_us = port_fake.now_us;
    stale_floor_us = stale_until_us = port_fake.now_us + CDS_STALE_REPLY_US;
}

static void change_rate(void)
{
    uint8_t baud_reg = any_rate(), old = bus.baud_reg;
    enum cds_result result = cds_bus_set_baud(&bus, baud_reg);

    RULE(result == (flying || waiting_count ? CDS_BUSY : CDS_OK), NULL, "set_baud gives %u",
         result);
    if (result != CDS_OK || baud_reg == old)
        return;
    last_id = CDS_NO_ID;
    is_rx_exempt = true;
    is_low_known = is_failure_known = wire_is_clean = false;
}

static void change_delay(void)
{
    static const uint16_t delays[] = {0, 2, 20, 300, CDS_RETURN_DELAY_MAX_US, 1899, 1900, 3000};

    bus_delay_us = delays[any(sizeof delays / sizeof *delays)];
    cds_bus_set_return_delay(&bus, bus_delay_us);
    TRACE("return delay %u us\n", bus_delay_us);
}

static void change_lock(void)
{
    is_locked = !is_locked;
    if (is_locked)
        RULE(cds_bus_lock(&bus, &lock) == CDS_OK, NULL, "not locked");
    else
        cds_bus_unlock(&bus, &lock);
}

static void change_verdict(void)
{
    struct job *job = &jobs[any(JOBS)];

    if (job->waits)
        job->permit_result = one_in(2) ? CDS_INHIBITED : CDS_OK;
}

static void meddle(void)
{
    if (one_in(3))
        submit(&jobs[any(JOBS)]);
    if (one_in(40))
        cancel(&jobs[any(JOBS)]);
    if (one_in(30))
        disturb();
    if (one_in(1500))
        open_bus();
    if (one_in(one_in(2) ? 50 : 500))
        change_rate();
    if (one_in(100))
        change_delay();
    if (one_in(is_locked ? 20 : 300))
        change_lock();
    if (one_in(30))
        change_verdict();
}

/* ---- polls ---- */

/* Returns the time by which a transaction must end if polls were more than a wrap of the timer
 * apart. */
static uint32_t late_limit_us(const struct job *job)
{
    return job->first_poll_us + (duration_us(job) / 32768 + 2) * 65536 + 1000;
}

/* True if a poll may have missed one of several expiries of the timer. */
static bool polls_are_late(const struct job *job)
{
    return job->first_poll_us - job->begun_us + job->longest_gap_us > 32000;
}

/* Checks the deadline after a poll during the transaction. */
static void check_deadline(bool was_unread)
{
    bool is_late = polls_are_late(flying);
    uint32_t limit_us = is_late ? late_limit_us(flying) : deadline_us(flying);

    if (since(limit_us) < 0 || sending_goes_on)
        return;
    if (!flying->is_closed && !is_late) {
        flying->is_closed = true;
        flying->closed_us = port_fake.now_us;
    }
    flying->overdue++;
    flying->idle_overdue = (uint16_t)(flying->idle_overdue + !was_unread);
    RULE(flying->overdue <= OVERDUE && flying->idle_overdue <= 3, flying,
         "does not end by its deadline");
}

/* Notes the first poll of a transaction, which sets the deadline. */
static void note_first_poll(void)
{
    if (flying->is_polled)
        return;
    flying->is_polled = true;
    flying->first_poll_us = port_fake.now_us;
}

static int32_t wait_limit_us(void)
{
    return WAIT_BYTES * byte_us(bus.baud_reg) + CDS_RETURN_DELAY_MAX_US + CDS_REPLY_MARGIN_US;
}

/* Checks `job`, which waited for the line before a poll and still waits. */
static void check_wait(const struct job *job)
{
    bool rests =
        is_stale && reply_is_due(job) && !job->request.ignores_stale && since(stale_until_us) < 0;
    int32_t limit_us = wait_limit_us() + CDS_STALE_REPLY_US;

    RULE((is_active && since(active_us) < quiet_us()) || rests || permit_pending, job,
         "waits though the line is quiet");
    if (wait_is_sloppy)
        limit_us = 2 * limit_us + LATE_US;
    if (since(wait_from_us) < limit_us)
        return;
    if (wait_overdue++ == 0)
        wait_overdue_us = port_fake.now_us;
    RULE(wait_overdue <= 3 || since(wait_overdue_us) <= 2 * quiet_us(), job,
         "waits longer than allowed");
}

static void note_wait(struct job *job)
{
    if (job != wait_job) {
        wait_job = job;
        wait_from_us = wait_least_us = port_fake.now_us;
        wait_overdue = 0;
        wait_is_sloppy = wait_is_last = wait_restarts = false;
        wait_least_us += (uint32_t)(wait_limit_us() - quiet_us());
    } else if (!wait_is_last && since(wait_least_us) >= 0) {
        wait_is_last = true; // the last test of the line begins here or later
        wait_last_us = port_fake.now_us;
    }
    if (wait_restarts) {
        wait_from_us = port_fake.now_us;
        wait_overdue = 0;
    }
}

/* Without on_end the end shows in the return value of the poll. */
static void end_quietly(bool busy)
{
    struct job *job = waiting_count ? waiting[0] : flying;

    RULE(busy == (job && job->request.result == CDS_PENDING), job, "poll returns %d", busy);
    if (job && !busy)
        on_end(&job->request);
}

/* Checks the state that test/eva/driver.c assumes at the beginning of each call. Frama-C Eva proves
 * the absence of run-time errors from it. */
static void check_invariants(void)
{
    const struct cds_parser *parser = &bus.parser;
    bool is_receiving = bus.state == CDS_BUS_RECEIVING;
    uint8_t left = cds_ring_distance(parser->position, parser->end);

    RULE((bus.state >= CDS_BUS_WAITING_FOR_LINE) == (bus.request != NULL), NULL,
         "state %u, request %s", bus.state, bus.request ? "set" : "NULL");
    RULE(is_receiving || bus.phase != 6, NULL, "phase 6 in state %u", bus.state);
    if (is_receiving) {
        const struct cds_request *request = bus.request;

        RULE(parser->found == CDS_FOUND_HEAD && bus.link.state == CDS_LINK_LISTENING, NULL,
             "RECEIVING without a packet, or while sending");
        RULE(parser->to + left <= request->reply + request->reply_capacity, NULL,
             "reply has no place for %u parameters", left);
    } else {
        RULE(parser->found != CDS_FOUND_HEAD || !parser->to, NULL, "state %u stores a packet",
             bus.state);
    }
    RULE(parser->found == CDS_FOUND_NOTHING ||
             (CDS_LENGTH_MIN <= parser->length && parser->length <= CDS_PARSER_LENGTH_MAX),
         NULL, "LENGTH %u of a head", parser->length);
    RULE(parser->longest <= CDS_PARSER_LENGTH_MAX, NULL, "longest %u", parser->longest);
}

static void poll(void)
{
    bool is_unread = bus.link.broken || bus.parser.position != cds_ring_end(&bus.link.rx), busy;
    struct job *head = NULL;
    uint32_t ends_before = ends;
    bool was_polled = flying && flying->is_polled;

    if (bus.state == CDS_BUS_WAITING_FOR_LINE)
        head = (struct job *)bus.request->context;
    note_wait(head);
    if (bus.state <= CDS_BUS_WAITING_FOR_LINE && is_unread) {
        is_active = true;
        active_us = port_fake.now_us;
    }
    if (was_low && since(low_us) >= quiet_us()) {
        is_active = true;
        active_us =
            port_fake.now_us; // the bus waits two byte times from the poll that finds the line high
        was_low = false;
    }
    permit_pending = sending_goes_on = sending_was_asked = false;
    port_fake.low = level_is_low();
    if (port_fake.low && !is_unread && bus.state <= CDS_BUS_WAITING_FOR_LINE)
        port_fake.low_seen++; // each such poll must test the line
    if (flying && flying->drains && bus.state == CDS_BUS_SENDING_ONLY &&
        since(deadline_us(flying)) >= 0)
        port_fake.late = &bus.link;
    check_invariants();
    busy = cds_bus_poll(&bus);
    check_invariants();
    port_fake.late = NULL;
    if (mode == QUIET)
        end_quietly(busy);
    note_line_and_begin();
    TRACE("poll: state %u, gate %u, searched to %u\n", bus.state, bus.gate, bus.parser.position);
    RULE(mode == QUIET || busy == (flying || waiting_count), NULL, "poll returns %d", busy);
    if (flying && was_polled)
        check_deadline(is_unread);
    else if (flying && bus.state != CDS_BUS_SENDING)
        note_first_poll();
    if (was_polled && ends != ends_before)
        return;
    if (permit_pending || !is_active || since(active_us) >= quiet_us())
        wait_job = NULL;                 // a permit check, or a rest on a quiet line, is no wait
    wait_restarts = line_may_be_quiet(); // the bus may have found the line quiet
    if (head && !permit_pending && ends == ends_before && bus.state == CDS_BUS_WAITING_FOR_LINE &&
        bus.request == &head->request)
        check_wait(head);
}

static uint32_t next_gap_us(void)
{
    uint32_t byte = byte_us(bus.baud_reg);

    if (one_in(50000))
        return 1000000 + any(2000000000);
    if (flying && duration_us(flying) > 32768 && one_in(60))
        return any(700000); // several wraps of the timer
    if (one_in(300))
        return 1000 * (1 + any(one_in(10) ? 400 : 40));
    return 1 + any(one_in(10) ? 40 * byte : 4 * byte);
}

static void step(void)
{
    uint32_t us = next_gap_us();

    pass(us);
    wait_is_sloppy = wait_is_sloppy || us > 30000;
    poll();
}

static void check_stats(void)
{
    struct cds_stats is;

    cds_bus_stats(&bus, &is);
    count.malformed = is.malformed;
    count.noise_bytes = is.noise_bytes;
    if (mode != WITH_PERMIT) {
        count.stale_replies = is.stale_replies;
        count.duplicate_replies = is.duplicate_replies;
        count.unexpected_packets = is.unexpected_packets;
    }
    RULE(memcmp(&is, &count, sizeof is) == 0, NULL, "the stats are wrong");
    RULE(is.sent == (uint16_t)(is.ok + is.timeouts + is.corrupt), NULL, "the stats do not add up");
}

/* Lets all requests end, then checks stats and buffers. */
static void end_all(void)
{
    for (uint32_t i = 0; flying || waiting_count; i++) {
        RULE(i < 100000, flying, "the bus does not become idle");
        step();
    }
    for (uint8_t i = 0; i < 20; i++) {
        pass(4u * byte_us(bus.baud_reg));
        poll();
        if (flying || waiting_count)
            return; // on_end has submitted again
    }
    check_stats();
    for (uint8_t i = 0; i < JOBS; i++)
        if (!jobs[i].is_submitted)
            check_poison(&jobs[i]);
    RULE(port_fake.breaches == 0, NULL, "a function of the port was called in a wrong state");
}

/* ---- rounds ---- */

static void attach(void)
{
    memset(&queue, 0, sizeof queue);
    cds_queue_begin(&queue, &bus);
    max_retries = (uint8_t)any(3);
    cds_queue_set_retries(&queue, max_retries);
    hooks = (struct cds_bus_hooks){
        .context = &queue,
        .permit = mode == WITH_PERMIT ? permit_hook : NULL,
        .submit = submit_hook,
        .cancel = cancel_hook,
        .on_sending = on_sending,
        .request_ended = on_end_hook,
        .on_packet = on_packet,
    };
    if (mode <= WITHOUT_QUEUE)
        max_retries = 0;
    else
        RULE(cds_bus_attach(&bus, &hooks) == CDS_OK, NULL, "hooks are not attached");
}

static void begin_round(void)
{
    static const uint16_t delays[] = {0, 2, 100, CDS_RETURN_DELAY_MAX_US, 1500, 3000};

    port_fake_reset();
    memset(&bus, 0, sizeof bus);
    event_next = event_count = 0;
    holds = is_harmed = false;
    port_fake.now_us = one_in(2) ? 0u - any(300000) : any(0x7FFFFFFF) * 2;
    mode = one_in(2) ? WITH_PERMIT : (enum mode)any(3);
    for (uint8_t i = 0; i < JOBS; i++) {
        uint8_t *reply = jobs[i].reply;

        jobs[i] = (struct job){.reply = reply};
        jobs[i].request.packet.bytes = jobs[i].buffer;
        jobs[i].request.packet.capacity = sizeof jobs[i].buffer;
        jobs[i].request.on_end = mode == QUIET ? NULL : on_end;
        jobs[i].request.context = &jobs[i];
    }
    for (uint8_t i = 0; i < SERVOS; i++)
        return_delays_us[i] = delays[any(sizeof delays / sizeof *delays)];
    open_bus();
    attach();
    rounds++;
}

static void run_round(void)
{
    begin_round();
    for (uint16_t i = 0; i < 20000; i++) {
        meddle();
        step();
        if (i % 256 == 255)
            end_all();
    }
    end_all();
}

int main(int argc, char **argv)
{
    uint32_t wanted;

    if (argc < 2) {
        fprintf(stderr, "usage: bus_random TRANSACTIONS [SEED [TRACE_FROM]]\n");
        return 2;
    }
    wanted = (uint32_t)strtoul(argv[1], NULL, 0);
    first_seed = argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 0) : 1;
    if (argc > 3)
        trace_from = (uint32_t)strtoul(argv[3], NULL, 0);
    state = first_seed * 2654435761u | 1;
    for (uint8_t i = 0; i < JOBS; i++)
        jobs[i].reply = malloc(CDS_REPLY_ANY);
    while (transactions < wanted)
        run_round();
    printf(
        "%u transactions in %u rounds: %u ok, %u without a reply, %u corrupt; %u requests found no "
        "quiet line; sure of %u replies, %u other packets, %u damaged ones\n",
        transactions, rounds, outcomes[CDS_OK], outcomes[CDS_TIMEOUT], outcomes[CDS_CORRUPT],
        outcomes[CDS_LINE_BUSY], certain[0], certain[1], certain[2]);
    for (uint8_t i = 0; i < JOBS; i++)
        free(jobs[i].reply);
    puts("ok");
    return 0;
}
