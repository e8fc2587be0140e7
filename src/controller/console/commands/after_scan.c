/* SPDX-License-Identifier: MIT */
/* After a scan: which servo answers sooner than this board listens, and which ID two servos have.
 */
#include <string.h>

#include "cds55xx/control_table.h" // CDS_REG_RETURN_DELAY
#include "console/commands/shared.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"

static const CDS_FLASH char message_early[] =
    "servo %u answers after %u us, this board needs %u: 'set %u RETURN_DELAY %uus'";
static const CDS_FLASH char message_return_delay[] =
    "servo %u answers too early: 'write %u RETURN_DELAY %u', then 'scan'";

static const CDS_FLASH char message_powered[] =
    "servos that joined with torque on: %u, for example servo %u; it may be moving: 'stop' "
    "switches torque off";

static const CDS_FLASH char message_noisy[] =
    "replies were damaged, so an ID above may be no servo: %s; then 'scan' again";

#define TRIES 3 // of a READ: a damaged reply alone is no finding

void after_scan_note(struct console *console)
{
    struct after_scan *job = after_scan_job(console);
    uint8_t id = console->robot->work.scan.scan.id;
    struct cds_stats stats;

    cds_bus_stats(console->bus, &stats);
    if (stats.noise_bytes == job->noise)
        return;
    job->noise = stats.noise_bytes;
    if (console->bus->baud_reg == console->robot->baud_reg && job->suspects < AFTER_SCAN_SUSPECTS &&
        !memchr(job->suspect_ids, id, job->suspects))
        job->suspect_ids[job->suspects++] = id;
}

static void add(struct after_scan *job, uint8_t id, uint8_t kind)
{
    if (memchr(job->ids, id, job->count))
        return;
    job->ids[job->count] = id;
    job->kinds[job->count++] = kind;
}

/* The servos found at the rate of the bus, then the suspects: the diagnosis needs the storage of
 * the scan. */
static void copy_found(struct console *console, struct after_scan *job)
{
    const struct robot *robot = console->robot;
    uint16_t count = robot->work.scan.scan.count;

    for (uint8_t i = 0; i < count && i < ROBOT_SERVOS; i++) {
        const struct cds_scan_found *found = &robot->work.scan.found[i];

        if (command_set.has_room && found->baud_reg != robot->baud_reg)
            job->other_rate = (uint16_t)(found->baud_reg + 1u);
        if (found->baud_reg == robot->baud_reg)
            add(job, found->id, found->result == CDS_OK ? AFTER_SCAN_GOOD : AFTER_SCAN_DAMAGED);
    }
    for (uint8_t i = 0; i < job->suspects; i++)
        add(job, job->suspect_ids[i], AFTER_SCAN_SUSPECT);
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
    if (job->kinds[job->index] != AFTER_SCAN_GOOD) {
        job->phase = AFTER_SCAN_DIAGNOSE;
        begun = diagnose_servo(console) == 0;
    } else {
        job->phase = AFTER_SCAN_READ;
        begun = servo_read(console, 0, CDS_TABLE_SIZE) == CDS_OK;
    }
    if (!begun)
        next(job);
}

/* The READ has succeeded: notes a servo that was not in the list before the search, and has torque.
 */
static void note_torque(const struct console *console, struct after_scan *job)
{
    const struct cds_servo_state *servo = console_servo(console);

    if (!servo || servo - console->robot->states < job->known ||
        !console->line.request->reply[CDS_REG_TORQUE_ENABLE])
        return;
    job->powered++;
    job->powered_id = servo->id;
}

/* For a person: prints once that servos have torque that have just joined, as after a reset of the
 * controller alone. False: there is none. */
static bool tell_torque(struct console *console, struct after_scan *job)
{
    union printer_value *values = console->printer.values;

    if (!job->powered || !console_is_for_person(console))
        return false;
    values[0].number = job->powered;
    values[1].number = job->powered_id;
    printer_line(&console->printer, message_powered);
    job->powered = 0;
    return true;
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
        job->kinds[job->index] = AFTER_SCAN_DAMAGED;
        job->phase = AFTER_SCAN_ASK;
        return;
    }
    if (command_set.has_room && request->result == CDS_OK)
        note_torque(console, job);
    if (request->result == CDS_OK && delay < shortest) {
        values[0].number = values[3].number = console->line.id;
        values[1].number = (uint16_t)(2u * delay);
        values[2].number = values[4].number = (uint16_t)(2u * shortest);
        printer_line(&console->printer, message_early);
    }
    next(job);
}

/* Noise on the line also gives bytes without a packet, of no servo. */
static bool is_told(const struct after_scan *job, uint8_t finding)
{
    return job->kinds[job->index] == AFTER_SCAN_DAMAGED ||
           finding == CDS_FINDING_REPLIES_TOO_EARLY || finding == CDS_FINDING_DUPLICATE_ID;
}

/* True if damaged bytes of no servo were taken for the reply of one. */
static bool is_noise(uint8_t finding)
{
    return command_set.advise && (finding == CDS_FINDING_NOISE || finding == CDS_FINDING_BABBLE);
}

/* Noise: ends the job, as a diagnosis of the next ID would only find the noise again. */
static void tell_noise(struct console *console, struct after_scan *job, uint8_t finding)
{
    if (command_set.account)
        account_end(console);
    console->printer.values[0].text = diagnose_findings[finding];
    printer_line(&console->printer, message_noisy);
    job->index = job->count;
    job->phase = AFTER_SCAN_ASK;
}

/* Prints the finding; of a servo that answers too early also the command that mends it. */
static void tell(struct console *console, struct after_scan *job)
{
    union printer_value *values = console->printer.values;
    uint8_t finding = console->robot->work.diagnose.finding;

    if (is_noise(finding) && is_told(job, finding)) {
        tell_noise(console, job, finding);
        return;
    }
    if (job->phase == AFTER_SCAN_DIAGNOSE) {
        if (is_told(job, finding))
            diagnose_print_finding(console);
        job->phase = AFTER_SCAN_MEND;
        return;
    }
    values[0].number = values[1].number = console->line.id;
    values[2].number = console->robot->servos.shortest_delay;
    if (finding == CDS_FINDING_REPLIES_TOO_EARLY)
        printer_line(&console->printer, message_return_delay);
    next(job);
}

/* The diagnosis has ended. False: a key has ended it, or it has failed. */
static bool end_diagnosis(struct console *console, struct after_scan *job)
{
    if (console->error == 0) {
        tell(console, job);
        return true;
    }
    if (command_set.account)
        account_end(console);
    return false;
}

bool after_scan(struct console *console)
{
    struct after_scan *job = after_scan_job(console);

    if (job->phase == AFTER_SCAN_BEGIN) {
        scan_sum_up(console);
        copy_found(console, job);
        job->phase = AFTER_SCAN_ASK;
        return console->error == 0;
    }
    if (job->phase == AFTER_SCAN_ASK && job->index == job->count)
        return command_set.has_room && tell_torque(console, job);
    if (job->phase == AFTER_SCAN_ASK) {
        ask(console, job);
    } else if (job->phase == AFTER_SCAN_READ) {
        if (console->line.request->result != CDS_PENDING)
            take(console, job);
    } else if (!console_operates(console)) {
        return end_diagnosis(console, job);
    }
    return true;
}
