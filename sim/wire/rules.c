/* SPDX-License-Identifier: MIT */
#include "wire/rules.h"

#include <inttypes.h>
#include <stdarg.h>

#define PRINTED_MAX 3 // further breaches of one rule are counted, not printed

static const struct {
    const char *name;
    const char *meaning;
    bool fatal; // a rule of the run: --rules warn does not apply
} rule_table[RULE_COUNT] = {
    [RULE_EARLY_RELEASE] = {"early-release",
                            "the driver let go before the last stop bit of a byte had ended"},
    [RULE_TWO_DRIVERS] = {"two-drivers", "controller and servo drove the wire at the same time"},
    [RULE_COLLISION] = {"collision", "two servos drove the wire at the same time"},
    [RULE_BOTH_ENABLES] = {"both-enables", "TX enable and RX enable were on together"},
    [RULE_DRIVER_OFF] = {"driver-off", "a byte was shifted out while the TX enable was off"},
    [RULE_TRANSMITTER_OFF] = {"transmitter-off", "a byte was written to UDR while TXEN was off"},
    [RULE_REPLY_LOST] = {"reply-lost",
                         "a servo talked while the way to the receiver (RX enable, RXEN) was shut"},
    [RULE_OVERRUN] =
        {"overrun", "the receiver lost a byte because the firmware had not read the earlier ones"},
    [RULE_FLOATING_RXD] = {"floating-rxd",
                           "RXD floated: RX enable was off and the AVR's pull-up too"},
    [RULE_FLOATING_TXD] = {"floating-txd",
                           "nothing drove TXD while the TX enable was on, or an adapter heard it"},
    [RULE_TXD_OUTPUT] = {"txd-output",
                         "TXD, tied to the wire, was an output of the port: it held the wire"},
    [RULE_LOST_WRITE] = {"lost-write", "UDR was written while it was full (UDRE off)"},
    [RULE_FRAME_FORMAT] = {"frame-format", "a byte was sent in another format than 8N1"},
    [RULE_CRASH] = {"crash", "the firmware went where there is no code", true},
    [RULE_BAD_ADDRESS] = {"bad-address", "the firmware used an address beyond the RAM of the chip",
                          true},
    [RULE_REPLY_WAS_ERROR] = {"reply-was-error", "the firmware answered a command with an error",
                              true},
    [RULE_REPLY_WAS_OK] = {"reply-was-ok", "the script expected an error, the firmware said ok",
                           true},
    [RULE_EXPECTATION] = {"expectation", "something that the script expected did not happen", true},
    [RULE_SCRIPT_UNFINISHED] = {"script-unfinished", "the run ended before the script did", true},
};

void rules_init(struct rules *rules, uint32_t clock_Hz, FILE *out)
{
    *rules = (struct rules){.clock_Hz = clock_Hz, .out = out};
}

void rules_init_bus(struct rules *rules, struct rules *aggregate, const char *where)
{
    *rules = (struct rules){.aggregate = aggregate, .where = where};
}

/* True if a real bus has such breaches, too, while several servos answer a search. */
static bool is_of_searches(enum rule rule)
{
    return rule == RULE_COLLISION || rule == RULE_TWO_DRIVERS || rule == RULE_REPLY_LOST;
}

void rules_record_breach(struct rules *rules, enum rule rule, uint64_t now, const char *format, ...)
{
    const char *where = rules->where ? rules->where : "";
    if (rules->on_breach) {
        rules->on_breach(rules->context, rule, now);
    }
    rules = rules->aggregate ? rules->aggregate : rules;
    rules->breaches[rule]++;
    if (!rules->out || rules->breaches[rule] > PRINTED_MAX) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    if (rules->line_is_open) {
        fputc('\n', rules->out);
        rules->line_is_open = false;
    }
    fprintf(rules->out, "rule broken at %" PRIu64 " (%.3f ms): %s%s: ", now,
            (double)now * 1000.0 / rules->clock_Hz, where, rule_name(rule));
    vfprintf(rules->out, format, arguments);
    fputs(
        is_of_searches(rule)
            ? "; harmless only while 'diagnose', 'new', 'ping 254' or a scan at other rates runs\n"
            : "\n",
        rules->out);
    va_end(arguments);
}

uint32_t rules_broken(const struct rules *rules)
{
    uint32_t sum = 0;
    for (int i = 0; i < RULE_COUNT; i++) {
        sum += rules->breaches[i];
    }
    return sum;
}

bool rules_failed(const struct rules *rules)
{
    bool failed = false;
    for (int i = 0; i < RULE_COUNT; i++) {
        failed = failed || (rules->breaches[i] && (rule_table[i].fatal || !rules->warn));
    }
    return failed;
}

const char *rule_name(enum rule rule)
{
    return rule_table[rule].name;
}

void rules_report(const struct rules *rules, FILE *out)
{
    if (!rules_broken(rules)) {
        fputs("rules:   none broken\n", out);
        return;
    }
    for (enum rule rule = 0; rule < RULE_COUNT; rule++) {
        if (rules->breaches[rule]) {
            bool warning = rules->warn && !rule_table[rule].fatal;
            fprintf(out, "%s %s, %" PRIu32 " times: %s\n",
                    warning ? "WARNING:" : "BROKEN: ", rule_name(rule), rules->breaches[rule],
                    rule_table[rule].meaning);
        }
    }
}
