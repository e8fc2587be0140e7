/* SPDX-License-Identifier: MIT */
/* The console over an EEPROM that keeps settings, poses and sequences, after a reset by power. The
 * whole reply must fit `said`. */
#ifndef SAVING_RIG_H
#define SAVING_RIG_H

#include <stdio.h>
#include <string.h>

#include "console/console.h"
#include "eeprom_fake.h"
#include "ring_input.h"
#include "port_fake.h"
#include "unity.h"

static struct cds_bus bus;
static struct cds_ring input, output;
static struct console console;
static struct failsafe failsafe;
static struct robot robot;
static struct settings settings;
static struct settings_store store;
static char said[500];

static uint16_t damaged_stops;

static inline void begin_controller(void)
{
    port_fake_reset();
    eeprom_fake_reset();
    eeprom_fake.has_more = true; // poses and sequences
    memset(&bus, 0, sizeof bus);
    memset(&console, 0, sizeof console);
    memset(&input, 0, sizeof input);
    memset(&output, 0, sizeof output);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    memset(&robot, 0, sizeof robot);
    robot_begin(&robot, &bus, 0);
    settings_load(&store, &settings);
    settings.echo = SETTINGS_ECHO_OFF; // replies alone, as programs read them
    failsafe = (struct failsafe){.settings = &settings,
                                 .store = &store,
                                 .robot = &robot,
                                 .damaged_stops = &damaged_stops,
                                 .room_bytes = 2000,
                                 .spare_bytes = 1234};
    failsafe_begin(&failsafe, FAILSAFE_RESET_POWER | FAILSAFE_RESET_BROWN_OUT);
    console_open(&console, &failsafe, &input, &output);
    robot.moves = command_set.moves;
    command_set.store->load(command_set.store->motions, &store);
    command_set.store->begin(&failsafe, command_set.store->motions);
}

static inline void end_controller(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
    TEST_ASSERT_EQUAL_UINT16(0, eeprom_fake.breaches);
}

static inline void turn(void)
{
    failsafe_poll(&failsafe);
    settings_save_poll(&store);
    failsafe.counts_stack = false; // as main does when it has counted
    cds_bus_poll(&bus);
    robot_poll(&robot);
    console_poll(&console);
    while (cds_ring_count(&output)) {
        size_t length = strlen(said);

        TEST_ASSERT_TRUE(length < sizeof said - 1);
        said[length] = (char)ring_peek(&output, 0);
        said[length + 1] = '\0';
        ring_drop(&output, 1);
    }
}

static inline void turns(uint16_t count)
{
    while (count--)
        turn();
}

/* What is said to a line. */
static inline const char *reply_to(const char *line)
{
    said[0] = '\0';
    for (; *line; line++)
        cds_ring_put(&input, (uint8_t)*line);
    cds_ring_put(&input, '\r');
    turns(120);
    for (uint16_t left = 400; left && console.state == CONSOLE_ENDING; left--)
        turn();
    return said;
}

static inline void assert_error(const char *number, const char *line)
{
    char start[16];

    sprintf(start, "error %s: ", number);
    reply_to(line);
    TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(start, said, strlen(start), line);
    turns(80); // a hint may follow
}

#endif
