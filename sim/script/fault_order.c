/* SPDX-License-Identifier: MIT */
#include "script/fault_order.h"

#include <ctype.h>
#include <stddef.h>
#include <string.h>

#include "script/lexer.h"

#define WORDS_MAX   6
#define CHOICES_MAX 4
#define US_MAX      10000000
#define MS_MAX      3600000
#define BYTE_MAX    258 // position in a reply of 257 bytes, or after its end
#define FLIPS_MAX   1000000

enum word {
    NONE,
    DIRECTION,       // in or out
    IN,              // in
    OUT,             // out
    PACKET,          // a number from 1, or every
    IDS,             // a list of IDs
    CHOICE,          // one of the verb's words
    CHOICE_OR_BYTE,  // one of the verb's words, or a number: then the choice after the last word
    NUMBER,          // 0 to the limit of its place
    OPTIONAL_NUMBER, // a number that may be missing
};

// clang-format off
static const struct {
    const char *name;
    const char *usage; // printed if anything is wrong
    enum word word[WORDS_MAX];
    const char *choice[CHOICES_MAX];
    int32_t limit[FAULT_NUMBERS];
} verbs[FAULT_VERBS] = {
    [FAULT_FLIP] = {"flip", "flip in|out PACKET BYTE BIT [BIT]: bits are 0 (start) to 9 (stop)",
                    {DIRECTION, PACKET, NUMBER, NUMBER, OPTIONAL_NUMBER}, {0}, {BYTE_MAX, 9, 9}},
    [FAULT_LOSE] = {"lose", "lose in|out PACKET BYTE",
                    {DIRECTION, PACKET, NUMBER}, {0}, {BYTE_MAX}},
    [FAULT_INSERT] = {"insert", "insert out PACKET BYTE VALUE",
                      {OUT, PACKET, NUMBER, NUMBER}, {0}, {BYTE_MAX, 255}},
    [FAULT_CUT] = {"cut", "cut out PACKET BYTES [MS]: an hour at most",
                   {OUT, PACKET, NUMBER, OPTIONAL_NUMBER}, {0}, {BYTE_MAX, MS_MAX}},
    [FAULT_DELAY] = {"delay", "delay out PACKET US: 10 s at most",
                     {OUT, PACKET, NUMBER}, {0}, {US_MAX}},
    [FAULT_ID] = {"id", "id out PACKET ID", {OUT, PACKET, NUMBER}, {0}, {255}},
    [FAULT_LENGTH] = {"length", "length out PACKET VALUE", {OUT, PACKET, NUMBER}, {0}, {255}},
    [FAULT_ECHO] = {"echo", "echo on|off", {CHOICE}, {"off", "on"}, {0}},
    [FAULT_BABBLE] = {"babble", "babble off|headers|random|VALUE",
                      {CHOICE_OR_BYTE}, {"off", "headers", "random"}, {255}},
    [FAULT_STUCK] = {"stuck", "stuck low|high|off [MS]: an hour at most",
                     {CHOICE, OPTIONAL_NUMBER}, {"off", "low", "high"}, {MS_MAX}},
    [FAULT_NOISE] = {"noise", "noise FLIPS_PER_SECOND: a million at most, 0 is off",
                     {NUMBER}, {0}, {FLIPS_MAX}},
    [FAULT_BROWNOUT] = {"brownout", "brownout IDS MS: an hour at most",
                        {IDS, NUMBER}, {0}, {MS_MAX}},
    [FAULT_UNPLUG] = {"unplug", "unplug in PACKET BYTE IDS MS: an hour at most",
                      {IN, PACKET, NUMBER, IDS, NUMBER}, {0}, {BYTE_MAX, MS_MAX}},
    [FAULT_TURNAROUND] = {"turnaround", "turnaround IDS US: 10 s at most",
                          {IDS, NUMBER}, {0}, {US_MAX}},
    [FAULT_BAUD] = {"baud", "baud IDS REGISTER: 0 to 254", {IDS, NUMBER}, {0}, {254}},
    [FAULT_QUIRK] = {"quirk", "quirk IDS silent_after_power_up|sync_write_limit|"
                     "extra_turnaround_us|jitter_us VALUE",
                     {IDS, CHOICE, NUMBER},
                     {"silent_after_power_up", "sync_write_limit", "extra_turnaround_us",
                      "jitter_us"},
                     {UINT16_MAX}},
    [FAULT_CLEAR] = {"clear", "clear", {NONE}, {0}, {0}},
};
// clang-format on

static bool parse_choice(struct fault_order *order, const char *text)
{
    const char *const *choice = verbs[order->verb].choice;
    unsigned i = 0;
    while (i < CHOICES_MAX && choice[i] && strcmp(text, choice[i]) != 0) {
        i++;
    }
    order->choice = i; // the index after the last word means: none of them
    return i < CHOICES_MAX && choice[i];
}

static bool parse_number(struct fault_order *order, const char *text)
{
    int32_t value = 0;
    bool good = lexer_number(text, 0, verbs[order->verb].limit[order->numbers], &value);
    order->number[order->numbers++] = (uint32_t)value;
    return good;
}

static bool parse_packet(struct fault_order *order, const char *text)
{
    int32_t value = 0;
    order->every = strcmp(text, "every") == 0;
    bool good = order->every || lexer_number(text, 1, INT32_MAX, &value);
    order->packet = (uint32_t)value;
    return good;
}

static bool parse_direction(struct fault_order *order, const char *text)
{
    order->from_servo = strcmp(text, "out") == 0;
    return order->from_servo || strcmp(text, "in") == 0;
}

static bool parse_word(struct fault_order *order, enum word word, const char *text)
{
    switch (word) {
    case NONE: return false;
    case DIRECTION: return parse_direction(order, text);
    case IN: return parse_direction(order, text) && !order->from_servo;
    case OUT: return parse_direction(order, text) && order->from_servo;
    case PACKET: return parse_packet(order, text);
    case IDS: return !ids_parse_set(text, order->ids);
    case CHOICE: return parse_choice(order, text);
    case CHOICE_OR_BYTE: return parse_choice(order, text) || parse_number(order, text);
    case NUMBER:
    case OPTIONAL_NUMBER: return parse_number(order, text);
    }
    return false;
}

static bool parse_words(struct fault_order *order, char *word[], unsigned count)
{
    const enum word *usage = verbs[order->verb].word;
    unsigned i = 0;
    for (; i < count; i++) {
        if (i == WORDS_MAX || !parse_word(order, usage[i], word[i])) {
            return false;
        }
    }
    return i == WORDS_MAX || usage[i] == NONE || usage[i] == OPTIONAL_NUMBER;
}

static bool names_bus(const char *text)
{
    return isdigit((unsigned char)text[0]) && text[1] == ':';
}

unsigned fault_order_bus(const char *text)
{
    return names_bus(text) ? (unsigned)(text[0] - '0') : 0;
}

const char *fault_order_parse(struct fault_order *order, const char *text)
{
    char line[FAULT_TEXT_MAX + 1];
    char *word[WORDS_MAX + 1];
    *order = (struct fault_order){0};
    if (strlen(text) > FAULT_TEXT_MAX) {
        return "a fault has 1200 characters at most";
    }
    strcpy(line, names_bus(text) ? text + 2 : text);
    unsigned count = lexer_split(line, word, WORDS_MAX + 1);
    for (order->verb = 0; count && order->verb < FAULT_VERBS; order->verb++) {
        if (strcmp(word[0], verbs[order->verb].name) == 0) {
            bool good = parse_words(order, word + 1, count - 1);
            return good ? 0 : verbs[order->verb].usage;
        }
    }
    return "a fault is wanted: flip lose insert cut delay id length echo babble stuck noise "
           "brownout unplug turnaround baud quirk clear";
}

const char *fault_verb_name(enum fault_verb verb)
{
    return verbs[verb].name;
}
