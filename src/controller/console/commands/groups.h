/* The groups of commands that a profile may link; each stands in the file of its name. */
#ifndef CONTROLLER_GROUPS_H
#define CONTROLLER_GROUPS_H

#include <stdbool.h>

#include "console/command.h"

extern const CDS_FLASH struct command_group help_commands, servo_commands, register_commands,
    monitor_commands, group_commands, cycle_commands, stop_commands, setup_commands, bus_commands,
    diagnose_commands, raw_commands, controller_commands;

/* The command `stop`, for struct command_set. */
extern const CDS_FLASH struct command stop_rows[];

/* Prints alarms, for struct command_set. */
bool alarms_report(struct console *console);

#endif
