/* SPDX-License-Identifier: MIT */
/* get, set, info: registers in their units. */
#include "cds55xx/control_table.h"
#include "compiler.h" // ALWAYS_INLINE
#include "console/console.h"
#include "console/errors.h"
#include "console/commands/command_groups.h"
#include "console/commands/shared.h"
#include "console/messages.h"
#include "console/number_format.h"
#include "console/reply.h"

static const CDS_FLASH char message_in_eeprom[] = " EEPROM";
static const CDS_FLASH char message_in_ram[] = " RAM";
static const CDS_FLASH char message_not_read[] =
    "sent, not verified: at level 0 a servo answers only PING";

/* In endless turn MOVING_SPEED has a direction (R16), which no speed of position mode has. */
static enum cds_unit unit_of(uint8_t address, uint16_t raw)
{
    enum cds_unit unit = cds_units_of(&cds_profile_cds55xx, address);

    return unit == CDS_UNIT_MRPM && raw > CDS_VALUE_MAX ? CDS_UNIT_SIGNED_MRPM : unit;
}

void register_print(struct printer *printer, uint8_t address, uint16_t raw)
{
    enum cds_unit unit = unit_of(address, raw);

    number_print_name(printer, address);
    number_print(printer, unit, raw);
    if (unit != CDS_UNIT_NUMBER && unit != CDS_UNIT_NONE) {
        printer_char(printer, ' ');
        printer_char(printer, '(');
        printer_decimal(printer, raw);
        printer_char(printer, ')');
    }
}

uint16_t register_raw_at(const uint8_t *bytes, uint8_t width)
{
    return (uint16_t)(width == 2 ? bytes[0] | bytes[1] << 8 : bytes[0]);
}

/* True for the address of the second byte of a register, which `get` and `set` refuse on chips with
 * room for the check: they take the register as a whole. */
static bool is_second_byte(const struct command_line *line, const struct cds_register *at)
{
    return command_set.has_room && line->address != at->address;
}

/* ---- get ---- */

static uint8_t get_begin(struct console *console)
{
    struct command_line *line = &console->line;
    struct cds_register at;

    if (!cds_register_at(line->address, &at))
        return ERROR_OUT_OF_RANGE;
    if (is_second_byte(line, &at))
        return ERROR_UNKNOWN_REGISTER;
    line->address = at.address;
    line->length = at.width;
    return servo_read(console, at.address, at.width);
}

static bool get_poll(struct console *console)
{
    const struct command_line *line = &console->line;

    if (console_waits(console))
        return true;
    if (!console_answered(console))
        return false;
    register_print(&console->printer, line->address,
                   register_raw_at(line->request->reply, line->length));
    printer_end_of_line(&console->printer);
    return false;
}

/* ---- set ---- */

uint8_t register_take_value(struct console *console, struct cds_register *at)
{
    struct command_line *line = &console->line;
    uint8_t *data = set_job(console)->data;
    uint16_t raw = 0;
    uint8_t error;

    if (!cds_register_at(line->address, at))
        return ERROR_OUT_OF_RANGE;
    if (is_second_byte(line, at))
        return ERROR_UNKNOWN_REGISTER;
    if (at->access != CDS_ACCESS_RW || at->address == CDS_REG_ID ||
        at->address == CDS_REG_BAUD_RATE)
        return ERROR_NOT_WRITABLE;
    error =
        number_register(&line->number[0], cds_units_of(&cds_profile_cds55xx, at->address), &raw);
    if (error)
        return error;
    if (raw < at->lowest || raw > at->highest)
        return ERROR_OUT_OF_RANGE;
    data[0] = (uint8_t)raw;
    data[1] = (uint8_t)(raw >> 8);
    return 0;
}

/* In console->phase, beside SERVO_WRITE_SENT: the READ of angle limits to torque is under way. */
#define LOOKS     (SERVO_WRITE_SENT + 1)
#define LOOK_SIZE (CDS_REG_TORQUE_ENABLE - CDS_REG_CW_ANGLE_LIMIT + 1)

/* True if the servo is known to turn without end, with torque: with a limit it would move to its
 * old goal. */
static bool turns(const struct console *console)
{
    const struct cds_servo_state *servo = console_servo(console);

    return servo && servo->torque && cds_servo_is_endless(servo);
}

static bool is_angle_limit(uint8_t address)
{
    return address >= CDS_REG_CW_ANGLE_LIMIT && address <= CDS_REG_CCW_ANGLE_LIMIT;
}

/* The register that bounds the one at `address`: the other angle limit or voltage limit. 0: none.
 */
static uint8_t pair_of(uint8_t address)
{
    if (is_angle_limit(address))
        return (uint8_t)(CDS_REG_CW_ANGLE_LIMIT + CDS_REG_CCW_ANGLE_LIMIT - address);
    if (address == CDS_REG_MIN_VOLTAGE || address == CDS_REG_MAX_VOLTAGE)
        return (uint8_t)(CDS_REG_MIN_VOLTAGE + CDS_REG_MAX_VOLTAGE - address);
    return 0;
}

/* True if the value contradicts the register that bounds it, as the servo was read. Then
 * stores the register that bounds it in the job, for advice.c. */
static bool note_contradiction(struct console *console)
{
    struct set_job *job = set_job(console);
    uint8_t address = console->line.address, other = pair_of(address);
    uint8_t width = is_angle_limit(address) ? 2 : 1;
    const uint8_t *bytes = console->line.request->reply;
    uint16_t value = register_raw_at(job->data, width);
    uint16_t bound = register_raw_at(bytes + (other - CDS_REG_CW_ANGLE_LIMIT), width);

    if (width == 2 && (value == 0 || bound == 0))
        return false; // the mode changes, in two steps
    if (other > address ? value <= bound : value >= bound)
        return false;
    job->bound_at = other;
    job->bound = bound;
    return true;
}

static uint8_t read_limits(struct console *console)
{
    return servo_read(console, CDS_REG_CW_ANGLE_LIMIT, LOOK_SIZE);
}

static uint8_t set_begin(struct console *console)
{
    struct cds_register at;
    uint8_t *data = set_job(console)->data;
    uint8_t error = register_take_value(console, &at);

    if (error)
        return error;
    /* A cycle overwrites a goal: refused as by `move`. During a motion the bus refuses it (error
     * 14). */
    if (command_set.has_room && at.address >= CDS_REG_GOAL_POSITION &&
        at.address <= CDS_REG_MOVING_SPEED && !robot_is_in_motion(console->robot))
        error = servo_cycled(console);
    if (error)
        return error;
    if (is_angle_limit(at.address) && (data[0] | data[1]) && turns(console))
        return ERROR_ENDLESS;
    if (command_set.advise && pair_of(at.address)) {
        console->line.address = at.address;
        console->phase = LOOKS;
        return read_limits(console);
    }
    // With level 0 the servo answers no READ: this register is written without reading it first.
    if (at.area == CDS_AREA_EEPROM && at.address != CDS_REG_STATUS_RETURN_LEVEL)
        return setup_write(console, at.address, data, at.width);
    return servo_write(console, at.address, at.width);
}

/* Sets the voltage limit or the angle limit of the servo that was read. An angle limit not with
 * torque if it begins or ends an endless turn: the servo would move at once. Returns an error or 0.
 */
static uint8_t set_limit(struct console *console)
{
    const uint8_t *bytes = console->line.request->reply, *data = set_job(console)->data;
    bool is_angle = is_angle_limit(console->line.address);
    const uint8_t *own = bytes, *other = bytes + (CDS_REG_CCW_ANGLE_LIMIT - CDS_REG_CW_ANGLE_LIMIT);
    bool changes_mode;

    if (console->line.address == CDS_REG_CCW_ANGLE_LIMIT) {
        own = other;
        other = bytes;
    }
    changes_mode =
        (other[0] | other[1]) == 0 && ((own[0] | own[1]) == 0) != ((data[0] | data[1]) == 0);
    if (note_contradiction(console))
        return ERROR_OUT_OF_RANGE; // advice.c names the other register
    if (is_angle && bytes[LOOK_SIZE - 1] && changes_mode)
        return ERROR_ENDLESS;
    console->phase = console->part = 0;
    return setup_write(console, console->line.address, data, is_angle ? 2 : 1);
}

/* The status return level was written: compares it. At level 0 no servo answers a READ. */
static uint8_t verify_level(struct console *console)
{
    struct set_job *job = set_job(console);
    uint8_t error;

    console->phase = 0;
    error = setup_write(console, CDS_REG_STATUS_RETURN_LEVEL, job->data, 1);
    job->setup.is_written = true; // by the WRITE before
    return error;
}

/* Goes on after the WRITE or the READ of set_begin(). False: the command has ended. */
static bool set_goes_on(struct console *console)
{
    if (console->phase == LOOKS) {
        console->error = set_limit(console);
        return console->error == 0;
    }
    if (console->line.address != CDS_REG_STATUS_RETURN_LEVEL)
        return false;
    if (set_job(console)->data[0] == 0) {
        printer_line(&console->printer, message_not_read);
        return false;
    }
    console->error = verify_level(console);
    return console->error == 0;
}

static bool set_poll(struct console *console)
{
    if (console->phase == 0)
        return setup_poll(console);
    if (console_waits(console))
        return true;
    if (command_set.advise && console->phase == LOOKS &&
        setup_has_try(console, console->line.request->result, console->line.request->error)) {
        console->error = read_limits(console);
        return console->error == 0;
    }
    return command_set.advise && console_answered(console) && set_goes_on(console);
}

/* ---- info ---- */

static uint8_t info_begin(struct console *console)
{
    return servo_read(console, 0, CDS_TABLE_SIZE);
}

/* "servo 3: " before each line of a list of servos but the first, which the console has labelled.
 * printer_text() may only end the output; here the register follows. */
ALWAYS_INLINE void print_servo_of_list(struct console *console)
{
    if (!command_set.lists || !console->line.is_repeated || console->index == 0)
        return;
    reply_print_servo(&console->printer, console->line.id);
    printer_flash(&console->printer, message_colon);
}

/* "0x1E GOAL_POSITION = 150.147deg (512) RAM" */
static bool info_poll(struct console *console)
{
    uint8_t *address = &console->index;
    struct cds_register at;

    if (console_waits(console))
        return true;
    if (!console_answered(console) || !cds_register_at(*address, &at))
        return false;
    print_servo_of_list(console);
    printer_address(&console->printer, at.address);
    printer_char(&console->printer, ' ');
    register_print(&console->printer, at.address,
                   register_raw_at(console->line.request->reply + at.address, at.width));
    printer_line(&console->printer,
                 at.area == CDS_AREA_EEPROM ? message_in_eeprom : message_in_ram);
    *address = (uint8_t)(at.address + at.width);
    return *address < CDS_TABLE_SIZE;
}

static const CDS_FLASH struct command register_rows[] = {
    {
        .usage = FLASH_TEXT("get ID REG"),
        .what = FLASH_TEXT("a register, with its unit"),
        .details = COMMAND_DETAILS(
            "REG: its name or address, as info shows them. In brackets: the register value"),
        .example = COMMAND_DETAILS("get 1 PRESENT_VOLTAGE"),
        .begin = get_begin,
        .poll = get_poll,
    },
    {
        .usage = FLASH_TEXT("set ID REG VALUE"),
        .what = FLASH_TEXT("set a register"),
        .details =
            COMMAND_DETAILS("VALUE in the unit that get shows, another of its kind (mdeg, mV), "
                            "or raw. ID and BAUD_RATE: use id and baud. EEPROM is written if "
                            "it differs"),
        .example = COMMAND_DETAILS("set 1 MIN_VOLTAGE 6.5V"),
        .begin = set_begin,
        .poll = set_poll,
    },
    {
        .usage = FLASH_TEXT("info ID"),
        .what = FLASH_TEXT("all registers of a servo"),
        .details = COMMAND_DETAILS("Address, name, value with unit, register value, area"),
        .example = COMMAND_DETAILS("info 1"),
        .begin = info_begin,
        .poll = info_poll,
    },
};

const CDS_FLASH struct command_group register_commands = {
    .rows = register_rows,
    .count = sizeof register_rows / sizeof register_rows[0],
};
