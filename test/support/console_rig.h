/* SPDX-License-Identifier: MIT */
/* The console over one bus on a port that records. A suite types lines, answers as a servo, and
 * compares what the console has said:
 *
 *     reply_to("ping 1");
 *     assert_sent("FF FF 01 02 01 FB");
 *     answer(1, 0, NULL, 0);
 *     TEST_ASSERT_EQUAL_STRING("ok\r\n", said);
 */
#ifndef CONSOLE_RIG_H
#define CONSOLE_RIG_H

#include <stdio.h>
#include <string.h>

#include "console/commands/shared.h" // struct account
#include "console/console.h"
#include "console/errors.h"
#include "console/unasked.h"
#include "host/host_demux.h"
#include "ring_input.h"
#include "port_fake.h"
#include "unity.h"

static struct cds_bus bus;
static struct cds_ring input, output;
static struct robot robot;
static struct settings settings;
static struct settings_store store;
static struct failsafe failsafe;
static struct console console;

/* What the console has said; only the end of it is kept. */
static char said[512];
static uint16_t said_length;

static inline void begin_console(void)
{
    port_fake_reset();
    memset(&bus, 0, sizeof bus);
    memset(&console, 0, sizeof console);
    memset(&input, 0, sizeof input);
    memset(&output, 0, sizeof output);
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    memset(&robot, 0, sizeof robot);
    robot_begin(&robot, &bus, 0);
    settings_default(&settings);
    settings.echo = SETTINGS_ECHO_OFF; // mode program: the tests compare bare replies
    failsafe = (struct failsafe){.settings = &settings,
                                 .store = &store,
                                 .robot = &robot,
                                 .reset_cause = FAILSAFE_RESET_POWER};
    console_open(&console, &failsafe, &input, &output);
    *command_set.unasked = (struct unasked){0};
    *command_set.account = (struct account){.counted_us = 0};
    robot.moves = command_set.moves;
    command_set.store->load(command_set.store->motions, &store);
    command_set.store->begin(&failsafe, command_set.store->motions);
    said_length = 0;
    said[0] = '\0';
}

static inline void hear_console(void)
{
    while (cds_ring_count(&output)) {
        if (said_length == sizeof said - 1) { // keep the later half
            memmove(said, said + sizeof said / 2, sizeof said / 2);
            said_length = (uint16_t)(sizeof said / 2 - 1);
        }
        said[said_length++] = (char)ring_peek(&output, 0);
        said[said_length] = '\0';
        ring_drop(&output, 1);
    }
}

static inline void turn(void)
{
    cds_bus_poll(&bus);
    robot_poll(&robot);
    console_poll(&console);
    hear_console();
}

/* True if the console can go on without a reply of the bus and without more input. */
static inline bool has_work(void)
{
    return console.state == CONSOLE_ENDING ||
           (console.state == CONSOLE_RUNNING && console.request.result != CDS_PENDING) ||
           (console.state == CONSOLE_READING && !console_idle(&console));
}

/* Types a text that is not yet a line: the console need not catch up. */
static inline void type_part(const char *text)
{
    while (*text) {
        while (!cds_ring_put(&input, (uint8_t)*text))
            turn();
        text++;
    }
}

static inline void type(const char *text)
{
    type_part(text);
    for (uint16_t i = 0; i < 100 || (i < 5000 && has_work()); i++) // 50 goals are checked in parts
        turn();
}

/* Types a line that needs no status packet: it sends nothing, or a packet that no servo answers. */
static inline const char *reply_to(const char *line)
{
    said_length = 0;
    said[0] = '\0';
    type(line);
    type("\r");
    if (bus.link.state == CDS_LINK_TALKING) {
        port_fake_transmit(&bus.link, 0);
        type("");
    }
    return said;
}

static inline void answer(uint8_t id, uint8_t error, const uint8_t *parameters, uint8_t count)
{
    port_fake_answer(&bus.link, id, error, parameters, count);
    type("");
}

static inline void assert_error(uint8_t number, const char *line)
{
    char start[12];

    sprintf(start, "error %u: ", number);
    reply_to(line);
    TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(start, said, strlen(start), line);
    TEST_ASSERT_EQUAL_STRING("\r\n", said + strlen(said) - 2);
}

static inline void assert_sent(const char *hex)
{
    char text[3 * 40 + 1] = "";

    for (uint8_t i = 0; i < port_fake.sent_size && i < 40; i++)
        sprintf(text + strlen(text), i ? " %02X" : "%02X", port_fake.sent[i]);
    TEST_ASSERT_EQUAL_STRING(hex, text);
}

/* The reply to `line` is this line; of a longer one, its beginning. */
static inline void assert_reply(const char *begin, const char *line)
{
    reply_to(line);
    TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(begin, said, strlen(begin), line);
    TEST_ASSERT_EQUAL_STRING("\r\n", said + strlen(said) - 2);
    TEST_ASSERT_EQUAL_PTR(strchr(said, '\n'), strrchr(said, '\n'));
}

/* lines: each with a line to type, and the begin of its reply. */
static inline void assert_replies(const char *const lines[][2], uint8_t count)
{
    for (uint8_t i = 0; i < count; i++)
        assert_reply(lines[i][1], lines[i][0]);
}

#define ASSERT_REPLIES(lines) assert_replies(lines, sizeof(lines) / sizeof(lines)[0])

#endif
