/* SPDX-License-Identifier: MIT */
#include "host/pc_program.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "output/files.h"
#include "script/lexer.h"

#define POLL_US        100
#define READY_AFTER_US 1000
#define LINE_BYTES_MAX 1024
#define WITHIN_MS      1000
#define STOP           0x18 // Ctrl-X stops the robot: a flood of random bytes leaves it out

/* --- the file --- */

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

static const char *parse(struct pc_line *line, char *text)
{
    static const char *const words[] = {"say",  "text", "rest",  "hear",
                                        "wait", "baud", "flood", "reset"};
    uint8_t bytes[LINE_BYTES_MAX];
    char *rest = lexer_rest(text);
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
        return parse_bytes(rest, bytes) ? 0 : "wanted: bytes in hexadecimal, 1024 at most";
    }
    if (line->verb == PC_TEXT) {
        return 0;
    }
    if (line->verb == PC_REST) {
        return *rest ? "too many words" : 0;
    }
    if (line->verb == PC_RESET) {
        return reset_order_parse(&line->reset, rest);
    }
    unsigned count = lexer_split(rest, word, 3);
    int32_t highest = line->verb == PC_HEAR ? PC_RECEIVED_MAX : 100000000;
    if (count < 1 || !lexer_number(word[0], 1, highest, &line->value)) {
        return "a number is wanted";
    }
    line->within_ms = WITHIN_MS;
    line->seed = 1;
    if (count == 3 && line->verb == PC_HEAR && strcmp(word[1], "within") == 0) {
        return lexer_number(word[2], 0, 3600000, &line->within_ms) ? 0 : "milliseconds are wanted";
    }
    if (count == 2 && line->verb == PC_FLOOD) {
        return lexer_number(word[1], 1, INT32_MAX, &line->seed) ? 0 : "a seed is wanted";
    }
    return count == 1 ? 0 : "too many words";
}

bool pc_program_read(struct pc_program *program, const char *path)
{
    *program = (struct pc_program){.path = path, .text = files_read_text(path)};
    if (!program->text) {
        return false;
    }
    size_t lines = 1;
    for (const char *c = program->text; *c; c++) {
        lines += *c == '\n';
    }
    program->line = calloc(lines, sizeof(*program->line));
    unsigned number = 0;
    for (char *next = program->text; next && program->line;) {
        char *text = next;
        next = strchr(text, '\n');
        if (next) {
            *next++ = 0;
        }
        number++;
        text = lexer_trim(text);
        if (*text == 0 || *text == '#') {
            continue;
        }
        struct pc_line *line = &program->line[program->count++];
        line->number = number;
        const char *wrong = parse(line, text);
        if (wrong) {
            return complain(program, number, wrong);
        }
    }
    return program->line || complain(program, 0, "out of memory");
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

static void print_received(struct pc_program *program, size_t size)
{
    fprintf(program->out, "heard %" PRIu64 " %" PRIu64 " %zu", program->times[program->printed],
            program->times[program->printed + size - 1], size);
    for (size_t i = 0; i < size; i++) {
        fprintf(program->out, " %02X", program->received[program->printed + i]);
    }
    fputc('\n', program->out);
    program->printed += size;
}

/* Returns true if the next line may follow at once. */
static bool wait_for_bytes(struct pc_program *program, uint64_t now, const struct pc_line *line)
{
    size_t wanted = (size_t)line->value;
    if (!program->waiting) {
        program->deadline = now + cycles(program, (uint64_t)line->within_ms * 1000);
    }
    program->waiting = program->size - program->printed < wanted && now < program->deadline;
    if (program->waiting) {
        schedule_at(program->schedule, &program->step,
                    program->deadline); // or earlier: when the bytes are there
        return false;
    }
    if (program->size - program->printed >= wanted) {
        print_received(program, wanted);
        return true;
    }
    char what[80];
    snprintf(what, sizeof(what), "heard %zu bytes, not %zu", program->size - program->printed,
             wanted);
    program->on_end(program->context, now, what);
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
    case PC_HEAR: return wait_for_bytes(program, now, line);
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

static void step(void *context, uint64_t now)
{
    struct pc_program *program = context;
    bool go_on = true;
    if (program->next == 0 && !usart_rxen(&program->link->usart)) {
        step_in(program, now, READY_AFTER_US); // a PC does not send earlier
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
        program->on_end(program->context, now, 0);
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
    if (program->waiting &&
        program->size - program->printed >= (size_t)program->line[program->next - 1].value) {
        schedule_at(program->schedule, &program->step, now);
    }
}
