/* A gait of 18 joints at 250 Hz, with feedback and the permit. Byte 0 of the EEPROM: sines of each
 * joint, 1 or 3. While the gait is checked, MARK_SLOW is cds_gait_poll(); then MARK_POLL is.
 * MARK_CALL is cds_cycle_goal() for six joints. */
#include <cds55xx/gait.h>

#include "benchmark.h"

#define JOINTS 18

#define ONE(turn)                                                                                  \
    {                                                                                              \
        .rest = 512, .sines = { {.amplitude = 100, .multiple = 1, .phase = CDS_GAIT_PHASE(turn)} } \
    }
#define THREE(turn)                                                                                \
    {                                                                                              \
        .rest = 512, .sines = {                                                                    \
            {.amplitude = 60, .multiple = 1, .phase = CDS_GAIT_PHASE(turn)},                       \
            {.amplitude = -30, .multiple = 2, .wave = CDS_GAIT_LIFT, .group = 1},                  \
            {.amplitude = 10, .multiple = 3, .phase = CDS_GAIT_PHASE(turn), .group = 2}            \
        }                                                                                          \
    }
#define ALL(shape)                                                                                 \
    shape(0), shape(20), shape(40), shape(60), shape(80), shape(100), shape(120), shape(140),      \
        shape(160), shape(180), shape(200), shape(220), shape(240), shape(260), shape(280),        \
        shape(300), shape(320), shape(340)

CDS_GAIT_TABLE(of_one_sine) = {ALL(ONE)};
CDS_GAIT_TABLE(of_three_sines) = {ALL(THREE)};

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static struct cds_servos servos;
static struct cds_servo_state states[JOINTS];
static struct cds_cycle cycle;
static struct cds_feedback feedback[JOINTS];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(JOINTS)], ids[JOINTS];
static struct cds_gait gait;
static struct cds_gait_state joints[JOINTS];

static void begin(void)
{
    for (uint8_t i = 0; i < JOINTS; i++)
        states[i].id = ids[i] = (uint8_t)(i + 1);
    say("servos",
        cds_servos_begin(&servos, &(struct cds_servos_config){.bus = &bus,
                                                              .queue = &bench_queue,
                                                              .states = states,
                                                              .count = JOINTS,
                                                              .capacity = JOINTS}) == CDS_OK);
    say("cycle", cds_cycle_begin(&cycle, &(struct cds_cycle_config){
                                             .bus = &bus,
                                             .ids = ids,
                                             .packets = packets,
                                             .feedback = feedback,
                                             .count = JOINTS,
                                             .period_us = CDS_CYCLE_PERIOD_US}) == CDS_OK);
}

static void torque_on(void)
{
    static uint8_t packet[CDS_PACKET_SIZE(2)];
    static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);

    cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1);
    bench_wait(&bus);
}

/* Reads all joints, then sends them where they are. */
static void begin_goals(void)
{
    while (cycle.counters.reads < JOINTS) {
        cds_bus_poll(&bus);
        cds_cycle_poll(&cycle);
    }
    for (uint8_t i = 0; i < JOINTS; i++)
        cds_cycle_goal(&cycle, i, feedback[i].position, 512);
    cds_cycle_commit(&cycle);
}

static void poll(void)
{
    cds_bus_poll(&bus);
    cds_cycle_poll(&cycle);
    if (gait.is_under_way) {
        mark(MARK_POLL);
        cds_gait_poll(&gait);
        unmark(MARK_POLL);
    } else {
        mark(MARK_SLOW);
        cds_gait_poll(&gait);
        unmark(MARK_SLOW);
    }
}

/* Returns 1 if the gait ends in the rest positions. */
static uint8_t walk(uint8_t sines)
{
    cds_gait_begin(&gait,
                   &(struct cds_gait_config){.cycle = &cycle,
                                             .servos = &servos,
                                             .joints = sines == 1 ? of_one_sine : of_three_sines,
                                             .states = joints,
                                             .period_ms = 1000,
                                             .ramp_ms = 1000});
    while (gait.result == CDS_PENDING) {
        poll();
        if (cycle.counters.periods == 1000)
            cds_gait_stop(&gait);
    }
    return gait.result == CDS_OK;
}

/* Returns CDS_BUSY while the goals before are sent. */
static enum cds_result set_six_goals(void)
{
    enum cds_result result = CDS_OK;

    mark(MARK_CALL);
    for (uint8_t i = 0; i < 6; i++)
        result = cds_cycle_goal(&cycle, i, 500, 500);
    unmark(MARK_CALL);
    return result;
}

int main(void)
{
    bench_open_bare(&bus);
    torque_on();
    begin();
    begin_goals();
    say("walked", walk(bench_option(0)));
    while (set_six_goals() != CDS_OK)
        poll();
    say("missed", cycle.counters.missed);
    say("unsent", cycle.counters.unsent);
    say("periods", cycle.counters.periods);
    say("reads", cycle.counters.reads);
    say_end();
}
