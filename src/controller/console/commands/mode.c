/* SPDX-License-Identifier: MIT */
/* mode; the banner. */
#include "cds55xx/version.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "robot/settings.h"

#ifndef BOARD_NAME
#define BOARD_NAME "host"
#endif

const CDS_FLASH char mode_banner[] =
    "cds55xx " CDS_VERSION " " BOARD_NAME "\r\nhelp lists the commands, Tab completes them; "
    "Ctrl-X stops all servos";

static uint8_t mode_begin(struct console *console)
{
    console->failsafe->settings->echo =
        console->line.choice == 1 ? SETTINGS_ECHO_PERSON : SETTINGS_ECHO_OFF;
    return 0;
}

static const CDS_FLASH struct command mode_rows[] = {
    {
        .usage = FLASH_TEXT("mode person|program"),
        .what = FLASH_TEXT("banner, prompt and echo, or bare replies"),
        .details = COMMAND_DETAILS("Is the setting echo: 2 or 0. After save a reset keeps it"),
        .example = COMMAND_DETAILS("mode person"),
        .begin = mode_begin,
    },
};

const CDS_FLASH struct command_group mode_commands = {
    .heading = FLASH_TEXT("A terminal:"),
    .rows = mode_rows,
    .count = sizeof mode_rows / sizeof mode_rows[0],
};
