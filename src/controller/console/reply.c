/* SPDX-License-Identifier: MIT */
/* The end of replies; see reply.h. */
#include "console/reply.h"

#include <stddef.h> // NULL

#include "compiler.h" // NOINLINE
#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"
#include "console/typing.h"
#include "console/unasked.h"

static const CDS_FLASH char ok[] = "ok";
static const CDS_FLASH char failed[] = "error %u: %s";
static const CDS_FLASH char failed_too[] = "also %u: %s";
static const CDS_FLASH char warning[] = "warning: %s%s";
static const CDS_FLASH char warning_of_servo[] = "warning: servo %u: %s%s";

const CDS_FLASH char *const CDS_FLASH reply_conditions[] = {
    FLASH_TEXT("input voltage"), FLASH_TEXT("angle limit"),
    FLASH_TEXT("overheating"),   FLASH_TEXT("range"),
    FLASH_TEXT("checksum"),      FLASH_TEXT("overload"),
    FLASH_TEXT("instruction"),   FLASH_TEXT("torque went off by itself"),
    message_is_offline,
};

void reply_print_servo(struct printer *printer, uint8_t id)
{
    printer_flash(printer, message_servo_label);
    printer_decimal(printer, id);
}

/* For each condition, the error whose remedy helps against it. */
static const CDS_FLASH uint8_t reply_remedies[] = {
    ERROR_VOLTAGE, ERROR_SERVO_ANGLE,       ERROR_ALARM,   ERROR_SERVO_RANGE, ERROR_SERVO_CHECKSUM,
    ERROR_ALARM,   ERROR_SERVO_INSTRUCTION, CDS_INHIBITED, CDS_TIMEOUT,
};

uint8_t reply_remedy_error(uint8_t condition)
{
    return reply_remedies[condition];
}

const CDS_FLASH char *reply_remedy(uint8_t condition)
{
    const CDS_FLASH char *text;

    if (!command_set.explain)
        return message_nothing;
    for (text = error_text(reply_remedies[condition]); *text != ';'; text++)
        ;
    return text;
}

NOINLINE uint8_t reply_condition(uint8_t bits)
{
    uint8_t index = 0;

    for (; !(bits & 1); bits >>= 1)
        index++;
    return index;
}

bool reply_warn(struct console *console)
{
    uint8_t conditions = console->servo_error & CDS_ERRORS_OF_CONDITION, condition;
    bool names_servo = command_set.lists && console->line.is_repeated;
    union printer_value *value = console->printer.values;

    if (conditions == 0)
        return false;
    condition = reply_condition(conditions);
    console->servo_error ^= conditions & (uint8_t)-conditions; // the lowest bit
    if (names_servo)
        (value++)->number = console->line.id;
    value[0].text = reply_conditions[condition];
    value[1].text = command_set.unasked
                        ? unasked_warning_remedy(command_set.unasked, console, condition)
                        : reply_remedy(condition);
    printer_line(&console->printer, names_servo ? warning_of_servo : warning);
    return true;
}

/* Prints "ok", the error, or one reason for which a servo refuses. All reasons but the last begin
 * with "also". True: there is more to print. */
static bool print_result(struct console *console)
{
    uint8_t number = error_of_servo(&console->servo_error);
    bool more = number && console->servo_error;

    if (number == 0)
        number = console->error;
    if (command_set.explain && number && !more) {
        console->error = number;
        if (command_set.explain(console))
            return true;
    } else {
        if (command_set.unasked && number)
            unasked_note_error(command_set.unasked, number);
        console->printer.values[0].number = number;
        console->printer.values[1].text = error_text(number);
        printer_line(&console->printer, more ? failed_too : number ? failed : ok);
    }
    if (command_set.typing && command_set.typing->has_hint(console))
        console->printer.ends = false; // the hint ends the line
    return more;
}

/* Returns true once if the command went well; with room also if it went well for a servo of a list.
 */
static bool take_note_due(struct console *console)
{
    bool *went_well = &console->buffer.command.list.some_went_well;
    bool is_due;

    if (!command_set.has_room || console->error != ERROR_SOME || !console->line.is_repeated)
        return console->error == 0 && console_answered(console) && console->explained++ == 0;
    is_due = *went_well;
    *went_well = false;
    return is_due;
}

/* Before the last line: prints what the wire cannot show (advice_note()). False: there is nothing.
 */
static bool print_note(struct console *console)
{
    const CDS_FLASH char *message = NULL;

    if (command_set.note && take_note_due(console))
        message = command_set.note(console);
    if (message)
        printer_line(&console->printer, message);
    return message;
}

bool reply_piece(struct console *console)
{
    if (console->reply_ended) { // the last line was printed
        bool more = command_set.typing && command_set.typing->has_hint(console);

        if (more)
            command_set.typing->print_hint(console);
        return more;
    }
    if (!print_note(console) && !reply_warn(console) && !print_result(console))
        console->reply_ended = true;
    return true;
}
