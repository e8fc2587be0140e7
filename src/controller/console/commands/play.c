/* play, pause, resume, motion: plays a stored sequence, and what goes on. */
#include <stddef.h>

#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/commands/stored.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"
#include "robot/moves.h"

static const CDS_FLASH char message_none[] = "motion: none";
static const CDS_FLASH char message_move[] = "motion: a move%s";
static const CDS_FLASH char message_plays[] = ": step %u of %u, run %u%s";
static const CDS_FLASH char message_name[] = "motion: ";
static const CDS_FLASH char message_paused[] = ", paused";

/* ---- play ---- */

struct play_job {
    struct move_job move; // first: moves_command_poll()
    struct stored_joints joints;
    uint16_t repeats;
    uint8_t percent;
    uint8_t place;   // of the sequence
    uint8_t step;    // that is checked next
    bool is_checked; // all steps are
};

_Static_assert(sizeof(struct play_job) <= CONSOLE_JOB_SIZE, "the job must fit");

static struct play_job *play_job(struct console *console)
{
    return console_job(console);
}

/* Number `index` of the line, if there is one, is the share of the speed. */
static uint8_t take_percent(struct console *console, uint8_t index)
{
    struct play_job *job = play_job(console);
    uint8_t error;

    job->percent = 100;
    if (index == console->line.numbers)
        return 0;
    error = number_percent(&console->line.number[index], &job->percent);
    return error == ERROR_OUT_OF_RANGE || (error == 0 && (job->percent < 10 || job->percent > 200))
               ? (uint8_t)ERROR_OVERRIDE
               : error;
}

/* Plays the sequence `repeats` times, 0: for ever. The share is number `index` of the line. */
static uint8_t play(struct console *console, uint16_t repeats, uint8_t index)
{
    struct play_job *job = play_job(console);
    uint8_t error = take_percent(console, index);

    if (console->robot->moves == NULL) // the chip has no room for them
        return ERROR_OMITTED;
    job->repeats = repeats;
    if (error == 0 && moves_are_under_way(console->robot))
        error = ERROR_MOTION;
    if (error == 0)
        error = stored_may_read();
    if (error == 0)
        error = stored_group(console);
    if (error)
        return error;
    job->place = stored_find(console, MOTION_STORE_SEQUENCE, 0);
    return job->place == MOTION_STORE_NONE ? (uint8_t)ERROR_NO_SEQUENCE
                                           : moves_command_begin(console);
}

static uint8_t play_begin(struct console *console)
{
    return play(console, 1, 0);
}

static uint8_t loop_begin(struct console *console)
{
    return play(console, 0, 0);
}

static uint8_t times_begin(struct console *console)
{
    uint8_t error = console_number(console, 0, CDS_UNIT_NUMBER);

    if (error == 0 && console->raw == 0)
        error = ERROR_OUT_OF_RANGE;
    return error ? error : play(console, console->raw, 1);
}

/* Checks one step in each call: is its pose there, for servos of the group? */
static bool check_step(struct console *console)
{
    struct play_job *job = play_job(console);
    uint16_t pose[ROBOT_SERVOS];
    struct motion_store_step step;
    uint8_t place;

    if (!motion_store_read_step(stored(), job->place, job->step++, &step)) {
        job->is_checked = true;
        return true;
    }
    if (job->step == 1)
        stored_joints_find(&job->joints, stored(), console->robot);
    place = motion_store_pose_of(stored(), step.pose);
    console->error = place == MOTION_STORE_NONE
                         ? (uint8_t)ERROR_POSE_GONE
                         : stored_pose_error(stored_pose_read(stored(), &job->joints, place, pose));
    return console->error == 0;
}

static enum cds_result begin_sequence(struct console *console, bool ends_cycle)
{
    const struct play_job *job = play_job(console);

    return moves_play(console->robot, stored(), job->place, job->repeats, job->percent, ends_cycle);
}

static bool play_poll(struct console *console)
{
    return play_job(console)->is_checked ? moves_command_poll(console, begin_sequence)
                                         : check_step(console);
}

/* ---- pause, resume, motion ---- */

static uint8_t no_motion(const struct console *console)
{
    return console->robot->moves ? (uint8_t)ERROR_NO_MOTION : (uint8_t)ERROR_OMITTED;
}

static uint8_t pause_begin(struct console *console)
{
    if (!moves_are_under_way(console->robot))
        return no_motion(console);
    moves_pause(console->robot);
    return 0;
}

static uint8_t resume_begin(struct console *console)
{
    if (!moves_are_under_way(console->robot))
        return no_motion(console);
    moves_resume(console->robot);
    return 0;
}

enum choice { CHOICE_NONE, CHOICE_WAIT, CHOICE_OFF } __attribute__((packed));

static uint8_t motion_begin(struct console *console)
{
    if (console->robot->moves == NULL)
        return ERROR_OMITTED;
    if (console->line.choice != CHOICE_OFF)
        return 0;
    if (!moves_are_under_way(console->robot))
        return ERROR_NO_MOTION;
    moves_end(console->robot);
    return 0;
}

/* Prints "motion: walk: step 2 of 3, run 1, paused". */
static void print_motion(struct console *console)
{
    const struct moves *moves = console->robot->moves;
    const struct player *player = &moves->player;
    struct printer *printer = &console->printer;
    const CDS_FLASH char *paused = player->is_paused ? message_paused : message_nothing;
    char name[MOTION_STORE_NAME + 1];

    printer->values[0].text = paused;
    if (!moves_are_under_way(console->robot)) {
        printer_line(printer, message_none);
    } else if (!moves_is_playing(console->robot)) {
        printer_line(printer, message_move);
    } else {
        printer_flash(printer, message_name);
        if (motion_store_read_name(stored(), MOTION_STORE_SEQUENCE, player->place, name))
            printer_string(printer, name);
        printer->values[0].number = (uint16_t)(player->sequence.step + 1);
        printer->values[1].number =
            motion_store_number(stored(), MOTION_STORE_SEQUENCE, player->place);
        printer->values[2].number = (uint16_t)(player->sequence.run + 1);
        printer->values[3].text = paused;
        printer_line(printer, message_plays);
    }
}

/* How the last motion has ended. */
static uint8_t outcome(const struct moves *moves)
{
    uint8_t result = moves->player.sequence.result;

    if (moves->follow.result == CDS_TIMEOUT)
        return ERROR_STUCK;
    return result == CDS_OK || result == CDS_CANCELLED ? moves->motion.result : result;
}

static uint8_t joint_of(const struct moves *moves)
{
    return moves->follow.result == CDS_TIMEOUT ? moves->follow.joint : moves->motion.joint;
}

static bool motion_poll(struct console *console)
{
    const struct robot *robot = console->robot;

    if (console->line.choice == CHOICE_NONE) {
        print_motion(console);
        return false;
    }
    if (console->line.choice == CHOICE_WAIT && console_key(console)) {
        console->error = ERROR_KEY;
        return false;
    }
    if (moves_are_under_way(robot))
        return true;
    if (console->line.choice == CHOICE_OFF)
        return robot->cycle && robot->moves->ends_cycle;
    console->error = outcome(robot->moves);
    if (console->error == CDS_PENDING)
        console->error = ERROR_STOPPED;
    else if (console->error == CDS_CANCELLED)
        console->error = ERROR_NO_MOTION; // it was ended
    else if (console->error)
        motion_failed(console, joint_of(robot->moves));
    return false;
}

static const CDS_FLASH struct command play_rows[] = {
    {
        .usage = FLASH_TEXT("play NAME [at PERCENT]"),
        .what = FLASH_TEXT("play a stored sequence"),
        .details = COMMAND_DETAILS("With the servos of the group; without a group those of all "
                                   "stored poses. PERCENT: 10 to "
                                   "200% of the speed, as far as the servos can. ok: the motion "
                                   "has begun. A cycle that it "
                                   "starts ends with it"),
        .example = COMMAND_DETAILS("play walk at 80%"),
        .begin = play_begin,
        .poll = play_poll,
    },
    {
        .usage = FLASH_TEXT("play NAME times N [at PERCENT]"),
        .what = FLASH_TEXT("play a stored sequence several times"),
        .details = COMMAND_DETAILS("N: 1 to 65535"),
        .example = COMMAND_DETAILS("play walk times 3"),
        .begin = times_begin,
        .poll = play_poll,
    },
    {
        .usage = FLASH_TEXT("play NAME loop [at PERCENT]"),
        .what = FLASH_TEXT("play a stored sequence again and again"),
        .details = COMMAND_DETAILS("Until motion off"),
        .example = COMMAND_DETAILS("play walk loop"),
        .begin = loop_begin,
        .poll = play_poll,
    },
    {
        .usage = FLASH_TEXT("pause"),
        .what = FLASH_TEXT("stop the motion on its way"),
        .details = COMMAND_DETAILS("All servos come to rest together, with torque"),
        .example = COMMAND_DETAILS("pause"),
        .begin = pause_begin,
    },
    {
        .usage = FLASH_TEXT("resume"),
        .what = FLASH_TEXT("go on with the motion"),
        .details = COMMAND_DETAILS("From where pause has stopped it"),
        .example = COMMAND_DETAILS("resume"),
        .begin = resume_begin,
    },
    {
        .usage = FLASH_TEXT("motion [wait|off]"),
        .what = FLASH_TEXT("show the motion, wait for its end, or end it"),
        .details = COMMAND_DETAILS(
            "wait: answers when it has ended, as it has ended; any key ends the wait. off: the "
            "servos come to rest on their way, with torque"),
        .example = COMMAND_DETAILS("motion wait"),
        .begin = motion_begin,
        .poll = motion_poll,
    },
};

const CDS_FLASH struct command_group play_commands = {
    .rows = play_rows,
    .count = sizeof play_rows / sizeof play_rows[0],
};
