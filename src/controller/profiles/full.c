/* SPDX-License-Identifier: MIT */
/* The profile `full`: all commands. On a chip with 4 KB of RAM there is no room for timed moves by
 * a motion: there "pose ... in TIME" gives each servo one goal, as in the profile `console`. */
#include <stddef.h>

/* A group between `#if HAS_ROOM` and `#endif` is linked only on chips with 256 KB of flash. */
#ifdef __AVR__
#include <avr/io.h> // RAMEND, FLASHEND
#define HAS_MOTION (RAMEND > 0x1FFF)
#define HAS_ROOM   (FLASHEND > 0x1FFFF)
#else
#define HAS_MOTION 1
#define HAS_ROOM   1
#endif

/* Longer texts of errors: also on a chip with 128 KB of flash that has no motions. */
#define HAS_ADVICE (HAS_ROOM || !HAS_MOTION)

#include "console/advice.h"
#include "console/advice_notes.h"
#include "console/commands/command_groups.h"
#include "console/commands/monitor.h"
#include "console/commands/shared.h"
#include "console/commands/stored.h"
#include "console/errors.h"
#include "host/device_registers.h"
#include "host/motion_registers.h"
#include "console/explain.h"
#include "console/servo_list.h"
#include "console/hint_parts.h"
#include "console/history.h"
#include "console/more_slips.h"
#include "console/noise.h"
#include "console/typing.h"
#include "console/unasked.h"
#include "robot/autostart.h"
#include "robot/group_cycle.h"
#include "robot/moves.h"

#if HAS_MOTION
/* Only this profile has it, so it stands here and not in main.c. */
static struct moves moves;
#endif

static struct motion_store motion_store;

#if HAS_MOTION
static void begin(const struct failsafe *failsafe, struct motion_store *store)
{
    moves_open(failsafe->robot, store, failsafe->settings);
    autostart_begin(failsafe, store);
}
#endif
#if HAS_ROOM
static struct noise noise;
static struct unasked unasked;
static struct ended_motion ended_motion;
#endif
static struct account account;
static struct history history;

static const CDS_FLASH struct command_store store = {
    .motions = &motion_store,
    .load = motion_store_load,
    .abort = motion_store_abort,
    .end = sequence_end,
    .room = stored_print_room,
    .wear = stored_print_wear,
#if HAS_MOTION
    .begin = begin,
#endif
};

/* In the order of the list of `help`. A new group that a chip with 128 KB of flash has no room for
 * stands at its place, between `#if HAS_ROOM` and `#endif` (CONTRIBUTING.md, "Make room").
 * clang-format would put several groups on a line. */
// clang-format off
static const CDS_FLASH struct command_group *const CDS_FLASH groups[] = {
    &help_commands,
    &servo_commands,
    &register_commands,
    &monitor_table_commands,
    &group_commands,
    &cycle_commands,
    &teach_commands,
    &pose_save_commands,
    &pose_show_commands,
    &pose_to_commands,
    &sequences_commands,
#if HAS_ROOM
    &sequence_steps_commands,
#endif
    &play_commands,
#if HAS_ROOM
    &motion_speed_commands,
#endif
    &stop_commands,
#if HAS_ROOM
    &limits_show_commands,
    &servos_forget_commands,
#else
    &servos_commands,
#endif
    &setup_commands,
    &new_commands,
    &backup_commands,
    &bus_commands,
    &diagnose_commands,
    &raw_commands,
    &controller_commands,
    &autostart_commands,
    NULL,
};
// clang-format on

#if !HAS_MOTION
static const CDS_FLASH struct command_group *const CDS_FLASH motion_groups[] = {
    &play_commands,
    &autostart_commands,
    NULL,
};
#endif

const CDS_FLASH struct command_set command_set = {
    .groups = groups,
    .on_stop = stop_rows,
    .errors = errors_with_remedies,
    .report = controller_report,
    .store = &store,
    .lists = &servo_lists,
    .baud_list = &baud_list,
    .setting_number = setting_number,
    .explain = explain_error,
#if HAS_ADVICE
    .advise = advice,
    .note = advice_note,
    .link_lost = advice_link_lost,
    .words = advice_words,
    .after_reset = advice_after_reset,
    .bus_changed = advice_bus_changed,
#endif
    .after_scan = after_scan,
    .account = &account,
#if HAS_ROOM
    .noise = &noise,
    .unasked = &unasked,
#endif
    .monitor = monitor_table,
    .typing = HAS_ADVICE ? &typing_with_parts : &typing,
    .history = &history,
    .set_up_tries = 3,
#if HAS_ROOM
    .more_slips = more_slips,
    .motion_words = &motion_words,
    .ended_motion = &ended_motion,
#endif
    .has_room = HAS_ROOM,
#if HAS_MOTION
    .cycle = &motion_cycle,
    .pose_in = &pose_moves,
    .moves = &moves,
    .device = &motion_registers_ops,
#else
    .named_only = motion_groups,
    .cycle = &group_cycle,
    .pose_in = &pose_by_servo,
    .device = &device_registers_ops,
#endif
};
