/* SPDX-License-Identifier: MIT */
/* Values of settings with a unit: read and printed as registers are. */
#include "console/commands/shared.h"
#include "console/console.h"
#include "console/errors.h"
#include "console/number_format.h"
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

enum setting_time setting_time(uint8_t setting)
{
    switch (*settings_table[setting].unit) {
    case 'm': return SETTING_IN_MS;
    case 'u': return SETTING_IN_US;
    case '2': return SETTING_IN_2_US;
    default: return SETTING_IS_NO_TIME;
    }
}

static uint8_t time_of_setting(struct console *console, const struct number *number)
{
    uint32_t ms = 0;
    uint8_t error;

    switch (setting_time(console->line.setting)) {
    case SETTING_IN_MS:
        error = number_ms(number, UINT16_MAX, &ms);
        if (error == 0)
            console->raw = (uint16_t)ms;
        return error;
    case SETTING_IN_US: return number_us(number, UINT16_MAX, &console->raw);
    case SETTING_IN_2_US: return console_number(console, 0, CDS_UNIT_US);
    default: return ERROR_UNIT;
    }
}

uint8_t setting_number(struct console *console)
{
    const struct number *number = &console->line.number[0];

    if (number->kind == NUMBER_TIME)
        return time_of_setting(console, number);
    return console_number(console, 0,
                          setting_is_rate(&console->line) ? CDS_UNIT_BPS : CDS_UNIT_NUMBER);
}

bool setting_print(struct console *console, uint8_t index)
{
    struct printer *printer = &console->printer;
    uint16_t value = settings_get(console->failsafe->settings, index);
    char unit = *settings_table[index].unit;
    bool is_rate = unit == 'r' && value <= CDS_BAUD_MAX; // 255: the board's own

    if (!is_rate && unit != '2')
        return false;
    number_print(printer, is_rate ? CDS_UNIT_BPS : CDS_UNIT_US, value);
    printer_char(printer, ' ');
    printer_char(printer, '(');
    printer_decimal(printer, value);
    printer_char(printer, ')');
    printer_end_of_line(printer);
    return true;
}
