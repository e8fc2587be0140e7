/* What looks after several servos at once, one after the other, on a bus of servos 1 to 6 at
 * factory values: group write, verified move, roster, torque off for all, state check, diagnosis.
 * Says how each ended, and the counters of the bus. */
#include <cds55xx/diagnose.h>
#include <cds55xx/registered_move.h>
#include <cds55xx/group_read.h>
#include <cds55xx/sync_write_many.h>
#include <cds55xx/servos.h>
#include <cds55xx/torque_off.h>
#include <cds55xx/blocking.h>
#include <cds55xx/health.h>
#include <cds55xx_avr.h>
#include <util/delay.h>

#include "say.h"

#define SERVOS 6
#define NOBODY 77
#define GOAL   4 // bytes from GOAL_POSITION on

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_SYNC_WRITE_SIZE(SERVOS, GOAL)];
static struct cds_request request = CDS_REQUEST(packet);
static const uint8_t ids[SERVOS] = {1, 2, 3, 4, 5, 6};
static struct cds_servos roster;
static struct cds_servo_state servos[SERVOS + 1];

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

    for (uint8_t i = 0; i < SERVOS; i++) {
        data[GOAL * i] = (uint8_t)(10 + i);
        data[GOAL * i + 1] = 2; // 522 and up
        data[GOAL * i + 2] = data[GOAL * i + 3] = 1;
    }
    cds_sync_write_many_begin(&write, &bus, &request, ids, SERVOS, CDS_REG_GOAL_POSITION, GOAL,
                              data);
    cds_sync_write_many_set_longest(&write, CDS_SYNC_WRITE_SIZE(2, GOAL));
    while (cds_sync_write_many_poll(&write) == CDS_PENDING)
        cds_bus_poll(&bus);
    say("written", write.result);
    say("packets", write.packets);
    cds_group_read_begin(&read, &bus, &request, ids, SERVOS, CDS_REG_GOAL_POSITION, 2, data,
                         answers);
    while (cds_group_read_poll(&read) == CDS_PENDING)
        cds_bus_poll(&bus);
    for (uint8_t i = 0; i < SERVOS; i++)
        say("goal", answers[i].result ? answers[i].result : data[2 * i] + 256u * data[2 * i + 1]);
}

static void verified_move(uint16_t position)
{
    static struct cds_goal goals[3];
    static struct cds_registered_move move;

    for (uint8_t i = 0; i < 3; i++)
        goals[i] = (struct cds_goal){.id = ids[i + 1], .position = position, .speed = 1023};
    cds_registered_move_begin(&move, &bus, &request, goals, 3);
    cds_registered_move_set_verify(&move);
    while (cds_registered_move_poll(&move) == CDS_PENDING)
        cds_bus_poll(&bus);
    say("moved", move.result);
    say("acted", move.acted);
    for (uint8_t i = 0; i < 3; i++)
        say("servo", goals[i].result * 1000ul + goals[i].error * 10u + goals[i].armed);
}

/* Servo 3 has a limit below the first of the two. */
static void verified_moves(void)
{
    write_word("limit", 3, CDS_REG_CCW_ANGLE_LIMIT, 600);
    verified_move(640);
    verified_move(560);
}

/* --- roster --------------------------------------------------------------------------------------
 */

static void soft_limits(void)
{
    uint16_t limit = 0;

    say("mode", cds_blocking_read_word(&bus, &request, 1, CDS_REG_CCW_ANGLE_LIMIT, &limit));
    say("set", cds_servos_set_limits(&roster, &servos[0], 300, 700, 512));
    write_word("fast", 1, CDS_REG_MOVING_SPEED, 513);
    write_word("speed", 1, CDS_REG_MOVING_SPEED, 512);
    write_word("far", 1, CDS_REG_GOAL_POSITION, 701);
    write_word("goal", 1, CDS_REG_GOAL_POSITION, 700);
    say("whom", roster.refused_id);
}

static void learning(void)
{
    uint8_t byte = 0;

    write_byte("delay", 4, CDS_REG_RETURN_DELAY, 50);
    say("known", servos[3].return_delay);
    write_byte("level", 5, CDS_REG_STATUS_RETURN_LEVEL, 0);
    say("unread", cds_blocking_read_byte(&bus, &request, 5, CDS_REG_ID, &byte));
    say("ping", cds_blocking_ping(&bus, &request, 5));
    write_byte("level", 5, CDS_REG_STATUS_RETURN_LEVEL, 2);
    say("read", cds_blocking_read_byte(&bus, &request, 5, CDS_REG_ID, &byte));
    say("id", byte);
    write_byte("wrong", 6, CDS_REG_LED, 2);
    say("alarms", cds_servos_acknowledge(&roster, &servos[5]));
    say("alarms", cds_servos_acknowledge(&roster, &servos[5]));
    for (uint8_t i = 0; i < CDS_SERVOS_SILENCES; i++)
        say("absent", cds_blocking_ping(&bus, &request, NOBODY));
    say("away", servos[SERVOS].presence == CDS_PRESENCE_OFFLINE);
}

static void holds(void)
{
    cds_servos_hold(&roster, &servos[1], CDS_INHIBIT_STOPPED);
    write_word("held", 2, CDS_REG_GOAL_POSITION, 500);
    write_byte("let_go", 2, CDS_REG_TORQUE_ENABLE, 0);
    cds_servos_release(&roster, &servos[1]);
    write_byte("driven", 2, CDS_REG_TORQUE_ENABLE, 1);
}

/* One that answers PING and READ only; one that is held. */
static void moves_with_roster(void)
{
    write_byte("level", 4, CDS_REG_STATUS_RETURN_LEVEL, 1);
    verified_move(540);
    cds_servos_hold(&roster, &servos[2], CDS_INHIBIT_STOPPED);
    verified_move(530);
    cds_servos_release(&roster, &servos[2]);
    write_byte("level", 4, CDS_REG_STATUS_RETURN_LEVEL, 2);
}

/* --- torque off, state check, diagnosis ----------------------------------------------------------
 */

static void stop_all(void)
{
    static struct cds_torque_off stop;

    say("begun", cds_torque_off_begin(&stop, &roster));
    while (cds_torque_off_poll(&stop) == CDS_PENDING)
        cds_bus_poll(&bus);
    say("stopped", stop.result);
    say("told", stop.broadcasts);
    for (uint8_t i = 0; i <= SERVOS; i++)
        say("outcome", servos[i].stopped);
    write_byte("held", 1, CDS_REG_TORQUE_ENABLE, 1);
    cds_servos_release(&roster, NULL);
    write_byte("driven", 1, CDS_REG_TORQUE_ENABLE, 1);
}

/* Two rounds, between which servo 1 is put off behind the roster's back. */
static void check_state(void)
{
    static struct cds_health watch;
    uint32_t since_us = cds_port_now_us();
    struct cds_bus_observer *observer = bus.observer;
    bool put_off = false;

    say("begun", cds_health_begin(&watch, &roster, 20000));
    while (cds_port_now_us() - since_us < 50000) {
        cds_health_poll(&watch);
        cds_bus_poll(&bus);
        if (!put_off && cds_port_now_us() - since_us >= 25000 && !bus.request) {
            put_off = true;
            bus.observer = NULL;
            cds_blocking_write_byte(&bus, &request, 1, CDS_REG_TORQUE_ENABLE, 0);
            bus.observer = observer;
        }
    }
    while (cds_bus_poll(&bus)) {
    }
    for (uint8_t i = 0; i <= SERVOS; i++)
        say("state", servos[i].held * 10u + servos[i].presence);
}

static void diagnose(uint8_t id)
{
    static struct cds_diagnose diagnosis;

    say("begun", cds_diagnose_begin(&diagnosis, &bus, &request, id));
    while (cds_diagnose_poll(&diagnosis) == CDS_PENDING)
        cds_bus_poll(&bus);
    say("ended", diagnosis.result);
    say("found", diagnosis.finding);
    say("whom", diagnosis.found_id);
}

/* --- all of it -----------------------------------------------------------------------------------
 */

static void say_counters(void)
{
    struct cds_counters count;
    uint16_t of_servos = 0;

    cds_bus_counters(&bus, &count);
    for (uint8_t i = 0; i <= SERVOS; i++)
        of_servos += servos[i].counters.ok;
    say("of_servos", of_servos);
    say("sent", count.sent);
    say("ok", count.ok);
    say("timeouts", count.timeouts);
    say("bad", count.corrupt + count.unsent + count.refuted + count.late + count.extra +
                   count.foreign + count.framing_errors + count.overruns + count.ring_overflows +
                   count.echo_errors);
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
        servos[i].id = ids[i];
    servos[SERVOS].id = NOBODY;
    say("roster", cds_servos_begin(&roster, &bus, servos, SERVOS + 1));
    soft_limits();
    learning();
    holds();
    moves_with_roster();
    stop_all();
    check_state();
    diagnose(1);
    say_counters();
    say_end();
}
