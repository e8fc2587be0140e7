#include "host/pc_program.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "output/files.h"
#include "script/lexer.h"

#define POLL_US        100
#define READY_AFTER_US 1000
#define SAY_MAX        1024
#define WITHIN_MS      1000
#define STOP           0x18 // Ctrl-X, by which a flood would stop the robot, and rightly

/* --- the file ------------------------------------------------------------------------------------
 */

static bool complain(const struct pc *pc, unsigned line, const char *what)
{
    fprintf(stderr, "%s:%u: %s\n", pc->path, line, what);
    return false;
}

static size_t bytes_of(const char *text, uint8_t *bytes)
{
    struct words_byte byte;
    size_t size = 0;
    while (size < SAY_MAX && words_byte(&text, &byte) && !byte.any && !byte.framing_error) {
        bytes[size++] = byte.byte;
    }
    return *text ? 0 : size;
}

static const char *parse(struct pc_line *line, char *text)
{
    static const char *const words[] = {"say",  "text", "rest",  "hear",
                                        "wait", "baud", "flood", "reset"};
    uint8_t bytes[SAY_MAX];
    char *rest = words_rest(text);
    char *word[3];
    line->verb = PC_SAY;
    while (line->verb <= PC_RESET && strcmp(text, words[line->verb]) != 0) {
        line->verb++;
    }
    if (line->verb > PC_RESET) {
        return "unknown word; there are say text rest hear wait baud flood reset";
    }
    line->text = rest;
    if (line->verb == PC_SAY) {
        return bytes_of(rest, bytes) ? 0 : "wanted: bytes in hexadecimal, 1024 at most";
    }
    if (line->verb == PC_TEXT) {
        return 0;
    }
    if (line->verb == PC_REST) {
        return *rest ? "too many words" : 0;
    }
    if (line->verb == PC_RESET) {
        return upset_parse_reset(&line->upset, rest);
    }
    unsigned count = words_split(rest, word, 3);
    int32_t highest = line->verb == PC_HEAR ? PC_HEARD_MAX : 100000000;
    if (count < 1 || !words_number(word[0], 1, highest, &line->value)) {
        return "a number is wanted";
    }
    line->within_ms = WITHIN_MS;
    line->seed = 1;
    if (count == 3 && line->verb == PC_HEAR && strcmp(word[1], "within") == 0) {
        return words_number(word[2], 0, 3600000, &line->within_ms) ? 0 : "milliseconds are wanted";
    }
    if (count == 2 && line->verb == PC_FLOOD) {
        return words_number(word[1], 1, INT32_MAX, &line->seed) ? 0 : "a seed is wanted";
    }
    return count == 1 ? 0 : "too many words";
}

bool pc_read(struct pc *pc, const char *path)
{
    *pc = (struct pc){.path = path, .text = files_read_text(path)};
    if (!pc->text) {
        return false;
    }
    size_t lines = 1;
    for (const char *c = pc->text; *c; c++) {
        lines += *c == '\n';
    }
    pc->line = calloc(lines, sizeof(*pc->line));
    unsigned number = 0;
    for (char *next = pc->text; next && pc->line;) {
        char *text = next;
        next = strchr(text, '\n');
        if (next) {
            *next++ = 0;
        }
        number++;
        text = words_trim(text);
        if (*text == 0 || *text == '#') {
            continue;
        }
        struct pc_line *line = &pc->line[pc->count++];
        line->number = number;
        const char *wrong = parse(line, text);
        if (wrong) {
            return complain(pc, number, wrong);
        }
    }
    return pc->line || complain(pc, 0, "out of memory");
}

void pc_free(struct pc *pc)
{
    free(pc->line);
    free(pc->text);
    pc->line = 0;
    pc->text = 0;
}

/* --- line after line -----------------------------------------------------------------------------
 */

static uint64_t cycles(const struct pc *pc, uint64_t us)
{
    return us * pc->clock_Hz / 1000000;
}

static void step_in(struct pc *pc, uint64_t now, uint64_t us)
{
    schedule_at(pc->schedule, &pc->step, now + cycles(pc, us));
}

/* What is said is told with the time from which it is said, and the end of its last stop bit. */
static void say(struct pc *pc, uint64_t now, const uint8_t *bytes, size_t size)
{
    uint64_t from = adapter_end(&pc->host->pc);
    pc->size = pc->taken = 0;
    adapter_say(&pc->host->pc, now, bytes, size);
    fprintf(pc->out, "said %" PRIu64 " %" PRIu64 " %zu\n", from > now ? from : now,
            adapter_end(&pc->host->pc), size);
}

static void say_text(struct pc *pc, uint64_t now, const char *text)
{
    uint8_t bytes[SAY_MAX];
    size_t size = strlen(text);
    size = size < SAY_MAX - 1 ? size : SAY_MAX - 1;
    memcpy(bytes, text, size);
    bytes[size++] = '\r';
    say(pc, now, bytes, size);
}

static void tell_heard(struct pc *pc, size_t size)
{
    fprintf(pc->out, "heard %" PRIu64 " %" PRIu64 " %zu", pc->times[pc->taken],
            pc->times[pc->taken + size - 1], size);
    for (size_t i = 0; i < size; i++) {
        fprintf(pc->out, " %02X", pc->heard[pc->taken + i]);
    }
    fputc('\n', pc->out);
    pc->taken += size;
}

/* True when the next line may follow at once. */
static bool hear(struct pc *pc, uint64_t now, const struct pc_line *line)
{
    size_t wanted = (size_t)line->value;
    if (!pc->hearing) {
        pc->deadline = now + cycles(pc, (uint64_t)line->within_ms * 1000);
    }
    pc->hearing = pc->size - pc->taken < wanted && now < pc->deadline;
    if (pc->hearing) {
        schedule_at(pc->schedule, &pc->step, pc->deadline); // or when it is here
        return false;
    }
    if (pc->size - pc->taken >= wanted) {
        tell_heard(pc, wanted);
        return true;
    }
    char what[80];
    snprintf(what, sizeof(what), "heard %zu bytes, not %zu", pc->size - pc->taken, wanted);
    pc->on_end(pc->owner, now, what);
    return false;
}

/* As much as the adapter takes. */
static bool flood(struct pc *pc, uint64_t now)
{
    while (pc->flood && adapter_room(&pc->host->pc)) {
        pc->random = pc->random * 1664525 + 1013904223;
        uint8_t byte = (uint8_t)(pc->random >> 24);
        if (byte == STOP) {
            continue;
        }
        adapter_say(&pc->host->pc, now, &byte, 1);
        pc->flood--;
    }
    if (pc->flood) {
        step_in(pc, now, POLL_US);
        return false;
    }
    schedule_at(pc->schedule, &pc->step, adapter_end(&pc->host->pc)); // and the next line then
    return false;
}

static bool run(struct pc *pc, uint64_t now, const struct pc_line *line)
{
    uint8_t bytes[SAY_MAX];
    switch (line->verb) {
    case PC_SAY: say(pc, now, bytes, bytes_of(line->text, bytes)); return true;
    case PC_TEXT: say_text(pc, now, line->text); return true;
    case PC_REST:
        if (pc->size > pc->taken) {
            tell_heard(pc, pc->size - pc->taken);
        }
        return true;
    case PC_HEAR: return hear(pc, now, line);
    case PC_WAIT: step_in(pc, now, (uint64_t)line->value); return false;
    case PC_BAUD: adapter_baud(&pc->host->pc, (uint32_t)line->value); return true;
    case PC_FLOOD:
        pc->size = pc->taken = 0;
        pc->flood = line->value;
        pc->random = (uint32_t)line->seed;
        return flood(pc, now);
    case PC_RESET:
        pc->on_reset(pc->owner, now, &line->upset);
        step_in(pc, now, 1); // what happens now happens before the next line
        return false;
    }
    return true;
}

static void step(void *owner, uint64_t now)
{
    struct pc *pc = owner;
    bool go_on = true;
    if (pc->next == 0 && !usart_rxen(&pc->host->usart)) {
        step_in(pc, now, READY_AFTER_US); // a PC is not that fast either
        return;
    }
    if (pc->hearing) {
        go_on = hear(pc, now, &pc->line[pc->next - 1]);
    } else if (pc->flood) {
        go_on = flood(pc, now);
    }
    while (go_on && pc->next < pc->count) {
        go_on = run(pc, now, &pc->line[pc->next++]);
    }
    if (go_on) {
        pc->on_end(pc->owner, now, 0);
    }
}

void pc_start(struct pc *pc, struct schedule *schedule, uint32_t clock_Hz, struct host *host,
              FILE *out)
{
    pc->schedule = schedule;
    pc->clock_Hz = clock_Hz;
    pc->host = host;
    pc->out = out;
    event_init(&pc->step, step, pc);
    step_in(pc, schedule->now, READY_AFTER_US);
}

void pc_hear(struct pc *pc, uint64_t now, uint8_t byte)
{
    if (pc->size < PC_HEARD_MAX) {
        pc->heard[pc->size] = byte;
        pc->times[pc->size++] = now;
    }
    if (pc->hearing && pc->size - pc->taken >= (size_t)pc->line[pc->next - 1].value) {
        schedule_at(pc->schedule, &pc->step, now);
    }
}
