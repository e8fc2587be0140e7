/* SPDX-License-Identifier: MIT */
/* Marks every submit and every call of cds_bus_poll(), with 50 servos and their limits. Cases: a
 * SYNC WRITE of 50 goals on an idle bus; a SYNC WRITE of 50 goals that waits behind a READ while
 * all limits change, so that it leaves or is refused; torque on to 50 servos by SYNC WRITE, which
 * servos.h learns; WRITE and ACTION by broadcast; READs and WRITEs of one servo. The program polls
 * at once or late. */
#include "safe.h"

#define NARROW_LOWEST (MIDDLE + 1) // limits that refuse the goals
#define ROUNDS        4

BENCH_SYNC_WRITE(sync, SERVOS, 4);
static uint16_t left, refused, others, wrong;

/* Marks the call `what`, which submits a request, and stores its return value in `result`. */
#define SUBMIT(result, what)                                                                       \
    do {                                                                                           \
        mark(MARK_CALL);                                                                           \
        result = (what);                                                                           \
        unmark(MARK_CALL);                                                                         \
    } while (0)

/* Polls every `late_us` until no request waits. */
static void run(uint16_t late_us)
{
    uint32_t from_us;
    bool busy;

    do {
        from_us = cds_port_now_us();
        while (cds_port_now_us() - from_us < late_us) {
        }
        mark(MARK_POLL);
        busy = cds_bus_poll(&bus);
        unmark(MARK_POLL);
    } while (busy);
}

static void count(const struct cds_request *which, enum cds_result submitted,
                  enum cds_result expected, uint16_t *counter)
{
    enum cds_result result = submitted == CDS_OK ? (enum cds_result)which->result : submitted;

    if (result == expected)
        (*counter)++;
    else
        wrong++;
}

static void build_goals(void)
{
    cds_sync_write_begin(&sync, CDS_REG_GOAL_POSITION, 4);
    for (uint8_t id = 1; id <= SERVOS; id++)
        cds_sync_write_add_goal(&sync, id, MIDDLE, SPEED);
}

BENCH_NOINLINE static void goals_at_once(uint16_t late_us)
{
    enum cds_result result;

    build_goals();
    SUBMIT(result, cds_sync_write_send(&bus, &sync));
    run(late_us);
    count(&sync, result, CDS_OK, &left);
}

/* `lowest`: the lower goal limit that all servos get while the goals wait. */
BENCH_NOINLINE static void goals_that_wait(uint16_t late_us, uint16_t lowest)
{
    enum cds_result result, of_read;

    build_goals();
    SUBMIT(of_read, cds_servo_read(&bus, &request, SERVOS, CDS_REG_PRESENT_POSITION, 2));
    SUBMIT(result, cds_sync_write_send(&bus, &sync));
    safe_set_limits(lowest, HIGHEST);
    run(late_us);
    count(&request, of_read, CDS_OK, &others);
    if (lowest > MIDDLE)
        count(&sync, result, CDS_LIMIT, &refused);
    else
        count(&sync, result, CDS_OK, &left);
}

/* The limits change back while the goals are being checked. */
BENCH_NOINLINE static void goals_checked_again(uint16_t late_us)
{
    enum cds_result result, of_read;

    build_goals();
    SUBMIT(of_read, cds_servo_read(&bus, &request, 1, CDS_REG_PRESENT_POSITION, 2));
    SUBMIT(result, cds_sync_write_send(&bus, &sync));
    safe_set_limits(NARROW_LOWEST, HIGHEST);
    safe_set_limits(LOWEST, HIGHEST);
    run(late_us);
    count(&request, of_read, CDS_OK, &others);
    count(&sync, result, CDS_OK, &left);
}

BENCH_NOINLINE static void torque_to_all(uint16_t late_us)
{
    static const uint8_t on[] = {1};
    enum cds_result result;

    cds_sync_write_begin(&sync, CDS_REG_TORQUE_ENABLE, sizeof(on));
    for (uint8_t id = 1; id <= SERVOS; id++)
        cds_sync_write_add(&sync, id, on);
    SUBMIT(result, cds_sync_write_send(&bus, &sync));
    run(late_us);
    count(&sync, result, CDS_OK, &left);
}

BENCH_NOINLINE static void broadcast(uint16_t late_us, uint8_t address, uint8_t value)
{
    enum cds_result result;

    SUBMIT(result, cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, address, value));
    run(late_us);
    count(&request, result, CDS_OK, &others);
}

BENCH_NOINLINE static void one_servo(uint16_t late_us, uint8_t id)
{
    enum cds_result result;

    SUBMIT(result, cds_servo_read(&bus, &request, id, CDS_REG_RESERVED_00, CDS_REPLY_MAX));
    run(late_us);
    count(&request, result, CDS_OK, &others);
    SUBMIT(result, cds_servo_write_word(&bus, &request, id, CDS_REG_MOVING_SPEED, SPEED));
    run(late_us);
    count(&request, result, CDS_OK, &others);
    SUBMIT(result, safe_send_goal(id));
    run(late_us);
    count(&request, result, CDS_OK, &others);
    SUBMIT(result, cds_servo_read(&bus, &request, id, CDS_REG_GOAL_POSITION, 4)); // or no torque on
    run(late_us);
    count(&request, result, CDS_OK, &others);
}

BENCH_NOINLINE static void action(uint16_t late_us)
{
    enum cds_result result;

    SUBMIT(result, cds_servo_action(&bus, &request, CDS_BROADCAST_ID));
    run(late_us);
    count(&request, result, CDS_LIMIT, &refused); // servos with limits: registered_move only
}

int main(void)
{
    static const uint16_t late_us[] = {0, 40, 1000};
    uint8_t good = safe_open();

    for (uint8_t i = 0; i < ROUNDS * 3; i++) {
        uint16_t late = late_us[i % 3];

        torque_to_all(late);
        broadcast(late, CDS_REG_LED, 1);
        broadcast(late, CDS_REG_TORQUE_ENABLE, 0);
        broadcast(late, CDS_REG_TORQUE_ENABLE, 1);
        action(late);
        one_servo(late, (uint8_t)(SERVOS - i));
        one_servo(late, (uint8_t)(i + 1));
    }
    for (uint8_t i = 0; i < ROUNDS * 3; i++) {
        uint16_t late = late_us[i % 3];

        goals_at_once(late);
        goals_that_wait(late, LOWEST - 1);
        goals_that_wait(late, NARROW_LOWEST);
        safe_set_limits(LOWEST, HIGHEST);
        goals_checked_again(late);
    }
    say("good", good);
    say("left", left);
    say("refused", refused);
    say("others", others);
    say("wrong", wrong);
    say_end();
}
