/* The end of replies; see reply.h. */
#include "reply.h"

#include "console.h"
#include "errors.h"

uint8_t reply_condition(struct writer *writer, uint8_t bits)
{
    static const struct {
        uint8_t bit;
        char text[14];
    } CDS_FLASH conditions[] = {
        {CDS_ERROR_VOLTAGE, "input voltage"},   {CDS_ERROR_ANGLE, "angle limit"},
        {CDS_ERROR_OVERHEATING, "overheating"}, {CDS_ERROR_RANGE, "range"},
        {CDS_ERROR_CHECKSUM, "checksum"},       {CDS_ERROR_OVERLOAD, "overload"},
        {CDS_ERROR_INSTRUCTION, "instruction"},
    };

    for (uint8_t i = 0; i < sizeof conditions / sizeof conditions[0]; i++) {
        if (bits & conditions[i].bit) {
            writer_flash(writer, conditions[i].text);
            return (uint8_t)(bits & ~conditions[i].bit);
        }
    }
    return 0;
}

/* Names one condition that merely holds; false when there is none left. */
static bool warning(struct console *console)
{
    uint8_t conditions = console->servo_error & CDS_ERRORS_OF_CONDITION;

    if (conditions == 0)
        return false;
    WRITER_TEXT(&console->writer, "warning: ");
    console->servo_error = (uint8_t)((console->servo_error & ~CDS_ERRORS_OF_CONDITION) |
                                     reply_condition(&console->writer, conditions));
    writer_end_of_line(&console->writer);
    return true;
}

static void error_line(struct console *console, uint8_t number)
{
    writer_decimal(&console->writer, number);
    WRITER_TEXT(&console->writer, ": ");
    writer_text_line(&console->writer, error_text(number));
}

/* Ends the reply. A servo may refuse for several reasons: all but the last are told as "also". */
static bool closing(struct console *console)
{
    uint8_t number = error_of_servo(&console->servo_error);

    if (number && console->servo_error) {
        WRITER_TEXT(&console->writer, "also ");
        error_line(console, number);
        return true;
    }
    if (number == 0)
        number = console->error;
    if (number) {
        WRITER_TEXT(&console->writer, "error ");
        error_line(console, number);
    } else {
        WRITER_TEXT(&console->writer, "ok");
        writer_end_of_line(&console->writer);
    }
    return false;
}

bool reply_piece(struct console *console)
{
    if (console->closed)
        return false; // and the last line is out
    if (!warning(console) && !closing(console))
        console->closed = true;
    return true;
}
