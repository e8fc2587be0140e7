/* The instructions of the manual: ping, read, write, regwrite, action, reset, sync. */
#include "cds55xx/control_table.h"
#include "console.h"
#include "handlers.h"

#define BYTES_IN_LINE 8

uint8_t raw_begin(struct console *console)
{
    return (uint8_t)cds_bus_submit(console->bus, console->line.request);
}

bool exchange_poll(struct console *console)
{
    return console_waits(console);
}

/* A broadcast PING tells who answered. */
bool ping_poll(struct console *console)
{
    if (console_waits(console))
        return true;
    if (console->error == 0 && console->line.id == CDS_BROADCAST_ID) {
        WRITER_TEXT(&console->writer, "id ");
        writer_decimal(&console->writer, console->line.request->id);
        writer_end_of_line(&console->writer);
    }
    return false;
}

/* "0x1E: 00 02 00 02" */
static void dump_line(struct console *console, uint8_t first)
{
    const struct cds_request *request = console->line.request;

    WRITER_TEXT(&console->writer, "0x");
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
    WRITER_TEXT(&console->writer, " = ");
    writer_decimal(&console->writer, value);
    writer_end_of_line(&console->writer);
}

/* The bytes, and the value of a register that was named and read whole. */
bool read_poll(struct console *console)
{
    const struct cds_request *request = console->line.request;
    uint8_t *line = &console->index;
    struct cds_register at;

    if (console_waits(console))
        return true;
    if (console->error)
        return false;
    if (*line * BYTES_IN_LINE < request->length) {
        dump_line(console, (uint8_t)(*line * BYTES_IN_LINE));
        (*line)++;
        return true;
    }
    if (console->line.named && cds_register_at(console->line.address, &at) &&
        at.width == request->length)
        value_line(console, at.width);
    return false;
}
