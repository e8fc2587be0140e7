/* SPDX-License-Identifier: MIT */
/* What the commands share that store, list and delete; see stored.h. */
#include "console/commands/stored.h"

#include <string.h>

#include "console/commands/shared.h"
#include "console/errors.h"
#include "console/messages.h"
#include "robot/stored_pose.h"

static const CDS_FLASH char message_room[] = "poses: %u, room for %u; sequences: %u, room for %u";
static const CDS_FLASH char message_wear[] =
    "EEPROM: %l saves of motion data, %u records are damaged";
static const CDS_FLASH char message_no_pose[] =
    "no pose is stored; 'group ID...', then 'pose save NAME' stores where its servos are";
static const CDS_FLASH char message_no_sequence[] =
    "no sequence is stored; 'sequence NAME new POSE 1s' stores the first step of one";

uint8_t stored_may_read(void)
{
    return motion_store_is_saving(console_store()) ? (uint8_t)ERROR_SAVING : 0;
}

uint8_t stored_may_write(const struct console *console)
{
    return robot_is_in_motion(console->robot) ? (uint8_t)ERROR_MOTION : stored_may_read();
}

uint8_t stored_list_begin(struct console *console)
{
    (void)console;
    return stored_may_read();
}

/* ---- names ---- */

uint8_t stored_length(const struct console *console, uint8_t index)
{
    const char *name = parse_name(&console->line, index);
    uint8_t length = 0;

    while (length < PARSE_NAME_SIZE && name[length])
        length++;
    return length;
}

uint8_t stored_find(const struct console *console, enum motion_store_kind kind, uint8_t index)
{
    uint8_t length = stored_length(console, index);

    return length > MOTION_STORE_NAME
               ? MOTION_STORE_NONE
               : motion_store_find(console_store(), kind, parse_name(&console->line, index),
                                   length);
}

static uint8_t error_of_missing(uint8_t kind)
{
    return kind == MOTION_STORE_POSE ? ERROR_NO_POSE : ERROR_NO_SEQUENCE;
}

uint8_t stored_show_begin(struct console *console, enum motion_store_kind kind)
{
    uint8_t error = stored_may_read();

    if (error || console->line.names == 0)
        return error;
    console->index = stored_find(console, kind, 0);
    return console->index == MOTION_STORE_NONE ? error_of_missing(kind) : 0;
}

static uint8_t error_of_name(const struct console *console)
{
    uint8_t length = stored_length(console, 0);

    if (length > MOTION_STORE_NAME)
        return ERROR_NAME_LONG;
    return motion_store_is_name(parse_name(&console->line, 0), length) ? 0 : (uint8_t)ERROR_NAME;
}

/* A line of `sequence list` that is such a name would look like the end of the reply. */
static const CDS_FLASH char stored_reply_words[] = "ok|error";

bool stored_name_poll(struct console *console)
{
    const CDS_FLASH struct command_group *group = command_set.groups[console->part];
    struct token token = {.length = stored_length(console, 0)};

    console->error = error_of_name(console);
    if (console->error || group == NULL)
        return false;
    memcpy(token.text, parse_name(&console->line, 0), PARSE_NAME_SIZE);
    if (parse_is_keyword(stored_reply_words, &token) ||
        parse_is_keyword(group->rows[console->index].usage, &token)) {
        console->error = ERROR_KEYWORD;
        return false;
    }
    if (++console->index == group->count) {
        console->index = 0;
        console->part++;
    }
    return true;
}

/* ---- saving ---- */

static uint8_t error_of(enum motion_store_result result, uint8_t kind)
{
    static const CDS_FLASH uint8_t errors[] = {
        [MOTION_STORE_IDLE] = ERROR_STOPPED,
        [MOTION_STORE_SAVING] = 0,
        [MOTION_STORE_SAVED] = 0,
        [MOTION_STORE_FAILED] = ERROR_NOT_SAVED,
        [MOTION_STORE_BUSY] = ERROR_SAVING,
        [MOTION_STORE_BAD] = ERROR_OUT_OF_RANGE,
        [MOTION_STORE_FULL] = ERROR_STORE_FULL,
        [MOTION_STORE_IN_USE] = ERROR_JOINTS,
    };

    return result == MOTION_STORE_MISSING ? error_of_missing(kind) : errors[result];
}

bool stored_save(struct console *console, const struct motion_store_record *record)
{
    console->error = stored_may_write(console);
    if (console->error == 0)
        console->error = error_of(motion_store_save(console_store(), record), record->kind);
    return console->error == 0;
}

uint8_t stored_autostart(void)
{
    char name[MOTION_STORE_NAME + 1];

    return motion_store_read_autostart(console_store(), name) == 0
               ? MOTION_STORE_NONE
               : motion_store_find(console_store(), MOTION_STORE_SEQUENCE, name,
                                   (uint8_t)strlen(name));
}

uint8_t stored_delete(struct console *console, enum motion_store_kind kind)
{
    struct motion_store_record *record = console_job(console);
    uint8_t error = stored_may_write(console);

    *record = (struct motion_store_record){.kind = (uint8_t)kind,
                                           .name = parse_name(&console->line, 0),
                                           .length = stored_length(console, 0)};
    if (error)
        return error;
    return error_of(motion_store_delete(console_store(), record), record->kind);
}

bool stored_save_poll(struct console *console)
{
    if (motion_store_poll(console_store()))
        return true;
    console->error =
        error_of((enum motion_store_result)console_store()->result, MOTION_STORE_KINDS);
    return false;
}

/* ---- showing ---- */

bool stored_next(struct console *console, enum motion_store_kind kind)
{
    uint8_t error = stored_may_read();

    if (error) {
        console->error = error;
        return false;
    }
    console->index = motion_store_next(console_store(), kind, console->index);
    return console->index != MOTION_STORE_NONE;
}

/* True if a person must hear that a list has no name. A program takes each line for a name. */
static bool is_empty(const struct console *console)
{
    return command_set.has_room && console->error == 0 && console->part == 0 &&
           console_is_for_person(console);
}

bool stored_list_poll(struct console *console, enum motion_store_kind kind)
{
    char name[MOTION_STORE_NAME + 1];

    if (!stored_next(console, kind)) {
        if (is_empty(console))
            printer_line(&console->printer,
                         kind == MOTION_STORE_POSE ? message_no_pose : message_no_sequence);
        return false;
    }
    if (command_set.has_room)
        console->part = 1;
    if (motion_store_read_name(console_store(), kind, console->index++, name)) {
        printer_string(&console->printer, name);
        printer_end_of_line(&console->printer);
    }
    return true;
}

void stored_print_room(struct console *console)
{
    const struct motion_store *store = console_store();
    union printer_value *values = console->printer.values;

    for (uint8_t kind = MOTION_STORE_POSE; kind <= MOTION_STORE_SEQUENCE; kind++) {
        uint8_t room = motion_store_room(store, (enum motion_store_kind)kind);

        (values++)->number = (uint16_t)(motion_store_capacity((enum motion_store_kind)kind) - room);
        (values++)->number = room;
    }
    printer_line(&console->printer, message_room);
}

void stored_print_wear(struct console *console)
{
    const struct motion_store *store = console_store();
    union printer_value *values = console->printer.values;

    values[0].number = (uint16_t)store->saves;
    values[1].number = (uint16_t)(store->saves >> 16);
    values[2].number = store->damaged;
    printer_line(&console->printer, message_wear);
}
