/* SPDX-License-Identifier: MIT */
/* More lines that are nearly right; see more_slips.h. */
#include "console/more_slips.h"

#include <stddef.h> // NULL
#include <string.h> // memchr(), memcpy()

#include "cds55xx/control_table.h"   // CDS_REG_GOAL_POSITION
#include "cds55xx/motion.h"          // CDS_MOTION_OVERRIDE_MIN
#include "cds55xx/packet.h"          // CDS_AT_PARAMETERS
#include "console/commands/shared.h" // set_job()
#include "console/commands/stored.h" // stored_length()
#include "console/console.h"
#include "console/errors.h"
#include "console/explain.h" // explain_is_settings()
#include "console/messages.h"
#include "console/misplaced.h" // misplaced_text()
#include "console/slips.h"     // struct slip
#include "console/typing.h"    // TYPING_NO_SEARCH
#include "robot/settings.h"    // settings_table

static const CDS_FLASH char message_dwell_and_pass[] =
    "a step has 'dwell TIME' or 'pass', not both";
static const CDS_FLASH char message_one_command[] = "one command a line, no ';'";
static const CDS_FLASH char message_of_one[] = "one servo: 'ping %u', 'info %u'";
static const CDS_FLASH char message_digits[] = "too many digits; at most 3 decimals";
static const CDS_FLASH char message_plus[] = "without '+'";
static const CDS_FLASH char message_plus_angle[] =
    "without '+': ANGLE is where it goes; 'get %u PRESENT_POSITION' prints where it is";
static const CDS_FLASH char message_id_changes[] = "'id %u %u' changes it";
static const CDS_FLASH char message_rate_changes[] = "'baud %u %l%s' changes it";
static const CDS_FLASH char message_setting_switch[] = "write %u (%s): 'settings %s %u'";
static const CDS_FLASH char message_counts[] =
    "angles: %u, servos of the group: %u; give one for each; 'group' shows them";
static const CDS_FLASH char message_point[] = "digits around the point: 90.0, 0.5";
static const CDS_FLASH char message_angle_each[] =
    "an angle for each: 'group 1-3', 'pose 90 120 150'";
static const CDS_FLASH char message_stands_beyond[] =
    "it stands at %a, its limits are %a to %a: turn it into them by hand; or 'move %i ANGLE "
    "SPEED', then 'torque %i on' drives it there";
static const CDS_FLASH char message_torque_beyond[] =
    "its goal is beyond its limits, %a to %a: 'move %i ANGLE SPEED' gives it another, 'teach off "
    "%i' makes its position the goal, if that is within them";
static const CDS_FLASH char message_goal_beyond[] = "%u is %a, its limits are %a to %a";
static const CDS_FLASH char message_pose_angle[] =
    "servo %u: the angle, %a, is not within its limits, %a to %a";
static const CDS_FLASH char message_pose_speed[] =
    "servo %u: its limits need a SPEED above 0, up to %r, as in 'pose 90 120 at %r'";
static const CDS_FLASH char message_second_byte[] =
    "%x is the second byte of %n, whose address is %x; 'read' and 'write' take single bytes";
static const CDS_FLASH char message_error_help[] =
    "no help on errors here; docs/errors.md lists their numbers";
static const CDS_FLASH char message_times_is_missing[] =
    "a number of runs stands behind 'times': 'play NAME times %u'";
static const CDS_FLASH char message_at_is_missing[] =
    "a speed stands behind 'at': 'play NAME at %u%'";
static const CDS_FLASH char message_delete_pose[] = "'pose delete NAME' deletes a pose";
static const CDS_FLASH char message_delete_sequence[] = "'sequence delete NAME' deletes a sequence";
static const CDS_FLASH char message_in_is_missing[] = "a time stands behind 'in': '%s'";
static const CDS_FLASH char message_own_limits[] =
    "angle limit error; CW_ANGLE_LIMIT to CCW_ANGLE_LIMIT are %a to %a";
static const CDS_FLASH char message_behind_table[] =
    "too many values: from %x to %x, the last register, there is room for %u";
static const CDS_FLASH char message_id_1_listed[] =
    "ID 1 is in the robot's list, nothing was written; 'id 1 NEW' first, or unplug servo 1, then "
    "'servos forget 1'";
static const CDS_FLASH char message_locked[] =
    "range error; the value is in range: if 'get %u LOCK' prints 1, switch its power off and on";

static const CDS_FLASH char command_move[] = "move";
static const CDS_FLASH char command_pose[] = "pose";
static const CDS_FLASH char command_cycle[] = "cycle";
static const CDS_FLASH char command_sequence[] = "sequence";
static const CDS_FLASH char command_set_register[] = "set";
const CDS_FLASH char more_slips_pose_line[] = "pose NAME in 2s";
static const CDS_FLASH char line_of_new[] = "'sequence NAME new POSE 1s'";

#define SETTING_NO_SWITCH UINT16_MAX
#define STEP_WORDS        6 // sequence NAME add POSE pass dwell: words that are no numbers

bool more_slips_has_word(const struct console *console)
{
    return console->line.error == console->error && console->token.length &&
           console->token.length <= TOKEN_MAX;
}

/* True if the line names one servo: line->id. */
static bool names_one_servo(const struct command_line *line)
{
    return slip_has_one_servo(line) && line->id <= CDS_ID_MAX;
}

/* ---- words ---- */

/* `move 1 90;move 2 90` */
static const CDS_FLASH char *text_of_semicolon(struct console *console)
{
    return more_slips_has_word(console) && memchr(console->token.text, ';', console->token.length)
               ? message_one_command
               : NULL;
}

struct token more_slips_name(const struct console *console)
{
    struct token name = {.length = stored_length(console, 0)};

    memcpy(name.text, parse_name(&console->line, 0), PARSE_NAME_SIZE);
    return name;
}

static const CDS_FLASH char lines_of_torque_off[] = "'torque 1 off', 'torque all off'";
static const CDS_FLASH char line_of_add[] = "'sequence NAME add POSE 2s'";

/* Words of other consoles. */
static const CDS_FLASH struct slip_word words_of_others[] = {
    {NULL, FLASH_TEXT("watch"), FLASH_TEXT("'monitor 1'")},
    {NULL, FLASH_TEXT("where|position|angle"), FLASH_TEXT("'get 1 PRESENT_POSITION'")},
    {NULL, FLASH_TEXT("temp|temperature"), FLASH_TEXT("'get 1 PRESENT_TEMPERATURE'")},
    {NULL, FLASH_TEXT("voltage|volt|supply|battery"), FLASH_TEXT("'get 1 PRESENT_VOLTAGE'")},
    {NULL, FLASH_TEXT("load|current"), FLASH_TEXT("'get 1 PRESENT_LOAD'")},
    {NULL, FLASH_TEXT("units|unit"), FLASH_TEXT("'help units'")},
    {NULL, FLASH_TEXT("errors|error"), FLASH_TEXT("docs/errors.md, which lists the numbers")},
    {NULL, FLASH_TEXT("halt|estop|abort"), FLASH_TEXT("'stop', or Ctrl-X")},
    {NULL, FLASH_TEXT("off|disable|relax|limp"), lines_of_torque_off},
    {NULL, FLASH_TEXT("hold|freeze"), FLASH_TEXT("'teach off 1', which holds a servo where it is")},
    {NULL, FLASH_TEXT("find|search|detect|discover|rescan"), FLASH_TEXT("'scan', 'scan all'")},
    {NULL, FLASH_TEXT("unlock"),
     FLASH_TEXT("to switch the servo's power off and on, which ends 'lock'")},
    {NULL, FLASH_TEXT("reboot|restart"),
     FLASH_TEXT("the reset key, or to switch the board off and on")},
    {NULL, FLASH_TEXT("add"), line_of_add},
    {NULL, FLASH_TEXT("insert"), FLASH_TEXT("'sequence NAME insert N POSE TIME'")},
    {NULL, FLASH_TEXT("loop|run|start"), FLASH_TEXT("'play NAME', 'play NAME loop'")},
    {command_move, FLASH_TEXT("to"), FLASH_TEXT("'move 1 90'")},
    {FLASH_TEXT("limits"), FLASH_TEXT("off|reset|clear|remove|none"),
     FLASH_TEXT("'limits 1 off', 'limits all off'")},
    {FLASH_TEXT("save"), command_pose, FLASH_TEXT("'pose save NAME'")},
    {FLASH_TEXT("save"), FLASH_TEXT("sequence"), line_of_new},
    {FLASH_TEXT("group"), FLASH_TEXT("add|remove|none|off|clear"),
     FLASH_TEXT("'group 1 2 3', which names all servos of the group")},
    {command_cycle, FLASH_TEXT("on|start|run"), FLASH_TEXT("'cycle every 4ms'")},
    {command_cycle, FLASH_TEXT("stop|end"), FLASH_TEXT("'cycle off'")},
    {command_pose, FLASH_TEXT("save"), FLASH_TEXT("'pose save NAME'")},
    {command_pose, FLASH_TEXT("delete"), FLASH_TEXT("'pose delete NAME'")},
    {command_pose, FLASH_TEXT("show"), FLASH_TEXT("'pose show NAME'")},
    {command_sequence, FLASH_TEXT("save"), line_of_new},
    {FLASH_TEXT("torque"), FLASH_TEXT("off|stop"), lines_of_torque_off},
    {command_sequence, FLASH_TEXT("in|at|for|to"), line_of_add},
    {FLASH_TEXT("monitor"), FLASH_TEXT("for"),
     FLASH_TEXT("'monitor 1 every 100ms', a key ends it")},
    {FLASH_TEXT("settings"), FLASH_TEXT("once"), FLASH_TEXT("'settings autostart NAME'")},
};

/* `where 1`, `move 1 to 90` */
static const CDS_FLASH char *text_of_other_word(struct console *console)
{
    const CDS_FLASH char *message = slip_word_text(
        words_of_others, sizeof words_of_others / sizeof words_of_others[0], console);

    if (console->line.command && explain_is_settings(&console->line) && !console->line.names)
        return NULL; // not `settings autostart NAME`
    if (message)
        console->phase = TYPING_NO_SEARCH; // the message names the line to type
    return message;
}

/* `help error 57`, `help 57` */
static const CDS_FLASH char *text_of_error_help(struct console *console)
{
    static const CDS_FLASH char help[] = "help", errors[] = "errors|error";
    uint16_t number;

    return parse_is_command(&console->line, help) &&
                   (parse_choice(errors, &console->token) ||
                    number_whole(&console->token, UINT8_MAX, &number) == 0)
               ? message_error_help
               : NULL;
}

/* `pose stand 2s` */
static const CDS_FLASH char *text_of_time_without_in(struct console *console)
{
    const struct command_line *line = &console->line;
    struct number number;

    if (!parse_is_command(line, command_pose) || line->names != 1 ||
        number_parse(&console->token, &number))
        return NULL;
    console->printer.values[0].text = more_slips_pose_line;
    return message_in_is_missing;
}

/* `play wave 3`, `play wave 50%` */
static const CDS_FLASH char *text_of_bare_play(struct console *console)
{
    static const CDS_FLASH char play[] = "play";
    struct number number;
    uint16_t *value = &console->printer.values[0].number;
    uint8_t percent;

    if (!parse_is_command(&console->line, play) || console->line.names != 1)
        return NULL;
    if (number_whole(&console->token, UINT16_MAX, value) == 0)
        return *value ? message_times_is_missing : NULL;
    if (number_parse(&console->token, &number) || number_percent(&number, &percent) ||
        percent < CDS_MOTION_OVERRIDE_MIN || percent > CDS_MOTION_OVERRIDE_MAX)
        return NULL;
    *value = percent;
    return message_at_is_missing;
}

/* `pose del low`, `sequence rm walk` */
static const CDS_FLASH char *text_of_delete(struct console *console)
{
    static const CDS_FLASH char words[] = "del|remove|rm|erase|clear";
    const struct command_line *line = &console->line;
    bool is_pose = parse_is_command(line, command_pose);
    struct token name;

    if (line->names != 1 || !(is_pose || parse_is_command(line, command_sequence)))
        return NULL;
    name = more_slips_name(console);
    if (!parse_choice(words, &name) || stored_may_read() ||
        stored_find(console, is_pose ? MOTION_STORE_POSE : MOTION_STORE_SEQUENCE, 0) !=
            MOTION_STORE_NONE)
        return NULL;
    return is_pose ? message_delete_pose : message_delete_sequence;
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

/* ---- numbers ---- */

/* `move 1 +10`, `turn 1 +10`, `move 1 90.`, `move 1 .5` */
static const CDS_FLASH char *text_of_notation(struct console *console)
{
    const struct token *word = &console->token;

    if (!more_slips_has_word(console) || console->line.argument != ARGUMENT_NUMBER)
        return NULL;
    console->printer.values[0].number = console->line.id;
    if (*word->text == '+')
        return parse_is_command(&console->line, command_move) && console->line.numbers == 1 &&
                       names_one_servo(&console->line)
                   ? message_plus_angle
                   : message_plus;
    return *word->text == '.' || word->text[word->length - 1] == '.' ? message_point : NULL;
}

/* `move 1 90.123456789` */
static const CDS_FLASH char *text_of_digits(struct console *console)
{
    const struct token *word = &console->token;
    struct number number;

    return more_slips_has_word(console) && console->line.argument == ARGUMENT_NUMBER &&
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

/* The value that switches the setting on or off; SETTING_NO_SWITCH: it has none. */
static uint16_t value_of_switch(uint8_t setting, bool is_on)
{
    const CDS_FLASH struct setting *row = &settings_table[setting];

    if (!is_on && setting == SETTINGS_AT_device_id)
        return CDS_BROADCAST_ID;
    if ((*row->unit != '-' && *row->unit != 'm') || (is_on && row->highest > 1))
        return SETTING_NO_SWITCH;
    return is_on;
}

/* `settings alarm_report on`, `settings device_id off` */
static const CDS_FLASH char *text_of_setting_switch(struct console *console)
{
    static const CDS_FLASH char words[] = "on|off";
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;
    uint8_t word = parse_choice(words, &console->token);
    uint16_t value;

    if (!more_slips_has_word(console) || !line->command || !explain_is_settings(line) ||
        line->numbers == 0 || line->names || !word)
        return NULL;
    value = value_of_switch(line->setting, word == 1);
    if (value == SETTING_NO_SWITCH)
        return NULL;
    values[0].number = values[3].number = value;
    values[1].text = setting_meaning(line->setting, value);
    values[2].text = settings_table[line->setting].name;
    return values[1].text ? message_setting_switch : NULL;
}

/* ---- refusals ---- */

/* `set 1 ID 5`, `set 1 BAUD_RATE 500000` */
static const CDS_FLASH char *text_of_id_or_rate(struct console *console)
{
    const struct command_line *line = &console->line;
    const struct number *number = line->number;
    union printer_value *values = console->printer.values;
    uint16_t raw;

    if (!parse_is_command(line, command_set_register) || !names_one_servo(line) || number->decimals)
        return NULL;
    values[0].number = line->id;
    values[1].number = (uint16_t)number->digits;
    if (line->address == CDS_REG_ID)
        return number->kind == NUMBER_BARE && number->digits >= 0 && number->digits <= CDS_ID_MAX
                   ? message_id_changes
                   : NULL;
    if (line->address != CDS_REG_BAUD_RATE || number_within(number, CDS_UNIT_BPS, &raw))
        return NULL;
    values[2].number = (uint16_t)((uint32_t)number->digits >> 16);
    values[3].text = number_unit_name(number);
    return message_rate_changes;
}

/* `pose 90 120` of three servos */
static const CDS_FLASH char *text_of_sizes(struct console *console)
{
    console->printer.values[0].number = console->line.values;
    console->printer.values[1].number = console->robot->group_count;
    return message_counts;
}

/* `write 1 GOAL_POSITION 100`: a value of the register, not an angle. `teach off 1`: the goal is
 * the position of the servo. */
static const CDS_FLASH char *text_of_goal(struct console *console)
{
    static const CDS_FLASH char teach[] = "teach";
    const struct command_line *line = &console->line;
    const struct cds_servo_state *servo = explain_limited(console);
    const uint8_t *bytes = line->request->packet.bytes;
    union printer_value *values = console->printer.values;
    bool is_of_teach = parse_is_command(line, teach);
    uint16_t goal;

    if (!servo || (line->command->instruction != CDS_WRITE && !is_of_teach) ||
        bytes[CDS_AT_PARAMETERS] != CDS_REG_GOAL_POSITION ||
        bytes[CDS_AT_LENGTH] < CDS_LENGTH_MIN + 3) // address, and both bytes
        return NULL;
    goal = register_raw_at(bytes + CDS_AT_PARAMETERS + 1, 2);
    if (goal > CDS_VALUE_MAX || (goal >= servo->lowest && goal <= servo->highest))
        return NULL;
    if (!is_of_teach)
        (values++)->number = goal;
    values[0].number = goal;
    values[1].number = servo->lowest;
    values[2].number = servo->highest;
    printer_set_id(&console->printer, servo->id);
    return is_of_teach ? message_stands_beyond : message_goal_beyond;
}

/* `torque 1 on` has read goal and speed: the goal is beyond the limits. */
static const CDS_FLASH char *text_of_torque_goal(struct console *console)
{
    static const CDS_FLASH char torque[] = "torque";
    const struct cds_servo_state *servo = console_servo(console);
    union printer_value *values = console->printer.values;

    if (!servo || !parse_is_command(&console->line, torque) || servo->held & CDS_HELD_GOAL ||
        cds_servo_is_endless(servo))
        return NULL;
    values[0].number = servo->lowest;
    values[1].number = servo->highest;
    printer_set_id(&console->printer, servo->id);
    return message_torque_beyond;
}

/* The goal of servo `index` of the group, as `pose` has taken it. A cycle takes it from the line;
 * else the packet is in the line's buffer, and the goals are in robot->work. False: not known. */
static bool goal_of_pose(const struct console *console, uint8_t index, struct cds_goal *goal)
{
    const struct robot *robot = console->robot;

    if (robot->cycle) {
        *goal = (struct cds_goal){.id = robot->group[index],
                                  .position = pose_angle(console, index),
                                  .speed = console->raw};
        return true;
    }
    *goal = robot->work.move.goals[index];
    return goal->id == robot->group[index];
}

/* `pose 90 10 90`: the first servo whose limits the line breaks. Of a timed move a line before
 * names it. */
static const CDS_FLASH char *text_of_pose_goal(struct console *console)
{
    const struct command_line *line = &console->line;
    const struct robot *robot = console->robot;
    union printer_value *values = console->printer.values;
    struct cds_goal goal;

    if (!parse_is_command(line, command_pose))
        return NULL;
    if (line->names || line->choice == POSE_IN)
        return message_not_within;
    for (uint8_t i = 0; i < robot->group_count && goal_of_pose(console, i, &goal); i++) {
        const struct cds_servo_state *servo = cds_servos_find(&console->robot->servos, goal.id);

        if (!servo || !servo->has_limits)
            continue;
        values[0].number = goal.id;
        values[1].number = goal.position;
        values[2].number = servo->lowest;
        values[3].number = servo->highest;
        if (goal.position < servo->lowest || goal.position > servo->highest)
            return message_pose_angle;
        values[1].number = values[2].number = servo->fastest;
        if (servo->fastest < CDS_VALUE_MAX && (goal.speed == 0 || goal.speed > servo->fastest))
            return servo->fastest ? message_pose_speed : message_not_within;
    }
    return message_not_within;
}

/* `set 1 0x1F 0`, `get 1 0x1F` */
static const CDS_FLASH char *text_of_second_byte(struct console *console)
{
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;
    struct cds_register at;

    if (line->error || !cds_register_at(line->address, &at))
        return NULL;
    values[0].number = line->address;
    values[1].number = values[2].number = at.address;
    return message_second_byte;
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

/* `write 1 0x30 100 1 2` */
static const CDS_FLASH char *text_of_end_of_table(struct console *console)
{
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;

    if (line->error != ERROR_COUNT || line->argument != ARGUMENT_VALUES ||
        line->next < CDS_TABLE_SIZE)
        return NULL;
    values[0].number = line->address;
    values[1].number = CDS_TABLE_SIZE - 1;
    values[2].number = line->values;
    return message_behind_table;
}

/* `reset 2`, `factory 2`: the permit lets no servo get the ID of another one of the list. */
static const CDS_FLASH char *text_of_factory_id(struct console *console)
{
    static const CDS_FLASH char reset[] = "reset", factory[] = "factory";
    const struct command_line *line = &console->line;
    bool is_refused = parse_is_command(line, reset) ||
                      (console->error == CDS_LIMIT && parse_is_command(line, factory));

    return is_refused && line->id != CONSOLE_FACTORY_ID &&
                   cds_servos_find(&console->robot->servos, CONSOLE_FACTORY_ID)
               ? message_id_1_listed
               : NULL;
}

/* `sequence walk add low 1s pass dwell 1s`: `dwell` after `pass`, or `pass` after `dwell TIME`. */
static const CDS_FLASH char *text_of_dwell_and_pass(struct console *console)
{
    static const CDS_FLASH char words[] = "dwell|pass";
    const struct command_line *line = &console->line;

    return more_slips_has_word(console) && parse_is_command(line, command_sequence) &&
                   parse_choice(words, &console->token) && line->words == STEP_WORDS + line->numbers
               ? message_dwell_and_pass
               : NULL;
}

static const CDS_FLASH struct slip more[] = {
    {ERROR_UNKNOWN_COMMAND, text_of_semicolon},
    {ERROR_UNKNOWN_COMMAND, text_of_error_help},
    {ERROR_UNKNOWN_COMMAND, text_of_other_word},
    {ERROR_UNKNOWN_WORD, text_of_semicolon},
    {ERROR_UNKNOWN_WORD, text_of_other_word},
    {ERROR_UNKNOWN_WORD, text_of_time_without_in},
    {ERROR_UNKNOWN_WORD, text_of_bare_play},
    {ERROR_UNKNOWN_WORD, text_of_delete},
    {ERROR_UNKNOWN_WORD, text_of_servo_number},
    {ERROR_NOT_A_NUMBER, text_of_semicolon},
    {ERROR_NOT_A_NUMBER, text_of_other_word},
    {ERROR_NOT_A_NUMBER, text_of_notation},
    {ERROR_NOT_A_NUMBER, text_of_setting_switch},
    {ERROR_NOT_WRITABLE, text_of_id_or_rate},
    {ERROR_GROUP_SIZE, text_of_sizes},
    {ERROR_UNIT, text_of_semicolon},
    {ERROR_OUT_OF_RANGE, text_of_digits},
    {ERROR_OUT_OF_RANGE, text_of_angle_each},
    {ERROR_COUNT, text_of_dwell_and_pass},
    {ERROR_COUNT, text_of_angle_each},
    {ERROR_COUNT, text_of_other_word},
    {ERROR_COUNT, text_of_end_of_table},
    {ERROR_PLACE_TAKEN, text_of_factory_id},
    {CDS_LIMIT, text_of_factory_id},
    {CDS_LIMIT, text_of_goal},
    {CDS_LIMIT, text_of_torque_goal},
    {CDS_LIMIT, text_of_pose_goal},
    {ERROR_UNKNOWN_REGISTER, text_of_second_byte},
    {ERROR_SERVO_ANGLE, text_of_own_limits},
    {ERROR_SERVO_RANGE, text_of_lock},
};

const CDS_FLASH char *more_slips(struct console *console)
{
    const CDS_FLASH char *message = slip_first_text(more, sizeof more / sizeof more[0], console);

    if (message == NULL)
        message = slip_text(console);
    return message ? message : misplaced_text(console);
}
