/* SPDX-License-Identifier: MIT */
/* servos: the robot's servos and their state. */
#include <stddef.h>
#include <string.h>

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "console/console.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h" // servo_is_at_other_rate()
#include "compiler.h"                // ALWAYS_INLINE, NOINLINE
#include "console/reply.h"
#include "console/messages.h"
#include "console/unasked.h" // unasked_forget()

static const CDS_FLASH char message_presence_low[] = "line held low";
static const CDS_FLASH char message_presence_busy[] = "line not quiet";
static const CDS_FLASH char message_presence_rate[] = "not at the rate of the bus";
static const CDS_FLASH char message_presence_at[] = "not at the rate of the bus but at %b";
static const CDS_FLASH char message_presence_id_twice[] =
    "replies damaged as if two servos had this ID ('diagnose " SERVO_ID "')";
static const CDS_FLASH char message_alarms_more[] = " + %s";
static const CDS_FLASH char message_alarms[] = ", latched alarms: %s";
static const CDS_FLASH char message_alarms_more_age[] = " + %s%s";
static const CDS_FLASH char message_alarms_age[] = ", latched alarms: %s%s";
static const CDS_FLASH char message_presence[] = "servo %u: %s, torque %s";
static const CDS_FLASH char message_angle_limits[] = ", limits %a to %a";
static const CDS_FLASH char message_all_limits[] = ", limits %a to %a and %r";
static const CDS_FLASH char message_on_endless[] = "on, endless turn";
static const CDS_FLASH char message_off_endless[] = "off, endless turn";
static const CDS_FLASH char message_lost[] = ", inhibited: lost its state";
static const CDS_FLASH char message_lost_due[] = "%s ('release %u')";
static const CDS_FLASH char message_stopped[] = ", inhibited: stopped";
static const CDS_FLASH char message_stopped_by_link[] = ", inhibited: host link lost";
static const CDS_FLASH char message_no_servo[] = "the list is empty";
static const CDS_FLASH char message_scan_finds[] = "the list is empty: 'scan' fills it";

enum servos_part {
    PART_STATE,
    PART_LIMITS,
    PART_LOST,
    PART_STOPPED,
    PART_ALARMS, // one part for each bit
    PART_END = PART_ALARMS + 7,
    PARTS,
} __attribute__((packed));

uint8_t servos_begin(struct console *console)
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
    if (command_set.unasked)
        unasked_forget(command_set.unasked);
    return 0;
}

static const CDS_FLASH char *const CDS_FLASH presences[] = {
    [CDS_PRESENCE_UNKNOWN] = FLASH_TEXT("not asked yet"),
    [CDS_PRESENCE_ONLINE] = FLASH_TEXT("online"),
    [CDS_PRESENCE_OFFLINE] = message_is_offline,
    [CDS_PRESENCE_RETURNED] = FLASH_TEXT("returned, being checked"),
};

/* Prints the condition `condition` of a servo, if its bit is set: ", latched alarms: overload". A
 * firmware with command_set.unasked adds whether it lasts. */
static void print_alarm(struct console *console, const struct cds_servo_state *servo,
                        uint8_t condition)
{
    struct printer *printer = &console->printer;
    uint8_t alarms = servo->alarms & CDS_ERRORS_OF_CONDITION, bit = (uint8_t)(1u << condition);
    bool is_first = !(alarms & (bit - 1));

    if (!(alarms & bit))
        return;
    printer->values[0].text = reply_conditions[condition];
    if (!command_set.unasked) {
        printer_text(printer, is_first ? message_alarms : message_alarms_more);
        return;
    }
    printer->values[1].text =
        unasked_alarm_state(command_set.unasked, (uint8_t)(servo - console->robot->states), bit);
    printer_text(printer, is_first ? message_alarms_age : message_alarms_more_age);
}

/* Damaged replies of a servo that has returned. In noise, which also damages packets to the servos,
 * they tell nothing of its ID. */
#define MANY_DAMAGED 8

/* "servo 1: online, torque on". The profile `full`, which has command_set.explain, also tells the
 * limits: ", limits 60deg to 200deg and 30rpm". */
ALWAYS_INLINE void print_presence(struct console *console, const struct cds_servo_state *servo)
{
    struct printer *printer = &console->printer;
    enum cds_bus_line line = cds_bus_line(console->bus);
    union printer_value *value = printer->values;
    const CDS_FLASH char *presence = presences[servo->presence];
    bool is_unknown = servo->presence != CDS_PRESENCE_ONLINE ||
                      servo->status_return_level == 0 || // no READ
                      !(servo->torque || servo->torque_off == CDS_TORQUE_OFF_OFF ||
                        console->robot->chosen); // the state check reads no servo yet

    if (command_set.advise && servo->presence == CDS_PRESENCE_RETURNED &&
        servo->counters.corrupt >= MANY_DAMAGED &&
        !(console->robot->servos.alarms & CDS_ERROR_CHECKSUM) &&
        !(console_faults(console) & FAULT_NOISE))
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
    if (command_set.advise && cds_servo_is_endless(servo))
        value->text = servo->torque ? message_on_endless : message_off_endless;
    if (is_unknown)
        value->text = message_torque_unknown;
    printer_set_id(printer, servo->id);
    printer_text(printer, message_presence);
}

/* ", inhibited: lost its state ('release 2')". While all servos are inhibited, `release 2` is
 * refused. */
ALWAYS_INLINE const CDS_FLASH char *text_of_lost(struct console *console,
                                                 const struct cds_servo_state *servo)
{
    if (!command_set.advise || !console_is_for_person(console) ||
        robot_is_inhibited(console->robot))
        return message_lost;
    console->printer.values[0].text = message_lost;
    console->printer.values[1].number = servo->id;
    return message_lost_due;
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
            printer_text(printer, text_of_lost(console, servo));
        break;
    case PART_STOPPED:
        if (cds_servos_inhibits(servos, servo) & CDS_INHIBIT_STOPPED)
            printer_text(printer, command_set.explain && console->failsafe->link_lost
                                      ? message_stopped_by_link
                                      : message_stopped);
        break;
    case PART_END: printer_end_of_line(printer); break;
    default: print_alarm(console, servo, (uint8_t)(part - PART_ALARMS)); break;
    }
}

/* Prints one part of a servo. In the order of IDs, console->index is the least ID that is due. */
static bool part_by_id(struct console *console)
{
    const struct cds_servo_state *servo = robot_servo_from(console->robot, console->index);

    if (servo == NULL) // its ID has changed
        return false;
    servo_part(console, servo, console->part++);
    if (console->part < PARTS)
        return true;
    console->part = PART_STATE;
    console->index = (uint8_t)(servo->id + 1);
    return robot_servo_from(console->robot, console->index);
}

/* True for up to 255 polls while the line is not quiet: for a moment it is not after each reply
 * that fails, as of a servo that is absent. */
static bool awaits_quiet(struct console *console)
{
    return cds_bus_line(console->bus) == CDS_BUS_LINE_SUSPECT && ++console->phase;
}

bool servos_poll(struct console *console)
{
    const struct robot *robot = console->robot;
    uint8_t *index = &console->index;
    uint8_t *part = &console->part;

    if (robot->servos.count == 0) {
        printer_line(&console->printer,
                     command_set.explain ? message_scan_finds : message_no_servo);
        return false;
    }
    if (*part == PART_STATE && awaits_quiet(console))
        return true;
    if (command_set.advise)
        return part_by_id(console);
    servo_part(console, &robot->states[*index], (*part)++);
    if (*part == PARTS) {
        *part = PART_STATE;
        (*index)++;
    }
    return *index < robot->servos.count;
}

static const CDS_FLASH struct command servos_rows[] = {
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

const CDS_FLASH struct command_group servos_commands = {
    .rows = servos_rows,
    .count = sizeof servos_rows / sizeof servos_rows[0],
};
