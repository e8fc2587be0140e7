/* stop, release, limits, servos: who is held, and why. */
#include <stddef.h>
#include <string.h>

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "console/console.h"
#include "console/errors.h"
#include "console/handlers.h"
#include "compiler.h" // NOINLINE
#include "console/reply.h"
#include "console/messages.h"

/* ---- stop ---- */

uint8_t stop_begin(struct console *console)
{
    robot_stop(console->robot);
    return 0;
}

/* Waits until it is over, whoever began it, then tells of those that are not known to be off. */
bool stop_poll(struct console *console)
{
    const struct robot *robot = console->robot;
    uint8_t *index = &console->index;

    if (robot_is_stopping(robot))
        return true;
    console->error = robot->stop.steps.result;
    while (*index < robot->servos.count) {
        const struct cds_servo_state *servo = &robot->states[(*index)++];

        if (servo->torque_off == CDS_TORQUE_OFF_OFF)
            continue;
        console->printer.values[0] = servo->id;
        printer_line_at(&console->printer, TEXT_STOP_UNKNOWN, servo->torque_off);
        return true;
    }
    console->printer.values[0] = robot_strangers(robot);
    if (console->printer.values[0] && console->error != CDS_LINE_BUSY) // else nothing was sent
        printer_line(&console->printer, TEXT_STOP_STRANGERS);
    return false;
}

uint8_t release_begin(struct console *console)
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

uint8_t limits_begin(struct console *console)
{
    const struct command_line *line = &console->line;
    struct cds_servos *servos = &console->robot->servos;
    struct cds_servo_state *servo = console_servo(console);
    uint16_t raw[] = {0, 0, CDS_VALUE_MAX};

    for (uint8_t i = 0; i < line->numbers; i++) {
        uint8_t error =
            number_register(&line->number[i], i < 2 ? CDS_UNIT_MDEG : CDS_UNIT_MRPM, &raw[i]);

        if (error)
            return error;
    }
    if (servo == NULL)
        return ERROR_NOT_KNOWN;
    return cds_servos_set_limits(servos, servo, raw[0], raw[1], raw[2]) == CDS_OK
               ? 0
               : ERROR_OUT_OF_RANGE;
}

/* ---- servos ---- */

enum servos_part {
    PART_STATE,
    PART_LOST,
    PART_STOPPED,
    PART_ALARMS, // and on: a part for each bit
    PART_END = PART_ALARMS + 7,
    PARTS,
} __attribute__((packed));

uint8_t servos_begin(struct console *console)
{
    struct robot *robot = console->robot;

    if (console->line.choice == 0)
        return 0;
    if (robot->operation != ROBOT_IDLE)
        return ERROR_CYCLE;
    if (robot_is_stopping(robot))
        return ERROR_STOPPED;
    robot_forget(robot);
    memset(console->failsafe->told, 0, sizeof console->failsafe->told); // others take their places
    return 0;
}

/* Of the conditions in `alarms`, number `index`, if it is one. */
static void tell_alarm(struct printer *printer, uint8_t alarms, uint8_t index)
{
    uint8_t bit = (uint8_t)(1u << index);

    if (!(alarms & bit))
        return;
    printer->values[0] = printer_text_at(TEXT_CONDITION_VOLTAGE, index);
    printer_text(printer, alarms & (bit - 1) ? TEXT_ALARMS_MORE : TEXT_ALARMS);
}

/* "servo 1: here, torque on, held: stopped" and so on, a part of it at a time. */
NOINLINE static void servo_part(struct printer *printer, const struct cds_servos *servos,
                                const struct cds_servo_state *servo, uint8_t part)
{
    switch (part) {
    case PART_STATE:
        printer->values[0] = servo->id;
        printer->values[1] = servo->torque ? TEXT_ON : TEXT_OFF;
        printer_text(printer, printer_text_at(TEXT_PRESENCE_UNKNOWN, servo->presence));
        break;
    case PART_LOST:
        if (servo->inhibits & CDS_INHIBIT_STATE_LOST)
            printer_text(printer, TEXT_HELD_LOST);
        break;
    case PART_STOPPED:
        if (cds_servos_inhibits(servos, servo) & CDS_INHIBIT_STOPPED)
            printer_text(printer, TEXT_HELD_STOPPED);
        break;
    case PART_END: printer_end_of_line(printer); break;
    default:
        tell_alarm(printer, servo->alarms & CDS_ERRORS_OF_CONDITION, (uint8_t)(part - PART_ALARMS));
        break;
    }
}

bool servos_poll(struct console *console)
{
    const struct robot *robot = console->robot;
    uint8_t *index = &console->index;
    uint8_t *part = &console->part;

    if (robot->servos.count == 0) {
        printer_line(&console->printer, TEXT_NOBODY);
        return false;
    }
    servo_part(&console->printer, &robot->servos, &robot->states[*index], (*part)++);
    if (*part == PARTS) {
        *part = PART_STATE;
        (*index)++;
    }
    return *index < robot->servos.count;
}
