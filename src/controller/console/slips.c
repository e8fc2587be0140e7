/* SPDX-License-Identifier: MIT */
/* Lines that are nearly right; see slips.h. */
#include "console/slips.h"

#include <stddef.h> // NULL

#include "cds55xx/control_table.h"   // CDS_REG_LED
#include "cds55xx/packet.h"          // CDS_WRITE
#include "console/commands/stored.h" // stored_find()
#include "console/console.h"
#include "console/errors.h"
#include "console/explain.h"
#include "console/messages.h"
#include "console/parse.h"

static const CDS_FLASH char message_id_first[] = "the ID comes first: '%s'";
static const CDS_FLASH char message_no_number[] = "no number here, as in '%s'";
static const CDS_FLASH char message_on_is_1[] = "1 is on, 0 is off; or '%s %u %s'";
static const CDS_FLASH char message_comma_behind[] = "a space, no comma: 90 120";
static const CDS_FLASH char message_write_word[] = "a byte: 0 to 255; both: 'set %u %u %uraw'";
static const CDS_FLASH char message_seconds[] = "has too many decimals of ms; seconds: 0.5s";
static const CDS_FLASH char message_is_pose[] = "a pose: 'pose NAME in 2s' moves to it";
static const CDS_FLASH char message_is_sequence[] = "a sequence: 'play NAME' plays it";

/* A line to type for the command: its example, or its usage. */
static const CDS_FLASH char *line_to_type(const struct command_line *line)
{
    const CDS_FLASH char *example = COMMAND_DETAILS_TEXT(line->command->example);

    return example ? example : line->command->usage;
}

/* `torque on 1` */
static const CDS_FLASH char *text_of_early_word(struct console *console)
{
    const struct command_line *line = &console->line;

    if (line->argument == ARGUMENT_NUMBER ||
        !parse_is_keyword(line->command->usage, &console->token))
        return NULL;
    console->printer.values[0].text = line_to_type(line);
    return message_id_first;
}

/* `teach 1 on`, `cycle 4ms`: a number stands where a word is due. */
static const CDS_FLASH char *text_of_early_number(struct console *console)
{
    const struct command_line *line = &console->line;
    struct number number;

    if (!line->command || line->argument != ARGUMENT_NONE || number_parse(&console->token, &number))
        return NULL;
    console->printer.values[0].text = line_to_type(line);
    return message_no_number;
}

/* `set 1 LED on` */
static const CDS_FLASH char *text_of_on(struct console *console)
{
    static const CDS_FLASH char on_off[] = "on|off", led[] = "led", torque[] = "torque";
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;
    uint8_t choice = parse_choice(on_off, &console->token);
    bool is_led = line->address == CDS_REG_LED;

    if (choice == 0 || (line->is_repeated && line->values > 1) ||
        (!is_led && line->address != CDS_REG_TORQUE_ENABLE))
        return NULL;
    values[0].text = is_led ? led : torque;
    values[1].number = line->id;
    values[2].text = choice == 1 ? message_on : message_off;
    return message_on_is_1;
}

/* `pose stand in 0.5`: a bare time is ms. */
static const CDS_FLASH char *text_of_seconds(const struct console *console)
{
    const struct command_line *line = &console->line;
    uint8_t unit;

    if (!explain_unit(console, &unit) || unit != UNIT_MS)
        return NULL;
    for (uint8_t i = 0; i < line->numbers; i++)
        if (line->number[i].kind == NUMBER_BARE && line->number[i].decimals)
            return message_seconds;
    return NULL;
}

static const CDS_FLASH char *text_of_no_number(struct console *console)
{
    const struct command_line *line = &console->line;
    const CDS_FLASH char *message;

    if (line->error == 0)
        return text_of_seconds(console);
    if (line->command == NULL || line->error != console->error)
        return NULL;
    message = text_of_early_word(console);
    return message ? message : text_of_on(console);
}

/* `pose 90, 120` */
static const CDS_FLASH char *text_of_comma(const struct console *console)
{
    const struct token *word = &console->token;

    return console->line.error && word->length <= TOKEN_MAX && word->text[word->length - 1] == ','
               ? message_comma_behind
               : NULL;
}

/* `write 1 0x1E 512`: a value of two bytes for a register that the line names by its address. */
static const CDS_FLASH char *text_of_two_bytes(struct console *console)
{
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;
    struct cds_register at;
    uint16_t value;

    if (line->command == NULL || line->argument != ARGUMENT_VALUES || line->named ||
        line->command->instruction != CDS_WRITE || line->id == CDS_BROADCAST_ID ||
        line->values != 1 || !cds_register_at(line->address, &at) || at.width != 2 ||
        at.address != line->address || number_whole(&console->token, at.highest, &value))
        return NULL;
    values[0].number = line->id;
    values[1].number = line->address;
    values[2].number = value;
    return message_write_word;
}

/* The store has no sequence of the name, but a pose; or a pose is due, and the name is that of a
 * sequence. */
static const CDS_FLASH char *text_of_kind(const struct console *console)
{
    bool is_pose = console->error == ERROR_NO_SEQUENCE;
    uint8_t kind = is_pose ? MOTION_STORE_POSE : MOTION_STORE_SEQUENCE;

    if (console->line.names != 1 ||
        stored_find(console, (enum motion_store_kind)kind, 0) == MOTION_STORE_NONE)
        return NULL;
    if (is_pose)
        return message_is_pose;
    return command_set.moves ? message_is_sequence : NULL;
}

const CDS_FLASH char *slip_text(struct console *console)
{
    switch (console->error) {
    case ERROR_UNKNOWN_WORD: return text_of_early_number(console);
    case ERROR_NOT_A_NUMBER: return text_of_no_number(console);
    case ERROR_UNIT: return text_of_comma(console);
    case ERROR_OUT_OF_RANGE: return text_of_two_bytes(console);
    case ERROR_NO_POSE:
    case ERROR_NO_SEQUENCE: return text_of_kind(console);
    default: return NULL;
    }
}
