/* SPDX-License-Identifier: MIT */
/* backup: the registers of a servo as lines of the console; restore: such a line. */
#include <string.h>

#include "cds55xx/control_table.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/console.h"
#include "console/messages.h"
#include "console/number_format.h"

static const CDS_FLASH char restore[] = "restore ";
static const CDS_FLASH char message_restore_written[] = " differed: written";
static const CDS_FLASH char message_not_written[] = " differs: not written";
static const CDS_FLASH char message_not_confirmed[] = " differed: sent, not confirmed";
static const CDS_FLASH char raw_unit[] = "raw";

uint8_t backup_begin(struct console *console)
{
    return servo_read(console, 0, CDS_TABLE_SIZE);
}

/* True if `set` writes this register, it outlives power-off, and the manual says what it does. */
static bool is_kept(const struct cds_register *at)
{
    return at->access == CDS_ACCESS_RW && at->area == CDS_AREA_EEPROM &&
           at->address != CDS_REG_ID && at->address != CDS_REG_BAUD_RATE &&
           cds_units_of(&cds_profile_cds55xx, at->address) != CDS_UNIT_NONE;
}

/* "restore 1 MAX_TEMPERATURE 80C"; a value that its unit does not have: "restore 1 ... 255raw" */
static void print_line(struct console *console, const struct cds_register *at)
{
    struct printer *printer = &console->printer;
    uint16_t raw = register_raw_at(console->line.request->reply + at->address, at->width);
    enum cds_unit unit = cds_units_of(&cds_profile_cds55xx, at->address);
    char name[CDS_REGISTER_NAME_SIZE];
    int32_t value;

    printer_flash(printer, restore);
    printer_decimal(printer, console->line.id);
    printer_char(printer, ' ');
    cds_register_name(at->address, name, sizeof name);
    printer_string(printer, name);
    printer_char(printer, ' ');
    if (cds_units_from_register(&cds_profile_cds55xx, unit, raw, &value) == CDS_OK) {
        number_print(printer, unit, raw);
    } else {
        printer_decimal(printer, raw);
        printer_flash(printer, raw_unit);
    }
    printer_end_of_line(printer);
}

/* Prints one register in each call. The status return level comes last: a servo that is set not to
 * answer READ could not be checked. */
static bool backup_poll(struct console *console)
{
    struct cds_register at;

    if (console_waits(console))
        return true;
    if (!console_answered(console))
        return false;
    if (console->part) {
        cds_register_at(CDS_REG_STATUS_RETURN_LEVEL, &at);
        print_line(console, &at);
        return false;
    }
    cds_register_at(console->index, &at);
    if (is_kept(&at) && at.address != CDS_REG_STATUS_RETURN_LEVEL)
        print_line(console, &at);
    console->index = (uint8_t)(at.address + at.width);
    console->part = console->index >= CDS_TABLE_SIZE;
    return true;
}

/* ---- restore ---- */

static uint8_t restore_begin(struct console *console)
{
    struct cds_register at;
    uint8_t error = register_take_value(console, &at);

    if (error)
        return error;
    console->line.address = at.address;
    console->line.length = at.width;
    return servo_read(console, at.address, at.width);
}

/* The register was read. True: it differs, and the WRITE has begun. */
static bool begin_to_write(struct console *console)
{
    const struct command_line *line = &console->line;
    const uint8_t *data = set_job(console)->data, *bytes = line->request->reply;

    if (setup_has_try(console, console->error, console->servo_error))
        return restore_begin(console) == 0;
    if (!console_answered(console))
        return false;
    console->raw = register_raw_at(bytes, line->length);
    if (memcmp(bytes, data, line->length) == 0) {
        printer_line(&console->printer, message_unchanged);
        return false;
    }
    console->phase = 1;
    console->error = setup_write(console, line->address, data, line->length);
    return console->error == 0;
}

/* What is known of the value. Without a good reply to the last READ the servo may hold it. */
static const CDS_FLASH char *end_of_restore(struct console *console)
{
    if (console->error == 0)
        return message_restore_written;
    return set_job(console)->setup.is_written && console->line.request->result != CDS_OK
               ? message_not_confirmed
               : message_not_written;
}

/* Writes the register if it differs, and reads it back. */
static bool restore_poll(struct console *console)
{
    if (console->phase == 0)
        return console_waits(console) || begin_to_write(console);
    if (setup_waits(console))
        return true;
    register_print(&console->printer, console->line.address, console->raw);
    printer_line(&console->printer, end_of_restore(console));
    return false;
}

static const CDS_FLASH struct command backup_rows[] = {
    {
        .usage = FLASH_TEXT("backup ID"),
        .what = FLASH_TEXT("print the lines that restore the registers"),
        .details = COMMAND_DETAILS(
            "EEPROM without ID and BAUD_RATE. scripts/send-lines.py sends the lines back"),
        .example = COMMAND_DETAILS("backup 1"),
        .begin = backup_begin,
        .poll = backup_poll,
    },
    {
        .usage = FLASH_TEXT("restore ID REG VALUE"),
        .what = FLASH_TEXT("write a register if it differs, and show what differed"),
        .details = COMMAND_DETAILS("A line of backup; REG and VALUE as for set"),
        .example = COMMAND_DETAILS("restore 1 MIN_VOLTAGE 6V"),
        .begin = restore_begin,
        .poll = restore_poll,
    },
};

const CDS_FLASH struct command_group backup_commands = {
    .rows = backup_rows,
    .count = sizeof backup_rows / sizeof backup_rows[0],
};
