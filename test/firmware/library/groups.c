/* SPDX-License-Identifier: MIT */
/* Operations on groups of servos 1 to 60: a SYNC WRITE to all; a SYNC WRITE to 18 in packets of at
 * most 64 bytes; a group read of the goals; a registered move of three that servo 2 refuses; a
 * registered move of 18 with verification. Prints the outcome of each. */
#include <cds55xx/blocking.h>
#include <cds55xx/avr.h>
#include <util/delay.h>

#include "say.h"

#define SERVOS 60
#define SOME   18
#define SHORT  64 // bytes
#define GOAL   4  // bytes from GOAL_POSITION on

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_SYNC_WRITE_PACKET_MAX];
static uint8_t reply[CDS_REGISTERED_MOVE_VERIFY_REPLY];
static struct cds_request request = CDS_REQUEST(packet, reply);
static uint8_t ids[SERVOS];
static uint8_t data[SERVOS * GOAL];
static struct cds_goal goals[SOME];

static void write_group(uint8_t count, uint16_t longest, uint16_t position)
{
    static struct cds_sync_write_many write;
    struct cds_sync_write_many_config config = {.bus = &bus,
                                                .request = &request,
                                                .ids = ids,
                                                .data = data,
                                                .count = count,
                                                .address = CDS_REG_GOAL_POSITION,
                                                .length = GOAL,
                                                .packet_max = longest};

    for (uint8_t i = 0; i < count; i++) {
        uint16_t goal = position + i;

        ids[i] = (uint8_t)(i + 1);
        data[GOAL * i] = (uint8_t)goal;
        data[GOAL * i + 1] = (uint8_t)(goal >> 8);
        data[GOAL * i + 2] = 0;
        data[GOAL * i + 3] = 0;
    }
    say("write_result", cds_blocking_sync_write_many(&write, &config));
    say("write_packets", write.packets);
}

/* Counts the servos among the first `count` that have the goal of write_group(). */
static void read_group(uint8_t count, uint16_t position)
{
    static uint8_t packets[2][CDS_PACKET_SIZE(2)], replies[2][2];
    static struct cds_request requests[2] = {CDS_REQUEST(packets[0], replies[0]),
                                             CDS_REQUEST(packets[1], replies[1])};
    static struct cds_group_read read;
    static struct cds_group_answer answers[SERVOS];
    struct cds_group_read_config config = {.bus = &bus,
                                           .requests = requests,
                                           .ids = ids,
                                           .data = data,
                                           .answers = answers,
                                           .count = count,
                                           .address = CDS_REG_GOAL_POSITION,
                                           .length = 2};
    uint8_t there = 0;
    uint32_t oldest_us = 0;

    enum cds_result result = cds_blocking_group_read(&read, &config);

    for (uint8_t i = 0; i < count; i++) {
        uint16_t goal = (uint16_t)(data[2 * i] | (uint16_t)data[2 * i + 1] << 8);
        uint32_t age_us = cds_group_read_age_us(&answers[i]);

        if (answers[i].result == CDS_OK && goal == position + i)
            there++;
        if (age_us > oldest_us)
            oldest_us = age_us;
    }
    say("read_result", result);
    say("there", there);
    say("oldest_us", oldest_us);
}

static void move_group(uint8_t count, uint16_t position, bool verified)
{
    static struct cds_registered_move move;
    struct cds_registered_move_config config = {
        .bus = &bus, .request = &request, .goals = goals, .count = count, .verify = verified};

    for (uint8_t i = 0; i < count; i++)
        goals[i] = (struct cds_goal){.id = (uint8_t)(i + 1), .position = position, .speed = 900};
    say("move_result", cds_blocking_registered_move(&move, &config));
    say("acted", move.acted);
    for (uint8_t i = 0; i < count; i++) {
        if (goals[i].result != CDS_OK || goals[i].registered) {
            say("servo", goals[i].id);
            say("servo_result", goals[i].result);
            say("servo_error", goals[i].error);
            say("servo_armed", goals[i].registered);
        }
    }
}

static void write_word(uint8_t id, uint8_t address, uint16_t value)
{
    cds_servo_write_word(&bus, &request, id, address, value);
    while (cds_bus_poll(&bus)) {
    }
}

int main(void)
{
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    _delay_ms(1000); // the servos start up
    cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1);
    while (cds_bus_poll(&bus)) {
    }

    write_group(SERVOS, CDS_SYNC_WRITE_PACKET_MAX, 400);
    read_group(SERVOS, 400);
    write_group(SOME, SHORT, 300);
    read_group(SOME, 300);
    _delay_ms(400); // until they are there

    write_word(2, CDS_REG_CCW_ANGLE_LIMIT, 512);
    move_group(3, 513, false);
    _delay_ms(20);
    read_group(3, 300);
    write_word(2, CDS_REG_CCW_ANGLE_LIMIT, CDS_VALUE_MAX);

    move_group(SOME, 700, true);
    _delay_ms(200);
    say_end();
}
