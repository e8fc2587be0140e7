/* SPDX-License-Identifier: MIT */
/* baud with a list of servos: the bus goes along with them. */
#include "console/commands/shared.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"

static const CDS_FLASH char message_followed[] = "servo %u: at %b%s";
static const CDS_FLASH char message_stays[] = "servo %u: stays at %b: %s";
static const CDS_FLASH char message_bus[] = "bus at %b";
static const CDS_FLASH char message_bus_unsaved[] = "bus at %b: 'save' keeps it over power-off";

static enum cds_result begin_change(struct robot *robot, const void *config)
{
    return baud_change_begin(&robot->work.baud, config);
}

static enum cds_result poll_change(struct robot *robot)
{
    return baud_change_poll(&robot->work.baud);
}

static const CDS_FLASH struct robot_operation baud_change = {.begin = begin_change,
                                                             .poll = poll_change};

/* The rate is in console->raw. */
static uint8_t begin(struct console *console)
{
    struct command_line *line = &console->line;

    return robot_start(console->robot, &baud_change,
                       &(struct baud_change_config){.bus = console->bus,
                                                    .request = line->request,
                                                    .ids = line->request->packet.bytes,
                                                    .count = line->values,
                                                    .baud_reg = (uint8_t)console->raw});
}

/* The error of a servo that has not followed. */
static uint8_t error_of(uint8_t state, uint8_t result)
{
    if (state == CDS_IDENTITY_BOTH || state == CDS_IDENTITY_TAKEN)
        return ERROR_BOTH;
    return result;
}

/* If the servo is known at another rate than the bus, puts that rate into the values of
 * message_servo and returns true. */
static bool put_other_rate(struct console *console, uint8_t id)
{
    const struct cds_servo_state *servo = cds_servos_find(&console->robot->servos, id);

    return servo && servo_put_rate(console, servo);
}

static void print_servo(struct console *console, const struct baud_change *change, uint8_t index)
{
    union printer_value *values = console->printer.values;
    uint8_t state = change->states[index];
    uint8_t error = error_of(state, change->results[index]);

    values[0].number = change->ids[index];
    if (state == CDS_IDENTITY_CHANGED) {
        values[1].number = change->to_baud_reg;
        values[2].text =
            cds_units_baud_is_kept(change->to_baud_reg) ? message_nothing : message_until_power_off;
        printer_line(&console->printer, message_followed);
        return;
    }
    console->error = ERROR_SOME;
    if (command_set.has_room && error == CDS_TIMEOUT &&
        put_other_rate(console, change->ids[index])) {
        printer_line(&console->printer, message_servo);
    } else if (state == CDS_IDENTITY_UNCHANGED) {
        values[1].number = change->from_baud_reg;
        values[2].text = error_text(error);
        printer_line(&console->printer, message_stays);
    } else {
        values[1].text = error_text(error);
        printer_line(&console->printer, message_servo);
    }
}

/* Prints a line for each servo, then the rate of the bus. */
static bool poll(struct console *console)
{
    const struct robot *robot = console->robot;
    const struct baud_change *change = &robot->work.baud;

    if (robot->operation)
        return true;
    if (console->index < change->count) {
        print_servo(console, change, console->index++);
        return true;
    }
    console->printer.values[0].number = console->bus->baud_reg;
    printer_line(&console->printer, command_set.has_room && console_is_for_person(console)
                                        ? message_bus_unsaved
                                        : message_bus);
    return false;
}

const CDS_FLASH struct command_action baud_list = {.begin = begin, .poll = poll};
