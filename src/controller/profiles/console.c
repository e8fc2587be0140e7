/* SPDX-License-Identifier: MIT */
/* The profile `console`: all commands but diagnose. */
#include <stddef.h>

#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/errors.h"
#include "host/device_registers.h" // device_registers_ops
#include "robot/group_cycle.h"

static uint8_t omitted_begin(struct console *console)
{
    (void)console;
    return ERROR_OMITTED;
}

/* So that diagnose is not an unknown command. */
static const CDS_FLASH struct command omitted_rows[] = {
    {
        .usage = FLASH_TEXT("diagnose [ID|254]"),
        .what = FLASH_TEXT("not in this firmware"),
        .begin = omitted_begin,
    },
};

static const CDS_FLASH struct command_group omitted_commands = {.rows = omitted_rows, .count = 1};

/* In the order of the list of `help`. clang-format would put several groups on a line. */
// clang-format off
static const CDS_FLASH struct command_group *const CDS_FLASH groups[] = {
    &help_commands,
    &servo_commands,
    &register_commands,
    &monitor_commands,
    &group_commands,
    &cycle_commands,
    &stop_commands,
    &servos_commands,
    &setup_commands,
    &bus_commands,
    &omitted_commands,
    &raw_commands,
    &controller_commands,
    NULL,
};
// clang-format on

const CDS_FLASH struct command_set command_set = {
    .groups = groups,
    .on_stop = stop_rows,
    .errors = errors_without_remedies,
    .report = controller_report,
    .cycle = &group_cycle,
    .pose_in = &pose_by_servo,
    .device = &device_registers_ops,
};
