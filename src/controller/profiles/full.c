/* The profile `full`: all commands. */
#include <stddef.h>

#include "console/commands/command_groups.h"

/* In the order of the list. */
static const CDS_FLASH struct command_group *const CDS_FLASH groups[] = {
    &help_commands,
    &servo_commands,
    &register_commands,
    &monitor_commands,
    &group_commands,
    &cycle_commands,
    &stop_commands,
    &setup_commands,
    &bus_commands,
    &diagnose_commands,
    &raw_commands,
    &controller_commands,
    NULL,
};

const CDS_FLASH struct command_set command_set = {
    .groups = groups,
    .on_stop = stop_rows,
    .report = alarms_report,
};
