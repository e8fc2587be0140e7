/* diagnose: why does it not answer? */
#include "console.h"
#include "errors.h"
#include "handlers.h"
#include "texts.h" // PACKED_...

#define TEXT(name, number, text, remedy)                                                           \
    static const CDS_FLASH char text_##name[] = PACKED_finding_##name;
CDS_FINDINGS(TEXT)
#undef TEXT

static const CDS_FLASH char *const CDS_FLASH texts[] = {
#define TEXT(name, number, text, remedy) [number] = text_##name,
    CDS_FINDINGS(TEXT)
#undef TEXT
};

uint8_t diagnose_begin(struct console *console)
{
    struct robot *robot = console->robot;
    uint8_t error = robot_claim(robot, ROBOT_DIAGNOSE);

    if (error)
        return error;
    return robot_begun(robot, cds_diagnose_begin(&robot->work.diagnose, console->bus,
                                                 console->line.request, console->line.id));
}

/* "ID 5 at 57600bps: 12V": whom it is about, and the value that the finding has. */
static void tell_who(struct console *console, const struct cds_diagnose *diagnose)
{
    struct writer *writer = &console->writer;

    WRITER_TEXT(writer, "ID ");
    writer_decimal(writer, diagnose->found_id);
    WRITER_TEXT(writer, " at ");
    number_write(writer, CDS_UNIT_BPS, diagnose->found_baud);
    switch (diagnose->finding) {
    case CDS_FINDING_SLOW:
        WRITER_TEXT(writer, ", waits us ");
        writer_decimal(writer, diagnose->value);
        break;
    case CDS_FINDING_LOW_SUPPLY:
    case CDS_FINDING_HIGH_SUPPLY:
        WRITER_TEXT(writer, ", supply mV ");
        writer_decimal(writer, diagnose->value);
        break;
    case CDS_FINDING_OVERHEATED:
        WRITER_TEXT(writer, ", hot C ");
        writer_decimal(writer, diagnose->value);
        break;
    default: break;
    }
    writer_end_of_line(writer);
}

/* "asked 20, answered 20, damaged 0, silent 0" */
static void tell_tally(struct console *console, const struct cds_diagnose *diagnose)
{
    struct writer *writer = &console->writer;

    WRITER_TEXT(writer, "asked ");
    writer_decimal(writer, diagnose->total.asked);
    WRITER_TEXT(writer, ", answered ");
    writer_decimal(writer, diagnose->total.answered);
    WRITER_TEXT(writer, ", damaged ");
    writer_decimal(writer, diagnose->total.damaged);
    WRITER_TEXT(writer, ", silent ");
    writer_decimal(writer, diagnose->total.silent);
    writer_end_of_line(writer);
}

static bool tell(struct console *console, uint8_t line)
{
    const struct cds_diagnose *diagnose = &console->robot->work.diagnose;
    uint8_t finding = diagnose->finding;

    switch (line) {
    case 0:
        WRITER_TEXT(&console->writer, "finding ");
        writer_decimal(&console->writer, finding);
        WRITER_TEXT(&console->writer, ": ");
        writer_text_line(&console->writer,
                         texts[finding < sizeof texts / sizeof texts[0] ? finding : 0]);
        return true;
    case 1: tell_tally(console, diagnose); return diagnose->found_id != CDS_DIAGNOSE_NOBODY;
    default: tell_who(console, diagnose); return false;
    }
}

bool diagnose_poll(struct console *console)
{
    struct robot *robot = console->robot;

    if (robot->operation == ROBOT_DIAGNOSE) {
        if (console_key(console))
            robot_abort(robot);
        return true;
    }
    if (robot->result != CDS_OK) {
        console->error = robot->result == CDS_CANCELLED ? ERROR_KEY : robot->result;
        return false;
    }
    return tell(console, console->index++);
}
