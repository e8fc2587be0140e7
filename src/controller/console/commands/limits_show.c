/* SPDX-License-Identifier: MIT */
/* limits ID off, limits [ID]: removes and shows the soft limits that stop.c sets. Only for chips
 * with room for it. */
#include <stddef.h>

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "console/commands/command_groups.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"

static const CDS_FLASH char message_angles[] = "limits %u %a %a";
static const CDS_FLASH char message_angles_and_speed[] = "limits %u %a %a %r";
static const CDS_FLASH char message_no_limit[] = "none";
static const CDS_FLASH char message_none_due[] =
    "none; 'limits %u LOW HIGH' sets some, 'info %u' shows those of its own";
static const CDS_FLASH char message_none_at_all[] = "no servo has limits";

static uint8_t show_begin(struct console *console)
{
    return console->line.id == CDS_BROADCAST_ID || console_servo(console)
               ? 0
               : (uint8_t)ERROR_NOT_KNOWN;
}

/* Prints the line to type: "limits 1 60.117deg 239.883deg 30rpm". */
static void print_line(struct printer *printer, const struct cds_servo_state *servo)
{
    printer->values[0].number = servo->id;
    printer->values[1].number = servo->lowest;
    printer->values[2].number = servo->highest;
    printer->values[3].number = servo->fastest;
    printer_line(printer,
                 servo->fastest < CDS_VALUE_MAX ? message_angles_and_speed : message_angles);
}

static void print_none(struct console *console)
{
    console->printer.values[0].number = console->printer.values[1].number = console->line.id;
    printer_line(&console->printer,
                 console_is_for_person(console) ? message_none_due : message_no_limit);
}

/* Prints the next servo with limits, in the order of IDs: console->index is the least ID that is
 * due. */
static bool show_all(struct console *console)
{
    const struct cds_servo_state *servo = robot_servo_from(console->robot, console->index);

    if (servo == NULL) {
        if (!console->part)
            printer_line(&console->printer, message_none_at_all);
        return false;
    }
    if (servo->has_limits) {
        print_line(&console->printer, servo);
        console->part = 1;
    }
    console->index = (uint8_t)(servo->id + 1);
    return true;
}

static bool show_poll(struct console *console)
{
    const struct cds_servo_state *servo = console_servo(console);

    if (console->line.id == CDS_BROADCAST_ID)
        return show_all(console);
    if (servo && servo->has_limits)
        print_line(&console->printer, servo);
    else
        print_none(console);
    return false;
}

static uint8_t off_begin(struct console *console)
{
    struct cds_servo_state *servo = console_servo(console);

    if (servo == NULL)
        return ERROR_NOT_KNOWN;
    return (uint8_t)cds_servos_set_limits(&console->robot->servos, servo, 0, CDS_VALUE_MAX,
                                          CDS_VALUE_MAX);
}

static const CDS_FLASH struct command limits_show_rows[] = {
    {
        .usage = FLASH_TEXT("limits ID off"),
        .what = FLASH_TEXT("remove limits"),
        .details = COMMAND_DETAILS("Those that the servo keeps, as CW_ANGLE_LIMIT, stay"),
        .example = COMMAND_DETAILS("limits 1 off"),
        .begin = off_begin,
    },
    {
        .usage = FLASH_TEXT("limits [ID]"),
        .what = FLASH_TEXT("show limits"),
        .details = COMMAND_DETAILS(
            "Prints the line that sets them again, or none. No ID: of each servo with limits"),
        .example = COMMAND_DETAILS("limits 1"),
        .begin = show_begin,
        .poll = show_poll,
    },
};

const CDS_FLASH struct command_group limits_show_commands = {
    .rows = limits_show_rows,
    .count = sizeof limits_show_rows / sizeof limits_show_rows[0],
};
