/* SPDX-License-Identifier: MIT */
/* help, version, mode, echo. */
#include "compiler.h" // ALWAYS_INLINE
#include "console/console.h"
#include "console/commands/command_groups.h"
#include "console/errors.h"
#include "console/messages.h"

static const CDS_FLASH char message_usage[] = "%s: %s";
static const CDS_FLASH char message_listed[] = "  %s: %s";
static const CDS_FLASH char message_list[] = "ID: one servo, or a list: 1 2 5-8, or 1,5-8, or all";
static const CDS_FLASH char message_list_word[] =
    "ID: one servo, or a list in one word: 1,2,5-8, or all";
static const CDS_FLASH char message_no_list[] = "ID: one servo, no list";
static const CDS_FLASH char message_more[] =
    "%u commands are not in this firmware; other boards have them (docs/console.md)";
static const CDS_FLASH char message_more_help[] =
    "'help move' explains one command, 'help safety' all below that heading";
static const CDS_FLASH char message_help_all[] =
    "'help all' shows how each is written; 'help units', 'help keys'";
static const CDS_FLASH char message_example_is[] = "Example: %s";

#define BETWEEN 2  // characters between two usages in a line
#define WIDTH   79 // of a line of usages

/* State of `help` in mode person. */
struct help_job {
    uint8_t width;              // characters of the line that has begun
    const CDS_FLASH char *last; // usage of the row before; NULL: none
};

static struct help_job *help_job(struct console *console)
{
    return console_job(console);
}

/* Ends the line of names or usages that has begun. False: there is none. */
static bool ends_line(struct console *console)
{
    if (help_job(console)->width == 0)
        return false;
    help_job(console)->width = 0;
    printer_end_of_line(&console->printer);
    return true;
}

/* True if the list is printed for a person: several commands in a line, so that it fits a terminal
 * of 40 rows. Programs read a line of each command. ALWAYS_INLINE: saves 270 bytes in a firmware
 * without command_set.advise. */
ALWAYS_INLINE bool is_brief(const struct console *console)
{
    uint8_t topic = console->line.choice;

    return command_set.advise && console_is_for_person(console) &&
           ((command_set.has_room && topic == TOPIC_ALL) ||
            (topic == TOPIC_COMMAND && console->line.topic == NULL));
}

/* True if the list for a person has only the names of the commands, so that it fits a terminal of
 * 24 rows; `help all` lists the usages. */
ALWAYS_INLINE bool is_of_names(const struct console *console)
{
    return command_set.has_room && console->line.choice != TOPIC_ALL && is_brief(console);
}

/* Prints the usage of the row, in the line that has begun if it fits. True: a line was ended, the
 * row is next. */
static bool usage_in_line(struct console *console, const CDS_FLASH struct command *row)
{
    struct printer *printer = &console->printer;
    struct help_job *job = help_job(console);
    uint8_t end = (uint8_t)(job->width + BETWEEN);

    for (const CDS_FLASH char *c = row->usage; *c; c++)
        end++;
    if (job->width && end > WIDTH)
        return ends_line(console);
    printer_char(printer, job->width ? ';' : ' ');
    printer_char(printer, ' ');
    printer_text(printer, row->usage);
    job->width = end;
    return false;
}

/* Prints the name of the command behind the heading: once, though it may have several rows. */
static void name_in_line(struct console *console, const CDS_FLASH struct command *row)
{
    struct help_job *job = help_job(console);
    const CDS_FLASH char *name = row->usage;

    if (job->last == NULL || !parse_have_same_name(job->last, name)) {
        printer_char(&console->printer, ' ');
        while (*name && *name != ' ')
            printer_char(&console->printer, *name++);
    }
    job->last = row->usage;
}

/* Prints the heading. In the list of names those of its commands follow in this line. */
static void print_heading(struct console *console, const CDS_FLASH char *heading)
{
    if (is_of_names(console)) {
        printer_text(&console->printer, heading);
        help_job(console)->width = 1; // a line has begun
    } else {
        printer_line(&console->printer, heading);
    }
}

/* Prints a line of the list: the heading before the row, then the row. True: the row is next. */
static bool list_line(struct console *console, const CDS_FLASH struct command_group *group,
                      const CDS_FLASH struct command *row)
{
    struct printer *printer = &console->printer;

    if (console->index == 0 && group->heading && console->phase == 0) {
        if (is_brief(console) && ends_line(console))
            return true;
        console->phase++;
        print_heading(console, group->heading);
        return true;
    }
    if (is_of_names(console)) {
        name_in_line(console, row);
        return false;
    }
    if (is_brief(console))
        return usage_in_line(console, row);
    printer->values[0].text = row->usage;
    printer->values[1].text = row->what;
    printer_line(printer, message_listed);
    return false;
}

/* The ID in the usage string, or NULL. `id` and `new` call it OLD and NEW. */
static const CDS_FLASH char *find_id(const CDS_FLASH char *usage)
{
    for (; *usage; usage++)
        if (usage[0] == 'I' && usage[1] == 'D' && usage[2] != ':') // not the ID:BYTE of `sync`
            return usage;
    return NULL;
}

/* What the ID at `id` may be. In front of a number a list is one word: `move 1 2 30` moves servo 1
 * to 2deg. */
static const CDS_FLASH char *text_of_list(const CDS_FLASH struct command *row,
                                          const CDS_FLASH char *id)
{
    if (row->instruction)
        return message_no_list;
    while (*id && *id != ' ')
        id++;
    return *id && parse_argument_at(id + 1) == ARGUMENT_NUMBER ? message_list_word : message_list;
}

/* Prints a line of all that help knows of the row. True: there is one more. */
static bool topic_line(struct console *console, const CDS_FLASH struct command *row)
{
    struct printer *printer = &console->printer;
    // Whether the ID may be a list follows from the first row: it parses the line.
    const CDS_FLASH struct command *read = command_set.has_room ? console->line.topic : row;
    uint8_t line = console->phase++;
    bool more = true;

    if (line == 0) {
        printer->values[0].text = row->usage;
        printer->values[1].text = row->what;
        if (command_is_only_named(command_set.groups[console->part])) {
            printer->values[1].text = error_text(ERROR_OMITTED);
            more = false;
        }
        printer_line(printer, message_usage);
        return more;
    }
    if (COMMAND_DETAILS_TEXT(row->details) == NULL)
        return false;
    if (line == 1) {
        printer_line(printer, COMMAND_DETAILS_TEXT(row->details));
        return true;
    }
    if (line == 2 && find_id(read->usage)) {
        printer_line(printer, text_of_list(row, find_id(read->usage)));
        return true;
    }
    printer->values[0].text = COMMAND_DETAILS_TEXT(row->example);
    if (printer->values[0].text)
        printer_line(printer, message_example_is);
    return false;
}

/* Count of the commands of the group. Rows of one command stand one behind the other. */
static uint8_t count_commands(const CDS_FLASH struct command_group *group)
{
    const CDS_FLASH struct command *row = group->rows;
    uint8_t count = 1;

    for (uint8_t left = group->count; --left; row++)
        if (!parse_have_same_name(row->usage, row[1].usage))
            count++;
    return count;
}

/* The list has ended. Prints how many commands are left out. */
static void print_more(struct console *console)
{
    const CDS_FLASH struct command_group *const CDS_FLASH *named = command_set.named_only;
    uint8_t count = 0;

    if (named == NULL)
        return;
    for (; *named; named++)
        count = (uint8_t)(count + count_commands(*named));
    console->printer.values[0].number = count;
    printer_line(&console->printer, message_more);
}

/* Prints what stands behind the list, a line in each call. True: there may be one more. */
static bool end_of_list(struct console *console)
{
    if (is_brief(console) && ends_line(console))
        return true;
    if (is_brief(console) && console->phase == 0) {
        console->phase = 1;
        printer_line(&console->printer, message_more_help);
        return true;
    }
    if (is_of_names(console) && console->phase == 1) {
        console->phase = 2;
        printer_line(&console->printer, message_help_all);
        return true;
    }
    print_more(console);
    return false;
}

/* ---- help units, help keys, help motion ---- */

/* `help units` */
static const CDS_FLASH char *const CDS_FLASH unit_lines[] = {
    FLASH_TEXT("Angle: deg, mdeg, or raw: steps, 0 to 1023raw for 0 to 300deg"),
    FLASH_TEXT("Speed: rpm, mrpm, or raw, 0 to 1023raw for 0 to 62rpm. Load: %"),
    FLASH_TEXT("Voltage: V, mV. Temperature: C. Time: s, ms, us. Rate: bps, kbps, Mbps"),
    FLASH_TEXT("Without a unit: deg, rpm, %, V, C, ms, bps. No space before a unit"),
    FLASH_TEXT("Example: move 1 90deg 30rpm, or move 1 307raw 495raw"),
};

static bool units_line(struct console *console)
{
    printer_line(&console->printer, unit_lines[console->phase++]);
    return console->phase < sizeof unit_lines / sizeof unit_lines[0];
}

/* `help keys` */
static const CDS_FLASH char *const CDS_FLASH key_lines[] = {
    FLASH_TEXT("Ctrl-X: stop, torque off for all servos, at any time"),
    FLASH_TEXT("Any key ends monitor, scan, diagnose, motion wait"),
    FLASH_TEXT("Tab: completes a word or lists what fits; Up, Down: earlier lines"),
    FLASH_TEXT("Left, Right, Home, End; Ctrl-U deletes the line, Ctrl-W a word"),
};

static bool keys_line(struct console *console)
{
    printer_line(&console->printer, key_lines[console->phase++]);
    return console->phase < sizeof key_lines / sizeof key_lines[0];
}

/* True if `help` lists only the rows below one heading. */
static bool is_of_heading(const struct console *console)
{
    return command_set.advise && console->line.choice == TOPIC_HEADING;
}

/* True if the heading has the name of the command: "Motion:", "The bus:". */
static bool is_heading_of(const CDS_FLASH char *heading, const CDS_FLASH char *usage)
{
    if (heading == NULL)
        return false;
    if (heading[3] == ' ')
        heading += sizeof "The";
    while (*usage && *usage != ' ' && ((*heading ^ *usage) & ~0x20) == 0) {
        heading++;
        usage++;
    }
    return *heading == ':' && (*usage == ' ' || *usage == '\0');
}

/* Behind the lines of a command, as `motion`: goes on with the heading of its name. False: there is
 * none. */
static bool begin_heading(struct console *console)
{
    const CDS_FLASH struct command_group *const CDS_FLASH *group = command_set.groups;

    for (uint8_t part = 0; *group; group++, part++) {
        if (!is_heading_of((*group)->heading, console->line.topic->usage))
            continue;
        console->line.topic = (*group)->rows;
        console->line.choice = TOPIC_HEADING;
        console->part = part;
        console->index = console->phase = 0;
        return true;
    }
    return false;
}

/* Goes to the group with the heading. Returns true behind the last group below it. */
static bool is_behind_heading(struct console *console)
{
    const CDS_FLASH struct command *topic = console->line.topic;
    const CDS_FLASH struct command_group *group;

    if (console->step == 0)
        while (command_set.groups[console->part]->rows != topic)
            console->part++;
    group = command_set.groups[console->part];
    return group == NULL || (group->heading && group->rows != topic);
}

/* Goes through all rows of all groups, at most one line in each call. */
static bool help_poll(struct console *console)
{
    const CDS_FLASH struct command *topic = console->line.topic, *row;
    const CDS_FLASH struct command_group *group;

    if (command_set.advise && console->line.choice == TOPIC_UNITS)
        return units_line(console);
    if (command_set.has_room && console->line.choice == TOPIC_KEYS)
        return keys_line(console);
    if (command_set.has_room && console->line.choice == TOPIC_ALL)
        topic = NULL;
    if (is_of_heading(console)) {
        if (is_behind_heading(console))
            return false;
        topic = NULL;
    }
    group = command_set.groups[console->part];
    if (group == NULL) {
        if (topic == NULL)
            return end_of_list(console);
        return command_set.advise && begin_heading(console);
    }
    if (topic == NULL && command_is_only_named(group)) {
        console->part++;
        return true;
    }
    row = &group->rows[console->index];
    if (topic == NULL ? list_line(console, group, row)
                      : parse_have_same_name(topic->usage, row->usage) && topic_line(console, row))
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
    printer_flash(&console->printer, message_version);
    printer_end_of_line(&console->printer);
    return false;
}

/* The words of both rows stand in the order of the values of the setting. */
static uint8_t mode_begin(struct console *console)
{
    console->failsafe->settings->echo = (uint8_t)(console->line.choice - 1u);
    return 0;
}

static const CDS_FLASH struct command help_rows[] = {
    {
        .usage = FLASH_TEXT("help [COMMAND]"),
        .what = FLASH_TEXT("this list, or one command"),
        .details = COMMAND_DETAILS("COMMAND: one of the list"),
        .example = COMMAND_DETAILS("help move"),
        .poll = help_poll,
    },
    {
        .usage = FLASH_TEXT("version"),
        .what = FLASH_TEXT("version and board"),
        .details = COMMAND_DETAILS("Of this firmware"),
        .poll = version_poll,
    },
    {
        .usage = FLASH_TEXT("mode program|echo|person"),
        .what = FLASH_TEXT("bare replies, echo or prompt"),
        .details = COMMAND_DETAILS("Sets echo: 0, 1 or 2. person also "
                                   "prints a banner after a reset"),
        .example = COMMAND_DETAILS("mode program"),
        .begin = mode_begin,
    },
    {
        .usage = FLASH_TEXT("echo off|on"),
        .what = FLASH_TEXT("show what is typed"),
        .details = COMMAND_DETAILS("For scripts that do not know mode"),
        .example = COMMAND_DETAILS("echo off"),
        .begin = mode_begin,
    },
};

const CDS_FLASH struct command_group help_commands = {
    .heading = FLASH_TEXT("The console:"),
    .rows = help_rows,
    .count = sizeof help_rows / sizeof help_rows[0],
};
