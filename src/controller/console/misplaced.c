/* SPDX-License-Identifier: MIT */
/* Words at the wrong place; see misplaced.h. */
#include "console/misplaced.h"

#include <stddef.h> // NULL

#include "cds55xx/control_table.h"   // cds_register_named()
#include "console/commands/stored.h" // stored_find()
#include "console/console.h"
#include "console/errors.h"
#include "console/explain.h"    // explain_is_settings()
#include "console/more_slips.h" // more_slips_has_word()
#include "console/names.h"      // names_begin_alike()
#include "console/slips.h"      // struct slip
#include "console/typing.h"     // TYPING_NO_SEARCH

static const CDS_FLASH char message_own_command[] = "a command of its own: '%s'";
static const CDS_FLASH char message_name_first[] = "the name comes first: '%s'";
static const CDS_FLASH char message_other_form[] = "usage: %s";
static const CDS_FLASH char message_motion_off[] =
    "'motion off' ends a motion; 'stop' switches torque off, too";
static const CDS_FLASH char message_spaces[] = "a space between words, as in '%s'";
static const CDS_FLASH char message_other_name[] = "unknown register; %s";
static const CDS_FLASH char message_one_servo_only[] =
    "no space after a comma: 1,2,3; for one servo no comma, as in '%s'";
static const CDS_FLASH char message_register_to_read[] = "a register: 'get 1 %u' prints it";
static const CDS_FLASH char message_every[] =
    "the period stands behind 'every': 'monitor 1 every 100ms'";
static const CDS_FLASH char message_show[] =
    "'sequence NAME show' shows its steps, 'play NAME' plays it";
static const CDS_FLASH char message_delete[] =
    "'sequence delete NAME' deletes all of it, 'sequence NAME delete N' deletes step N";
static const CDS_FLASH char message_save[] =
    "'save' alone keeps the settings; for a pose 'pose save NAME'";
static const CDS_FLASH char message_counters[] =
    "no command zeroes the counters: they count since the reset of the controller, or since the "
    "servo joined";
static const CDS_FLASH char message_new_pose[] =
    "'pose save NAME' stores where the servos are, 'pose set NAME ANGLE...' stores angles";

static const CDS_FLASH char name_of_sequence[] = "sequence";
static const CDS_FLASH char name_of_get[] = "get";
static const CDS_FLASH char name_of_move[] = "move";
static const CDS_FLASH char name_of_pose[] = "pose";

/* ---- rows ---- */

/* The first form of the line's command that has the word and shows it in its example; NULL: none
 * has it. */
static const CDS_FLASH struct command *form_with(const struct command_line *line,
                                                 const struct token *word)
{
    const CDS_FLASH struct command_group *const CDS_FLASH *group = command_set.groups;

    for (; *group; group++) {
        const CDS_FLASH struct command *row = (*group)->rows;

        for (uint8_t left = (*group)->count; left; left--, row++)
            if (parse_have_same_name(line->command->usage, row->usage) &&
                parse_is_keyword(row->usage, word) &&
                parse_is_keyword(slip_line_to_type(row), word))
                return row;
    }
    return NULL;
}

/* ---- a command behind another command ---- */

/* Commands that write to servos, or change what is stored or inhibited. None of them is named as
 * the line to type: behind another command the word means something else. */
static const CDS_FLASH char lasting_commands[] =
    "reset|factory|new|clear|save|defaults|restore|release";

/* `counters reset`, `counters 1 clear` */
static bool is_zeroing(const struct command_line *line, const struct token *word)
{
    static const CDS_FLASH char counters[] = "counters", zero[] = "reset|clear";

    return parse_is_command(line, counters) && parse_choice(zero, word);
}

/* `counters reset`, `teach save`, `pose new stand` */
static const CDS_FLASH char *text_of_lasting(const struct command_line *line,
                                             const struct token *word)
{
    static const CDS_FLASH char save[] = "save", new[] = "new";

    if (is_zeroing(line, word))
        return message_counters;
    if (parse_is_command(line, name_of_pose) && parse_choice(new, word))
        return message_new_pose;
    return parse_choice(save, word) ? message_save : NULL;
}

/* The text for a word that is a command; NULL: it is none, or no text is sure to help. */
static const CDS_FLASH char *text_of_command(struct console *console, const struct token *word)
{
    static const CDS_FLASH char stop[] = "stop", motion[] = "motion";
    const struct command_line *line = &console->line;
    const CDS_FLASH struct command *row = parse_command(word);
    bool is_pose;

    if (!row || explain_is_settings(line))
        return NULL;
    if (parse_choice(lasting_commands, word))
        return text_of_lasting(line, word);
    if (parse_has_name(row->usage, stop))
        return line->names || parse_is_command(line, motion) ? message_motion_off : NULL;
    is_pose = (line->names && parse_has_name(row->usage, name_of_pose)) ||
              (parse_is_command(line, name_of_pose) && parse_has_name(row->usage, name_of_move));
    console->printer.values[0].text = is_pose ? more_slips_pose_line : slip_line_to_type(row);
    return message_own_command;
}

/* `motion pause`, `set id 1 3` */
static const CDS_FLASH char *text_of_own_command(struct console *console)
{
    const struct command_line *line = &console->line;

    return more_slips_has_word(console) && line->command && !parse_is_command(line, name_of_get) &&
                   (line->argument == ARGUMENT_NONE || line->argument == ARGUMENT_ID)
               ? text_of_command(console, &console->token)
               : NULL;
}

/* `settings save` */
static const CDS_FLASH char *text_of_settings_command(struct console *console)
{
    static const CDS_FLASH char commands[] = "save|defaults";

    if (!more_slips_has_word(console) || !parse_choice(commands, &console->token))
        return NULL;
    console->printer.values[0].text = slip_line_to_type(parse_command(&console->token));
    return message_own_command;
}

/* `sequence play wave`, `sequence new walk`, `play loop`: a word stands in the place of a name. */
static const CDS_FLASH char *text_of_name(struct console *console)
{
    const struct command_line *line = &console->line;
    const CDS_FLASH struct command *form;
    struct token name;

    if (line->names != 1 || explain_is_settings(line))
        return NULL;
    name = more_slips_name(console);
    form = form_with(line, &name);
    if (form == NULL)
        return text_of_command(console, &name);
    console->printer.values[0].text = slip_line_to_type(form);
    return message_name_first;
}

/* `pose up save`, `settings autostart walk 5s loop` */
static const CDS_FLASH char *text_of_other_form(struct console *console)
{
    const struct command_line *line = &console->line;
    const CDS_FLASH struct command *form;

    if (!line->command || !more_slips_has_word(console))
        return NULL;
    form = form_with(line, &console->token);
    if (form == NULL || form == line->command)
        return NULL;
    console->printer.values[0].text = form->usage;
    return message_other_form;
}

/* ---- a name in front ---- */

/* `PRESENT_POSITION 1` */
static const CDS_FLASH char *text_of_register(struct console *console)
{
    struct cds_register found;

    if (console->line.command || !more_slips_has_word(console) ||
        !cds_register_named(console->token.text, console->token.length, &found))
        return NULL;
    console->printer.values[0].number = found.address;
    return message_register_to_read;
}

/* `stand in 2s`, `move stand`: the name of a stored pose */
static const CDS_FLASH char *text_of_pose(struct console *console)
{
    const struct token *word = &console->token;
    const struct command_line *line = &console->line;

    return (line->command == NULL ||
            (parse_is_command(line, name_of_move) && line->argument == ARGUMENT_ID_OR_ALL)) &&
                   word->length <= MOTION_STORE_NAME && stored_may_read() == 0 &&
                   motion_store_find(console_store(), MOTION_STORE_POSE, word->text,
                                     word->length) != MOTION_STORE_NONE
               ? message_is_pose
               : NULL;
}

/* Names of registers of an AX-12 and of newer Dynamixels. */
static const CDS_FLASH struct {
    const CDS_FLASH char *words;
    const CDS_FLASH char *text;
} other_names[] = {
    {FLASH_TEXT("TORQUE_LIMIT|GOAL_TORQUE"),
     FLASH_TEXT("a CDS55xx has only MAX_TORQUE, which acts from the servo's next power-up on")},
    {FLASH_TEXT("CW_COMPLIANCE_SLOPE"),
     FLASH_TEXT("a CDS55xx has CW_PROPORTION at its address, with values of another meaning")},
    {FLASH_TEXT("CCW_COMPLIANCE_SLOPE"),
     FLASH_TEXT("a CDS55xx has CCW_PROPORTION at its address, with values of another meaning")},
    {FLASH_TEXT("RETURN_DELAY_TIME|DELAY_TIME"), FLASH_TEXT("here it is RETURN_DELAY")},
    {FLASH_TEXT("TEMPERATURE_LIMIT|LIMIT_TEMPERATURE"), FLASH_TEXT("here it is MAX_TEMPERATURE")},
    {FLASH_TEXT("MIN_VOLTAGE_LIMIT|LOW_LIMIT_VOLTAGE|DOWN_LIMIT_VOLTAGE"),
     FLASH_TEXT("here it is MIN_VOLTAGE")},
    {FLASH_TEXT("MAX_VOLTAGE_LIMIT|HIGH_LIMIT_VOLTAGE|UP_LIMIT_VOLTAGE"),
     FLASH_TEXT("here it is MAX_VOLTAGE")},
    {FLASH_TEXT("GOAL_SPEED|GOAL_VELOCITY|PROFILE_VELOCITY"),
     FLASH_TEXT("here it is MOVING_SPEED")},
    {FLASH_TEXT("PRESENT_VELOCITY"), FLASH_TEXT("here it is PRESENT_SPEED")},
    {FLASH_TEXT("PRESENT_CURRENT"),
     FLASH_TEXT("a CDS55xx has PRESENT_LOAD, a share of its torque")},
    {FLASH_TEXT("ACCELERATION|GOAL_ACCELERATION|PROFILE_ACCELERATION"),
     FLASH_TEXT("a CDS55xx has ACC to speed up, DCC to slow down")},
};

/* `one` is a capital or '_'. */
static bool is_same(char one, char typed)
{
    return ((one ^ (typed == '-' ? '_' : typed)) & ~0x20) == 0;
}

/* True if one of the words, as in A|B, is the token, in any case, '-' standing for '_'. */
static bool is_one_of(const CDS_FLASH char *words, const struct token *token)
{
    uint8_t same = 0; // characters of the token that the word begins with; UINT8_MAX: another word

    for (;; words++) {
        if (*words == '|' || *words == '\0') {
            if (same == token->length)
                return true;
            if (*words == '\0')
                return false;
            same = 0;
        } else if (same < token->length && is_same(*words, token->text[same])) {
            same++;
        } else {
            same = UINT8_MAX;
        }
    }
}

/* `set 1 TORQUE_LIMIT 50` */
static const CDS_FLASH char *text_of_other_name(struct console *console)
{
    if (!more_slips_has_word(console))
        return NULL;
    for (uint8_t i = 0; i < sizeof other_names / sizeof other_names[0]; i++) {
        if (!is_one_of(other_names[i].words, &console->token))
            continue;
        console->printer.values[0].text = other_names[i].text;
        return message_other_name;
    }
    return NULL;
}

/* True if the word is the name of a register, or ends one behind a '_'. */
static bool ends_register_name(const struct token *word)
{
    struct cds_register at;
    char name[CDS_REGISTER_NAME_SIZE];

    for (uint8_t next = 0; cds_register_at(next, &at); next = (uint8_t)(at.address + at.width)) {
        uint8_t from = (uint8_t)(cds_register_name(next, name, sizeof name) - word->length);

        if (from < sizeof name && (from == 0 || name[from - 1] == '_') &&
            names_begin_alike(word, name + from, word->length))
            return true;
    }
    return false;
}

/* `get PRESENT_POSITION 1`, `set voltage 1 6` */
static const CDS_FLASH char *text_of_early_register(struct console *console)
{
    static const CDS_FLASH char set[] = "set";
    const struct command_line *line = &console->line;

    if (!(parse_is_command(line, name_of_get) || parse_is_command(line, set)) ||
        line->argument != ARGUMENT_ID || !more_slips_has_word(console) ||
        !ends_register_name(&console->token))
        return NULL;
    console->printer.values[0].text = slip_line_to_type(line->command);
    return message_id_first;
}

/* ---- separators ---- */

static bool is_separator(char c)
{
    return c == '(' || c == '=' || c == ',';
}

/* `move(1,90)`, `move 1=90`, `set 1 LED=1`, `move 1, 90`; not `move 1,x 90` */
static const CDS_FLASH char *text_of_separator(struct console *console)
{
    const struct token *word = &console->token;
    const CDS_FLASH struct command *row = console->line.command;
    struct token before = {0}; // the separator
    bool is_comma, is_last;

    if (!more_slips_has_word(console))
        return NULL;
    while (before.length < word->length && !is_separator(word->text[before.length]))
        token_add(&before, word->text[before.length]);
    if (before.length == 0 || before.length == word->length)
        return NULL;
    is_comma = word->text[before.length] == ',';
    is_last = before.length + 1 == word->length;
    if (row == NULL)
        row = is_last ? NULL : parse_command(&before);
    else if (is_comma && (!is_last || console->error == ERROR_UNKNOWN_REGISTER))
        return NULL;
    if (row == NULL)
        return NULL;
    console->printer.values[0].text = slip_line_to_type(row);
    return is_comma && is_last && console->line.command ? message_one_servo_only : message_spaces;
}

/* `monitor 1 100ms` */
static const CDS_FLASH char *text_of_period(struct console *console)
{
    static const CDS_FLASH char monitor[] = "monitor";
    struct number number;

    return parse_is_command(&console->line, monitor) && more_slips_has_word(console) &&
                   number_parse(&console->token, &number) == 0
               ? message_every
               : NULL;
}

/* ---- too few or too many words ---- */

/* `sequence walk`, `sequence walk delete`, `save stand` */
static const CDS_FLASH char *text_of_count(struct console *console)
{
    static const CDS_FLASH char save[] = "save", of_delete[] = "delete";
    const struct command_line *line = &console->line;

    if (parse_is_command(line, save))
        return message_save;
    if (more_slips_has_word(console) && is_zeroing(line, &console->token))
        return message_counters;
    if (!parse_is_command(line, name_of_sequence) || line->names != 1 || line->values ||
        more_slips_has_word(console) || stored_may_read() ||
        stored_find(console, MOTION_STORE_SEQUENCE, 0) == MOTION_STORE_NONE)
        return NULL;
    if (line->words == 2)
        return message_show;
    return parse_has_name(line->command->usage + sizeof "sequence NAME", of_delete) ? message_delete
                                                                                    : NULL;
}

static const CDS_FLASH struct slip misplaced[] = {
    {ERROR_UNKNOWN_COMMAND, text_of_separator},
    {ERROR_UNKNOWN_COMMAND, text_of_register},
    {ERROR_UNKNOWN_COMMAND, text_of_pose},
    {ERROR_UNKNOWN_WORD, text_of_other_form},
    {ERROR_UNKNOWN_WORD, text_of_own_command},
    {ERROR_UNKNOWN_WORD, text_of_name},
    {ERROR_NOT_A_NUMBER, text_of_pose},
    {ERROR_NOT_A_NUMBER, text_of_own_command},
    {ERROR_NOT_A_NUMBER, text_of_separator},
    {ERROR_NOT_A_NUMBER, text_of_period},
    {ERROR_NOT_A_NUMBER, text_of_early_register},
    {ERROR_UNKNOWN_REGISTER, text_of_separator},
    {ERROR_UNKNOWN_REGISTER, text_of_other_name},
    {ERROR_UNKNOWN_SETTING, text_of_settings_command},
    {ERROR_COUNT, text_of_other_form},
    {ERROR_COUNT, text_of_name},
    {ERROR_COUNT, text_of_count},
    {ERROR_NO_POSE, text_of_name},
    {ERROR_NO_SEQUENCE, text_of_name},
};

const CDS_FLASH char *misplaced_text(struct console *console)
{
    const CDS_FLASH char *message =
        slip_first_text(misplaced, sizeof misplaced / sizeof misplaced[0], console);

    if (message)
        console->phase = TYPING_NO_SEARCH; // the message names the line to type
    return message;
}
