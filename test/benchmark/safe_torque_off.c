/* SPDX-License-Identifier: MIT */
/* Torque off for all servos, while the main loop only polls. Cases: a quiet line, and many moments
 * during each of: a READ; a SYNC WRITE of 50 goals; torque on to 50 servos; a READ behind which 50
 * goals wait; a READ without a reply; a READ with a damaged reply, because two simulated servos
 * have the ID DAMAGED and answer at the same time. The mark begins at the call. */
#include "safe.h"

#define ABSENT    99
#define DAMAGED   60
#define PHASES    60
#define PHASE_US  8
#define LONGER    12 // times: a SYNC WRITE and its check take so much longer than a READ
#define SETTLE_US 3000

BENCH_REQUEST(read, 8);
BENCH_SYNC_WRITE(sync, SERVOS, 4);
static struct cds_torque_off stop;
static uint16_t stops, over;

/* The request in flight at the call of torque off. */
enum in_flight { NOTHING, GOALS, TORQUE, READ, READ_BEFORE_GOALS, NO_REPLY, BAD_REPLY, KINDS };

static void poll_for(uint16_t us)
{
    uint32_t from_us = cds_port_now_us();

    while (cds_port_now_us() - from_us < us)
        cds_bus_poll(&bus);
}

static void send_goals(void)
{
    cds_sync_write_begin(&sync, CDS_REG_GOAL_POSITION, 4);
    for (uint8_t id = 1; id <= SERVOS; id++)
        cds_sync_write_add_goal(&sync, id, MIDDLE, SPEED);
    cds_sync_write_send(&bus, &sync);
}

static void send_torque(void)
{
    static const uint8_t on[] = {1};

    cds_sync_write_begin(&sync, CDS_REG_TORQUE_ENABLE, sizeof(on));
    for (uint8_t id = 1; id <= SERVOS; id++)
        cds_sync_write_add(&sync, id, on);
    cds_sync_write_send(&bus, &sync);
}

static void begin(enum in_flight kind)
{
    switch (kind) {
    case READ: cds_servo_read(&bus, &read, SERVOS, CDS_REG_PRESENT_POSITION, 8); break;
    case GOALS: send_goals(); break;
    case TORQUE: send_torque(); break;
    case READ_BEFORE_GOALS:
        cds_servo_read(&bus, &read, 1, CDS_REG_PRESENT_POSITION, 8);
        send_goals();
        break;
    case NO_REPLY: cds_servo_read(&bus, &read, ABSENT, CDS_REG_PRESENT_POSITION, 8); break;
    case BAD_REPLY: cds_servo_read(&bus, &read, DAMAGED, CDS_REG_PRESENT_POSITION, 8); break;
    default: break;
    }
}

BENCH_NOINLINE static void torque_off(void)
{
    mark(MARK_CALL);
    cds_torque_off_begin(&stop, &servos);
    while (cds_torque_off_poll(&stop) == CDS_PENDING)
        cds_bus_poll(&bus);
    unmark(MARK_CALL);
    stops++;
    over += stop.steps.result == CDS_OK;
}

static void one_case(enum in_flight kind, uint8_t phase)
{
    uint16_t from_us = (uint16_t)(phase * PHASE_US);

    begin(kind);
    poll_for(kind <= TORQUE ? from_us * LONGER : from_us);
    bench_idle((uint8_t)(phase * 7u % 40u));
    torque_off();
    safe_release();
    bench_wait(&bus);
    poll_for(SETTLE_US);
}

int main(void)
{
    uint8_t good = safe_open();

    for (uint8_t kind = 0; kind < KINDS; kind++)
        for (uint8_t phase = 0; phase < PHASES; phase++)
            one_case((enum in_flight)kind, phase);
    say("good", good);
    say("stops", stops);
    say("over", over);
    say_end();
}
