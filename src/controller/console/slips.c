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
static const CDS_FLASH char message_steps_move[] = "beyond 300deg; steps: 'move %u %uraw'";
static const CDS_FLASH char message_steps[] = "beyond 300deg; steps: %uraw";
static const CDS_FLASH char message_unit_move[] =
    "a unit is short, without a space: 'move %u %u%s'";
static const CDS_FLASH char message_unit_word[] = "a unit is short, without a space: 90deg, 512raw";
static const CDS_FLASH char message_two_servos[] =
    "a speed is 0 to 62rpm; two servos: 'move %u,%u %u'";
static const CDS_FLASH char message_range_word[] =
    "no space in a range of IDs, as in 'torque 1-3 on'";
static const CDS_FLASH char message_switch[] = "write %s, no number: '%s %u %s'";
static const CDS_FLASH char message_twice_or_switch[] =
    "an ID is given twice; if it means %s: '%s %u %s'";
static const CDS_FLASH char message_move_in[] =
    "'move' takes no time; 'group %u', then 'pose %u%s in 2s'";
static const CDS_FLASH char message_move_at[] =
    "the speed stands behind the angle: 'move %u %u%s 30rpm'";
static const CDS_FLASH char message_write_unit[] =
    "'write' takes register values; with a unit: 'set %u %u %u%s'";
static const CDS_FLASH char message_bare_time[] =
    "too fast for a servo; a time without unit is ms; seconds: 'in %us'";
static const CDS_FLASH char message_measured[] = "read-only, measured; 'move %u %u%s' moves there";
static const CDS_FLASH char message_read_only[] = "read-only; 'read %u %u %u' reads it";
static const CDS_FLASH char message_has_limits[] =
    "limits of servo %u: %a to %a, %r; 'limits %u LOW HIGH' changes them";
static const CDS_FLASH char message_has_no_limits[] =
    "no limits of the controller for servo %u; 'limits %u LOW HIGH' sets them, 'info %u' shows "
    "those in the servo";

#define SECONDS_MAX 600 // of a move

/* A line to type for the command: its example, or its usage. */
static const CDS_FLASH char *line_to_type(const struct command_line *line)
{
    const CDS_FLASH char *example = COMMAND_DETAILS_TEXT(line->command->example);

    return example ? example : line->command->usage;
}

/* True if the line names one servo, or ID 254: its ID is line->id. */
static bool has_one_servo(const struct command_line *line)
{
    return !line->takes_all && !(line->is_repeated && line->values > 1);
}

static bool is_move_of_one(const struct command_line *line)
{
    static const CDS_FLASH char move[] = "move";

    return parse_is_command(line, move) && has_one_servo(line);
}

/* True if the number can stand in a line to type. */
static bool is_whole(const struct number *number)
{
    return number->decimals == 0 && number->digits >= 0 && number->digits <= UINT16_MAX;
}

/* The number and its unit, for "%u%s". */
static void put_number(union printer_value *values, const struct number *number)
{
    values[0].number = (uint16_t)number->digits;
    values[1].text = number_unit_name(number);
}

/* `torque on 1` */
static const CDS_FLASH char *text_of_early_word(struct console *console)
{
    const struct command_line *line = &console->line;

    if (line->command == NULL || line->error == 0 || line->argument == ARGUMENT_NUMBER ||
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

    if (line->error == 0 || choice == 0 || (line->is_repeated && line->values > 1) ||
        (!is_led && line->address != CDS_REG_TORQUE_ENABLE))
        return NULL;
    values[0].text = is_led ? led : torque;
    values[1].number = line->id;
    values[2].text = choice == 1 ? message_on : message_off;
    return message_on_is_1;
}

/* `pose stand in 0.5`: a bare time is ms. */
static const CDS_FLASH char *text_of_seconds(struct console *console)
{
    const struct command_line *line = &console->line;
    uint8_t unit;

    if (line->error || !explain_unit(console, &unit) || unit != UNIT_MS)
        return NULL;
    for (uint8_t i = 0; i < line->numbers; i++)
        if (line->number[i].kind == NUMBER_BARE && line->number[i].decimals)
            return message_seconds;
    return NULL;
}

/* `pose 90, 120` */
static const CDS_FLASH char *text_of_comma(struct console *console)
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
static const CDS_FLASH char *text_of_kind(struct console *console)
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

/* `move 1 512`: 512 steps are meant. */
static const CDS_FLASH char *text_of_steps(struct console *console)
{
    const struct command_line *line = &console->line;
    const struct number *angle = line->number;
    struct number word;
    uint16_t raw;
    uint8_t unit;

    if (!explain_unit(console, &unit) || unit != CDS_UNIT_MDEG)
        return NULL;
    if (line->error) {
        if (number_parse(&console->token, &word))
            return NULL;
        angle = &word;
    } else if (line->numbers > 1 && number_within(angle, CDS_UNIT_MDEG, &raw) == 0) {
        angle++; // HIGH of `limits`
    }
    if (angle->kind != NUMBER_BARE || !is_whole(angle) || angle->digits > CDS_VALUE_MAX ||
        number_within(angle, CDS_UNIT_MDEG, &raw) == 0)
        return NULL;
    console->printer.values[0].number = (uint16_t)angle->digits;
    if (!is_move_of_one(line))
        return message_steps;
    console->printer.values[0].number = line->id;
    console->printer.values[1].number = (uint16_t)angle->digits;
    return message_steps_move;
}

static const CDS_FLASH struct {
    const CDS_FLASH char *words;
    const CDS_FLASH char *unit;
} long_units[] = {
    {FLASH_TEXT("steps|step"), FLASH_TEXT("raw")},
    {FLASH_TEXT("degrees|degree"), FLASH_TEXT("deg")},
    {FLASH_TEXT("seconds|second|sec"), FLASH_TEXT("s")},
    {FLASH_TEXT("milliseconds|millisecond|msec"), FLASH_TEXT("ms")},
    {FLASH_TEXT("volts|volt"), FLASH_TEXT("V")},
    {FLASH_TEXT("percent"), FLASH_TEXT("%")},
};

/* `move 1 90 degrees` */
static const CDS_FLASH char *text_of_long_unit(struct console *console)
{
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;
    uint8_t row = 0, rows = sizeof long_units / sizeof long_units[0];

    while (row < rows && !parse_choice(long_units[row].words, &console->token))
        row++;
    if (row == rows || !line->command || line->error != console->error || line->words < 3 ||
        line->command->instruction)
        return NULL;
    if (!is_move_of_one(line) || line->numbers != 2 || !is_whole(line->number))
        return message_unit_word;
    values[0].number = line->id;
    values[1].number = (uint16_t)line->number[0].digits;
    values[2].text = long_units[row].unit;
    return message_unit_move;
}

/* `move 1 2 90`: in front of a number a list of servos is one word. */
static const CDS_FLASH char *text_of_two_servos(struct console *console)
{
    const struct command_line *line = &console->line;
    const struct number *number = line->number;
    union printer_value *values = console->printer.values;
    uint16_t raw;

    if (line->error || !is_move_of_one(line) || line->numbers != 2 ||
        number[0].kind != NUMBER_BARE || number[0].digits > CDS_ID_MAX || !is_whole(&number[0]) ||
        !is_whole(&number[1]) || number_within(&number[1], CDS_UNIT_MDEG, &raw) ||
        !cds_servos_find(&console->robot->servos, (uint8_t)number[0].digits))
        return NULL;
    values[0].number = line->id;
    values[1].number = (uint16_t)number[0].digits;
    values[2].number = (uint16_t)number[1].digits;
    return message_two_servos;
}

/* `torque 1 - 3 on` */
static const CDS_FLASH char *text_of_spaced_range(struct console *console)
{
    const struct token *word = &console->token;

    return console->line.command && console->line.words == 3 && *word->text == '-' &&
                   (word->length == 1 || console->line.argument == ARGUMENT_NONE)
               ? message_range_word
               : NULL;
}

/* `led 1 1`: the list of servos has taken the second number. */
static const CDS_FLASH char *text_of_switch(struct console *console)
{
    static const CDS_FLASH char on_off[] = "on|off", led[] = "led", torque[] = "torque";
    const struct command_line *line = &console->line;
    const uint8_t *ids = line->request->packet.bytes;
    union printer_value *values = console->printer.values;

    if (line->words != 3 || line->takes_all || line->values == 0 || line->values > 2 ||
        ids[line->values - 1] > 1 || !parse_has_name(line->usage, on_off))
        return NULL;
    values[1].text = parse_is_command(line, led) ? led : torque;
    values[2].number = ids[0];
    values[0].text = values[3].text = ids[line->values - 1] ? message_on : message_off;
    return console->error == ERROR_TWICE ? message_twice_or_switch : message_switch;
}

/* `move 1 90 in 2s`, `move 1 90 at 30rpm` */
static const CDS_FLASH char *text_of_move_word(struct console *console)
{
    static const CDS_FLASH char words[] = "in|at";
    const struct command_line *line = &console->line;
    uint8_t choice = parse_choice(words, &console->token);

    if (choice == 0 || !is_move_of_one(line) || line->numbers != 2 || !is_whole(line->number))
        return NULL;
    console->printer.values[0].number = line->id;
    put_number(&console->printer.values[1], line->number);
    return choice == 1 ? message_move_in : message_move_at;
}

/* `write 1 GOAL_POSITION 90deg` */
static const CDS_FLASH char *text_of_write_unit(struct console *console)
{
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;
    struct number number;

    if (line->command == NULL || line->argument != ARGUMENT_VALUES || line->values != 1 ||
        line->command->instruction != CDS_WRITE || number_parse(&console->token, &number) ||
        number.kind == NUMBER_BARE || !is_whole(&number))
        return NULL;
    values[0].number = line->id;
    values[1].number = line->address;
    put_number(&values[2], &number);
    return message_write_unit;
}

/* `set 1 PRESENT_POSITION 5` */
static const CDS_FLASH char *text_of_read_only(struct console *console)
{
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;
    struct cds_register at;
    uint16_t raw;

    if (!cds_register_at(line->address, &at) || at.access != CDS_ACCESS_RD || !has_one_servo(line))
        return NULL;
    values[0].number = line->id;
    if (at.address == CDS_REG_PRESENT_POSITION && is_whole(line->number) &&
        number_within(line->number, CDS_UNIT_MDEG, &raw) == 0) {
        put_number(&values[1], line->number);
        return message_measured;
    }
    values[1].number = at.address;
    values[2].number = at.width;
    return message_read_only;
}

/* `pose stand in 2`: 2 s are meant. */
static const CDS_FLASH char *text_of_bare_time(struct console *console)
{
    static const CDS_FLASH char pose[] = "pose";
    const struct command_line *line = &console->line;
    const struct number *time = line->number;
    union printer_value *values = console->printer.values;

    if (!parse_is_command(line, pose) || line->numbers != 1 || time->kind != NUMBER_BARE ||
        !is_whole(time) || time->digits > SECONDS_MAX)
        return NULL;
    values[0].number = (uint16_t)time->digits;
    return message_bare_time;
}

/* `limits 1` */
static const CDS_FLASH char *text_of_limits_shown(struct console *console)
{
    static const CDS_FLASH char limits[] = "limits";
    const struct command_line *line = &console->line;
    const struct cds_servo_state *servo = cds_servos_find(&console->robot->servos, line->id);
    union printer_value *values = console->printer.values;

    if (!servo || !parse_is_command(line, limits) || line->numbers || !has_one_servo(line))
        return NULL;
    values[0].number = values[1].number = values[2].number = values[4].number = line->id;
    if (!servo->has_limits)
        return message_has_no_limits;
    values[1].number = servo->lowest;
    values[2].number = servo->highest;
    values[3].number = servo->fastest;
    return message_has_limits;
}

/* The slips of an error; the first one that has a text is it. */
static const CDS_FLASH struct {
    uint8_t error;
    const CDS_FLASH char *(*text)(struct console *console);
} slips[] = {
    {ERROR_UNKNOWN_WORD, text_of_spaced_range},
    {ERROR_UNKNOWN_WORD, text_of_early_number},
    {ERROR_UNKNOWN_WORD, text_of_long_unit},
    {ERROR_NOT_A_NUMBER, text_of_seconds},
    {ERROR_NOT_A_NUMBER, text_of_long_unit},
    {ERROR_NOT_A_NUMBER, text_of_move_word},
    {ERROR_NOT_A_NUMBER, text_of_spaced_range},
    {ERROR_NOT_A_NUMBER, text_of_write_unit},
    {ERROR_NOT_A_NUMBER, text_of_early_word},
    {ERROR_NOT_A_NUMBER, text_of_on},
    {ERROR_COUNT, text_of_switch},
    {ERROR_COUNT, text_of_long_unit},
    {ERROR_COUNT, text_of_limits_shown},
    {ERROR_TWICE, text_of_switch},
    {ERROR_UNIT, text_of_comma},
    {ERROR_OUT_OF_RANGE, text_of_two_bytes},
    {ERROR_OUT_OF_RANGE, text_of_two_servos},
    {ERROR_OUT_OF_RANGE, text_of_steps},
    {ERROR_NOT_WRITABLE, text_of_read_only},
    {ERROR_TOO_FAST, text_of_bare_time},
    {ERROR_NO_POSE, text_of_kind},
    {ERROR_NO_SEQUENCE, text_of_kind},
};

const CDS_FLASH char *slip_text(struct console *console)
{
    const CDS_FLASH char *message = NULL;

    for (uint8_t i = 0; !message && i < sizeof slips / sizeof slips[0]; i++)
        if (slips[i].error == console->error)
            message = slips[i].text(console);
    return message;
}
