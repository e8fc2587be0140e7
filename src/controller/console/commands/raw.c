/* The instructions of the manual: ping, read, write, regwrite, action, reset, sync. */
#include "cds55xx/control_table.h"
#include "console/console.h"
#include "console/handlers.h"
#include "console/messages.h"

#define BYTES_IN_LINE 8

uint8_t raw_begin(struct console *console)
{
    console->line.request->no_retry = true; // what was typed is sent once
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
        console->printer.values[0] = console->line.request->id;
        printer_line(&console->printer, TEXT_ID);
    }
    return false;
}

/* "0x1E: 00 02 00 02" */
static void dump_line(struct console *console, uint8_t first)
{
    const struct cds_request *request = console->line.request;

    printer_address(&console->printer, (uint8_t)(console->line.address + first));
    printer_char(&console->printer, ':');
    for (uint8_t i = first; i < request->length && i < first + BYTES_IN_LINE; i++) {
        printer_char(&console->printer, ' ');
        printer_hex(&console->printer, request->reply[i]);
    }
    printer_end_of_line(&console->printer);
}

/* "GOAL_POSITION = 512", of a register that was read whole */
static void value_line(struct console *console)
{
    const struct cds_request *request = console->line.request;
    const uint8_t *bytes = request->reply;

    number_write_name(&console->printer, console->line.address);
    printer_decimal(&console->printer,
                    (uint16_t)(request->length == 2 ? bytes[0] | bytes[1] << 8 : bytes[0]));
    printer_end_of_line(&console->printer);
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
        value_line(console);
    return false;
}
