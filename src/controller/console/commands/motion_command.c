/* SPDX-License-Identifier: MIT */
/* What play and "pose ... in TIME" share: the start of a motion. */
#include "console/commands/shared.h"
#include "console/errors.h"
#include "console/messages.h"
#include "console/mistake.h" // mistake_is_noise()
#include "console/reply.h"   // reply_conditions
#include "console/unasked.h" // unasked_bus_noise()
#include "robot/motion_start.h"
#include "robot/moves.h"

static const CDS_FLASH char message_stuck_alarm[] =
    "the servo does not follow its goals, and has reported since 'clear': %s; 'torque %i off', "
    "free or unload it: 'diagnose %i'";
static const CDS_FLASH char message_cause[] = "servo %u is the cause";
static const CDS_FLASH char message_in_step[] = "%s in step %u";

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

/* Puts the latched alarm of the servo that is stuck behind values[0], its text. */
static void name_alarm(const struct console *console, uint8_t id, union printer_value *values)
{
    const struct cds_servo_state *servo = cds_servos_find(&console->robot->servos, id);
    uint8_t alarms = servo ? servo->alarms & CDS_ERRORS_OF_CONDITION : 0;

    if (alarms == 0)
        return;
    if (alarms != CDS_ERROR_VOLTAGE)
        alarms &= (uint8_t)~CDS_ERROR_VOLTAGE; // a heavy load lowers the voltage, too
    values[0].text = message_stuck_alarm;
    values[1].text = reply_conditions[reply_condition(alarms)];
}

const CDS_FLASH char *motion_failure(struct console *console, union printer_value *values)
{
    const struct motion_outcome *outcome = motion_outcome(console->robot);
    const struct ended_motion *end = command_set.ended_motion;
    uint8_t error = end ? end->error : console_remedied(console, outcome->result);

    values->text = message_nothing;
    if (outcome->id != CDS_NO_ID && !(end && end->concerns_all)) {
        (values++)->text = message_of_servo;
        values->number = outcome->id;
    }
    (++values)->number = error;
    (++values)->text = end ? end->text : error_text(error);
    if (end && error == ERROR_STUCK)
        name_alarm(console, outcome->id, values);
    printer_set_id(&console->printer, outcome->id);
    return message_end_failed;
}

void motion_print_cause(struct console *console, const struct motion_outcome *outcome)
{
    union printer_value *values = console->printer.values;
    bool is_too_fast = outcome->result == MOTION_TOO_FAST;
    const CDS_FLASH char *message = is_too_fast ? message_too_fast : message_cause;

    if (command_set.motion_words) {
        command_set.motion_words->cause(console, outcome);
        return;
    }
    if (outcome->step != MOTION_NO_STEP) {
        (values++)->text = message;
        message = message_in_step;
    }
    (values++)->number = outcome->id;
    if (is_too_fast) {
        (values++)->number = (uint16_t)outcome->shortest_ms;
        (values++)->number = (uint16_t)(outcome->shortest_ms >> 16);
    }
    values->number = (uint16_t)(outcome->step + 1);
    printer_line(&console->printer, message);
}

void motion_take_outcome(struct console *console, const struct motion_outcome *outcome)
{
    bool has_servo = outcome->id != CDS_NO_ID;

    console->error = outcome->result;
    if (outcome->result == CDS_OK || (command_set.noise && motion_concerns_all(console, outcome)))
        return;
    if (has_servo)
        console->robot->servos.refused_id = outcome->id; // error 12 names this servo
    if (has_servo || (command_set.motion_words && outcome->step != MOTION_NO_STEP))
        motion_print_cause(console, outcome);
}

static bool poll_start(struct console *console)
{
    const struct motion_outcome *outcome = &console->robot->moves->start.outcome;

    if (outcome->result == CDS_PENDING)
        return true;
    if (command_set.motion_words && command_set.motion_words->tries_again(console)) {
        console->phase = WAIT;
        return true;
    }
    if (console->error == 0)
        motion_take_outcome(console, outcome);
    if (command_set.motion_words && !console->error)
        command_set.motion_words->warn(console);
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
        if (command_set.ended_motion) {
            command_set.ended_motion->is_kept = false;
            command_set.ended_motion->noise_bytes = unasked_bus_noise(console);
        }
        console->error = start(console);
        return console->error == 0;
    case START: return poll_start(console);
    default: return motion_cycle_is_ending(robot);
    }
}
