/* SPDX-License-Identifier: MIT */
/* The groups of commands that a profile may link. Group X_commands is in X.c. */
#ifndef CONTROLLER_COMMAND_GROUPS_H
#define CONTROLLER_COMMAND_GROUPS_H

#include <stdbool.h>

#include "console/command.h"

extern const CDS_FLASH struct command_group help_commands, servo_commands, register_commands,
    monitor_commands, monitor_table_commands, group_commands, cycle_commands, teach_commands,
    pose_save_commands, pose_show_commands, pose_to_commands, sequences_commands,
    sequence_steps_commands, autostart_commands, play_commands, motion_speed_commands,
    stop_commands, limits_show_commands, servos_commands, servos_forget_commands, setup_commands,
    new_commands, backup_commands, bus_commands, diagnose_commands, raw_commands,
    controller_commands;

/* The command `stop`: on_stop of struct command_set. */
extern const CDS_FLASH struct command stop_rows[];

/* Prints alarms, and how a motion has failed: report of struct command_set. */
bool controller_report(struct console *console);

#endif
