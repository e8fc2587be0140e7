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

/* The next command, or the heading before it. */
static bool list_poll(struct console *console)
{
    uint8_t *index = &console->index;
    const CDS_FLASH struct command_group *group = command_set.groups[console->part];
    const CDS_FLASH struct command *row;

    if (group == NULL)
        return false;
    if (*index == 0 && group->heading && !console->phase) {
        console->phase = 1; // the heading is printed
        printer_line(&console->printer, group->heading);
        return true;
    }
    row = &group->rows[*index];
    console->printer.values[0].text = row->usage;
    console->printer.values[1].text = row->what;
    printer_line(&console->printer, message_listed);
    if (++*index == group->count) {
        *index = 0;
        console->phase = 0;
        console->part++;
    }
    return true;
}

static bool help_poll(struct console *console)
{
    const CDS_FLASH struct command *topic = console->line.topic;
    struct printer *printer = &console->printer;

    if (topic == NULL)
        return list_poll(console);
    if (console->step == 0) {
        printer->values[0].text = topic->usage;
        printer->values[1].text = topic->what;
        printer_line(printer, message_usage);
        return true;
    }
    if (topic->details == NULL)
        return false;
    if (console->step == 1) {
        printer_line(printer, topic->details);
        return true;
    }
    printer->values[0].text = topic->example;
    printer_line(printer, message_example_is);
    return false;
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
