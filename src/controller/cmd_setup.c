/* id, baud, factory, lock: what a servo keeps. */
#include "console.h"
#include "errors.h"
#include "handlers.h"
#include "sentences.h"

/* ---- ID, baud rate, factory values: a transaction ---- */

uint8_t id_begin(struct console *console)
{
    struct robot *robot = console->robot;
    uint8_t error = robot_claim(robot, ROBOT_IDENTITY);

    if (error)
        return error;
    return robot_begun(robot, cds_identity_change_id_begin(&robot->work.identity, console->bus,
                                                           console->line.request, console->line.id,
                                                           console->line.to));
}

uint8_t baud_begin(struct console *console)
{
    struct robot *robot = console->robot;
    uint8_t error = console_number(console, 0, CDS_UNIT_BPS);

    if (error == 0)
        error = robot_claim(robot, ROBOT_IDENTITY);
    if (error)
        return error;
    return robot_begun(robot, cds_identity_change_baud_begin(
                                  &robot->work.identity, console->bus, console->line.request,
                                  console->line.id, (uint8_t)console->raw));
}

uint8_t factory_begin(struct console *console)
{
    struct robot *robot = console->robot;
    struct cds_identity *identity = &robot->work.identity;
    struct command_line *line = &console->line;
    bool all = line->id == CDS_BROADCAST_ID;
    uint8_t error = all && !line->choice ? ERROR_FORCE : robot_claim(robot, ROBOT_IDENTITY);

    if (error)
        return error;
    return robot_begun(
        robot, all ? cds_identity_reset_all_begin(identity, console->bus, line->request)
                   : cds_identity_reset_begin(identity, console->bus, line->request, line->id));
}

/* Where it answers, as `sentence` says it. */
static void tell_place(struct console *console, uint16_t sentence,
                       const struct cds_identity_place *place)
{
    console->writer.values[0] = place->id;
    console->writer.values[1] = place->baud;
    console->writer.values[2] =
        cds_units_baud_is_kept(place->baud) ? TEXT_NOTHING : TEXT_UNTIL_POWER_OFF;
    writer_line(&console->writer, sentence);
}

static bool conclude(struct console *console)
{
    const struct cds_identity *identity = &console->robot->work.identity;

    console->servo_error = identity->error;
    switch (identity->state) {
    case CDS_IDENTITY_CHANGED: tell_place(console, TEXT_PLACE, &identity->to); return false;
    case CDS_IDENTITY_TAKEN: console->error = ERROR_PLACE_TAKEN; return false;
    case CDS_IDENTITY_LOST: // or it was never there
        console->error = identity->written ? (uint8_t)ERROR_LOST : identity->result;
        return false;
    case CDS_IDENTITY_BOTH: console->error = ERROR_BOTH; return false;
    default: console->error = identity->result; break;
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

uint8_t lock_begin(struct console *console)
{
    return (uint8_t)cds_setup_lock_begin(&console_job(console)->set.setup, console->bus,
                                         console->line.request, console->line.id);
}

uint8_t setup_write(struct console *console, uint8_t address, const uint8_t *data, uint8_t length)
{
    const struct command_line *line = &console->line;

    return (uint8_t)cds_setup_write_begin(&console_job(console)->set.setup, console->bus,
                                          line->request, line->id, address, data, length);
}

bool setup_waits(struct console *console)
{
    struct cds_setup *setup = &console_job(console)->set.setup;

    if (cds_setup_poll(setup) == CDS_PENDING)
        return true;
    console->error = setup->result;
    console->servo_error = setup->error;
    return false;
}

bool setup_poll(struct console *console)
{
    if (setup_waits(console))
        return true;
    if (console->error == 0)
        writer_line(&console->writer,
                    console_job(console)->set.setup.written ? TEXT_WRITTEN : TEXT_UNCHANGED);
    return false;
}
