/* A robot of servos 1 to 12 that walks on the spot: goals at 250 Hz, feedback of all, soft limits,
 * a state check, and torque off for all as soon as something is wrong. Put your own gait into
 * gait(). Nothing here waits once it walks. */
#include <cds55xx/cycle.h>
#include <cds55xx/servos.h>
#include <cds55xx/setup.h>
#include <cds55xx/torque_off.h>
#include <cds55xx/blocking.h>
#include <cds55xx/health.h>
#include <cds55xx_avr.h>
#include <util/delay.h>

#define SERVOS          12
#define LOWEST          300 // soft limits: 88 to 212 degrees, 31 RPM
#define HIGHEST         724
#define FASTEST         512
#define RETURN_DELAY_US 10 // of the servos; what this controller needs

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_FEEDBACK_SIZE];
static struct cds_request request = CDS_REQUEST(packet);
static struct cds_servos roster;
static struct cds_servo_state servos[SERVOS];
static struct cds_cycle cycle;
static struct cds_feedback feedback[SERVOS];
static struct cds_health watch;
static struct cds_torque_off stop;
static uint8_t ids[SERVOS];

static bool read_word(uint8_t i, uint8_t address, uint16_t *value)
{
    return cds_blocking_read_word(&bus, &request, ids[i], address, value) == CDS_OK;
}

static bool write_word(uint8_t i, uint8_t address, uint16_t value)
{
    return cds_blocking_write_word(&bus, &request, ids[i], address, value) == CDS_OK;
}

/* Is servo `i` there, quick to answer, in position mode, and within its limits? Its first goal is
 * where it is: the one it holds itself too, as that is where it goes when it is switched on. */
static bool prepare(uint8_t i)
{
    static struct cds_setup setup;
    uint16_t limit, position;

    if (cds_setup_return_delay_begin(&setup, &bus, &request, ids[i], RETURN_DELAY_US) != CDS_OK)
        return false;
    while (cds_setup_poll(&setup) == CDS_PENDING)
        cds_bus_poll(&bus);
    return setup.result == CDS_OK &&
           read_word(i, CDS_REG_CCW_ANGLE_LIMIT, &limit) && // 0: the roster refuses what follows
           read_word(i, CDS_REG_PRESENT_POSITION, &position) &&
           write_word(i, CDS_REG_MOVING_SPEED, FASTEST) &&
           write_word(i, CDS_REG_GOAL_POSITION, position) &&
           cds_cycle_goal(&cycle, i, position, FASTEST) == CDS_OK;
}

/* All servos or none: who is not well now will not be when the robot stands on it. */
static bool stand_up(void)
{
    static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(SERVOS)];

    for (uint8_t i = 0; i < SERVOS; i++)
        servos[i].id = ids[i] = (uint8_t)(i + 1);
    cds_bus_set_repeats(&bus, 2);
    cds_servos_begin(&roster, &bus, servos, SERVOS);
    cds_cycle_begin(&cycle, &bus, ids, SERVOS, packets, feedback, CDS_CYCLE_PERIOD_US);
    for (uint8_t i = 0; i < SERVOS; i++) {
        cds_servos_set_limits(&roster, &servos[i], LOWEST, HIGHEST, FASTEST);
        if (!prepare(i))
            return false;
    }
    cds_bus_set_return_delay(&bus, RETURN_DELAY_US);
    cds_health_begin(&watch, &roster, CDS_HEALTH_PERIOD_US);
    cds_health_set_cycle(&watch, &cycle);
    cds_cycle_commit(&cycle);
    while (!cycle.counters.periods) { // who is switched on stays where it is
        cds_bus_poll(&bus);
        cds_cycle_poll(&cycle);
    }
    return cds_blocking_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1) ==
           CDS_OK;
}

/* Goals of period `now`: each servo swings about the middle, its neighbours the other way. */
static void gait(uint16_t now)
{
    uint16_t phase = now & 0x1FF, swing = phase < 0x100 ? phase : 0x200 - phase;

    for (uint8_t i = 0; i < SERVOS; i++)
        cds_cycle_goal(&cycle, i, i & 1 ? 384 + swing : 640 - swing, FASTEST);
    cds_cycle_commit(&cycle);
}

/* An alarm, a servo that does not answer any more, or one that is held: it lost its power for a
 * moment, say. */
static bool anything_wrong(void)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        if (servos[i].presence == CDS_PRESENCE_OFFLINE)
            return true;
    return roster.alarms || !cds_servos_may_drive(&roster, CDS_BROADCAST_ID);
}

static void walk(void)
{
    uint16_t now = 0;

    while (!anything_wrong()) {
        cds_bus_poll(&bus);
        cds_cycle_poll(&cycle);
        cds_health_poll(&watch);
        if ((uint16_t)cycle.counters.periods != now) {
            now = (uint16_t)cycle.counters.periods;
            gait(now);
        }
    }
}

int main(void)
{
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    _delay_ms(1000); // the servos start up
    if (stand_up())
        walk();
    cds_cycle_stop(&cycle);
    cds_torque_off_begin(&stop, &roster);
    for (;;) { // until somebody has looked, and switches off and on
        cds_bus_poll(&bus);
        cds_cycle_poll(&cycle);
        cds_torque_off_poll(&stop);
    }
}
