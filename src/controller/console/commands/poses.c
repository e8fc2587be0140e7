/* SPDX-License-Identifier: MIT */
/* pose save, set, show, delete, list, and a move to a stored pose. */
#include <string.h>

#include "cds55xx/control_table.h" // CDS_REG_PRESENT_POSITION
#include "cds55xx/motion.h"        // CDS_POSE_NONE
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/commands/stored.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"
#include "robot/motion_start.h" // motion_group_is_endless()
#include "robot/stored_pose.h"

static const CDS_FLASH char message_group_begins[] = "group";
static const CDS_FLASH char message_set_begins[] = "pose set ";
static const CDS_FLASH char message_raw[] = "raw";
static const CDS_FLASH char message_autostart_lost[] =
    "the sequence of 'settings autostart' has this pose: it plays no more";

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

/* ---- show, list ---- */

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

/* ---- delete ---- */

enum delete_phase { DELETE, LOOK } __attribute__((packed));

struct delete_job {
    struct motion_store_record record; // of stored_delete()
    uint8_t number;                    // of the pose
    uint8_t place;                     // of the sequence that plays after power-up
    uint8_t step;                      // that is compared next
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

/* Deletes the pose, then tells if the sequence of the autostart had it. */
static bool delete_poll(struct console *console)
{
    struct delete_job *job = console_job(console);
    struct motion_store_step step;

    if (console->phase == DELETE) {
        if (stored_save_poll(console))
            return true;
        console->phase = LOOK;
        return console->error == 0 && job->place != MOTION_STORE_NONE;
    }
    if (stored_may_read())
        return true;
    if (!motion_store_read_step(console_store(), job->place, job->step++, &step))
        return false;
    if (step.pose != job->number)
        return true;
    printer_line(&console->printer, message_autostart_lost);
    return false;
}

/* ---- in TIME ---- */

/* The error for an enum stored_pose_result, or 0. */
static uint8_t error_of_pose(enum stored_pose_result result)
{
    static const CDS_FLASH uint8_t errors[] = {
        [STORED_POSE_READ] = 0,
        [STORED_POSE_MISSING] = ERROR_NO_POSE,
        [STORED_POSE_ABSENT] = ERROR_ABSENT,
    };

    return errors[result];
}

/* Puts the positions of the group into the line, as its angles. */
static void take_pose(struct console *console)
{
    uint16_t pose[ROBOT_SERVOS];
    struct stored_joints joints;

    console->error = stored_may_read();
    if (console->error)
        return;
    stored_joints_find(&joints, console_store(), console->robot);
    console->error = error_of_pose(stored_pose_read(console_store(), &joints, console->part, pose));
    memcpy(console->line.request->packet.bytes, pose, sizeof pose);
}

static uint8_t in_begin(struct console *console)
{
    uint8_t error = console_move_ms(console, 0, &move_job(console)->ms);

    if (error == 0)
        error = stored_may_read();
    if (error)
        return error;
    console->part = stored_find(console, MOTION_STORE_POSE, 0);
    return console->part == MOTION_STORE_NONE
               ? (uint8_t)ERROR_NO_POSE
               : stored_group_choose(console->robot, console_store());
}

/* Finding the pose takes up to 0.4 ms, and reading it 0.65 ms: two polls, so that the cycle is not
 * late. */
static bool in_poll(struct console *console)
{
    if (console->step)
        return command_set.pose_in->poll(console);
    take_pose(console);
    console->part = 0;
    if (console->error == 0 && !command_set.moves && motion_group_is_endless(console->robot))
        console->error = ERROR_ENDLESS; // no motion checks it
    if (console->error == 0)
        console->error = command_set.pose_in->begin(console);
    return console->error == 0;
}

static const CDS_FLASH struct command pose_rows[] = {
    {
        .usage = FLASH_TEXT("pose list"),
        .what = FLASH_TEXT("names of the stored poses"),
        .details = COMMAND_DETAILS("One a line"),
        .example = COMMAND_DETAILS("pose list"),
        .begin = stored_list_begin,
        .poll = list_poll,
    },
    {
        .usage = FLASH_TEXT("pose save NAME"),
        .what = FLASH_TEXT("store where the servos of the group are"),
        .details = COMMAND_DETAILS(
            "In the EEPROM, in place of a pose of this name. NAME: a letter, then letters and "
            "digits, up to 8, and no word of the console. If a servo does not answer, nothing is "
            "stored. Not while a motion is under way"),
        .example = COMMAND_DETAILS("pose save stand"),
        .begin = save_begin,
        .poll = save_poll,
    },
    {
        .usage = FLASH_TEXT("pose set NAME ANGLE..."),
        .what = FLASH_TEXT("store a pose by its angles"),
        .details = COMMAND_DETAILS(
            "An angle for each servo of the group, in its order, 0 to 300deg. As pose save"),
        .example = COMMAND_DETAILS("pose set stand 90 150.5 210"),
        .begin = set_begin,
        .poll = save_poll,
    },
    {
        .usage = FLASH_TEXT("pose show [NAME]"),
        .what = FLASH_TEXT("lines that store a pose again, or all poses"),
        .details = COMMAND_DETAILS("group, then pose set. Send them to store the poses elsewhere"),
        .example = COMMAND_DETAILS("pose show stand"),
        .begin = show_begin,
        .poll = show_poll,
    },
    {
        .usage = FLASH_TEXT("pose delete NAME"),
        .what = FLASH_TEXT("delete a stored pose"),
        .details = COMMAND_DETAILS(
            "A sequence with this pose plays no more, also if a new pose gets the name. Tells if "
            "this is the sequence of settings autostart"),
        .example = COMMAND_DETAILS("pose delete stand"),
        .begin = delete_begin,
        .poll = delete_poll,
    },
    {
        .usage = FLASH_TEXT("pose NAME in TIME"),
        .what = FLASH_TEXT("move to a stored pose; all servos arrive together"),
        .details = COMMAND_DETAILS(
            "1ms to 600s. ok: the move has begun. Without a group: all servos of the stored poses"),
        .example = COMMAND_DETAILS("pose stand in 2s"),
        .begin = in_begin,
        .poll = in_poll,
    },
};

const CDS_FLASH struct command_group poses_commands = {
    .rows = pose_rows,
    .count = sizeof pose_rows / sizeof pose_rows[0],
};
