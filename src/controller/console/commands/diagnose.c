/* SPDX-License-Identifier: MIT */
/* diagnose: finds out why a servo does not answer. */
#include <stddef.h> // NULL

#include "console/console.h"
#include "console/errors.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/messages.h"

static const CDS_FLASH char message_waits[] = ", return delay %u us";
static const CDS_FLASH char message_supply_mv[] = ", supply %u mV";
static const CDS_FLASH char message_hot[] = ", temperature %u C";
static const CDS_FLASH char message_is_there[] = ": 'bus %b' first";
static const CDS_FLASH char message_another[] = ": another";
static const CDS_FLASH char message_finding_place[] = "ID %u at %b%s";
static const CDS_FLASH char message_tally[] = "asked %u, answered %u, damaged %u, silent %u";
static const CDS_FLASH char message_tally_twice[] =
    "asked %u, answered %u, damaged %u, silent %u; duplicate replies: %u";
static const CDS_FLASH char message_none_examined[] = "no servo examined; packets sent: %u";
static const CDS_FLASH char message_only_one[] =
    "servo %u answers well, as far as the wire shows; 'diagnose ID' examines another; count "
    "the servos: two may agree in every bit";
static const CDS_FLASH char message_own_delay[] =
    "the servo answers later than its own RETURN_DELAY, for which the bus waits; 'write %u "
    "RETURN_DELAY 254', else replace it";
static const CDS_FLASH char message_finding_is[] = "finding %u: %s";

static enum cds_result begin_diagnosis(struct robot *robot, const void *config)
{
    return cds_diagnose_begin(&robot->work.diagnose, config);
}

static enum cds_result poll_diagnosis(struct robot *robot)
{
    return cds_diagnose_poll(&robot->work.diagnose);
}

static void abort_diagnosis(struct robot *robot)
{
    cds_diagnose_abort(&robot->work.diagnose);
}

static const CDS_FLASH struct robot_operation diagnosis = {.begin = begin_diagnosis,
                                                           .poll = poll_diagnosis,
                                                           .abort = abort_diagnosis,
                                                           .changes_rate = true};

/* Only a profile with command_set.advise has flash for the rate that the list of servos knows. */
uint8_t diagnose_servo(struct console *console)
{
    struct robot *robot = console->robot;
    const struct cds_servo_state *servo = command_set.advise ? console_servo(console) : NULL;
    uint8_t error;

    if (command_set.account)
        account_begin(console);
    error = robot_start(robot, &diagnosis,
                        &(struct cds_diagnose_config){.bus = console->bus,
                                                      .request = console->line.request,
                                                      .id = console->line.id});
    if (error == 0 && servo && servo->baud_reg != CDS_SERVOS_UNKNOWN)
        robot->work.diagnose.known_baud_reg = servo->baud_reg;
    return error;
}

/* CDS_FINDING_NONE is never printed: an empty text saves 53 bytes. */
const CDS_FLASH char *const CDS_FLASH diagnose_findings[] = {
#define ROW(name, number, text, remedy)                                                            \
    [number] = (number) == CDS_FINDING_NONE ? message_nothing : FLASH_TEXT(text "; " remedy),
    CDS_FINDINGS(ROW)
#undef ROW
};

/* The message of the finding's value; none if the value is not known. No switch: its table would
 * stand in RAM. */
static const CDS_FLASH char *value_text(uint8_t finding, uint16_t value)
{
    if (finding == CDS_FINDING_SLOW)
        return value ? message_waits : message_nothing;
    if (finding == CDS_FINDING_LOW_SUPPLY || finding == CDS_FINDING_HIGH_SUPPLY)
        return message_supply_mv;
    if (finding == CDS_FINDING_OTHER_ID)
        return message_another;
    return finding == CDS_FINDING_OVERHEATED ? message_hot : message_nothing;
}

/* The servo of the finding, and the value of the finding. */
static void print_who(struct printer *printer, const struct cds_diagnose *diagnose)
{
    printer->values[0].number = diagnose->found_id;
    printer->values[1].number = diagnose->found_baud_reg;
    printer->values[2].text = value_text(diagnose->finding, diagnose->value);
    printer->values[3].number = diagnose->value;
    if (command_set.advise && diagnose->finding == CDS_FINDING_OTHER_RATE) {
        printer->values[2].text = message_is_there;
        printer->values[3].number = diagnose->found_baud_reg;
    }
    printer_line(printer, message_finding_place);
}

static void print_tally(struct printer *printer, const struct cds_diagnose *diagnose)
{
    printer->values[0].number = diagnose->total.asked;
    printer->values[1].number = diagnose->total.answered;
    printer->values[2].number = diagnose->total.damaged;
    printer->values[3].number = diagnose->total.silent;
    if (command_set.advise && diagnose->duplicate_replies) {
        printer->values[4].number = diagnose->duplicate_replies;
        printer_line(printer, message_tally_twice);
    } else {
        printer_line(printer, message_tally);
    }
}

/* No servo got more than a PING. */
static void print_search(struct printer *printer, const struct cds_diagnose *diagnose)
{
    printer->values[0].number = diagnose->transactions;
    printer_line(printer, message_none_examined);
}

/* The line named no servo: the diagnosis has examined one, and others may be on the bus. */
static void put_one_of_several(struct printer *printer, const struct cds_diagnose *diagnose)
{
    printer->values[1].text = message_only_one;
    printer->values[2].number = diagnose->found_id;
}

/* True if the reply comes after the servo's own RETURN_DELAY, for which the bus waits: a longer one
 * in the settings does not help. */
static bool is_late_by_itself(const struct cds_diagnose *diagnose)
{
    return diagnose->finding == CDS_FINDING_SLOW && diagnose->value &&
           diagnose->value <= diagnose->steps.bus->return_delay_us;
}

static bool print_line(struct printer *printer, const struct cds_diagnose *diagnose, uint8_t line,
                       bool is_of_any)
{
    switch (line) {
    case 0:
        printer->values[0].number = diagnose->finding;
        printer->values[1].text = diagnose_findings[diagnose->finding];
        if (command_set.has_room && diagnose->finding == CDS_FINDING_OK && is_of_any)
            put_one_of_several(printer, diagnose);
        if (command_set.has_room && is_late_by_itself(diagnose)) {
            printer->values[1].text = message_own_delay;
            printer->values[2].number = diagnose->found_id;
        }
        printer_line(printer, message_finding_is);
        return true;
    case 1:
        if (command_set.advise && diagnose->total.asked == 0)
            print_search(printer, diagnose);
        else
            print_tally(printer, diagnose);
        return diagnose->found_id != CDS_NO_ID;
    default: print_who(printer, diagnose); return false;
    }
}

static const CDS_FLASH char message_finding_of[] = "servo %u: finding %u: %s";

void diagnose_print_finding(struct console *console)
{
    uint8_t finding = console->robot->work.diagnose.finding;

    if (command_set.account)
        account_end(console);
    console->printer.values[0].number = console->line.id;
    console->printer.values[1].number = finding;
    console->printer.values[2].text = diagnose_findings[finding];
    printer_line(&console->printer, message_finding_of);
}

static bool diagnose_poll(struct console *console)
{
    struct robot *robot = console->robot;

    if (console_operates(console))
        return true;
    if (command_set.account && console->index == 0)
        account_end(console);
    if (console->error)
        return false;
    return print_line(&console->printer, &robot->work.diagnose, console->index++,
                      console->line.id == CDS_BROADCAST_ID);
}

static const CDS_FLASH struct command diagnose_rows[] = {
    {
        .usage = FLASH_TEXT("diagnose [ID|254]"),
        .what = FLASH_TEXT("find why a servo does not answer"),
        .details = COMMAND_DETAILS("No ID: any servo. A key ends it"),
        .example = COMMAND_DETAILS("diagnose 1"),
        .begin = diagnose_servo,
        .poll = diagnose_poll,
    },
};

const CDS_FLASH struct command_group diagnose_commands = {
    .rows = diagnose_rows,
    .count = sizeof diagnose_rows / sizeof diagnose_rows[0],
};
