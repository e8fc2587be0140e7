/* stop, release, limits, servos: who is held, and why. */
#include <stddef.h>

#include "cds55xx/control_table.h" // CDS_VALUE_MAX
#include "console.h"
#include "errors.h"
#include "handlers.h"
#include "reply.h"
#include "sentences.h"

/* ---- stop ---- */

uint8_t stop_begin(struct console *console)
{
    robot_stop(console->robot);
    return 0;
}

static void tell_outcome(struct writer *writer, uint8_t outcome)
{
    switch (outcome) {
    case CDS_STOP_ON: WRITER_TEXT(writer, ": torque is on still"); break;
    case CDS_STOP_SILENT: WRITER_TEXT(writer, ": no answer"); break;
    case CDS_STOP_MUTE: WRITER_TEXT(writer, ": told, but set not to answer"); break;
    default: WRITER_TEXT(writer, ": not looked at"); break;
    }
}

/* Waits until it is over, whoever began it, then tells of those that are not known to be off. */
bool stop_poll(struct console *console)
{
    const struct robot *robot = console->robot;
    uint8_t *index = &console->index;

    if (robot_is_stopping(robot))
        return true;
    console->error = robot->stop.result;
    while (*index < robot->crew.roster.count) {
        uint8_t at = (*index)++;

        if (robot->outcomes[at] == CDS_STOP_OFF)
            continue;
        WRITER_TEXT(&console->writer, "servo ");
        writer_decimal(&console->writer, robot->servos[at].id);
        tell_outcome(&console->writer, robot->outcomes[at]);
        writer_end_of_line(&console->writer);
        return true;
    }
    return false;
}

uint8_t release_begin(struct console *console)
{
    struct robot *robot = console->robot;
    struct cds_roster_servo *servo = NULL;

    if (robot_is_stopping(robot))
        return ERROR_STOPPED;
    if (console->line.id != CDS_BROADCAST_ID) {
        servo = cds_roster_find(&robot->crew.roster, console->line.id);
        if (servo == NULL)
            return ERROR_NOT_KNOWN;
    } else {
        crew_unhold(&robot->crew);
    }
    cds_roster_release(&robot->crew.roster, servo);
    return 0;
}

/* ---- limits ---- */

uint8_t limits_begin(struct console *console)
{
    const struct command_line *line = &console->line;
    struct cds_roster *roster = &console->robot->crew.roster;
    struct cds_roster_servo *servo = cds_roster_find(roster, line->id);
    uint16_t raw[] = {0, 0, CDS_VALUE_MAX};

    for (uint8_t i = 0; i < line->numbers; i++) {
        uint8_t error =
            number_register(&line->number[i], i < 2 ? CDS_UNIT_MDEG : CDS_UNIT_MRPM, &raw[i]);

        if (error)
            return error;
    }
    if (servo == NULL)
        return ERROR_NOT_KNOWN;
    return cds_roster_set_limits(roster, servo, raw[0], raw[1], raw[2]) == CDS_OK
               ? 0
               : ERROR_OUT_OF_RANGE;
}

/* ---- servos ---- */

enum servos_part { PART_STATE, PART_LOST, PART_STOPPED, PART_ALARMS, PART_END, PARTS };

uint8_t servos_begin(struct console *console)
{
    struct robot *robot = console->robot;

    if (console->line.choice == 0)
        return 0;
    if (robot->operation != ROBOT_IDLE)
        return ERROR_CYCLE;
    if (robot_is_stopping(robot))
        return ERROR_STOPPED;
    robot_forget(robot);
    return 0;
}

static void tell_presence(struct writer *writer, uint8_t presence)
{
    switch (presence) {
    case CDS_PRESENCE_HERE: WRITER_TEXT(writer, ": here"); break;
    case CDS_PRESENCE_AWAY: WRITER_TEXT(writer, ": away"); break;
    case CDS_PRESENCE_BACK: WRITER_TEXT(writer, ": back, being looked at"); break;
    default: WRITER_TEXT(writer, ": not asked yet"); break;
    }
}

/* "servo 1: here, torque on, held: stopped" and so on, a part of it at a time. */
static void servo_part(struct console *console, const struct cds_roster_servo *servo, uint8_t part)
{
    struct writer *writer = &console->writer;
    uint8_t alarms = servo->alarms & CDS_ERRORS_OF_CONDITION;

    switch (part) {
    case PART_STATE:
        WRITER_TEXT(writer, "servo ");
        writer_decimal(writer, servo->id);
        tell_presence(writer, servo->presence);
        if (servo->torque)
            WRITER_TEXT(writer, ", torque on");
        else
            WRITER_TEXT(writer, ", torque off");
        break;
    case PART_LOST:
        if (servo->held & CDS_HOLD_LOST)
            WRITER_TEXT(writer, ", held: lost its state, torque went off");
        break;
    case PART_STOPPED:
        if (servo->held & CDS_HOLD_STOPPED)
            WRITER_TEXT(writer, ", held: stopped");
        break;
    case PART_ALARMS:
        while (alarms) {
            if (alarms == (servo->alarms & CDS_ERRORS_OF_CONDITION))
                WRITER_TEXT(writer, ", alarms: ");
            else
                WRITER_TEXT(writer, " + ");
            alarms = reply_condition(writer, alarms);
        }
        break;
    default: writer_end_of_line(writer); break;
    }
}

bool servos_poll(struct console *console)
{
    const struct robot *robot = console->robot;
    uint8_t *index = &console->index;
    uint8_t *part = &console->part;

    if (robot->crew.roster.count == 0) {
        writer_text_line(&console->writer, sentences[SENTENCE_NOBODY]);
        return false;
    }
    servo_part(console, &robot->servos[*index], (*part)++);
    if (*part == PARTS) {
        *part = PART_STATE;
        (*index)++;
    }
    return *index < robot->crew.roster.count;
}
