/* SPDX-License-Identifier: MIT */
#include "script/reset_injection.h"

#include <string.h>

#include "script/lexer.h"

/* --- reading --- */

static bool parse_cause(struct reset_order *order, const char *word)
{
    static const char *const names[MACHINE_RESETS] = {
        [MACHINE_POWER_ON] = "power",
        [MACHINE_EXTERNAL] = "external",
        [MACHINE_BROWN_OUT] = "brown-out",
        [MACHINE_WATCHDOG] = "watchdog",
    };
    for (unsigned i = 0; i < MACHINE_RESETS; i++) {
        if (strcmp(names[i], word) == 0) {
            order->cause = (enum machine_reset)i;
            return true;
        }
    }
    return false;
}

static bool parse_in(struct reset_order *order, const char *word)
{
    int32_t us = 0;
    bool good = lexer_decimal(word, 1000, 0, INT32_MAX, &us);
    order->us = (uint32_t)us;
    return good;
}

static bool parse_write(struct reset_order *order, const char *number, const char *percent)
{
    int32_t writes = 0;
    int32_t part = 0;
    bool good = lexer_number(number, 1, 1000000, &writes) && lexer_number(percent, 0, 100, &part);
    order->writes = (uint32_t)writes;
    order->percent = (uint32_t)part;
    return good;
}

const char *reset_order_parse(struct reset_order *order, char *text)
{
    char *word[5];
    unsigned count = lexer_split(text, word, 5);
    bool good = count >= 1 && parse_cause(order, word[0]);
    if (good && count == 3 && strcmp(word[1], "in") == 0) {
        good = parse_in(order, word[2]);
    } else if (good && count == 4 && strcmp(word[1], "write") == 0) {
        good = parse_write(order, word[2], word[3]);
    } else {
        good = good && count == 1;
    }
    return good ? 0 : "wanted: power|external|brown-out|watchdog [in MS | write N PERCENT]";
}

const char *hang_order_parse(struct reset_order *order, char *text)
{
    char *word[2];
    unsigned count = lexer_split(text, word, 2);
    order->hang = true;
    bool good =
        count == 0 || (count == 2 && strcmp(word[0], "in") == 0 && parse_in(order, word[1]));
    return good ? 0 : "wanted: nothing, or: in MS";
}

/* --- doing --- */

static void execute(void *context, uint64_t now)
{
    (void)now;
    struct reset_injection *injection = context;
    if (injection->order.hang) {
        machine_hang(injection->machine);
    } else {
        machine_reset(injection->machine, injection->order.cause);
    }
}

static void eeprom_write_begins(void *context, uint64_t start, uint64_t cycles)
{
    struct reset_injection *injection = context;
    if (injection->order.writes && --injection->order.writes == 0) {
        schedule_at(injection->machine->schedule, &injection->event,
                    start + cycles * injection->order.percent / 100);
    }
}

void reset_injection_init(struct reset_injection *injection, struct machine *machine)
{
    *injection = (struct reset_injection){.machine = machine};
    event_init(&injection->event, execute, injection);
    machine->eeprom.context = injection;
    machine->eeprom.on_write = eeprom_write_begins;
}

void reset_injection_order(struct reset_injection *injection, uint64_t now,
                           const struct reset_order *order)
{
    struct schedule *schedule = injection->machine->schedule;
    injection->order = *order;
    schedule_cancel(schedule, &injection->event);
    if (!order->writes) {
        schedule_at(schedule, &injection->event,
                    now + (uint64_t)order->us * injection->machine->avr->frequency / 1000000u);
    }
}
