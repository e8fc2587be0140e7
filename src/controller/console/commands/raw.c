/* SPDX-License-Identifier: MIT */
/* The instructions of the manual: ping, read, write, regwrite, action, reset, sync. */
#include "cds55xx/control_table.h"
#include "console/console.h"
#include "console/errors.h" // ERROR_PLACE_TAKEN
#include "console/commands/command_groups.h"
#include "console/commands/shared.h" // register_raw_at()
#include "console/messages.h"
#include "console/number_format.h"

static const CDS_FLASH char message_id[] = "id %u";

#define BYTES_IN_LINE 8

static uint8_t raw_begin(struct console *console)
{
    console->line.request->no_retry = true; // a typed packet is sent once
    return (uint8_t)cds_bus_submit(console->bus, console->line.request);
}

/* True if a WRITE gives its servo the ID of another known servo. */
static bool gives_known_id(const struct console *console)
{
    const struct cds_packet *packet = &console->line.request->packet;
    uint8_t new_id = packet->bytes[CDS_AT_PARAMETERS + 1];

    return console->line.address == CDS_REG_ID && packet->bytes[CDS_AT_INSTRUCTION] == CDS_WRITE &&
           console->line.id <= CDS_ID_MAX && new_id != console->line.id &&
           cds_servos_find(&console->robot->servos, new_id);
}

/* If the permit refuses the packet, removes the entry that it has just added for the servo. Only
 * where there is flash for it. */
static uint8_t write_begin(struct console *console)
{
    struct cds_servos *servos = &console->robot->servos;
    uint8_t count = servos->count, result = raw_begin(console);

    if (!command_set.has_room || result != CDS_LIMIT)
        return result;
    cds_servos_forget_from(servos, count);
    return gives_known_id(console) ? (uint8_t)ERROR_PLACE_TAKEN : result;
}

/* After RESET a servo has ID 1: the only limit that RESET can break. */
static uint8_t reset_begin(struct console *console)
{
    uint8_t result = raw_begin(console);

    return result == CDS_LIMIT ? (uint8_t)ERROR_PLACE_TAKEN : result;
}

/* Prints what the servo has now, if the chip has flash for it. */
static bool reset_poll(struct console *console)
{
    if (console_waits(console))
        return true;
    if (command_set.has_room && console_answered(console))
        printer_line(&console->printer, message_factory);
    return false;
}

/* After a broadcast PING: prints the ID that answered. */
static bool ping_poll(struct console *console)
{
    if (console_waits(console))
        return true;
    if (console->error == 0 && console->line.id == CDS_BROADCAST_ID) {
        console->printer.values[0].number = console->line.request->id;
        printer_line(&console->printer, message_id);
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

    number_print_name(&console->printer, console->line.address);
    printer_decimal(&console->printer, register_raw_at(request->reply, request->length));
    printer_end_of_line(&console->printer);
}

/* Prints the bytes, and the value if a named register was read whole. */
static bool read_poll(struct console *console)
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

static const CDS_FLASH struct command raw_rows[] = {
    {
        .usage = FLASH_TEXT("ping ID|254"),
        .what = FLASH_TEXT("see if a servo answers"),
        .details = COMMAND_DETAILS("ID 254 finds a servo that is alone on the bus"),
        .example = COMMAND_DETAILS("ping 1"),
        .begin = raw_begin,
        .poll = ping_poll,
        .instruction = CDS_PING,
    },
    {
        .usage = FLASH_TEXT("read ID REG [LENGTH]"),
        .what = FLASH_TEXT("read registers"),
        .details = COMMAND_DETAILS("REG: name or address, 0 to 0x31. LENGTH: 1 to 50"),
        .example = COMMAND_DETAILS("read 1 PRESENT_POSITION"),
        .begin = raw_begin,
        .poll = read_poll,
        .instruction = CDS_READ,
    },
    {
        .usage = FLASH_TEXT("write ID|254 REG VALUE..."),
        .what = FLASH_TEXT("write registers"),
        .details = COMMAND_DETAILS(
            "By name: values of registers. By address: bytes, 0 to 255. ID 254: all"),
        .example = COMMAND_DETAILS("write 1 GOAL_POSITION 512 300"),
        .begin = write_begin,
        .poll = console_waits,
        .instruction = CDS_WRITE,
    },
    {
        .usage = FLASH_TEXT("regwrite ID|254 REG VALUE..."),
        .what = FLASH_TEXT("write, kept until action"),
        .details = COMMAND_DETAILS("As write"),
        .example = COMMAND_DETAILS("regwrite 2 GOAL_POSITION 700"),
        .begin = write_begin,
        .poll = console_waits,
        .instruction = CDS_REG_WRITE,
    },
    {
        .usage = FLASH_TEXT("action [ID|254]"),
        .what = FLASH_TEXT("do what regwrite sent"),
        .details = COMMAND_DETAILS("All start at the same moment. No ID: all servos"),
        .example = COMMAND_DETAILS("action"),
        .begin = raw_begin,
        .poll = console_waits,
        .instruction = CDS_ACTION,
    },
    {
        .usage = FLASH_TEXT("reset ID"),
        .what = message_factory,
        .details = COMMAND_DETAILS("factory does the same and checks the result"),
        .example = COMMAND_DETAILS("reset 1"),
        .begin = reset_begin,
        .poll = reset_poll,
        .instruction = CDS_RESET,
    },
    {
        .usage = FLASH_TEXT("sync REG LENGTH ID:BYTE,... ..."),
        .what = FLASH_TEXT("write many servos"),
        .details = COMMAND_DETAILS("LENGTH: bytes for each servo, 1 to 50. No replies"),
        .example = COMMAND_DETAILS("sync GOAL_POSITION 4 1:0,2,44,1 2:0,1,44,1"),
        .begin = raw_begin,
        .poll = console_waits,
        .instruction = CDS_SYNC_WRITE,
    },
};

const CDS_FLASH struct command_group raw_commands = {
    .heading = FLASH_TEXT("Instructions of the manual:"),
    .rows = raw_rows,
    .count = sizeof raw_rows / sizeof raw_rows[0],
};
