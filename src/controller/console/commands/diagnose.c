/* diagnose: why does it not answer? */
#include "console/console.h"
#include "console/errors.h"
#include "console/handlers.h"
#include "console/messages.h"

uint8_t diagnose_begin(struct console *console)
{
    struct robot *robot = console->robot;
    uint8_t error;

    if (!ROBOT_DIAGNOSES)
        return ERROR_OMITTED;
    error = robot_claim(robot, ROBOT_DIAGNOSE);
    if (error)
        return error;
    return robot_begun(
        robot, cds_diagnose_begin(&robot->work.diagnose,
                                  &(struct cds_diagnose_config){.bus = console->bus,
                                                                .request = console->line.request,
                                                                .id = console->line.id}));
}

/* What the value of the finding is. Not by a switch: a table for it would stand in RAM. */
static uint16_t value_text(uint8_t finding)
{
    if (finding == CDS_FINDING_SLOW)
        return TEXT_WAITS;
    if (finding == CDS_FINDING_LOW_SUPPLY || finding == CDS_FINDING_HIGH_SUPPLY)
        return TEXT_SUPPLY;
    return finding == CDS_FINDING_OVERHEATED ? TEXT_HOT : TEXT_NOTHING;
}

/* Whom it is about, and the value that the finding has. */
static void tell_who(struct printer *printer, const struct cds_diagnose *diagnose)
{
    printer->values[0] = diagnose->found_id;
    printer->values[1] = diagnose->found_baud_reg;
    printer->values[2] = value_text(diagnose->finding);
    printer->values[3] = diagnose->value;
    printer_line(printer, TEXT_PLACE);
}

static void tell_tally(struct printer *printer, const struct cds_diagnose *diagnose)
{
    printer->values[0] = diagnose->total.asked;
    printer->values[1] = diagnose->total.answered;
    printer->values[2] = diagnose->total.damaged;
    printer->values[3] = diagnose->total.silent;
    printer_line(printer, TEXT_TALLY);
}

static bool tell(struct printer *printer, const struct cds_diagnose *diagnose, uint8_t line)
{
    switch (line) {
    case 0:
        printer->values[0] = diagnose->finding;
        printer->values[1] = printer_text_at(TEXT_FINDING, diagnose->finding);
        printer_line(printer, TEXT_FINDING_IS);
        return true;
    case 1: tell_tally(printer, diagnose); return diagnose->found_id != CDS_NO_ID;
    default: tell_who(printer, diagnose); return false;
    }
}

bool diagnose_poll(struct console *console)
{
    struct robot *robot = console->robot;

    if (console_operates(console, ROBOT_DIAGNOSE))
        return true;
    if (!ROBOT_DIAGNOSES || console->error)
        return false;
    return tell(&console->printer, &robot->work.diagnose, console->index++);
}
