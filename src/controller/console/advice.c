/* SPDX-License-Identifier: MIT */
/* Errors whose remedy depends on the line or on the servo; see advice.h. */
#include "console/advice.h"

#include <stddef.h> // NULL

#include "cds55xx/packet.h"          // CDS_PING
#include "console/commands/shared.h" // servo_is_at_other_rate()
#include "console/console.h"
#include "console/errors.h"
#include "console/explain.h"
#include "console/messages.h"
#include "console/slips.h"
#include "console/unasked.h"    // unasked_noise_bytes()
#include "console/unit_names.h" // unit_shown
#include "robot/settings.h"     // settings_table

static const CDS_FLASH char message_units[] = "wrong unit; units: %s%s";
static const CDS_FLASH char message_takes_no_unit[] = "wrong unit; this number has no unit";
static const CDS_FLASH char message_number[] = "not a number; write %s";
static const CDS_FLASH char message_value[] = "not a number; write a number from %u to %u";
static const CDS_FLASH char message_switch_value[] = "not a number; write 1 for on, 0 for off";
static const CDS_FLASH char message_setting[] =
    "a setting of the controller, not a servo; 'settings SETTING VALUE' sets it";
static const CDS_FLASH char message_all_forms[] = "; 'help " COMMAND_NAME "' has all forms of it";
static const CDS_FLASH char message_twice[] = "an ID is given twice; usage: %s";
static const CDS_FLASH char message_is_not_gone[] =
    "it stays in the list, as it is not offline; unplug it first";
static const CDS_FLASH char message_is_inhibited[] =
    "it stays in the list, as it is inhibited; 'release %u' first";
static const CDS_FLASH char message_is_at_rate[] =
    "it stays in the list, where its rate is %b; 'bus %b', then this line again";
static const CDS_FLASH char message_force[] =
    "nothing was reset; each of them would get ID 1: 'factory %u' resets one, 'factory 254 force' "
    "all on the bus";
static const CDS_FLASH char message_ids[] = "IDs: 1, 1-3, 1,4 or all";
static const CDS_FLASH char message_one_id[] = "an ID: 0 to 253";
static const CDS_FLASH char message_space[] = "no space before a unit: 90deg, 500ms";
static const CDS_FLASH char message_raw_too[] = ", raw";
static const CDS_FLASH char message_of_move[] =
    "time out of range: 1ms to 600s; a number without unit is ms";
static const CDS_FLASH char message_of_step[] =
    "time out of range: 10ms to 600s, dwell 0 to 65.53s; a number without unit is ms";
static const CDS_FLASH char message_step_range[] = "N %l is out of range: 1 to %u%s";
static const CDS_FLASH char message_only_step[] =
    "step 1 is the only one; 'sequence delete NAME' deletes the sequence";
static const CDS_FLASH char message_add_appends[] =
    "; 'sequence NAME add' appends a step behind the last one";
const CDS_FLASH char advice_pose_gone[] =
    "a step names a deleted pose; 'sequence NAME show' numbers the steps, 'sequence NAME set N "
    "POSE TIME' mends step N";
static const CDS_FLASH char message_swapped[] =
    "above HIGH, %a; write the smaller angle first: limits ID LOW HIGH";
static const CDS_FLASH char message_beyond_angle[] =
    "nothing was written: %s_ANGLE_LIMIT is %a, and %s_ANGLE_LIMIT may not be %s it";
static const CDS_FLASH char message_beyond_voltage[] =
    "nothing was written: %s_VOLTAGE is %v, and %s_VOLTAGE may not be %s it";
static const CDS_FLASH char *const CDS_FLASH names_of_pairs[] = {
    FLASH_TEXT("CCW"), FLASH_TEXT("CW"), FLASH_TEXT("MAX"), FLASH_TEXT("MIN")};
static const CDS_FLASH char message_several[] =
    "several servos answer at the same time, so their replies mix; 'scan' asks each";
static const CDS_FLASH char message_late[] =
    "%s; replies that came late so far: %u, see 'diagnose %u'";
static const CDS_FLASH char message_stray[] =
    "%s; bytes without a packet so far, of noise or echoes: %u, see 'diagnose %u'";
static const CDS_FLASH char message_stray_now[] =
    "%s; bytes without a packet came meanwhile, of noise or echoes: %u, see 'diagnose %u'";
static const CDS_FLASH char message_damaged_there[] =
    "damaged bytes came from ID %u at %b, so it may be taken, or there is noise; nothing was "
    "written: 'diagnose %u'";
static const CDS_FLASH char message_factory_id[] =
    "another servo has ID 1, nothing was written; 'id 1 NEW' first, or connect this one alone";
static const CDS_FLASH char message_search_rates[] = "%s; 'scan all' looks at other rates";
static const CDS_FLASH char message_one[] =
    "254 means all servos; this command takes an ID from 0 to 253%s";
static const CDS_FLASH char message_or_each[] = ", or 'all': each in turn";
static const CDS_FLASH char message_state_lost[] =
    "the servo may not be driven; %s, 'release %u', then 'torque %u on' moves it to its goal, "
    "'teach off %u' keeps it where it is";
static const CDS_FLASH char message_state_lost_unknown[] =
    "the servo may not be driven; %s, 'release %u'";
static const CDS_FLASH char message_state_cause[] =
    "it lost its state by power, plug or an alarm: mend that";
static const CDS_FLASH char message_supply_cause[] =
    "its input voltage is an alarm: mend the supply, 'clear'";
static const CDS_FLASH char message_would_turn[] =
    "with both limits 0 it would turn at once, without end: 'torque %u off' first; 'turn %u SPEED' "
    "sets limits and speed";
static const CDS_FLASH char message_speed_0[] =
    "its speed is 0, as fast as it can, and its limit is %r: 'set %u MOVING_SPEED %r' first";
static const CDS_FLASH char message_speed_unread[] =
    "its speed is not known to be within its limit, %r: 'set %u MOVING_SPEED %r', then "
    "'info %u' reads it";
static const CDS_FLASH char message_no_turn[] =
    "its limits are %a to %a: 'limits %u 0 300' first, since an endless turn would leave them";
static const CDS_FLASH char message_goal_unread[] =
    "its goal is not known to be within its limits, %a to %a: 'info %u' reads it; 'teach off %u' "
    "makes its position the goal";
static const CDS_FLASH char message_goal_due[] =
    "it would leave the endless turn for its goal, not read yet or beyond its limits, %a to %a: "
    "'set %u GOAL_POSITION ANGLE', 'get %u GOAL_POSITION' reads it, then send this line again";
static const CDS_FLASH char message_list_full[] =
    "the list of servos is full: 'servos forget', then this line again";
static const CDS_FLASH char message_mode[] = "the mode is %s; usage: %s";
static const CDS_FLASH char *const CDS_FLASH modes[] = {
    [SETTINGS_ECHO_OFF] = FLASH_TEXT("program"),
    [SETTINGS_ECHO_ON] = FLASH_TEXT("echo"),
    [SETTINGS_ECHO_PERSON] = FLASH_TEXT("person"),
};
static const CDS_FLASH char message_mute[] =
    "no reply is awaited: its STATUS_RETURN_LEVEL was set to 0, or its replies to READ were lost; "
    "'set %u STATUS_RETURN_LEVEL 2' lets it answer";
static const CDS_FLASH char message_save_stopped[] =
    "stopped: driving is inhibited until 'release'; the %s";
static const CDS_FLASH char message_save_goes_on[] = "save goes on, 'settings' tells how it ends";
static const CDS_FLASH char message_save_done[] = "settings are saved all the same";
static const CDS_FLASH char message_save_failed_too[] = "settings are not saved: 'save' again";
static const CDS_FLASH char message_release_all[] =
    "stopped: driving is inhibited; remove the cause, 'release' without an ID";
static const CDS_FLASH char message_loss[] =
    "the host link was lost; no byte for link_loss_ms: %s; %s%s";
static const CDS_FLASH char message_loss_shown[] = "driving goes on, as link_loss_action is 0";
static const CDS_FLASH char message_loss_inhibits[] = "driving is inhibited, torque stays as it is";
static const CDS_FLASH char message_loss_stops[] = "torque off, driving is inhibited";
static const CDS_FLASH char message_clear_if_back[] = "'clear' when it is back";
static const CDS_FLASH char message_clear_to_type[] =
    "to work by hand: 'settings link_loss_ms 0', 'clear'";
static const CDS_FLASH char message_torque_again[] =
    ", then 'torque all on' moves to the last goals, 'teach off all' does not";

/* ---- units ---- */

/* By enum number_kind; NULL: no unit. */
static const CDS_FLASH char *const CDS_FLASH units_of_kind[] = {
    [NUMBER_BARE] = NULL,
    [NUMBER_RAW] = NULL,
    [NUMBER_ANGLE] = FLASH_TEXT("deg, mdeg"),
    [NUMBER_SPEED] = FLASH_TEXT("rpm, mrpm"),
    [NUMBER_VOLTAGE] = FLASH_TEXT("V, mV"),
    [NUMBER_SHARE] = FLASH_TEXT("%"),
    [NUMBER_TEMPERATURE] = FLASH_TEXT("C"),
    [NUMBER_TIME] = FLASH_TEXT("s, ms, us"),
    [NUMBER_RATE] = FLASH_TEXT("bps, kbps, Mbps"),
};

/* The kind of a setting, by the first letter of its unit in settings_table: enum number_kind. */
static uint8_t kind_of_setting(char unit)
{
    switch (unit) {
    case 'm':
    case 'u':
    case 'x': return NUMBER_TIME;
    case 'r': return NUMBER_RATE;
    default: return NUMBER_BARE;
    }
}

/* enum number_kind of an argument with this unit: enum cds_unit or UNIT_MS and so on (explain.h).
 */
static uint8_t kind_of_unit(uint8_t unit)
{
    if (unit < UNIT_ADDRESS)
        return unit_shown[unit].kind;
    return unit == UNIT_PERCENT ? NUMBER_SHARE : NUMBER_TIME;
}

/* What to write in place of a unit that the argument does not take. */
static const CDS_FLASH char *text_of_units(struct console *console)
{
    const struct command_line *line = &console->line;
    union printer_value *values = console->printer.values;
    uint8_t unit = CDS_UNIT_NUMBER, kind;

    values[1].text = message_nothing;
    if (line->command && explain_is_settings(line) && line->numbers && line->error == 0) {
        kind = kind_of_setting(*settings_table[line->setting].unit);
    } else {
        if (!explain_unit(console, &unit))
            return NULL;
        kind = kind_of_unit(unit);
        if (unit < UNIT_ADDRESS)
            values[1].text = message_raw_too;
    }
    values[0].text = units_of_kind[kind];
    return values[0].text ? message_units : message_takes_no_unit;
}

/* What the argument may be, by enum number_kind. */
static const CDS_FLASH char *const CDS_FLASH examples_of_kind[] = {
    [NUMBER_BARE] = FLASH_TEXT("a whole number: 12 or 0x1F"),
    [NUMBER_RAW] = message_nothing,
    [NUMBER_ANGLE] = FLASH_TEXT("an angle: 90, 90.5deg or 512raw"),
    [NUMBER_SPEED] = FLASH_TEXT("a speed: 30, 30.5rpm or 512raw"),
    [NUMBER_VOLTAGE] = FLASH_TEXT("a voltage: 6.5 or 6.5V"),
    [NUMBER_SHARE] = FLASH_TEXT("a share: 50 or 50%"),
    [NUMBER_TEMPERATURE] = FLASH_TEXT("a temperature: 70 or 70C"),
    [NUMBER_TIME] = FLASH_TEXT("a time: 500ms or 1.5s"),
    [NUMBER_RATE] = FLASH_TEXT("a rate: 57600 or 1Mbps"),
};

static const CDS_FLASH char example_of_seconds[] = "whole seconds: 5s";

/* What to write in place of a word that is no number of a setting. */
static const CDS_FLASH char *text_of_setting(struct console *console)
{
    const CDS_FLASH struct setting *row = &settings_table[console->line.setting];
    union printer_value *values = console->printer.values;
    uint8_t kind = kind_of_setting(*row->unit);

    if (command_set.has_room && row->highest == 1)
        return message_switch_value;
    if (kind == NUMBER_BARE) {
        values[0].number = row->lowest;
        values[1].number = row->highest;
        return message_value;
    }
    values[0].text = examples_of_kind[kind];
    return message_number;
}

/* True if the word that is no ID is the name of a setting. */
static bool is_name_of_setting(const struct console *console)
{
    const struct token *word = &console->token;

    return console->line.argument == ARGUMENT_ID &&
           settings_named(word->text, word->length) < SETTINGS_COUNT;
}

/* What to write in place of a word that is no number. */
static const CDS_FLASH char *text_of_number(struct console *console)
{
    const struct command_line *line = &console->line;
    const CDS_FLASH char **text = &console->printer.values[0].text;
    uint8_t unit = CDS_UNIT_NUMBER;

    if (line->error != ERROR_NOT_A_NUMBER)
        return NULL; // the number has too many decimals
    if (is_name_of_setting(console))
        return message_setting;
    if (line->argument == ARGUMENT_IDS || (line->list_is_open && line->is_repeated)) {
        *text = message_ids;
    } else if (line->argument == ARGUMENT_ID || line->argument == ARGUMENT_ID_OR_ALL ||
               line->argument == ARGUMENT_NEW_ID) {
        *text = message_one_id;
    } else if (!explain_unit(console, &unit)) {
        return NULL;
    } else if (line->command && explain_is_settings(line) &&
               !(command_set.has_room && line->names)) {
        return text_of_setting(console);
    } else if (command_set.has_room && unit == UNIT_S) { // DELAY of the autostart
        *text = example_of_seconds;
    } else {
        *text = examples_of_kind[kind_of_unit(unit)];
    }
    return message_number;
}

/* The word of the line that is wrong is a unit: "90 deg". */
static const CDS_FLASH char *unit_behind_space(const struct console *console)
{
    const struct token *word = &console->token;
    struct token joined = {0};
    struct number number;

    if (console->line.error != console->error || word->length >= TOKEN_MAX ||
        number_parse(word, &number) == 0)
        return NULL;
    token_add(&joined, '1');
    for (uint8_t i = 0; i < word->length; i++)
        token_add(&joined, word->text[i]);
    return number_parse(&joined, &number) == 0 && number.kind != NUMBER_BARE ? message_space : NULL;
}

/* ---- words ---- */

static bool ends_word(char c)
{
    return c == '\0' || c == ' ' || c == ']';
}

static bool is_capital(char c)
{
    return c >= 'A' && c <= 'Z';
}

/* The place of `usage` behind the text from `begin` to `end`, if it begins with this text and has a
 * small word there; else NULL. */
static const CDS_FLASH char *word_behind(const CDS_FLASH char *usage, const CDS_FLASH char *begin,
                                         const CDS_FLASH char *end)
{
    for (; begin < end; begin++, usage++)
        if (*usage != *begin)
            return NULL;
    while (*usage == '[')
        usage++;
    return *usage && !is_capital(*usage) ? usage : NULL;
}

static bool is_same_word(const CDS_FLASH char *one, const CDS_FLASH char *other)
{
    for (; *one == *other && !ends_word(*one); one++)
        other++;
    return ends_word(*one) && ends_word(*other);
}

/* "as plot": the small words at `word`, up to an argument. */
static void print_words(struct printer *printer, const CDS_FLASH char *word)
{
    for (;; word++) {
        for (; !ends_word(*word); word++)
            printer_char(printer, *word);
        if (*word != ' ' || word[1] == '[' || is_capital(word[1]))
            return;
        printer_char(printer, ' ');
    }
}

/* Prints each word once: rows with the same word are neighbours in the table. */
void advice_words(struct console *console)
{
    const CDS_FLASH char *begin = console->line.command->usage, *end = console->line.usage;
    const CDS_FLASH struct command_group *const CDS_FLASH *group = command_set.groups;
    const CDS_FLASH char *told = NULL;

    while (end[-1] == '[')
        end--;
    for (; *group; group++) {
        const CDS_FLASH struct command *row = (*group)->rows;

        for (uint8_t left = (*group)->count; left; left--, row++) {
            const CDS_FLASH char *word = word_behind(row->usage, begin, end);

            if (!word || (told && is_same_word(word, told)))
                continue;
            if (told)
                printer_char(&console->printer, '|');
            print_words(&console->printer, word);
            told = word;
        }
    }
}

/* ---- other errors ---- */

static const CDS_FLASH char name_of_sequence[] = "sequence";

/* True if another row of the table begins with the same word as the command of the line. */
static bool has_other_forms(const struct command_line *line)
{
    const CDS_FLASH struct command_group *const CDS_FLASH *group = command_set.groups;

    for (; *group; group++)
        for (uint8_t i = 0; i < (*group)->count; i++)
            if ((*group)->rows + i != line->command &&
                is_same_word((*group)->rows[i].usage, line->command->usage))
                return true;
    return false;
}

/* The time of a move, or of a step of a sequence, is out of range. */
static const CDS_FLASH char *text_of_times(const struct console *console)
{
    return parse_is_command(&console->line, name_of_sequence) ? message_of_step : message_of_move;
}

/* `limits` with LOW above HIGH: both are angles, so the range of LOW explains nothing. */
static const CDS_FLASH char *text_of_order(struct console *console)
{
    static const CDS_FLASH char limits[] = "limits";
    const struct command_line *line = &console->line;
    uint16_t low, high;

    if (line->error || !parse_is_command(line, limits) ||
        number_within(&line->number[0], CDS_UNIT_MDEG, &low) ||
        number_within(&line->number[1], CDS_UNIT_MDEG, &high))
        return NULL;
    console->printer.values[0].number = high;
    return low > high ? message_swapped : NULL;
}

/* Count of the servos that answer a PING to ID 254, as far as is known. */
static uint8_t count_of_online(const struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;
    uint8_t count = 0;

    for (uint8_t i = 0; i < servos->count; i++)
        count = (uint8_t)(count + (servos->states[i].presence == CDS_PRESENCE_ONLINE &&
                                   !servo_is_at_other_rate(console, &servos->states[i])));
    return count;
}

/* A PING to ID 254 that several servos answer. */
static const CDS_FLASH char *text_of_scan(const struct console *console)
{
    const struct command_line *line = &console->line;

    return line->command && line->command->instruction == CDS_PING &&
                   line->id == CDS_BROADCAST_ID && count_of_online(console) > 1
               ? message_several
               : NULL;
}

/* With room: noise bytes since this command began. Else: since the reset, less those of scan and
 * diagnose. */
static uint16_t stray_bytes(const struct console *console)
{
    struct cds_stats stats;

    if (command_set.unasked)
        return unasked_noise_bytes(command_set.unasked, console);

    cds_bus_stats(console->bus, &stats);
    return (uint16_t)(stats.noise_bytes - command_set.account->searched.noise_bytes);
}

/* True if most replies that a servo did not give in time came late, or as many as are counted. */
static bool is_slow(const struct cds_servo_counters *counters)
{
    return counters->stale_replies == UINT8_MAX ||
           2u * counters->stale_replies > counters->timeouts;
}

/* No reply by the deadline. Appends how many late replies came since the servo is known, or bytes
 * without a packet, as of an echo. Late replies may date from before the servo was unplugged. */
static const CDS_FLASH char *text_of_late(struct console *console)
{
    const struct cds_servo_state *servo = console_servo(console);
    union printer_value *values = console->printer.values;

    values[0].text = error_text(CDS_TIMEOUT);
    if (!servo)
        return console->line.id <= CDS_ID_MAX && !console->line.is_repeated ? message_search_rates
                                                                            : text_of_scan(console);
    values[1].number = servo->counters.stale_replies;
    values[2].number = servo->id;
    if (is_slow(&servo->counters))
        return message_late;
    values[1].number = stray_bytes(console);
    if (!values[1].number)
        return text_of_scan(console);
    return command_set.unasked ? message_stray_now : message_stray;
}

/* The new ID or rate is not free, but no good reply came from there. */
static const CDS_FLASH char *text_of_place(struct console *console)
{
    static const CDS_FLASH char factory[] = "factory";
    const struct cds_identity *identity = &console->robot->work.identity;
    union printer_value *values = console->printer.values;

    if (console->line.command->instruction)
        return NULL; // `reset`, `write`: refused by the permit, so no servo was asked
    if (identity->at_to != CDS_CORRUPT)
        return parse_is_command(&console->line, factory) ? message_factory_id : NULL;
    values[0].number = values[2].number = identity->to.id;
    values[1].number = identity->to.baud_reg;
    return message_damaged_there;
}

/* ID 254 for a command that needs a reply. */
static const CDS_FLASH char *text_of_one_id(struct console *console)
{
    const struct command_line *line = &console->line;
    uint16_t id;

    if (line->error != ERROR_OUT_OF_RANGE || number_whole(&console->token, UINT8_MAX, &id) ||
        id != CDS_BROADCAST_ID || (line->argument != ARGUMENT_ID && line->argument != ARGUMENT_IDS))
        return NULL;
    console->printer.values[0].text = line->is_repeated ? message_or_each : message_nothing;
    return message_one;
}

/* ERROR_OUT_OF_RANGE of `sequence NAME set|insert|delete N`: the sequence has console->part steps,
 * and no step N. If it has this step, it is the only one, and `delete` was refused. */
static const CDS_FLASH char *text_of_step(struct console *console)
{
    union printer_value *values = console->printer.values;

    if (command_set.motion_words == NULL || console->line.error ||
        !parse_is_command(&console->line, name_of_sequence))
        return NULL;
    if (console->raw && console->raw <= console->part)
        return message_only_step;
    values[0].number = (uint16_t)console->line.number[0].digits;
    values[1].number = (uint16_t)((uint32_t)console->line.number[0].digits >> 16);
    values[2].number = console->part;
    values[3].text =
        console->raw == console->part + 1u && console->line.numbers > 1 // `delete` has one number
            ? message_add_appends
            : message_nothing;
    return message_step_range;
}

/* `set` of a limit that contradicts the other one (register.c). */
static const CDS_FLASH char *text_of_pair(struct console *console)
{
    static const CDS_FLASH char set[] = "set", message_below[] = "below", message_above[] = "above";
    union printer_value *values = console->printer.values;
    uint8_t bound; // index in names_of_pairs

    if (console->line.error || !parse_is_command(&console->line, set))
        return NULL;
    switch (set_job(console)->bound_at) {
    case CDS_REG_CCW_ANGLE_LIMIT: bound = 0; break;
    case CDS_REG_CW_ANGLE_LIMIT: bound = 1; break;
    case CDS_REG_MAX_VOLTAGE: bound = 2; break;
    case CDS_REG_MIN_VOLTAGE: bound = 3; break;
    default: return NULL;
    }
    values[0].text = names_of_pairs[bound];
    values[1].number = set_job(console)->bound;
    values[2].text = names_of_pairs[bound ^ 1];
    values[3].text = bound & 1 ? message_below : message_above;
    return bound < 2 ? message_beyond_angle : message_beyond_voltage;
}

static const CDS_FLASH char *text_of_value(struct console *console)
{
    const CDS_FLASH char *message = text_of_one_id(console);

    if (message == NULL)
        message = text_of_pair(console);
    if (message == NULL)
        message = text_of_step(console);
    return message ? message : text_of_order(console);
}

/* The servo alone is inhibited, and is there. */
static const CDS_FLASH char *text_of_release(struct console *console)
{
    uint8_t id = explain_servo(console);
    const struct cds_servo_state *servo = cds_servos_find(&console->robot->servos, id);

    if (!servo || servo->presence == CDS_PRESENCE_OFFLINE ||
        !(servo->inhibits & CDS_INHIBIT_STATE_LOST))
        return NULL;
    console->printer.values[0].text =
        servo->alarms & CDS_ERROR_VOLTAGE ? message_supply_cause : message_state_cause;
    for (uint8_t i = 1; i < 4; i++)
        console->printer.values[i].number = id;
    if (command_set.unasked &&
        unasked_mode(command_set.unasked, (uint8_t)(servo - console->robot->states)) !=
            UNASKED_POSITION)
        return message_state_lost_unknown; // in endless turn it has no goal: names only 'release'
    return message_state_lost;
}

const CDS_FLASH char *advice_link_lost(struct console *console)
{
    const struct robot *robot = console->robot;
    union printer_value *values = console->printer.values;
    bool is_stop = robot_is_inhibited(robot) && (robot_is_stopping(robot) || robot->stop_begun);

    values[0].text = !robot_is_inhibited(robot) ? message_loss_shown
                     : is_stop                  ? message_loss_stops
                                                : message_loss_inhibits;
    values[1].text = console_is_for_person(console) && console->failsafe->settings->link_loss_ms
                         ? message_clear_to_type
                         : message_clear_if_back;
    values[2].text = is_stop ? message_torque_again : message_nothing;
    return message_loss;
}

/* A limit of 0 that would begin an endless turn. */
static const CDS_FLASH char *text_of_turn(struct console *console)
{
    static const CDS_FLASH char set[] = "set";
    const uint8_t *data = set_job(console)->data;

    if (!parse_is_command(&console->line, set) || (data[0] | data[1]))
        return NULL;
    console->printer.values[0].number = console->printer.values[1].number = console->line.id;
    return message_would_turn;
}

#define AT_FIRST_VALUE   (CDS_AT_PARAMETERS + 1) // behind the address of a WRITE
#define LIMITS_END       (CDS_REG_CCW_ANGLE_LIMIT + 2)
#define LENGTH_OF_VALUES (CDS_LENGTH_MIN + 1) // LENGTH of a WRITE without values

/* True if the packet writes 0 to each byte of the angle limits that it writes. */
static bool writes_zeros(const uint8_t *bytes)
{
    const uint8_t *value = &bytes[AT_FIRST_VALUE];
    uint8_t address = bytes[CDS_AT_PARAMETERS];

    for (uint8_t left = bytes[CDS_AT_LENGTH]; left > LENGTH_OF_VALUES && address < LIMITS_END;
         left--, address++)
        if (*value++)
            return false;
    return true;
}

/* Why the limits of the servo refuse what the line writes. With torque on, or out of an endless
 * turn, a servo goes to its goal: MOVING_SPEED is 0, as fast as it can; or goal or speed are not
 * known to be within the limits. `torque on`, `turn` and angle limits of 0: an endless turn would
 * leave the limits. A new ID has no place in a full list. NULL for other registers. */
static const CDS_FLASH char *text_of_limits(struct console *console)
{
    const struct cds_servo_state *servo = explain_limited(console);
    union printer_value *values = console->printer.values;
    const uint8_t *bytes = console->line.request->packet.bytes;
    uint8_t written = bytes[CDS_AT_PARAMETERS];
    bool is_torque = written == CDS_REG_TORQUE_ENABLE;
    bool is_mode = written == CDS_REG_CW_ANGLE_LIMIT || written == CDS_REG_CCW_ANGLE_LIMIT;
    bool is_turn;

    if (console->line.new_id <= CDS_ID_MAX && console->robot->servos.count == ROBOT_SERVOS)
        return message_list_full; // the new ID needs an entry, too (cds_servos_may_become())
    if (!(is_torque || is_mode) || !servo ||
        (command_set.has_room && console->line.command->instruction == CDS_SYNC_WRITE))
        return NULL; // of a SYNC WRITE the values of the servo are not looked for
    is_turn = (servo->lowest || servo->highest < CDS_VALUE_MAX) &&
              (is_mode ? writes_zeros(bytes) : cds_servo_is_endless(servo));
    values[0].number = values[2].number = servo->fastest;
    values[1].number = values[3].number = servo->id;
    if (!is_turn && servo->fastest < CDS_VALUE_MAX && servo->held & CDS_HELD_GOAL) {
        if (!(servo->held & CDS_HELD_SPEED))
            return message_speed_unread;
        if (servo->held & CDS_HELD_SPEED_0)
            return message_speed_0;
    }
    values[0].number = servo->lowest;
    values[1].number = servo->highest;
    values[2].number = values[3].number = servo->id;
    if (is_turn)
        return message_no_turn;
    return is_torque ? message_goal_unread : message_goal_due;
}

/* `torque 1 1`: an ID stands where one of the words behind the list is due. */
static const CDS_FLASH char *text_of_twice(struct console *console)
{
    char due = *console->line.usage;

    if (!console->line.is_repeated || due == '[' || ends_word(due) || is_capital(due))
        return NULL;
    console->printer.values[0].text = console->line.command->usage;
    return message_twice;
}

/* `servos forget ID` of a servo that is not gone (servos_forget.c). */
static const CDS_FLASH char *text_of_forget(struct console *console)
{
    static const CDS_FLASH char servos[] = "servos";
    const struct cds_servo_state *servo = console_servo(console);

    if (!servo || !parse_is_command(&console->line, servos))
        return NULL;
    if (command_set.has_room && servo_is_at_other_rate(console, servo)) {
        console->printer.values[0].number = console->printer.values[1].number = servo->baud_reg;
        return message_is_at_rate;
    }
    console->printer.values[0].number = servo->id;
    return servo->presence == CDS_PRESENCE_OFFLINE && servo->inhibits ? message_is_inhibited
                                                                      : message_is_not_gone;
}

/* `factory all`: each servo of the list would get ID 1. */
static const CDS_FLASH char *text_of_force(struct console *console)
{
    if (!command_set.has_room || console->line.id == CDS_BROADCAST_ID)
        return NULL;
    console->printer.values[0].number = console->line.id;
    return message_force;
}

/* `mode` without a word: the present mode. */
static const CDS_FLASH char *text_of_mode(struct console *console)
{
    union printer_value *values = console->printer.values;

    values[0].text = modes[console->failsafe->settings->echo];
    values[1].text = console->line.command->usage;
    return message_mode;
}

/* The servo reports only its input voltage: load and heat are no cause. */
static const CDS_FLASH char *text_of_supply(const struct console *console)
{
    const struct cds_servo_state *servo = console_servo(console);

    return servo && servo->alarms == CDS_ERROR_VOLTAGE ? error_text(ERROR_VOLTAGE) : NULL;
}

/* The servo is taken for one of status return level 0. The servo of a list or of a stop: the first
 * one of this level. */
static const CDS_FLASH char *text_of_mute(struct console *console)
{
    const struct cds_servo_state *servo = console_servo(console);
    const struct cds_servos *servos = &console->robot->servos;

    for (uint8_t i = 0; !servo && i < servos->count; i++)
        if (servos->states[i].torque_off == CDS_TORQUE_OFF_MUTE)
            servo = &servos->states[i];
    if (!servo || servo->status_return_level != 0)
        return NULL;
    console->printer.values[0].number = servo->id;
    return message_mute;
}

/* A stop ends the wait for a save, not the save. `release` with an ID does not end a stop. */
static const CDS_FLASH char *text_of_stopped(struct console *console)
{
    static const CDS_FLASH char save[] = "save";
    const CDS_FLASH char **outcome = &console->printer.values[0].text;

    if (command_set.has_room && parse_is_command(&console->line, message_release))
        return message_release_all;
    if (!parse_is_command(&console->line, save))
        return NULL;
    switch (console->failsafe->store->result) {
    case SETTINGS_SAVING: *outcome = message_save_goes_on; break;
    case SETTINGS_SAVED: *outcome = message_save_done; break;
    default: *outcome = message_save_failed_too; break;
    }
    return message_save_stopped;
}

static const CDS_FLASH char *text_of_count(struct console *console)
{
    static const CDS_FLASH char mode[] = "mode";
    const struct command_line *line = &console->line;
    const CDS_FLASH char *message =
        parse_is_command(line, mode) ? text_of_mode(console) : unit_behind_space(console);

    if (message || line->command == NULL || (line->is_repeated && line->numbers > 1) ||
        !has_other_forms(line))
        return message;
    console->printer.values[0].text = line->command->usage;
    console->printer.values[1].text = message_all_forms;
    return message_usage_due;
}

const CDS_FLASH char *advice(struct console *console)
{
    const CDS_FLASH char *message;

    if (command_set.motion_words) {
        message = command_set.motion_words->advise(console);
        if (message)
            return message;
    }
    message = command_set.more_slips ? command_set.more_slips(console) : NULL;
    if (message == NULL)
        message = slip_text(console);
    if (message)
        return message;
    switch (console->error) {
    case ERROR_TWICE: return text_of_twice(console);
    case ERROR_NOT_NEW: return text_of_forget(console);
    case ERROR_FORCE: return text_of_force(console);
    case ERROR_UNIT: return text_of_units(console);
    case ERROR_COUNT: return text_of_count(console);
    case ERROR_UNKNOWN_WORD: return unit_behind_space(console);
    case ERROR_NOT_A_NUMBER:
        message = unit_behind_space(console);
        return message ? message : text_of_number(console);
    case ERROR_TIME: return text_of_times(console);
    case ERROR_OUT_OF_RANGE: return text_of_value(console);
    case ERROR_PLACE_TAKEN: return text_of_place(console);
    case ERROR_POSE_GONE: return command_set.motion_words ? advice_pose_gone : NULL;
    case CDS_TIMEOUT: return text_of_late(console);
    case CDS_CORRUPT: return text_of_scan(console);
    case CDS_LIMIT: return text_of_limits(console);
    case CDS_NO_REPLY_DUE: return command_set.has_room ? text_of_mute(console) : NULL;
    case CDS_INHIBITED: return text_of_release(console);
    case ERROR_STOPPED: return text_of_stopped(console);
    case ERROR_ENDLESS: return text_of_turn(console);
    case ERROR_ALARM: return text_of_supply(console);
    case ERROR_LINK_LOST: return advice_link_lost(console);
    default: return NULL;
    }
}
