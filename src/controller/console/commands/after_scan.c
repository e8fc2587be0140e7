/* After a scan: which servo answers sooner than this board listens, and which ID two servos have.
 */
#include "cds55xx/control_table.h" // CDS_REG_RETURN_DELAY
#include "console/commands/shared.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"

static const CDS_FLASH char message_early[] =
    "servo %u answers %u us after a packet, this board needs %u: 'set %u RETURN_DELAY %uus'";
static const CDS_FLASH char message_mend[] = "servo %u: 'write %u RETURN_DELAY %u', then 'scan'";

#define TRIES 3 // of a READ: a damaged reply alone is no finding

/* The found servos: the diagnosis needs the storage of the scan. */
static void copy_found(struct console *console, struct after_scan *job)
{
    const struct robot *robot = console->robot;
    uint16_t count = robot->work.scan.scan.count;

    for (; job->count < count && job->count < ROBOT_SERVOS; job->count++) {
        const struct cds_scan_found *found = &robot->work.scan.found[job->count];

        job->ids[job->count] = found->id;
        job->damaged[job->count] = found->result != CDS_OK;
    }
}

static void next(struct after_scan *job)
{
    job->index++;
    job->tries = 0;
    job->phase = AFTER_SCAN_ASK;
}

/* A long reply shows differences that a short one does not: two servos drift apart, and measure
 * different values. */
static void ask(struct console *console, struct after_scan *job)
{
    bool begun;

    console->line.id = job->ids[job->index];
    if (job->damaged[job->index]) {
        job->phase = AFTER_SCAN_DIAGNOSE;
        begun = diagnose_servo(console) == 0;
    } else {
        job->phase = AFTER_SCAN_READ;
        begun = servo_read(console, 0, CDS_TABLE_SIZE) == CDS_OK;
    }
    if (!begun)
        next(job);
}

static void take(struct console *console, struct after_scan *job)
{
    const struct cds_request *request = console->line.request;
    uint8_t shortest = console->robot->servos.shortest_delay;
    uint8_t delay = request->length ? request->reply[CDS_REG_RETURN_DELAY] : shortest;
    union printer_value *values = console->printer.values;

    if (request->result == CDS_CORRUPT && ++job->tries < TRIES) {
        job->phase = AFTER_SCAN_ASK;
        return;
    }
    if (request->result == CDS_CORRUPT) {
        job->damaged[job->index] = true;
        job->phase = AFTER_SCAN_ASK;
        return;
    }
    if (request->result == CDS_OK && delay < shortest) {
        values[0].number = values[3].number = console->line.id;
        values[1].number = (uint16_t)(2u * delay);
        values[2].number = values[4].number = (uint16_t)(2u * shortest);
        printer_line(&console->printer, message_early);
    }
    next(job);
}

/* Prints the finding; of a servo that answers too early also the command that mends it. */
static void tell(struct console *console, struct after_scan *job)
{
    union printer_value *values = console->printer.values;
    uint8_t finding = console->robot->work.diagnose.finding;

    if (job->phase == AFTER_SCAN_DIAGNOSE) {
        diagnose_print_finding(console);
        job->phase = AFTER_SCAN_MEND;
        return;
    }
    values[0].number = values[1].number = console->line.id;
    values[2].number = console->robot->servos.shortest_delay;
    if (finding == CDS_FINDING_REPLIES_TOO_EARLY)
        printer_line(&console->printer, message_mend);
    next(job);
}

bool after_scan(struct console *console)
{
    struct after_scan *job = after_scan_job(console);

    if (job->phase == AFTER_SCAN_BEGIN) {
        scan_sum_up(console);
        copy_found(console, job);
        job->phase = AFTER_SCAN_ASK;
        return console->error == 0 && scan_is_here(console);
    }
    if (job->phase == AFTER_SCAN_ASK && job->index == job->count)
        return false;
    if (job->phase == AFTER_SCAN_ASK) {
        ask(console, job);
    } else if (job->phase == AFTER_SCAN_READ) {
        if (console->line.request->result != CDS_PENDING)
            take(console, job);
    } else if (!console_operates(console)) {
        tell(console, job);
    }
    return true;
}
