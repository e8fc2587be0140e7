#include "script/reset_injection.h"

#include <string.h>

#include "script/lexer.h"

/* --- reading -------------------------------------------------------------------------------------
 */

static bool parse_cause(struct upset_order *order, const char *word)
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

static bool parse_in(struct upset_order *order, const char *word)
{
    int32_t us = 0;
    bool good = words_decimal(word, 1000, 0, INT32_MAX, &us);
    order->us = (uint32_t)us;
    return good;
}

static bool parse_write(struct upset_order *order, const char *number, const char *percent)
{
    int32_t writes = 0;
    int32_t part = 0;
    bool good = words_number(number, 1, 1000000, &writes) && words_number(percent, 0, 100, &part);
    order->writes = (uint32_t)writes;
    order->percent = (uint32_t)part;
    return good;
}

const char *upset_parse_reset(struct upset_order *order, char *text)
{
    char *word[5];
    unsigned count = words_split(text, word, 5);
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

const char *upset_parse_hang(struct upset_order *order, char *text)
{
    char *word[2];
    unsigned count = words_split(text, word, 2);
    order->hang = true;
    bool good =
        count == 0 || (count == 2 && strcmp(word[0], "in") == 0 && parse_in(order, word[1]));
    return good ? 0 : "wanted: nothing, or: in MS";
}

/* --- doing ---------------------------------------------------------------------------------------
 */

static void happen(void *owner, uint64_t now)
{
    (void)now;
    struct upset *upset = owner;
    if (upset->order.hang) {
        machine_hang(upset->machine);
    } else {
        machine_reset(upset->machine, upset->order.cause);
    }
}

static void writes(void *owner, uint64_t start, uint64_t cycles)
{
    struct upset *upset = owner;
    if (upset->order.writes && --upset->order.writes == 0) {
        schedule_at(upset->machine->schedule, &upset->event,
                    start + cycles * upset->order.percent / 100);
    }
}

void upset_init(struct upset *upset, struct machine *machine)
{
    *upset = (struct upset){.machine = machine};
    event_init(&upset->event, happen, upset);
    machine->eeprom.owner = upset;
    machine->eeprom.on_write = writes;
}

void upset_order(struct upset *upset, uint64_t now, const struct upset_order *order)
{
    struct schedule *schedule = upset->machine->schedule;
    upset->order = *order;
    schedule_cancel(schedule, &upset->event);
    if (!order->writes) {
        schedule_at(schedule, &upset->event,
                    now + (uint64_t)order->us * upset->machine->avr->frequency / 1000000u);
    }
}
