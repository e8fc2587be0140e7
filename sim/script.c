#include "script.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define READY_POLL_US  100
#define READY_AFTER_US 1000 // a PC is not that fast either

/* --- reading -------------------------------------------------------------------------------------
 */

static bool complain(const struct script *script, unsigned line, const char *what)
{
    fprintf(stderr, "%s:%u: %s\n", script->path, line, what);
    return false;
}

static char *read_all(const char *path)
{
    FILE *file = fopen(path, "r");
    if (!file) {
        fprintf(stderr, "%s: %s\n", path, strerror(errno));
        return 0;
    }
    size_t size = 0;
    size_t got = 0;
    char *text = 0;
    do {
        size += got;
        char *bigger = realloc(text, size + 4097);
        if (!bigger) {
            break;
        }
        text = bigger;
        got = fread(text + size, 1, 4096, file);
    } while (got > 0);
    bool good = text && !ferror(file);
    fclose(file);
    if (!good) {
        fprintf(stderr, "%s: cannot be read\n", path);
        free(text);
        return 0;
    }
    text[size] = 0;
    return text;
}

static char *trim(char *text)
{
    while (isspace((unsigned char)*text)) {
        text++;
    }
    size_t size = strlen(text);
    while (size && isspace((unsigned char)text[size - 1])) {
        text[--size] = 0;
    }
    return text;
}

static const char *parse_switch(struct script_line *line)
{
    line->flag = strcmp(line->text, "on") == 0;
    return line->flag || strcmp(line->text, "off") == 0 ? 0 : "on or off is wanted";
}

static const char *parse_wait(struct script_line *line)
{
    char *end = 0;
    unsigned long ms = strtoul(line->text, &end, 10);
    line->wait_ms = (uint32_t)ms;
    return isdigit((unsigned char)line->text[0]) && !*end && ms <= SCRIPT_WAIT_MAX
               ? 0
               : "milliseconds are wanted, an hour at most";
}

/* A line that begins with `@`, without it. Returns 0, or what is wrong. */
static const char *parse_action(struct script_line *line, char *text)
{
    static const struct {
        const char *word;
        enum script_verb verb;
    } verbs[] = {{"servos", SCRIPT_SERVOS},
                 {"power", SCRIPT_POWER},
                 {"wait", SCRIPT_WAIT},
                 {"print", SCRIPT_PRINT},
                 {"echo", SCRIPT_ECHO}};
    size_t length = strcspn(text, " \t");
    for (size_t i = 0; i < sizeof(verbs) / sizeof(verbs[0]); i++) {
        if (strlen(verbs[i].word) != length || strncmp(verbs[i].word, text, length) != 0) {
            continue;
        }
        line->verb = verbs[i].verb;
        line->text = trim(text + length);
        uint8_t ids[IDS_MAX];
        unsigned count = 0;
        switch (line->verb) {
        case SCRIPT_SERVOS: return ids_parse(line->text, true, ids, &count);
        case SCRIPT_POWER:
        case SCRIPT_ECHO: return parse_switch(line);
        case SCRIPT_WAIT: return parse_wait(line);
        default: return 0;
        }
    }
    return "unknown @ command; there are @servos @power @wait @print @echo";
}

static const char *parse_line(struct script_line *line, char *text)
{
    if (text[0] == '@') {
        return parse_action(line, text + 1);
    }
    line->verb = SCRIPT_COMMAND;
    line->flag = text[0] == '!';
    line->text = line->flag ? trim(text + 1) : text;
    return line->text[0] ? 0 : "a command is wanted behind the !";
}

bool script_read(struct script *script, const char *path)
{
    *script = (struct script){.path = path, .text = read_all(path)};
    if (!script->text) {
        return false;
    }
    size_t lines = 1;
    for (const char *c = script->text; *c; c++) {
        lines += *c == '\n';
    }
    script->lines = calloc(lines, sizeof(*script->lines));
    if (!script->lines) {
        return complain(script, 0, "out of memory");
    }
    unsigned number = 0;
    for (char *next = script->text; next;) {
        char *text = next;
        next = strchr(text, '\n');
        if (next) {
            *next++ = 0;
        }
        number++;
        text = trim(text);
        if (text[0] == 0 || text[0] == '#') {
            continue;
        }
        struct script_line *line = &script->lines[script->count++];
        line->number = number;
        const char *wrong = parse_line(line, text);
        if (wrong) {
            return complain(script, number, wrong);
        }
    }
    return true;
}

void script_free(struct script *script)
{
    free(script->lines);
    free(script->text);
    *script = (struct script){0};
}

/* --- running -------------------------------------------------------------------------------------
 */

static uint64_t cycles(const struct script *script, uint64_t us)
{
    return us * script->clock_Hz / 1000000;
}

static const struct script_line *current(const struct script *script)
{
    return &script->lines[script->next - 1];
}

unsigned script_line_number(const struct script *script)
{
    return script->next ? current(script)->number : 0;
}

static void say(struct script *script, uint64_t now, const struct script_line *line)
{
    if (script->echo) {
        fprintf(script->out, "> %s\n", line->text);
    }
    script->waiting = true;
    script->world->say(script->world->owner, now, line->text, strlen(line->text));
    script->world->say(script->world->owner, now, "\n", 1);
    uint64_t patience = cycles(script, SCRIPT_PATIENCE_S * 1000000ull);
    schedule_at(script->schedule, &script->patience, now + patience);
}

static void act(struct script *script, uint64_t now, const struct script_line *line)
{
    const struct script_world *world = script->world;
    uint8_t ids[IDS_MAX];
    unsigned count = 0;
    switch (line->verb) {
    case SCRIPT_SERVOS:
        ids_parse(line->text, true, ids, &count);
        world->servos(world->owner, now, ids, count);
        break;
    case SCRIPT_POWER: world->power(world->owner, now, line->flag); break;
    case SCRIPT_PRINT: fprintf(script->out, "%s\n", line->text); break;
    case SCRIPT_ECHO:
        script->echo = line->flag;
        world->echo(world->owner, line->flag);
        break;
    case SCRIPT_COMMAND:
    case SCRIPT_WAIT: break; // not here
    }
}

static void finish(struct script *script, uint64_t now)
{
    script->done = true;
    script->world->finished(script->world->owner, now);
}

static void step(void *owner, uint64_t now)
{
    struct script *script = owner;
    if (!script->started) {
        script->started = script->world->ready(script->world->owner);
        uint64_t pause = cycles(script, script->started ? READY_AFTER_US : READY_POLL_US);
        schedule_at(script->schedule, &script->step, now + pause);
        return;
    }
    schedule_cancel(script->schedule, &script->patience);
    while (script->next < script->count) {
        const struct script_line *line = &script->lines[script->next++];
        if (line->verb == SCRIPT_COMMAND) {
            say(script, now, line);
            return;
        }
        if (line->verb == SCRIPT_WAIT) {
            schedule_at(script->schedule, &script->step,
                        now + cycles(script, line->wait_ms * 1000ull));
            return;
        }
        act(script, now, line);
    }
    finish(script, now);
}

static void out_of_patience(void *owner, uint64_t now)
{
    struct script *script = owner;
    const char *what = script->started ? current(script)->text : "the firmware never listened";
    script->world->outcome(script->world->owner, now, SCRIPT_SILENCE, what);
    finish(script, now);
}

static void reply_line(struct script *script, uint64_t now)
{
    const char *reply = script->reply;
    if (script->echo) {
        fprintf(script->out, "%s\n", reply);
    }
    bool error = strncmp(reply, "error ", 6) == 0;
    if (!script->waiting || (!error && strcmp(reply, "ok") != 0)) {
        return;
    }
    script->waiting = false;
    const struct script_line *line = current(script);
    char what[SCRIPT_REPLY_ROOM * 2];
    snprintf(what, sizeof(what), "%.180s: %s", line->text, reply);
    enum script_outcome outcome = error == line->flag ? SCRIPT_GOOD
                                  : error             ? SCRIPT_UNEXPECTED_ERROR
                                                      : SCRIPT_UNEXPECTED_OK;
    script->world->outcome(script->world->owner, now, outcome, what);
    schedule_at(script->schedule, &script->step, now);
}

void script_hear(struct script *script, uint64_t now, uint8_t byte)
{
    if (byte == '\n') {
        script->reply[script->reply_size] = 0;
        script->reply_size = 0;
        reply_line(script, now);
    } else if (byte != '\r' && script->reply_size < SCRIPT_REPLY_ROOM - 1) {
        script->reply[script->reply_size++] = (char)byte;
    }
}

void script_start(struct script *script, struct schedule *schedule, uint32_t clock_Hz,
                  const struct script_world *world, FILE *out)
{
    script->schedule = schedule;
    script->clock_Hz = clock_Hz;
    script->world = world;
    script->out = out;
    event_init(&script->step, step, script);
    event_init(&script->patience, out_of_patience, script);
    schedule_at(schedule, &script->step, schedule->now);
    schedule_at(schedule, &script->patience,
                schedule->now + cycles(script, SCRIPT_PATIENCE_S * 1000000ull));
}
