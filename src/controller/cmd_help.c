/* help, version, echo. */
#include "cds55xx/version.h"
#include "commands.h"
#include "console.h"
#include "errors.h"
#include "handlers.h"
#include "texts.h" // PACKED_...

#ifndef BOARD_NAME
#define BOARD_NAME "host"
#endif

static const CDS_FLASH char version_text[] = "cds55xx " CDS_VERSION " " BOARD_NAME;

#define HEADING(name, heading) static const CDS_FLASH char heading_##name[] = PACKED_heading_##name;
COMMAND_GROUPS(HEADING)
#undef HEADING

static const CDS_FLASH char *const CDS_FLASH headings[COMMAND_GROUP_COUNT] = {
#define HEADING(name, heading) heading_##name,
    COMMAND_GROUPS(HEADING)
#undef HEADING
};

uint8_t help_begin(struct console *console)
{
    struct command_line *line = &console->line;

    if (line->word.length == 0)
        return 0;
    line->to = command_named(&line->word);
    return line->to < COMMAND_COUNT ? 0 : ERROR_UNKNOWN_COMMAND;
}

/* A heading, or the next command below it; `index`: the row to be looked at next, from 1 on. */
static bool list_poll(struct console *console)
{
    uint8_t *group = &console->part, *index = &console->index;

    if (*index == 0) {
        writer_text_line(&console->writer, headings[*group]);
        *index = 1;
        return true;
    }
    while (*index <= COMMAND_COUNT && commands[*index - 1].group != *group)
        (*index)++;
    if (*index <= COMMAND_COUNT) {
        WRITER_TEXT(&console->writer, "  ");
        writer_text_line(&console->writer, commands[*index - 1].usage);
        (*index)++;
        return true;
    }
    *index = 0;
    (*group)++;
    return *group < COMMAND_GROUP_COUNT;
}

bool help_poll(struct console *console)
{
    const CDS_FLASH struct command *command = &commands[console->line.to];

    if (console->line.word.length == 0)
        return list_poll(console);
    if (console->step == 0) {
        writer_text_line(&console->writer, command->usage);
    } else if (console->step == 1) {
        writer_text_line(&console->writer, command->details);
    } else {
        WRITER_TEXT(&console->writer, "Example: ");
        writer_text_line(&console->writer, command->example);
    }
    return console->step < 2;
}

bool version_poll(struct console *console)
{
    writer_text_line(&console->writer, version_text);
    return false;
}

uint8_t echo_begin(struct console *console)
{
    console->keeper->settings->echo = console->line.choice == 1;
    return 0;
}
