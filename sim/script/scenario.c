/* SPDX-License-Identifier: MIT */
#include "script/scenario.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "output/files.h"
#include "script/faults.h"
#include "script/lexer.h"

bool scenario_complain(const struct scenario *scenario, unsigned line, const char *what)
{
    fprintf(stderr, "%s:%u: %s\n", scenario->path, line, what);
    return false;
}

/* --- one line --- */

static const char *parse_servos(struct scenario_line *line, char *rest)
{
    return ids_parse_set(rest, line->ids);
}

static const char *parse_switch(struct scenario_line *line, char *rest)
{
    return lexer_switch(rest, &line->flag) ? 0 : "wanted: echo on|off";
}

static const char *parse_ms(struct scenario_line *line, char *rest)
{
    int32_t ms = 0;
    bool good = lexer_number(rest, 0, SCENARIO_MS_MAX, &ms);
    line->ms = (uint32_t)ms;
    return good ? 0 : "milliseconds are wanted, 0 to 3600000 (an hour), without unit";
}

static const char *parse_print(struct scenario_line *line, char *rest)
{
    (void)line, (void)rest;
    return 0;
}

static const char *parse_send(struct scenario_line *line, char *rest)
{
    (void)line;
    const char *at = rest;
    struct lexer_byte byte;
    unsigned size = 0;
    while (lexer_byte(&at, &byte) && !byte.any && !byte.framing_error) {
        size++;
    }
    if (size > SCENARIO_SEND_MAX) {
        return "1024 bytes at most in one line";
    }
    return *rest && !*at && !byte.any && !byte.framing_error
               ? 0
               : "bytes in hexadecimal are wanted, as in FF FF 01 02 01 FB";
}

static const char *parse_baud(struct scenario_line *line, char *rest)
{
    return lexer_number(rest, 300, 2000000, &line->value) ? 0 : "wanted: 300 to 2000000 baud";
}

static const char *parse_fault(struct scenario_line *line, char *rest)
{
    (void)line;
    return faults_check(rest);
}

static const char *parse_expect(struct scenario_line *line, char *rest)
{
    return expect_parse(&line->expectation, rest);
}

static const char *parse_show(struct scenario_line *line, char *rest)
{
    return expect_parse_show(&line->expectation, rest);
}

static const char *parse_reset(struct scenario_line *line, char *rest)
{
    return reset_order_parse(&line->reset, rest);
}

static const char *parse_hang(struct scenario_line *line, char *rest)
{
    return hang_order_parse(&line->reset, rest);
}

/* Parses the place of a servo: "1st", "2nd", "3rd", "4th". Returns 0 if the text is none. */
static unsigned parse_place(const char *text)
{
    static const char *const suffixes[] = {"st", "nd", "rd", "th"};
    size_t digits = strspn(text, "0123456789");
    bool has_suffix = false;
    for (unsigned i = 0; i < 4; i++) {
        has_suffix |= strcmp(text + digits, suffixes[i]) == 0;
    }
    unsigned long place = strtoul(text, 0, 10);
    return digits && has_suffix && place < IDS_MAX ? (unsigned)place : 0;
}

/* Parses [IDS] VALUE [over MS]. */
static const char *parse_environment(struct scenario_line *line, char *rest)
{
    char *word[4];
    unsigned count = lexer_split(rest, word, 4);
    if (count >= 3 && count <= 4 && strcmp(word[count - 2], "over") == 0) {
        if (!environment_is_quantity(line->property)) {
            return "what is on or off cannot take time";
        }
        const char *wrong = parse_ms(line, word[count - 1]);
        if (wrong) {
            return wrong;
        }
        count -= 2;
    }
    if (count < 1 || count > 2) {
        return environment_form(line->property);
    }
    line->all = count == 1;
    line->place = line->all ? 0 : parse_place(word[0]);
    if (!line->all && !strchr("0123456789", word[0][0])) {
        return environment_form(line->property); // "power all off"
    }
    const char *wrong = line->all || line->place ? 0 : ids_parse_set(word[0], line->ids);
    wrong = wrong ? wrong : environment_parse(line->property, word[count - 1], &line->value);
    return wrong || !line->all ? wrong : environment_check_for_all(line->property, line->value);
}

/* Parses a line after its `@`. Returns 0, or what is wrong. */
static const char *parse_action(struct scenario_line *line, char *text)
{
    static const struct {
        const char *word;
        enum scenario_verb verb;
        const char *(*parse)(struct scenario_line *line, char *rest);
    } verbs[] = {
        {"servos", SCENARIO_SERVOS, parse_servos},
        {"wait", SCENARIO_WAIT, parse_ms},
        {"at", SCENARIO_AT, parse_ms},
        {"print", SCENARIO_PRINT, parse_print},
        {"echo", SCENARIO_ECHO, parse_switch},
        {"send", SCENARIO_SEND, parse_send},
        {"fault", SCENARIO_FAULT, parse_fault},
        {"expect", SCENARIO_EXPECT, parse_expect},
        {"baud", SCENARIO_BAUD, parse_baud},
        {"show", SCENARIO_SHOW, parse_show},
        {"reset", SCENARIO_RESET, parse_reset},
        {"hang", SCENARIO_RESET, parse_hang},
    };
    char *rest = lexer_rest(text);
    line->text = rest;
    for (size_t i = 0; i < sizeof(verbs) / sizeof(verbs[0]); i++) {
        if (strcmp(verbs[i].word, text) == 0) {
            line->verb = verbs[i].verb;
            return verbs[i].parse(line, rest);
        }
    }
    if (strcmp(text, "unplug") == 0) {
        return "unknown @ command; to unplug servo 2: @power 2 off";
    }
    line->verb = SCENARIO_ENVIRONMENT;
    line->property = environment_find(text);
    return line->property < ENVIRONMENT_COUNT
               ? parse_environment(line, rest)
               : "unknown @ command; there are @servos @power @supply @ambient @load @block @fault "
                 "@reset @hang @wait @at @send @baud @expect @show @print @echo";
}

/* True if the text ends with "within" and a number. */
static bool ends_within_digits(const char *text)
{
    const char *last = strrchr(text, ' ');
    const size_t size = strlen(" within");

    return last && last[1] && strspn(last + 1, "0123456789") == strlen(last + 1) &&
           (size_t)(last - text) >= size && memcmp(last - size, " within", size) == 0;
}

static const char *parse_line(struct scenario_line *line, char *text)
{
    if (text[0] == '@') {
        return parse_action(line, text + 1);
    }
    line->verb = SCENARIO_COMMAND;
    line->flag = text[0] == '!';
    text = line->flag ? lexer_trim(text + 1) : text;
    line->text = text;
    line->ms = SCENARIO_REPLY_MS;
    if (!lexer_within(text, SCENARIO_MS_MAX, &line->ms) && ends_within_digits(text)) {
        return "milliseconds are wanted behind within, 0 to 3600000 (an hour), without unit";
    }
    return line->text[0] ? 0 : "a command is wanted behind the !";
}

int scenario_absent(const struct scenario_line *line, bool there[IDS_MAX])
{
    if (line->verb == SCENARIO_SERVOS) {
        memcpy(there, line->ids, sizeof(line->ids));
        return -1;
    }
    bool looks = line->expectation.kind == EXPECT_SERVO &&
                 (line->verb == SCENARIO_EXPECT || line->verb == SCENARIO_SHOW);
    const bool *named = looks ? line->expectation.ids : line->ids;
    for (int id = 0; id < IDS_MAX; id++) {
        if (named[id] && !there[id]) {
            return id;
        }
    }
    return -1;
}

/* --- the file --- */

static bool read_lines(struct scenario *scenario)
{
    char *next = scenario->text;
    char *text;
    for (unsigned number = 0; (text = lexer_next_line(&next, &number)) != 0;) {
        struct scenario_line *line = &scenario->line[scenario->count++];
        line->number = number;
        line->source = strcpy(scenario->source + (text - scenario->text), text);
        const char *wrong = parse_line(line, text);
        if (wrong) {
            return scenario_complain(scenario, number, wrong);
        }
    }
    return true;
}

bool scenario_read(struct scenario *scenario, const char *path)
{
    *scenario = (struct scenario){.path = path, .text = files_read_text(path)};
    if (!scenario->text) {
        return false;
    }
    scenario->source = strdup(scenario->text);
    scenario->line = calloc(lexer_count_lines(scenario->text), sizeof(*scenario->line));
    if (!scenario->source || !scenario->line) {
        return scenario_complain(scenario, 0, "out of memory");
    }
    return read_lines(scenario);
}

const char *scenario_read_line(struct scenario *scenario, const char *text)
{
    scenario_free(scenario);
    scenario->text = strdup(text);
    scenario->source = strdup(text);
    scenario->line = calloc(1, sizeof(*scenario->line));
    if (!scenario->text || !scenario->source || !scenario->line) {
        return "out of memory";
    }
    scenario->count = 1;
    scenario->line->number = 1;
    scenario->line->source = scenario->source;
    return parse_line(scenario->line, lexer_trim(scenario->text));
}

void scenario_free(struct scenario *scenario)
{
    free(scenario->line);
    free(scenario->source);
    free(scenario->text);
    *scenario = (struct scenario){0};
}
