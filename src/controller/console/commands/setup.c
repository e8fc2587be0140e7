/* SPDX-License-Identifier: MIT */
/* id, baud, factory, lock: settings of a servo that outlive power-off. */
#include "cds55xx/control_table.h" // CDS_REG_LOCK
#include "console/console.h"
#include "console/errors.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/messages.h"

static const CDS_FLASH char message_place[] = "ID %u at %b%s";
static const CDS_FLASH char message_unchanged_place[] = "unchanged: ID %u at %b";
static const CDS_FLASH char message_written[] = "written";

/* ---- ID, baud rate, factory values: an operation of several transactions ---- */

static enum cds_result end_reset(struct robot *robot, enum cds_result result)
{
    if (result != CDS_PENDING)
        cds_servos_allow_reset(&robot->servos, false);
    return result;
}

static enum cds_result begin_identity(struct robot *robot, const void *config)
{
    const struct cds_identity_config *to = config;
    enum cds_result result;

    if (to->change == CDS_IDENTITY_RESET_ALL)
        cds_servos_allow_reset(&robot->servos, true); // until the operation has ended
    result = cds_identity_begin(&robot->work.identity, to);
    return result == CDS_OK ? CDS_OK : end_reset(robot, result);
}

static enum cds_result poll_identity(struct robot *robot)
{
    return end_reset(robot, cds_identity_poll(&robot->work.identity));
}

static const CDS_FLASH struct robot_operation identity = {.begin = begin_identity,
                                                          .poll = poll_identity};

/* `change`: enum cds_identity_change; `to`: the new ID or baud register. */
static uint8_t change_begin(struct console *console, uint8_t change, uint8_t to)
{
    struct robot *robot = console->robot;
    struct cds_identity_config config = {
        .bus = console->bus,
        .request = console->line.request,
        .change = change,
        .id = console->line.id,
        .new_id = to,
        .new_baud_reg = to,
    };

    return robot_start(robot, &identity, &config);
}

static uint8_t id_begin(struct console *console)
{
    return change_begin(console, CDS_IDENTITY_ID, console->line.new_id);
}

static bool is_baud_list(const struct console *console)
{
    return command_set.baud_list && console->line.values > 1 &&
           console->line.command->begin == baud_begin;
}

uint8_t baud_begin(struct console *console)
{
    uint8_t error = console_number(console, 0, CDS_UNIT_BPS);

    if (error == 0 && is_baud_list(console))
        return command_set.baud_list->begin(console);
    return error ? error : change_begin(console, CDS_IDENTITY_BAUD, (uint8_t)console->raw);
}

uint8_t factory_begin(struct console *console)
{
    const struct command_line *line = &console->line;
    bool all = line->id == CDS_BROADCAST_ID;

    if (all && !line->choice)
        return ERROR_FORCE;
    return change_begin(console, all ? CDS_IDENTITY_RESET_ALL : CDS_IDENTITY_RESET, 0);
}

/* True if a person must hear that servos at the old rate do not answer now. */
static bool must_tell_rate(const struct console *console)
{
    const struct cds_identity *state = &console->robot->work.identity;

    return command_set.explain && state->change == CDS_IDENTITY_BAUD &&
           state->from.baud_reg != state->to.baud_reg && console_is_for_person(console);
}

/* Prints ID and rate of the servo with `message`. */
static void print_place(struct console *console, const CDS_FLASH char *message,
                        const struct cds_identity_place *place)
{
    console->printer.values[0].number = place->id;
    console->printer.values[1].number = place->baud_reg;
    console->printer.values[2].text =
        cds_units_baud_is_kept(place->baud_reg) ? message_nothing : message_until_power_off;
    printer_line(&console->printer, message);
}

/* The operation has ended. Prints the result; true if another line follows: console->raw has its
 * rate then, since the robot may begin another operation before. */
static bool conclude(struct console *console)
{
    const struct cds_identity *state = &console->robot->work.identity;

    console->servo_error = state->error;
    switch (state->state) {
    case CDS_IDENTITY_CHANGED:
        robot_rename(console->robot, state->from.id, state->to.id);
        print_place(console, message_place, &state->to);
        if (command_set.explain && state->change == CDS_IDENTITY_RESET_ALL)
            robot_forget(console->robot); // the IDs of the list are no more
        console->raw = state->from.baud_reg;
        console->index = must_tell_rate(console);
        return console->index;
    case CDS_IDENTITY_TAKEN: console->error = ERROR_PLACE_TAKEN; return false;
    case CDS_IDENTITY_LOST: // or the servo never answered
        console->error = state->is_written ? (uint8_t)ERROR_LOST : state->steps.result;
        return false;
    case CDS_IDENTITY_BOTH: console->error = ERROR_BOTH; return false;
    default: console->error = state->steps.result; break;
    }
    if (state->state == CDS_IDENTITY_UNCHANGED &&
        !(command_set.has_room && console->error == CDS_INHIBITED)) // it would read like success
        print_place(console, message_unchanged_place, &state->from);
    return false;
}

bool setup_has_try(struct console *console, uint8_t result, uint8_t servo_error)
{
    return command_set.set_up_tries &&
           (result == CDS_TIMEOUT || result == CDS_CORRUPT || servo_error & CDS_ERROR_CHECKSUM) &&
           ++console->part < command_set.set_up_tries;
}

/* Begins the command once more if its write was lost or damaged: the servo answers where it was,
 * and only there. Any other end is not retried: the servo may have done what it was told, or has
 * refused it. */
static bool begins_again(struct console *console)
{
    const struct cds_identity *state = &console->robot->work.identity;

    return state->state == CDS_IDENTITY_UNCHANGED && state->is_written &&
           setup_has_try(console, state->steps.result, state->error) &&
           console->line.command->begin(console) == 0;
}

static bool identity_poll(struct console *console)
{
    if (is_baud_list(console))
        return command_set.baud_list->poll(console);
    if (command_set.explain && console->index) {
        bus_print_change(console, (uint8_t)console->raw);
        return false;
    }
    if (console->robot->operation || (command_set.set_up_tries && begins_again(console)))
        return true;
    return conclude(console);
}

/* ---- settings that are written only if they differ ---- */

uint8_t setup_write(struct console *console, uint8_t address, const uint8_t *data, uint8_t length)
{
    return (uint8_t)cds_setup_begin(&set_job(console)->setup,
                                    &(struct cds_setup_config){.bus = console->bus,
                                                               .request = console->line.request,
                                                               .id = console->line.id,
                                                               .setting = CDS_SETUP_REGISTERS,
                                                               .address = address,
                                                               .length = length,
                                                               .data = data});
}

static uint8_t lock_begin(struct console *console)
{
    uint8_t *data = set_job(console)->data;

    data[0] = 1;
    return setup_write(console, CDS_REG_LOCK, data, 1);
}

/* Begins once more, which does no harm: the register is read first, and written only if it differs,
 * so a lock that has come is not sent twice. */
static bool sets_up_again(struct console *console)
{
    struct cds_setup *setup = &set_job(console)->setup;
    bool is_written = setup->is_written;
    uint8_t error;

    if (!setup_has_try(console, setup->steps.result, setup->error))
        return false;
    error = setup_write(console, setup->address, setup->data, setup->length);
    setup->is_written = is_written; // by an earlier try
    return error == 0;
}

bool setup_waits(struct console *console)
{
    struct cds_setup *setup = &set_job(console)->setup;

    if (cds_setup_poll(setup) == CDS_PENDING ||
        (command_set.set_up_tries && sets_up_again(console)))
        return true;
    console->error = setup->steps.result;
    console->servo_error = setup->error;
    return false;
}

bool setup_poll(struct console *console)
{
    if (setup_waits(console))
        return true;
    if (console->error == 0)
        printer_line(&console->printer,
                     set_job(console)->setup.is_written ? message_written : message_unchanged);
    return false;
}

static const CDS_FLASH struct command setup_rows[] = {
    {
        .usage = FLASH_TEXT("id OLD NEW"),
        .what = FLASH_TEXT("set a servo's ID"),
        .details = COMMAND_DETAILS("0 to 253. NEW must be free; if it is OLD, nothing is written"),
        .example = COMMAND_DETAILS("id 1 5"),
        .begin = id_begin,
        .poll = identity_poll,
    },
    {
        .usage = FLASH_TEXT("baud ID RATE"),
        .what = FLASH_TEXT("set a servo's baud rate"),
        .details = COMMAND_DETAILS("RATE: 7843 to 2000000bps. The bus changes "
                                   "with it: other servos answer after 'bus' has changed it back"),
        .example = COMMAND_DETAILS("baud 1 57600bps"),
        .begin = baud_begin,
        .poll = identity_poll,
    },
    {
        .usage = FLASH_TEXT("factory ID|254 [force]"),
        .what = message_factory,
        .details = COMMAND_DETAILS("254 (all servos) only with force: then all have ID 1, and none "
                                   "can be addressed alone"),
        .example = COMMAND_DETAILS("factory 1"),
        .begin = factory_begin,
        .poll = identity_poll,
    },
    {
        .usage = FLASH_TEXT("lock ID"),
        .what = FLASH_TEXT("lock set-up until power-off"),
        .details = COMMAND_DETAILS("Then only 0x18 to 0x23 can be written"),
        .example = COMMAND_DETAILS("lock 1"),
        .begin = lock_begin,
        .poll = setup_poll,
    },
};

const CDS_FLASH struct command_group setup_commands = {
    .heading = FLASH_TEXT("Set-up of servos:"),
    .rows = setup_rows,
    .count = sizeof setup_rows / sizeof setup_rows[0],
};
