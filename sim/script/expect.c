#include "script/expect.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "script/lexer.h"

#define MS_MAX 3600000

/* --- reading -------------------------------------------------------------------------------------
 */

/* `within MS` at the end of the line. */
static void parse_within(struct expectation *e, char *words)
{
    char *within = 0;
    for (char *at = strstr(words, " within "); at; at = strstr(at + 1, " within ")) {
        within = at;
    }
    int32_t ms = EXPECT_WITHIN_MS;
    if (within && words_number(words_trim(within + strlen(" within ")), 0, MS_MAX, &ms)) {
        *within = 0;
        words_trim(words);
    }
    e->ms = (uint32_t)ms;
}

static const char *parse_packet(struct expectation *e, char *words)
{
    static const char wanted[] =
        "wanted: packet in|out and bytes in hexadecimal, .. for any, FF! with a framing error";
    e->text = words_rest(words);
    e->in = strcmp(words, "in") == 0;
    const char *at = e->text;
    struct words_byte byte;
    while (words_byte(&at, &byte)) {
    }
    return (e->in || strcmp(words, "out") == 0) && *e->text && !*at ? 0 : wanted;
}

static const char *parse_silence(struct expectation *e, char *words)
{
    int32_t ms = 0;
    if (!words_number(words, 1, MS_MAX, &ms)) {
        return "wanted: silence and milliseconds, an hour at most";
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
    return "wanted: the name of a rule of the wire";
}

/* off, on and blinking are 0, 1, 2: enum servo_lamp. */
static bool parse_value(const char *text, int32_t *value)
{
    static const char *const states[] = {"off", "on", "blinking"};
    for (int32_t i = 0; i < 3; i++) {
        if (strcmp(text, states[i]) == 0) {
            *value = i;
            return true;
        }
    }
    return words_number(text, 0, UINT16_MAX, value);
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
    bool good = row || words_number(word, 0, TABLE_REGISTERS - 1, &address);
    e->address = (uint8_t)address;
    return good;
}

/* IDS WHAT */
static const char *parse_look(struct expectation *e, const char *list, const char *what)
{
    uint8_t ids[IDS_MAX];
    unsigned count = 0;
    const char *wrong = ids_parse(list, true, ids, &count);
    if (wrong) {
        return wrong;
    }
    for (unsigned i = 0; i < count; i++) {
        e->ids[ids[i]] = true;
    }
    e->text = what;
    return parse_subject(e, what)
               ? 0
               : "a register (docs/registers.md), an address, torque, led or error is wanted";
}

static const char *parse_servo(struct expectation *e, char *words)
{
    char *word[3];
    if (words_split(words, word, 3) != 3) {
        return "wanted: servo, IDs, what to look at, VALUE or LOW..HIGH";
    }
    const char *wrong = parse_look(e, word[0], word[1]);
    if (wrong) {
        return wrong;
    }
    return parse_range(e, word[2]) ? 0
                                   : "a value from 0 on, LOW..HIGH, on, off or blinking is wanted";
}

const char *expect_parse_show(struct expectation *e, char *words)
{
    char *word[3];
    e->kind = EXPECT_SERVO;
    if (words_split(words, word, 3) != 3 || strcmp(word[0], "servo") != 0) {
        return "wanted: servo, IDs, what to look at";
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
    char *rest = words_rest(words);
    for (e->kind = EXPECT_PACKET; e->kind <= EXPECT_RULE; e->kind++) {
        if (strcmp(kinds[e->kind].word, words) != 0) {
            continue;
        }
        if (e->kind != EXPECT_SILENCE) {
            parse_within(e, rest);
        }
        return kinds[e->kind].parse(e, rest);
    }
    return "packet, silence, servo, text or rule is wanted behind @expect";
}

/* --- judging -------------------------------------------------------------------------------------
 */

static bool packet_fits(const struct witness_packet *packet, const char *text)
{
    struct words_byte byte;
    for (unsigned i = 0; i < packet->size; i++) {
        if (!words_byte(&text, &byte) || (!byte.any && (byte.byte != packet->bytes[i] ||
                                                        byte.framing_error != packet->bad[i]))) {
            return false;
        }
    }
    return !words_byte(&text, &byte);
}

static enum expect_verdict judge_packet(const struct expectation *e,
                                        const struct expect_scene *scene, char *seen, size_t room)
{
    const struct witness_packet *packet = witness_next(scene->witness, e->in);
    if (!packet) {
        snprintf(seen, room, "no packet");
        return scene->witness->packets == WITNESS_PACKETS ? EXPECT_NEVER : EXPECT_NOT_YET;
    }
    if (packet_fits(packet, e->text)) {
        witness_take(scene->witness, e->in);
        return EXPECT_MET;
    }
    size_t size = 0;
    for (unsigned i = 0; i < packet->size && size + 5 < room; i++) {
        size += (size_t)snprintf(seen + size, room - size, i ? " %02X%s" : "%02X%s",
                                 packet->bytes[i], packet->bad[i] ? "!" : "");
    }
    return EXPECT_NEVER;
}

static enum expect_verdict judge_silence(const struct expect_scene *scene, uint64_t now, char *seen,
                                         size_t room)
{
    if (!witness_silence(scene->witness, scene->edges)) {
        snprintf(seen, room, "the wire is not silent");
        return EXPECT_NEVER;
    }
    return now < scene->end ? EXPECT_NOT_YET : EXPECT_MET;
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

static enum expect_verdict judge_servo(const struct expectation *e,
                                       const struct expect_scene *scene, char *seen, size_t room)
{
    const struct servos *servos;
    for (unsigned bus = 0; (servos = scene->bus(scene->owner, bus)) != 0; bus++) {
        for (unsigned i = 0; i < servos->count; i++) {
            const struct servo_node *node = &servos->node[i];
            int32_t value = e->ids[node->id] ? look_at(e, &node->servo) : e->lowest;
            if (value < e->lowest || value > e->highest) {
                snprintf(seen, room, "servo %u has %" PRId32 " (0x%02" PRIX32 ")", node->id, value,
                         (uint32_t)value);
                return EXPECT_NOT_YET;
            }
        }
    }
    return EXPECT_MET;
}

static enum expect_verdict judge_text(const struct expectation *e, const struct expect_scene *scene,
                                      char *seen, size_t room)
{
    const char *reply = scene->witness->reply;
    if (strstr(reply, e->text)) {
        return EXPECT_MET;
    }
    snprintf(seen, room, "%s", *reply ? reply : "no reply");
    for (char *c = seen; *c; c++) {
        *c = *c != '\n' ? *c : c[1] ? '|' : 0;
    }
    return EXPECT_NOT_YET;
}

/* A breach that was expected is none. */
static enum expect_verdict judge_rule(const struct expectation *e, const struct expect_scene *scene,
                                      char *seen, size_t room)
{
    snprintf(seen, room, "it was not broken");
    if (!scene->rules || !scene->rules->breaches[e->rule]) {
        return EXPECT_NOT_YET;
    }
    scene->rules->breaches[e->rule] = 0;
    return EXPECT_MET;
}

enum expect_verdict expect_judge(const struct expectation *e, const struct expect_scene *scene,
                                 uint64_t now, char *seen, size_t room)
{
    switch (e->kind) {
    case EXPECT_PACKET: return judge_packet(e, scene, seen, room);
    case EXPECT_SILENCE: return judge_silence(scene, now, seen, room);
    case EXPECT_SERVO: return judge_servo(e, scene, seen, room);
    case EXPECT_TEXT: return judge_text(e, scene, seen, room);
    default: return judge_rule(e, scene, seen, room);
    }
}

void expect_show(const struct expectation *e, const struct expect_scene *scene, FILE *out)
{
    const struct servos *servos;
    for (unsigned bus = 0; (servos = scene->bus(scene->owner, bus)) != 0; bus++) {
        for (unsigned i = 0; i < servos->count; i++) {
            const struct servo_node *node = &servos->node[i];
            if (e->ids[node->id]) {
                fprintf(out, "servo %u %s %" PRId32 "\n", node->id, e->text,
                        look_at(e, &node->servo));
            }
        }
    }
}
