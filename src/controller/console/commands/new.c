/* SPDX-License-Identifier: MIT */
/* new: guides through the set-up of a new servo. */
#include "console/commands/command_groups.h"
#include "console/commands/shared.h" // account_begin()
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"

/* 4 us: with the factory value 1 a servo may answer before the controller listens, while the host
 * floods the link (docs/bridge.md). */
#define RETURN_DELAY 2

static const CDS_FLASH char message_search[] =
    "step 1 of 4: search at six rates, about %u s; a key ends it";
static const CDS_FLASH char message_search_any[] = "not there: search at all 255 rates";
static const CDS_FLASH char message_mend_all[] =
    "a servo answers too early: its return delay is raised, then search again";
static const CDS_FLASH char message_delay_written[] =
    "its reply is damaged: return delay is written without a reply";
static const CDS_FLASH char message_new_found_at[] =
    "one ID answers: ID %u at %b; connect one servo only: equal ones cannot be told apart";
static const CDS_FLASH char message_delay[] = "step 2 of 4: return delay %u us";
static const CDS_FLASH char message_step_id[] = "step 3 of 4: ID %u becomes %u";
static const CDS_FLASH char message_rate[] = "step 4 of 4: rate %b becomes %b";
static const CDS_FLASH char message_rate_kept[] = "step 4 of 4: the rate is %b already";
static const CDS_FLASH char message_done[] = "servo %u is set up and joins the robot, at %b";
static const CDS_FLASH char message_new_found[] = "id %u at %b";

static enum cds_result begin_new(struct robot *robot, const void *config)
{
    return new_servo_begin(&robot->work.new_servo, config);
}

static enum cds_result poll_new(struct robot *robot)
{
    return new_servo_poll(&robot->work.new_servo);
}

static void abort_new(struct robot *robot)
{
    new_servo_abort(&robot->work.new_servo);
}

/* changes_rate also stops learning: the list of servos may hold another servo of this ID. */
static const CDS_FLASH struct robot_operation new_servo = {
    .begin = begin_new, .poll = poll_new, .abort = abort_new, .changes_rate = true};

static uint8_t begin(struct console *console)
{
    struct cds_servos *servos = &console->robot->servos;

    if (cds_servos_find(servos, console->line.new_id))
        return CDS_LIMIT; // mistake.c names the ID
    if (!robot_has_room(console->robot, &console->line.new_id, 1))
        return ERROR_TOO_MANY;
    if (command_set.has_room)
        account_begin(console);
    return robot_start(console->robot, &new_servo,
                       &(struct new_servo_config){.bus = console->bus,
                                                  .request = console->line.request,
                                                  .servos = servos,
                                                  .id = console->line.new_id,
                                                  .return_delay = RETURN_DELAY});
}

/* Prints what a step does. A step that was left out prints nothing. */
static void print_step(struct console *console, const struct new_servo *servo, uint8_t step)
{
    struct printer *printer = &console->printer;
    union printer_value *values = printer->values;

    switch (step) {
    case NEW_SERVO_SEARCH_LISTED:
        /* 4.5 s for each try of the search */
        values[0].number = (uint16_t)(9u * (1u + console->failsafe->settings->repeats) / 2);
        printer_line(printer, message_search);
        break;
    case NEW_SERVO_MEND_ALL:
        if (servo->mended_all)
            printer_line(printer, message_mend_all);
        break;
    case NEW_SERVO_SEARCH_ANY:
        if (servo->searched_any)
            printer_line(printer, message_search_any);
        break;
    case NEW_SERVO_MEND_DELAY:
        if (servo->found[0].result != CDS_OK)
            printer_line(printer, message_delay_written);
        break;
    case NEW_SERVO_CHECK:
        values[0].number = servo->found[0].id;
        values[1].number = servo->found[0].baud_reg;
        printer_line(printer, message_new_found_at);
        break;
    case NEW_SERVO_SET_DELAY:
        values[0].number = (uint16_t)(2u * servo->config.return_delay);
        printer_line(printer, message_delay);
        break;
    case NEW_SERVO_SET_ID:
        values[0].number = servo->found[0].id;
        values[1].number = servo->config.id;
        printer_line(printer, message_step_id);
        break;
    case NEW_SERVO_SET_RATE:
        values[0].number = servo->first_baud_reg;
        values[1].number = servo->home_baud_reg;
        printer_line(printer,
                     values[0].number == values[1].number ? message_rate_kept : message_rate);
        break;
    default: break;
    }
}

/* Prints the servos that are on the bus, one in each call, then that the new one is not alone. */
static bool print_others(struct console *console, const struct new_servo *servo)
{
    console->error = ERROR_NOT_ALONE;
    if (console->part == servo->count)
        return false;
    console->printer.values[0].number = servo->found[console->part].id;
    console->printer.values[1].number = servo->found[console->part++].baud_reg;
    printer_line(&console->printer, message_new_found);
    return true;
}

/* The error bits with which the servo has refused the step. */
static uint8_t bits_of(const struct new_servo *servo)
{
    if (servo->step == NEW_SERVO_SET_DELAY)
        return servo->work.setup.error;
    return servo->step > NEW_SERVO_SET_DELAY ? servo->work.identity.error : 0;
}

static bool conclude(struct console *console, const struct new_servo *servo)
{
    if (servo->count)
        console->line.id = servo->id;   // an error names it
    if (servo->outcome != NEW_SERVO_OK) // it has joined the robot with the first write
        cds_servos_forget_from(&console->robot->servos, servo->known);
    switch (servo->outcome) {
    case NEW_SERVO_NOT_ALONE: return print_others(console, servo);
    case NEW_SERVO_NONE: console->error = ERROR_NO_SERVO; return false;
    case NEW_SERVO_KNOWN: console->error = ERROR_NOT_NEW; return false;
    case NEW_SERVO_DAMAGED: console->error = ERROR_DAMAGED; return false;
    case NEW_SERVO_LOST: console->error = ERROR_LOST; return false;
    case NEW_SERVO_ENDED: console->error = ERROR_KEY; return false;
    case NEW_SERVO_FAILED:
        console->error = servo->result;
        console->servo_error = bits_of(servo);
        return false;
    default: break;
    }
    robot_add(console->robot, servo->id);
    console->printer.values[0].number = servo->id;
    console->printer.values[1].number = console->bus->baud_reg;
    printer_line(&console->printer, message_done);
    return false;
}

static bool poll(struct console *console)
{
    const struct new_servo *servo = &console->robot->work.new_servo;

    if (servo->step == NEW_SERVO_SEARCH_ANY && console->index > NEW_SERVO_CHECK)
        console->index = NEW_SERVO_SEARCH_ANY; // the servo was found, but its replies are damaged
    if (console->index <= servo->step) {
        print_step(console, servo, console->index++);
        return true;
    }
    if (console_operates(console))
        return true;
    if (command_set.has_room)
        account_end(console);
    return conclude(console, servo);
}

static const CDS_FLASH struct command new_rows[] = {
    {
        .usage = FLASH_TEXT("new NEW"),
        .what = FLASH_TEXT("set up a new servo, alone on the bus"),
        .details =
            COMMAND_DETAILS("NEW: 0 to 253. Finds the servo at any rate; sets its return delay, ID "
                            "and rate for this bus. Writes nothing if another servo answers"),
        .example = COMMAND_DETAILS("new 5"),
        .begin = begin,
        .poll = poll,
    },
};

const CDS_FLASH struct command_group new_commands = {
    .rows = new_rows,
    .count = sizeof new_rows / sizeof new_rows[0],
};
