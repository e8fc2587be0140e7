/* SPDX-License-Identifier: MIT */
/* monitor with a table that stays in place on a terminal, and absent servos. */
#include "cds55xx/port.h" // cds_port_now_us()
#include "console/commands/command_groups.h"
#include "console/commands/monitor.h"
#include "console/messages.h"
#include "console/number_format.h"
#include "console/reply.h"

/* Sequences of ANSI X3.64 that every terminal obeys. */
static const CDS_FLASH char csi[] = "\x1B[";
static const CDS_FLASH char clear_rest_of_line[] = "\x1B[K";

/* Behind the number of rows: moves the cursor up by them, and clears all below it. */
static const CDS_FLASH char clear_table[] = "A\x1B[J";

static const CDS_FLASH char absent[] = "absent";

/* Moves the cursor by the rows of the old table that are below it, at least 1. */
static void move(struct printer *printer, const struct monitor *monitor, char direction)
{
    printer_flash(printer, csi);
    printer_decimal(printer, monitor->below);
    printer_char(printer, direction);
}

/* Prints the next lines below the table. */
static void leave(struct printer *printer, const struct monitor *monitor)
{
    if (monitor->below == 0)
        return;
    move(printer, monitor, 'B');
    printer_char(printer, '\r');
    printer->within = false;
}

/* Goes back to the first row before a table is printed over the last one, then prints "servo 1:" */
static void begin_row(struct printer *printer, struct monitor *monitor)
{
    if (monitor->index == 0 && monitor->lines && !(command_set.unasked && monitor->is_cleared)) {
        monitor->below = monitor->count;
        move(printer, monitor, 'A');
    }
    if (command_set.unasked)
        monitor->is_cleared = false;
    reply_print_servo(printer, monitor->ids[monitor->index]);
    printer_char(printer, ':');
}

static void end_row(struct printer *printer, struct monitor *monitor)
{
    if (monitor->below)
        monitor->below--;
    printer_flash(printer, clear_rest_of_line);
    printer_end_of_line(printer);
}

/* ",3:absent" */
static void print_absent_in_line(struct printer *printer, struct monitor *monitor)
{
    if (monitor->begun)
        printer_char(printer, ',');
    monitor->begun = true;
    printer_decimal(printer, monitor->ids[monitor->index]);
    printer_char(printer, ':');
    printer_flash(printer, absent);
}

/* "servo 1: 150.147deg 0rpm 0% 12V 32C", one value in each call */
void monitor_table(struct console *console, uint8_t value)
{
    struct printer *printer = &console->printer;
    struct monitor *monitor = monitor_job(console);
    uint8_t unit;

    if (value == MONITOR_LEAVE) {
        leave(printer, monitor);
        return;
    }
    if (!monitor->is_table) {
        print_absent_in_line(printer, monitor);
        return;
    }
    if (value == 0 || value == MONITOR_ABSENT)
        begin_row(printer, monitor);
    printer_char(printer, ' ');
    if (value == MONITOR_ABSENT) {
        printer_flash(printer, absent);
    } else {
        uint16_t raw = monitor_value(console, value, &unit);

        number_print(printer, (enum cds_unit)unit, raw);
    }
    if (value >= MONITOR_VALUES - 1)
        end_row(printer, monitor);
}

bool monitor_report(struct console *console)
{
    return monitor_job(console)->is_table && console_is_for_person(console) &&
           command_set.report(console);
}

void monitor_clear_table(struct console *console)
{
    struct monitor *monitor = monitor_job(console);
    struct printer *printer = &console->printer;

    if (console->line.command->poll != monitor_poll || !monitor->is_table || console->phase ||
        monitor->lines == 0 || monitor->is_cleared)
        return;
    printer_flash(printer, csi);
    printer_decimal(printer, monitor->count);
    printer_flash(printer, clear_table);
    monitor->is_cleared = true;
    monitor->next_us = cds_port_now_us();
}

/* A program that reads replies has the echo off, and gets lines. */
static uint8_t begin(struct console *console)
{
    bool as_plot = *console->line.usage == '\0'; // the end of the row was reached

    monitor_job(console)->is_table = console->failsafe->settings->echo && !as_plot;
    return monitor_begin(console);
}

static const CDS_FLASH struct command monitor_table_rows[] = {
    {
        .usage = FLASH_TEXT("monitor ID... [every MS [as plot]]"),
        .what = FLASH_TEXT("feedback until a key"),
        .details = COMMAND_DETAILS("Up to 8 servos; MS: 10 to 60000ms, default 100. With echo a "
                                   "table in place; else, and as plot, a line each period"),
        .example = COMMAND_DETAILS("monitor 1 2 every 50ms"),
        .begin = begin,
        .poll = monitor_poll,
    },
    {
        .usage = FLASH_TEXT("monitor ID... as plot [every MS]"),
        .what = FLASH_TEXT("a line of feedback each period until a key"),
        .details = COMMAND_DETAILS("For serial plotters: 1deg:150.147,1rpm:0,... Absent: 3:absent"),
        .example = COMMAND_DETAILS("monitor 1 2 as plot"),
        .begin = monitor_begin, // the job is zero: no table
        .poll = monitor_poll,
    },
};

const CDS_FLASH struct command_group monitor_table_commands = {
    .rows = monitor_table_rows,
    .count = sizeof monitor_table_rows / sizeof monitor_table_rows[0],
};
