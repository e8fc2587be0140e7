/* SPDX-License-Identifier: MIT */
/* sequence NAME show, set, insert, delete: the steps of a stored sequence by their numbers. Only
 * for chips with room for it. */
#include <stddef.h>

#include "console/commands/command_groups.h"
#include "console/commands/stored.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"

static const CDS_FLASH char message_step_gone[] = "its pose is deleted";

enum edit { EDIT_SET = 1, EDIT_INSERT };

enum phase { TAKE, BEGIN, SAVE } __attribute__((packed));

_Static_assert(MOTION_STORE_STEPS * sizeof(struct motion_store_step) <= CONSOLE_JOB_SIZE,
               "the steps must fit");
_Static_assert(sizeof(struct motion_store_record) <= CDS_REPLY_MAX, "the record must fit");

/* The record, which stays in place while it is stored. The job has no room for it beside the steps.
 */
static struct motion_store_record *record_of(struct console *console)
{
    return (struct motion_store_record *)(void *)console->reply;
}

/* The number of steps of the sequence at place console->index. */
static uint8_t steps_of(const struct console *console)
{
    return motion_store_number(console_store(), MOTION_STORE_SEQUENCE, console->index);
}

/* Stores the place of the sequence in console->index, and the index of step N of the line in
 * console->part. Returns an error or 0. ERROR_OUT_OF_RANGE: N is console->raw, and the number of
 * steps console->part (advice.c prints both). */
static uint8_t find_step(struct console *console)
{
    uint8_t error = stored_may_write(console);

    console->raw = 0;
    if (error == 0)
        error = console_number(console, 0, CDS_UNIT_NUMBER);
    if (error && error != ERROR_OUT_OF_RANGE)
        return error;
    console->index = stored_find(console, MOTION_STORE_SEQUENCE, 0);
    if (console->index == MOTION_STORE_NONE)
        return ERROR_NO_SEQUENCE;
    console->part = steps_of(console);
    if (error || console->raw < 1 || console->raw > console->part)
        return ERROR_OUT_OF_RANGE;
    console->part = (uint8_t)(console->raw - 1);
    return 0;
}

/* set, insert */
static uint8_t edit_begin(struct console *console)
{
    uint8_t error = find_step(console);

    if (error == 0 && console->line.choice == EDIT_INSERT &&
        steps_of(console) == MOTION_STORE_STEPS)
        error = ERROR_STEPS;
    record_of(console)->count = 1;
    return error ? error : sequence_take_step(console, 1, console_job(console));
}

static uint8_t delete_step_begin(struct console *console)
{
    uint8_t error = find_step(console);

    record_of(console)->count = 0;
    if (error || steps_of(console) > 1)
        return error;
    console->part = 1; // steps of the sequence: text_of_step() in advice.c
    return ERROR_OUT_OF_RANGE;
}

/* The record takes the place of all steps from step N on: the new step, if there is one, and the
 * steps behind it. */
static void take_record(struct console *console)
{
    struct motion_store_record *record = record_of(console);
    struct motion_store_step *steps = console_job(console);
    uint8_t count = record->count;
    uint8_t index = (uint8_t)(console->part + (console->line.choice != EDIT_INSERT));

    while (count < MOTION_STORE_STEPS &&
           motion_store_read_step(console_store(), console->index, index++, &steps[count]))
        count++;
    *record = (struct motion_store_record){.kind = MOTION_STORE_SEQUENCE,
                                           .name = parse_name(&console->line, 0),
                                           .length = stored_length(console, 0),
                                           .kept = console->part,
                                           .count = count,
                                           .steps = count ? steps : NULL};
}

/* Reading the steps takes 0.7 ms, and the begin of the save 0.5 ms: two polls, so that a cycle is
 * not late. */
static bool edit_poll(struct console *console)
{
    switch (console->phase) {
    case TAKE:
        console->error = stored_may_write(console); // a packet may have started a motion
        if (console->error)
            return false;
        take_record(console);
        console->phase = BEGIN;
        return true;
    case BEGIN: console->phase = SAVE; return stored_save(console, record_of(console));
    default: return stored_save_poll(console);
    }
}

/* ---- show ---- */

static uint8_t show_steps_begin(struct console *console)
{
    uint8_t error = stored_may_read();

    if (error)
        return error;
    console->index = stored_find(console, MOTION_STORE_SEQUENCE, 0);
    return console->index == MOTION_STORE_NONE ? (uint8_t)ERROR_NO_SEQUENCE : 0;
}

/* "2: stand 1.2s dwell 0.5s" */
static bool show_steps_poll(struct console *console)
{
    struct printer *printer = &console->printer;
    struct motion_store_step step;
    char pose[MOTION_STORE_NAME + 1];

    console->error = stored_may_read();
    if (console->error ||
        !motion_store_read_step(console_store(), console->index, console->part, &step))
        return false;
    printer_decimal(printer, ++console->part);
    printer_flash(printer, message_colon);
    if (motion_store_read_name(console_store(), MOTION_STORE_POSE,
                               motion_store_pose_of(console_store(), step.pose), pose))
        sequence_print_way(printer, pose, &step);
    else
        printer_line(printer, message_step_gone);
    return true;
}

static const CDS_FLASH struct command sequence_step_rows[] = {
    {
        .usage = FLASH_TEXT("sequence NAME show"),
        .what = FLASH_TEXT("steps of a stored sequence with their numbers"),
        .details = COMMAND_DETAILS("N of set, insert and delete. For lines to send: sequence show"),
        .example = COMMAND_DETAILS("sequence walk show"),
        .begin = show_steps_begin,
        .poll = show_steps_poll,
    },
    {
        .usage = FLASH_TEXT("sequence NAME set|insert N POSE TIME [dwell TIME]"),
        .what = FLASH_TEXT("replace step N, or insert a step before it"),
        .details =
            COMMAND_DETAILS("N as 'sequence NAME show' prints it. TIME and dwell: as with add"),
        .example = COMMAND_DETAILS("sequence walk set 2 stand 1.5s"),
        .begin = edit_begin,
        .poll = edit_poll,
    },
    {
        .usage = FLASH_TEXT("sequence NAME set|insert N POSE TIME pass"),
        .what = FLASH_TEXT("replace or insert a step that passes its pose without a stop"),
        .details =
            COMMAND_DETAILS("Servos go on to the next pose, and stop at the end of the last run"),
        .example = COMMAND_DETAILS("sequence walk insert 2 lift 0.3s pass"),
        .begin = edit_begin,
        .poll = edit_poll,
    },
    {
        .usage = FLASH_TEXT("sequence NAME delete N"),
        .what = FLASH_TEXT("delete step N"),
        .details = COMMAND_DETAILS("The steps behind it move up. Its pose stays"),
        .example = COMMAND_DETAILS("sequence walk delete 2"),
        .begin = delete_step_begin,
        .poll = edit_poll,
    },
};

const CDS_FLASH struct command_group sequence_steps_commands = {
    .rows = sequence_step_rows,
    .count = sizeof sequence_step_rows / sizeof sequence_step_rows[0],
};
