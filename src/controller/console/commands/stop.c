/* SPDX-License-Identifier: MIT */
/* stop, release, limits, servos: torque off, and which servos may be driven. */
#include <stddef.h>
#include <string.h>

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "console/console.h"
#include "console/errors.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h" // servo_is_at_other_rate()
#include "compiler.h"                // NOINLINE
#include "console/reply.h"
#include "console/messages.h"
#include "console/noise.h"
#include "console/unasked.h"

static const CDS_FLASH char message_stop_done[] =
    "robot stopped: torque off, driving inhibited until 'release'";
static const CDS_FLASH char message_stop_failed[] =
    "torque may still be on: switch off the supply; inhibited until 'release'";
static const CDS_FLASH char message_presence_low[] = "line held low";
static const CDS_FLASH char message_presence_busy[] = "line not quiet";
static const CDS_FLASH char message_presence_rate[] = "not at the rate of the bus";
static const CDS_FLASH char message_presence_at[] = "not at the rate of the bus but at %b";
static const CDS_FLASH char message_presence_id_twice[] =
    "returned, replies damaged as if two servos had this ID ('diagnose ID')";
static const CDS_FLASH char message_torque_unknown[] = "unknown";
static const CDS_FLASH char message_alarms_more[] = " + %s";
static const CDS_FLASH char message_alarms[] = ", latched alarms: %s";
static const CDS_FLASH char message_presence[] = "servo %u: %s, torque %s";
static const CDS_FLASH char message_angle_limits[] = ", limits %a to %a";
static const CDS_FLASH char message_all_limits[] = ", limits %a to %a and %r";
static const CDS_FLASH char message_on[] = "on";
static const CDS_FLASH char message_off[] = "off";
static const CDS_FLASH char message_lost[] = ", inhibited: lost its state";
static const CDS_FLASH char message_stopped[] = ", inhibited: stopped";
static const CDS_FLASH char message_stopped_by_link[] = ", inhibited: host link lost";
static const CDS_FLASH char message_no_servo[] = "the list is empty";
static const CDS_FLASH char message_scan_finds[] = "the list is empty: 'scan' fills it";

/* ---- stop ---- */

static const CDS_FLASH char *const CDS_FLASH stop_outcomes[] = {
    [CDS_TORQUE_OFF_UNKNOWN] = FLASH_TEXT("not checked"),
    [CDS_TORQUE_OFF_ON] = FLASH_TEXT("torque is still on"),
    [CDS_TORQUE_OFF_SILENT] = FLASH_TEXT("no answer"),
    [CDS_TORQUE_OFF_MUTE] = FLASH_TEXT("told, set not to answer"),
};

static uint8_t stop_begin(struct console *console)
{
    robot_stop(console->robot);
    return 0;
}

NOINLINE bool servo_is_at_other_rate(const struct console *console,
                                     const struct cds_servo_state *servo)
{
    return servo->baud_reg != CDS_SERVOS_UNKNOWN && servo->baud_reg != console->bus->baud_reg;
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
    /* A servo kept its torque, as its line says. There was noise when the stop began: the error
     * names it. */
    if (command_set.noise && command_set.noise->is_there && console->error == CDS_REFUSED)
        console->error = CDS_CORRUPT;
    while (*index < robot->servos.count) {
        const struct cds_servo_state *servo = &robot->states[(*index)++];

        if (servo->torque_off == CDS_TORQUE_OFF_OFF)
            continue;
        console->printer.values[0].number = servo->id;
        console->printer.values[1].text = stop_outcomes[servo->torque_off];
        if (command_set.explain && servo->torque_off == CDS_TORQUE_OFF_SILENT &&
            servo_is_at_other_rate(console, servo)) {
            console->printer.values[1].text = message_at_rate;
            console->printer.values[2].number = servo->baud_reg;
        }
        printer_line(&console->printer, message_servo);
        return true;
    }
    if (command_set.unasked && !console->error)
        unasked_note_stop();
    if (command_set.explain && console->part++) {
        printer_line(&console->printer, console->error ? message_stop_failed : message_stop_done);
        return false;
    }
    console->printer.values[0].number = robot_unlisted(robot);
    if (console->printer.values[0].number &&
        console->error != CDS_LINE_BUSY)                       // else nothing was sent
        printer_line(&console->printer, message_unlisted + 2); // behind "; "
    return command_set.explain && (console->error || console_is_for_person(console));
}

static uint8_t release_begin(struct console *console)
{
    struct robot *robot = console->robot;
    struct cds_servo_state *servo = console_servo(console);

    if (robot_is_stopping(robot))
        return ERROR_STOPPING;
    if (console->failsafe->link_lost)
        return ERROR_LINK_LOST;
    if (console->line.id == CDS_BROADCAST_ID) {
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
    return cds_servos_set_limits(servos, servo, raw[0], raw[1], raw[2]) == CDS_OK
               ? 0
               : ERROR_OUT_OF_RANGE;
}

/* ---- servos ---- */

enum servos_part {
    PART_STATE,
    PART_LIMITS,
    PART_LOST,
    PART_STOPPED,
    PART_ALARMS, // one part for each bit
    PART_END = PART_ALARMS + 7,
    PARTS,
} __attribute__((packed));

static uint8_t servos_begin(struct console *console)
{
    struct robot *robot = console->robot;
    uint8_t error;

    if (console->line.choice == 0)
        return 0;
    error = robot_busy(robot);
    if (error)
        return error;
    robot_forget(robot);
    if (command_set.explain)
        console->failsafe->alarm = 0; // one of a forgotten servo, not yet printed
    memset(console->failsafe->reported, 0,
           sizeof console->failsafe->reported); // other servos will take these places
    return 0;
}

static const CDS_FLASH char *const CDS_FLASH presences[] = {
    [CDS_PRESENCE_UNKNOWN] = FLASH_TEXT("not asked yet"),
    [CDS_PRESENCE_ONLINE] = FLASH_TEXT("online"),
    [CDS_PRESENCE_OFFLINE] = message_is_offline,
    [CDS_PRESENCE_RETURNED] = FLASH_TEXT("returned, being checked"),
};

/* Prints the condition `index`, if its bit in `alarms` is set. */
static void print_alarm(struct printer *printer, uint8_t alarms, uint8_t index)
{
    uint8_t bit = (uint8_t)(1u << index);

    if (!(alarms & bit))
        return;
    printer->values[0].text = reply_conditions[index];
    printer_text(printer, alarms & (bit - 1) ? message_alarms_more : message_alarms);
}

/* Damaged replies of a servo that has returned: noise alone seldom gives so many. */
#define MANY_DAMAGED 8

/* "servo 1: online, torque on". The profile `full`, which has command_set.explain, also tells the
 * limits: ", limits 60deg to 200deg and 30rpm". */
ALWAYS_INLINE void print_presence(struct console *console, const struct cds_servo_state *servo)
{
    struct printer *printer = &console->printer;
    enum cds_bus_line line = cds_bus_line(console->bus);
    union printer_value *value = printer->values;
    const CDS_FLASH char *presence = presences[servo->presence];
    bool is_unknown =
        servo->presence != CDS_PRESENCE_ONLINE || servo->status_return_level == 0; // no READ

    if (command_set.advise && servo->presence == CDS_PRESENCE_RETURNED &&
        servo->counters.corrupt >= MANY_DAMAGED)
        presence = message_presence_id_twice;
    if (command_set.explain && servo_is_at_other_rate(console, servo)) {
        presence = command_set.advise ? message_presence_at : message_presence_rate;
        is_unknown = true;
    }
    if (line != CDS_BUS_LINE_QUIET) {
        presence = line == CDS_BUS_LINE_FAULT ? message_presence_low : message_presence_busy;
        is_unknown = true;
    }
    (value++)->number = servo->id;
    (value++)->text = presence;
    if (command_set.advise && presence == message_presence_at)
        (value++)->number = servo->baud_reg;
    value->text = servo->torque ? message_on : message_off;
    if (is_unknown)
        value->text = message_torque_unknown;
    printer_text(printer, message_presence);
}

/* "servo 1: online, torque on, inhibited: stopped", one part at a time. */
NOINLINE static void servo_part(struct console *console, const struct cds_servo_state *servo,
                                uint8_t part)
{
    const struct robot *robot = console->robot;
    const struct cds_servos *servos = &robot->servos;
    struct printer *printer = &console->printer;

    switch (part) {
    case PART_STATE: print_presence(console, servo); break;
    case PART_LIMITS:
        if (!command_set.explain || !servo->has_limits)
            break;
        printer->values[0].number = servo->lowest;
        printer->values[1].number = servo->highest;
        printer->values[2].number = servo->fastest;
        printer_text(printer,
                     servo->fastest < CDS_VALUE_MAX ? message_all_limits : message_angle_limits);
        break;
    case PART_LOST:
        if (servo->inhibits & CDS_INHIBIT_STATE_LOST)
            printer_text(printer, message_lost);
        break;
    case PART_STOPPED:
        if (cds_servos_inhibits(servos, servo) & CDS_INHIBIT_STOPPED)
            printer_text(printer, command_set.explain && console->failsafe->link_lost
                                      ? message_stopped_by_link
                                      : message_stopped);
        break;
    case PART_END: printer_end_of_line(printer); break;
    default:
        print_alarm(printer, servo->alarms & CDS_ERRORS_OF_CONDITION,
                    (uint8_t)(part - PART_ALARMS));
        break;
    }
}

static bool servos_poll(struct console *console)
{
    const struct robot *robot = console->robot;
    uint8_t *index = &console->index;
    uint8_t *part = &console->part;

    if (robot->servos.count == 0) {
        printer_line(&console->printer,
                     command_set.explain ? message_scan_finds : message_no_servo);
        return false;
    }
    servo_part(console, &robot->states[*index], (*part)++);
    if (*part == PARTS) {
        *part = PART_STATE;
        (*index)++;
    }
    return *index < robot->servos.count;
}

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
        .what = FLASH_TEXT("allow driving again"),
        .details = COMMAND_DETAILS("No ID: all servos, after stop. ID: a servo that lost its "
                                   "state. Nothing moves before torque is on"),
        .example = COMMAND_DETAILS("release"),
        .begin = release_begin,
    },
    {
        .usage = FLASH_TEXT("limits ID LOW HIGH [SPEED]"),
        .what = FLASH_TEXT("limits of angle and speed"),
        .details = COMMAND_DETAILS(
            "Angles: 0 to 300deg. SPEED: 0 to 62rpm, 0: no limit. Nothing beyond them is sent. "
            "Until a reset; 'servos' shows them, 'limits ID 0 300' removes them"),
        .example = COMMAND_DETAILS("limits 1 60 240 30rpm"),
        .begin = limits_begin,
    },
    {
        .usage = FLASH_TEXT("servos [forget]"),
        .what = FLASH_TEXT("servos and their state"),
        .details = COMMAND_DETAILS("scan finds servos; the state check reads each once a second. "
                                   "forget: empties the list"),
        .example = COMMAND_DETAILS("servos"),
        .begin = servos_begin,
        .poll = servos_poll,
    },
};

const CDS_FLASH struct command_group stop_commands = {
    .heading = FLASH_TEXT("Safety:"),
    .rows = stop_rows,
    .count = sizeof stop_rows / sizeof stop_rows[0],
};
