/* SPDX-License-Identifier: MIT */
/* More lines that are nearly right; see more_slips.h. */
#include "console/more_slips.h"

#include <stddef.h> // NULL
#include <string.h> // memchr()

#include "cds55xx/control_table.h"   // CDS_REG_GOAL_POSITION
#include "cds55xx/packet.h"          // CDS_AT_PARAMETERS
#include "console/commands/shared.h" // set_job()
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"
#include "console/slips.h"  // struct slip
#include "console/typing.h" // TYPING_NO_SEARCH

static const CDS_FLASH char message_one_command[] = "one command a line, no ';'";
static const CDS_FLASH char message_of_one[] = "one servo: 'ping %u', 'info %u'";
static const CDS_FLASH char message_digits[] = "too many digits; at most 3 decimals";
static const CDS_FLASH char message_plus[] = "without '+'";
static const CDS_FLASH char message_plus_angle[] = "without '+': ANGLE is where it goes";
static const CDS_FLASH char message_point[] = "digits around the point: 90.0, 0.5";
static const CDS_FLASH char message_angle_each[] =
    "an angle for each: 'group 1-3', 'pose 90 120 150'";
static const CDS_FLASH char message_register_first[] =
    "the ID comes first: 'get 1 PRESENT_POSITION'";
static const CDS_FLASH char message_goal_beyond[] = "%u is %a, its limits are %a to %a";
static const CDS_FLASH char message_own_limits[] =
    "angle limit error; CW_ANGLE_LIMIT to CCW_ANGLE_LIMIT are %a to %a";
static const CDS_FLASH char message_locked[] =
    "range error; the value is in range: if 'get %u LOCK' prints 1, switch its power off and on";

static const CDS_FLASH char command_move[] = "move";
static const CDS_FLASH char command_pose[] = "pose";
static const CDS_FLASH char command_set_register[] = "set";
static const CDS_FLASH char line_of_new[] = "'sequence NAME new POSE 1s'";

/* True if a word of the line has caused the error; it is console->token. */
static bool has_wrong_word(const struct console *console)
{
    return console->line.error == console->error && console->token.length &&
           console->token.length <= TOKEN_MAX;
}

/* ---- words ---- */

/* `move 1 90;move 2 90` */
static const CDS_FLASH char *text_of_semicolon(struct console *console)
{
    return has_wrong_word(console) && memchr(console->token.text, ';', console->token.length)
               ? message_one_command
               : NULL;
}

/* Words of other consoles. */
static const CDS_FLASH struct slip_word words_of_others[] = {
    {NULL, FLASH_TEXT("watch"), FLASH_TEXT("'monitor 1'")},
    {NULL, FLASH_TEXT("where"), FLASH_TEXT("'get 1 PRESENT_POSITION'")},
    {NULL, FLASH_TEXT("temp"), FLASH_TEXT("'get 1 PRESENT_TEMPERATURE'")},
    {NULL, FLASH_TEXT("halt"), FLASH_TEXT("'stop', or Ctrl-X")},
    {command_move, FLASH_TEXT("to"), FLASH_TEXT("'move 1 90'")},
    {FLASH_TEXT("limits"), FLASH_TEXT("off"), FLASH_TEXT("'limits 1 off', 'limits all off'")},
    {FLASH_TEXT("save"), command_pose, FLASH_TEXT("'pose save NAME'")},
    {FLASH_TEXT("save"), FLASH_TEXT("sequence"), line_of_new},
    {command_pose, FLASH_TEXT("save"), FLASH_TEXT("'pose save NAME'")},
    {command_pose, FLASH_TEXT("delete"), FLASH_TEXT("'pose delete NAME'")},
    {command_pose, FLASH_TEXT("show"), FLASH_TEXT("'pose show NAME'")},
    {FLASH_TEXT("sequence"), FLASH_TEXT("save"), line_of_new},
};

/* `where 1`, `move 1 to 90` */
static const CDS_FLASH char *text_of_other_word(struct console *console)
{
    const CDS_FLASH char *message = slip_word_text(
        words_of_others, sizeof words_of_others / sizeof words_of_others[0], console);

    if (message)
        console->phase = TYPING_NO_SEARCH; // the message names the line to type
    return message;
}

/* `scan 1`, `servos 1` */
static const CDS_FLASH char *text_of_servo_number(struct console *console)
{
    static const CDS_FLASH char scan[] = "scan", servos[] = "servos";
    const struct command_line *line = &console->line;
    uint16_t id;

    if (number_whole(&console->token, CDS_ID_MAX, &id) ||
        !(parse_is_command(line, scan) || parse_is_command(line, servos)))
        return NULL;
    console->printer.values[0].number = console->printer.values[1].number = id;
    return message_of_one;
}

/* `get PRESENT_POSITION 1` */
static const CDS_FLASH char *text_of_register_first(struct console *console)
{
    static const CDS_FLASH char get[] = "get";
    const struct command_line *line = &console->line;
    struct cds_register found;

    return parse_is_command(line, get) && has_wrong_word(console) &&
                   cds_register_named(console->token.text, console->token.length, &found)
               ? message_register_first
               : NULL;
}

/* ---- numbers ---- */

/* `move 1 +10`, `turn 1 +10`, `move 1 90.`, `move 1 .5` */
static const CDS_FLASH char *text_of_notation(struct console *console)
{
    const struct token *word = &console->token;

    if (!has_wrong_word(console) || console->line.argument != ARGUMENT_NUMBER)
        return NULL;
    if (*word->text == '+')
        return parse_is_command(&console->line, command_move) && console->line.numbers == 1
                   ? message_plus_angle
                   : message_plus;
    return *word->text == '.' || word->text[word->length - 1] == '.' ? message_point : NULL;
}

/* `move 1 90.123456789` */
static const CDS_FLASH char *text_of_digits(struct console *console)
{
    const struct token *word = &console->token;
    struct number number;

    return has_wrong_word(console) && console->line.argument == ARGUMENT_NUMBER &&
                   memchr(word->text, '.', word->length) &&
                   number_parse(word, &number) == ERROR_OUT_OF_RANGE
               ? message_digits
               : NULL;
}

/* `move 1-3 90 120 150`, `move 1,2 90 120` */
static const CDS_FLASH char *text_of_angle_each(struct console *console)
{
    const struct command_line *line = &console->line;
    uint16_t raw;

    return parse_is_command(line, command_move) && line->is_repeated &&
                   (line->values > 1 || line->takes_all) && line->numbers == 2 &&
                   line->number[1].kind == NUMBER_BARE &&
                   number_within(&line->number[0], CDS_UNIT_MDEG, &raw) == 0 &&
                   number_within(&line->number[1], CDS_UNIT_MDEG, &raw) == 0
               ? message_angle_each
               : NULL;
}

/* ---- refusals ---- */

/* `write 1 GOAL_POSITION 100`: a value of the register, not an angle. */
static const CDS_FLASH char *text_of_goal(struct console *console)
{
    const struct command_line *line = &console->line;
    const struct cds_servo_state *servo = console_servo(console);
    const uint8_t *bytes = line->request->packet.bytes;
    union printer_value *values = console->printer.values;
    uint16_t goal;

    if (!servo || line->command->instruction != CDS_WRITE ||
        bytes[CDS_AT_PARAMETERS] != CDS_REG_GOAL_POSITION ||
        bytes[CDS_AT_LENGTH] < CDS_LENGTH_MIN + 3) // address, and both bytes
        return NULL;
    goal = register_raw_at(bytes + CDS_AT_PARAMETERS + 1, 2);
    if (goal > CDS_VALUE_MAX || (goal >= servo->lowest && goal <= servo->highest))
        return NULL;
    values[0].number = values[1].number = goal;
    values[2].number = servo->lowest;
    values[3].number = servo->highest;
    return message_goal_beyond;
}

/* `move` beyond the angle limits that the servo keeps itself: `move` has read them (servo.c). */
static const CDS_FLASH char *text_of_own_limits(struct console *console)
{
    const uint8_t *limits = set_job(console)->limits;
    union printer_value *values = console->printer.values;

    if (!parse_is_command(&console->line, command_move) ||
        !(limits[0] | limits[1] | limits[2] | limits[3]))
        return NULL;
    values[0].number = register_raw_at(limits, 2);
    values[1].number = register_raw_at(limits + 2, 2);
    return message_own_limits;
}

/* `set` of an EEPROM register, `id`, `baud`: the console has checked the value, so the servo may be
 * locked (LOCK = 1). */
static const CDS_FLASH char *text_of_lock(struct console *console)
{
    static const CDS_FLASH char id[] = "id", baud[] = "baud";
    const struct command_line *line = &console->line;
    bool sets = parse_is_command(line, command_set_register) &&
                line->address < CDS_REG_TORQUE_ENABLE && line->number[0].kind != NUMBER_RAW;

    if (!(sets || parse_is_command(line, id) || parse_is_command(line, baud)))
        return NULL;
    console->printer.values[0].number = line->id;
    return message_locked;
}

static const CDS_FLASH struct slip more[] = {
    {ERROR_UNKNOWN_COMMAND, text_of_semicolon},
    {ERROR_UNKNOWN_COMMAND, text_of_other_word},
    {ERROR_UNKNOWN_WORD, text_of_semicolon},
    {ERROR_UNKNOWN_WORD, text_of_other_word},
    {ERROR_UNKNOWN_WORD, text_of_servo_number},
    {ERROR_NOT_A_NUMBER, text_of_semicolon},
    {ERROR_NOT_A_NUMBER, text_of_other_word},
    {ERROR_NOT_A_NUMBER, text_of_register_first},
    {ERROR_NOT_A_NUMBER, text_of_notation},
    {ERROR_UNIT, text_of_semicolon},
    {ERROR_OUT_OF_RANGE, text_of_digits},
    {ERROR_OUT_OF_RANGE, text_of_angle_each},
    {ERROR_COUNT, text_of_angle_each},
    {ERROR_COUNT, text_of_other_word},
    {CDS_LIMIT, text_of_goal},
    {ERROR_SERVO_ANGLE, text_of_own_limits},
    {ERROR_SERVO_RANGE, text_of_lock},
};

const CDS_FLASH char *more_slips(struct console *console)
{
    return slip_first_text(more, sizeof more / sizeof more[0], console);
}
