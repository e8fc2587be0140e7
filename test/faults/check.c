#include "check.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "rows.h"

#define TOLD_MAX        10  // failures of a row that are told in full
#define RETURN_DELAY_US 508 // what the bus allows for, unless it is told better
#define MARGIN_US       100
#define EDGE            (120 * RIG_US) // so near to the deadline a reply may be in time or not
#define PING_SIZE       6
#define ENDLESS         (10 * 1000 * 1000 * RIG_US)

/* --- which, and what of it -----------------------------------------------------------------------
 */

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
    check->failed = check->foreseen = check->holds = false;
    check->baud = -1;
    check->pause = 0;
    check->misunderstood = check->powered_up = false;
    check->rules = check->slack_us = check->bad = check->echo_errors = 0;
    check->good_id = rig_node(check->rig, 0)->id;
    check->before = check->outcome.counters;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(check->text, sizeof(check->text), format, arguments);
    va_end(arguments);
    rig_forget(check->rig);
    check->rig->servos_heard.count = 0;
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

/* --- what a job means ----------------------------------------------------------------------------
 */

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

/* --- one exchange --------------------------------------------------------------------------------
 */

static uint32_t allowed_us(const struct oracle_asked *asked)
{
    uint32_t reply = asked->due < 0 ? 0 : 10 * (6 + (uint32_t)asked->due) + RETURN_DELAY_US;
    return 10 * asked->size + reply + MARGIN_US;
}

static void check_time(struct check *check)
{
    struct rig *rig = check->rig;
    uint64_t took = rig->ended - rig->begun;
    uint64_t deadline = (uint64_t)check->attempts * allowed_us(&check->asked) * RIG_US;
    uint32_t processing_us =
        CHECK_PROCESSING_US +
        CHECK_BYTE_US * (uint32_t)(check->asked.due > 0 ? check->asked.due : 0);
    uint64_t processing = (uint64_t)(processing_us + check->slack_us) * RIG_US * check->attempts;
    if (took > deadline + processing) {
        check_fail(check, "took %.1f us, deadline %.1f", (double)took / RIG_US,
                   (double)deadline / RIG_US);
    }
    if (check->outcome.result != CDS_OK && took < deadline) {
        check_fail(check, "gave up after %.1f us, deadline %.1f", (double)took / RIG_US,
                   (double)deadline / RIG_US);
    }
    if (took > deadline && took - deadline > check->longest) {
        check->longest = took - deadline;
    }
}

static void check_said(struct check *check)
{
    const struct tap *said = &check->rig->said;
    unsigned size = check->asked.size;
    expect(check, "bytes said", check->attempts * size, said->count);
    for (unsigned i = 0; i < said->count && i < RIG_ROOM; i++) {
        if (said->bytes[i].byte != check->asked.packet[i % size]) {
            check_fail(check, "said %02X as byte %u", said->bytes[i].byte, i);
        }
    }
}

/* A byte that came back while the controller drove the wire. */
static bool is_echo(const struct check *check, unsigned attempt, unsigned echoes, uint64_t time)
{
    const struct tap_byte *said = check->rig->said.bytes + attempt * check->asked.size;
    return rig_tied(check->rig) && echoes < check->asked.size && time >= said[0].time &&
           time < said[check->asked.size - 1].time + RIG_BYTE;
}

/* What was heard from `from` until `until`, without the echo, `index` the first byte not yet taken.
 */
static unsigned take_heard(struct check *check, unsigned attempt, unsigned *index, uint64_t until,
                           struct oracle_byte *bytes, uint64_t *times)
{
    const struct tap *heard = &check->rig->heard;
    unsigned count = 0, echoes = 0;
    for (; *index < heard->count && *index < RIG_ROOM; ++*index) {
        const struct tap_byte *byte = &heard->bytes[*index];
        if (byte->time >= until) {
            break;
        }
        if (is_echo(check, attempt, echoes, byte->time)) {
            check->echo_errors += byte->bad || byte->byte != check->asked.packet[echoes];
            echoes++;
            continue;
        }
        check->bad += byte->bad;
        times[count] = byte->time;
        bytes[count++] = (struct oracle_byte){byte->byte, byte->bad};
    }
    return count;
}

struct sums {
    unsigned ok, timeouts, corrupt, refuted, foreign;
    bool several; // damaged bytes in one attempt: what stands between them may go unexamined
};

/* What must have come of one attempt. `good`: the library says it ended well. */
static void judge_attempt(struct check *check, struct oracle_byte *bytes, const uint64_t *times,
                          unsigned count, uint64_t until, bool good, struct verdict *verdict,
                          struct sums *sums)
{
    unsigned bad = 0;
    oracle_judge(&check->asked, bytes, count, verdict);
    if (!good && verdict->result == CDS_OK) { // too late, perhaps?
        while (count > 0 && times[count - 1] + EDGE > until) {
            count--;
        }
        oracle_judge(&check->asked, bytes, count, verdict);
    }
    for (unsigned i = 0; i < count; i++) {
        bad += bytes[i].bad;
    }
    sums->ok += verdict->result == CDS_OK;
    sums->timeouts += verdict->result == CDS_TIMEOUT;
    sums->corrupt += verdict->result == CDS_CORRUPT;
    sums->refuted += verdict->refuted;
    sums->foreign += verdict->foreign;
    sums->several |= bad > 1;
}

static void judge(struct check *check, struct verdict *verdict, struct sums *sums)
{
    static struct oracle_byte bytes[RIG_ROOM];
    static uint64_t times[RIG_ROOM];
    const struct rig *rig = check->rig;
    unsigned index = 0;
    take_heard(check, 0, &index, rig->said.bytes[0].time, bytes, times); // nothing was asked yet
    for (unsigned attempt = 0; attempt < check->attempts; attempt++) {
        bool last = attempt + 1 == check->attempts;
        unsigned next = (attempt + 1) * check->asked.size;
        uint64_t until = last ? rig->ended : rig->said.bytes[next].time;
        unsigned count = take_heard(check, attempt, &index, until, bytes, times);
        judge_attempt(check, bytes, times, count, until, last && check->outcome.result == CDS_OK,
                      verdict, sums);
    }
    check->judged = index;
}

static void subtract(struct cds_counters *a, const struct cds_counters *b)
{
    uint16_t *words = (uint16_t *)(void *)a;
    const uint16_t *less = (const uint16_t *)(const void *)b;
    for (unsigned i = 0; i < sizeof(*a) / sizeof(*words); i++) {
        words[i] = (uint16_t)(words[i] - less[i]);
    }
}

void check_sums(struct check *check)
{
    const struct cds_counters *moved = &check->moved;
    expect(check, "ok + timeouts + corrupt", moved->sent,
           (unsigned)moved->ok + moved->timeouts + moved->corrupt);
}

static void check_counters(struct check *check, const struct sums *sums)
{
    const struct cds_counters *moved = &check->moved;
    expect(check, "sent", 1u + moved->repeated, moved->sent);
    expect(check, "ok", sums->ok, moved->ok);
    expect(check, "timeouts", sums->timeouts, moved->timeouts);
    expect(check, "corrupt", sums->corrupt, moved->corrupt);
    if (moved->repeated > check->job.repeats) {
        check_fail(check, "repeated %u times of %u", moved->repeated, check->job.repeats);
    }
    if (!sums->several || moved->refuted > sums->refuted) {
        expect(check, "refuted", sums->refuted, moved->refuted);
    }
    if (!sums->several || moved->foreign > sums->foreign) {
        expect(check, "foreign", sums->foreign, moved->foreign);
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

static void check_value(struct check *check, const struct verdict *verdict)
{
    const struct job_outcome *outcome = &check->outcome;
    expect(check, "result", verdict->result, outcome->result);
    if (outcome->result != CDS_OK || verdict->result != CDS_OK) {
        return;
    }
    expect(check, "id", verdict->id, outcome->id);
    expect(check, "error", verdict->error, outcome->error);
    expect(check, "length", verdict->length, outcome->length);
    if (memcmp(verdict->data, outcome->data, verdict->length) != 0) {
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

void check_job(struct check *check, const struct job *job)
{
    struct rig *rig = check->rig;
    struct cds_counters before = check->outcome.counters;
    check->job = *job;
    if (job->kind < JOB_SCAN) {
        check_asked(job, &check->asked);
    }
    rig_begin(rig, job);
    if (!rig_wait(rig, ENDLESS, &check->outcome)) {
        check_fail(check, "the call did not end");
        printf("failure\t%s: given up\n", check->row->name);
        exit(1);
    }
    check->moved = check->outcome.counters;
    subtract(&check->moved, &before);
    check->attempts = 1u + check->moved.repeated;
}

static void check_exchange(struct check *check)
{
    struct verdict verdict;
    struct sums sums = {0};
    expect(check, "submitted", CDS_OK, check->outcome.submitted);
    check->judged = 0;
    check_said(check);
    check_time(check);
    check_sums(check);
    if (!check->failed) {
        judge(check, &verdict, &sums);
        if (!check->holds) {
            check_value(check, &verdict);
            check_counters(check, &sums);
        }
    }
    if (!rig_listens(check->rig)) {
        check_fail(check, "the driver was not released");
    }
}

/* --- the servos ----------------------------------------------------------------------------------
 */

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
    const struct tap *heard = &check->rig->servos_heard;
    struct oracle_byte bytes[RIG_ROOM];
    unsigned count = heard->count < RIG_ROOM ? heard->count : RIG_ROOM;
    for (unsigned i = 0; i < count; i++) {
        bytes[i] = (struct oracle_byte){heard->bytes[i].byte, heard->bytes[i].bad};
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
        node->late_us = 0;
        if (baud != node->servo.registers[TABLE_BAUD]) {
            servo_node_baud(node, node->servo.registers[TABLE_BAUD]);
            node->misled = false;
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

/* --- what a row calls ----------------------------------------------------------------------------
 */

void check_open(struct check *check)
{
    unsigned count = check->rig->bench.bus[0].servos.count;
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
        if (given == check->foreseen) {
            check_fail(check, given ? "a wrong value was to be taken and was not"
                                    : "a value was taken that no servo gave");
        }
    } else if (check->foreseen) {
        check_fail(check, "a wrong value was to be taken and was not");
    }
}

void check_outcome(struct check *check, unsigned outcomes)
{
    if (!(OUTCOME(check->outcome.result) & outcomes)) {
        check_fail(check, "the outcome was %u", check->outcome.result);
    }
}

/* What came when nobody asked any more. */
static void count_the_rest(struct check *check)
{
    const struct tap *heard = &check->rig->heard;
    for (unsigned i = check->judged; i < heard->count && i < RIG_ROOM; i++) {
        check->bad += heard->bytes[i].bad;
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
        rig_settle(check->rig);
        count_the_rest(check);
        rig_forget(check->rig);
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
    if (!check->pause && !rig_settle(rig)) {
        check_fail(check, "the line does not become quiet");
    }
    check_rules(check);
    struct job job = check->job;
    bool acknowledged = check->outcome.result == CDS_OK && !check->outcome.error;
    count_the_rest(check);
    rig_forget(rig);
    check_good(check);
    check_rules(check);
    count_the_rest(check);
    check_servos(check, &job, acknowledged);
    struct cds_counters all = check->outcome.counters;
    subtract(&all, &check->before);
    if (!check->holds) {
        expect(check, "framing errors", check->bad, all.framing_errors);
        expect(check, "echo errors", check->echo_errors, all.echo_errors);
        expect(check, "overruns", 0, all.overruns);
        expect(check, "ring overflows", 0, all.ring_overflows);
    }
    rig_settle(rig);
    restore(check);
}

void check_all(struct check *check, const struct job *job, unsigned outcomes)
{
    check_run(check, job);
    check_outcome(check, outcomes);
    check_after(check);
}
