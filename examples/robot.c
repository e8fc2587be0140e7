/* A robot of servos 1 to 12 that walks on the spot: goals at 250 Hz, feedback of all, soft limits,
 * a state check, and torque off for all as soon as something is wrong. Put your own gait into
 * gait(). Nothing here waits once it walks. */
#include <cds55xx/cds55xx.h>
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

static uint8_t packet[CDS_PACKET_SIZE(5)], reply[4];
static struct cds_request request = CDS_REQUEST(packet, reply);
static struct cds_queue queue;
static struct cds_servos servos;
static struct cds_servo_state states[SERVOS];
static struct cds_cycle cycle;
static struct cds_feedback feedback[SERVOS];
static struct cds_health health;
static struct cds_torque_off torque_off;
static uint8_t ids[SERVOS];

/* Reads 4 bytes from `address` on, for the permit: it lets no torque be switched on before it knows
 * mode, goal and speed of a servo with limits. */
static bool read_4(uint8_t i, uint8_t address)
{
    return cds_blocking_read(&bus, &request, ids[i], address, 4) == CDS_OK;
}

static bool set_return_delay(uint8_t i)
{
    static struct cds_setup setup;
    struct cds_setup_config config = {.bus = &bus,
                                      .request = &request,
                                      .id = ids[i],
                                      .setting = CDS_SETUP_RETURN_DELAY,
                                      .return_delay_us = RETURN_DELAY_US};

    return cds_blocking_setup(&setup, &config) == CDS_OK;
}

/* The servo goes to its goal as soon as its torque is on: the goal becomes `position`. Goal and
 * speed are one packet, since the permit checks both. */
static bool set_goal(uint8_t i, uint16_t position)
{
    uint8_t goal[] = {(uint8_t)position, (uint8_t)(position >> 8), FASTEST & 0xFF, FASTEST >> 8};

    return cds_blocking_write(&bus, &request, ids[i], CDS_REG_GOAL_POSITION, goal, sizeof goal) ==
           CDS_OK;
}

/* True if servo `i` answers quickly, is in position mode and within its limits. Its first goal is
 * its position. */
static bool prepare(uint8_t i)
{
    uint16_t position;

    return set_return_delay(i) && read_4(i, CDS_REG_CW_ANGLE_LIMIT) &&
           cds_blocking_read_word(&bus, &request, ids[i], CDS_REG_PRESENT_POSITION, &position) ==
               CDS_OK &&
           set_goal(i, position) && read_4(i, CDS_REG_GOAL_POSITION) &&
           cds_cycle_goal(&cycle, i, position, FASTEST) == CDS_OK;
}

static void begin(void)
{
    static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(SERVOS)];

    for (uint8_t i = 0; i < SERVOS; i++)
        states[i].id = ids[i] = (uint8_t)(i + 1);
    cds_servos_begin(
        &servos,
        &(struct cds_servos_config){
            .bus = &bus, .queue = &queue, .states = states, .count = SERVOS, .capacity = SERVOS});
    cds_queue_set_retries(&queue, 2);
    cds_cycle_begin(&cycle, &(struct cds_cycle_config){.bus = &bus,
                                                       .ids = ids,
                                                       .packets = packets,
                                                       .feedback = feedback,
                                                       .count = SERVOS,
                                                       .period_us = CDS_CYCLE_PERIOD_US});
}

/* Torque on for all servos, or for none if one of them is not well. */
static bool stand_up(void)
{
    for (uint8_t i = 0; i < SERVOS; i++) {
        cds_servos_set_limits(&servos, &states[i], LOWEST, HIGHEST, FASTEST);
        if (!prepare(i))
            return false;
    }
    cds_bus_set_return_delay(&bus, RETURN_DELAY_US);
    cds_health_begin(
        &health, &(struct cds_health_config){.servos = &servos, .period_us = CDS_HEALTH_PERIOD_US});
    cds_health_set_cycle(&health, &cycle);
    cds_cycle_commit(&cycle);
    while (!cycle.counters.periods) { // until the servos have the goals that they are at
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

/* True after an alarm, if a servo does not answer any more, or if a servo is inhibited, as after a
 * moment without power. */
static bool anything_wrong(void)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        if (states[i].presence == CDS_PRESENCE_OFFLINE)
            return true;
    return servos.alarms || !cds_servos_may_drive(&servos, CDS_BROADCAST_ID);
}

static void walk(void)
{
    uint16_t now = 0;

    while (!anything_wrong()) {
        cds_bus_poll(&bus);
        cds_cycle_poll(&cycle);
        cds_health_poll(&health);
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
    begin();
    if (stand_up())
        walk();
    cds_cycle_abort(&cycle);
    cds_torque_off_begin(&torque_off, &servos);
    for (;;) { // until power is switched off
        cds_bus_poll(&bus);
        cds_cycle_poll(&cycle);
        cds_torque_off_poll(&torque_off);
    }
}
