/* SPDX-License-Identifier: MIT */
/* stop, release, limits: torque off, and which servos may be driven. */
#include <stddef.h>

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "console/console.h"
#include "console/errors.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h" // servo_is_at_other_rate()
#include "compiler.h"                // NOINLINE
#include "console/messages.h"
#include "console/noise.h"
#include "console/unasked.h"

static const CDS_FLASH char message_stop_done[] =
    "robot stopped: torque off, driving inhibited until '%s'";
static const CDS_FLASH char message_stop_failed[] =
    "torque may still be on: switch off the supply; inhibited until '%s'";
static const CDS_FLASH char message_stop_unread[] =
    "torque off was sent to all IDs at this rate; no servo is known, torque may be on: 'scan', or "
    "'scan all', then 'bus RATE'; driving inhibited until '%s'";
static const CDS_FLASH char message_unscanned_ids[] =
    "IDs not checked: %u; torque off was sent to them, too; 'scan' looks for servos there";

#if PRINTER_HAS_ROOM
static const CDS_FLASH char message_no_speed_limit[] =
    "it has no speed limit any more (it was %r): 'limits %u LOW HIGH SPEED' sets one";
#endif

/* ---- stop ---- */

static const CDS_FLASH char *const CDS_FLASH stop_outcomes[] = {
    [CDS_TORQUE_OFF_UNKNOWN] = FLASH_TEXT("not checked"),
    [CDS_TORQUE_OFF_ON] = FLASH_TEXT("torque is still on"),
    [CDS_TORQUE_OFF_SILENT] = FLASH_TEXT("no answer"),
    [CDS_TORQUE_OFF_MUTE] = FLASH_TEXT("told, answers no READ"),
};

/* What the stop has learnt of a servo. The state check takes a servo that answers PING and no READ
 * for one of status return level 0: in noise it may be of any level. */
static uint8_t outcome_of(const struct console *console, const struct cds_servo_state *servo)
{
    return command_set.noise && servo->torque_off == CDS_TORQUE_OFF_MUTE &&
                   console_is_noisy(console)
               ? (uint8_t)CDS_TORQUE_OFF_SILENT
               : (uint8_t)servo->torque_off;
}

uint8_t stop_begin(struct console *console)
{
    robot_stop(console->robot);
    return 0;
}

NOINLINE bool servo_is_at_other_rate(const struct console *console,
                                     const struct cds_servo_state *servo)
{
    return servo->baud_reg != CDS_SERVOS_UNKNOWN && servo->baud_reg != console->bus->baud_reg;
}

/* What the stop has done, with what ends its inhibit as value. While the host link is lost,
 * `release` is refused: `clear` ends both. */
static const CDS_FLASH char *stop_message(struct console *console)
{
    console->printer.values[0].text =
        command_set.advise && console->failsafe->link_lost ? message_clear : message_release;
    if (console->error)
        return message_stop_failed;
    return command_set.advise && console->robot->servos.count == 0 ? message_stop_unread
                                                                   : message_stop_done;
}

/* Waits until the stop is over, then prints the servos whose torque was not read as off. The
 * profile `full`, which has command_set.explain, then tells a person what the stop has done, and
 * anyone what to do if it has failed; the profile `console` has no flash for this line. */
static bool stop_poll(struct console *console)
{
    const struct robot *robot = console->robot;
    uint8_t *index = &console->index;

    if (robot_is_stopping(robot))
        return true;
    console->error = robot->stop.steps.result;
    /* A servo kept its torque or gave no answer, as its line says. There was noise when the stop
     * began: the error names it. */
    if (command_set.noise && console_is_noisy(console) &&
        (console->error == CDS_REFUSED || console->error == CDS_NO_REPLY_DUE))
        console->error = CDS_CORRUPT;
    while (*index < robot->servos.count) {
        const struct cds_servo_state *servo = &robot->states[(*index)++];

        if (servo->torque_off == CDS_TORQUE_OFF_OFF)
            continue;
        console->printer.values[0].number = servo->id;
        console->printer.values[1].text = stop_outcomes[outcome_of(console, servo)];
        if (command_set.explain && servo->torque_off == CDS_TORQUE_OFF_SILENT)
            servo_put_rate(console, servo);
        printer_line(&console->printer, message_servo);
        return true;
    }
    if (command_set.unasked && !console->error)
        unasked_note_stop(command_set.unasked);
    if (command_set.explain && console->part++) {
        printer_line(&console->printer, stop_message(console));
        return false;
    }
    console->printer.values[0].number = robot_unlisted(robot);
    if (console->printer.values[0].number && console->error != CDS_LINE_BUSY) // else nothing sent
        printer_line(&console->printer, command_set.has_room &&
                                                robot->unlisted == ROBOT_NOT_SCANNED &&
                                                console_is_for_person(console)
                                            ? message_unscanned_ids
                                            : message_unlisted + 2); // behind "; "
    return command_set.explain && (console->error || console_is_for_person(console));
}

static uint8_t release_begin(struct console *console)
{
    struct robot *robot = console->robot;
    struct cds_servo_state *servo = console_servo(console);

    if (robot_is_stopping(robot))
        return ERROR_STOPPING;
    if (console->failsafe->link_lost && (!command_set.has_room || robot_is_inhibited(robot)))
        return ERROR_LINK_LOST;
    if (console->line.id == CDS_BROADCAST_ID) {
        if (command_set.advise)
            console->part = robot->stop_begun; // advice_note() tells who has not confirmed it
        robot_release(robot);
        return 0;
    }
    if (robot_is_inhibited(robot))
        return ERROR_STOPPED;
    if (servo == NULL)
        return ERROR_NOT_KNOWN;
    cds_servos_release(&robot->servos, servo);
    return 0;
}

/* ---- limits ---- */

static uint8_t limits_begin(struct console *console)
{
    const struct command_line *line = &console->line;
    struct cds_servos *servos = &console->robot->servos;
    struct cds_servo_state *servo = console_servo(console);
    uint16_t raw[3];
    uint8_t error = 0;

    raw[2] = 0;
    for (uint8_t i = 0; error == 0 && i < line->numbers; i++)
        error = number_register(&line->number[i], i < 2 ? CDS_UNIT_MDEG : CDS_UNIT_MRPM, &raw[i]);
    if (error)
        return error;
    if (raw[2] == 0) // as in the servo: no limit
        raw[2] = CDS_VALUE_MAX;
    if (servo == NULL)
        return ERROR_NOT_KNOWN;
    if (command_set.has_room)
        console->raw = line->numbers == 2 ? servo->fastest : CDS_VALUE_MAX;
    return cds_servos_set_limits(servos, servo, raw[0], raw[1], raw[2]) == CDS_OK
               ? 0
               : ERROR_OUT_OF_RANGE;
}

#if PRINTER_HAS_ROOM // else the row has no poll: it would take flash
/* Tells a person that a line without SPEED has removed the speed limit, console->raw. */
static bool limits_poll(struct console *console)
{
    if (command_set.has_room && console->raw < CDS_VALUE_MAX && console_is_for_person(console)) {
        console->printer.values[0].number = console->raw;
        console->printer.values[1].number = console->line.id;
        printer_line(&console->printer, message_no_speed_limit);
    }
    return false;
}
#endif

const CDS_FLASH struct command stop_rows[] = {
    {
        .usage = FLASH_TEXT("stop"),
        .what = FLASH_TEXT("torque off for all servos"),
        .details =
            COMMAND_DETAILS("Ctrl-X does the same at any time. Driving is inhibited until release"),
        .begin = stop_begin,
        .poll = stop_poll,
    },
    {
        .usage = FLASH_TEXT("release [ID]"),
        .what = FLASH_TEXT("allow driving"),
        .details = COMMAND_DETAILS("No ID: all servos, after stop. ID: a servo that lost its "
                                   "state. Nothing moves before torque is on"),
        .example = COMMAND_DETAILS("release"),
        .begin = release_begin,
    },
    {
        .usage = FLASH_TEXT("limits ID LOW HIGH [SPEED]"),
        .what = FLASH_TEXT("angle and speed limits"),
        .details = COMMAND_DETAILS(
            "Angles: 0 to 300deg. SPEED: 0 to 62rpm, 0: no limit. Nothing beyond them is sent. "
            "Until a reset; 'servos' shows them, 'limits ID 0 300' removes them"),
        .example = COMMAND_DETAILS("limits 1 60 240 30rpm"),
        .begin = limits_begin,
#if PRINTER_HAS_ROOM
        .poll = limits_poll,
#endif
    },
};

const CDS_FLASH struct command_group stop_commands = {
    .heading = FLASH_TEXT("Safety:"),
    .rows = stop_rows,
    .count = sizeof stop_rows / sizeof stop_rows[0],
};
