/* SPDX-License-Identifier: MIT */
/* The names that may stand at a place of a line; see names.h. */
#include "console/names.h"

#include <stddef.h>
#include <string.h>

#include "cds55xx/control_table.h"
#include "compiler.h"                // ALWAYS_INLINE
#include "console/commands/stored.h" // console_store()
#include "robot/settings.h"          // settings_table

/* Characters of usage strings behind a word. */
static bool ends_word(char c)
{
    return c == '\0' || c == ' ' || c == '|' || c == ']';
}

/* Copies the word at `from`, up to a space, '|', ']' or the end. */
static void copy(struct token *token, const CDS_FLASH char *from)
{
    token->length = 0;
    while (!ends_word(*from))
        token_add(token, *from++);
}

/* Where the arguments of the row go on behind what `line` has, or NULL if the row begins in another
 * way. Inline: 12 bytes less on chips without room, where only one of its two callers is left. */
ALWAYS_INLINE const CDS_FLASH char *place_in(const CDS_FLASH struct command *row,
                                             const struct command_line *line)
{
    const CDS_FLASH char *usage = row->usage;

    for (const CDS_FLASH char *at = line->command->usage;; at++) {
        while (*usage == '[')
            usage++;
        if (at == line->usage)
            return usage;
        if (*at != '[' && *usage++ != *at) // "settings [SETTING" and "settings autostart"
            return NULL;
    }
}

/* Word number `index` of those at `usage`, as in a|b, or NULL. */
static const CDS_FLASH char *word_at(const CDS_FLASH char *usage, uint8_t index)
{
    for (; index; index--) {
        while (!ends_word(*usage))
            usage++;
        if (*usage++ != '|')
            return NULL;
    }
    return usage;
}

static enum names_result next_row(struct names *names)
{
    names->within = 0;
    if (++names->row == command_set.groups[names->group]->count) {
        names->row = 0;
        names->group++;
    }
    return NAMES_NONE;
}

static enum names_result next_register(struct names *names)
{
    struct cds_register found;

    if (!cds_register_at(names->next, &found))
        return next_row(names);
    names->name.length = cds_register_name(names->next, names->name.text, sizeof names->name.text);
    names->next = (uint8_t)(found.address + found.width);
    return NAMES_FOUND;
}

static enum names_result next_setting(struct names *names)
{
    if (names->next == SETTINGS_COUNT)
        return next_row(names);
    copy(&names->name, settings_table[names->next++].name);
    return NAMES_FOUND;
}

/* What the NAME or POSE at `usage` is the name of. */
static enum motion_store_kind kind_at(const struct command_line *line, const CDS_FLASH char *usage)
{
    static const CDS_FLASH char pose[] = "pose";

    return *usage == 'P' || parse_is_command(line, pose) ? MOTION_STORE_POSE
                                                         : MOTION_STORE_SEQUENCE;
}

/* Several rows may have a NAME at this place: the first one has gone through the store. */
static enum names_result next_stored(struct names *names, enum motion_store_kind kind)
{
    char name[MOTION_STORE_NAME + 1];
    uint8_t place = motion_store_next(console_store(), kind, names->next);

    if (place == MOTION_STORE_NONE)
        return next_row(names);
    names->next = (uint8_t)(place + 1);
    if (!motion_store_read_name(console_store(), kind, place, name))
        return NAMES_NONE;
    names->name.length = 0;
    for (const char *c = name; *c; c++)
        token_add(&names->name, *c);
    return NAMES_FOUND;
}

/* The first of several rows of a command names it. */
static enum names_result next_command(struct names *names, const CDS_FLASH struct command *row)
{
    copy(&names->name, row->usage);
    next_row(names);
    return parse_command(&names->name) == row ? NAMES_FOUND : NAMES_NONE;
}

/* True if another row of the group has had the present name at this place. */
static bool is_repeated(const struct names *names, const struct command_line *line)
{
    const CDS_FLASH struct command *row = command_set.groups[names->group]->rows;

    for (uint8_t left = names->row; left; left--, row++) {
        const CDS_FLASH char *usage = place_in(row, line);

        if (usage && parse_choice(usage, &names->name))
            return true;
    }
    return false;
}

static enum names_result next_word(struct names *names, const CDS_FLASH char *usage)
{
    const CDS_FLASH char *word = word_at(usage, names->within);

    if (word == NULL || *word == '\0')
        return next_row(names);
    names->within++;
    copy(&names->name, word);
    if (names->name.length == names->earlier.length &&
        memcmp(names->name.text, names->earlier.text, names->name.length) == 0)
        return NAMES_NONE; // the row before it has this word, too
    names->earlier = names->name;
    return NAMES_FOUND;
}

bool names_id_is_due(const struct command_line *line)
{
    return line->argument == ARGUMENT_ID || line->argument == ARGUMENT_ID_OR_ALL ||
           line->argument == ARGUMENT_IDS;
}

/* `all`, where a list of servos stands. Commands that send one packet, and `id`, take one servo: no
 * `all`. */
static enum names_result next_all(struct names *names, const struct command_line *line)
{
    static const CDS_FLASH char all[] = "all", old_id[] = "OLD";
    bool takes_list = !line->command->instruction && !parse_has_name(line->usage, old_id);

    return takes_list ? next_word(names, all) : next_row(names);
}

/* What `help` takes beside commands (parse.c). */
static const CDS_FLASH char *const CDS_FLASH topics[] = {FLASH_TEXT("all"), FLASH_TEXT("units"),
                                                         FLASH_TEXT("keys"), NULL};

/* The first word of each heading, behind "The", then the topics. Skips the name of a command, as
 * `motion`. */
static enum names_result next_topic(struct names *names)
{
    static const CDS_FLASH char the[] = "The";
    const CDS_FLASH struct command_group *group = command_set.groups[names->next];
    const CDS_FLASH char *word = group ? group->heading : topics[names->within];

    if (word == NULL && group == NULL)
        return NAMES_END;
    if (group)
        names->next++;
    else
        names->within++;
    if (word == NULL)
        return NAMES_NONE;
    if (parse_has_name(word, the))
        word += sizeof the;
    names->name.length = 0;
    for (; *word && *word != ' ' && *word != ':'; word++)
        token_add(&names->name, (char)(*word | 0x20)); // in small letters
    return parse_command(&names->name) ? NAMES_NONE : NAMES_FOUND;
}

enum names_result names_next(struct names *names, const struct command_line *line)
{
    const CDS_FLASH struct command_group *group = command_set.groups[names->group];
    const CDS_FLASH struct command *row;
    const CDS_FLASH char *usage;
    enum names_result result;

    if (group == NULL)
        return command_set.has_room && line->command && line->argument == ARGUMENT_COMMAND
                   ? next_topic(names)
                   : NAMES_END;
    row = &group->rows[names->row];
    /* Tab and `help` skip a command that this firmware only names; a hint does not. */
    if ((line->command ? line->argument == ARGUMENT_COMMAND : !line->error) &&
        command_is_only_named(group))
        return next_row(names);
    if (line->command == NULL || line->argument == ARGUMENT_COMMAND)
        return next_command(names, row);
    usage = place_in(row, line);
    if (usage == NULL)
        return next_row(names);
    if (command_set.has_room && names_id_is_due(line))
        return next_all(names, line);
    switch (parse_argument_at(usage)) {
    case ARGUMENT_NONE: result = next_word(names, usage); break;
    case ARGUMENT_REGISTER: return next_register(names);
    case ARGUMENT_SETTING: return next_setting(names);
    case ARGUMENT_NAME:
        if (command_set.advise && command_set.store)
            return next_stored(names, kind_at(line, usage));
        return next_row(names);
    default: return next_row(names);
    }
    return command_set.has_room && result == NAMES_FOUND && is_repeated(names, line) ? NAMES_NONE
                                                                                     : result;
}

bool names_begin_alike(const struct token *name, const char *text, uint8_t length)
{
    if (length > name->length)
        return false;
    for (uint8_t i = 0; i < length; i++)
        if ((name->text[i] ^ text[i]) & ~0x20)
            return false;
    return true;
}
