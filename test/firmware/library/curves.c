/* SPDX-License-Identifier: MIT */
/* One joint makes the moves of docs/img/curves.svg; scripts/motion_pictures.py draws them. Pin B0
 * is high while a move of the picture is under way. Before each move the joint goes back to START.
 */
#include <cds55xx/motion.h>
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>

#include "say.h"

#define START      300
#define GOAL       700
#define TIME_MS    1200
#define PERIODS_MS 4

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static struct cds_cycle cycle;
static struct cds_feedback feedback;
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(1)];
static const uint8_t id = 1;
static struct cds_motion motion;
static struct cds_motion_joint joint;

static void poll(void)
{
    cds_bus_poll(&bus);
    cds_cycle_poll(&cycle);
    cds_motion_poll(&motion);
}

static void poll_for(uint16_t time_ms)
{
    uint32_t end = cycle.counters.periods + time_ms / PERIODS_MS;

    while (cycle.counters.periods != end)
        poll();
}

/* Until all moves are over. */
static void poll_to_end(void)
{
    while (cds_motion_is_busy(&motion) || motion.result == CDS_PENDING)
        poll();
}

static void begin(void)
{
    static uint8_t packet[CDS_PACKET_SIZE(2)];
    static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);

    cds_servo_write_byte(&bus, &request, id, CDS_REG_TORQUE_ENABLE, 1);
    while (cds_bus_poll(&bus)) {
    }
    cds_cycle_begin(&cycle, &(struct cds_cycle_config){.bus = &bus,
                                                       .ids = &id,
                                                       .packets = packets,
                                                       .feedback = &feedback,
                                                       .count = 1,
                                                       .period_us = CDS_CYCLE_PERIOD_US});
    cds_motion_begin(&motion, &(struct cds_motion_config){.cycle = &cycle, .joints = &joint});
    while (cycle.counters.reads < 2)
        poll();
}

/* Begins a move and marks it, as soon as the move is checked. */
static void move(const struct cds_move *it)
{
    cds_motion_move(&motion, it);
    while (cds_motion_is_busy(&motion))
        poll();
    if (motion.move_result == CDS_OK)
        PORTB |= 1 << 0;
}

/* The move of the picture is over; the joint goes back. */
static void go_back(void)
{
    static const uint16_t start = START;

    poll_to_end();
    PORTB &= (uint8_t) ~(1 << 0);
    poll_for(600);
    cds_motion_move(&motion, &(struct cds_move){.pose = &start, .time_ms = TIME_MS});
    poll_to_end();
    poll_for(200);
}

static void show_curves(void)
{
    static const uint16_t goal = GOAL;
    struct cds_move it = {.pose = &goal, .time_ms = TIME_MS, .acceleration = 1000};

    for (it.curve = CDS_MOTION_MINIMUM_JERK; it.curve <= CDS_MOTION_BY_SERVO; it.curve++) {
        move(&it);
        go_back();
    }
}

static void show_pass(void)
{
    static const uint16_t goal = GOAL, on_the_way = 600;

    move(&(struct cds_move){
        .pose = &on_the_way, .time_ms = TIME_MS / 2, .next_pose = &goal, .next_ms = TIME_MS / 2});
    move(&(struct cds_move){.pose = &goal, .time_ms = TIME_MS / 2, .waits = true});
    go_back();
}

static void show_new_target(void)
{
    static const uint16_t goal = GOAL, other = 400;

    move(&(struct cds_move){.pose = &goal, .time_ms = TIME_MS});
    poll_for(TIME_MS / 2);
    move(&(struct cds_move){.pose = &other, .time_ms = TIME_MS / 2});
    go_back();
}

static void show_pause(void)
{
    static const uint16_t goal = GOAL;

    move(&(struct cds_move){.pose = &goal, .time_ms = TIME_MS});
    poll_for(400);
    cds_motion_pause(&motion, 2000);
    poll_for(400);
    cds_motion_resume(&motion);
    go_back();
}

static void show_override_and_abort(void)
{
    static const uint16_t goal = GOAL;

    move(&(struct cds_move){.pose = &goal, .time_ms = TIME_MS});
    poll_for(400);
    cds_motion_set_override(&motion, 50);
    poll_for(600);
    cds_motion_abort(&motion, 2000);
    poll_to_end();
    cds_motion_set_override(&motion, 100);
    go_back();
}

int main(void)
{
    static const uint16_t start = START;

    DDRB = 1 << 0;
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    begin();
    cds_motion_move(&motion, &(struct cds_move){.pose = &start, .time_ms = TIME_MS});
    poll_to_end();
    poll_for(200);
    show_curves();
    show_pass();
    show_new_target();
    show_pause();
    show_override_and_abort();
    say("missed", cycle.counters.missed);
    say_end();
}
