/* SPDX-License-Identifier: MIT */
/* Runs the operations of the library for several servos, one after the other, on servos 1 to 6 with
 * factory values: SYNC WRITE, registered move with verification, servos.h, torque off, health
 * check, diagnosis. Prints the outcome of each, and the counters of the bus. */
#include <cds55xx/blocking.h>
#include <cds55xx/health.h>
#include <cds55xx/queue.h>
#include <cds55xx/avr.h>
#include <util/delay.h>

#include "say.h"

#define SERVOS 6
#define NOBODY 77
#define GOAL   4 // bytes from GOAL_POSITION on

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_SYNC_WRITE_SIZE(SERVOS, GOAL)];
static uint8_t reply[CDS_DIAGNOSE_REPLY_SIZE];
static struct cds_request request = CDS_REQUEST(packet, reply);
static const uint8_t ids[SERVOS] = {1, 2, 3, 4, 5, 6};
static struct cds_servos servos;
static struct cds_servo_state states[SERVOS + 1];

static void write_byte(const char *name, uint8_t id, uint8_t address, uint8_t value)
{
    say(name, cds_blocking_write_byte(&bus, &request, id, address, value));
}

static void write_word(const char *name, uint8_t id, uint8_t address, uint16_t value)
{
    say(name, cds_blocking_write_word(&bus, &request, id, address, value));
}

/* --- groups --------------------------------------------------------------------------------------
 */

static void group_write(void)
{
    static struct cds_sync_write_many write;
    static struct cds_group_read read;
    static struct cds_group_answer answers[SERVOS];
    static uint8_t data[SERVOS * GOAL];
    static uint8_t packets[2][CDS_PACKET_SIZE(2)], replies[2][2];
    static struct cds_request requests[2] = {CDS_REQUEST(packets[0], replies[0]),
                                             CDS_REQUEST(packets[1], replies[1])};

    for (uint8_t i = 0; i < SERVOS; i++) {
        data[GOAL * i] = (uint8_t)(10 + i);
        data[GOAL * i + 1] = 2; // 522 and up
        data[GOAL * i + 2] = data[GOAL * i + 3] = 1;
    }
    cds_blocking_sync_write_many(
        &write, &(struct cds_sync_write_many_config){.bus = &bus,
                                                     .request = &request,
                                                     .ids = ids,
                                                     .data = data,
                                                     .count = SERVOS,
                                                     .address = CDS_REG_GOAL_POSITION,
                                                     .length = GOAL,
                                                     .packet_max = CDS_SYNC_WRITE_SIZE(2, GOAL)});
    say("written", write.steps.result);
    say("packets", write.packets);
    cds_blocking_group_read(&read, &(struct cds_group_read_config){.bus = &bus,
                                                                   .requests = requests,
                                                                   .ids = ids,
                                                                   .data = data,
                                                                   .answers = answers,
                                                                   .count = SERVOS,
                                                                   .address = CDS_REG_GOAL_POSITION,
                                                                   .length = 2});
    for (uint8_t i = 0; i < SERVOS; i++)
        say("goal", answers[i].result ? answers[i].result : data[2 * i] + 256u * data[2 * i + 1]);
}

static void verified_move(uint16_t position)
{
    static struct cds_goal goals[3];
    static struct cds_registered_move move;

    for (uint8_t i = 0; i < 3; i++)
        goals[i] = (struct cds_goal){.id = ids[i + 1], .position = position, .speed = 1023};
    say("moved",
        cds_blocking_registered_move(
            &move,
            &(struct cds_registered_move_config){
                .bus = &bus, .request = &request, .goals = goals, .count = 3, .verify = true}));
    say("acted", move.acted);
    for (uint8_t i = 0; i < 3; i++)
        say("servo", goals[i].result * 1000ul + goals[i].error * 10u + goals[i].registered);
}

/* Servo 3 has a limit below the first goal. */
static void verified_moves(void)
{
    write_word("limit", 3, CDS_REG_CCW_ANGLE_LIMIT, 600);
    verified_move(640);
    verified_move(560);
}

/* --- servos --------------------------------------------------------------------------------------
 */

static void soft_limits(void)
{
    static const uint8_t goal[GOAL] = {700 & 0xFF, 700 >> 8, 512 & 0xFF, 512 >> 8};
    uint16_t limit = 0;

    say("mode", cds_blocking_read_word(&bus, &request, 1, CDS_REG_CCW_ANGLE_LIMIT, &limit));
    say("set", cds_servos_set_limits(&servos, &states[0], 300, 700, 512));
    write_word("fast", 1, CDS_REG_MOVING_SPEED, 513);
    write_word("speed", 1, CDS_REG_MOVING_SPEED, 512);
    write_word("far", 1, CDS_REG_GOAL_POSITION, 701);
    write_word("alone", 1, CDS_REG_GOAL_POSITION, 700); // without its speed
    say("goal", cds_blocking_write(&bus, &request, 1, CDS_REG_GOAL_POSITION, goal, GOAL));
    say("whom", servos.refused_id);
}

static void learning(void)
{
    uint8_t byte = 0;

    write_byte("delay", 4, CDS_REG_RETURN_DELAY, 50);
    say("known", states[3].return_delay);
    write_byte("level", 5, CDS_REG_STATUS_RETURN_LEVEL, 0);
    say("unread", cds_blocking_read_byte(&bus, &request, 5, CDS_REG_ID, &byte));
    say("ping", cds_blocking_ping(&bus, &request, 5));
    write_byte("level", 5, CDS_REG_STATUS_RETURN_LEVEL, 2);
    say("read", cds_blocking_read_byte(&bus, &request, 5, CDS_REG_ID, &byte));
    say("id", byte);
    write_byte("wrong", 6, CDS_REG_LED, 2);
    say("alarms", cds_servos_acknowledge(&servos, &states[5]));
    say("alarms", cds_servos_acknowledge(&servos, &states[5]));
    for (uint8_t i = 0; i < CDS_SERVOS_MISSES; i++)
        say("absent", cds_blocking_ping(&bus, &request, NOBODY));
    say("away", states[SERVOS].presence == CDS_PRESENCE_OFFLINE);
}

static void inhibits(void)
{
    cds_servos_inhibit(&servos, &states[1], CDS_INHIBIT_STOPPED);
    write_word("held", 2, CDS_REG_GOAL_POSITION, 500);
    write_byte("let_go", 2, CDS_REG_TORQUE_ENABLE, 0);
    cds_servos_release(&servos, &states[1]);
    write_byte("driven", 2, CDS_REG_TORQUE_ENABLE, 1);
}

/* A servo that answers only PING and READ, and an inhibited servo. ACTION also reaches servo 1, so
 * its limits are removed first. */
static void moves_beside_limits(void)
{
    verified_move(540);
    say("set", cds_servos_set_limits(&servos, &states[0], 0, CDS_VALUE_MAX, CDS_VALUE_MAX));
    write_byte("level", 4, CDS_REG_STATUS_RETURN_LEVEL, 1);
    verified_move(540);
    cds_servos_inhibit(&servos, &states[2], CDS_INHIBIT_STOPPED);
    verified_move(530);
    cds_servos_release(&servos, &states[2]);
    write_byte("level", 4, CDS_REG_STATUS_RETURN_LEVEL, 2);
}

/* --- torque off, state check, diagnosis ----------------------------------------------------------
 */

static void stop_all(void)
{
    static struct cds_torque_off off;

    say("begun", cds_torque_off_begin(&off, &servos));
    while (cds_torque_off_poll(&off) == CDS_PENDING)
        cds_bus_poll(&bus);
    say("stopped", off.steps.result);
    say("told", off.broadcasts);
    for (uint8_t i = 0; i <= SERVOS; i++)
        say("outcome", states[i].torque_off);
    write_byte("held", 1, CDS_REG_TORQUE_ENABLE, 1);
    cds_servos_release_all(&servos);
    write_byte("driven", 1, CDS_REG_TORQUE_ENABLE, 1);
}

/* Two rounds of the health check. Between them the torque of servo 1 is switched off without
 * servos.h. */
static void check_state(void)
{
    static struct cds_health health;
    uint32_t since_us = cds_port_now_us();
    static struct cds_queue queue;
    const struct cds_bus_hooks *hooks = bus.hooks;
    bool put_off = false;

    say("begun", cds_health_begin(
                     &health, &(struct cds_health_config){.servos = &servos, .period_us = 20000}));
    while (cds_port_now_us() - since_us < 50000) {
        cds_health_poll(&health);
        cds_bus_poll(&bus);
        if (!put_off && cds_port_now_us() - since_us >= 25000 && !bus.request) {
            put_off = true;
            bus.hooks = NULL;
            cds_queue_attach(&queue, &bus);
            cds_blocking_write_byte(&bus, &request, 1, CDS_REG_TORQUE_ENABLE, 0);
            bus.hooks = NULL;
            cds_bus_attach(&bus, hooks);
        }
    }
    while (cds_bus_poll(&bus)) {
    }
    for (uint8_t i = 0; i <= SERVOS; i++)
        say("state", states[i].inhibits * 10u + states[i].presence);
}

static void diagnose(uint8_t id)
{
    static struct cds_diagnose diagnosis;
    struct cds_diagnose_config config = {.bus = &bus, .request = &request, .id = id};

    say("begun", cds_diagnose_begin(&diagnosis, &config));
    while (cds_diagnose_poll(&diagnosis) == CDS_PENDING)
        cds_bus_poll(&bus);
    say("ended", diagnosis.steps.result);
    say("found", diagnosis.finding);
    say("whom", diagnosis.found_id);
}

/* --- all of it -----------------------------------------------------------------------------------
 */

static void say_counters(void)
{
    struct cds_stats count;
    uint16_t of_servos = 0;

    cds_bus_stats(&bus, &count);
    for (uint8_t i = 0; i <= SERVOS; i++)
        of_servos += states[i].counters.ok;
    say("of_servos", of_servos);
    say("sent", count.sent);
    say("ok", count.ok);
    say("timeouts", count.timeouts);
    say("bad", count.corrupt + count.line_busy + count.malformed + count.stale_replies +
                   count.duplicate_replies + count.unexpected_packets + count.framing_errors +
                   count.overruns + count.ring_overflows + count.echo_errors);
}

int main(void)
{
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_return_delay(&bus, 100);
    group_write();
    verified_moves();

    for (uint8_t i = 0; i < SERVOS; i++)
        states[i].id = ids[i];
    states[SERVOS].id = NOBODY;
    say("servos", cds_servos_begin(&servos, &(struct cds_servos_config){.bus = &bus,
                                                                        .states = states,
                                                                        .count = SERVOS + 1,
                                                                        .capacity = SERVOS + 1}));
    soft_limits();
    learning();
    inhibits();
    moves_beside_limits();
    stop_all();
    check_state();
    diagnose(1);
    say_counters();
    say_end();
}
