/* id, baud, factory, lock: what a servo keeps. */
#include "console/console.h"
#include "console/errors.h"
#include "console/handlers.h"
#include "console/messages.h"

/* ---- ID, baud rate, factory values: a transaction ---- */

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
    uint8_t error = robot_claim(robot, ROBOT_IDENTITY);

    if (error)
        return error;
    if (change == CDS_IDENTITY_RESET_ALL)
        cds_servos_allow_reset(&robot->servos, true); // until the operation has ended
    return robot_begun(robot, cds_identity_begin(&robot->work.identity, &config));
}

uint8_t id_begin(struct console *console)
{
    return change_begin(console, CDS_IDENTITY_ID, console->line.to);
}

uint8_t baud_begin(struct console *console)
{
    uint8_t error = console_number(console, 0, CDS_UNIT_BPS);

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

/* Where it answers, as `sentence` says it. */
static void tell_place(struct console *console, uint16_t sentence,
                       const struct cds_identity_place *place)
{
    console->printer.values[0] = place->id;
    console->printer.values[1] = place->baud_reg;
    console->printer.values[2] =
        cds_units_baud_is_kept(place->baud_reg) ? TEXT_NOTHING : TEXT_UNTIL_POWER_OFF;
    printer_line(&console->printer, sentence);
}

static bool conclude(struct console *console)
{
    const struct cds_identity *identity = &console->robot->work.identity;

    console->servo_error = identity->error;
    switch (identity->state) {
    case CDS_IDENTITY_CHANGED: tell_place(console, TEXT_PLACE, &identity->to); return false;
    case CDS_IDENTITY_TAKEN: console->error = ERROR_PLACE_TAKEN; return false;
    case CDS_IDENTITY_LOST: // or it was never there
        console->error = identity->is_written ? (uint8_t)ERROR_LOST : identity->steps.result;
        return false;
    case CDS_IDENTITY_BOTH: console->error = ERROR_BOTH; return false;
    default: console->error = identity->steps.result; break;
    }
    if (identity->state == CDS_IDENTITY_UNCHANGED)
        tell_place(console, TEXT_UNCHANGED_PLACE, &identity->from);
    return false;
}

bool identity_poll(struct console *console)
{
    return console->robot->operation == ROBOT_IDENTITY || conclude(console);
}

/* ---- settings that are written only if they differ ---- */

static uint8_t begin(struct console *console, struct cds_setup_config *config)
{
    config->bus = console->bus;
    config->request = console->line.request;
    config->id = console->line.id;
    return (uint8_t)cds_setup_begin(&console_job(console)->set.setup, config);
}

uint8_t lock_begin(struct console *console)
{
    return begin(console, &(struct cds_setup_config){.setting = CDS_SETUP_LOCK});
}

uint8_t setup_write(struct console *console, uint8_t address, const uint8_t *data, uint8_t length)
{
    return begin(console, &(struct cds_setup_config){.setting = CDS_SETUP_REGISTERS,
                                                     .address = address,
                                                     .length = length,
                                                     .data = data});
}

bool setup_waits(struct console *console)
{
    struct cds_setup *setup = &console_job(console)->set.setup;

    if (cds_setup_poll(setup) == CDS_PENDING)
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
                     console_job(console)->set.setup.is_written ? TEXT_WRITTEN : TEXT_UNCHANGED);
    return false;
}
