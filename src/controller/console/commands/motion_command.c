/* SPDX-License-Identifier: MIT */
/* What play and "pose ... in TIME" share: the start of a motion. */
#include "cds55xx/diagnose.h" // CDS_FINDING_NOISE
#include "console/commands/shared.h"
#include "console/errors.h"
#include "console/messages.h"
#include "console/mistake.h" // mistake_is_noise()
#include "robot/motion_start.h"
#include "robot/moves.h"

static const CDS_FLASH char message_cause[] = "servo %u is the cause";
static const CDS_FLASH char message_step_too_fast[] = "servo %u needs %l ms in step %u";

enum phase {
    WAIT,  // until a cycle that is ending has ended
    START, // until the motion has begun, or was refused
    END,   // it was refused: until the cycle that was started for it has ended
} __attribute__((packed));

static bool a_servo_answers(const struct cds_servos *servos)
{
    for (uint8_t i = 0; i < servos->count; i++)
        if (servos->states[i].presence < CDS_PRESENCE_OFFLINE)
            return true;
    return false;
}

bool motion_concerns_all(const struct console *console, const struct motion_outcome *outcome)
{
    return mistake_is_noise(outcome->result) ||
           (outcome->result == CDS_TIMEOUT && !a_servo_answers(&console->robot->servos));
}

const CDS_FLASH char *motion_line_text(const struct console *console, uint8_t error)
{
    if (mistake_is_noise(error))
        return diagnose_findings[CDS_FINDING_NOISE];
    return error == CDS_LINE_BUSY && servos_line_is_low(&console->robot->servos)
               ? diagnose_findings[CDS_FINDING_LINE_LOW]
               : error_text(error);
}

/* "servo 2 needs 92 ms in step 3", or "servo 2 is the cause". */
void motion_take_outcome(struct console *console, const struct motion_outcome *outcome)
{
    union printer_value *values = console->printer.values;
    const CDS_FLASH char *message = message_cause;

    console->error = outcome->result;
    if (outcome->result == CDS_OK || outcome->id == CDS_NO_ID ||
        (command_set.noise && motion_concerns_all(console, outcome)))
        return;
    values[0].number = outcome->id;
    console->robot->servos.refused_id = outcome->id; // error 12 names this servo
    if (outcome->result == MOTION_TOO_FAST) {
        values[1].number = (uint16_t)outcome->shortest_ms;
        values[2].number = (uint16_t)(outcome->shortest_ms >> 16);
        values[3].number = (uint16_t)(outcome->step + 1);
        message = outcome->step == MOTION_NO_STEP ? message_too_fast : message_step_too_fast;
    }
    printer_line(&console->printer, message);
}

static bool poll_start(struct console *console)
{
    const struct motion_outcome *outcome = &console->robot->moves->start.outcome;

    if (outcome->result == CDS_PENDING)
        return true;
    motion_take_outcome(console, outcome);
    console->phase = END;
    return console->error;
}

bool motion_command_poll(struct console *console, uint8_t (*start)(struct console *console))
{
    const struct robot *robot = console->robot;

    switch (console->phase) {
    case WAIT:
        if (motion_cycle_is_ending(robot))
            return true;
        console->phase = START;
        console->error = start(console);
        return console->error == 0;
    case START: return poll_start(console);
    default: return motion_cycle_is_ending(robot);
    }
}
