/* SPDX-License-Identifier: MIT */
/* Faults of single bits, bytes and replies: F1 to F5, F7, F15, F16. */
#include "rows.h"

#include <string.h>

#define BITS 10 // of a byte on the wire

const struct job rows_jobs[ROWS_JOBS] = {
    {.kind = JOB_PING, .id = 1},
    {.kind = JOB_READ, .id = 1, .address = TABLE_GOAL_POSITION, .length = 2},
    {.kind = JOB_READ, .id = 1, .address = TABLE_PRESENT_POSITION, .length = 8},
    {.kind = JOB_READ, .id = 1, .address = TABLE_PRESENT_POSITION, .length = 11},
    {.kind = JOB_READ, .id = 1, .length = TABLE_REGISTERS},
    {.kind = JOB_WRITE, .id = 1, .address = TABLE_GOAL_POSITION, .length = 2, .data = {0x5A, 2}},
    {.kind = JOB_REG_WRITE, .id = 1, .address = TABLE_GOAL_POSITION, .length = 2, .data = {9, 3}},
    {.kind = JOB_WRITE, .id = 1, .address = TABLE_CW_MARGIN, .length = 1, .data = {7}},
};

unsigned rows_reply_size(const struct job *job)
{
    return 6u + (job->kind == JOB_READ ? job->length : 0u);
}

unsigned rows_packet_size(const struct job *job)
{
    struct oracle_asked asked;
    check_asked(job, &asked);
    return asked.size;
}

/* --- predictions --- */

/* Predicts the outcome of a reply from the levels of the line. GOOD: the library takes it, with a
 * right or a wrong value. */
static unsigned predict(struct check *check, const struct job *job, const bool *level,
                        unsigned bits)
{
    uint8_t truth[SERVO_PACKET_MAX];
    struct oracle_byte received[SERVO_PACKET_MAX];
    struct oracle_asked asked;
    struct oracle_result result;
    unsigned size = check_reply(check, job, truth);
    check_asked(job, &asked);
    oracle_reply(&asked, received, oracle_receive(level, bits, received), &result);
    bool same = result.error == truth[4] && result.length == size - 6 &&
                memcmp(result.data, truth + 5, result.length) == 0;
    check->predicts_wrong_value = result.result == CDS_OK && !same;
    return OUTCOME(result.result);
}

/* Predicts the outcome of a reply in which two bits are inverted; bits count from the first start
 * bit. */
static unsigned predict_flips(struct check *check, const struct job *job, unsigned a, unsigned b)
{
    bool level[SERVO_PACKET_MAX * BITS];
    uint8_t reply[SERVO_PACKET_MAX];
    unsigned size = check_reply(check, job, reply);
    oracle_send(reply, size, level);
    level[a] ^= true;
    level[b] ^= true;
    return predict(check, job, level, size * BITS);
}

/* Predicts whether a servo carries out another command if these bits of the packet are inverted. If
 * LENGTH is too high, the packet goes on into the next one: if it is one too high, the FF that
 * begins the next packet makes the checksum right. */
static void predict_command(struct check *check, const struct job *job, unsigned a, unsigned b)
{
    static const uint8_t next[] = {0xFF, 0xFF, 1, 4, 2, TABLE_GOAL_POSITION, 2, 0xD8};
    bool level[SERVO_PACKET_MAX * BITS];
    struct oracle_byte received[SERVO_PACKET_MAX];
    struct oracle_asked asked;
    check_asked(job, &asked);
    oracle_send(asked.packet, asked.size, level);
    level[a] ^= true;
    level[b] ^= a != b;
    unsigned count = oracle_receive(level, asked.size * BITS, received);
    for (unsigned i = 0; i < sizeof(next); i++) {
        received[count++] = (struct oracle_byte){next[i], false};
    }
    check->allows_wrong_command = oracle_commands(&asked, received, count);
}

/* Returns true if the checksum does not show that two data bits are inverted: they have the same
 * weight in two bytes, and opposite values or weight 128. A bit of a known value is always noticed:
 * header, ID, LENGTH, the highest error bit. */
static bool is_undetectable(const uint8_t *reply, unsigned a, unsigned b)
{
    unsigned byte_a = a / BITS, byte_b = b / BITS, bit = a % BITS;
    bool unlike = (reply[byte_a] ^ reply[byte_b]) >> (bit - 1) & 1;
    bool known = byte_a < 4 || (byte_a == 4 && bit == 8);
    return bit == b % BITS && byte_a != byte_b && !known && (unlike || bit == 8);
}

/* --- F1, F2 --- */

static void flip(struct check *check, bool out, unsigned bit)
{
    rig_order(check->rig, "flip %s 1 %u %u", out ? "out" : "in", bit / BITS, bit % BITS);
}

static void flip_replies(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        const struct job *job = &rows_jobs[i];
        for (unsigned bit = 0; bit < rows_reply_size(job) * BITS; bit++) {
            if (check_next(check, "%s, bit %u of byte %u", check_name(job), bit % BITS,
                           bit / BITS)) {
                flip(check, true, bit);
                check_all(check, job, FAILED);
            }
        }
    }
}

/* Checks a job whose packet was damaged: no reply, or a reply that reports the damage in ERROR. */
static void check_damaged_packet(struct check *check, const struct job *job)
{
    check_run(check, job);
    check_outcome(check, FAILED | GOOD);
    if (check->outcome.result == CDS_OK && !(check->outcome.error & 0x5A)) {
        check_fail(check, "a damaged packet was answered without an error");
    }
    check_after(check);
}

static void flip_packets(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        const struct job *job = &rows_jobs[i];
        for (unsigned bit = 0; bit < rows_packet_size(job) * BITS; bit++) {
            if (check_next(check, "%s, bit %u of byte %u", check_name(job), bit % BITS,
                           bit / BITS)) {
                flip(check, false, bit);
                predict_command(check, &rows_jobs[i], bit, bit);
                check_damaged_packet(check, job);
            }
        }
    }
}

/* One to three damaged replies, while two retries are allowed. REG WRITE is never retried. */
static void flip_with_retries(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS * 3; i++) {
        struct job job = rows_jobs[i % ROWS_JOBS];
        unsigned damaged = i / ROWS_JOBS + 1;
        job.retries = 2;
        bool is_retried = job.kind != JOB_REG_WRITE;
        for (unsigned bit = 0; bit < rows_reply_size(&job) * BITS; bit += BITS + 1) {
            if (check_next(check, "%s, %u replies, bit %u of byte %u", check_name(&job), damaged,
                           bit % BITS, bit / BITS)) {
                for (unsigned packet = 1; packet <= damaged; packet++) {
                    rig_order(check->rig, "flip out %u %u %u", packet, bit / BITS, bit % BITS);
                }
                check_run(check, &job);
                check_outcome(check, is_retried && damaged < 3 ? GOOD : FAILED);
                if (check->attempts != (!is_retried ? 1 : damaged < 3 ? damaged + 1 : 3)) {
                    check_fail(check, "%u attempts", check->attempts);
                }
                check_after(check);
            }
        }
    }
}

static void flip_pairs_of_replies(struct check *check)
{
    for (unsigned i = 0; i < 2; i++) {
        const struct job *job = &rows_jobs[i];
        uint8_t reply[SERVO_PACKET_MAX];
        unsigned bits = check_reply(check, job, reply) * BITS;
        for (unsigned a = 0; a < bits; a++) {
            for (unsigned b = a + 1; b < bits; b++) {
                if (!check_next(check, "%s, bits %u and %u", check_name(job), a, b)) {
                    continue;
                }
                flip(check, true, a);
                flip(check, true, b);
                unsigned outcome = predict_flips(check, job, a, b);
                bool data = a % BITS % 9 && b % BITS % 9;
                if (data && check->predicts_wrong_value != is_undetectable(reply, a, b)) {
                    check_fail(check, "the two predictions differ");
                }
                check_all(check, job, outcome);
            }
        }
    }
}

static void flip_pairs_of_packets(struct check *check)
{
    static const unsigned which[] = {0, 1, 5};
    for (unsigned i = 0; i < 3; i++) {
        const struct job *job = &rows_jobs[which[i]];
        unsigned bits = rows_packet_size(job) * BITS;
        for (unsigned a = 0; a < bits; a++) {
            for (unsigned b = a + 1; b < bits; b++) {
                if (check_next(check, "%s, bits %u and %u", check_name(job), a, b)) {
                    flip(check, false, a);
                    flip(check, false, b);
                    predict_command(check, job, a, b);
                    check_run(check, job);
                    check_outcome(check, FAILED | GOOD);
                    check_after(check);
                }
            }
        }
    }
}

/* --- F3, F4, F7 --- */

static void lose_of_replies(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned byte = 0; byte < rows_reply_size(&rows_jobs[i]); byte++) {
            if (check_next(check, "%s, byte %u", check_name(&rows_jobs[i]), byte)) {
                rig_order(check->rig, "lose out 1 %u", byte);
                check_all(check, &rows_jobs[i], FAILED);
            }
        }
    }
}

static void lose_of_packets(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned byte = 0; byte < rows_packet_size(&rows_jobs[i]); byte++) {
            if (check_next(check, "%s, byte %u", check_name(&rows_jobs[i]), byte)) {
                rig_order(check->rig, "lose in 1 %u", byte);
                check_damaged_packet(check, &rows_jobs[i]);
            }
        }
    }
}

/* Inserts a byte before byte `at`; 0: before the header. A byte after the last one does no harm. */
static void insert_at(struct check *check, const struct job *job, unsigned at, unsigned value)
{
    if (!check_next(check, "%s, %02X before byte %u", check_name(job), value, at)) {
        return;
    }
    bool level[SERVO_PACKET_MAX * BITS];
    uint8_t reply[SERVO_PACKET_MAX + 1];
    unsigned size = check_reply(check, job, reply);
    memmove(reply + at + 1, reply + at, size - at);
    reply[at] = (uint8_t)value;
    oracle_send(reply, size + 1, level);
    unsigned outcome = predict(check, job, level, (size + 1) * BITS);
    bool harmless = at == 0 || at == size || (value == 0xFF && at <= 2);
    if (harmless && (outcome != GOOD || check->predicts_wrong_value)) {
        check_fail(check, "the inserted byte should do no harm");
    }
    rig_order(check->rig, "insert out 1 %u %u", at, value);
    check_all(check, job, outcome);
}

static void insert_before(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned value = 0; value < 256; value++) {
            insert_at(check, &rows_jobs[i], 0, value);
        }
    }
}

static void insert_inside(struct check *check)
{
    for (unsigned i = 0; i < 2; i++) {
        for (unsigned at = 1; at <= rows_reply_size(&rows_jobs[i]); at++) {
            for (unsigned value = 0; value < 256; value++) {
                insert_at(check, &rows_jobs[i], at, value);
            }
        }
    }
}

static void insert_headers(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned count = 1; count <= 40; count++) {
            if (check_next(check, "%s, %u times FF", check_name(&rows_jobs[i]), count)) {
                for (unsigned n = 0; n < count; n++) {
                    rig_order(check->rig, "insert out 1 0 255");
                }
                check_all(check, &rows_jobs[i], GOOD);
            }
        }
    }
}

static void cut(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        unsigned size = rows_reply_size(&rows_jobs[i]);
        for (unsigned bytes = 0; bytes <= size; bytes++) {
            if (check_next(check, "%s, after %u bytes", check_name(&rows_jobs[i]), bytes)) {
                check->powered_up = true;
                rig_order(check->rig, "cut out 1 %u", bytes);
                check_all(check, &rows_jobs[i], bytes < size ? OUTCOME(CDS_TIMEOUT) : GOOD);
            }
        }
    }
}

/* --- F5 --- */

/* The receive buffer is always on. The receiver is off except during the last byte, whose handler
 * delays the release up to 8 us after the last stop bit. The reply of a servo that answers sooner
 * meets the driver; it may be lost, but no wrong value may be taken. */
static void echo_of_buffer(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned delay_us = 2; delay_us <= 508; delay_us += 2) {
            if (check_next(check, "%s, return delay %u us", check_name(&rows_jobs[i]), delay_us)) {
                bool prompt = delay_us < 8;
                rig_node(check->rig, 0)->servo.registers[TABLE_RETURN_DELAY] =
                    check->servos[0].registers[TABLE_RETURN_DELAY] = (uint8_t)(delay_us / 2);
                rig_order(check->rig, "echo on");
                check->rules = prompt ? RULE(RULE_TWO_DRIVERS) | RULE(RULE_REPLY_LOST) : 0;
                check_run(check, &rows_jobs[i]);
                check_outcome(check, prompt ? GOOD | FAILED : GOOD);
                if (prompt) { // the next reply would meet the driver too
                    rig_order(check->rig, "echo off");
                }
                check_after(check);
                rig_order(check->rig, "echo off");
            }
        }
    }
    check->servos[0].registers[TABLE_RETURN_DELAY] = 1;
}

/* The echo of a byte is changed, as if another sender had talked. If the last byte loses its start
 * bit, it ends too late to count as an echo. */
static void echo_changed(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned bit = 0; bit < rows_packet_size(&rows_jobs[i]) * BITS; bit++) {
            if (check_next(check, "%s, bit %u of byte %u", check_name(&rows_jobs[i]), bit % BITS,
                           bit / BITS)) {
                flip(check, false, bit);
                predict_command(check, &rows_jobs[i], bit, bit);
                check_run(check, &rows_jobs[i]);
                check_outcome(check, FAILED | GOOD);
                bool is_echo = bit != (rows_packet_size(&rows_jobs[i]) - 1) * BITS;
                if (is_echo && check->last_stats.echo_errors == 0 && !check->failed) {
                    check_fail(check, "the difference was not counted");
                }
                check_after(check);
            }
        }
    }
}

/* --- F15, F16 --- */

/* Checks that a good reply after the deadline counts as a stale reply, and as nothing else. */
static void check_stale_reply(struct check *check)
{
    check_settle(check);
    const struct cds_stats *stats = &check->injection_stats;
    if (stats->stale_replies != (check->outcome.result == CDS_TIMEOUT) ||
        stats->duplicate_replies || stats->unexpected_packets) {
        check_fail(check, "stale_replies %u, duplicate_replies %u, unexpected_packets %u",
                   stats->stale_replies, stats->duplicate_replies, stats->unexpected_packets);
    }
}

unsigned rows_outcome_of_late_reply(const struct check *check, const struct job *job, unsigned us,
                                    unsigned allowed_us)
{
    unsigned bytes = rows_reply_size(job) < 20 ? rows_reply_size(job) : 20;
    unsigned poll_us = 30 + bytes * (rig_tied(check->rig) ? CHECK_BYTE_TIED_US : CHECK_BYTE_US);
    if (us + 40 <= allowed_us) {
        return GOOD;
    }
    return us > allowed_us + poll_us ? OUTCOME(CDS_TIMEOUT) : GOOD | OUTCOME(CDS_TIMEOUT);
}

/* Replies around the deadline. The oracle decides for each reply whether it was in time. */
static void late_reply(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned us = 0; us <= 3000; us += us < 800 ? 5 : 50) {
            if (check_next(check, "%s, %u us", check_name(&rows_jobs[i]), us)) {
                check_allow_late_bytes(check, &rows_jobs[i]);
                rig_order(check->rig, "delay out 1 %u", us);
                check_run(check, &rows_jobs[i]);
                check_outcome(
                    check, rows_outcome_of_late_reply(check, &rows_jobs[i], us, ROWS_ALLOWED_us));
                check_stale_reply(check);
                check_after(check);
            }
        }
    }
}

/* The reply comes while the program does not poll for 5 ms. Then the next packet is sent, whose
 * reply has the same ID and length. */
static void late_reply_unread(struct check *check)
{
    static const struct job job = {
        .kind = JOB_READ, .id = 1, .address = TABLE_MOVING_SPEED, .length = 2};
    for (unsigned us = 750; us <= 4500; us += 10) {
        if (check_next(check, "%s, %u us", check_name(&job), us)) {
            check->pause = 50;
            rig_order(check->rig, "delay out 1 %u", us);
            check_all(check, &job, OUTCOME(CDS_TIMEOUT));
            if (check->injection_stats.stale_replies != 1) {
                check_fail(check, "stale_replies %u", check->injection_stats.stale_replies);
            }
        }
    }
}

/* The bus is set to a return delay of 2 us, as cds_setup leaves servos, and one reply comes up to
 * 508 us later, the longest return delay of a servo. A READ with a reply of the same length follows
 * at once, of servo `id`. The bus must wait until the stale reply is over. `absent`: a PING of an
 * absent servo comes between the two READs. */
static void next(struct check *check, uint8_t id, bool absent)
{
    static const struct job first = {
        .kind = JOB_READ, .id = 1, .address = TABLE_MOVING_SPEED, .length = 2, .return_delay = 1};
    struct job second = first, between = {.kind = JOB_PING, .id = 99, .return_delay = 1};
    second.id = id;
    second.address = TABLE_GOAL_POSITION;
    for (unsigned us = 0; us <= 506; us++) {
        if (!check_next(check, "%u us", us)) {
            continue;
        }
        check->return_delay = 1;
        rig_order(check->rig, "delay out 1 %u", us);
        check_run(check, &first);
        check_outcome(check, rows_outcome_of_late_reply(check, &first, us, 100));
        bool late = check->outcome.result == CDS_TIMEOUT;
        check_forget(check);
        if (absent) {
            check_run(check, &between);
            check_outcome(check, OUTCOME(CDS_TIMEOUT));
            check_forget(check);
        }
        check_run(check, &second);
        check_outcome(check, GOOD);
        check_settle(check);
        if (check->injection_stats.stale_replies + check->injection_stats.unexpected_packets !=
            late) {
            check_fail(check, "stale_replies %u, unexpected_packets %u",
                       check->injection_stats.stale_replies,
                       check->injection_stats.unexpected_packets);
        }
        check_after(check);
    }
}

static void next_same(struct check *check)
{
    next(check, 1, false);
}

static void next_other(struct check *check)
{
    next(check, 2, false);
}

static void next_but_one(struct check *check)
{
    next(check, 1, true);
}

static void other_id(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned id = 0; id < 256; id++) {
            if (check_next(check, "%s, ID %u", check_name(&rows_jobs[i]), id)) {
                rig_order(check->rig, "id out 1 %u", id);
                check_run(check, &rows_jobs[i]);
                check_outcome(check, id == 1 ? GOOD : id == 0xFF ? FAILED : OUTCOME(CDS_TIMEOUT));
                // servo 2 takes a reply with its ID for a packet and answers it
                if (id != 1 && id != 0xFF &&
                    check->last_stats.unexpected_packets != (id == 2 ? 2 : 1)) {
                    check_fail(check, "unexpected_packets %u",
                               check->last_stats.unexpected_packets);
                }
                check_after(check);
            }
        }
    }
}

static void wrong_length(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        unsigned right = rows_reply_size(&rows_jobs[i]) - 4;
        for (unsigned length = 0; length < 256; length++) {
            if (check_next(check, "%s, LENGTH %u", check_name(&rows_jobs[i]), length)) {
                rig_order(check->rig, "length out 1 %u", length);
                check_run(check, &rows_jobs[i]);
                check_outcome(check, length == right ? GOOD : FAILED);
                if ((length < 2 || length > right) && check->last_stats.malformed == 0) {
                    check_fail(check, "the reply was not counted as malformed");
                }
                check_after(check);
            }
        }
    }
}

#define BUFFERED "atmega128 arduino-uno"
#define TIED     "arbotix"

const struct row rows_wire[] = {
    {"F1-reply", "one bit of a reply flipped, every position", "1,2", flip_replies, 0},
    {"F1-packet", "one bit of an instruction packet flipped, every position", "1,2", flip_packets,
     0},
    {"F1-retry", "one to three replies damaged, two retries allowed", "1,2", flip_with_retries, 0},
    {"F2-reply", "two bits of a reply of 6 or 8 bytes flipped, all pairs", "1,2",
     flip_pairs_of_replies, 0},
    {"F2-packet", "two bits of an instruction packet flipped, all pairs", "1,2",
     flip_pairs_of_packets, 0},
    {"F3-reply", "byte of a reply lost, every position", "1,2", lose_of_replies, 0},
    {"F3-packet", "byte of an instruction packet lost, every position", "1,2", lose_of_packets, 0},
    {"F4-before", "any byte before a reply", "1,2", insert_before, 0},
    {"F4-inside", "any byte inside or after a reply of 6 or 8 bytes, every position", "1,2",
     insert_inside, 0},
    {"F4-headers", "1 to 40 times FF before a reply", "1,2", insert_headers, 0},
    {"F5-buffers", "receive buffer always on, return delay 2 to 508 us", "1,2", echo_of_buffer,
     BUFFERED},
    {"F5-tied", "tied pins, one bit of the echo flipped, every position", "1,2", echo_changed,
     TIED},
    {"F7", "servo resets after each byte of its reply", "1,2", cut, 0},
    {"F15-late", "reply 0 to 3000 us late", "1,2", late_reply, 0},
    {"F15-stale", "late reply, not read before the next packet is sent", "1,2", late_reply_unread,
     0},
    {"F15-next", "bus set to 2 us, reply up to 508 us late, the same servo is asked again at once",
     "1,2", next_same, 0},
    {"F15-other", "bus set to 2 us, reply up to 508 us late, another servo is asked at once", "1,2",
     next_other, 0},
    {"F15-between",
     "bus set to 2 us, reply up to 508 us late, an absent servo is asked, then the same servo "
     "again",
     "1,2", next_but_one, 0},
    {"F15-id", "reply from every other ID", "1,2", other_id, 0},
    {"F16", "LENGTH 0 to 255", "1,2", wrong_length, 0},
    {0},
};
