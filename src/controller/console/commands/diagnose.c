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
static void tell_who(struct writer *writer, const struct cds_diagnose *diagnose)
{
    writer->values[0] = diagnose->found_id;
    writer->values[1] = diagnose->found_baud_reg;
    writer->values[2] = value_text(diagnose->finding);
    writer->values[3] = diagnose->value;
    writer_line(writer, TEXT_PLACE);
}

static void tell_tally(struct writer *writer, const struct cds_diagnose *diagnose)
{
    writer->values[0] = diagnose->total.asked;
    writer->values[1] = diagnose->total.answered;
    writer->values[2] = diagnose->total.damaged;
    writer->values[3] = diagnose->total.silent;
    writer_line(writer, TEXT_TALLY);
}

static bool tell(struct writer *writer, const struct cds_diagnose *diagnose, uint8_t line)
{
    switch (line) {
    case 0:
        writer->values[0] = diagnose->finding;
        writer->values[1] = writer_text_at(TEXT_FINDING, diagnose->finding);
        writer_line(writer, TEXT_FINDING_IS);
        return true;
    case 1: tell_tally(writer, diagnose); return diagnose->found_id != CDS_NO_ID;
    default: tell_who(writer, diagnose); return false;
    }
}

bool diagnose_poll(struct console *console)
{
    struct robot *robot = console->robot;

    if (console_operates(console, ROBOT_DIAGNOSE))
        return true;
    if (!ROBOT_DIAGNOSES || console->error)
        return false;
    return tell(&console->writer, &robot->work.diagnose, console->index++);
}
