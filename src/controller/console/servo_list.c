/* SPDX-License-Identifier: MIT */
/* Lists of servos; see servo_list.h. */
#include "console/servo_list.h"

#include <string.h>

#include "cds55xx/control_table.h"   // CDS_TABLE_SIZE
#include "console/commands/shared.h" // servo_outcome()
#include "console/console.h"
#include "console/errors.h"
#include "console/explain.h"
#include "console/messages.h"
#include "console/mistake.h"
#include "console/reply.h"   // reply_warn()
#include "console/unasked.h" // unasked_note_error()

static const CDS_FLASH char message_ok[] = "ok";
static const CDS_FLASH char message_not_a_list[] =
    "warning: %u was read as a value, not as servo %u%s";

static const CDS_FLASH char message_register[] =
    "warning: %u was read as the address of a register, not as servo %u";

/* ---- reading a line: these functions return an error or 0 ---- */

static uint8_t *ids_of(const struct command_line *line)
{
    return line->request->packet.bytes;
}

/* Before a REG an ID may stand twice: it may be an address or a value. */
static uint8_t add_id(struct command_line *line, uint8_t id)
{
    if (!parse_at_register(line) && memchr(ids_of(line), id, line->values))
        return ERROR_TWICE;
    if (line->values == PARSE_LIST_MAX)
        return ERROR_TOO_MANY;
    ids_of(line)[line->values++] = id;
    return 0;
}

/* The ID that the `length` characters at `text` are, into *id. */
static uint8_t read_id(const char *text, uint8_t length, uint8_t highest, uint8_t *id)
{
    struct token token = {.length = length};
    uint16_t value = 0;
    uint8_t error;

    memcpy(token.text, text, length);
    error = number_whole(&token, highest, &value);
    *id = (uint8_t)value;
    return error;
}

/* An ID, or two of them with a '-' between: "5-8". */
static uint8_t add_range(struct command_line *line, const char *text, uint8_t length)
{
    uint8_t before = 1, first, last; // characters before the '-', which is no minus
    uint8_t error;

    while (before < length && text[before] != '-')
        before++;
    error = read_id(text, before < length ? before : length, CDS_ID_MAX, &first);
    last = first;
    if (error == 0 && before < length)
        error = read_id(text + before + 1, (uint8_t)(length - before - 1), CDS_ID_MAX, &last);
    if (error == 0 && first > last)
        error = ERROR_OUT_OF_RANGE;
    for (uint8_t id = first; error == 0 && id <= last; id++)
        error = add_id(line, id);
    return error;
}

bool servo_list_is_all(const struct token *token)
{
    static const CDS_FLASH char all[] = "all";

    return parse_choice(all, token);
}

static uint8_t take_word(struct command_line *line, const struct token *token)
{
    const char *text = token->text, *end = text + token->length;
    uint8_t error = 0;

    if (servo_list_is_all(token) && line->values == 0) {
        line->takes_all = true;
        line->values = 1; // the list is complete; begin() fills it
        ids_of(line)[0] = CDS_BROADCAST_ID;
        return 0;
    }
    if (token->length > TOKEN_MAX || line->takes_all)
        return ERROR_NOT_A_NUMBER; // `group all 1`, too
    if (memchr(text, ',', token->length) || memchr(text, '-', token->length))
        line->singles = 0;
    else if (line->singles < 3)
        line->singles++;
    while (error == 0 && text <= end) {
        uint8_t length = 0;

        while (text + length < end && text[length] != ',')
            length++;
        error = length ? add_range(line, text, length) : (uint8_t)ERROR_NOT_A_NUMBER;
        text += length + 1;
    }
    return error;
}

static uint8_t take(struct command_line *line, const struct token *token, uint8_t highest)
{
    static const CDS_FLASH char old_id[] = "OLD";
    uint16_t value = 0;
    uint8_t id, error;

    if (parse_has_name(line->usage, old_id)) { // no list: several servos cannot get one ID
        error = number_whole(token, CDS_ID_MAX, &value);
        line->id = (uint8_t)value;
        return error;
    }
    if (highest == CDS_BROADCAST_ID && token->length <= TOKEN_MAX &&
        read_id(token->text, token->length, highest, &id) == 0 && id == CDS_BROADCAST_ID)
        return 0; // a packet to all servos: no list
    error = take_word(line, token);
    line->list_is_open = true;
    line->is_repeated = true;
    if (line->values)
        line->id = ids_of(line)[0];
    return error;
}

/* True if the word begins with a decimal digit: an ID, or the address of a register. */
static bool begins_with_decimal(const struct token *token)
{
    char second = token->length > 1 ? (char)(token->text[1] | 0x20) : '\0';

    return token->length && token->text[0] >= '0' && token->text[0] <= '9' && second != 'x';
}

/* True if the word is IDs with a ',' or a '-' between, or one ID. */
static bool is_list(const struct token *token)
{
    uint8_t id;

    if (token->length > TOKEN_MAX)
        return false;
    return memchr(token->text, ',', token->length) || memchr(token->text, '-', token->length) ||
           read_id(token->text, token->length, CDS_ID_MAX, &id) == 0;
}

/* True if the last words of the list, one or more, may be the address of a register, and a value:
 * each is one number, and an ID stands before them. */
static bool may_hold_address(const struct command_line *line, uint8_t words)
{
    return parse_at_register(line) && line->values > words && line->singles >= words;
}

/* The last ID of the list is the address of a register instead. If no register has the address, the
 * line gets the error, stays at REG, and number[0] is the address (explain.c). */
static void take_address_out(struct command_line *line)
{
    line->address = line->next = ids_of(line)[--line->values];
    line->length = 1;
    if (line->address < CDS_TABLE_SIZE) {
        parse_next_argument(line);
        return;
    }
    line->number[0] = (struct number){.digits = line->address, .kind = NUMBER_BARE};
    line->numbers = 1;
    line->error = ERROR_OUT_OF_RANGE;
}

/* More words of the list may follow, unless a number comes next. The address of a register may be
 * a decimal number: in `set 1 30 512` the word behind it, which is no ID, shows that. */
static bool goes_on(struct command_line *line, const struct token *token)
{
    if (!line->takes_all && begins_with_decimal(token) && !parse_at_number(line)) {
        if (is_list(token) || !may_hold_address(line, 1))
            return true;
        take_address_out(line);
    }
    line->list_is_open = false;
    return false;
}

/* In `get 1 30` and `set 1 5 10` the last numbers are address and value. */
static void end(struct command_line *line)
{
    static const CDS_FLASH char register_argument[] = "REG";
    struct number value = {.kind = NUMBER_BARE};
    bool has_value;

    if (!line->list_is_open)
        return;
    has_value = parse_has_name(line->usage, register_argument) &&
                line->usage[sizeof "REG" - 1] == ' '; // else the usage may end before
    if (!may_hold_address(line, (uint8_t)(1 + has_value)))
        return;
    if (has_value)
        value.digits = ids_of(line)[--line->values];
    take_address_out(line);
    if (has_value && line->error == 0) {
        line->number[line->numbers++] = value;
        parse_next_argument(line);
    }
}

/* ---- running the command ---- */

/* The list stands behind the packets of the command. */
static uint8_t *kept_ids(const struct command_line *line)
{
    return ids_of(line) + PARSE_LIST_MAX;
}

static struct servo_list *list_of(struct console *console)
{
    return &console->buffer.command.list;
}

static uint8_t begin_command(struct console *console)
{
    const CDS_FLASH struct command *command = console->line.command;

    return command->begin ? command->begin(console) : 0;
}

/* Fills the list with the servos of the robot, in the order in which `servos` prints them. Returns
 * an error or 0. */
static uint8_t list_all(struct console *console)
{
    const struct cds_servos *servos = &console->robot->servos;
    uint8_t *ids = ids_of(&console->line), id = 0;

    if (servos->count == 0)
        return ERROR_NOT_KNOWN;
    for (uint8_t i = 0; i < servos->count; i++) {
        id = command_set.advise ? robot_servo_from(console->robot, id)->id : servos->states[i].id;
        ids[i] = id++;
    }
    console->line.values = servos->count;
    return 0;
}

/* True if an ID stands twice in the list. */
static bool has_twins(const struct command_line *line)
{
    const uint8_t *ids = ids_of(line);

    for (uint8_t i = 1; i < line->values; i++)
        if (memchr(ids, ids[i], i))
            return true;
    return false;
}

static uint8_t begin(struct console *console)
{
    struct command_line *line = &console->line;
    uint8_t error = line->takes_all ? list_all(console) : 0;

    if (error == 0 && line->command->begin == teach_begin)
        error = teach_choose(console);
    if (error)
        return error;
    if (line->takes_all && line->is_repeated)
        line->id = ids_of(line)[0];
    else if (line->is_repeated && has_twins(line))
        return ERROR_TWICE;
    if (!line->is_repeated || line->values < 2 || line->command->begin == baud_begin) {
        line->is_repeated = false;
        return begin_command(console);
    }
    if (command_set.has_room && line->command->begin == factory_begin)
        return ERROR_FORCE;           // each servo would get ID 1
    error = explain_numbers(console); // it is wrong for each servo
    if (error)
        return error;
    memmove(kept_ids(line), ids_of(line), line->values);
    memset(list_of(console), 0, sizeof(struct servo_list));
    return 0;
}

enum list_phase { NEXT_SERVO, BEGIN, RUN, END, WARN } __attribute__((packed));

/* Prints "servo 3: ". False: the list has ended. */
static bool next_servo(struct console *console)
{
    struct servo_list *list = list_of(console);

    if (list->next == console->line.values) {
        console->error = list->error ? (uint8_t)ERROR_SOME : 0;
        return false;
    }
    console->line.id = kept_ids(&console->line)[list->next++];
    console->printer.values[0].number = console->line.id;
    if (console->line.command->begin != backup_begin)
        printer_text(&console->printer, message_of_servo);
    list->phase = BEGIN;
    return true;
}

static bool run_servo(struct console *console)
{
    const CDS_FLASH struct command *command = console->line.command;

    return command->poll && command->poll(console);
}

/* Begins the command, and polls it at once, as a command that runs alone. */
static bool begin_servo(struct console *console)
{
    console_begin_job(console);
    console->error = begin_command(console);
    return console->error == 0 && run_servo(console);
}

/* Prints the outcome behind "servo 3: ". */
static void end_servo_line(struct console *console, uint8_t error, enum mistake mistake)
{
    if (mistake)
        mistake_print(console, mistake);
    else
        printer_line(&console->printer, error ? error_text_of_servo(error) : message_ok);
}

/* Prints an error that a servo before had, too: "servo 3: no reply by the deadline". What to do
 * stands behind a ';' in the line of that servo. */
static void repeat_error(struct console *console, uint8_t error)
{
    const CDS_FLASH char *text = error_text_of_servo(error);
    struct printer *printer = &console->printer;

    if (!printer->within) {
        reply_print_servo(printer, console->line.id);
        printer_flash(printer, message_colon);
    }
    while (*text && *text != ';')
        printer_char(printer, *text++);
    printer_end_of_line(printer);
}

/* Ends the line of the servo, or prints its error on a line of its own. */
static void end_servo(struct console *console)
{
    struct servo_list *list = list_of(console);
    uint8_t conditions = console->servo_error & CDS_ERRORS_OF_CONDITION;
    uint8_t error = servo_outcome(console);
    enum mistake mistake;
    bool is_own; // the text of the error is of this servo alone, as its limits or its rate

    console->error = error;
    mistake = mistake_of(console, false);
    /* A stop concerns all servos: its advice does, too. */
    is_own = command_set.has_room && error && error != ERROR_STOPPED && mistake;
    console->servo_error = conditions;
    list->phase = WARN;
    if (command_set.has_room && error)
        printer_set_id(&console->printer, console->line.id);
    if (error && !(mistake && console->printer.within))
        explain_note_told(console);
    if (command_set.has_room && error && !is_own && error == list->error)
        repeat_error(console, error);
    else if (console->printer.within)
        end_servo_line(console, error, mistake);
    else if (error)
        servo_failed(console, error);
    if (error)
        list->error = is_own ? (uint8_t)ERROR_SOME : error;
    else if (command_set.has_room)
        list->some_went_well = true;
}

/* True if the user may have meant a list: in `move 1 2 30` all numbers are bare, the optional one
 * is there, and the first one is the ID of another servo of the robot. */
static bool may_be_list(const struct console *console)
{
    const struct command_line *line = &console->line;
    const struct number *first = line->number;

    if (line->takes_all || line->values != 1 || line->numbers < 2 || *line->usage ||
        first->digits == line->id || first->digits < 0 || first->digits > CDS_ID_MAX)
        return false;
    for (uint8_t i = 0; i < line->numbers; i++)
        if (line->number[i].kind != NUMBER_BARE || line->number[i].decimals)
            return false;
    return cds_servos_find(&console->robot->servos, (uint8_t)first->digits) != NULL;
}

/* True if the user may have forgotten the register: `get 1 2 3` reads register 3 of servos 1 and 2,
 * and the robot has a servo 3. */
static bool may_lack_register(const struct console *console)
{
    const struct command_line *line = &console->line;

    return line->singles > 2 && line->length == 1 && !line->named &&
           console->buffer.command.list.next == 0 &&
           cds_servos_find(&console->robot->servos, line->address);
}

/* Warns of a number that may be meant as an ID: "warning: 2 was read as a value, not as servo 2; a
 * list of servos is one word: 1,2". False: there is none. */
static bool warn_of_list(struct console *console)
{
    union printer_value *values = console->printer.values;
    const struct command_line *line = &console->line;

    if (!line->is_repeated && may_be_list(console)) {
        values[0].number = values[1].number = (uint16_t)line->number[0].digits;
        values[2].text = message_one_word;
        printer_line(&console->printer, message_not_a_list);
        return true;
    }
    if (!command_set.advise || !line->is_repeated || !may_lack_register(console))
        return false;
    values[0].number = values[1].number = line->address;
    printer_line(&console->printer, message_register);
    return true;
}

static bool poll(struct console *console)
{
    struct servo_list *list = list_of(console);

    if (console->step == 0 && warn_of_list(console))
        return true;
    if (!console->line.is_repeated)
        return run_servo(console);
    switch (list->phase) {
    case NEXT_SERVO: return next_servo(console);
    case BEGIN: list->phase = begin_servo(console) ? RUN : END; return true;
    case RUN: list->phase = run_servo(console) ? RUN : END; return true;
    case END: end_servo(console); return true;
    default: list->phase = reply_warn(console) ? WARN : NEXT_SERVO; return true;
    }
}

const CDS_FLASH struct command_lists servo_lists = {.take = take,
                                                    .take_word = take_word,
                                                    .goes_on = goes_on,
                                                    .end = end,
                                                    .begin = begin,
                                                    .poll = poll};
