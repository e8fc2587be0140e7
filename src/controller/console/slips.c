/* SPDX-License-Identifier: MIT */
/* Lines that are nearly right; see slips.h. */
#include "console/slips.h"

#include <stddef.h> // NULL

#include "cds55xx/control_table.h"    // CDS_REG_LED
#include "cds55xx/packet.h"           // CDS_WRITE
#include "console/commands/monitor.h" // MONITOR_SERVOS
#include "console/commands/stored.h"  // stored_find()
#include "console/console.h"
#include "console/errors.h"
#include "console/explain.h"
#include "console/messages.h"
#include "console/parse.h"
#include "console/typing.h" // TYPING_NO_SEARCH

const CDS_FLASH char message_id_first[] = "the ID comes first: '%s'";
static const CDS_FLASH char message_no_number[] = "no number here, as in '%s'";
static const CDS_FLASH char message_on_is_1[] = "1 is on, 0 is off; or '%s %u %s'";
static const CDS_FLASH char message_comma_behind[] = "a space, no comma: 90 120";
static const CDS_FLASH char message_write_word[] = "a byte: 0 to 255; both: 'set %u %u %uraw'";
static const CDS_FLASH char message_seconds[] = "has too many decimals of ms; seconds: 0.5s";
const CDS_FLASH char message_is_pose[] = "a pose: 'pose NAME in 2s' moves to it";
static const CDS_FLASH char message_is_sequence[] =
    "a sequence: 'play NAME', 'play NAME times 2', 'play NAME loop'";
static const CDS_FLASH char message_steps_move[] = "beyond 300deg; steps: 'move %u %uraw'";
static const CDS_FLASH char message_steps[] = "beyond 300deg; steps: %uraw";
static const CDS_FLASH char message_unit_move[] = "write %s, without a space: 'move %u %u%s'";
static const CDS_FLASH char message_unit_word[] = "write %s, without a space: %u%s";
static const CDS_FLASH char message_two_servos[] =
    "a speed is 0 to 62rpm; two servos: 'move %u,%u %u'";
static const CDS_FLASH char message_range_word[] =
    "no space in a range of IDs, as in 'torque 1-3 on'";
static const CDS_FLASH char message_switch[] = "%s; if %u means %s: '%s %u %s'";
static const CDS_FLASH char message_switch_missing[] = "on|off is missing";
static const CDS_FLASH char message_id_is_twice[] = "an ID is given twice";
static const CDS_FLASH char message_move_in[] =
    "'move' takes no time; 'group %u', then 'pose %u%s in 2s'";
static const CDS_FLASH char message_move_at[] =
    "the speed stands behind the angle: 'move %u %u%s 30rpm'";
static const CDS_FLASH char message_write_unit[] =
    "'write' takes register values; with a unit: 'set %u %u %u%s'";
static const CDS_FLASH char message_write_unit_named[] =
    "'write' takes register values; with a unit: 'set %u %n %u%s'";
static const CDS_FLASH char message_bare_time[] =
    "too fast for a servo; %u is %ums: for seconds 'in %us'";
static const CDS_FLASH char message_measured[] = "read-only, measured; 'move %u %u%s' moves there";
static const CDS_FLASH char message_read_only[] = "read-only; 'get %u %u' prints it";
static const CDS_FLASH char message_has_limits[] =
    "limits of servo %u: %a to %a, %r; 'limits %u LOW HIGH' changes them";
static const CDS_FLASH char message_has_no_limits[] =
    "servo %u has none; 'limits %u LOW HIGH' sets some, 'info %u' shows those of its own";
static const CDS_FLASH char message_in_line_at_most[] =
    "too many servos or angles; at most %u in a line";
static const CDS_FLASH char message_at_most[] = "too many servos; at most %u";
static const CDS_FLASH char message_robot_at_most[] =
    "too many servos; the robot has at most %u: 'servos forget' empties its list";

#define MESSAGE_TRY (message_try + sizeof "unknown command;") // behind a known command
const CDS_FLASH char message_try[] = "unknown command; try %s";

static const CDS_FLASH char name_of_led[] = "led";
static const CDS_FLASH char name_of_torque[] = "torque";
static const CDS_FLASH char name_of_pose[] = "pose";
static const CDS_FLASH char name_of_move[] = "move";
static const CDS_FLASH char words_of_switch[] = "on|off";
static const CDS_FLASH char words_of_off[] = "off|stop";
static const CDS_FLASH char words_behind_angle[] = "in|at";
#define WORD_AT (words_behind_angle + 3)
static const CDS_FLASH char line_of_torque_off[] = "'torque 1 off'";

#define SECONDS_MAX 20 // of a move; a larger number without unit is more likely meant in ms

static bool is_move_of_one(const struct command_line *line)
{
    return parse_is_command(line, name_of_move) && slip_has_one_servo(line);
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
    console->printer.values[0].text = slip_line_to_type(line->command);
    return message_id_first;
}

/* `teach 1 on`, `cycle 4ms`: a number stands where a word is due. */
static const CDS_FLASH char *text_of_early_number(struct console *console)
{
    const struct command_line *line = &console->line;
    struct number number;

    if (!line->command || line->argument != ARGUMENT_NONE || number_parse(&console->token, &number))
        return NULL;
    console->printer.values[0].text = slip_line_to_type(line->command);
    return message_no_number;
}

/* `set 1 LED on` */
static const CDS_FLASH char *text_of_on(struct console *console)
{
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;
    uint8_t choice = parse_choice(words_of_switch, &console->token);
    bool is_led = line->address == CDS_REG_LED;

    if (line->error == 0 || choice == 0 || (line->is_repeated && line->values > 1) ||
        (!is_led && line->address != CDS_REG_TORQUE_ENABLE))
        return NULL;
    values[0].text = is_led ? name_of_led : name_of_torque;
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

/* Long names of units, with an example in the short one. */
static const CDS_FLASH struct {
    const CDS_FLASH char *words;
    const CDS_FLASH char *unit;
    uint16_t example;
    uint8_t kind; // enum number_kind
} long_units[] = {
    {FLASH_TEXT("steps|step"), FLASH_TEXT("raw"), 512, NUMBER_RAW},
    {FLASH_TEXT("degrees|degree"), FLASH_TEXT("deg"), 90, NUMBER_ANGLE},
    {FLASH_TEXT("seconds|second|sec"), FLASH_TEXT("s"), 2, NUMBER_TIME},
    {FLASH_TEXT("milliseconds|millisecond|msec"), FLASH_TEXT("ms"), 500, NUMBER_TIME},
    {FLASH_TEXT("volts|volt"), FLASH_TEXT("V"), 6, NUMBER_VOLTAGE},
    {FLASH_TEXT("percent"), FLASH_TEXT("%"), 50, NUMBER_SHARE},
};

/* True if numbers stand before the word that is wrong, and it is no value of a packet. */
static bool is_behind_number(const struct console *console)
{
    const struct command_line *line = &console->line;
    uint8_t numbers = line->numbers;

    if (!line->command || line->error != console->error || line->command->instruction)
        return false;
    if (line->error == ERROR_NOT_A_NUMBER && numbers)
        numbers--;                                                            // the word itself
    return numbers || (parse_is_command(line, name_of_pose) && line->values); // angles
}

/* `move 1 90 degrees` */
static const CDS_FLASH char *text_of_long_unit(struct console *console)
{
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;
    uint8_t row = 0, rows = sizeof long_units / sizeof long_units[0];

    while (row < rows && !parse_choice(long_units[row].words, &console->token))
        row++;
    if (row == rows || !is_behind_number(console))
        return NULL;
    values[0].text = values[2].text = values[3].text = long_units[row].unit;
    values[1].number = long_units[row].example;
    if (long_units[row].kind > NUMBER_ANGLE || !is_move_of_one(line) ||
        line->error != ERROR_NOT_A_NUMBER || line->number[0].kind != NUMBER_BARE ||
        !is_whole(line->number))
        return message_unit_word;
    values[1].number = line->id;
    values[2].number = (uint16_t)line->number[0].digits;
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
        number[0].kind != NUMBER_BARE || number[0].digits > CDS_ID_MAX ||
        number[0].digits == line->id || !is_whole(&number[0]) || !is_whole(&number[1]) ||
        number_within(&number[1], CDS_UNIT_MDEG, &raw) ||
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
    const struct command_line *line = &console->line;
    const struct token *word = &console->token;

    if (line->error == 0 || word->length == 0 || *word->text != '-')
        return NULL;
    return line->argument == ARGUMENT_IDS ||
                   (line->is_repeated && line->words == 3 &&
                    (word->length == 1 || line->argument == ARGUMENT_NONE))
               ? message_range_word
               : NULL;
}

/* `led 1 1`: the list of servos has taken the second number; both words are one ID. */
static const CDS_FLASH char *text_of_switch(struct console *console)
{
    const struct command_line *line = &console->line;
    const uint8_t *ids = line->request->packet.bytes;
    union printer_value *values = console->printer.values;

    if (line->words != 3 || line->singles != 2 || ids[line->values - 1] > 1 ||
        !parse_has_name(line->usage, words_of_switch))
        return NULL;
    values[0].text = console->error == ERROR_TWICE ? message_id_is_twice : message_switch_missing;
    values[1].number = ids[line->values - 1];
    values[2].text = values[5].text = values[1].number ? message_on : message_off;
    values[3].text = parse_is_command(line, name_of_led) ? name_of_led : name_of_torque;
    values[4].number = ids[0];
    return message_switch;
}

/* `move 1 90 in 2s`, `move 1 90 at 30rpm` */
static const CDS_FLASH char *text_of_move_word(struct console *console)
{
    const struct command_line *line = &console->line;
    uint8_t choice = parse_choice(words_behind_angle, &console->token);

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
    uint16_t raw;

    if (line->command == NULL || line->argument != ARGUMENT_VALUES || line->values != 1 ||
        line->id > CDS_ID_MAX || line->command->instruction != CDS_WRITE ||
        number_parse(&console->token, &number) || number.kind == NUMBER_BARE ||
        !is_whole(&number) ||
        number_within(&number, cds_units_of(&cds_profile_cds55xx, line->address), &raw))
        return NULL;
    values[0].number = line->id;
    values[1].number = line->address;
    put_number(&values[2], &number);
    return command_set.has_room ? message_write_unit_named : message_write_unit;
}

/* `set 1 PRESENT_POSITION 5` */
static const CDS_FLASH char *text_of_read_only(struct console *console)
{
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;
    struct cds_register at;
    uint16_t raw;

    if (!cds_register_at(line->address, &at) || at.access != CDS_ACCESS_RD ||
        !slip_has_one_servo(line))
        return NULL;
    values[0].number = line->id;
    if (at.address == CDS_REG_PRESENT_POSITION && is_whole(line->number) &&
        number_within(line->number, CDS_UNIT_MDEG, &raw) == 0) {
        put_number(&values[1], line->number);
        return message_measured;
    }
    values[1].number = at.address;
    return message_read_only;
}

/* `pose stand in 2`: 2 s are meant. */
static const CDS_FLASH char *text_of_bare_time(struct console *console)
{
    const struct command_line *line = &console->line;
    const struct number *time = line->number;
    union printer_value *values = console->printer.values;

    if (!parse_is_command(line, name_of_pose) || line->numbers != 1 || time->kind != NUMBER_BARE ||
        !is_whole(time) || time->digits > SECONDS_MAX)
        return NULL;
    values[0].number = values[1].number = values[2].number = (uint16_t)time->digits;
    return message_bare_time;
}

/* `limits 1`, which a chip with more flash carries out (limits_show.c). */
static const CDS_FLASH char *text_of_limits_shown(struct console *console)
{
    static const CDS_FLASH char limits[] = "limits";
    const struct command_line *line = &console->line;
    const struct cds_servo_state *servo = cds_servos_find(&console->robot->servos, line->id);
    union printer_value *values = console->printer.values;

    if (command_set.has_room || !servo || !parse_is_command(line, limits) || line->numbers ||
        !slip_has_one_servo(line))
        return NULL;
    values[0].number = values[1].number = values[2].number = values[4].number = line->id;
    if (!servo->has_limits)
        return message_has_no_limits;
    values[1].number = servo->lowest;
    values[2].number = servo->highest;
    values[3].number = servo->fastest;
    return message_has_limits;
}

/* `sequence walk loop` */
static const CDS_FLASH char *text_of_stored(struct console *console)
{
    static const CDS_FLASH char sequence[] = "sequence", plays[] = "loop|play";

    return command_set.moves && parse_is_command(&console->line, sequence) &&
                   parse_choice(plays, &console->token)
               ? message_is_sequence
               : NULL;
}

static const CDS_FLASH struct slip_word tried[] = {
    {NULL, FLASH_TEXT("goto|go|goal"), FLASH_TEXT("'move 1 90deg'")},
    {NULL, FLASH_TEXT("speed"), FLASH_TEXT("'move 1 90deg 30rpm'")},
    {NULL, FLASH_TEXT("delete|remove|erase"),
     FLASH_TEXT("'pose delete NAME', 'sequence delete NAME'")},
    {NULL, FLASH_TEXT("enable|on"), FLASH_TEXT("'torque 1 on'")},
    {NULL, FLASH_TEXT("disable|off"), line_of_torque_off},
    {NULL, FLASH_TEXT("list|show|ls"), FLASH_TEXT("'servos', 'pose list'")},
    {NULL, FLASH_TEXT("exit|quit"), FLASH_TEXT("Ctrl-T, then Ctrl-Q in picocom")},
    {name_of_torque, words_of_off, line_of_torque_off},
    {name_of_led, words_of_off, FLASH_TEXT("'led 1 off'")},
    {FLASH_TEXT("turn"), words_of_off, FLASH_TEXT("'turn 1 0', or 'torque 1 off'")},
    {FLASH_TEXT("monitor"), FLASH_TEXT("plot"), FLASH_TEXT("'monitor 1 as plot'")},
    {name_of_move, words_behind_angle, FLASH_TEXT("'move 1-3 90 30rpm'; in a time: 'help pose'")},
    {name_of_pose, WORD_AT, FLASH_TEXT("'pose NAME in 2s'")},
};

const CDS_FLASH char *slip_word_text(const CDS_FLASH struct slip_word *rows, uint8_t count,
                                     struct console *console)
{
    const struct command_line *line = &console->line;

    for (; count; count--, rows++) {
        const CDS_FLASH char *command = rows->command;
        bool is_of_row = command ? parse_is_command(line, command) : line->command == NULL;

        if (!is_of_row || !parse_choice(rows->words, &console->token))
            continue;
        console->printer.values[0].text = rows->lines;
        return line->command ? MESSAGE_TRY : message_try;
    }
    return NULL;
}

/* `goto 1 90`, `turn 1 off` */
static const CDS_FLASH char *text_of_tried(struct console *console)
{
    return slip_word_text(tried, sizeof tried / sizeof tried[0], console);
}

/* `wave`: the name of a stored sequence */
static const CDS_FLASH char *text_of_sequence(struct console *console)
{
    const struct token *word = &console->token;

    if (!command_set.moves || console->line.command || word->length > MOTION_STORE_NAME ||
        stored_may_read() ||
        motion_store_find(console_store(), MOTION_STORE_SEQUENCE, word->text, word->length) ==
            MOTION_STORE_NONE)
        return NULL;
    console->phase = TYPING_NO_SEARCH; // this name is right
    return message_is_sequence;
}

/* `play wave twice`, `play wave 2` */
static const CDS_FLASH char *text_of_play(struct console *console)
{
    static const CDS_FLASH char play[] = "play", words[] = "twice|repeat|forever";
    const struct token *word = &console->token;
    struct number number;

    return command_set.moves && parse_is_command(&console->line, play) &&
                   (parse_choice(words, word) || number_parse(word, &number) == 0)
               ? message_is_sequence
               : NULL;
}

/* Of several limits the one that the line has broken. Only for chips with room for it. */
static const CDS_FLASH char *text_of_many(struct console *console)
{
    static const CDS_FLASH char monitor[] = "monitor";
    const struct command_line *line = &console->line;
    uint16_t *most = &console->printer.values[0].number;

    if (!command_set.has_room)
        return NULL;
    *most = PARSE_LIST_MAX;
    if (line->error)
        return message_in_line_at_most;
    *most = MONITOR_SERVOS;
    if (parse_is_command(line, monitor))
        return message_at_most;
    *most = ROBOT_SERVOS;
    return message_robot_at_most;
}

static const CDS_FLASH struct slip slips[] = {
    {ERROR_UNKNOWN_COMMAND, text_of_sequence},
    {ERROR_UNKNOWN_COMMAND, text_of_tried},
    {ERROR_UNKNOWN_WORD, text_of_tried},
    {ERROR_UNKNOWN_WORD, text_of_play},
    {ERROR_UNKNOWN_WORD, text_of_spaced_range},
    {ERROR_UNKNOWN_WORD, text_of_early_number},
    {ERROR_UNKNOWN_WORD, text_of_long_unit},
    {ERROR_UNKNOWN_WORD, text_of_stored},
    {ERROR_NOT_A_NUMBER, text_of_seconds},
    {ERROR_NOT_A_NUMBER, text_of_long_unit},
    {ERROR_NOT_A_NUMBER, text_of_move_word},
    {ERROR_NOT_A_NUMBER, text_of_tried},
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
    {ERROR_TOO_MANY, text_of_many},
    {ERROR_TOO_FAST, text_of_bare_time},
    {ERROR_NO_POSE, text_of_kind},
    {ERROR_NO_SEQUENCE, text_of_kind},
};

const CDS_FLASH char *slip_first_text(const CDS_FLASH struct slip *rows, uint8_t count,
                                      struct console *console)
{
    const CDS_FLASH char *message = NULL;

    for (; !message && count; count--, rows++)
        if (rows->error == console->error)
            message = rows->text(console);
    return message;
}

const CDS_FLASH char *slip_text(struct console *console)
{
    return slip_first_text(slips, sizeof slips / sizeof slips[0], console);
}
