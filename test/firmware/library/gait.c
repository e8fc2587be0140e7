/* 18 joints, 6 legs of coxa, femur and tibia, walk in a tripod gait: forwards, then they turn, then
 * they stop. Prints how the gait ended. A joint that does not follow aborts the gait; then torque
 * is switched off. */
#include <cds55xx/follow.h>
#include <cds55xx/gait.h>
#include <cds55xx/queue.h>
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>

#include "say.h"

#define JOINTS       18
#define WALK_PERIODS 750
#define TURN_PERIODS 750
#define DECELERATION 8000

enum { LEFT, RIGHT, LIFT };

/* The foot is in the air in the first half of the turn that begins at `degrees`; meanwhile the coxa
 * swings forwards. */
#define LEG(side, forwards, degrees)                                                               \
    {.rest = 512,                                                                                  \
     .sines = {{.amplitude = forwards,                                                             \
                .phase = CDS_GAIT_PHASE(degrees + 270),                                            \
                .multiple = 1,                                                                     \
                .group = side}}},                                                                  \
        {.rest = 400,                                                                              \
         .sines = {{.amplitude = 70,                                                               \
                    .phase = CDS_GAIT_PHASE(degrees),                                              \
                    .multiple = 1,                                                                 \
                    .wave = CDS_GAIT_LIFT,                                                         \
                    .group = LIFT}}},                                                              \
    {                                                                                              \
        .rest = 600, .sines = {                                                                    \
            {.amplitude = 40,                                                                      \
             .phase = CDS_GAIT_PHASE(degrees),                                                     \
             .multiple = 1,                                                                        \
             .wave = CDS_GAIT_LIFT,                                                                \
             .group = LIFT}                                                                        \
        }                                                                                          \
    }

CDS_GAIT_TABLE(tripod) = {LEG(LEFT, 80, 0),     LEG(LEFT, 80, 180), LEG(LEFT, 80, 0),
                          LEG(RIGHT, -80, 180), LEG(RIGHT, -80, 0), LEG(RIGHT, -80, 180)};

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static struct cds_queue queue;
static struct cds_servos servos;
static struct cds_servo_state servo_states[JOINTS];
static struct cds_cycle cycle;
static struct cds_feedback feedback[JOINTS];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(JOINTS)], ids[JOINTS];
static struct cds_gait gait;
static struct cds_gait_state states[JOINTS];
static struct cds_follow follow;
static struct cds_follow_joint followed[JOINTS];

static void set_torque(uint8_t is_on)
{
    static uint8_t packet[CDS_PACKET_SIZE(2)];
    static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);

    cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, is_on);
    while (request.result == CDS_PENDING)
        cds_bus_poll(&bus);
}

static void poll(void)
{
    cds_bus_poll(&bus);
    cds_cycle_poll(&cycle);
}

static void begin(void)
{
    for (uint8_t i = 0; i < JOINTS; i++)
        servo_states[i].id = ids[i] = (uint8_t)(i + 1);
    set_torque(1);
    cds_servos_begin(&servos, &(struct cds_servos_config){.bus = &bus,
                                                          .queue = &queue,
                                                          .states = servo_states,
                                                          .count = JOINTS,
                                                          .capacity = JOINTS});
    cds_cycle_begin(&cycle, &(struct cds_cycle_config){.bus = &bus,
                                                       .ids = ids,
                                                       .packets = packets,
                                                       .feedback = feedback,
                                                       .count = JOINTS,
                                                       .period_us = CDS_CYCLE_PERIOD_US});
    cds_follow_begin(&follow, &(struct cds_follow_config){.cycle = &cycle, .joints = followed});
    while (cycle.counters.reads < 2 * JOINTS)
        poll();
    cds_gait_begin(&gait, &(struct cds_gait_config){.cycle = &cycle,
                                                    .servos = &servos,
                                                    .joints = tripod,
                                                    .states = states,
                                                    .period_ms = 1000,
                                                    .ramp_ms = 1000});
}

/* What the robot does in which period. */
static void steer(void)
{
    if (cycle.counters.periods == WALK_PERIODS)
        cds_gait_set_scale(&gait, RIGHT, -100);
    if (cycle.counters.periods == WALK_PERIODS + TURN_PERIODS)
        cds_gait_stop(&gait);
}

static void walk(void)
{
    while (cds_gait_poll(&gait) == CDS_PENDING) {
        poll();
        steer();
        if (cds_follow_poll(&follow) == CDS_TIMEOUT && !gait.is_ending) {
            say("stuck", follow.joint);
            cds_gait_abort(&gait, DECELERATION);
        }
    }
    if (follow.result == CDS_PENDING)
        return;
    cds_cycle_abort(&cycle);
    while (cds_cycle_poll(&cycle) == CDS_PENDING)
        cds_bus_poll(&bus);
    set_torque(0);
    say("torque_off", 1);
}

int main(void)
{
    uint32_t end;

    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    begin();
    walk();
    end = cycle.counters.periods + 75;
    while (follow.result == CDS_PENDING && cycle.counters.periods != end)
        poll();
    say("result", gait.result);
    say("joint", gait.joint);
    say("missed", cycle.counters.missed);
    say("oldest_us", cycle.counters.oldest_us);
    say_end();
}
