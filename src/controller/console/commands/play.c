/* SPDX-License-Identifier: MIT */
/* play, pause, resume, motion: plays a stored sequence, and what goes on. */
#include <stddef.h>

#include "cds55xx/motion.h" // CDS_MOTION_OVERRIDE_MIN
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/commands/stored.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"
#include "robot/motion_start.h"
#include "robot/moves.h"

static const CDS_FLASH char message_none[] = "none";
static const CDS_FLASH char message_none_but[] = "none; 'motion wait' tells the last end";
static const CDS_FLASH char message_starts[] = "starts";
static const CDS_FLASH char message_move[] = "a move%s";
static const CDS_FLASH char message_plays[] = ": step %u of %u, run %u%s";
static const CDS_FLASH char message_motion[] = "motion: ";
static const CDS_FLASH char message_last[] = "last ";
static const CDS_FLASH char message_old_end[] = "no motion is under way; the last one has failed:";
static const CDS_FLASH char message_paused[] = ", paused";

/* Known when the firmware is linked: on a chip without room for motions their code is dropped. */
#define HAS_MOTIONS (command_set.moves != NULL)

/* ---- play ---- */

uint8_t play_take_percent(const struct console *console, uint8_t index, uint8_t *percent)
{
    uint8_t error = number_percent(&console->line.number[index], percent);

    return error == ERROR_OUT_OF_RANGE || (error == 0 && (*percent < CDS_MOTION_OVERRIDE_MIN ||
                                                          *percent > CDS_MOTION_OVERRIDE_MAX))
               ? (uint8_t)ERROR_OVERRIDE
               : error;
}

/* Stores `repeats`, 0: for ever, and the override in the job. The override is number `index` of the
 * line; 100 % if the line has no such number. Returns an error or 0. */
static uint8_t take_options(struct console *console, uint16_t repeats, uint8_t index)
{
    struct play_job *job = console_job(console);

    if (!HAS_MOTIONS)
        return ERROR_OMITTED;
    job->repeats = repeats;
    job->percent = 100;
    return index < console->line.numbers ? play_take_percent(console, index, &job->percent) : 0;
}

static uint8_t once_begin(struct console *console)
{
    return take_options(console, 1, 0);
}

static uint8_t loop_begin(struct console *console)
{
    return take_options(console, 0, 0);
}

static uint8_t times_begin(struct console *console)
{
    uint8_t error = console_number(console, 0, CDS_UNIT_NUMBER);

    if (error == 0 && console->raw == 0)
        error = ERROR_OUT_OF_RANGE;
    return error ? error : take_options(console, console->raw, 1);
}

static uint8_t start(struct console *console)
{
    const struct play_job *job = console_job(console);
    uint8_t place = motion_store_is_saving(console_store())
                        ? (uint8_t)MOTION_STORE_NONE
                        : stored_find(console, MOTION_STORE_SEQUENCE, 0);
    uint8_t error;

    if (command_set.motion_words)
        command_set.motion_words->begin(console);
    error = motion_start_sequence(console->robot, place, job->repeats);
    if (error == 0)
        moves_set_override(console->robot, job->percent);
    return error;
}

static bool play_poll(struct console *console)
{
    return HAS_MOTIONS && motion_command_poll(console, start);
}

/* ---- how the last motion has ended ---- */

/* True if the user must hear of this end. */
static bool is_failure(uint8_t result)
{
    return result != CDS_OK && result != MOTION_NONE && result != ROBOT_STOPPED;
}

/* Prints "motion: servo 2: error 83: a servo does not follow its goals; ..." */
static void print_failure(struct console *console)
{
    printer_flash(&console->printer, message_motion);
    if (command_set.motion_words)
        command_set.motion_words->step(console, motion_outcome(console->robot));
    printer_line(&console->printer, motion_failure(console, console->printer.values));
}

/* ---- pause, resume, motion ---- */

static uint8_t pause_begin(struct console *console)
{
    if (!HAS_MOTIONS)
        return ERROR_OMITTED;
    if (!motion_may_pause(console->robot))
        return ERROR_NO_MOTION;
    moves_pause(console->robot);
    return 0;
}

static uint8_t resume_begin(struct console *console)
{
    if (!HAS_MOTIONS)
        return ERROR_OMITTED;
    if (command_set.motion_words ? !motion_is_paused(console->robot)
                                 : !motion_may_pause(console->robot))
        return ERROR_NO_MOTION;
    moves_resume(console->robot);
    return 0;
}

enum choice { CHOICE_NONE, CHOICE_WAIT, CHOICE_OFF } __attribute__((packed));

static uint8_t motion_begin(struct console *console)
{
    if (!HAS_MOTIONS)
        return ERROR_OMITTED;
    if (console->line.choice != CHOICE_OFF)
        return 0;
    if (!robot_is_in_motion(console->robot))
        return ERROR_NO_MOTION;
    motion_end(console->robot);
    return 0;
}

/* The speed of the step under way: the override, or less if a servo cannot follow. */
static uint16_t percent_of_step(const struct cds_motion *motion)
{
    uint16_t rate = (uint16_t)(motion->rate_goal >> 8); // in 1/256

    return (uint16_t)(rate * 100 + 128) >> 8;
}

/* Prints "none", and how the last motion has failed, or where to read how it has ended. */
static void print_no_motion(struct console *console)
{
    struct printer *printer = &console->printer;

    if (!command_set.motion_words) {
        printer_line(printer, message_none_but);
        return;
    }
    command_set.motion_words->keep_end(console);
    printer_flash(printer, message_none);
    printer_end_of_line(printer);
    if (is_failure(motion_outcome(console->robot)->result)) {
        printer_flash(printer, message_last);
        print_failure(console);
    } else {
        command_set.motion_words->end(console);
    }
}

/* Prints "motion: walk: step 2 of 3, run 1, at 100%", or "paused" in place of the speed. */
static void print_motion(struct console *console)
{
    const struct moves *moves = console->robot->moves;
    const struct player *player = &moves->player;
    struct printer *printer = &console->printer;
    char name[MOTION_STORE_NAME + 1];

    printer_flash(printer, message_motion);
    if (!robot_is_in_motion(console->robot)) {
        print_no_motion(console);
    } else if (motion_is_starting(console->robot)) {
        printer_line(printer, message_starts);
    } else if (!moves_is_playing(console->robot)) {
        printer->values[0].text = moves->is_paused ? message_paused : message_nothing;
        if (command_set.motion_words && moves->motion.is_ending)
            printer->values[0].text = command_set.motion_words->limit(console);
        printer_line(printer, message_move);
    } else {
        if (motion_store_read_name(console_store(), MOTION_STORE_SEQUENCE, player->place, name))
            printer_string(printer, name);
        printer->values[0].number = (uint16_t)(player->sequence.step + 1);
        printer->values[1].number =
            motion_store_number(console_store(), MOTION_STORE_SEQUENCE, player->place);
        printer->values[2].number = (uint16_t)(player->sequence.run + 1);
        printer->values[3].text = moves->is_paused ? message_paused : message_at_percent;
        printer->values[4].number = percent_of_step(&moves->motion);
        if (command_set.motion_words && !moves->is_paused)
            printer->values[3].text = command_set.motion_words->limit(console);
        printer_line(printer, message_plays);
    }
}

/* Prints a line to a person if `motion wait` finds no motion, and the failure of the last one was
 * taken before. False: nothing was printed. */
static bool tell_old_end(struct console *console)
{
    const struct robot *robot = console->robot;

    if (console->step || !console_is_for_person(console) || robot_is_in_motion(robot) ||
        robot->moves->end_is_unreported || !is_failure(motion_outcome(robot)->result))
        return false;
    printer_line(&console->printer, message_old_end);
    return true;
}

static bool motion_poll(struct console *console)
{
    const struct robot *robot = console->robot;

    if (!HAS_MOTIONS)
        return false;
    if (console->line.choice == CHOICE_NONE) {
        print_motion(console);
        return false;
    }
    if (command_set.has_room && console->line.choice == CHOICE_WAIT && tell_old_end(console))
        return true;
    if (console->line.choice == CHOICE_WAIT && console_key(console)) {
        console->error = ERROR_KEY;
        return false;
    }
    if (robot_is_in_motion(robot))
        return true;
    if (console->line.choice == CHOICE_OFF)
        return motion_cycle_is_ending(robot);
    motion_take_outcome(console, motion_outcome(robot));
    moves_take_end(console->robot);
    return false;
}

/* ---- the report of a motion that has failed ---- */

bool play_report(struct console *console)
{
    if (command_set.motion_words)
        command_set.motion_words->keep_end(console);
    if (!printer_ready(&console->printer) || !moves_take_end(console->robot) ||
        !is_failure(motion_outcome(console->robot)->result) || !console_is_for_person(console))
        return false;
    console_move_prompt(console);
    print_failure(console);
    return true;
}

static const CDS_FLASH struct command play_rows[] = {
    {
        .usage = FLASH_TEXT("play NAME [at PERCENT]"),
        .what = FLASH_TEXT("play a stored sequence"),
        .details = COMMAND_DETAILS(
            "PERCENT: 10 to 200% of the speed. "
            "ok: the motion has begun. Without a group: the servos of all stored poses"),
        .example = COMMAND_DETAILS("play walk at 80%"),
        .begin = once_begin,
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
        .begin = pause_begin,
    },
    {
        .usage = FLASH_TEXT("resume"),
        .what = FLASH_TEXT("go on with the motion"),
        .details = COMMAND_DETAILS("From where pause has stopped it"),
        .begin = resume_begin,
    },
    {
        .usage = FLASH_TEXT("motion [wait|off]"),
        .what = FLASH_TEXT("show the motion, wait for its end, or end it"),
        .details = COMMAND_DETAILS("wait: answers at its end; a key ends the "
                                   "wait. off: all servos come to rest together, with torque"),
        .example = COMMAND_DETAILS("motion wait"),
        .begin = motion_begin,
        .poll = motion_poll,
    },
};

const CDS_FLASH struct command_group play_commands = {
    .rows = play_rows,
    .count = sizeof play_rows / sizeof play_rows[0],
};
