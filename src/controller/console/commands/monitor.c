/* SPDX-License-Identifier: MIT */
/* monitor: feedback as lines for a serial plotter: "1deg:150.147,1rpm:0,..." */
#include <stddef.h>
#include <string.h>

#include "cds55xx/port.h" // cds_port_now_us()
#include "console/commands/command_groups.h"
#include "console/commands/monitor.h"
#include "console/errors.h"
#include "console/messages.h"
#include "console/number_format.h"

static const CDS_FLASH char message_lines[] = "%u lines, %u answers missing";

#define PERIOD_MS 100

enum monitor_phase {
    PAUSE, // waits until the next line is due
    ASK,   // reads a servo
    TAKE,  // waits for its reply
    TELL,  // prints its values
    SUM_UP,
} __attribute__((packed));

uint8_t monitor_begin(struct console *console)
{
    struct monitor *monitor = monitor_job(console);
    const struct command_line *line = &console->line;
    uint8_t error;

    console->raw = PERIOD_MS;
    error = line->numbers ? console_ms(console) : 0;
    if (error)
        return error;
    if (console->raw < MONITOR_MS_MIN || console->raw > MONITOR_MS_MAX)
        return ERROR_OUT_OF_RANGE;
    if (line->values > MONITOR_SERVOS)
        return ERROR_TOO_MANY;
    memcpy(monitor->ids, line->request->packet.bytes, line->values);
    monitor->count = line->values;
    monitor->period_us = console->raw * 1000ul;
    monitor->next_us = cds_port_now_us();
    return 0;
}

/* Values of each servo, one in each call: a conversion takes 100 us. */
static const CDS_FLASH struct {
    char label[5];
    uint8_t unit;   // enum cds_unit
    uint8_t offset; // in struct cds_feedback, in bytes
    uint8_t bytes;
} values[] = {
    {"deg:", CDS_UNIT_MDEG, offsetof(struct cds_feedback, position), 2},
    {"rpm:", CDS_UNIT_SIGNED_MRPM, offsetof(struct cds_feedback, speed), 2},
    {"%:", CDS_UNIT_SIGNED_CPCT, offsetof(struct cds_feedback, load), 2},
    {"V:", CDS_UNIT_MV, offsetof(struct cds_feedback, voltage), 1},
    {"C:", CDS_UNIT_CELSIUS, offsetof(struct cds_feedback, temperature), 1},
};

_Static_assert(sizeof values / sizeof values[0] == MONITOR_VALUES, "each has a row");

uint16_t monitor_value(struct console *console, uint8_t value, uint8_t *unit)
{
    uint16_t raw = 0;

    memcpy(&raw, (const uint8_t *)&monitor_job(console)->feedback + values[value].offset,
           values[value].bytes); // low byte first, on an AVR and on the host
    *unit = values[value].unit;
    return raw;
}

/* "1deg:150.147", behind the first one with a comma before it */
static void print_value(struct console *console, uint8_t value)
{
    struct monitor *monitor = monitor_job(console);
    struct printer *printer = &console->printer;
    uint8_t unit;
    uint16_t raw = monitor_value(console, value, &unit);

    if (command_set.monitor && monitor->is_table) {
        command_set.monitor(console, value);
        return;
    }
    if (monitor->begun)
        printer_char(printer, ',');
    monitor->begun = true;
    printer_decimal(printer, monitor->ids[monitor->index]);
    printer_flash(printer, values[value].label);
    number_print_bare(printer, (enum cds_unit)unit, raw);
}

static void end_of_line(struct console *console)
{
    struct monitor *monitor = monitor_job(console);
    uint32_t now_us = cds_port_now_us();

    if (monitor->begun)
        printer_end_of_line(&console->printer);
    if (monitor->lines < UINT16_MAX)
        monitor->lines++;
    monitor->next_us += monitor->period_us;
    if ((int32_t)(now_us - monitor->next_us) > 0)
        monitor->next_us = now_us; // the line takes longer than the period
    monitor->begun = false;
    monitor->index = 0;
    console->phase = PAUSE;
}

static void next(struct console *console)
{
    struct monitor *monitor = monitor_job(console);

    monitor->index++;
    if (monitor->index < monitor->count)
        console->phase = ASK;
    else
        end_of_line(console);
}

/* True if a servo that fails ends the command: in the first line, and if it can be shown as absent,
 * only if no other servo has answered. */
static bool ends_command(const struct monitor *monitor)
{
    if (monitor->lines)
        return false;
    return command_set.monitor == NULL ||
           (!monitor->is_answered && monitor->index + 1 == monitor->count);
}

/* A servo that fails is shown as absent, or left out of the line. */
static void take(struct console *console)
{
    struct monitor *monitor = monitor_job(console);
    struct cds_feedback *feedback = &monitor->feedback;

    if (cds_feedback_take(feedback, console->line.request, cds_port_now_us()) == CDS_OK) {
        monitor->value = 0;
        if (command_set.monitor)
            monitor->is_answered = true;
        console->phase = TELL;
    } else if (ends_command(monitor)) {
        console->error = console->line.request->result;
        console->servo_error = feedback->error;
        if (command_set.explain) // the error names the servo
            console->line.id = monitor->ids[monitor->index];
        console->phase = SUM_UP;
    } else {
        if (monitor->failed < UINT16_MAX)
            monitor->failed++;
        if (command_set.monitor)
            command_set.monitor(console, MONITOR_ABSENT);
        next(console);
    }
}

/* "42 lines, 0 answers missing" */
static bool sum_up(struct console *console)
{
    struct monitor *monitor = monitor_job(console);

    if (console->printer.within) {
        printer_end_of_line(&console->printer);
        return true;
    }
    if (command_set.explain && console->line.request->result == CDS_LINE_BUSY)
        console->error = CDS_LINE_BUSY; // why the last answer is missing
    console->printer.values[0].number = monitor->lines;
    console->printer.values[1].number = monitor->failed;
    printer_line(&console->printer, message_lines);
    return false;
}

static void ask(struct console *console)
{
    struct monitor *monitor = monitor_job(console);
    enum cds_result result =
        cds_feedback_read(console->bus, console->line.request, monitor->ids[monitor->index]);

    console->error = (uint8_t)result;
    console->phase = result == CDS_OK ? TAKE : SUM_UP;
}

bool monitor_poll(struct console *console)
{
    struct monitor *monitor = monitor_job(console);

    if (console->phase == TAKE && console->line.request->result == CDS_PENDING)
        return true;
    if (console->phase == PAUSE && console_key(console)) // a begun line is printed to its end
        console->phase = SUM_UP;
    switch (console->phase) {
    case PAUSE:
        if (command_set.unasked && monitor_report(console))
            return true;
        if ((int32_t)(cds_port_now_us() - monitor->next_us) >= 0)
            console->phase = ASK;
        return true;
    case ASK: ask(console); return true;
    case TAKE: take(console); return true;
    case TELL:
        print_value(console, monitor->value++);
        if (monitor->value == MONITOR_VALUES)
            next(console);
        return true;
    default: return sum_up(console);
    }
}

static const CDS_FLASH struct command monitor_rows[] = {
    {
        .usage = FLASH_TEXT("monitor ID... [every MS]"),
        .what = FLASH_TEXT("feedback until a key"),
        .details = COMMAND_DETAILS("Up to 8 servos; MS: 10 to 60000ms, 100 if left out. One line "
                                   "each period, for serial plotters"),
        .example = COMMAND_DETAILS("monitor 1 2 every 50ms"),
        .begin = monitor_begin,
        .poll = monitor_poll,
    },
};

const CDS_FLASH struct command_group monitor_commands = {
    .rows = monitor_rows,
    .count = sizeof monitor_rows / sizeof monitor_rows[0],
};
