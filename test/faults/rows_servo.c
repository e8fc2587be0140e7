/* SPDX-License-Identifier: MIT */
/* Two servos with one ID (F6); servos that lose power (F8), are absent (F11), use another baud rate
 * (F12), answer late (F17) or not at all (F18); error bits (F19). */
#include "rows.h"

#include <string.h>

#define BITS           10 // of a byte on the wire
#define SCAN_us        300000u
#define TWINS_us       500u
#define SERVO_DELAY_us 2u // factory return delay

static struct job with_id(const struct job *job, uint8_t id)
{
    struct job other = *job;
    other.id = id;
    return other;
}

/* Sets a register of servo 0. check_after() does not reset it. */
static void set_register(struct check *check, uint8_t address, uint8_t value)
{
    check->servos[0].registers[address] = value;
    rig_node(check->rig, 0)->servo.registers[address] = value;
}

/* --- F6: two servos with one ID --- */

/* Predicts the outcome if the second reply begins `us` bit times after the first one: the receiver
 * gets the AND of both. The first reply stays whole if the header of the second one meets its end
 * bit for bit. */
static unsigned predict_both(struct check *check, const struct job *job, unsigned us)
{
    static bool level[SERVO_PACKET_MAX * BITS * 2 + TWINS_us], second[SERVO_PACKET_MAX * BITS];
    static struct oracle_byte received[SERVO_PACKET_MAX * 2 + TWINS_us / BITS];
    struct oracle_asked asked;
    struct oracle_result result;
    uint8_t reply[2][SERVO_PACKET_MAX];
    unsigned bits = 0;
    for (unsigned i = 0; i < 2; i++) {
        const uint8_t *data = check->servos[i].registers + job->address;
        bits = BITS *
               oracle_packet(reply[i], job->id, 0, data, job->kind == JOB_READ ? job->length : 0);
    }
    memset(level, 1, sizeof(level));
    oracle_send(reply[0], bits / BITS, level);
    oracle_send(reply[1], bits / BITS, second);
    for (unsigned i = 0; i < bits; i++) {
        level[i + us] = level[i + us] && second[i];
    }
    check_asked(job, &asked);
    oracle_reply(&asked, received, oracle_receive(level, bits + us, received), &result);
    bool given = false;
    for (unsigned i = 0; i < 2; i++) {
        given |= result.error == 0 && result.length == bits / BITS - 6 &&
                 memcmp(result.data, reply[i] + 5, result.length) == 0;
    }
    check->predicts_wrong_value = result.result == CDS_OK && !given;
    return OUTCOME(result.result);
}

/* Checks that some counter shows the second reply if the first one was taken. Replies that are
 * equal within half a bit cannot be told apart. */
static void check_second_reply_counted(struct check *check, unsigned us)
{
    const struct cds_stats *stats = &check->injection_stats;
    if (us > 0 && check->outcome.result == CDS_OK && !stats->duplicate_replies &&
        !stats->malformed && !stats->noise_bytes && !stats->framing_errors) {
        check_fail(check, "no counter shows the second reply");
    }
}

/* Each servo takes the reply of the other one for a packet and answers it, and so on. The line
 * stays in use until `stuck high 1` breaks the chain. */
static void check_endless_replies(struct check *check, unsigned us)
{
    static const struct job other = {.kind = JOB_PING, .id = 2};
    struct job job = check->job;
    check_allow_babble(check);
    check_forget(check);
    rig_pass(check->rig, us * RIG_US);
    check_run(check, &other);
    check_outcome(check, OUTCOME(CDS_LINE_BUSY));
    if (check->outcome.state != CDS_BUS_LINE_SUSPECT) {
        check_fail(check, "line state %u", check->outcome.state);
    }
    rig_order(check->rig, "stuck high 1");
    rig_pass(check->rig, 2000 * RIG_US);
    check_settle(check);
    if (check->injection_stats.duplicate_replies == 0) {
        check_fail(check, "the second reply was not counted");
    }
    check->job = job;
    check->outcome.result = CDS_OK;
}

/* Checks what becomes of the second reply. Both replies together can overflow the ring. */
static void second_reply(struct check *check, unsigned us, unsigned bits)
{
    check->allows_ring_overflow = us + bits > 64 * BITS;
    if (us >= bits) {
        check_endless_replies(check, us + 2 * bits);
        return;
    }
    check_settle(check);
    check_second_reply_counted(check, us);
}

static void twins(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        struct job job = with_id(&rows_jobs[i], 7);
        for (unsigned us = 0; us <= TWINS_us; us++) {
            if (check_next(check, "%s, %u us apart", check_name(&job), us)) {
                check->next_id = 2;
                unsigned outcome = predict_both(check, &job, us);
                check_allow_late_bytes(check, &job);
                rig_order(check->rig, "delay out 2 %u", us);
                check_run(check, &job);
                check_outcome(check, outcome);
                second_reply(check, us, rows_reply_size(&job) * BITS);
                check_after(check);
            }
        }
    }
}

/* --- F8: brown-out --- */

/* Returns 0 to 2. A row that takes long divides its injections among the boards. */
static unsigned board_number(const struct check *check)
{
    const char *board = check->rig->options.board;
    return strcmp(board, "atmega128") == 0 ? 0 : strcmp(board, "arduino-uno") == 0 ? 1 : 2;
}

static void check_known(struct check *check, const char *what, unsigned expected, unsigned is)
{
    if (expected != is) {
        check_fail(check, "servos.h has %s %u, expected %u", what, is, expected);
    }
}

/* Sends PINGs to the servo without power, five at most, up to `until`. Each must time out. From the
 * third one on the servo is OFFLINE and its goal is refused. Returns the number of PINGs. */
static unsigned ping_without_power(struct check *check, const struct job *goal, uint64_t until)
{
    static const struct job ping = {.kind = JOB_PING, .id = 1, .servos = JOB_WITH_SERVOS};
    unsigned count = 0;
    while (count < 5 && rig_now(check->rig) + 900 * RIG_US < until) {
        check_forget(check);
        check_run(check, &ping);
        check_outcome(check, OUTCOME(CDS_TIMEOUT));
        count++;
        check_known(check, "presence", count < 3 ? CDS_PRESENCE_ONLINE : CDS_PRESENCE_OFFLINE,
                    check->outcome.known.presence);
        if (count == 3) {
            check_forget(check);
            check_refused(check, goal, CDS_INHIBITED);
        }
    }
    if (rig_now(check->rig) < until) {
        rig_pass(check->rig, until - rig_now(check->rig));
    }
    return count;
}

/* A servo with torque on loses its power. If the library noticed, it must refuse goals until torque
 * was read. Torque read as off means that the servo has lost its state: goals and torque on are
 * refused. Nothing may switch torque on again. */
static void lose_state(struct check *check, unsigned ms)
{
    struct job on = {.kind = JOB_WRITE,
                     .id = 1,
                     .address = TABLE_TORQUE_ENABLE,
                     .length = 1,
                     .data = {1},
                     .servos = JOB_NEW_SERVOS};
    struct job goal = rows_jobs[5], ask = {.kind = JOB_PING, .id = 1, .servos = JOB_WITH_SERVOS};
    check_run(check, &on);
    check_outcome(check, GOOD);
    on.servos = goal.servos = JOB_WITH_SERVOS;
    rig_order(check->rig, "brownout 1 %u", ms);
    check->powered_up = true;
    bool away = ping_without_power(check, &goal, rig_now(check->rig) + ms * 1000 * RIG_US) >= 3;
    check_forget(check);
    check_run(check, &ask);
    check_outcome(check, GOOD);
    check_known(check, "presence", away ? CDS_PRESENCE_RETURNED : CDS_PRESENCE_ONLINE,
                check->outcome.known.presence);
    check_forget(check);
    if (away) {
        check_refused(check, &goal, CDS_INHIBITED);
        check_refused(check, &on, CDS_INHIBITED);
    }
    ask = (struct job){.kind = JOB_READ,
                       .id = 1,
                       .address = TABLE_TORQUE_ENABLE,
                       .length = 1,
                       .servos = JOB_WITH_SERVOS};
    check_run(check, &ask);
    check_outcome(check, GOOD);
    check_known(check, "inhibited", CDS_INHIBIT_STATE_LOST, check->outcome.known.inhibited);
    check_known(check, "presence", CDS_PRESENCE_ONLINE, check->outcome.known.presence);
    check_forget(check);
    check_refused(check, &goal, CDS_INHIBITED);
    check_refused(check, &on, CDS_INHIBITED);
    if (rig_node(check->rig, 0)->servo.registers[TABLE_TORQUE_ENABLE]) {
        check_fail(check, "the torque of the servo is on");
    }
}

static void drop(struct check *check)
{
    set_register(check, TABLE_TORQUE_ENABLE, 1);
    table_set(check->servos[0].registers, TABLE_GOAL_POSITION, 2, 512); // its present position
    rig_node(check->rig, 0)->servo = check->servos[0];
    for (unsigned ms = 1; ms <= 500; ms++) {
        bool here = ms <= 50 || ms % 3 == board_number(check);
        if (here && check_next(check, "%u ms", ms)) {
            lose_state(check, ms);
            check_after(check);
        }
    }
}

static void drop_amid(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned us = 0; us < 300; us++) {
            if (check_next(check, "%s, after %u us", check_name(&rows_jobs[i]), us)) {
                check->powered_up = true;
                rig_order_in(check->rig, us * RIG_US, "brownout 1 5");
                check_run(check, &rows_jobs[i]);
                check_outcome(check, GOOD | FAILED);
                rig_pass(check->rig, 5000 * RIG_US);
                check_after(check);
            }
        }
    }
}

/* --- F11: absent --- */

static void absent(struct check *check)
{
    for (uint8_t id = 0; id <= 253; id++) {
        for (unsigned i = 0; i < ROWS_JOBS; i++) {
            struct job job = with_id(&rows_jobs[i], id);
            if (id != 1 && id != 2 && check_next(check, "%s of %u", check_name(&job), id)) {
                check_all(check, &job, OUTCOME(CDS_TIMEOUT));
            }
        }
    }
}

static void scan(struct check *check)
{
    static const struct job job = {.kind = JOB_SCAN, .id = 0, .address = 253};
    if (!check_next(check, "254 IDs")) {
        return;
    }
    check_job(check, &job);
    check_sent_total(check);
    const struct job_outcome *found = &check->outcome;
    double us = (double)(check->rig->ended - check->rig->begun) / RIG_US;
    if (us > SCAN_us) {
        check_fail(check, "took %.0f us", us);
    }
    if (found->result != CDS_OK || found->asked != 254 || found->found != 2 || found->ids[0] != 1 ||
        found->ids[1] != 2 || check->last_stats.sent != 254 || check->last_stats.timeouts != 252) {
        check_fail(check, "asked %u IDs, found %u servos", found->asked, found->found);
    }
    const struct cds_stats *stats = &check->last_stats;
    if (stats->malformed || stats->noise_bytes || stats->stale_replies ||
        stats->duplicate_replies || stats->unexpected_packets) {
        check_fail(check, "noise or an unexpected packet was counted");
    }
    check->job = rows_jobs[0];
    check->skips_oracle = true; // the oracle knows no scan; the two replies are checked above
    check_after(check);
}

/* --- F12: another rate --- */

static void other_baud(struct check *check)
{
    for (int baud = 0; baud <= 254; baud++) {
        for (unsigned i = 0; i < ROWS_JOBS; i++) {
            if (baud != SERVO_RESET_BAUD &&
                check_next(check, "%s, register %d", check_name(&rows_jobs[i]), baud)) {
                check->baud = baud;
                check->next_id = 2;
                rig_order(check->rig, "baud 1 %d", baud);
                check_all(check, &rows_jobs[i], FAILED);
            }
        }
    }
}

static void scan_bauds(struct check *check)
{
    static const uint8_t listed[] = {1, 3, 7, 16, 34, 103};
    static const struct job job = {.kind = JOB_SCAN_LISTED, .id = 1, .address = 1};
    for (unsigned i = 0; i < sizeof(listed); i++) {
        if (!check_next(check, "register %u", listed[i])) {
            continue;
        }
        check->baud = listed[i];
        check->next_id = 2;
        rig_order(check->rig, "baud 1 %u", listed[i]);
        check_job(check, &job);
        check_sent_total(check);
        const struct job_outcome *found = &check->outcome;
        if (found->result != CDS_OK || found->found != 1 || found->baud_regs[0] != listed[i] ||
            found->own_baud_regs[0] != listed[i]) {
            check_fail(check, "found %u servos, at baud register %u, own register %u", found->found,
                       found->baud_regs[0], found->own_baud_regs[0]);
        }
        check->job = rows_jobs[0];
        check->skips_oracle = true; // the rig records bytes of one rate only
        check_after(check);
    }
}

/* --- F17, F18 --- */

static void delay_from(struct check *check, unsigned first)
{
    for (unsigned delay = first; delay <= 254; delay++) {
        for (unsigned i = 0; i < ROWS_JOBS; i++) {
            if (check_next(check, "%s, register %u", check_name(&rows_jobs[i]), delay)) {
                set_register(check, TABLE_RETURN_DELAY, (uint8_t)delay);
                check_all(check, &rows_jobs[i], GOOD);
            }
        }
    }
}

/* Return delay 0 is too short for a board with two enables: the driver can meet the reply. The
 * phase varies which other handler runs at that moment. */
static void delay_zero(struct check *check)
{
    set_register(check, TABLE_RETURN_DELAY, 0);
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned phase = 0; phase < 100; phase++) {
            if (check_next(check, "%s, phase %u", check_name(&rows_jobs[i]), phase)) {
                check->rules = RULE(RULE_TWO_DRIVERS) | RULE(RULE_REPLY_LOST);
                check->next_id = 2;
                rig_pass(check->rig, phase * 13);
                check_run(check, &rows_jobs[i]);
                check_outcome(check, GOOD | FAILED);
                check_after(check);
            }
        }
    }
}

static void delay_buffered(struct check *check)
{
    delay_from(check, 1);
}

static void delay_tied(struct check *check)
{
    delay_from(check, 0);
}

static void delay_over(struct check *check)
{
    for (unsigned i = 0; i < ROWS_JOBS; i++) {
        for (unsigned us = 700; us <= 10000; us += 100) {
            if (check_next(check, "%s, %u us", check_name(&rows_jobs[i]), us)) {
                check->next_id = 2;
                check_allow_late_bytes(check, &rows_jobs[i]);
                rig_order(check->rig, "turnaround 1 %u", us);
                check_all(check, &rows_jobs[i],
                          rows_outcome_of_late_reply(check, &rows_jobs[i], us, ROWS_ALLOWED_us));
            }
        }
    }
}

/* A READ of another register of the same servo follows at once. The late reply to the first READ
 * may be taken for the reply to the second one only if it begins later than the bus rests for. If
 * the second packet meets that reply, only the end of the reply is received. */
static void read_again(struct check *check, unsigned us, uint8_t return_delay)
{
    struct job job = {.kind = JOB_READ,
                      .id = 1,
                      .address = TABLE_MOVING_SPEED,
                      .length = 2,
                      .return_delay = return_delay};
    rig_order(check->rig, "turnaround 1 %u", us);
    check_run(check, &job);
    check_outcome(check, OUTCOME(CDS_TIMEOUT));
    check_forget(check);
    job.address = TABLE_GOAL_POSITION;
    check->allows_wrong_value = us + SERVO_DELAY_us > CHECK_STALE_REPLY_US;
    check_run(check, &job);
    check_outcome(check, check->allows_wrong_value ? GOOD | FAILED : OUTCOME(CDS_TIMEOUT));
    check_after(check);
}

static void delay_over_again(struct check *check)
{
    for (uint8_t return_delay = 0; return_delay <= 1; return_delay++) { // 508 us, 2 us
        for (unsigned us = return_delay ? 200 : 700; us <= 10000; us += 10) {
            if (check_next(check, "bus set to %u us, %u us", return_delay ? 2 : 508, us)) {
                check->next_id = 2;
                check->return_delay = return_delay;
                read_again(check, us, return_delay);
            }
        }
    }
}

/* The bus learns the status return level from the WRITEs that it sends. Then it runs the job. A
 * READ at level 0 must be refused, because no reply is due. */
static void level(struct check *check, const struct job *asked, unsigned level, unsigned before)
{
    struct job job = *asked, set = {.kind = JOB_WRITE,
                                    .id = 1,
                                    .length = 1,
                                    .address = TABLE_RETURN_LEVEL,
                                    .servos = JOB_NEW_SERVOS};
    job.servos = JOB_WITH_SERVOS;
    for (unsigned i = 0; i < 2; i++) { // first `before`, then `level`
        set.data[0] = (uint8_t)(i ? level : before);
        check_run(check, &set);
        check_outcome(check, GOOD);
        check_known(check, "level", set.data[0], check->outcome.known.status_return_level);
        check_forget(check);
        check->level = set.data[0];
        set.servos = JOB_WITH_SERVOS;
    }
    check->servos[0].registers[TABLE_RETURN_LEVEL] = (uint8_t)level;
    if (level == 0 && job.kind == JOB_READ) {
        check_refused(check, &job, CDS_NO_REPLY_DUE);
    } else {
        check_run(check, &job);
        check_outcome(check, GOOD);
        bool answered = job.id == 1 && (level == 2 || job.kind == JOB_PING || job.kind == JOB_READ);
        if (check->rig->answer_count != answered) {
            check_fail(check, "%u replies", check->rig->answer_count);
        }
    }
    check->next_id = 2;
    check_after(check);
    check->servos[0].registers[TABLE_RETURN_LEVEL] = 2;
    rig_node(check->rig, 0)->servo.registers[TABLE_RETURN_LEVEL] = 2;
}

static void levels(struct check *check)
{
    for (unsigned from_to = 0; from_to < 9; from_to++) {
        for (unsigned i = 0; i <= ROWS_JOBS; i++) {
            struct job job = rows_jobs[i < ROWS_JOBS ? i : 5];
            job.id = i < ROWS_JOBS ? 1 : SERVO_BROADCAST_ID;
            if (check_next(check, "%s to %u, level %u, then %u", check_name(&job), job.id,
                           from_to / 3, from_to % 3)) {
                level(check, &job, from_to % 3, from_to / 3);
            }
        }
    }
}

/* --- F19: error bits --- */

/* Makes the servo report these error bits. Its tick is stopped, so that it keeps reporting them. */
static void set_alarm_conditions(struct check *check, unsigned conditions)
{
    struct servo *servo = &rig_node(check->rig, 0)->servo;
    schedule_cancel(&check->rig->bench.schedule, &rig_node(check->rig, 0)->tick);
    if (conditions & SERVO_ERROR_VOLTAGE) {
        servo->registers[TABLE_LOWEST_VOLTAGE] = 200;
    }
    if (conditions & SERVO_ERROR_OVERHEATING) {
        servo->registers[TABLE_HIGHEST_TEMPERATURE] = 10;
    }
    servo->motor.overload = conditions & SERVO_ERROR_OVERLOAD;
}

static void clear_alarm_conditions(struct check *check)
{
    struct servo *servo = &rig_node(check->rig, 0)->servo;
    servo->registers[TABLE_LOWEST_VOLTAGE] = check->servos[0].registers[TABLE_LOWEST_VOLTAGE];
    servo->registers[TABLE_HIGHEST_TEMPERATURE] =
        check->servos[0].registers[TABLE_HIGHEST_TEMPERATURE];
    servo->motor.overload = false;
}

/* The servo reports no error any more: checks that servos.h keeps the alarms. */
static void check_alarms_kept(struct check *check, unsigned alarms)
{
    static const struct job ping = {.kind = JOB_PING, .id = 1, .servos = JOB_WITH_SERVOS};
    struct job job = check->job;
    struct job_outcome outcome = check->outcome;
    check_forget(check);
    check_run(check, &ping);
    check_outcome(check, GOOD);
    if (check->outcome.error) {
        check_fail(check, "the servo still reports %02X", check->outcome.error);
    }
    check_known(check, "alarms", alarms, check->outcome.known.alarms);
    check_known(check, "alarms of all", alarms, check->outcome.alarms);
    check->job = job;
    check->outcome = outcome;
}

/* Checks a reply with error bits. Retries are allowed and must not be used: the reply is good. */
static void report(struct check *check, const struct job *job, unsigned conditions,
                   unsigned error_of_packet)
{
    struct job with_retries = *job;
    with_retries.retries = 2;
    with_retries.servos = JOB_NEW_SERVOS;
    set_alarm_conditions(check, conditions);
    if (error_of_packet == SERVO_ERROR_CHECKSUM) {
        rig_order(check->rig, "flip in 1 %u 1", rows_packet_size(job) - 1);
    }
    check_run(check, &with_retries);
    check_outcome(check, GOOD);
    if (check->outcome.error != (conditions | error_of_packet)) {
        check_fail(check, "error %02X", check->outcome.error);
    }
    if (check->attempts != 1) {
        check_fail(check, "%u attempts", check->attempts);
    }
    check_known(check, "alarms", check->outcome.error, check->outcome.known.alarms);
    check_known(check, "alarms of all", check->outcome.error, check->outcome.alarms);
    clear_alarm_conditions(check);
    check_alarms_kept(check, check->outcome.error);
    check_after(check);
}

static void error_bits(struct check *check)
{
    static const struct {
        struct job job;
        unsigned error;
    } refused[] = {
        {{.kind = JOB_WRITE,
          .id = 1,
          .address = TABLE_GOAL_POSITION,
          .length = 2,
          .data = {0x20, 3}},
         SERVO_ERROR_ANGLE},
        {{.kind = JOB_REG_WRITE,
          .id = 1,
          .address = TABLE_GOAL_POSITION,
          .length = 2,
          .data = {0x20, 3}},
         SERVO_ERROR_ANGLE},
        {{.kind = JOB_WRITE, .id = 1, .address = TABLE_PRESENT_POSITION, .length = 2},
         SERVO_ERROR_RANGE},
        {{.kind = JOB_ACTION, .id = 1}, SERVO_ERROR_INSTRUCTION},
    };
    table_set(check->servos[0].registers, TABLE_CCW_LIMIT, 2, 0x310);
    rig_node(check->rig, 0)->servo = check->servos[0];
    for (unsigned some = 0; some < 8; some++) {
        unsigned conditions = (some & 1 ? SERVO_ERROR_VOLTAGE : 0u) |
                              (some & 2 ? SERVO_ERROR_OVERHEATING : 0u) |
                              (some & 4 ? SERVO_ERROR_OVERLOAD : 0u);
        for (unsigned i = 0; i < ROWS_JOBS - 1;
             i++) { // not the READ of the whole table: it would read the changed limits
            const struct job *job = &rows_jobs[i == 4 ? ROWS_JOBS - 1 : i];
            for (unsigned error = 0; error <= SERVO_ERROR_CHECKSUM; error += SERVO_ERROR_CHECKSUM) {
                if (check_next(check, "%s, error %02X", check_name(job), conditions | error)) {
                    report(check, job, conditions, error);
                }
            }
        }
        for (unsigned i = 0; i < sizeof(refused) / sizeof(refused[0]); i++) {
            if (check_next(check, "%s, error %02X", check_name(&refused[i].job),
                           conditions | refused[i].error)) {
                report(check, &refused[i].job, conditions, refused[i].error);
            }
        }
    }
}

#define BUFFERED "atmega128 arduino-uno"
#define TIED     "arbotix"

const struct row rows_servo[] = {
    {"F6", "two servos with one ID, replies 0 to 500 us apart, every one", "7,7,2", twins, 0},
    {"F8-drop", "servo without power for 1 to 500 ms, every one: OFFLINE, RETURNED, state lost",
     "1,2", drop, 0},
    {"F8-amid", "servo loses power at every microsecond of a transaction", "1,2", drop_amid, 0},
    {"F11", "servo absent, every ID", "1,2", absent, 0},
    {"F11-scan", "scan of 254 IDs within 0.3 s", "1,2", scan, 0},
    {"F12", "servo at every other baud rate", "1,2", other_baud, 0},
    {"F12-scan", "servo at every listed baud rate is found", "1,2", scan_bauds, 0},
    {"F17-buffers", "return delay register 1 to 254", "1,2", delay_buffered, BUFFERED},
    {"F17-zero", "return delay register 0 where it is too short: no wrong value", "1,2", delay_zero,
     BUFFERED},
    {"F17-tied", "return delay register 0 to 254, tied pins", "1,2", delay_tied, TIED},
    {"F17-over", "return delay 0.7 to 10 ms, another servo is asked next", "1,2", delay_over, 0},
    {"F17-again", "return delay 0.2 to 10 ms, the same servo is asked for another word at once",
     "1,2", delay_over_again, 0},
    {"F18", "status return level 0 to 2, from each to each, learnt; broadcast", "1,2", levels, 0},
    {"F19", "each error bit, and all that go together; alarms", "1,2", error_bits, 0},
    {0},
};
