/* SPDX-License-Identifier: MIT */
#include "check.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "rows.h"

#define FAILURES_PRINTED_MAX 10            // failures of a row that are printed
#define START                (30 * RIG_US) // from the read of the clock to the first start bit
#define CLOCK                (5 * RIG_US) // from the end of a byte to the read of the clock after it
#define NOTICED              100u         // cycles until the handler of the last byte has run
/* The library reads the ring, then sends; handlers of two bytes may run between. It cannot notice a
 * byte that ends less than RACE before the packet. It notices one that ends SEEN before or earlier.
 */
#define RACE      (20 * RIG_US)
#define RACE_TIED (24 * RIG_US)
#define SEEN      (25 * RIG_US)
#define RING      64u
#define PING_SIZE 6
/* Time by which the handlers delay the program. */
#define BABBLE_US      400           // on a line that is never quiet
#define BABBLE_TIED_US 1000          // on a line that is never quiet, tied pins
#define TIED_MORE_US   3             // for each byte of a late reply, tied pins
#define QUIET          (60 * RIG_US) // longer than the bus needs to notice a quiet line
#define ENDLESS        (10 * 1000 * 1000 * RIG_US)

/* --- choice of injections, failures --- */

static uint32_t mix(uint32_t a, uint32_t b)
{
    uint32_t mixed = (a ^ b * 0x9E3779B1u) * 0x85EBCA77u;
    return mixed ^ mixed >> 15;
}

static bool is_chosen(const struct check *check)
{
    uint32_t hash = mix(check->seed, check->index);
    for (const char *c = check->row->name; *c; c++) {
        hash = mix(hash, (uint8_t)*c);
    }
    return hash % check->parts == check->part - 1;
}

bool check_next(struct check *check, const char *format, ...)
{
    check->index++;
    if (!is_chosen(check)) {
        return false;
    }
    if (check->counting) {
        check->total++;
        return false;
    }
    check->injections++;
    check->failed = check->skips_oracle = false;
    check->predicts_wrong_value = check->allows_wrong_value = check->allows_wrong_command = false;
    check->allows_overruns = check->allows_ring_overflow = check->powered_up = false;
    check->baud = -1;
    check->pause = 0;
    check->level = 2;
    check->return_delay = 0;
    check->low_until = 0;
    check->bytes_assigned = 0;
    check->least = check->most = (struct check_counters){0};
    check->span.has_packet = false;
    check->span.count = 0;
    check->span.last_id = check->last_id;
    check->span.last_ok = check->last_ok;
    check->rules = check->slack_us = check->framing_errors = check->echo_errors = 0;
    check->next_id = rig_node(check->rig, 0)->id;
    check->stats_before = check->latest.stats;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(check->text, sizeof(check->text), format, arguments);
    va_end(arguments);
    rig_forget(check->rig);
    check->rig->servos_received.count = 0;
    if (check->on_progress) {
        check->on_progress(check);
    }
    return true;
}

void check_fail(struct check *check, const char *format, ...)
{
    if (!check->failed) {
        check->failed = true;
        check->failures++;
    }
    if (check->failures > FAILURES_PRINTED_MAX) {
        return;
    }
    printf("failure\t%s, %s: ", check->row->name, check->text);
    va_list arguments;
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
    putchar('\n');
}

static void expect(struct check *check, const char *what, unsigned expected, unsigned is)
{
    if (expected != is) {
        check_fail(check, "%s: %u, expected %u", what, is, expected);
    }
}

/* --- packets of a job --- */

enum { PING = 1, READ, WRITE, REG_WRITE, ACTION, BROADCAST = 0xFE };

void check_asked(const struct job *job, struct oracle_asked *asked)
{
    static const uint8_t instructions[] = {[JOB_PING] = PING,
                                           [JOB_READ] = READ,
                                           [JOB_WRITE] = WRITE,
                                           [JOB_REG_WRITE] = REG_WRITE,
                                           [JOB_ACTION] = ACTION};
    uint8_t parameters[JOB_DATA_MAX + 1] = {job->address, job->length};
    unsigned count = job->kind == JOB_READ ? 2 : 0;
    if (job->kind == JOB_WRITE || job->kind == JOB_REG_WRITE) {
        memcpy(parameters + 1, job->data, job->length);
        count = job->length + 1u;
    }
    asked->size = oracle_packet(asked->packet, job->id, instructions[job->kind], parameters, count);
    asked->due = job->kind == JOB_READ ? job->length : 0;
    if (job->id == BROADCAST && job->kind != JOB_PING) {
        asked->due = -1;
    }
}

unsigned check_reply(const struct check *check, const struct job *job, uint8_t *packet)
{
    const uint8_t *registers = check->servos[0].registers;
    return oracle_packet(packet, job->id, 0, registers + job->address,
                         job->kind == JOB_READ ? job->length : 0);
}

const char *check_name(const struct job *job)
{
    static char name[24];
    static const char *const names[] = {"PING", "READ", "WRITE", "REG WRITE", "ACTION"};
    snprintf(name, sizeof(name), job->length ? "%s of %u" : "%s", names[job->kind], job->length);
    return name;
}

/* --- received bytes --- */

/* Returns true if the byte is an echo: on tied pins the controller receives each byte that it
 * sends. A byte counts as echo until the transmit-complete handler has run. If a byte ends within
 * NOTICED cycles after the packet, either handler may run first: echo_errors tells which did. */
static bool is_echo(const struct check *check, uint64_t time)
{
    const struct check_span *span = &check->span;
    if (!rig_tied(check->rig) || !span->has_packet || span->echoes == span->asked.size ||
        time < span->echo_from) {
        return false;
    }
    if (time > span->echo_until && time <= span->echo_until + NOTICED) {
        return check->last_stats.echo_errors > check->echo_errors;
    }
    return time <= span->echo_until; // if both handlers are due, the receive handler runs first
}

/* Assigns the bytes received before `until` to the current span. */
static void hear(struct check *check, uint64_t until)
{
    const struct tap *received = &check->rig->received;
    struct check_span *span = &check->span;
    for (; check->bytes_assigned < received->count && check->bytes_assigned < RIG_ROOM;
         check->bytes_assigned++) {
        const struct tap_byte *byte = &received->bytes[check->bytes_assigned];
        if (byte->time >= until) {
            return;
        }
        if (is_echo(check, byte->time)) {
            check->echo_errors += byte->bad || byte->byte != span->asked.packet[span->echoes];
            span->echoes++;
            continue;
        }
        check->framing_errors += byte->bad;
        if (span->count == RIG_ROOM) {
            check_fail(check, "more bytes were received than the rig records");
            return;
        }
        span->times[span->count] = byte->time;
        span->bytes[span->count++] = (struct oracle_byte){byte->byte, byte->bad};
    }
}

/* Extends the bounds by this result; `first`: sets them to it. */
static void widen(struct check_counters *least, struct check_counters *most,
                  const struct oracle_result *result, bool first)
{
    const unsigned is[] = {result->malformed, result->noise_bytes, result->stale_replies,
                           result->duplicate_replies, result->unexpected_packets};
    unsigned *low[] = {&least->malformed, &least->noise_bytes, &least->stale_replies,
                       &least->duplicate_replies, &least->unexpected_packets};
    unsigned *high[] = {&most->malformed, &most->noise_bytes, &most->stale_replies,
                        &most->duplicate_replies, &most->unexpected_packets};
    for (unsigned i = 0; i < sizeof(is) / sizeof(is[0]); i++) {
        *low[i] = first || is[i] < *low[i] ? is[i] : *low[i];
        *high[i] = first || is[i] > *high[i] ? is[i] : *high[i];
    }
}

/* Returns true if the library came to this result. */
static bool fits(const struct check_span *span, const struct oracle_result *result)
{
    if (!span->has_packet || span->good) {
        return result->result == CDS_OK;
    }
    return result->result != CDS_OK &&
           (span->result < 0 || result->result == (unsigned)span->result);
}

/* Predicts the first `count` bytes of the span, once for each number of bytes that may have been in
 * time. Returns true if a prediction has the outcome of the library. `result` is the first of these
 * predictions, `least` and `most` bound their counters. */
static bool predict_part(const struct check_span *span, unsigned count,
                         struct check_counters *least, struct check_counters *most,
                         struct oracle_result *result)
{
    struct oracle_span part = {.asked = span->has_packet ? &span->asked : 0,
                               .bytes = span->bytes,
                               .count = count,
                               .last_id = span->last_id,
                               .last_ok = span->last_ok};
    bool fitted = false;
    unsigned from = span->has_packet ? span->in_time_least : 0,
             to = span->has_packet ? span->in_time_most : 0;
    for (unsigned in_time = to + 1; in_time-- > from;) {
        struct oracle_result one;
        part.in_time = in_time;
        oracle_predict(&part, &one);
        if (fits(span, &one)) {
            widen(least, most, &one, !fitted);
            *result = fitted ? *result : one;
            fitted = true;
        } else if (in_time == to) {
            *result = one;
        }
    }
    return fitted;
}

/* Predicts the span. `until`: start of the next packet. The library may have dropped bytes that
 * ended less than RACE before it. */
static bool predict_span(const struct check_span *span, uint64_t until,
                         struct check_counters *least, struct check_counters *most,
                         struct oracle_result *result)
{
    unsigned count = span->count, bad = 0;
    bool fitted = predict_part(span, count, least, most, result);
    while (fitted && count > 0 && span->times[count - 1] + RACE > until) {
        struct check_counters low, high;
        struct oracle_result without;
        if (!predict_part(span, --count, &low, &high, &without)) {
            break;
        }
        struct oracle_result lowest = {.malformed = low.malformed,
                                       .noise_bytes = low.noise_bytes,
                                       .stale_replies = low.stale_replies,
                                       .duplicate_replies = low.duplicate_replies,
                                       .unexpected_packets = low.unexpected_packets};
        widen(least, most, &lowest, false);
    }
    for (unsigned i = 0; i < span->count; i++) {
        bad += span->bytes[i].bad;
    }
    if (bad > 1) { // the library may skip the bytes between two damaged bytes
        *least = (struct check_counters){0};
    }
    return fitted;
}

static void add(struct check_counters *to, const struct check_counters *more)
{
    to->malformed += more->malformed;
    to->noise_bytes += more->noise_bytes;
    to->stale_replies += more->stale_replies;
    to->duplicate_replies += more->duplicate_replies;
    to->unexpected_packets += more->unexpected_packets;
}

/* Ends the current span at `until`, the start of the next packet. The library reports only the last
 * attempt of a request; the outcome of the attempts before it follows from the received bytes. */
static void close_span(struct check *check, uint64_t until)
{
    struct check_counters least, most;
    struct oracle_result result;
    if (!predict_span(&check->span, until, &least, &most, &result)) {
        check_fail(check, "the received bytes do not lead to this outcome");
        return;
    }
    add(&check->least, &least);
    add(&check->most, &most);
    check->span.has_packet = false;
    check->span.count = 0;
}

static uint32_t allowed_us(const struct check *check)
{
    const struct oracle_asked *asked = &check->asked;
    uint32_t delay = check->job.return_delay ? 2u * check->job.return_delay : CHECK_RETURN_DELAY_US;
    uint32_t reply = asked->due < 0 ? 0 : 10 * (6 + (uint32_t)asked->due) + delay + CHECK_MARGIN_US;
    return 10 * asked->size + reply;
}

static void open_span(struct check *check, unsigned attempt)
{
    struct check_span *span = &check->span;
    const struct tap_byte *sent = check->rig->sent.bytes + attempt * check->asked.size;
    span->asked = check->asked;
    span->has_packet = true;
    span->count = span->echoes = 0;
    span->echo_from = sent[0].time;
    span->echo_until = sent[check->asked.size - 1].time + RIG_BYTE;
    span->last_id = check->last_id;
    span->last_ok = check->last_ok;
}

static uint64_t processing(const struct check *check)
{
    uint32_t bytes = check->asked.due > 0 ? (uint32_t)check->asked.due : 0;
    return (CHECK_PROCESSING_US + CHECK_BYTE_US * bytes + check->slack_us) * (uint64_t)RIG_US;
}

/* The attempt failed between these two times, and the bus rests. The deadline already includes the
 * return delay and the margin. */
static void begin_rest(struct check *check, uint64_t earliest, uint64_t latest)
{
    uint32_t delay = check->job.return_delay ? 2u * check->job.return_delay : CHECK_RETURN_DELAY_US;
    uint64_t rest = (CHECK_STALE_REPLY_US - CHECK_MARGIN_US - delay) * (uint64_t)RIG_US;
    check->rest_least = earliest + rest;
    check->rest_most = latest + rest;
}

/* The attempt ended before `until`. Bytes that arrived before its deadline were in time; bytes that
 * arrived later may have been. */
static void end_span(struct check *check, uint64_t until, int result)
{
    struct check_span *span = &check->span;
    uint64_t deadline = span->echo_from + allowed_us(check) * (uint64_t)RIG_US - START;
    hear(check, until);
    span->good = result == CDS_OK;
    span->result = result;
    span->in_time_most = span->in_time_least = span->count;
    while (!span->good && span->in_time_least > 0 &&
           span->times[span->in_time_least - 1] + CLOCK > deadline) {
        span->in_time_least--;
    }
    if (check->asked.due >= 0) {
        check->last_id = check->asked.packet[2];
        check->last_ok = span->good;
        if (!span->good) {
            begin_rest(check, deadline, result < 0 ? deadline + START + processing(check) : until);
        }
    }
}

/* --- one transaction --- */

static double us(uint64_t cycles)
{
    return (double)cycles / RIG_US;
}

/* Checks that the last attempt ended by its deadline, and not before it if it failed. */
static void check_time(struct check *check)
{
    const struct rig *rig = check->rig;
    uint64_t start = rig->sent.bytes[(check->attempts - 1) * check->asked.size].time;
    uint64_t took = rig->ended - start, allowed = allowed_us(check) * (uint64_t)RIG_US;
    if (took > allowed + processing(check)) {
        check_fail(check, "took %.1f us, deadline %.1f", us(took), us(allowed));
    }
    if (check->outcome.result != CDS_OK && took + START < allowed) {
        check_fail(check, "failed after %.1f us, deadline %.1f", us(took), us(allowed));
    }
    if (took > allowed && took - allowed > check->longest) {
        check->longest = took - allowed;
    }
}

/* Returns when another sender last used the line, as far as the controller can know; 0: never.
 * `until`: start of the next packet. Sets `bytes` to the number of bytes that ended less than
 * `near` before `until`. */
static uint64_t last_use(const struct check *check, uint64_t until, uint64_t near, unsigned *bytes)
{
    const struct check_span *span = &check->span;
    uint64_t last = check->corrupt_at;
    struct check_counters least, most;
    struct oracle_result result;
    unsigned first = 0;
    *bytes = 0;
    if (span->has_packet && predict_part(span, span->count, &least, &most, &result)) {
        first = result.taken ? result.taken : span->in_time_least;
    }
    for (unsigned i = first; i < span->count; i++) {
        last = span->times[i] > last ? span->times[i] : last;
        *bytes += span->times[i] + near > until;
    }
    return check->low_until > last ? check->low_until : last;
}

/* Checks that the packet was sent after the line was quiet for long enough, and then at once. Two
 * bytes may end after the library last reads the ring: it cannot notice them in time. */
static void check_start(struct check *check, unsigned attempt)
{
    const struct rig *rig = check->rig;
    uint64_t start = rig->sent.bytes[attempt * check->asked.size].time, from = rig->begun;
    unsigned near, nearest;
    if (attempt > 0) {
        from = rig->sent.bytes[(attempt - 1) * check->asked.size].time +
               allowed_us(check) * (uint64_t)RIG_US;
    }
    last_use(check, start, rig_tied(rig) ? RACE_TIED : RACE, &nearest);
    uint64_t used = last_use(check, start, SEEN, &near);
    if (near > nearest) {
        check_fail(check, "sent into a line in use");
    }
    if (check->asked.due >= 0) {
        if (start < check->rest_least) {
            check_fail(check, "sent %.1f us before the rest was over",
                       us(check->rest_least - start));
        }
        from = check->rest_most > from ? check->rest_most : from;
    }
    uint64_t latest = (used > from ? used : from) + CHECK_QUIET_US * RIG_US + processing(check);
    if (start > latest) {
        check_fail(check, "sent %.1f us later than allowed", us(start - latest));
    }
}

/* Time that the library needs to read a full ring. */
static uint64_t full_ring_cycles(const struct rig *rig)
{
    return RING * RIG_US * (rig_tied(rig) ? CHECK_BYTE_TIED_US : CHECK_BYTE_US);
}

/* Checks a request that was not sent: the line was in use, and the request ended in time. */
static void check_unsent(struct check *check)
{
    const struct rig *rig = check->rig;
    uint64_t took = rig->ended - rig->begun, wait = CHECK_QUIET_WAIT_US * (uint64_t)RIG_US;
    unsigned bytes;
    hear(check, rig->ended);
    if (took + CLOCK < wait || took > wait + processing(check)) {
        check_fail(check, "waited %.1f us for a quiet line, bound %.1f", us(took), us(wait));
    }
    if (took > wait && took - wait > check->longest) {
        check->longest = took - wait;
    }
    uint64_t behind =
        3 * CHECK_QUIET_US * RIG_US + (check->allows_ring_overflow ? full_ring_cycles(rig) : 0);
    if (last_use(check, rig->ended, 0, &bytes) + behind < rig->ended) {
        check_fail(check, "the line was quiet, and nothing was sent");
    }
    if (check->outcome.state == CDS_BUS_LINE_QUIET) {
        check_fail(check, "the bus reports a quiet line");
    }
}

static void check_sent(struct check *check)
{
    const struct tap *sent = &check->rig->sent;
    unsigned size = check->asked.size;
    expect(check, "bytes sent", check->attempts * size, sent->count);
    for (unsigned i = 0; i < sent->count && i < RIG_ROOM; i++) {
        if (sent->bytes[i].byte != check->asked.packet[i % size]) {
            check_fail(check, "sent %02X as byte %u", sent->bytes[i].byte, i);
        }
    }
}

/* Assigns all received bytes to the attempts of the transaction. */
static void hear_all(struct check *check)
{
    const struct rig *rig = check->rig;
    for (unsigned attempt = 0; attempt < check->attempts; attempt++) {
        uint64_t start = rig->sent.bytes[attempt * check->asked.size].time;
        if (attempt > 0) {
            end_span(check, start, -1);
        }
        hear(check, start);
        if (!check->skips_oracle) {
            check_start(check, attempt);
            close_span(check, start);
        }
        open_span(check, attempt);
    }
    bool sent = check->outcome.result != CDS_LINE_BUSY;
    end_span(check, rig->ended, sent ? check->outcome.result : -1);
    if (check->outcome.result == CDS_CORRUPT) {
        check->corrupt_at = rig->ended;
    }
}

static void subtract(struct cds_stats *a, const struct cds_stats *b)
{
    uint16_t *words = (uint16_t *)(void *)a;
    const uint16_t *less = (const uint16_t *)(const void *)b;
    for (unsigned i = 0; i < sizeof(*a) / sizeof(*words); i++) {
        words[i] = (uint16_t)(words[i] - less[i]);
    }
}

void check_sent_total(struct check *check)
{
    const struct cds_stats *stats = &check->last_stats;
    expect(check, "ok + timeouts + corrupt", stats->sent,
           (unsigned)stats->ok + stats->timeouts + stats->corrupt);
}

/* Checks the counters of one transaction. check_settle() checks the counters of other bytes. */
static void check_counters(struct check *check)
{
    const struct cds_stats *stats = &check->last_stats;
    enum cds_result result = check->outcome.result;
    bool unsent = result == CDS_LINE_BUSY;
    expect(check, "retried", stats->sent - (unsent ? 0u : 1u), stats->retried);
    expect(check, "line_busy", unsent, stats->line_busy);
    expect(check, "ok", result == CDS_OK, stats->ok);
    if ((result == CDS_TIMEOUT && !stats->timeouts) || (result == CDS_CORRUPT && !stats->corrupt)) {
        check_fail(check, "the failure was not counted");
    }
    if (stats->retried > check->job.retries) {
        check_fail(check, "%u retries, allowed %u", stats->retried, check->job.retries);
    }
}

static void between(struct check *check, const char *what, unsigned least, unsigned most,
                    unsigned is)
{
    if (is < least || is > most) {
        check_fail(check, "%s: %u, expected %u to %u", what, is, least, most);
    }
}

/* Checks the counters since the start of the injection. */
static void check_counts(struct check *check)
{
    struct check_counters least, most;
    struct oracle_result result;
    const struct cds_stats *stats = &check->injection_stats;
    expect(check, "framing errors", check->framing_errors, stats->framing_errors);
    expect(check, "echo errors", check->echo_errors, stats->echo_errors);
    expect(check, "overruns", 0, stats->overruns);
    if (!check->allows_ring_overflow) {
        expect(check, "ring overflows", 0, stats->ring_overflows);
    }
    if (check->failed) {
        return;
    }
    if (!predict_span(&check->span, UINT64_MAX, &least, &most, &result)) {
        check_fail(check, "the received bytes do not lead to this outcome");
        return;
    }
    add(&least, &check->least);
    add(&most, &check->most);
    if (stats->ring_overflows == 0) {
        between(check, "malformed", least.malformed, most.malformed, stats->malformed);
        between(check, "noise_bytes", least.noise_bytes, most.noise_bytes, stats->noise_bytes);
        between(check, "stale_replies", least.stale_replies, most.stale_replies,
                stats->stale_replies);
        between(check, "duplicate_replies", least.duplicate_replies, most.duplicate_replies,
                stats->duplicate_replies);
        between(check, "unexpected_packets", least.unexpected_packets, most.unexpected_packets,
                stats->unexpected_packets);
    }
}

/* Returns true if a servo sent the reply that the library took. */
static bool was_given(const struct check *check)
{
    const struct rig *rig = check->rig;
    const struct job_outcome *outcome = &check->outcome;
    for (unsigned i = 0; i < rig->answer_count && i < RIG_ANSWERS; i++) {
        const uint8_t *bytes = rig->answers[i].bytes;
        if (rig->answers[i].size == 6u + outcome->length && bytes[2] == outcome->id &&
            bytes[4] == outcome->error && memcmp(bytes + 5, outcome->data, outcome->length) == 0) {
            return true;
        }
    }
    return check->asked.due < 0;
}

static void check_value(struct check *check)
{
    const struct job_outcome *outcome = &check->outcome;
    struct check_counters least, most;
    struct oracle_result one, *result = &one;
    predict_part(&check->span, check->span.count, &least, &most, result);
    expect(check, "result", result->result, outcome->result);
    if (outcome->result != CDS_OK || result->result != CDS_OK) {
        return;
    }
    expect(check, "id", result->id, outcome->id);
    expect(check, "error", result->error, outcome->error);
    expect(check, "length", result->length, outcome->length);
    if (memcmp(result->data, outcome->data, result->length) != 0) {
        check_fail(check, "the values differ from the received bytes");
    }
}

static void check_rules(struct check *check)
{
    for (unsigned rule = 0; rule < RULE_COUNT; rule++) {
        uint32_t breaches = check->rig->bench.rules.breaches[rule];
        if (breaches && !(check->rules & RULE(rule))) {
            check_fail(check, "rule broken: %s, %u times", rule_name(rule), breaches);
        }
    }
}

static void perform(struct check *check, const struct job *job, struct job_outcome *outcome)
{
    rig_begin(check->rig, job);
    if (!rig_wait(check->rig, ENDLESS, outcome)) {
        check_fail(check, "the call did not end");
        printf("failure\t%s: row aborted\n", check->row->name);
        exit(1);
    }
}

void check_job(struct check *check, const struct job *job)
{
    struct cds_stats before = check->latest.stats;
    check->job = *job;
    if (job->kind < JOB_SCAN) {
        check_asked(job, &check->asked);
        bool known = job->servos != JOB_WITHOUT_SERVOS;
        if (known && job->kind != JOB_PING && check->level < (job->kind == JOB_READ ? 1 : 2)) {
            check->asked.due = -1;
        }
    }
    perform(check, job, &check->outcome);
    check->latest = check->outcome;
    check->last_stats = check->outcome.stats;
    subtract(&check->last_stats, &before);
    check->attempts = check->last_stats.sent;
}

static void check_transaction(struct check *check)
{
    expect(check, "submitted", CDS_OK, check->outcome.submitted);
    check_sent(check);
    check_sent_total(check);
    expect(check, "bytes stored behind the reply", 0, check->outcome.spilled);
    check->skips_oracle |= check->allows_overruns && check->rig->overruns;
    if (!check->failed && check->attempts > 0) {
        hear_all(check);
        if (check->outcome.result != CDS_LINE_BUSY) {
            check_time(check);
        }
        if (!check->skips_oracle && check->outcome.result != CDS_LINE_BUSY) {
            check_value(check);
        }
    } else if (!check->failed) {
        check_unsent(check);
    }
    if (!check->failed) {
        check_counters(check);
    }
    if (!rig_listens(check->rig)) {
        check_fail(check, "the driver was not released");
    }
}

/* --- the servos --- */

/* Changes the registers of a servo as the job does. */
static void apply_job(const struct job *job, uint8_t *registers)
{
    if (job->kind == JOB_WRITE) {
        memcpy(registers + job->address, job->data, job->length);
    } else if (job->kind == JOB_REG_WRITE) {
        registers[TABLE_REGISTERED] = 1;
    }
}

/* Changes the registers of a servo as a power-up does. */
static void power_up(const struct servo *servo, uint8_t *registers)
{
    struct servo again = *servo;
    memcpy(again.registers, registers, sizeof(again.registers));
    servo_power(&again, true);
    memcpy(registers, again.registers, sizeof(again.registers));
}

/* A servo holds a value that was not requested. This is a failure unless the servo received a
 * damaged packet that says so, and the row allows it. */
static void check_unrequested_value(struct check *check, unsigned index)
{
    const struct tap *received = &check->rig->servos_received;
    struct oracle_byte bytes[RIG_ROOM];
    unsigned count = received->count < RIG_ROOM ? received->count : RIG_ROOM;
    for (unsigned i = 0; i < count; i++) {
        bytes[i] = (struct oracle_byte){received->bytes[i].byte, received->bytes[i].bad};
    }
    check->misunderstood++;
    if (!oracle_commands(&check->asked, bytes, count)) {
        check_fail(check, "servo %u holds a value that no packet sets", index);
    } else if (!check->allows_wrong_command) {
        check_fail(check, "servo %u carried out a damaged packet", index);
    }
}

/* Checks that each servo has carried out `job`, or has not changed. `acknowledged`: the servo of
 * the job must have carried it out. */
static void check_servos(struct check *check, const struct job *job, bool acknowledged)
{
    check_asked(job, &check->asked);
    for (unsigned i = 0; i < check->rig->bench.bus[0].servos.count; i++) {
        const struct servo *servo = &rig_node(check->rig, i)->servo;
        uint8_t asked[SERVO_REGISTERS];
        memcpy(asked, check->servos[i].registers, sizeof(asked));
        if (i == 0 && check->powered_up) {
            power_up(&check->servos[i], asked);
        }
        if (i == 0 && check->baud >= 0) {
            asked[TABLE_BAUD] = (uint8_t)check->baud;
        }
        bool untouched = memcmp(asked, servo->registers, sizeof(asked)) == 0;
        bool mine = job->id == BROADCAST || asked[TABLE_ID] == job->id;
        if (mine) {
            apply_job(job, asked);
        }
        bool done = memcmp(asked, servo->registers, sizeof(asked)) == 0;
        if (!done && !untouched) {
            check_unrequested_value(check, i);
        } else if (mine && acknowledged && !done && !check->predicts_wrong_value &&
                   !check->powered_up && !check->allows_wrong_command) {
            check_fail(check, "acknowledged, but servo %u does not hold the value", i);
        }
    }
}

/* Restores power, rates and registers. */
static void restore(struct check *check)
{
    struct rig *rig = check->rig;
    for (unsigned i = 0; i < rig->bench.bus[0].servos.count; i++) {
        struct servo_node *node = rig_node(rig, i);
        servo_node_power(node, rig_now(rig), true);
        uint8_t baud = node->baud;
        node->servo = check->servos[i];
        node->extra_delay_us = 0;
        if (baud != node->servo.registers[TABLE_BAUD]) {
            servo_node_baud(node, node->servo.registers[TABLE_BAUD]);
            node->has_wrong_baud = false;
        }
    }
}

/* Returns how many bytes the longest incomplete packet of a servo still lacks. The servo takes the
 * next packets for these bytes. */
static unsigned missing_bytes(const struct check *check)
{
    unsigned most = 0;
    for (unsigned i = 0; i < check->rig->bench.bus[0].servos.count; i++) {
        const struct servo_node *node = rig_node(check->rig, i);
        const struct codec *codec = &node->servo.codec;
        bool receives = node->baud == SERVO_RESET_BAUD; // at another rate it receives no packet
        unsigned held = receives ? (unsigned)(codec->size - codec->first) : 0;
        unsigned whole = held > 3 ? 4u + codec->bytes[codec->first + 3] : held ? 4 + 254 : 0;
        most = whole > held && whole - held > most ? whole - held : most;
    }
    return most;
}

/* --- functions for rows --- */

void check_open(struct check *check)
{
    unsigned count = check->rig->bench.bus[0].servos.count;
    check->last_id = 0xFF; // no servo
    check->servos = calloc(count ? count : 1, sizeof(*check->servos));
    for (unsigned i = 0; i < count; i++) {
        struct servo *servo = &rig_node(check->rig, i)->servo;
        table_set(servo->registers, TABLE_GOAL_POSITION, 2, (uint16_t)(0x1A5 + 0x59 * i));
        table_set(servo->registers, TABLE_MOVING_SPEED, 2, (uint16_t)(0x0C3 + 0x11 * i));
        check->servos[i] = *servo;
    }
}

void check_close(struct check *check)
{
    free(check->servos);
}

void check_run(struct check *check, const struct job *job)
{
    check_job(check, job);
    check_transaction(check);
    if (check->outcome.result == CDS_OK && !check->failed) {
        bool given = was_given(check);
        check->undetected += !given;
        if (given == check->predicts_wrong_value && !(check->allows_wrong_value && !given)) {
            check_fail(check, given ? "a wrong value was predicted, but not taken"
                                    : "a value was taken that no servo sent");
        }
    } else if (check->predicts_wrong_value) {
        check_fail(check, "a wrong value was predicted, but not taken");
    }
}

void check_allow_late_bytes(struct check *check, const struct job *job)
{
    uint8_t reply[SERVO_PACKET_MAX];
    check->slack_us = rig_tied(check->rig) ? TIED_MORE_US * check_reply(check, job, reply) : 0;
}

void check_allow_babble(struct check *check)
{
    check->allows_ring_overflow = true;
    check->slack_us = rig_tied(check->rig) ? BABBLE_TIED_US : BABBLE_US;
}

void check_outcome(struct check *check, unsigned outcomes)
{
    if (!(OUTCOME(check->outcome.result) & outcomes)) {
        check_fail(check, "outcome %u", check->outcome.result);
    }
}

void check_refused(struct check *check, const struct job *job, enum cds_result result)
{
    check_job(check, job);
    hear(check, check->rig->ended);
    expect(check, "submitted", result, check->outcome.submitted);
    expect(check, "bytes sent", 0, check->rig->sent.count);
    expect(check, "sent", 0, check->last_stats.sent);
    expect(check, "line_busy", 0, check->last_stats.line_busy);
}

void check_forget(struct check *check)
{
    hear(check, UINT64_MAX);
    rig_forget(check->rig);
    check->bytes_assigned = 0;
}

void check_settle(struct check *check)
{
    static const struct job look = {.kind = JOB_LOOK};
    if (!rig_settle(check->rig)) {
        check_fail(check, "the line does not become quiet");
        return;
    }
    rig_pass(check->rig, QUIET);
    hear(check, UINT64_MAX);
    perform(check, &look, &check->latest);
    check->injection_stats = check->latest.stats;
    subtract(&check->injection_stats, &check->stats_before);
    expect(check, "state of the bus", CDS_BUS_LINE_QUIET, check->latest.state);
    if (!check->skips_oracle) {
        check_counts(check);
    }
}

/* Sends good packets until one is answered. The first must be, unless a servo holds part of a
 * packet. Such a servo takes the next packets for bytes of that packet, and then up to two more,
 * because it takes the end of a packet for a beginning. PING and READ alternate: a packet that is
 * sent again and again can keep the servo out of step for ever. */
static void check_good(struct check *check)
{
    struct job job = {.kind = JOB_READ,
                      .id = check->next_id,
                      .address = TABLE_GOAL_POSITION,
                      .length = 2,
                      .return_delay = check->return_delay,
                      .pause = check->pause};
    unsigned missing = missing_bytes(check), may_fail = missing ? (missing - 1) / PING_SIZE + 3 : 0;
    for (unsigned lost = 0;; lost++) {
        check_job(check, &job);
        check_transaction(check);
        if (check->outcome.result == CDS_OK && !check->outcome.error) {
            break;
        }
        if (lost == may_fail) {
            check_fail(check, "the next transaction failed: result %u, error %02X",
                       check->outcome.result, check->outcome.error);
            return;
        }
        check->lost++;
        check_settle(check);
        check_forget(check);
        job.kind = job.kind == JOB_READ ? JOB_PING : JOB_READ;
    }
    if (!was_given(check)) {
        check_fail(check, "the next transaction took a value that no servo sent");
    }
}

void check_after(struct check *check)
{
    struct rig *rig = check->rig;
    rig_order(rig, "clear");
    if (!check->pause) {
        check_settle(check);
    }
    check_rules(check);
    struct job job = check->job;
    bool acknowledged = check->outcome.result == CDS_OK && !check->outcome.error;
    check_forget(check);
    check_good(check);
    check_rules(check);
    check_settle(check);
    check_servos(check, &job, acknowledged);
    restore(check);
}

void check_all(struct check *check, const struct job *job, unsigned outcomes)
{
    check_run(check, job);
    check_outcome(check, outcomes);
    check_after(check);
}
