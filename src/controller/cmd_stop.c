/* stop, release, servos: who is held, and why. */
#include <stddef.h>

#include "console.h"
#include "errors.h"
#include "handlers.h"
#include "reply.h"

/* ---- stop ---- */

uint8_t stop_begin(struct console *console)
{
    robot_stop(console->robot);
    return 0;
}

static const char *outcome_text(uint8_t outcome)
{
    switch (outcome) {
    case CDS_STOP_ON: return ": torque is on still";
    case CDS_STOP_SILENT: return ": no answer";
    case CDS_STOP_MUTE: return ": told, but set not to answer";
    default: return ": not looked at";
    }
}

/* Waits until it is over, whoever began it, then tells of those that are not known to be off. */
bool stop_poll(struct console *console)
{
    const struct robot *robot = console->robot;
    uint8_t *index = &console->job.progress.index;

    if (robot->stopping || robot->stop_waits)
        return true;
    console->error = robot->stop.result;
    while (*index < robot->roster.count) {
        uint8_t at = (*index)++;

        if (robot->outcomes[at] == CDS_STOP_OFF)
            continue;
        writer_string(&console->writer, "servo ");
        writer_decimal(&console->writer, robot->servos[at].id);
        writer_string(&console->writer, outcome_text(robot->outcomes[at]));
        writer_end_of_line(&console->writer);
        return true;
    }
    return false;
}

uint8_t release_begin(struct console *console)
{
    struct robot *robot = console->robot;
    struct cds_roster_servo *servo = NULL;

    if (robot->stopping || robot->stop_waits)
        return ERROR_STOPPED;
    if (console->line.id != CDS_BROADCAST_ID) {
        servo = cds_roster_find(&robot->roster, console->line.id);
        if (servo == NULL)
            return ERROR_NOT_KNOWN;
    }
    cds_roster_release(&robot->roster, servo);
    return 0;
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
    if (robot->stopping || robot->stop_waits)
        return ERROR_STOPPED;
    robot_forget(robot);
    return 0;
}

static const char *presence_text(uint8_t presence)
{
    switch (presence) {
    case CDS_PRESENCE_HERE: return ": here";
    case CDS_PRESENCE_AWAY: return ": away";
    case CDS_PRESENCE_BACK: return ": back, being looked at";
    default: return ": not asked yet";
    }
}

/* "servo 1: here, torque on, held: stopped" and so on, a part of it at a time. */
static void servo_part(struct console *console, const struct cds_roster_servo *servo, uint8_t part)
{
    struct writer *writer = &console->writer;
    uint8_t alarms = servo->alarms & CDS_ERRORS_OF_CONDITION;

    switch (part) {
    case PART_STATE:
        writer_string(writer, "servo ");
        writer_decimal(writer, servo->id);
        writer_string(writer, presence_text(servo->presence));
        writer_string(writer, servo->torque ? ", torque on" : ", torque off");
        break;
    case PART_LOST:
        if (servo->held & CDS_HOLD_LOST)
            writer_string(writer, ", held: lost its state, torque went off");
        break;
    case PART_STOPPED:
        if (servo->held & CDS_HOLD_STOPPED)
            writer_string(writer, ", held: stopped");
        break;
    case PART_ALARMS:
        while (alarms) {
            writer_string(writer, alarms == (servo->alarms & CDS_ERRORS_OF_CONDITION) ? ", alarms: "
                                                                                      : " + ");
            alarms = reply_condition(writer, alarms);
        }
        break;
    default: writer_end_of_line(writer); break;
    }
}

bool servos_poll(struct console *console)
{
    static const CDS_FLASH char nobody[] = "none is known: scan finds them";
    const struct robot *robot = console->robot;
    uint8_t *index = &console->job.progress.index;
    uint8_t *part = &console->job.progress.group;

    if (robot->roster.count == 0) {
        writer_text_line(&console->writer, nobody);
        return false;
    }
    servo_part(console, &robot->servos[*index], (*part)++);
    if (*part == PARTS) {
        *part = PART_STATE;
        (*index)++;
    }
    return *index < robot->roster.count;
}
