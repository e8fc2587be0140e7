/* Replies of the console; see reply.h. Each body writes one piece a step and says whether more of
 * it follows; after it come the warnings and the closing line, the same for all commands. */
#include "reply.h"

#include "cds55xx/control_table.h"
#include "cds55xx/version.h"
#include "cmd_keeper.h"
#include "console.h"
#include "errors.h"

#ifndef BOARD_NAME
#define BOARD_NAME "host"
#endif

#define BYTES_IN_LINE 8

static const CDS_FLASH char version_text[] = "cds55xx " CDS_VERSION " " BOARD_NAME;

static bool help_body(struct console *console)
{
    writer_text_line(&console->writer, commands[console->step].usage);
    return console->step < COMMAND_COUNT - 1;
}

static bool version_body(struct console *console)
{
    writer_text_line(&console->writer, version_text);
    return false;
}

/* A broadcast PING tells who answered. */
static bool ping_body(struct console *console)
{
    if (console->line.id == CDS_BROADCAST_ID) {
        writer_string(&console->writer, "id ");
        writer_decimal(&console->writer, console->line.request->id);
        writer_end_of_line(&console->writer);
    }
    return false;
}

/* "0x1E: 00 02 00 02" */
static void dump_line(struct console *console, uint8_t first)
{
    const struct cds_request *request = console->line.request;

    writer_string(&console->writer, "0x");
    writer_hex(&console->writer, (uint8_t)(console->line.address + first));
    writer_char(&console->writer, ':');
    for (uint8_t i = first; i < request->length && i < first + BYTES_IN_LINE; i++) {
        writer_char(&console->writer, ' ');
        writer_hex(&console->writer, request->packet.bytes[i]);
    }
    writer_end_of_line(&console->writer);
}

/* "GOAL_POSITION = 512" */
static void value_line(struct console *console, uint8_t width)
{
    char name[CDS_REGISTER_NAME_SIZE];
    uint8_t byte = 0;
    uint16_t value = 0;

    if (width == 2)
        cds_request_word(console->line.request, 0, &value);
    else if (cds_request_byte(console->line.request, 0, &byte) == CDS_OK)
        value = byte;
    cds_register_name(console->line.address, name, sizeof name);
    writer_string(&console->writer, name);
    writer_string(&console->writer, " = ");
    writer_decimal(&console->writer, value);
    writer_end_of_line(&console->writer);
}

/* The bytes, and the value of a register that was named and read whole. */
static bool read_body(struct console *console)
{
    const struct cds_request *request = console->line.request;
    uint8_t first = (uint8_t)(console->step * BYTES_IN_LINE);
    struct cds_register at;

    if (first < request->length) {
        dump_line(console, first);
        return true;
    }
    if (console->line.named && cds_register_at(console->line.address, &at) &&
        at.width == request->length)
        value_line(console, at.width);
    return false;
}

/* Writes a piece of the command's own reply; false when it was the last one. */
static bool body(struct console *console)
{
    switch (console->line.kind) {
    case COMMAND_help: return help_body(console);
    case COMMAND_version: return version_body(console);
    case COMMAND_ping: return ping_body(console);
    case COMMAND_read: return read_body(console);
    default: return cmd_keeper_poll(console);
    }
}

/* Names one condition that merely holds; false when there is none left. */
static bool warning(struct console *console)
{
    static const struct {
        uint8_t bit;
        char text[15];
    } CDS_FLASH conditions[] = {
        {CDS_ERROR_VOLTAGE, "input voltage"},
        {CDS_ERROR_OVERHEATING, "overheating"},
        {CDS_ERROR_OVERLOAD, "overload"},
    };

    for (uint8_t i = 0; i < sizeof conditions / sizeof conditions[0]; i++) {
        if (console->servo_error & conditions[i].bit) {
            console->servo_error = (uint8_t)(console->servo_error & ~conditions[i].bit);
            writer_string(&console->writer, "warning: ");
            writer_text_line(&console->writer, conditions[i].text);
            return true;
        }
    }
    return false;
}

static void error_line(struct console *console, const char *word, uint8_t number)
{
    writer_string(&console->writer, word);
    writer_char(&console->writer, ' ');
    writer_decimal(&console->writer, number);
    writer_string(&console->writer, ": ");
    writer_text_line(&console->writer, error_text(number));
}

/* Ends the reply. A servo may refuse for several reasons: all but the last are told as "also". */
static bool closing(struct console *console)
{
    uint8_t number = error_of_servo(&console->servo_error);

    if (number && console->servo_error) {
        error_line(console, "also", number);
        return true;
    }
    if (number == 0)
        number = console->error;
    if (number) {
        error_line(console, "error", number);
    } else {
        writer_string(&console->writer, "ok");
        writer_end_of_line(&console->writer);
    }
    return false;
}

bool reply_piece(struct console *console)
{
    switch (console->phase) {
    case REPLY_BODY:
        if (console->error || !body(console))
            console->phase = REPLY_CLOSING;
        console->step++;
        return true;
    case REPLY_CLOSING:
        if (!warning(console) && !closing(console))
            console->phase = REPLY_CLOSED;
        return true;
    default: return false; // and the last line is out
    }
}
