/* SPDX-License-Identifier: MIT */
/* Values of settings with a unit. */
#include "console/commands/shared.h"
#include "console/console.h"
#include "console/errors.h"
#include "robot/settings.h" // settings_table

/* A bare number from 256 on is bit/s: a baud register is one byte. */
#define LEAST_BPS 256

bool setting_is_rate(const struct command_line *line)
{
    static const CDS_FLASH char rate[] = "register";
    const struct number *number = &line->number[0];

    return parse_has_name(settings_table[line->setting].unit, rate) &&
           (number->kind == NUMBER_RATE ||
            (number->kind == NUMBER_BARE && number->digits >= LEAST_BPS));
}

/* Stores number 0, a time, in console->raw. `unit`: the first letter of the setting's unit in
 * settings_table: ms, us, or x 2us of a return delay. Returns an error or 0. */
static uint8_t take_time(struct console *console, char unit)
{
    uint32_t time = 0;
    uint8_t error = ERROR_UNIT;

    if (unit == 'x')
        return console_number(console, 0, CDS_UNIT_US);
    if (unit == 'm')
        error = number_ms(&console->line.number[0], UINT16_MAX, &time);
    if (unit == 'u')
        error = number_us(&console->line.number[0], UINT16_MAX, &time);
    console->raw = (uint16_t)time;
    return error;
}

uint8_t setting_number(struct console *console)
{
    if (console->line.number[0].kind == NUMBER_TIME)
        return take_time(console, *settings_table[console->line.setting].unit);
    return console_number(console, 0,
                          setting_is_rate(&console->line) ? CDS_UNIT_BPS : CDS_UNIT_NUMBER);
}
