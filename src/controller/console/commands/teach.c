/* teach: switches torque off so that a person can turn the servos, and on again where they are. */
#include <string.h>

#include "cds55xx/servo.h" // cds_servo_write_byte()
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"

/* Registers read before torque goes on: from the mode to the present position. */
#define LOOK_FROM   CDS_REG_CW_ANGLE_LIMIT
#define LOOK_SIZE   (CDS_REG_PRESENT_POSITION + 2 - LOOK_FROM)
#define AT_TORQUE   (CDS_REG_TORQUE_ENABLE - LOOK_FROM)
#define AT_POSITION (CDS_REG_PRESENT_POSITION - LOOK_FROM)

enum choice { CHOICE_ON = 1, CHOICE_OFF } __attribute__((packed));
enum phase { LOOK, GOAL, CHECK, TORQUE, DONE } __attribute__((packed));

struct teach_job {
    uint8_t ids[PARSE_LIST_MAX];
    uint8_t count;
    uint8_t error;   // of the first servo that failed
    uint8_t goal[2]; // the present position of the servo, low byte first
};

_Static_assert(sizeof(struct teach_job) <= CONSOLE_JOB_SIZE, "the job must fit");

/* Submits the request of the present phase to servo line.id. Returns enum cds_result. */
static uint8_t send(struct console *console)
{
    const struct teach_job *job = console_job(console);
    const struct command_line *line = &console->line;

    switch (console->phase) {
    case LOOK: return servo_read(console, LOOK_FROM, LOOK_SIZE);
    case GOAL:
        return (uint8_t)cds_servo_write(console->bus, line->request, line->id,
                                        CDS_REG_GOAL_POSITION, job->goal, sizeof job->goal);
    case CHECK: // speed too: the permit wants to know both of a servo with soft limits
        return servo_read(console, CDS_REG_GOAL_POSITION, 4);
    default:
        return (uint8_t)cds_servo_write_byte(console->bus, line->request, line->id,
                                             CDS_REG_TORQUE_ENABLE, line->choice == CHOICE_OFF);
    }
}

/* Begins with servo `index` of the list. False: there is none. */
static bool begin_servo(struct console *console)
{
    const struct teach_job *job = console_job(console);

    if (console->index == job->count)
        return false;
    console->line.id = job->ids[console->index];
    console->phase = console->line.choice == CHOICE_OFF ? LOOK : TORQUE;
    console->part = send(console);
    return true;
}

static uint8_t teach_begin(struct console *console)
{
    const struct command_line *line = &console->line;
    const struct robot *robot = console->robot;
    struct teach_job *job = console_job(console);

    if (robot->operation) // its next goals would move a servo whose torque is on again
        return ERROR_CYCLE;
    job->count = line->values ? line->values : robot->group_count;
    if (job->count == 0)
        return ERROR_NO_GROUP;
    memcpy(job->ids, line->values ? line->request->packet.bytes : robot->group, job->count);
    begin_servo(console);
    return 0;
}

/* Takes the reply of servo line.id, and stores the next phase. Returns an error or 0. */
static uint8_t take_reply(struct console *console)
{
    const uint8_t *reply = console->line.request->reply;
    struct teach_job *job = console_job(console);

    switch (console->phase++) {
    case LOOK:
        if (reply[AT_TORQUE]) // it holds its position: a new goal would move it
            console->phase = DONE;
        memcpy(job->goal, reply + AT_POSITION, sizeof job->goal);
        return reply[0] | reply[1] | reply[2] | reply[3] ? 0 : (uint8_t)ERROR_ENDLESS;
    case CHECK: return memcmp(reply, job->goal, sizeof job->goal) ? (uint8_t)ERROR_GOAL : 0;
    default: return 0;
    }
}

/* Moves one servo on by one request. A servo that fails is left as it is, and printed. */
static bool teach_poll(struct console *console)
{
    struct teach_job *job = console_job(console);
    uint8_t error = console->part; // of the submit

    if (error == 0 && console_waits(console))
        return true;
    if (error == 0)
        error = servo_outcome(console);
    if (error == 0)
        error = take_reply(console);
    if (error == 0 && console->phase < DONE) {
        console->part = send(console);
        return true;
    }
    if (error) {
        servo_failed(console, error);
        if (job->error == 0)
            job->error = error;
    }
    console->index++;
    if (begin_servo(console))
        return true;
    console->error = job->error;
    return false;
}

static const CDS_FLASH struct command teach_rows[] = {
    {
        .usage = FLASH_TEXT("teach on|off [ID...]"),
        .what = FLASH_TEXT("switch torque off to turn servos by hand, and on again where they are"),
        .details = COMMAND_DETAILS(
            "0 to 253; without IDs: the servos of the group. off: the goal becomes the present "
            "position and is read back, then torque goes on; nothing moves"),
        .example = COMMAND_DETAILS("teach on 1 2 3"),
        .begin = teach_begin,
        .poll = teach_poll,
    },
};

const CDS_FLASH struct command_group teach_commands = {
    .heading = FLASH_TEXT("Motion:"),
    .rows = teach_rows,
    .count = sizeof teach_rows / sizeof teach_rows[0],
};
