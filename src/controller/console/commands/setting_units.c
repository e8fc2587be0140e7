/* SPDX-License-Identifier: MIT */
/* Values of settings: with a unit, and what a value means. */
#include <stddef.h> // NULL

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

static const CDS_FLASH struct {
    uint8_t setting; // row of settings_table
    uint8_t value;
    const CDS_FLASH char *meaning;
} meanings[] = {
    {SETTINGS_AT_device_id, 254, FLASH_TEXT("off")},
    {SETTINGS_AT_repeats, 0, FLASH_TEXT("never")},
    {SETTINGS_AT_repeats, 1, FLASH_TEXT("once")},
    {SETTINGS_AT_repeats, 2, FLASH_TEXT("twice")},
    {SETTINGS_AT_echo, SETTINGS_ECHO_OFF, FLASH_TEXT("mode program")},
    {SETTINGS_AT_echo, SETTINGS_ECHO_ON, FLASH_TEXT("mode echo")},
    {SETTINGS_AT_echo, SETTINGS_ECHO_PERSON, FLASH_TEXT("mode person")},
    {SETTINGS_AT_link_loss_ms, 0, FLASH_TEXT("not watched")},
    {SETTINGS_AT_link_loss_action, 0, FLASH_TEXT("only show it")},
    {SETTINGS_AT_link_loss_action, 1, FLASH_TEXT("inhibit driving")},
    {SETTINGS_AT_link_loss_action, 2, FLASH_TEXT("inhibit driving, torque off")},
    {SETTINGS_AT_alarm_report, 0, FLASH_TEXT("only in mode person")},
    {SETTINGS_AT_alarm_report, 1, FLASH_TEXT("in each mode")},
};

const CDS_FLASH char *setting_meaning(uint8_t setting, uint16_t value)
{
    for (uint8_t i = 0; i < sizeof meanings / sizeof meanings[0]; i++)
        if (meanings[i].setting == setting && meanings[i].value == value)
            return meanings[i].meaning;
    return NULL;
}

uint8_t setting_number(struct console *console)
{
    if (console->line.number[0].kind == NUMBER_TIME)
        return take_time(console, *settings_table[console->line.setting].unit);
    return console_number(console, 0,
                          setting_is_rate(&console->line) ? CDS_UNIT_BPS : CDS_UNIT_NUMBER);
}
