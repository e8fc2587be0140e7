/* SPDX-License-Identifier: MIT */
/* A robot with a cycle of servos 1 to SERVOS, the health check, torque off for all, and soft
 * limits. A line from the PC is a letter and numbers. The program answers "ok" when it has read the
 * line; the main loop continues meanwhile. It records changes of presence and inhibit with their
 * time, and prints them when the PC asks for them. */
#include <cds55xx/cycle.h>
#include <cds55xx/health.h>
#include <cds55xx/queue.h>
#include <cds55xx/servo.h>
#include <cds55xx/sync_write.h>
#include <cds55xx/torque_off.h>
#include <cds55xx/avr.h>
#include <string.h>

#include "say.h"

#define SERVOS          (RAMEND > 0x10FF ? 50 : 18)
#define RETURN_DELAY_US 20
#define SPEED           300
#define EVENTS          20
#define WAITING         4

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static struct cds_queue queue;
static struct cds_servos servos;
static struct cds_servo_state states[SERVOS];
static struct cds_cycle cycle;
static uint8_t ids[SERVOS];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(SERVOS)];
static struct cds_feedback feedback[SERVOS];
static struct cds_health health;
static struct cds_torque_off torque_off;
static bool is_cycling, is_torque_off;

/* Recorded changes. */
static struct {
    uint32_t us;
    uint8_t id, inhibits, presence;
} events[EVENTS];
static uint8_t event_count;
static struct {
    uint8_t inhibits, presence;
} seen[SERVOS];
static uint16_t seen_epoch;
static uint8_t seen_news;

static uint8_t packet_buffers[WAITING][CDS_SYNC_WRITE_SIZE(2, 4)];
static uint8_t replies[WAITING][8];
static struct cds_request requests[WAITING];

/* A line of the PC, and the number of bytes received. Its handler delays the handlers of the bus by
 * 4 us, so the servos have a return delay of 20 us. */
static volatile uint8_t heard;
static char line[24];

ISR(CDS_AVR_VECTOR(BOARD_HOST_USART, RX))
{
    uint8_t byte = SAY_DATA;

    line[heard] = byte == '\n' ? 0 : (char)byte;
    if (heard < sizeof line - 1)
        heard++;
}

static void see(uint8_t i)
{
    seen[i].inhibits = cds_servos_inhibits(&servos, &states[i]);
    seen[i].presence = states[i].presence;
}

static bool has_changed(uint8_t i)
{
    return seen[i].inhibits != cds_servos_inhibits(&servos, &states[i]) ||
           seen[i].presence != states[i].presence;
}

/* Clears counters and recorded changes. */
static void begin_anew(void)
{
    memset(&cycle.counters, 0, sizeof cycle.counters);
    for (uint8_t i = 0; i < SERVOS; i++)
        see(i);
    event_count = 0;
}

static void note_events(void)
{
    if (seen_epoch == servos.epoch && seen_news == servos.event_count)
        return;
    seen_epoch = servos.epoch;
    seen_news = servos.event_count;
    for (uint8_t i = 0; i < SERVOS; i++) {
        if (!has_changed(i))
            continue;
        see(i);
        if (event_count == EVENTS)
            continue;
        events[event_count].us = cds_port_now_us();
        events[event_count].id = states[i].id;
        events[event_count].inhibits = seen[i].inhibits;
        events[event_count++].presence = seen[i].presence;
    }
}

static void turn(void)
{
    cds_bus_poll(&bus);
    if (is_cycling && cds_cycle_poll(&cycle) == CDS_OK)
        is_cycling = false;
    cds_health_poll(&health);
    if (is_torque_off && cds_torque_off_poll(&torque_off) != CDS_PENDING)
        is_torque_off = false;
    note_events();
}

/* ---- what is asked for ---- */

/* Goals that all go out together; says how many were taken. */
static void set_goals(uint16_t position)
{
    uint8_t taken = 0;

    for (uint8_t i = 0; i < SERVOS; i++)
        if (cds_cycle_goal(&cycle, i, position, SPEED) == CDS_OK)
            taken++;
    say("taken", taken);
    cds_cycle_commit(&cycle);
}

static void begin_cycle(uint16_t position)
{
    say("cycle",
        cds_cycle_begin(&cycle, &(struct cds_cycle_config){.bus = &bus,
                                                           .ids = ids,
                                                           .packets = packets,
                                                           .feedback = feedback,
                                                           .count = SERVOS,
                                                           .period_us = CDS_CYCLE_PERIOD_US}));
    set_goals(position);
    is_cycling = true;
}

static void begin_health(uint16_t period_ms)
{
    cds_health_begin(
        &health, &(struct cds_health_config){.servos = &servos, .period_us = 1000ul * period_ms});
    say("health", cds_health_set_cycle(&health, is_cycling ? &cycle : NULL));
}

/* The queue is full of packets that drive when torque off begins. */
static void fill_queue_and_begin_torque_off(void)
{
    static const uint8_t on = 1;

    cds_servo_ping(&bus, &requests[0], 1);
    requests[2].priority = CDS_PRIORITY_HIGH;
    cds_servo_write(&bus, &requests[1], CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, &on, 1);
    cds_servo_write_word(&bus, &requests[2], 2, CDS_REG_GOAL_POSITION, 900);
    cds_servo_ping(&bus, &requests[3], 3);
    cds_torque_off_begin(&torque_off, &servos);
    is_torque_off = true;
}

static enum cds_result sync_goals(const uint16_t *goal)
{
    cds_sync_write_begin(&requests[0], CDS_REG_GOAL_POSITION, 4);
    cds_sync_write_add_goal(&requests[0], 1, goal[0], goal[1]);
    cds_sync_write_add_goal(&requests[0], 2, goal[2], goal[3]);
    return cds_sync_write_send(&bus, &requests[0]);
}

/* A goal and its speed in one WRITE. */
static enum cds_result write_goal(uint8_t id, uint16_t position, uint16_t speed)
{
    const uint8_t data[4] = {(uint8_t)position, (uint8_t)(position >> 8), (uint8_t)speed,
                             (uint8_t)(speed >> 8)};

    return cds_servo_write(&bus, &requests[0], id, CDS_REG_GOAL_POSITION, data, sizeof data);
}

static void see_through(enum cds_result submitted)
{
    say("submitted", submitted);
    while (requests[0].result == CDS_PENDING)
        turn();
    say("result", requests[0].result);
}

static void say_torque_off(void)
{
    say("result", torque_off.steps.result);
    say("broadcasts", torque_off.broadcasts);
    for (uint8_t i = 0; i < SERVOS; i++)
        say("outcome", states[i].torque_off);
    for (uint8_t i = 0; i < WAITING; i++)
        say("waiting", requests[i].result);
}

static void say_events(void)
{
    for (uint8_t i = 0; i < event_count; i++) {
        say("event", events[i].us);
        say("id", events[i].id);
        say("inhibits", events[i].inhibits);
        say("presence", events[i].presence);
    }
}

static void say_counters(void)
{
    struct cds_stats stats;

    cds_bus_stats(&bus, &stats);
    say("periods", cycle.counters.periods);
    say("missed", cycle.counters.missed);
    say("unsent", cycle.counters.unsent);
    say("dropped", cycle.counters.dropped);
    say("sent", stats.sent);
    say("ok", stats.ok);
    say("timeouts", stats.timeouts);
    say("corrupt", stats.corrupt);
    say("line_busy", stats.line_busy);
    say("overruns", stats.overruns);
}

static struct cds_servo_state *named(uint16_t id)
{
    return cds_servos_find(&servos, (uint8_t)id);
}

static void release(uint8_t id)
{
    if (id)
        cds_servos_release(&servos, named(id));
    else
        cds_servos_release_all(&servos);
}

static void obey(char letter, const uint16_t *number)
{
    uint8_t id = (uint8_t)number[0], address = (uint8_t)number[1];

    switch (letter) {
    case 'c': begin_cycle(number[0]); break;
    case 'g': set_goals(number[0]); break;
    case 'x': cds_cycle_abort(&cycle); break;
    case 'w': begin_health(number[0]); break;
    case 's': fill_queue_and_begin_torque_off(); break;
    case 'o': say_torque_off(); break;
    case 'e': say_events(); break;
    case 'z': begin_anew(); break;
    case 'n': say_counters(); break;
    case 'r': release(id); break;
    case 'l':
        say("limits", cds_servos_set_limits(&servos, named(id), number[1], number[2], number[3]));
        break;
    case 'a': say("alarms", cds_servos_acknowledge(&servos, id ? named(id) : NULL)); break;
    case 'q':
        say("latched", states[id - 1].alarms);
        say("of_all", servos.alarms);
        break;
    case 'b':
        see_through(cds_servo_write_byte(&bus, &requests[0], id, address, (uint8_t)number[2]));
        break;
    case 'd': see_through(cds_servo_write_word(&bus, &requests[0], id, address, number[2])); break;
    case 'v': see_through(write_goal(id, number[1], number[2])); break;
    case 'p': see_through(cds_servo_ping(&bus, &requests[0], id)); break;
    case 'y': see_through(sync_goals(number)); break;
    case 't':
        see_through(cds_servo_read(&bus, &requests[0], id, address, (uint8_t)number[2]));
        break;
    default: say_text("error 30: letter\n"); return;
    }
    say_text("ok\n");
}

static void obey_line(void)
{
    uint16_t number[4] = {0};
    uint8_t count = 0;

    for (uint8_t i = 1; line[i]; i++) {
        if (line[i] == ' ')
            count++;
        else if (count >= 1 && count <= 4)
            number[count - 1] = (uint16_t)(number[count - 1] * 10u + (uint8_t)(line[i] - '0'));
    }
    heard = 0;
    obey(line[0], number);
}

int main(void)
{
    say_open();
    SAY_CONTROL = SAY_TXEN | SAY_RXEN | SAY_RXC; // the last one is RXCIE there
    cds_avr_clock_open();
    sei();
    for (uint8_t i = 0; i < SERVOS; i++)
        ids[i] = states[i].id = (uint8_t)(i + 1);
    for (uint8_t i = 0; i < WAITING; i++)
        requests[i] = (struct cds_request)CDS_REQUEST(packet_buffers[i], replies[i]);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_return_delay(&bus, RETURN_DELAY_US);
    cds_servos_begin(
        &servos,
        &(struct cds_servos_config){
            .bus = &bus, .queue = &queue, .states = states, .count = SERVOS, .capacity = SERVOS});
    cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID, CDS_REG_RETURN_DELAY,
                         RETURN_DELAY_US / 2);
    while (requests[0].result == CDS_PENDING)
        turn();
    for (;;) {
        turn();
        if (heard && line[heard - 1] == 0)
            obey_line();
    }
}
