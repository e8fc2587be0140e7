/* A robot that can be stopped: a cycle of servos 1 to SERVOS, the state check beside it, torque off
 * for all, soft limits. A line from the PC is a letter and numbers; each is answered with "ok" as
 * soon as it was read, while the main loop turns. What became of the servos is noted with its time,
 * and said when it is asked for. */
#include <cds55xx/sync_write.h>
#include <cds55xx/servo.h>
#include <cds55xx/torque_off.h>
#include <cds55xx/health.h>
#include <cds55xx_avr.h>
#include <string.h>

#include "say.h"

#define SERVOS          (RAMEND > 0x10FF ? 50 : 18)
#define RETURN_DELAY_US 20
#define SPEED           300
#define EVENTS          20
#define WAITING         4
#define REPLY           12

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static struct cds_servos servos;
static struct cds_servo_state states[SERVOS];
static struct cds_queue queue;
static struct cds_cycle cycle;
static uint8_t ids[SERVOS];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(SERVOS)];
static struct cds_feedback feedback[SERVOS];
static struct cds_health watch;
static struct cds_torque_off stop;
static bool cycling, watching, stopping;

/* What changed, and when. */
static struct {
    uint32_t us;
    uint8_t id, held, presence;
} events[EVENTS];
static uint8_t event_count;
static struct {
    uint8_t held, presence;
} seen[SERVOS];
static uint16_t seen_changes;

static uint8_t buffers[WAITING][CDS_SYNC_WRITE_SIZE(2, 4)], replies[WAITING][REPLY];
static struct cds_request requests[WAITING];

/* A line of the PC, and how many bytes of it came. The handler holds up those of the bus by 4 us,
 * so the servos are told to wait for 20. */
static volatile uint8_t heard;
static char line[24];

ISR(AVR_VECTOR(BOARD_HOST_USART, RX))
{
    uint8_t byte = SAY_DATA;

    line[heard] = byte == '\n' ? 0 : (char)byte;
    if (heard < sizeof line - 1)
        heard++;
}

/* From here on it counts. */
static void begin_anew(void)
{
    memset(&cycle.counters, 0, sizeof cycle.counters);
    for (uint8_t i = 0; i < SERVOS; i++) {
        seen[i].held = cds_servos_inhibits(&servos, &states[i]);
        seen[i].presence = states[i].presence;
    }
    event_count = 0;
}

static void note_events(void)
{
    uint16_t changes = (uint16_t)(servos.epoch + servos.news);

    if (seen_changes == changes)
        return;
    seen_changes = changes;
    for (uint8_t i = 0; i < SERVOS; i++) {
        if (seen[i].held == cds_servos_inhibits(&servos, &states[i]) &&
            seen[i].presence == states[i].presence)
            continue;
        seen[i].held = cds_servos_inhibits(&servos, &states[i]);
        seen[i].presence = states[i].presence;
        if (event_count == EVENTS)
            continue;
        events[event_count].us = cds_port_now_us();
        events[event_count].id = states[i].id;
        events[event_count].held = cds_servos_inhibits(&servos, &states[i]);
        events[event_count++].presence = states[i].presence;
    }
}

static void turn(void)
{
    cds_bus_poll(&bus);
    if (cycling && cds_cycle_poll(&cycle) == CDS_OK)
        cycling = false;
    if (watching)
        cds_health_poll(&watch);
    if (stopping && cds_torque_off_poll(&stop) != CDS_PENDING)
        stopping = false;
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
    say("commit", cds_cycle_commit(&cycle));
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
    cycling = true;
}

static void begin_watch(uint16_t period_ms)
{
    cds_health_begin(
        &watch, &(struct cds_health_config){.servos = &servos, .period_us = 1000ul * period_ms});
    say("watch", cds_health_set_cycle(&watch, cycling ? &cycle : NULL));
    watching = true;
}

/* The queue is full of what drives when all is to stop. */
static void fill_and_stop(void)
{
    static const uint8_t on = 1;

    cds_servo_ping(&bus, &requests[0], 1);
    requests[2].priority = CDS_PRIORITY_HIGH;
    cds_servo_write(&bus, &requests[1], CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, &on, 1);
    cds_servo_write_word(&bus, &requests[2], 2, CDS_REG_GOAL_POSITION, 900);
    cds_servo_ping(&bus, &requests[3], 3);
    cds_torque_off_begin(&stop, &servos);
    stopping = true;
}

static enum cds_result sync_goals(const uint16_t *goal)
{
    cds_sync_write_begin(&requests[0], CDS_REG_GOAL_POSITION, 4);
    cds_sync_write_add_goal(&requests[0], 1, goal[0], goal[1]);
    cds_sync_write_add_goal(&requests[0], 2, goal[2], goal[3]);
    return cds_sync_write_send(&bus, &requests[0]);
}

static void see_through(enum cds_result submitted)
{
    say("submitted", submitted);
    while (requests[0].result == CDS_PENDING)
        turn();
    say("result", requests[0].result);
}

static void say_stop(void)
{
    say("result", stop.steps.result);
    say("broadcasts", stop.broadcasts);
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
        say("held", events[i].held);
        say("presence", events[i].presence);
    }
}

static void say_counters(void)
{
    struct cds_stats count;

    cds_bus_stats(&bus, &count);
    say("periods", cycle.counters.periods);
    say("missed", cycle.counters.missed);
    say("unsent", cycle.counters.unsent);
    say("dropped", cycle.counters.dropped);
    say("sent", count.sent);
    say("ok", count.ok);
    say("timeouts", count.timeouts);
    say("corrupt", count.corrupt);
    say("unsent_by_bus", count.line_busy);
    say("overruns", count.overruns);
}

static struct cds_servo_state *named(uint16_t id)
{
    return cds_servos_find(&servos, (uint8_t)id);
}

static void obey(char letter, const uint16_t *number)
{
    uint8_t id = (uint8_t)number[0], address = (uint8_t)number[1];

    switch (letter) {
    case 'c': begin_cycle(number[0]); break;
    case 'g': set_goals(number[0]); break;
    case 'x': cds_cycle_abort(&cycle); break;
    case 'w': begin_watch(number[0]); break;
    case 's': fill_and_stop(); break;
    case 'o': say_stop(); break;
    case 'e': say_events(); break;
    case 'z': begin_anew(); break;
    case 'n': say_counters(); break;
    case 'r':
        if (id)
            cds_servos_release(&servos, named(id));
        else
            cds_servos_release_all(&servos);
        break;
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
        requests[i] = (struct cds_request)CDS_REQUEST(buffers[i], replies[i]);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_return_delay(&bus, RETURN_DELAY_US);
    cds_servos_begin(
        &servos,
        &(struct cds_servos_config){
            .bus = &bus, .queue = &queue, .states = states, .count = SERVOS, .capacity = SERVOS});
    cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID, CDS_REG_RETURN_DELAY,
                         RETURN_DELAY_US / 2);
    for (;;) {
        turn();
        if (heard && line[heard - 1] == 0)
            obey_line();
    }
}
