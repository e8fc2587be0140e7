/* help, version, echo. */
#include "cds55xx/version.h"
#include "console/commands.h"
#include "console/console.h"
#include "console/handlers.h"
#include "console/messages.h"

#ifndef BOARD_NAME
#define BOARD_NAME "host"
#endif

static const CDS_FLASH char version_text[] = "cds55xx " CDS_VERSION " " BOARD_NAME;

/* Rows before which a heading stands. */
static const CDS_FLASH uint8_t first_of_group[COMMAND_GROUP_COUNT] = TEXT_FIRST_OF_GROUP;

/* The next command, or the heading before it. */
static bool list_poll(struct console *console)
{
    uint8_t *group = &console->part, *index = &console->index;

    if (*group < COMMAND_GROUP_COUNT && *index == first_of_group[*group]) {
        printer_line_at(&console->printer, TEXT_HEADING, (*group)++);
        return true;
    }
    console->printer.values[0] = printer_text_at(TEXT_USAGE, (*index)++);
    printer_char(&console->printer, ' '); // and a second one
    printer_line(&console->printer, TEXT_LISTED);
    return *index < COMMAND_COUNT;
}

bool help_poll(struct console *console)
{
    uint8_t row = console->line.to;

    if (console->line.words == 1)
        return list_poll(console);
    if (console->step == 0) {
        printer_line_at(&console->printer, TEXT_USAGE, row);
    } else if (console->step == 1) {
        printer_line_at(&console->printer, TEXT_DETAILS, row);
    } else {
        console->printer.values[0] = printer_text_at(TEXT_EXAMPLE, row);
        printer_line(&console->printer, TEXT_EXAMPLE_IS);
    }
    return console->step < 2;
}

bool version_poll(struct console *console)
{
    printer_flash(&console->printer, version_text);
    printer_end_of_line(&console->printer);
    return false;
}

uint8_t echo_begin(struct console *console)
{
    console->failsafe->settings->echo = console->line.choice == 1;
    return 0;
}
