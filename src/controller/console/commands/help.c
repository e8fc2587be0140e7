/* SPDX-License-Identifier: MIT */
/* help, version, echo. */
#include "cds55xx/version.h"
#include "console/console.h"
#include "console/commands/command_groups.h"
#include "console/messages.h"

static const CDS_FLASH char message_usage[] = "%s: %s";
static const CDS_FLASH char message_listed[] = "  %s: %s";
static const CDS_FLASH char message_example_is[] = "Example: %s";

#ifndef BOARD_NAME
#define BOARD_NAME "host"
#endif

static const CDS_FLASH char version_text[] = "cds55xx " CDS_VERSION " " BOARD_NAME;

/* Prints a line of the list: the heading before the row, then the row. True: the row is next. */
static bool list_line(struct console *console, const CDS_FLASH struct command_group *group,
                      const CDS_FLASH struct command *row)
{
    struct printer *printer = &console->printer;

    if (console->index == 0 && group->heading && console->phase++ == 0) {
        printer_line(printer, group->heading);
        return true;
    }
    printer->values[0].text = row->usage;
    printer->values[1].text = row->what;
    printer_line(printer, message_listed);
    return false;
}

/* True if both usage strings begin with the same command. */
static bool are_alike(const CDS_FLASH char *a, const CDS_FLASH char *b)
{
    for (; *a == *b; a++, b++)
        if (*a == ' ' || *a == '\0')
            return true;
    return false;
}

/* Prints a line of all that help knows of the row. True: there is one more. */
static bool topic_line(struct console *console, const CDS_FLASH struct command *row)
{
    struct printer *printer = &console->printer;
    uint8_t line = console->phase++;

    if (line == 0) {
        printer->values[0].text = row->usage;
        printer->values[1].text = row->what;
        printer_line(printer, message_usage);
        return true;
    }
    if (row->details == NULL)
        return false;
    if (line == 1) {
        printer_line(printer, row->details);
        return true;
    }
    printer->values[0].text = row->example;
    printer_line(printer, message_example_is);
    return false;
}

/* Goes through all rows of all groups, at most one line in each call. */
static bool help_poll(struct console *console)
{
    const CDS_FLASH struct command *topic = console->line.topic, *row;
    const CDS_FLASH struct command_group *group = command_set.groups[console->part];

    if (group == NULL)
        return false;
    row = &group->rows[console->index];
    if (topic == NULL ? list_line(console, group, row)
                      : are_alike(topic->usage, row->usage) && topic_line(console, row))
        return true;
    console->phase = 0;
    if (++console->index == group->count) {
        console->index = 0;
        console->part++;
    }
    return true;
}

static bool version_poll(struct console *console)
{
    printer_flash(&console->printer, version_text);
    printer_end_of_line(&console->printer);
    return false;
}

static uint8_t echo_begin(struct console *console)
{
    console->failsafe->settings->echo = console->line.choice == 1;
    return 0;
}

static const CDS_FLASH struct command help_rows[] = {
    {
        .usage = FLASH_TEXT("help [COMMAND]"),
        .what = FLASH_TEXT("this list, or one command"),
        .details = COMMAND_DETAILS("COMMAND: a name out of the list"),
        .example = COMMAND_DETAILS("help move"),
        .poll = help_poll,
    },
    {
        .usage = FLASH_TEXT("version"),
        .what = FLASH_TEXT("version and board"),
        .details = COMMAND_DETAILS("Of this firmware"),
        .example = COMMAND_DETAILS("version"),
        .poll = version_poll,
    },
    {
        .usage = FLASH_TEXT("echo on|off"),
        .what = FLASH_TEXT("show what is typed"),
        .details = COMMAND_DETAILS("Scripts read replies more easily with echo off"),
        .example = COMMAND_DETAILS("echo off"),
        .begin = echo_begin,
    },
};

const CDS_FLASH struct command_group help_commands = {
    .heading = FLASH_TEXT("The console:"),
    .rows = help_rows,
    .count = sizeof help_rows / sizeof help_rows[0],
};
