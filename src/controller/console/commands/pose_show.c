/* SPDX-License-Identifier: MIT */
/* pose list, show: the poses of the store. */
#include "cds55xx/motion.h" // CDS_POSE_NONE
#include "console/commands/command_groups.h"
#include "console/commands/stored.h"
#include "console/console.h"
#include "console/messages.h"

static const CDS_FLASH char message_group_begins[] = "group";
static const CDS_FLASH char message_set_begins[] = "pose set ";
static const CDS_FLASH char message_raw[] = "raw";

struct show_job {
    uint16_t positions[MOTION_STORE_JOINTS];
    uint8_t ids[MOTION_STORE_JOINTS];
    uint8_t count; // of joints
    bool is_last;  // the pose that is printed is the last one
};

static uint8_t show_begin(struct console *console)
{
    return stored_show_begin(console, MOTION_STORE_POSE);
}

/* Begins one of the two lines of the pose at place console->index: "group", or "pose set stand". */
static bool show_line(struct console *console)
{
    struct show_job *job = console_job(console);
    char name[MOTION_STORE_NAME + 1];

    if (!stored_next(console, MOTION_STORE_POSE))
        return false;
    job->count = motion_store_read_joints(console_store(), job->ids);
    if (!motion_store_read_pose(console_store(), console->index, job->positions) ||
        !motion_store_read_name(console_store(), MOTION_STORE_POSE, console->index, name)) {
        console->index++; // it is damaged
        return true;
    }
    if (console->phase == 0) {
        printer_flash(&console->printer, message_group_begins);
    } else {
        printer_flash(&console->printer, message_set_begins);
        printer_string(&console->printer, name);
    }
    console->part = 1;
    return true;
}

/* Prints the ID or the position of the next joint that has a position. */
static void show_joint(struct console *console)
{
    struct show_job *job = console_job(console);
    struct printer *printer = &console->printer;
    uint8_t joint = (uint8_t)(console->part++ - 1);

    if (joint == job->count) {
        printer_end_of_line(printer);
        console->part = 0;
        if (console->phase) {
            console->index++;
            job->is_last = console->line.names;
        }
        console->phase = !console->phase;
        return;
    }
    if (job->positions[joint] == CDS_POSE_NONE)
        return;
    printer_char(printer, ' ');
    printer_decimal(printer, console->phase ? job->positions[joint] : job->ids[joint]);
    if (console->phase)
        printer_flash(printer, message_raw);
}

/* Prints lines that store the poses again: "group 1 2 3", "pose set stand 512raw 448raw 576raw". */
static bool show_poll(struct console *console)
{
    if (console->part) {
        show_joint(console);
        return true;
    }
    return !((struct show_job *)console_job(console))->is_last && show_line(console);
}

static bool list_poll(struct console *console)
{
    return stored_list_poll(console, MOTION_STORE_POSE);
}

static const CDS_FLASH struct command pose_show_rows[] = {
    {
        .usage = FLASH_TEXT("pose list"),
        .what = FLASH_TEXT("names of the stored poses"),
        .details = COMMAND_DETAILS("One a line"),
        .begin = stored_list_begin,
        .poll = list_poll,
    },
    {
        .usage = FLASH_TEXT("pose show [NAME]"),
        .what = FLASH_TEXT("lines that store a pose again, or all poses"),
        .details = COMMAND_DETAILS("Send them to store the poses elsewhere"),
        .example = COMMAND_DETAILS("pose show stand"),
        .begin = show_begin,
        .poll = show_poll,
    },
};

const CDS_FLASH struct command_group pose_show_commands = {
    .rows = pose_show_rows,
    .count = sizeof pose_show_rows / sizeof pose_show_rows[0],
};
