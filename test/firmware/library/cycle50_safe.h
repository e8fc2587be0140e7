/* SPDX-License-Identifier: MIT */
/* What cycle50_safe.c adds to cycle50.c, which includes it. */
#include <cds55xx/blocking.h>
#include <cds55xx/health.h>

#define LOWEST  256
#define HIGHEST 767
#define FASTEST SPEED
#define MIDDLE  512
#define RETRIES 2

static struct cds_servos servos;
static struct cds_servo_state states[SERVOS_MAX];
static struct cds_health health;

/* Reads mode, goal and speed of servo `id`, so that its limits can be checked. */
static bool prepare(uint8_t id)
{
    static const uint8_t goal[] = {MIDDLE & 0xFF, MIDDLE >> 8, FASTEST & 0xFF, FASTEST >> 8};
    static uint8_t packet[CDS_PACKET_SIZE(5)], reply[4];
    static struct cds_request request = CDS_REQUEST(packet, reply);

    return cds_blocking_read(&bus, &request, id, CDS_REG_CW_ANGLE_LIMIT, 4) == CDS_OK &&
           cds_blocking_for(&bus, &request,
                            cds_servo_write(&bus, &request, id, CDS_REG_GOAL_POSITION, goal, 4)) ==
               CDS_OK &&
           cds_blocking_read(&bus, &request, id, CDS_REG_GOAL_POSITION, 4) == CDS_OK &&
           cds_blocking_write_byte(&bus, &request, id, CDS_REG_TORQUE_ENABLE, 1) == CDS_OK;
}

static void begin_servos(void)
{
    uint8_t prepared = 0;

    for (uint8_t i = 0; i < servo_count; i++)
        states[i].id = ids[i];
    say("servos",
        cds_servos_begin(&servos, &(struct cds_servos_config){.bus = &bus,
                                                              .queue = &queue,
                                                              .states = states,
                                                              .count = servo_count,
                                                              .capacity = servo_count}) == CDS_OK);
    cds_queue_set_retries(&queue, RETRIES);
    for (uint8_t i = 0; i < servo_count; i++) {
        cds_servos_set_limits(&servos, &states[i], LOWEST, HIGHEST, FASTEST);
        if (prepare(ids[i]))
            prepared++;
    }
    say("prepared", prepared);
}

static void begin_health(void)
{
    cds_health_begin(
        &health, &(struct cds_health_config){.servos = &servos, .period_us = CDS_HEALTH_PERIOD_US});
    cds_health_set_cycle(&health, &cycle);
}

static void poll_health(void)
{
    cds_health_poll(&health);
}

static void say_health(void)
{
    say("alarms", servos.alarms);
}

/* Returns the number of reply bytes after which to poll; the health check reads one register. */
static uint8_t most(void)
{
    return health.request.result == CDS_PENDING ? CDS_PACKET_SIZE(1) - 4 : MOST;
}
