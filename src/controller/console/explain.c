/* SPDX-License-Identifier: MIT */
/* Errors with servo, argument, value and range; see explain.h. */
#include "console/explain.h"

#include <stddef.h>

#include "cds55xx/control_table.h"    // cds_register_at()
#include "cds55xx/motion.h"           // CDS_MOTION_OVERRIDE_MIN
#include "console/advice_alarms.h"    // advice_note_refused()
#include "console/commands/monitor.h" // MONITOR_MS_MIN
#include "console/commands/shared.h"  // setting_is_rate()
#include "console/commands/stored.h"  // stored_unknown_name()
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"
#include "console/mistake.h"
#include "console/number_format.h"
#include "console/unasked.h" // unasked_note_error()
#include "robot/autostart.h" // AUTOSTART_DELAY_MAX
#include "robot/settings.h"  // settings_table

static const CDS_FLASH char message_error[] = "error %u: ";
static const CDS_FLASH char message_range[] = " is out of range: ";
static const CDS_FLASH char message_to[] = " to ";
static const CDS_FLASH char message_where[] = " where '";
static const CDS_FLASH char message_is_due[] = "' is due";
static const CDS_FLASH char message_ms[] = "ms";
static const CDS_FLASH char message_us[] = "us";
static const CDS_FLASH char name_of_id[] = "ID";
static const CDS_FLASH char name_of_settings[] = "settings";
static const CDS_FLASH char name_of_speed_or_time[] =
    "SPEED|TIME"; // of `pose`: behind `at` or `in`
static const CDS_FLASH char message_whole_s[] = "s, whole seconds";
static const CDS_FLASH char message_too_fine[] = "has too many decimals";

#define CW_FULL (0x400 | CDS_VALUE_MAX) // full speed CW (R35)

/* By the name of the argument and, where commands differ, the name of the command. */
static const CDS_FLASH struct {
    const CDS_FLASH char *name;
    const CDS_FLASH char *command;
    struct range range;
} argument_ranges[] = {
    {name_of_id, NULL, {0, CDS_ID_MAX, CDS_UNIT_NUMBER}},
    {FLASH_TEXT("ID..."), NULL, {0, CDS_ID_MAX, CDS_UNIT_NUMBER}},
    {FLASH_TEXT("OLD"), NULL, {0, CDS_ID_MAX, CDS_UNIT_NUMBER}},
    {FLASH_TEXT("NEW"), NULL, {0, CDS_ID_MAX, CDS_UNIT_NUMBER}},
    {FLASH_TEXT("ID|254"), NULL, {0, CDS_BROADCAST_ID, CDS_UNIT_NUMBER}},
    {FLASH_TEXT("REG"), NULL, {0, CDS_TABLE_SIZE - 1, UNIT_ADDRESS}},
    {FLASH_TEXT("ANGLE"), NULL, {0, CDS_VALUE_MAX, CDS_UNIT_MDEG}},
    {FLASH_TEXT("ANGLE..."), NULL, {0, CDS_VALUE_MAX, CDS_UNIT_MDEG}},
    {FLASH_TEXT("HIGH"), NULL, {0, CDS_VALUE_MAX, CDS_UNIT_MDEG}},
    {FLASH_TEXT("SPEED"), FLASH_TEXT("turn"), {CW_FULL, CDS_VALUE_MAX, CDS_UNIT_SIGNED_MRPM}},
    {FLASH_TEXT("SPEED"), NULL, {0, CDS_VALUE_MAX, CDS_UNIT_MRPM}},
    {FLASH_TEXT("RATE"), NULL, {CDS_BAUD_MAX, 0, CDS_UNIT_BPS}},
    {FLASH_TEXT("MS"), FLASH_TEXT("monitor"), {MONITOR_MS_MIN, MONITOR_MS_MAX, UNIT_MS}},
    {FLASH_TEXT("MS"), FLASH_TEXT("cycle"), {CYCLE_MS_MIN, CYCLE_MS_MAX, UNIT_MS}},
    {FLASH_TEXT("N"), FLASH_TEXT("play"), {1, UINT16_MAX, CDS_UNIT_NUMBER}},
    {FLASH_TEXT("PERCENT"), NULL, {CDS_MOTION_OVERRIDE_MIN, CDS_MOTION_OVERRIDE_MAX, UNIT_PERCENT}},
    {FLASH_TEXT("DELAY"), NULL, {1, AUTOSTART_DELAY_MAX, UNIT_S}},
    {FLASH_TEXT("TIME"), NULL, {0, 0, UNIT_MS}}, // its range depends on the command
    {name_of_speed_or_time, NULL, {0, 0, UNIT_MS}},
};

#define RANGES (sizeof argument_ranges / sizeof argument_ranges[0])

/* The range of a value of the register at `address`. False: there is no such register. */
static bool range_of_register(uint8_t address, bool in_unit, struct range *range)
{
    struct cds_register at;

    if (!cds_register_at(address, &at))
        return false;
    *range = (struct range){in_unit ? at.lowest : 0, at.highest, CDS_UNIT_NUMBER};
    if (in_unit)
        range->unit = (uint8_t)cds_units_of(&cds_profile_cds55xx, at.address);
    if (range->unit == CDS_UNIT_BPS) // the rate falls as the register rises
        *range = (struct range){at.highest, at.lowest, CDS_UNIT_BPS};
    return true;
}

bool explain_is_settings(const struct command_line *line)
{
    return parse_has_name(line->command->usage, name_of_settings);
}

/* The range of the setting of the line. A rate may be given in bit/s. */
static struct range range_of_setting(const struct command_line *line)
{
    const CDS_FLASH struct setting *row = &settings_table[line->setting];
    uint8_t unit = CDS_UNIT_NUMBER;

    if (setting_is_rate(line))
        return (struct range){row->highest < CDS_BAUD_MAX ? row->highest : CDS_BAUD_MAX,
                              row->lowest, CDS_UNIT_BPS};
    if (line->number[0].kind == NUMBER_TIME && *row->unit == 'm')
        unit = UNIT_MS;
    if (line->number[0].kind == NUMBER_TIME && *row->unit == 'u')
        unit = UNIT_US;
    if (line->number[0].kind == NUMBER_TIME && *row->unit == 'x')
        unit = CDS_UNIT_US;
    return (struct range){row->lowest, row->highest, unit};
}

/* LOW of the line may be up to its HIGH. */
static uint16_t highest_low(const struct command_line *line)
{
    uint16_t high = CDS_VALUE_MAX;

    if (line->numbers > 1)
        number_within(&line->number[1], CDS_UNIT_MDEG, &high);
    return high;
}

/* The range of the argument called `name`, up to a space. False: it is not known. */
static bool range_of(const struct command_line *line, const CDS_FLASH char *name,
                     struct range *range)
{
    static const CDS_FLASH char value[] = "VALUE", values[] = "VALUE...", length[] = "LENGTH",
                                low[] = "LOW";

    if (parse_has_name(name, name_of_speed_or_time) && line->choice == 1) { // "pose ... at SPEED"
        *range = (struct range){0, CDS_VALUE_MAX, CDS_UNIT_MRPM};
        return true;
    }
    if (parse_has_name(name, value) && explain_is_settings(line)) {
        *range = range_of_setting(line);
        return true;
    }
    if (parse_has_name(name, value))
        return range_of_register(line->address, true, range);
    if (parse_has_name(name, values)) {
        *range = (struct range){0, UINT8_MAX, CDS_UNIT_NUMBER};
        if (!line->named)
            return true;
        return line->next < CDS_TABLE_SIZE && // it stands behind the register of the value
               range_of_register((uint8_t)(line->next - 1), false, range);
    }
    if (parse_has_name(name, length)) {
        *range = (struct range){1, (uint16_t)(CDS_TABLE_SIZE - line->address), CDS_UNIT_NUMBER};
        return true;
    }
    if (parse_has_name(name, low)) {
        *range = (struct range){0, highest_low(line), CDS_UNIT_MDEG};
        return true;
    }
    for (uint8_t i = 0; i < RANGES; i++) {
        if (!parse_has_name(name, argument_ranges[i].name) ||
            (argument_ranges[i].command &&
             !parse_has_name(line->command->usage, argument_ranges[i].command)))
            continue;
        *range = argument_ranges[i].range;
        return true;
    }
    return false;
}

/* The error of `number` in this range, or 0. */
static uint8_t check(const struct number *number, const struct range *range)
{
    uint16_t raw = 0;
    uint32_t ms = 0;
    uint8_t percent = 0, error;

    if (range->unit == UNIT_MS) {
        error = number_ms(number, UINT16_MAX, &ms);
        raw = (uint16_t)ms;
    } else if (range->unit == UNIT_US) {
        error = number_us(number, UINT16_MAX, &ms);
        raw = (uint16_t)ms;
    } else if (range->unit == UNIT_S) {
        error = number_ms(number, range->highest * (uint32_t)1000, &ms);
        raw = ms % 1000 ? 0 : (uint16_t)(ms / 1000);
    } else if (range->unit == UNIT_PERCENT) {
        error = number_percent(number, &percent);
        raw = percent;
    } else {
        error = number_within(number, (enum cds_unit)range->unit, &raw);
    }
    if (error == 0 && range->unit == CDS_UNIT_BPS) // the rate falls as the register rises
        return raw > range->lowest || raw < range->highest ? (uint8_t)ERROR_OUT_OF_RANGE : 0;
    return error == 0 && range->lowest <= range->highest &&
                   (raw < range->lowest || raw > range->highest)
               ? (uint8_t)ERROR_OUT_OF_RANGE
               : error;
}

/* What the error is about. */
struct subject {
    const CDS_FLASH char *name;  // of the argument, in the usage; NULL: none
    const struct number *number; // the value; NULL: it is the word that the console keeps
    struct range range;
    bool has_range;
};

/* True if an address behind a list of servos is out of range (take_address_out() of servo_list.c).
 * No number stands before a REG. */
static bool is_of_address(const struct command_line *line)
{
    return line->error == ERROR_OUT_OF_RANGE && parse_at_register(line) && line->numbers;
}

/* True if a word of the line, which the console keeps, has caused the error. */
static bool is_of_word(const struct console *console)
{
    static const CDS_FLASH uint8_t errors[] = {
        ERROR_UNKNOWN_COMMAND, ERROR_NOT_A_NUMBER, ERROR_OUT_OF_RANGE,    ERROR_UNKNOWN_REGISTER,
        ERROR_UNKNOWN_WORD,    ERROR_UNIT,         ERROR_UNKNOWN_SETTING, ERROR_TWICE,
    };

    for (uint8_t i = 0; i < sizeof errors; i++)
        if (errors[i] == console->error)
            return console->line.error == console->error && console->token.length &&
                   !is_of_address(&console->line);
    return false;
}

/* Command and ID: until there are more words, the ID itself may be wrong. */
#define WORDS_WITH_ID 2

/* True if the wrong word belongs to a list of servos, behind the first word of it. */
static bool is_of_list(const struct command_line *line)
{
    return line->list_is_open && line->words > WORDS_WITH_ID && !is_of_address(line);
}

/* True if a number is out of range. */
static bool is_range_error(uint8_t error)
{
    return error == ERROR_OUT_OF_RANGE || error == ERROR_OVERRIDE;
}

/* Finds the subject. False: the error has none. */
static bool find_subject(const struct console *console, struct subject *subject)
{
    const struct command_line *line = &console->line;
    bool is_known;

    subject->number = NULL;
    if (is_of_word(console)) {
        subject->name = line->command ? line->usage : message_nothing;
        if (is_of_list(line))
            subject->name = name_of_id;
        subject->has_range = console->error == ERROR_OUT_OF_RANGE &&
                             range_of(line, subject->name, &subject->range) &&
                             (subject->range.lowest || subject->range.highest);
        return true;
    }
    if (is_of_address(line)) {
        subject->name = line->usage;
        subject->number = line->number;
        subject->has_range = range_of(line, subject->name, &subject->range);
        return true;
    }
    for (uint8_t i = 0; line->error == 0 && line->command && i < line->numbers; i++) {
        subject->name = parse_number_name(line, i);
        subject->number = &line->number[i];
        is_known = range_of(line, subject->name, &subject->range);
        subject->has_range = is_known && (subject->range.lowest || subject->range.highest);
        if (command_set.advise && !subject->has_range && is_range_error(console->error))
            continue; // TIME: not this number
        if (is_known &&
            check(subject->number, &subject->range) ==
                (is_range_error(console->error) ? (uint8_t)ERROR_OUT_OF_RANGE : console->error))
            return true;
    }
    return false;
}

bool explain_unit(const struct console *console, uint8_t *unit)
{
    struct subject subject;

    if (!find_subject(console, &subject) || !console->line.command ||
        !range_of(&console->line, subject.name, &subject.range))
        return false;
    *unit = subject.range.unit;
    return true;
}

uint8_t explain_numbers(struct console *console)
{
    struct subject subject;
    bool is_found;

    console->error = ERROR_OUT_OF_RANGE;
    is_found = find_subject(console, &subject);
    console->error = 0;
    return is_found && subject.has_range && subject.number->kind != NUMBER_RAW
               ? (uint8_t)ERROR_OUT_OF_RANGE
               : 0;
}

/* True if the error is that of the servo in the line, or of an argument for the servo. */
static bool is_of_servo(const struct console *console)
{
    static const CDS_FLASH uint8_t errors[] = {
        ERROR_NOT_A_NUMBER, ERROR_OUT_OF_RANGE, ERROR_UNIT,        ERROR_UNKNOWN_REGISTER,
        ERROR_NOT_WRITABLE, ERROR_ENDLESS,      ERROR_NOT_KNOWN,   ERROR_UNKNOWN_WORD,
        ERROR_LOST,         ERROR_BOTH,         ERROR_PLACE_TAKEN, ERROR_NOT_NEW,
        ERROR_ALARM,        ERROR_VOLTAGE,
    };
    const struct command_line *line = &console->line;
    uint8_t error = console->error;

    if (line->id > CDS_ID_MAX || (line->is_repeated && line->values > 1) ||
        (line->error && (line->words <= WORDS_WITH_ID || is_of_list(line))))
        return false;
    for (uint8_t i = 0; i < sizeof errors; i++)
        if (errors[i] == error)
            return true;
    return error < ERROR_UNKNOWN_COMMAND && error != CDS_NO_ROOM; // enum cds_result
}

/* True if the line is one packet to several servos: `sync`, or a command to ID 254. */
static bool is_to_many(const struct command_line *line)
{
    static const CDS_FLASH char move[] = "move", torque[] = "torque";

    return line->command && line->id == CDS_BROADCAST_ID &&
           (line->command->instruction || parse_is_command(line, move) ||
            parse_is_command(line, torque));
}

const struct cds_servo_state *explain_limited(const struct console *console)
{
    struct cds_servos *servos = &console->robot->servos;

    return command_set.has_room && is_to_many(&console->line)
               ? cds_servos_find(servos, servos->refused_id)
               : console_servo(console);
}

uint8_t explain_servo(const struct console *console)
{
    struct cds_servos *servos = &console->robot->servos;

    if (is_of_servo(console))
        return console->line.id;
    if (command_set.has_room && console->error == CDS_LIMIT && is_to_many(&console->line))
        return explain_limited(console) ? servos->refused_id : CDS_NO_ID;
    return console->error == CDS_INHIBITED && !cds_servos_may_drive(servos, servos->refused_id)
               ? servos->refused_id
               : CDS_NO_ID;
}

/* ---- printing ---- */

/* "ANGLE 400deg", or "REG 'GOAL'" */
static void print_subject(struct console *console, const struct subject *subject)
{
    struct printer *printer = &console->printer;
    const struct token *token = &console->token;
    const CDS_FLASH char *name = subject->name;
    bool quotes = subject->number == NULL && !subject->has_range;
    bool has_words = command_set.words && console->error == ERROR_UNKNOWN_WORD;
    bool is_half = command_set.advise && parse_has_name(name, name_of_speed_or_time);

    if (is_half && console->line.choice != 1) // `in`
        name += sizeof "SPEED|" - 1;
    if (has_words && !command_set.has_room) // else print_words_due() prints them
        command_set.words(console);
    for (; !has_words && *name && *name != ' ' && *name != ']' && !(is_half && *name == '|');
         name++)
        if (*name != '[')
            printer_char(printer, *name);
    if (printer->within && *subject->name && !(has_words && command_set.has_room))
        printer_char(printer, ' ');
    if (quotes)
        printer_char(printer, '\'');
    for (uint8_t i = 0; subject->number == NULL && i < token->length && i < TOKEN_MAX; i++)
        printer_typed_char(printer, token->text[i]);
    if (quotes)
        printer_char(printer, '\'');
    if (subject->number) {
        printer_fixed(printer, subject->number->digits, subject->number->decimals);
        printer_flash(printer, subject->number->kind == NUMBER_BARE &&
                                       subject->range.unit >= UNIT_S &&
                                       subject->range.unit != UNIT_PERCENT
                                   ? message_ms
                                   : number_unit_name(subject->number));
    }
}

/* Behind a word that stands in the place of others: " where 'wait|off|at' is due". */
static void print_words_due(struct console *console)
{
    if (console->error != ERROR_UNKNOWN_WORD)
        return;
    printer_flash(&console->printer, message_where);
    command_set.words(console);
    printer_flash(&console->printer, message_is_due);
}

/* "'walk': ", if the pose or sequence that the line names is unknown. A line with two names has the
 * pose behind the sequence. */
static void print_unknown_name(struct console *console)
{
    struct printer *printer = &console->printer;
    const char *name = stored_unknown_name(console);

    if (name == NULL)
        return;
    printer_char(printer, '\'');
    for (uint8_t i = 0; i < PARSE_NAME_SIZE && name[i]; i++)
        printer_char(printer, name[i]);
    printer_char(printer, '\'');
    printer_flash(printer, message_colon);
}

static void print_bound(struct printer *printer, uint8_t unit, uint16_t value, bool with_unit)
{
    if (unit == UNIT_ADDRESS) {
        printer_address(printer, (uint8_t)value);
    } else if (unit >= UNIT_S) {
        printer_decimal(printer, value);
        if (with_unit && unit == UNIT_MS)
            printer_flash(printer, message_ms);
        else if (with_unit && unit == UNIT_US)
            printer_flash(printer, message_us);
        else if (with_unit && unit == UNIT_S)
            printer_flash(printer, message_whole_s);
        else if (with_unit)
            printer_char(printer, '%');
    } else if (with_unit) {
        if (unit == CDS_UNIT_MRPM && value > CDS_VALUE_MAX)
            value = CDS_VALUE_MAX; // the register takes more, of no known speed
        number_print(printer, (enum cds_unit)unit, value);
    } else {
        number_print_bare(printer, (enum cds_unit)unit, value);
    }
}

/* The range in values of the register: of a rate and of the speed of `turn` it begins with 0. */
static struct range raw_range(const struct range *range)
{
    bool falls = range->lowest > range->highest;

    return (struct range){falls ? 0 : range->lowest, falls ? range->lowest : range->highest,
                          CDS_UNIT_NUMBER};
}

/* "0 to 300deg"; of a register value "0 to 1023raw" */
static void print_range(struct printer *printer, const struct subject *subject)
{
    bool is_raw = command_set.advise && subject->number && subject->number->kind == NUMBER_RAW;
    struct range of_raw = raw_range(&subject->range);
    const struct range *range = is_raw ? &of_raw : &subject->range;

    print_bound(printer, range->unit, range->lowest, false);
    printer_flash(printer, message_to);
    print_bound(printer, range->unit, range->highest, true);
    if (is_raw)
        printer_flash(printer, number_unit_name(subject->number));
    printer_end_of_line(printer);
}

/* The text of the error. Texts of refusals begin with "servo: ", which the number replaces. */
static const CDS_FLASH char *text_of(const struct console *console)
{
    return is_of_servo(console) ? error_text_of_servo(console->error) : error_text(console->error);
}

void explain_note_told(struct console *console)
{
    if (command_set.unasked)
        unasked_note_error(command_set.unasked, console->error);
    else if (command_set.advise)
        advice_note_refused(console, console->error);
}

/* The servo that the remedy of the error names: that of the error, or the servo for which a motion
 * was refused or has ended. */
static uint8_t servo_of_remedy(const struct console *console)
{
    uint8_t id = explain_servo(console);

    return id == CDS_NO_ID && (console->error == ERROR_STUCK || console->error == ERROR_ENDLESS)
               ? console->robot->servos.refused_id
               : id;
}

/* Prints the text of the error with its remedy. */
static void print_error_text(struct console *console)
{
    explain_note_told(console);
    if (command_set.has_room)
        printer_set_id(&console->printer, servo_of_remedy(console));
    printer_line(&console->printer, text_of(console));
}

enum part { PART_NUMBER, PART_SERVO, PART_SUBJECT, PART_TEXT, PART_RANGE } __attribute__((packed));

bool explain_error(struct console *console)
{
    struct printer *printer = &console->printer;
    struct subject subject;
    bool has_subject = console->explained >= PART_SUBJECT && find_subject(console, &subject);
    enum mistake mistake = mistake_of(console, is_of_word(console));
    bool has_group = command_set.motion_words && mistake == MISTAKE_GROUP;
    bool has_range = has_subject && subject.has_range && is_range_error(console->error) && !mistake;

    switch (console->explained++) {
    case PART_NUMBER:
        printer->values[0].number = console->error;
        printer_text(printer, message_error);
        return true;
    case PART_SERVO:
        printer->values[0].number = explain_servo(console);
        if (printer->values[0].number <= CDS_ID_MAX)
            printer_text(printer, message_of_servo);
        return true;
    case PART_SUBJECT:
        subject.has_range = has_range; // else the word has quotes
        if (has_subject)
            print_subject(console, &subject);
        print_unknown_name(console);
        return true;
    case PART_TEXT:
        if (command_set.has_room) {
            print_words_due(console);
            printer_set_command(printer,
                                console->line.command ? console->line.command->usage : NULL);
        }
        if (has_subject && !has_range)
            printer_flash(printer, message_colon);
        if (has_range)
            printer_text(printer, message_range);
        else if (mistake)
            mistake_print(console, mistake);
        else if (has_subject && subject.number && console->error == ERROR_NOT_A_NUMBER)
            printer_line(printer, message_too_fine);
        else
            print_error_text(console);
        return has_range || mistake == MISTAKE_COMMA || has_group;
    default:
        if (has_group)
            return command_set.motion_words->group(console,
                                                   (uint8_t)(console->explained - 1 - PART_RANGE));
        if (mistake)
            mistake_print_with_point(console);
        else
            print_range(printer, &subject);
        return false;
    }
}
