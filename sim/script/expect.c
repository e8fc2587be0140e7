/* SPDX-License-Identifier: MIT */
#include "script/expect.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "script/lexer.h"

#define MS_MAX            3600000
#define EXPECT_VALUE_SIZE 32
#define POSITION_MAX      1023

/* --- reading --- */

static const char *parse_packet(struct expectation *e, char *words)
{
    static const char wanted[] =
        "wanted: packet in|out and bytes in hexadecimal, .. for any, FF! with a framing error";
    e->text = lexer_rest(words);
    e->in = strcmp(words, "in") == 0;
    const char *at = e->text;
    struct lexer_byte byte;
    while (lexer_byte(&at, &byte)) {
    }
    return (e->in || strcmp(words, "out") == 0) && *e->text && !*at ? 0 : wanted;
}

static const char *parse_silence(struct expectation *e, char *words)
{
    int32_t ms = 0;
    if (!lexer_number(words, 1, MS_MAX, &ms)) {
        return "wanted: silence and milliseconds, 1 to 3600000 (an hour), without unit";
    }
    e->ms = (uint32_t)ms;
    return 0;
}

static const char *parse_text(struct expectation *e, char *words)
{
    e->text = words;
    return *words ? 0 : "wanted: text and what the reply contains";
}

static const char *parse_rule(struct expectation *e, char *words)
{
    for (e->rule = 0; e->rule < RULE_COUNT; e->rule++) {
        if (strcmp(rule_name(e->rule), words) == 0) {
            return 0;
        }
    }
    return "wanted: the name of a rule of the wire, as in collision (docs/simulator.md)";
}

/* off, on and blinking are 0, 1 and 2, as in enum servo_lamp. */
static const char *const states[] = {"off", "on", "blinking"};

static bool parse_value(const char *text, int32_t *value)
{
    for (int32_t i = 0; i < 3; i++) {
        if (strcmp(text, states[i]) == 0) {
            *value = i;
            return true;
        }
    }
    return lexer_number(text, 0, UINT16_MAX, value);
}

static bool parse_range(struct expectation *e, char *text)
{
    char *range = strstr(text, "..");
    if (range) {
        *range = 0;
    }
    return parse_value(text, &e->lowest) && parse_value(range ? range + 2 : text, &e->highest) &&
           e->lowest <= e->highest;
}

static bool parse_subject(struct expectation *e, const char *word)
{
    static const char *const subjects[] = {
        [EXPECT_TORQUE] = "torque", [EXPECT_LED] = "led", [EXPECT_ERROR] = "error"};
    for (e->subject = EXPECT_TORQUE; e->subject <= EXPECT_ERROR; e->subject++) {
        if (strcmp(subjects[e->subject], word) == 0) {
            return true;
        }
    }
    e->subject = EXPECT_REGISTER;
    const struct table_row *row = table_find(word);
    int32_t address = row ? row->address : 0;
    e->width = row ? row->width : 1;
    bool good = row || lexer_number(word, 0, TABLE_REGISTERS - 1, &address);
    e->address = (uint8_t)address;
    return good;
}

/* Returns what is wrong if the servo can never have a value of the range, or 0. */
static const char *check_range(const struct expectation *e)
{
    bool is_position = e->subject == EXPECT_REGISTER &&
                       (e->address == TABLE_GOAL_POSITION || e->address == TABLE_PRESENT_POSITION);
    if (e->subject == EXPECT_TORQUE) {
        return e->highest <= 1 ? 0 : "torque is on or off";
    }
    if (e->subject == EXPECT_LED) {
        return e->highest <= 2 ? 0 : "led is on, off or blinking";
    }
    if (is_position && e->width == 2) {
        return e->lowest <= POSITION_MAX ? 0 : "a position is 0 to 1023 (300 degrees)";
    }
    return e->width == 2 || e->lowest <= UINT8_MAX ? 0 : "the value of one byte is 0 to 255";
}

/* Parses IDS WHAT. */
static const char *parse_look(struct expectation *e, const char *list, const char *what)
{
    const char *wrong = ids_parse_set(list, e->ids);
    if (wrong) {
        return wrong;
    }
    e->text = what;
    return parse_subject(e, what)
               ? 0
               : "a register (docs/registers.md), an address, torque, led or error is wanted";
}

static const char *parse_servo(struct expectation *e, char *words)
{
    char *word[3];
    if (lexer_split(words, word, 3) != 3) {
        return "wanted: expect servo IDS WHAT VALUE, as in expect servo 1 PRESENT_POSITION "
               "500..524";
    }
    const char *wrong = parse_look(e, word[0], word[1]);
    if (wrong) {
        return wrong;
    }
    return parse_range(e, word[2]) ? check_range(e)
                                   : "a value from 0 on, LOW..HIGH, on, off or blinking is wanted";
}

const char *expect_parse_show(struct expectation *e, char *words)
{
    char *word[3];
    e->kind = EXPECT_SERVO;
    if (lexer_split(words, word, 3) != 3 || strcmp(word[0], "servo") != 0) {
        return "wanted: show servo IDS WHAT, as in show servo 1 PRESENT_POSITION";
    }
    return parse_look(e, word[1], word[2]);
}

const char *expect_parse(struct expectation *e, char *words)
{
    static const struct {
        const char *word;
        const char *(*parse)(struct expectation *e, char *words);
    } kinds[] = {
        [EXPECT_PACKET] = {"packet", parse_packet}, [EXPECT_SILENCE] = {"silence", parse_silence},
        [EXPECT_SERVO] = {"servo", parse_servo},    [EXPECT_TEXT] = {"text", parse_text},
        [EXPECT_RULE] = {"rule", parse_rule},
    };
    char *rest = lexer_rest(words);
    for (e->kind = EXPECT_PACKET; e->kind <= EXPECT_RULE; e->kind++) {
        if (strcmp(kinds[e->kind].word, words) != 0) {
            continue;
        }
        if (e->kind != EXPECT_SILENCE) {
            e->ms = EXPECT_WITHIN_MS;
            lexer_within(rest, MS_MAX, &e->ms);
        }
        return kinds[e->kind].parse(e, rest);
    }
    return "packet, silence, servo, text or rule is wanted behind @expect";
}

/* --- checking --- */

static bool packet_fits(const struct recorder_packet *packet, const char *text)
{
    struct lexer_byte byte;
    for (unsigned i = 0; i < packet->size; i++) {
        if (!lexer_byte(&text, &byte) || (!byte.any && (byte.byte != packet->bytes[i] ||
                                                        byte.framing_error != packet->bad[i]))) {
            return false;
        }
    }
    return !lexer_byte(&text, &byte);
}

static enum expect_result check_packet(const struct expectation *e,
                                       const struct expect_sources *sources, char *seen,
                                       size_t capacity)
{
    const struct recorder_packet *packet = recorder_next_packet(sources->recorder, e->in);
    if (!packet) {
        snprintf(seen, capacity, "no packet");
        return sources->recorder->packets == RECORDER_PACKETS ? EXPECT_FAILED : EXPECT_PENDING;
    }
    if (packet_fits(packet, e->text)) {
        recorder_take_packet(sources->recorder, e->in);
        return EXPECT_MET;
    }
    size_t size = 0;
    for (unsigned i = 0; i < packet->size && size + 5 < capacity; i++) {
        size += (size_t)snprintf(seen + size, capacity - size, i ? " %02X%s" : "%02X%s",
                                 packet->bytes[i], packet->bad[i] ? "!" : "");
    }
    return EXPECT_FAILED;
}

static enum expect_result check_silence(const struct expect_sources *sources, uint64_t now,
                                        char *seen, size_t capacity)
{
    if (!recorder_is_silent(sources->recorder, sources->edges)) {
        snprintf(seen, capacity, "the wire is not silent");
        return EXPECT_FAILED;
    }
    return now < sources->end ? EXPECT_PENDING : EXPECT_MET;
}

static int32_t look_at(const struct expectation *e, const struct servo *servo)
{
    switch (e->subject) {
    case EXPECT_TORQUE: return servo->powered && servo_torque(servo);
    case EXPECT_LED: return (int32_t)servo_lamp(servo);
    case EXPECT_ERROR: return servo_errors(servo);
    default: return table_get(servo->registers, e->address, e->width);
    }
}

/* Writes "torque off", "led blinking" or "512 (0x200)" to `seen`. */
static void tell_value(const struct expectation *e, int32_t value, char *seen, size_t capacity)
{
    if (e->subject == EXPECT_TORQUE || e->subject == EXPECT_LED) {
        snprintf(seen, capacity, "%s %s", e->text, states[value]);
    } else {
        snprintf(seen, capacity, "%" PRId32 " (0x%02" PRIX32 ")", value, (uint32_t)value);
    }
}

static enum expect_result check_servo(const struct expectation *e,
                                      const struct expect_sources *sources, char *seen,
                                      size_t capacity)
{
    const struct servos *servos;
    for (unsigned bus = 0; (servos = sources->bus(sources->context, bus)) != 0; bus++) {
        for (unsigned i = 0; i < servos->count; i++) {
            const struct servo_node *node = &servos->node[i];
            int32_t value = e->ids[node->id] ? look_at(e, &node->servo) : e->lowest;
            if (value < e->lowest || value > e->highest) {
                char what[EXPECT_VALUE_SIZE];
                tell_value(e, value, what, sizeof(what));
                snprintf(seen, capacity, "servo %u has %s", node->id, what);
                return EXPECT_PENDING;
            }
        }
    }
    return EXPECT_MET;
}

static enum expect_result check_text(const struct expectation *e,
                                     const struct expect_sources *sources, char *seen,
                                     size_t capacity)
{
    const char *reply = sources->recorder->reply;
    if (strstr(reply, e->text)) {
        return EXPECT_MET;
    }
    snprintf(seen, capacity, "%s", *reply ? reply : "no line of text");
    for (char *c = seen; *c; c++) {
        *c = *c != '\n' ? *c : c[1] ? '|' : 0;
    }
    return EXPECT_PENDING;
}

/* An expected breach is not counted. */
static enum expect_result check_rule(const struct expectation *e,
                                     const struct expect_sources *sources, char *seen,
                                     size_t capacity)
{
    snprintf(seen, capacity, "it was not broken");
    if (!sources->rules || !sources->rules->breaches[e->rule]) {
        return EXPECT_PENDING;
    }
    sources->rules->breaches[e->rule] = 0;
    return EXPECT_MET;
}

enum expect_result expect_check(const struct expectation *e, const struct expect_sources *sources,
                                uint64_t now, char *seen, size_t capacity)
{
    switch (e->kind) {
    case EXPECT_PACKET: return check_packet(e, sources, seen, capacity);
    case EXPECT_SILENCE: return check_silence(sources, now, seen, capacity);
    case EXPECT_SERVO: return check_servo(e, sources, seen, capacity);
    case EXPECT_TEXT: return check_text(e, sources, seen, capacity);
    default: return check_rule(e, sources, seen, capacity);
    }
}

void expect_show(const struct expectation *e, const struct expect_sources *sources, FILE *out)
{
    const struct servos *servos;
    for (unsigned bus = 0; (servos = sources->bus(sources->context, bus)) != 0; bus++) {
        for (unsigned i = 0; i < servos->count; i++) {
            const struct servo_node *node = &servos->node[i];
            int32_t value = look_at(e, &node->servo);
            if (!e->ids[node->id]) {
                continue;
            }
            if (e->subject == EXPECT_TORQUE || e->subject == EXPECT_LED) {
                fprintf(out, "servo %u %s %s\n", node->id, e->text, states[value]);
            } else {
                fprintf(out, "servo %u %s %" PRId32 "\n", node->id, e->text, value);
            }
        }
    }
}
