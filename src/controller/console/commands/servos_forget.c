/* SPDX-License-Identifier: MIT */
/* servos forget ID: one servo that is gone leaves the list. */
#include <stddef.h>

#include "cds55xx/servo.h" // cds_servo_ping()
#include "console/commands/command_groups.h"
#include "console/commands/shared.h" // servos_begin(), servos_poll()
#include "console/console.h"
#include "console/errors.h"
#include "console/unasked.h"

enum forget_phase { ASK_SERVO, REMOVE } __attribute__((packed));

/* True if the line names a servo: without one all are forgotten, or listed. */
static bool names_servo(const struct console *console)
{
    return console->line.id != CDS_BROADCAST_ID;
}

/* True if the servo may leave the list. The remedy if not: text_of_forget() of advice.c. */
static bool may_leave(const struct cds_servo_state *servo)
{
    return servo->presence == CDS_PRESENCE_OFFLINE && servo->second == CDS_NO_ID &&
           !servo->inhibits;
}

static uint8_t ask(struct console *console)
{
    return (uint8_t)cds_servo_ping(console->bus, console->line.request, console->line.id);
}

/* True if the servo, which has not answered, must be asked once more: only CDS_SERVOS_MISSES in a
 * row make a servo offline. Counts the call. */
static bool must_ask_again(struct console *console)
{
    const struct cds_servo_state *servo = console_servo(console);

    return servo && servo->presence != CDS_PRESENCE_OFFLINE && ++console->part < CDS_SERVOS_MISSES;
}

static uint8_t servos_forget_begin(struct console *console)
{
    uint8_t error;

    if (!names_servo(console))
        return servos_begin(console);
    error = robot_busy(console->robot);
    if (error)
        return error;
    if (console_servo(console) == NULL)
        return ERROR_NOT_KNOWN;
    return ask(console);
}

/* Waits while the bus has a request, which may hold an index of the list. */
static bool remove_servo(struct console *console)
{
    struct cds_servo_state *servo = console_servo(console);
    struct failsafe *failsafe = console->failsafe;
    uint8_t index, last = (uint8_t)(console->robot->servos.count - 1u);

    console->error = servo ? robot_busy(console->robot) : (uint8_t)ERROR_NOT_KNOWN;
    if (console->error == 0 && !may_leave(servo))
        console->error = ERROR_NOT_NEW;
    if (console->error)
        return false;
    index = (uint8_t)(servo - console->robot->states);
    if (!robot_forget_servo(console->robot, servo))
        return true;
    failsafe_move_servo(failsafe, last, index, console->line.id);
    unasked_move_servo(command_set.unasked, last, index);
    return false;
}

static bool servos_forget_poll(struct console *console)
{
    if (!names_servo(console))
        return servos_poll(console);
    if (console->phase == REMOVE)
        return remove_servo(console);
    if (console_waits(console))
        return true;
    if (console->error == CDS_OK)
        console->error = ERROR_NOT_NEW;
    if (console->error != CDS_TIMEOUT)
        return false;
    console->error = 0;
    if (must_ask_again(console))
        console->error = ask(console);
    else
        console->phase = REMOVE;
    return console->error == 0;
}

static const CDS_FLASH struct command servos_forget_rows[] = {
    {
        .usage = FLASH_TEXT("servos [forget [ID]]"),
        .what = FLASH_TEXT("servos and their state"),
        .details = COMMAND_DETAILS("scan finds servos; the state check reads each once a second. "
                                   "forget: empties the list; with an ID: takes this servo out of "
                                   "list and group, if it is offline and does not answer"),
        .example = COMMAND_DETAILS("servos forget 3"),
        .begin = servos_forget_begin,
        .poll = servos_forget_poll,
    },
};

const CDS_FLASH struct command_group servos_forget_commands = {
    .rows = servos_forget_rows,
    .count = sizeof servos_forget_rows / sizeof servos_forget_rows[0],
};
