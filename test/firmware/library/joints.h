/* SPDX-License-Identifier: MIT */
/* Shared by programs with a motion or a gait: servos 1 to `count` on bus 0 with limits, and a
 * cycle. A program may define JOINTS, the most servos, before it includes this file. */
#ifndef JOINTS_H
#define JOINTS_H

#include <cds55xx/cycle.h>
#include <cds55xx/queue.h>
#include <cds55xx/servo.h>
#include <cds55xx/servos.h>
#include <cds55xx/avr.h>

#ifndef JOINTS
#define JOINTS 18
#endif

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static struct cds_servos servos;
static struct cds_servo_state servo_states[JOINTS];
static struct cds_cycle cycle;
static struct cds_feedback feedback[JOINTS];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(JOINTS)], ids[JOINTS];

static inline void joints_set_torque(uint8_t is_on)
{
    static uint8_t packet[CDS_PACKET_SIZE(2)];
    static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);

    cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, is_on);
    while (request.result == CDS_PENDING)
        cds_bus_poll(&bus);
}

/* Switches torque on, begins the cycle, and reads each joint `reads` times. False: a call has
 * failed. */
static inline bool joints_begin(struct cds_queue *queue, uint8_t count, uint8_t reads)
{
    bool is_good;

    joints_set_torque(1);
    for (uint8_t i = 0; i < count; i++)
        servo_states[i].id = ids[i] = (uint8_t)(i + 1);
    is_good = cds_servos_begin(&servos, &(struct cds_servos_config){.bus = &bus,
                                                                    .queue = queue,
                                                                    .states = servo_states,
                                                                    .count = count,
                                                                    .capacity = count}) == CDS_OK;
    is_good &= cds_cycle_begin(
                   &cycle, &(struct cds_cycle_config){.bus = &bus,
                                                      .ids = ids,
                                                      .packets = packets,
                                                      .feedback = feedback,
                                                      .count = count,
                                                      .period_us = CDS_CYCLE_PERIOD_US}) == CDS_OK;
    while (is_good && cycle.counters.reads < reads * count) {
        cds_bus_poll(&bus);
        cds_cycle_poll(&cycle);
    }
    return is_good;
}

#endif
