/* SPDX-License-Identifier: MIT */
/* pose save, set, delete: the commands that write poses to the store. */
#include <string.h>

#include "cds55xx/control_table.h" // CDS_REG_PRESENT_POSITION
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/commands/stored.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"

static const CDS_FLASH char message_autostart_lost[] =
    "the sequence of 'settings autostart' has this pose: it plays no more";

static const CDS_FLASH char message_sequence_lost[] =
    " has this pose and plays no more: 'sequence NAME show' numbers its steps";
static const CDS_FLASH char message_of_sequence[] = "sequence ";

/* ---- save, set ---- */

enum save_phase { NAME, READ, SAVE_JOINTS, SAVE_POSE } __attribute__((packed));

struct save_job {
    struct motion_store_record record;
    uint16_t positions[MOTION_STORE_JOINTS];
    uint8_t ids[MOTION_STORE_JOINTS]; // of the list of joints
    uint8_t count;                    // of joints
    bool has_new_joints;              // that are not stored yet
};

_Static_assert(sizeof(struct save_job) <= CONSOLE_JOB_SIZE, "the job must fit");

/* Returns the place in the list for a servo that is no joint yet: behind the last one, or, if the
 * list is full, that of a joint that neither the group nor a stored pose has. MOTION_STORE_NONE:
 * there are too many. */
static uint8_t free_joint(const struct robot *robot, const struct save_job *job)
{
    if (job->count < MOTION_STORE_JOINTS)
        return job->count;
    for (uint8_t joint = 0; joint < MOTION_STORE_JOINTS; joint++)
        if (!memchr(robot->group, job->ids[joint], robot->group_count) &&
            !motion_store_uses_joint(console_store(), joint))
            return joint;
    return MOTION_STORE_NONE;
}

/* Servo `id` becomes a joint if it is none yet. False: there are too many. */
static bool add_joint(const struct robot *robot, struct save_job *job, uint8_t id)
{
    uint8_t joint;

    if (memchr(job->ids, id, job->count))
        return true;
    joint = free_joint(robot, job);
    if (joint == MOTION_STORE_NONE)
        return false;
    job->ids[joint] = id;
    job->has_new_joints = true;
    job->count = (uint8_t)(job->count + (joint == job->count));
    return true;
}

/* Returns the place in the pose of the position of servo `id` of the group. */
static uint8_t joint_of(const struct save_job *job, uint8_t id)
{
    return (uint8_t)((const uint8_t *)memchr(job->ids, id, job->count) - job->ids);
}

static uint8_t save_begin(struct console *console)
{
    struct save_job *job = console_job(console);
    const struct robot *robot = console->robot;
    uint8_t error = stored_may_write(console);

    if (error)
        return error;
    if (robot->group_count == 0)
        return ERROR_NO_GROUP;
    if (motion_store_next(console_store(), MOTION_STORE_POSE, 0) != MOTION_STORE_NONE)
        job->count = motion_store_read_joints(console_store(), job->ids);
    memset(job->positions, UINT8_MAX, sizeof job->positions); // CDS_POSE_NONE
    for (uint8_t i = 0; i < robot->group_count; i++)
        if (!add_joint(robot, job, robot->group[i]))
            return ERROR_JOINTS;
    return 0;
}

static uint8_t set_begin(struct console *console)
{
    const struct robot *robot = console->robot;
    struct save_job *job = console_job(console);
    uint8_t error = save_begin(console);

    if (error)
        return error;
    if (console->line.values != robot->group_count)
        return ERROR_GROUP_SIZE;
    for (uint8_t i = 0; i < robot->group_count; i++)
        job->positions[joint_of(job, robot->group[i])] = pose_angle(console, i);
    return 0;
}

static bool save_pose(struct console *console)
{
    struct save_job *job = console_job(console);

    job->record = (struct motion_store_record){.kind = MOTION_STORE_POSE,
                                               .name = parse_name(&console->line, 0),
                                               .length = stored_length(console, 0),
                                               .positions = job->positions};
    console->phase = SAVE_POSE;
    return stored_save(console, &job->record);
}

/* Begins to save the joints if there are new ones, else the pose. */
static bool save(struct console *console)
{
    struct save_job *job = console_job(console);

    if (!job->has_new_joints)
        return save_pose(console);
    job->record = (struct motion_store_record){
        .kind = MOTION_STORE_JOINT_LIST, .count = job->count, .ids = job->ids};
    console->phase = SAVE_JOINTS;
    return stored_save(console, &job->record);
}

/* Asks the next servo of the group where it is. */
static bool read_next(struct console *console)
{
    const struct robot *robot = console->robot;

    if (console->index == robot->group_count)
        return save(console);
    console->line.id = robot->group[console->index];
    console->error = servo_read(console, CDS_REG_PRESENT_POSITION, 2);
    if (console->error)
        servo_failed(console, console->error);
    return console->error == 0;
}

static bool read_poll(struct console *console)
{
    struct save_job *job = console_job(console);
    uint16_t position = 0;

    if (console_waits(console))
        return true;
    console->error = servo_outcome(console);
    if (console->error == 0)
        console->error = (uint8_t)cds_request_word(console->line.request, 0, &position);
    if (console->error) {
        servo_failed(console, console->error);
        return false;
    }
    job->positions[joint_of(job, console->line.id)] = position;
    console->index++;
    return read_next(console);
}

static bool save_poll(struct console *console)
{
    switch (console->phase) {
    case NAME:
        if (stored_name_poll(console))
            return true;
        console->phase = READ;
        if (console->error)
            return false;
        return console->line.values ? save(console) : read_next(console);
    case READ: return read_poll(console);
    case SAVE_JOINTS:
        if (stored_save_poll(console))
            return true;
        if (console->error)
            return false;
        return stored_may_read() || save_pose(console); // the settings may be being saved now
    default: return stored_save_poll(console);
    }
}

/* ---- delete ---- */

enum delete_phase { DELETE, LOOK } __attribute__((packed));

struct delete_job {
    struct motion_store_record record; // of stored_delete()
    uint8_t number;                    // of the pose
    uint8_t place; // of the sequence that is looked at; the sequence of the autostart is the first
    uint8_t step;  // that is compared next
};

static uint8_t delete_begin(struct console *console)
{
    struct delete_job *job = console_job(console);
    uint8_t place, error = stored_may_write(console);

    if (error)
        return error;
    place = stored_find(console, MOTION_STORE_POSE, 0);
    if (place != MOTION_STORE_NONE)
        job->number = motion_store_number(console_store(), MOTION_STORE_POSE, place);
    job->place = stored_autostart();
    return stored_delete(console, MOTION_STORE_POSE);
}

/* Goes on with the next stored sequence. Sets console->part: the sequence of the autostart has been
 * looked at. False: there is none. */
static bool next_sequence(struct console *console)
{
    struct delete_job *job = console_job(console);

    job->step = 0;
    job->place = motion_store_next(console_store(), MOTION_STORE_SEQUENCE, console->index);
    console->index = (uint8_t)(job->place + 1);
    console->part = 1;
    return job->place != MOTION_STORE_NONE;
}

/* Tells that the sequence had the pose. */
static void tell_sequence(struct console *console, uint8_t place)
{
    char name[MOTION_STORE_NAME + 1];

    if (!motion_store_read_name(console_store(), MOTION_STORE_SEQUENCE, place, name))
        return; // its record is damaged
    printer_flash(&console->printer, message_of_sequence);
    printer_string(&console->printer, name);
    printer_line(&console->printer, message_sequence_lost);
}

/* True if there is no such sequence, or it is that of the autostart again. */
static bool is_skipped(const struct console *console, uint8_t place)
{
    return place == MOTION_STORE_NONE || (console->part && place == stored_autostart());
}

/* The pose is deleted. Tells of each sequence that had it: that of the autostart, then the others.
 * Without room in the flash it looks only at the sequence of the autostart. */
static bool look_poll(struct console *console)
{
    struct delete_job *job = console_job(console);
    struct motion_store_step step;

    if (stored_may_read())
        return true;
    if ((command_set.has_room && is_skipped(console, job->place)) ||
        !motion_store_read_step(console_store(), job->place, job->step++, &step))
        return command_set.has_room && next_sequence(console);
    if (step.pose != job->number)
        return true;
    if (command_set.has_room && console->part)
        tell_sequence(console, job->place);
    else
        printer_line(&console->printer, message_autostart_lost);
    return command_set.has_room && next_sequence(console);
}

/* Deletes the pose, then tells which sequences had it. */
static bool delete_poll(struct console *console)
{
    const struct delete_job *job = console_job(console);

    if (console->phase == DELETE) {
        if (stored_save_poll(console))
            return true;
        console->phase = LOOK;
        return console->error == 0 && (command_set.has_room || job->place != MOTION_STORE_NONE);
    }
    return look_poll(console);
}

static const CDS_FLASH struct command pose_save_rows[] = {
    {
        .usage = FLASH_TEXT("pose save NAME"),
        .what = FLASH_TEXT("store where the servos of the group are"),
        .details = COMMAND_DETAILS(
            "Replaces a pose of this name. NAME: a letter, then letters and digits, up to 8, no "
            "word of the console. Refused if a servo does not answer, or in a motion"),
        .example = COMMAND_DETAILS("pose save stand"),
        .begin = save_begin,
        .poll = save_poll,
    },
    {
        .usage = FLASH_TEXT("pose set NAME ANGLE..."),
        .what = FLASH_TEXT("store a pose by its angles"),
        .details = COMMAND_DETAILS("Angles as for pose, NAME as for pose save"),
        .example = COMMAND_DETAILS("pose set stand 90 150.5 210"),
        .begin = set_begin,
        .poll = save_poll,
    },
    {
        .usage = FLASH_TEXT("pose delete NAME"),
        .what = FLASH_TEXT("delete a stored pose"),
        .details = COMMAND_DETAILS(
            "Sequences with this pose play no more, also if a new pose gets the name"),
        .example = COMMAND_DETAILS("pose delete stand"),
        .begin = delete_begin,
        .poll = delete_poll,
    },
};

const CDS_FLASH struct command_group pose_save_commands = {
    .rows = pose_save_rows,
    .count = sizeof pose_save_rows / sizeof pose_save_rows[0],
};
