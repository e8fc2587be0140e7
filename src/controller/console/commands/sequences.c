/* SPDX-License-Identifier: MIT */
/* sequence: sequences of stored poses. */
#include <string.h> // memchr()

#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/commands/stored.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"
#include "robot/moves.h"

static const CDS_FLASH char message_sequence[] = "sequence ";
static const CDS_FLASH char message_new[] = " new ";
static const CDS_FLASH char message_add[] = " add ";
static const CDS_FLASH char message_gone[] =
    " step %u: its pose is deleted"; // this line is refused
static const CDS_FLASH char message_dwell[] = " dwell ";
static const CDS_FLASH char message_pass[] = " pass";

enum choice { CHOICE_NEW = 1, CHOICE_ADD };

#define PASS_WORDS 6 // of a line without a number before the pose that ends with "pass"

enum phase { NAME, SAVE } __attribute__((packed));

struct step_job {
    struct motion_store_record record;
    struct motion_store_step step;
};

_Static_assert(sizeof(struct step_job) <= CONSOLE_JOB_SIZE, "the job must fit");

/* ---- new, add ---- */

/* Takes number `index` of the line, a multiple of 10 ms from 10 * `lowest` to 10 * `highest` ms. */
static uint8_t take_time(const struct console *console, uint8_t index, uint16_t lowest,
                         uint16_t highest, uint16_t *time_10ms)
{
    uint32_t ms = 0;
    uint8_t error = number_ms(&console->line.number[index], 10ul * highest, &ms);

    *time_10ms = (uint16_t)(ms / 10);
    if (error == ERROR_OUT_OF_RANGE || (error == 0 && *time_10ms < lowest))
        return ERROR_TIME;
    return error == 0 && ms % 10 ? (uint8_t)ERROR_TIME_STEP : error;
}

uint8_t sequence_take_step(struct console *console, uint8_t first, struct motion_store_step *step)
{
    const struct command_line *line = &console->line;
    uint8_t pose = stored_find(console, MOTION_STORE_POSE, 1);
    uint8_t error = take_time(console, first, 1, MOTION_STORE_TIME_MAX, &step->time_10ms);

    if (error == 0 && line->numbers == first + 2)
        error =
            take_time(console, (uint8_t)(first + 1), 0, MOTION_STORE_DWELL_MAX, &step->dwell_10ms);
    if (error)
        return error;
    if (pose == MOTION_STORE_NONE)
        return ERROR_NO_POSE;
    step->pose = motion_store_number(console_store(), MOTION_STORE_POSE, pose);
    step->passes = line->words == PASS_WORDS + first;
    return 0;
}

static uint8_t step_begin(struct console *console)
{
    struct step_job *job = console_job(console);
    uint8_t place, kept = 0, error = stored_may_write(console);

    if (error == 0 && console->line.choice == CHOICE_ADD && console->new_is_refused)
        error = ERROR_NO_NEW;
    if (error == 0)
        error = sequence_take_step(console, 0, &job->step);
    if (error)
        return error;
    place = stored_find(console, MOTION_STORE_SEQUENCE, 0);
    if (console->line.choice != CHOICE_NEW && place != MOTION_STORE_NONE)
        kept = motion_store_number(console_store(), MOTION_STORE_SEQUENCE, place);
    if (kept == MOTION_STORE_STEPS)
        return ERROR_STEPS;
    job->record = (struct motion_store_record){.kind = MOTION_STORE_SEQUENCE,
                                               .name = parse_name(&console->line, 0),
                                               .length = stored_length(console, 0),
                                               .count = 1,
                                               .kept = kept,
                                               .steps = &job->step};
    return 0;
}

static bool step_poll(struct console *console)
{
    const struct step_job *job = console_job(console);

    if (console->phase == SAVE)
        return stored_save_poll(console);
    if (stored_name_poll(console))
        return true;
    console->phase = SAVE;
    return console->error == 0 && stored_save(console, &job->record);
}

/* ---- show, list, delete ---- */

static uint8_t show_begin(struct console *console)
{
    return stored_show_begin(console, MOTION_STORE_SEQUENCE);
}

/* "1.2s" */
static void print_time(struct printer *printer, uint16_t time_10ms)
{
    printer_fixed(printer, time_10ms, 2);
    printer_char(printer, 's');
}

void sequence_print_way(struct printer *printer, const char *pose,
                        const struct motion_store_step *step)
{
    printer_string(printer, pose);
    printer_char(printer, ' ');
    print_time(printer, step->time_10ms);
    if (step->dwell_10ms) {
        printer_flash(printer, message_dwell);
        print_time(printer, step->dwell_10ms);
    }
    if (step->passes)
        printer_flash(printer, message_pass);
    printer_end_of_line(printer);
}

/* Prints the line that adds the next step of the sequence `name`; for a step with a deleted pose a
 * line that the console refuses, and with it the steps behind it. False: there is no such step. */
static bool print_step(struct console *console, const char *name)
{
    struct printer *printer = &console->printer;
    uint8_t index = (uint8_t)(console->part++ - 1);
    struct motion_store_step step;
    char pose[MOTION_STORE_NAME + 1];

    if (!motion_store_read_step(console_store(), console->index, index, &step))
        return false;
    printer_flash(printer, message_sequence);
    printer_string(printer, name);
    if (!motion_store_read_name(console_store(), MOTION_STORE_POSE,
                                motion_store_pose_of(console_store(), step.pose), pose)) {
        printer->values[0].number = (uint16_t)(index + 1);
        printer_line(printer, message_gone);
        console->error = ERROR_POSE_GONE;
        return true;
    }
    printer_flash(printer, index ? message_add : message_new);
    sequence_print_way(printer, pose, &step);
    return true;
}

/* Prints lines that store the sequences again: "sequence walk add stand 1.2s dwell 0.5s". The name
 * is kept, since reading it checks the whole record. */
static bool show_poll(struct console *console)
{
    char *name = console_job(console);

    if (!stored_next(console, MOTION_STORE_SEQUENCE))
        return false;
    if (console->part == 0 &&
        motion_store_read_name(console_store(), MOTION_STORE_SEQUENCE, console->index, name)) {
        console->part = 1;
        return true;
    }
    if (console->part && print_step(console, name))
        return true;
    console->part = 0;
    console->index++;
    return console->line.names == 0;
}

static bool list_poll(struct console *console)
{
    return stored_list_poll(console, MOTION_STORE_SEQUENCE);
}

static uint8_t delete_begin(struct console *console)
{
    uint8_t place, error = stored_may_write(console);

    if (error)
        return error;
    place = stored_find(console, MOTION_STORE_SEQUENCE, 0);
    if (place != MOTION_STORE_NONE && place == stored_autostart())
        return ERROR_AUTOSTART;
    return stored_delete(console, MOTION_STORE_SEQUENCE);
}

static const CDS_FLASH struct command sequence_rows[] = {
    {
        .usage = FLASH_TEXT("sequence list"),
        .what = FLASH_TEXT("names of the stored sequences"),
        .details = COMMAND_DETAILS("One a line"),
        .begin = stored_list_begin,
        .poll = list_poll,
    },
    {
        .usage = FLASH_TEXT("sequence show [NAME]"),
        .what = FLASH_TEXT("lines that store a sequence again, or all sequences"),
        .details = COMMAND_DETAILS("Send them behind those of pose show"),
        .example = COMMAND_DETAILS("sequence show walk"),
        .begin = show_begin,
        .poll = show_poll,
    },
    {
        .usage = FLASH_TEXT("sequence delete NAME"),
        .what = FLASH_TEXT("delete a stored sequence"),
        .details = COMMAND_DETAILS("Its poses stay. Not the sequence of settings autostart"),
        .example = COMMAND_DETAILS("sequence delete walk"),
        .begin = delete_begin,
        .poll = stored_save_poll,
    },
    {
        .usage = FLASH_TEXT("sequence NAME new|add POSE TIME [dwell TIME]"),
        .what = FLASH_TEXT("store a step of a sequence: the way to a stored pose"),
        .details =
            COMMAND_DETAILS("new: the first step, replaces a sequence of this name; add: "
                            "one more, up to 16. TIME of the way: 10ms to 600s; dwell: rest, "
                            "up to 65.53s; both in steps of 10ms"),
        .example = COMMAND_DETAILS("sequence walk new stand 1.2s dwell 0.5s"),
        .begin = step_begin,
        .poll = step_poll,
    },
    {
        .usage = FLASH_TEXT("sequence NAME new|add POSE TIME pass"),
        .what = FLASH_TEXT("store a step that passes its pose without a stop"),
        .details =
            COMMAND_DETAILS("Servos go on to the next pose, and stop at the end of the last run"),
        .example = COMMAND_DETAILS("sequence walk add lift 0.3s pass"),
        .begin = step_begin,
        .poll = step_poll,
    },
};

/* True if the command of the line is a row of this group. */
static bool is_of_group(const CDS_FLASH struct command *command)
{
    return command >= sequence_rows &&
           command < sequence_rows + sizeof sequence_rows / sizeof sequence_rows[0];
}

/* True if the word that is no word of the command may be "new": it has two of its letters, and does
 * not begin as add, insert or delete do. Or it is the "step" of an exported step without a pose. */
static bool resembles_new(const struct token *token)
{
    static const CDS_FLASH char step[] = "step", new[] = "new", others[] = "aid";
    uint8_t length = token->length < TOKEN_MAX ? token->length : TOKEN_MAX, shared = 0;

    for (const CDS_FLASH char *letter = others; *letter; letter++)
        if (token->text[0] == *letter)
            return false;
    for (const CDS_FLASH char *letter = new; *letter; letter++)
        if (memchr(token->text, *letter, length))
            shared++;
    return shared >= 2 || parse_choice(step, token);
}

/* True if the refused line was, or may have been, a `new`. */
static bool may_be_new(const struct console *console)
{
    const struct command_line *line = &console->line;

    if (!command_set.advise || line->choice)
        return true;
    return line->error != ERROR_COUNT &&
           (line->error != ERROR_UNKNOWN_WORD || resembles_new(&console->token));
}

void sequence_end(struct console *console)
{
    const CDS_FLASH struct command *command = console->line.command;

    if (command_set.motion_words) // the command may be a `play` that Ctrl-X has ended
        fast_steps_end(console->robot);
    if (console->error == ERROR_INPUT_LOST) // of a `new`, perhaps
        console->new_is_refused = true;
    else if (command && is_of_group(command) &&
             !(command->begin == step_begin && console->line.choice == CHOICE_ADD))
        console->new_is_refused =
            command->begin == step_begin && console->error && may_be_new(console);
}

const CDS_FLASH struct command_group sequences_commands = {
    .rows = sequence_rows,
    .count = sizeof sequence_rows / sizeof sequence_rows[0],
};
