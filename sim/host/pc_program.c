/* SPDX-License-Identifier: MIT */
#include "host/pc_program.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "output/files.h"
#include "script/lexer.h"

#define POLL_US        100
#define READY_AFTER_US 1000
#define READY_WITHIN_S 10
#define LINE_BYTES_MAX 1024
#define WITHIN_MS      1000
#define WITHIN_MAX_MS  3600000
#define VALUE_MAX      100000000 // bytes, us or bit/s
#define STOP           0x18      // Ctrl-X stops the robot: a flood of random bytes leaves it out

/* --- the file --- */

static const char no_number[] = "a number is wanted";
static const char too_many_words[] = "too many words";

static bool complain(const struct pc_program *program, unsigned line, const char *what)
{
    fprintf(stderr, "%s:%u: %s\n", program->path, line, what);
    return false;
}

static size_t parse_bytes(const char *text, uint8_t *bytes)
{
    struct lexer_byte byte;
    size_t size = 0;
    while (size < LINE_BYTES_MAX && lexer_byte(&text, &byte) && !byte.any && !byte.framing_error) {
        bytes[size++] = byte.byte;
    }
    return *text ? 0 : size;
}

static const char *parse_say(struct pc_line *line, char *text)
{
    uint8_t bytes[LINE_BYTES_MAX];
    (void)line;
    return parse_bytes(text, bytes) ? 0 : "wanted: bytes in hexadecimal, 1024 at most";
}

static const char *parse_text(struct pc_line *line, char *text)
{
    (void)line, (void)text;
    return 0;
}

static const char *parse_rest(struct pc_line *line, char *text)
{
    (void)line;
    return *text ? too_many_words : 0;
}

/* BYTES [within MS] */
static const char *parse_hear(struct pc_line *line, char *text)
{
    char *word[3];
    unsigned count = lexer_split(text, word, 3);
    if (count < 1 || !lexer_number(word[0], 1, PC_RECEIVED_MAX, &line->value)) {
        return no_number;
    }
    if (count == 3 && strcmp(word[1], "within") == 0) {
        int32_t ms = 0;
        bool good = lexer_number(word[2], 0, WITHIN_MAX_MS, &ms);
        line->within_ms = (uint32_t)ms;
        return good ? 0 : "milliseconds are wanted";
    }
    return count == 1 ? 0 : too_many_words;
}

/* Parses a number, of us or of bit/s. */
static const char *parse_number(struct pc_line *line, char *text)
{
    char *word[1];
    unsigned count = lexer_split(text, word, 1);
    if (count < 1 || !lexer_number(word[0], 1, VALUE_MAX, &line->value)) {
        return no_number;
    }
    return count == 1 ? 0 : too_many_words;
}

/* BYTES [SEED] */
static const char *parse_flood(struct pc_line *line, char *text)
{
    char *word[2];
    unsigned count = lexer_split(text, word, 2);
    if (count < 1 || !lexer_number(word[0], 1, VALUE_MAX, &line->value)) {
        return no_number;
    }
    if (count == 2) {
        return lexer_number(word[1], 1, INT32_MAX, &line->seed) ? 0 : "a seed is wanted";
    }
    return count == 1 ? 0 : too_many_words;
}

static const char *parse_reset(struct pc_line *line, char *text)
{
    return reset_order_parse(&line->reset, text);
}

/* TEXT [within MS] */
static const char *parse_expect(struct pc_line *line, char *text)
{
    lexer_within(text, WITHIN_MAX_MS, &line->within_ms);
    return *text ? 0 : "a text is wanted";
}

static const char *parse(struct pc_line *line, char *text)
{
    static const struct {
        const char *word;
        const char *(*parse)(struct pc_line *line, char *text);
    } verbs[] = {
        [PC_SAY] = {"say", parse_say},          [PC_TEXT] = {"text", parse_text},
        [PC_REST] = {"rest", parse_rest},       [PC_HEAR] = {"hear", parse_hear},
        [PC_WAIT] = {"wait", parse_number},     [PC_BAUD] = {"baud", parse_number},
        [PC_FLOOD] = {"flood", parse_flood},    [PC_RESET] = {"reset", parse_reset},
        [PC_EXPECT] = {"expect", parse_expect},
    };
    char *rest = lexer_rest(text);
    line->text = rest;
    line->within_ms = WITHIN_MS;
    line->seed = 1;
    for (line->verb = PC_SAY; line->verb <= PC_EXPECT; line->verb++) {
        if (strcmp(verbs[line->verb].word, text) == 0) {
            return verbs[line->verb].parse(line, rest);
        }
    }
    return "unknown word; there are say text rest hear wait baud flood reset expect";
}

bool pc_program_read(struct pc_program *program, const char *path)
{
    *program = (struct pc_program){.path = path, .text = files_read_text(path)};
    if (!program->text) {
        return false;
    }
    program->line = calloc(lexer_count_lines(program->text), sizeof(*program->line));
    if (!program->line) {
        return complain(program, 0, "out of memory");
    }
    char *next = program->text;
    char *text;
    for (unsigned number = 0; (text = lexer_next_line(&next, &number)) != 0;) {
        struct pc_line *line = &program->line[program->count++];
        line->number = number;
        const char *wrong = parse(line, text);
        if (wrong) {
            return complain(program, number, wrong);
        }
    }
    return true;
}

void pc_program_free(struct pc_program *program)
{
    free(program->line);
    free(program->text);
    program->line = 0;
    program->text = 0;
}

/* --- line after line --- */

static uint64_t cycles(const struct pc_program *program, uint64_t us)
{
    return us * program->clock_Hz / 1000000;
}

static void step_in(struct pc_program *program, uint64_t now, uint64_t us)
{
    schedule_at(program->schedule, &program->step, now + cycles(program, us));
}

/* Sends bytes, and prints the start of the first start bit and the end of the last stop bit. */
static void send_bytes(struct pc_program *program, uint64_t now, const uint8_t *bytes, size_t size)
{
    uint64_t from = adapter_end(&program->link->adapter);
    program->size = program->printed = 0;
    adapter_send(&program->link->adapter, now, bytes, size);
    fprintf(program->out, "said %" PRIu64 " %" PRIu64 " %zu\n", from > now ? from : now,
            adapter_end(&program->link->adapter), size);
}

static void send_text(struct pc_program *program, uint64_t now, const char *text)
{
    uint8_t bytes[LINE_BYTES_MAX];
    size_t size = strlen(text);
    size = size < LINE_BYTES_MAX - 1 ? size : LINE_BYTES_MAX - 1;
    memcpy(bytes, text, size);
    bytes[size++] = '\r';
    send_bytes(program, now, bytes, size);
}

static bool is_text(const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        if (!isprint(bytes[i]) && !isspace(bytes[i])) {
            return false;
        }
    }
    return true;
}

/* Prints the lines that are not empty. */
static void print_text(FILE *out, const uint8_t *bytes, size_t size)
{
    for (size_t i = 0, from = 0; i <= size; i++) {
        if (i < size && bytes[i] != '\r' && bytes[i] != '\n') {
            continue;
        }
        if (i > from) {
            fprintf(out, "text: %.*s\n", (int)(i - from), (const char *)bytes + from);
        }
        from = i + 1;
    }
}

static void print_received(struct pc_program *program, size_t size)
{
    const uint8_t *bytes = program->received + program->printed;
    fprintf(program->out, "heard %" PRIu64 " %" PRIu64 " %zu", program->times[program->printed],
            program->times[program->printed + size - 1], size);
    for (size_t i = 0; i < size; i++) {
        fprintf(program->out, " %02X", bytes[i]);
    }
    fputc('\n', program->out);
    if (is_text(bytes, size)) {
        print_text(program->out, bytes, size);
    }
    program->printed += size;
}

/* Ends the run. `wrong` 0: no error. */
static void end(struct pc_program *program, uint64_t now, const char *wrong)
{
    program->done = true;
    program->on_end(program->context, now, wrong);
}

/* Returns how many bytes, from the first that is not printed on, the line waits for; 0: they have
 * not come. */
static size_t awaited(const struct pc_program *program, const struct pc_line *line)
{
    size_t size = program->size - program->printed, length;
    const uint8_t *from = program->received + program->printed;
    if (line->verb == PC_HEAR) {
        return size >= (size_t)line->value ? (size_t)line->value : 0;
    }
    length = strlen(line->text);
    for (size_t i = 0; i + length <= size; i++) {
        if (memcmp(from + i, line->text, length) == 0) {
            return i + length;
        }
    }
    return 0;
}

static void end_unheard(struct pc_program *program, uint64_t now, const struct pc_line *line)
{
    char what[160];
    size_t size = program->size - program->printed;
    if (line->verb == PC_HEAR) {
        snprintf(what, sizeof(what), "heard %zu bytes, not %" PRId32, size, line->value);
    } else {
        snprintf(what, sizeof(what), "heard %zu bytes without '%.80s'", size, line->text);
    }
    if (size) {
        print_received(program, size);
    }
    end(program, now, what);
}

/* Returns true if the next line may follow at once. */
static bool wait_for_bytes(struct pc_program *program, uint64_t now, const struct pc_line *line)
{
    size_t size = awaited(program, line);
    if (!program->waiting) {
        program->deadline = now + cycles(program, (uint64_t)line->within_ms * 1000);
    }
    program->waiting = size == 0 && now < program->deadline;
    if (program->waiting) {
        schedule_at(program->schedule, &program->step,
                    program->deadline); // or earlier: when the bytes are there
        return false;
    }
    if (size) {
        print_received(program, size);
        return true;
    }
    end_unheard(program, now, line);
    return false;
}

/* Sends as many bytes as the adapter takes. */
static bool flood(struct pc_program *program, uint64_t now)
{
    while (program->flood && adapter_space(&program->link->adapter)) {
        program->random = program->random * 1664525 + 1013904223;
        uint8_t byte = (uint8_t)(program->random >> 24);
        if (byte == STOP) {
            continue;
        }
        adapter_send(&program->link->adapter, now, &byte, 1);
        program->flood--;
    }
    if (program->flood) {
        step_in(program, now, POLL_US);
        return false;
    }
    schedule_at(program->schedule, &program->step,
                adapter_end(&program->link->adapter)); // the next line follows then
    return false;
}

static bool run(struct pc_program *program, uint64_t now, const struct pc_line *line)
{
    uint8_t bytes[LINE_BYTES_MAX];
    switch (line->verb) {
    case PC_SAY: send_bytes(program, now, bytes, parse_bytes(line->text, bytes)); return true;
    case PC_TEXT: send_text(program, now, line->text); return true;
    case PC_REST:
        if (program->size > program->printed) {
            print_received(program, program->size - program->printed);
        }
        return true;
    case PC_HEAR:
    case PC_EXPECT: return wait_for_bytes(program, now, line);
    case PC_WAIT: step_in(program, now, (uint64_t)line->value); return false;
    case PC_BAUD: adapter_baud(&program->link->adapter, (uint32_t)line->value); return true;
    case PC_FLOOD:
        program->size = program->printed = 0;
        program->flood = line->value;
        program->random = (uint32_t)line->seed;
        return flood(program, now);
    case PC_RESET:
        program->on_reset(program->context, now, &line->reset);
        step_in(program, now, 1); // what happens now happens before the next line
        return false;
    }
    return true;
}

/* The firmware does not receive yet: a PC does not send earlier. */
static void await_receiver(struct pc_program *program, uint64_t now)
{
    if (now < (uint64_t)READY_WITHIN_S * program->clock_Hz) {
        step_in(program, now, READY_AFTER_US);
        return;
    }
    end(program, now, "after 10 s the firmware does not receive on its host USART (RXEN is 0)");
}

static void step(void *context, uint64_t now)
{
    struct pc_program *program = context;
    bool go_on = true;
    if (program->next == 0 && !usart_rxen(&program->link->usart)) {
        await_receiver(program, now);
        return;
    }
    if (program->waiting) {
        go_on = wait_for_bytes(program, now, &program->line[program->next - 1]);
    } else if (program->flood) {
        go_on = flood(program, now);
    }
    while (go_on && program->next < program->count) {
        go_on = run(program, now, &program->line[program->next++]);
    }
    if (go_on) {
        end(program, now, 0);
    }
}

void pc_program_start(struct pc_program *program, struct schedule *schedule, uint32_t clock_Hz,
                      struct host_link *link, FILE *out)
{
    program->schedule = schedule;
    program->clock_Hz = clock_Hz;
    program->link = link;
    program->out = out;
    event_init(&program->step, step, program);
    step_in(program, schedule->now, READY_AFTER_US);
}

void pc_program_receive(struct pc_program *program, uint64_t now, uint8_t byte)
{
    if (program->size < PC_RECEIVED_MAX) {
        program->received[program->size] = byte;
        program->times[program->size++] = now;
    }
    if (program->waiting && awaited(program, &program->line[program->next - 1])) {
        schedule_at(program->schedule, &program->step, now);
    }
}

bool pc_program_is_unfinished(const struct pc_program *program)
{
    bool is_last = program->next == program->count;
    return !program->done && !(is_last && program->line[program->count - 1].verb == PC_FLOOD);
}

unsigned pc_program_line_number(const struct pc_program *program)
{
    unsigned index = program->next ? program->next - 1 : 0;
    return index < program->count ? program->line[index].number : 0;
}
