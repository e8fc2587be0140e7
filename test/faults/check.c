#include "check.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "rows.h"

#define TOLD_MAX 10            // failures of a row that are told in full
#define START    (30 * RIG_US) // from the reading of the clock to the first start bit
#define CLOCK    (5 * RIG_US)  // from the end of a byte to the clock that is read for it
/* From the last look at the ring to the first start bit, with the handlers of two bytes amid it:
 * one that ends within this time before a packet, nobody saw. One that was seen ended SEEN before.
 */
#define NOTICED        100u // cycles until the handler of the last byte has run
#define RACE           (20 * RIG_US)
#define RACE_TIED      (24 * RIG_US)
#define SEEN           (25 * RIG_US)
#define RING           64u
#define PING_SIZE      6
#define BABBLE_US      400  // how much longer a line never quiet holds up the program: on tied
#define BABBLE_TIED_US 1000 // ... pins the handlers take most of the time there is
#define TIED_MORE_US   3    // ... and by each byte more
#define QUIET          (60 * RIG_US) // more than it takes a bus to see that it is
#define ENDLESS        (10 * 1000 * 1000 * RIG_US)

/* --- which, and what of it --- */

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
    check->failed = check->foreseen = check->mixed = check->holds = check->blind = false;
    check->baud = -1;
    check->pause = 0;
    check->level = 2;
    check->told = 0;
    check->babbles = check->several = false;
    check->low_until = 0;
    check->judged = 0;
    check->least = check->most = (struct check_sums){0};
    check->span.asks = false;
    check->span.count = 0;
    check->span.last_id = check->last_id;
    check->span.last_ok = check->last_ok;
    check->misunderstood = check->powered_up = false;
    check->rules = check->slack_us = check->bad = check->echo_errors = 0;
    check->good_id = rig_node(check->rig, 0)->id;
    check->before = check->look.stats;
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
    if (check->failures > TOLD_MAX) {
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

/* --- what a job means --- */

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

/* --- what is heard --- */

/* As many bytes as are said are echo, as long as the controller has not noticed that all are out. A
 * byte that ends with the packet may find the handler of that before its own, or behind it. */
static bool is_echo(const struct check *check, uint64_t time)
{
    const struct check_span *span = &check->span;
    if (!rig_tied(check->rig) || !span->asks || span->echoes == span->asked.size ||
        time < span->echo_from) {
        return false;
    }
    if (time > span->echo_until && time <= span->echo_until + NOTICED) {
        return check->moved.echo_errors > check->echo_errors;
    }
    return time <= span->echo_until; // at once: the receiver is first
}

/* What was heard until then is of the present span. */
static void hear(struct check *check, uint64_t until)
{
    const struct tap *received = &check->rig->received;
    struct check_span *span = &check->span;
    for (; check->judged < received->count && check->judged < RIG_ROOM; check->judged++) {
        const struct tap_byte *byte = &received->bytes[check->judged];
        if (byte->time >= until) {
            return;
        }
        if (is_echo(check, byte->time)) {
            check->echo_errors += byte->bad || byte->byte != span->asked.packet[span->echoes];
            span->echoes++;
            continue;
        }
        check->bad += byte->bad;
        if (span->count == RIG_ROOM) {
            check_fail(check, "too much was heard");
            return;
        }
        span->times[span->count] = byte->time;
        span->bytes[span->count++] = (struct oracle_byte){byte->byte, byte->bad};
    }
}

static void widen(struct check_sums *least, struct check_sums *most, const struct result *result,
                  bool first)
{
    const unsigned is[] = {result->refuted, result->stray, result->late, result->extra,
                           result->foreign};
    unsigned *low[] = {&least->refuted, &least->stray, &least->late, &least->extra,
                       &least->foreign};
    unsigned *high[] = {&most->refuted, &most->stray, &most->late, &most->extra, &most->foreign};
    for (unsigned i = 0; i < sizeof(is) / sizeof(is[0]); i++) {
        *low[i] = first || is[i] < *low[i] ? is[i] : *low[i];
        *high[i] = first || is[i] > *high[i] ? is[i] : *high[i];
    }
}

static bool fits(const struct check_span *span, const struct result *result)
{
    if (!span->asks || span->good) {
        return result->result == CDS_OK;
    }
    return result->result != CDS_OK &&
           (span->result < 0 || result->result == (unsigned)span->result);
}

/* Of the first `count` bytes of the span, over all that may have been in time. True: the oracle
 * comes to the result that the library came to; then `verdict` says so. */
static bool judge_part(const struct check_span *span, unsigned count, struct check_sums *least,
                       struct check_sums *most, struct result *result)
{
    struct oracle_span part = {.asked = span->asks ? &span->asked : 0,
                               .bytes = span->bytes,
                               .count = count,
                               .last_id = span->last_id,
                               .last_ok = span->last_ok};
    bool fitted = false;
    unsigned from = span->asks ? span->in_time_least : 0, to = span->asks ? span->in_time_most : 0;
    for (unsigned in_time = to + 1; in_time-- > from;) {
        struct result one;
        part.in_time = in_time;
        oracle_judge(&part, &one);
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

/* Bytes that ended just before the next packet `until` may have been thrown away. */
static bool judge_span(const struct check_span *span, uint64_t until, struct check_sums *least,
                       struct check_sums *most, struct result *result)
{
    unsigned count = span->count, bad = 0;
    bool fitted = judge_part(span, count, least, most, result);
    while (fitted && count > 0 && span->times[count - 1] + RACE > until) {
        struct check_sums low, high;
        struct result without;
        if (!judge_part(span, --count, &low, &high, &without)) {
            break;
        }
        struct result lowest = {.refuted = low.refuted,
                                .stray = low.stray,
                                .late = low.late,
                                .extra = low.extra,
                                .foreign = low.foreign};
        widen(least, most, &lowest, false);
    }
    for (unsigned i = 0; i < span->count; i++) {
        bad += span->bytes[i].bad;
    }
    if (bad > 1) { // what stands between them may go unexamined
        *least = (struct check_sums){0};
    }
    return fitted;
}

static void add(struct check_sums *to, const struct check_sums *more)
{
    to->refuted += more->refuted;
    to->stray += more->stray;
    to->late += more->late;
    to->extra += more->extra;
    to->foreign += more->foreign;
}

/* The next packet begins: how the last one ended, if it was not the last of a request, is to be
 * told from what was heard. */
static void close_span(struct check *check, uint64_t until)
{
    struct check_sums least, most;
    struct result result;
    if (!judge_span(&check->span, until, &least, &most, &result)) {
        check_fail(check, "what was heard does not fit how it ended");
        return;
    }
    add(&check->least, &least);
    add(&check->most, &most);
    check->span.asks = false;
    check->span.count = 0;
}

static uint32_t allowed_us(const struct check *check)
{
    const struct oracle_asked *asked = &check->asked;
    uint32_t delay = check->job.told ? 2u * check->job.told : CHECK_RETURN_DELAY_US;
    uint32_t reply = asked->due < 0 ? 0 : 10 * (6 + (uint32_t)asked->due) + delay + CHECK_MARGIN_US;
    return 10 * asked->size + reply;
}

static void open_span(struct check *check, unsigned attempt)
{
    struct check_span *span = &check->span;
    const struct tap_byte *sent = check->rig->sent.bytes + attempt * check->asked.size;
    span->asked = check->asked;
    span->asks = true;
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

/* The attempt was given up between these two times. The deadline has allowed for the return delay
 * and the margin. */
static void begin_rest(struct check *check, uint64_t earliest, uint64_t latest)
{
    uint32_t delay = check->job.told ? 2u * check->job.told : CHECK_RETURN_DELAY_US;
    uint64_t rest = (CHECK_STALE_REPLY_US - CHECK_MARGIN_US - delay) * (uint64_t)RIG_US;
    check->rest_least = earliest + rest;
    check->rest_most = latest + rest;
}

/* The attempt was over by `until`. All that had come by its deadline was in time, and what came
 * since then may have been. */
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

/* --- one exchange --- */

static double us(uint64_t cycles)
{
    return (double)cycles / RIG_US;
}

/* The last attempt ends by its deadline, and not before if it failed. */
static void check_time(struct check *check)
{
    const struct rig *rig = check->rig;
    uint64_t start = rig->sent.bytes[(check->attempts - 1) * check->asked.size].time;
    uint64_t took = rig->ended - start, allowed = allowed_us(check) * (uint64_t)RIG_US;
    if (took > allowed + processing(check)) {
        check_fail(check, "took %.1f us, deadline %.1f", us(took), us(allowed));
    }
    if (check->outcome.result != CDS_OK && took + START < allowed) {
        check_fail(check, "gave up after %.1f us, deadline %.1f", us(took), us(allowed));
    }
    if (took > allowed && took - allowed > check->longest) {
        check->longest = took - allowed;
    }
}

/* When the line was last in use by others, as far as a controller can know, before its next packet
 * at `until`; 0: not. Sets how many bytes there were within `near`. */
static uint64_t last_use(const struct check *check, uint64_t until, uint64_t near, unsigned *bytes)
{
    const struct check_span *span = &check->span;
    uint64_t last = check->corrupt_at;
    struct check_sums least, most;
    struct result result;
    unsigned first = 0;
    *bytes = 0;
    if (span->asks && judge_part(span, span->count, &least, &most, &result)) {
        first = result.taken ? result.taken : span->in_time_least;
    }
    for (unsigned i = first; i < span->count; i++) {
        last = span->times[i] > last ? span->times[i] : last;
        *bytes += span->times[i] + near > until;
    }
    return check->low_until > last ? check->low_until : last;
}

/* A packet is sent when the line has been quiet for long enough, and then at once. Two bytes may
 * end while the controller makes up its mind: nobody can see them in time. */
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
        check_fail(check, "spoke into a line in use");
    }
    if (check->asked.due >= 0) {
        if (start < check->rest_least) {
            check_fail(check, "spoke %.1f us before the rest was over",
                       us(check->rest_least - start));
        }
        from = check->rest_most > from ? check->rest_most : from;
    }
    uint64_t latest = (used > from ? used : from) + CHECK_QUIET_US * RIG_US + processing(check);
    if (start > latest) {
        check_fail(check, "spoke %.1f us after it might have", us(start - latest));
    }
}

/* Until a full ring has been looked at. */
static uint64_t backlog(const struct rig *rig)
{
    return RING * RIG_US * (rig_tied(rig) ? CHECK_BYTE_TIED_US : CHECK_BYTE_US);
}

/* A request that was not sent: for good reason, and given up in time. */
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
    uint64_t behind = 3 * CHECK_QUIET_US * RIG_US + (check->babbles ? backlog(rig) : 0);
    if (last_use(check, rig->ended, 0, &bytes) + behind < rig->ended) {
        check_fail(check, "the line was quiet, and nothing was said");
    }
    if (check->outcome.state == CDS_BUS_LINE_QUIET) {
        check_fail(check, "the line is said to be quiet");
    }
}

static void check_sent(struct check *check)
{
    const struct tap *sent = &check->rig->sent;
    unsigned size = check->asked.size;
    expect(check, "bytes said", check->attempts * size, sent->count);
    for (unsigned i = 0; i < sent->count && i < RIG_ROOM; i++) {
        if (sent->bytes[i].byte != check->asked.packet[i % size]) {
            check_fail(check, "said %02X as byte %u", sent->bytes[i].byte, i);
        }
    }
}

/* What was heard, put down to the packets that were said. */
static void hear_all(struct check *check)
{
    const struct rig *rig = check->rig;
    for (unsigned attempt = 0; attempt < check->attempts; attempt++) {
        uint64_t start = rig->sent.bytes[attempt * check->asked.size].time;
        if (attempt > 0) {
            end_span(check, start, -1);
        }
        hear(check, start);
        if (!check->blind) {
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

void check_sums(struct check *check)
{
    const struct cds_stats *moved = &check->moved;
    expect(check, "ok + timeouts + corrupt", moved->sent,
           (unsigned)moved->ok + moved->timeouts + moved->corrupt);
}

/* Of one exchange; what came that was not due is counted by check_settle(). */
static void check_counters(struct check *check)
{
    const struct cds_stats *moved = &check->moved;
    enum cds_result result = check->outcome.result;
    bool unsent = result == CDS_LINE_BUSY;
    expect(check, "repeated", moved->sent - (unsent ? 0u : 1u), moved->retried);
    expect(check, "unsent", unsent, moved->line_busy);
    expect(check, "ok", result == CDS_OK, moved->ok);
    if ((result == CDS_TIMEOUT && !moved->timeouts) || (result == CDS_CORRUPT && !moved->corrupt)) {
        check_fail(check, "the end was not counted");
    }
    if (moved->retried > check->job.repeats) {
        check_fail(check, "repeated %u times of %u", moved->retried, check->job.repeats);
    }
}

static void between(struct check *check, const char *what, unsigned least, unsigned most,
                    unsigned is)
{
    if (is < least || is > most) {
        check_fail(check, "%s: %u, expected %u to %u", what, is, least, most);
    }
}

/* All that was counted since the injection began. */
static void check_counts(struct check *check)
{
    struct check_sums least, most;
    struct result result;
    const struct cds_stats *all = &check->all;
    expect(check, "framing errors", check->bad, all->framing_errors);
    expect(check, "echo errors", check->echo_errors, all->echo_errors);
    expect(check, "overruns", 0, all->overruns);
    if (!check->babbles) {
        expect(check, "ring overflows", 0, all->ring_overflows);
    }
    if (check->failed) {
        return;
    }
    if (!judge_span(&check->span, UINT64_MAX, &least, &most, &result)) {
        check_fail(check, "what was heard does not fit how it ended");
        return;
    }
    add(&least, &check->least);
    add(&most, &check->most);
    if (all->ring_overflows == 0) {
        between(check, "refuted", least.refuted, most.refuted, all->malformed);
        between(check, "stray", least.stray, most.stray, all->noise_bytes);
        between(check, "late", least.late, most.late, all->stale_replies);
        between(check, "extra", least.extra, most.extra, all->duplicate_replies);
        between(check, "foreign", least.foreign, most.foreign, all->unexpected_packets);
    }
}

/* Did a servo give just this? */
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
    struct check_sums least, most;
    struct result one, *result = &one;
    judge_part(&check->span, check->span.count, &least, &most, result);
    expect(check, "result", result->result, outcome->result);
    if (outcome->result != CDS_OK || result->result != CDS_OK) {
        return;
    }
    expect(check, "id", result->id, outcome->id);
    expect(check, "error", result->error, outcome->error);
    expect(check, "length", result->length, outcome->length);
    if (memcmp(result->data, outcome->data, result->length) != 0) {
        check_fail(check, "other values than came over the wire");
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
        printf("failure\t%s: given up\n", check->row->name);
        exit(1);
    }
}

void check_job(struct check *check, const struct job *job)
{
    struct cds_stats before = check->look.stats;
    check->job = *job;
    if (job->kind < JOB_SCAN) {
        check_asked(job, &check->asked);
        bool known = job->roster != JOB_ALONE;
        if (known && job->kind != JOB_PING && check->level < (job->kind == JOB_READ ? 1 : 2)) {
            check->asked.due = -1;
        }
    }
    perform(check, job, &check->outcome);
    check->look = check->outcome;
    check->moved = check->outcome.stats;
    subtract(&check->moved, &before);
    check->attempts = check->moved.sent;
}

static void check_exchange(struct check *check)
{
    expect(check, "submitted", CDS_OK, check->outcome.submitted);
    check_sent(check);
    check_sums(check);
    expect(check, "bytes stored behind the reply", 0, check->outcome.spilled);
    check->blind |= check->holds && check->rig->overruns;
    if (!check->failed && check->attempts > 0) {
        hear_all(check);
        if (check->outcome.result != CDS_LINE_BUSY) {
            check_time(check);
        }
        if (!check->blind && check->outcome.result != CDS_LINE_BUSY) {
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

/* What the job does to this servo, if it heard it. */
static void carry_out(const struct job *job, uint8_t *registers)
{
    if (job->kind == JOB_WRITE) {
        memcpy(registers + job->address, job->data, job->length);
    } else if (job->kind == JOB_REG_WRITE) {
        registers[TABLE_REGISTERED] = 1;
    }
}

/* What a servo holds that has lost its power since. */
static void power_up(const struct servo *servo, uint8_t *registers)
{
    struct servo again = *servo;
    memcpy(again.registers, registers, sizeof(again.registers));
    servo_power(&again, true);
    memcpy(registers, again.registers, sizeof(again.registers));
}

/* A servo holds something else: that is told apart, and forgiven where it was foreseen. */
static void misunderstood(struct check *check, unsigned index)
{
    const struct tap *received = &check->rig->servos_received;
    struct oracle_byte bytes[RIG_ROOM];
    unsigned count = received->count < RIG_ROOM ? received->count : RIG_ROOM;
    for (unsigned i = 0; i < count; i++) {
        bytes[i] = (struct oracle_byte){received->bytes[i].byte, received->bytes[i].bad};
    }
    check->commanded++;
    if (!oracle_commands(&check->asked, bytes, count)) {
        check_fail(check, "servo %u holds what nobody asked for", index);
    } else if (!check->misunderstood) {
        check_fail(check, "servo %u was told what nobody asked for", index);
    }
}

/* `job` has been done with all servos, or not; and nothing else. */
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
            carry_out(job, asked);
        }
        bool done = memcmp(asked, servo->registers, sizeof(asked)) == 0;
        if (!done && !untouched) {
            misunderstood(check, i);
        } else if (mine && acknowledged && !done && !check->foreseen && !check->powered_up &&
                   !check->misunderstood) {
            check_fail(check, "acknowledged, but servo %u does not hold it", i);
        }
    }
}

/* Power, rates and registers as they were. */
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

/* Bytes of a packet that some servo still waits for: it is deaf to the next ones until then. */
static unsigned awaited(const struct check *check)
{
    unsigned most = 0;
    for (unsigned i = 0; i < check->rig->bench.bus[0].servos.count; i++) {
        const struct servo_node *node = rig_node(check->rig, i);
        const struct codec *codec = &node->servo.codec;
        bool heard = node->baud == SERVO_RESET_BAUD; // another one hears nobody's packets
        unsigned held = heard ? (unsigned)(codec->size - codec->first) : 0;
        unsigned whole = held > 3 ? 4u + codec->bytes[codec->first + 3] : held ? 4 + 254 : 0;
        most = whole > held && whole - held > most ? whole - held : most;
    }
    return most;
}

/* --- what a row calls --- */

void check_open(struct check *check)
{
    unsigned count = check->rig->bench.bus[0].servos.count;
    check->last_id = 0xFF; // nobody
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
    check_exchange(check);
    if (check->outcome.result == CDS_OK && !check->failed) {
        bool given = was_given(check);
        check->undetected += !given;
        if (given == check->foreseen && !(check->mixed && !given)) {
            check_fail(check, given ? "a wrong value was to be taken and was not"
                                    : "a value was taken that no servo gave");
        }
    } else if (check->foreseen) {
        check_fail(check, "a wrong value was to be taken and was not");
    }
}

void check_late_bytes(struct check *check, const struct job *job)
{
    uint8_t reply[SERVO_PACKET_MAX];
    check->slack_us = rig_tied(check->rig) ? TIED_MORE_US * check_reply(check, job, reply) : 0;
}

void check_babble(struct check *check)
{
    check->babbles = true;
    check->slack_us = rig_tied(check->rig) ? BABBLE_TIED_US : BABBLE_US;
}

void check_outcome(struct check *check, unsigned outcomes)
{
    if (!(OUTCOME(check->outcome.result) & outcomes)) {
        check_fail(check, "the outcome was %u", check->outcome.result);
    }
}

void check_refused(struct check *check, const struct job *job, enum cds_result result)
{
    check_job(check, job);
    hear(check, check->rig->ended);
    expect(check, "submitted", result, check->outcome.submitted);
    expect(check, "bytes said", 0, check->rig->sent.count);
    expect(check, "sent", 0, check->moved.sent);
    expect(check, "unsent", 0, check->moved.line_busy);
}

void check_forget(struct check *check)
{
    hear(check, UINT64_MAX);
    rig_forget(check->rig);
    check->judged = 0;
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
    perform(check, &look, &check->look);
    check->all = check->look.stats;
    subtract(&check->all, &check->before);
    expect(check, "state of the bus", CDS_BUS_LINE_QUIET, check->look.state);
    if (!check->blind) {
        check_counts(check);
    }
}

/* Good exchanges until one is answered: the first, unless a servo holds part of a packet. Then
 * those are lost that it takes for the rest of it, and two more at most, as it takes their ends for
 * beginnings. PING and READ in turn: one packet said again and again can keep it out of step for
 * ever. */
static void check_good(struct check *check)
{
    struct job job = {.kind = JOB_READ,
                      .id = check->good_id,
                      .address = TABLE_GOAL_POSITION,
                      .length = 2,
                      .told = check->told,
                      .pause = check->pause};
    unsigned missing = awaited(check), may_fail = missing ? (missing - 1) / PING_SIZE + 3 : 0;
    for (unsigned lost = 0;; lost++) {
        check_job(check, &job);
        check_exchange(check);
        if (check->outcome.result == CDS_OK && !check->outcome.error) {
            break;
        }
        if (lost == may_fail) {
            check_fail(check, "the next exchange failed: result %u, error %02X",
                       check->outcome.result, check->outcome.error);
            return;
        }
        check->lost++;
        check_settle(check);
        check_forget(check);
        job.kind = job.kind == JOB_READ ? JOB_PING : JOB_READ;
    }
    if (!was_given(check)) {
        check_fail(check, "the next exchange took a value that no servo gave");
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
