/* The end of replies; see reply.h. */
#include "console/reply.h"

#include "console/console.h"
#include "console/errors.h"
#include "console/messages.h"

uint8_t reply_condition(uint8_t bits, uint16_t *text)
{
    uint8_t bit = 1;

    *text = TEXT_CONDITION_VOLTAGE;
    for (; bits && !(bits & bit); bit = (uint8_t)(bit << 1))
        *text = printer_text_at(*text, 1);
    return (uint8_t)(bits & ~bit);
}

/* Names one condition that merely holds; false when there is none left. */
static bool warning(struct console *console)
{
    uint8_t conditions = console->servo_error & CDS_ERRORS_OF_CONDITION;

    if (conditions == 0)
        return false;
    console->servo_error = (uint8_t)((console->servo_error & ~CDS_ERRORS_OF_CONDITION) |
                                     reply_condition(conditions, &console->printer.values[0]));
    printer_line(&console->printer, TEXT_WARNING);
    return true;
}

/* Ends the reply. A servo may refuse for several reasons: all but the last are told as "also". */
static bool closing(struct console *console)
{
    uint8_t number = error_of_servo(&console->servo_error);
    bool more = number && console->servo_error;

    if (number == 0)
        number = console->error;
    console->printer.values[0] = number;
    console->printer.values[1] = error_text(number);
    printer_line(&console->printer, more ? TEXT_FAILED_TOO : number ? TEXT_FAILED : TEXT_OK);
    return more;
}

bool reply_piece(struct console *console)
{
    if (console->closed)
        return false; // and the last line is out
    if (!warning(console) && !closing(console))
        console->closed = true;
    return true;
}
