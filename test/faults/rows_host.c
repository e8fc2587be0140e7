/* SPDX-License-Identifier: MIT */
/* F14: a PC floods the console while the controller sends packets to a servo. Runs the controller's
 * firmware. */
#include "rows.h"

#include <string.h>

#define FLOOD        1500 // bytes without a gap
#define TEXT_ROOM    65536
#define RETURN_DELAY 5    // register 0x05, 10 us: the handlers of the host link delay the release
#define STOP         0x18 // Ctrl-X: it would switch torque off, and this row expects only PINGs

#define QUIET (120000 * RIG_US) // longer than the console looks for names near a wrong word

static char text[TEXT_ROOM]; // output of the console
static unsigned text_size;

static void console_prints(void *context, uint64_t now, uint8_t byte)
{
    (void)context, (void)now;
    if (text_size + 1 < TEXT_ROOM) {
        text[text_size++] = (char)byte;
        text[text_size] = 0;
    }
}

static void host_sends(struct check *check, const char *bytes, unsigned size)
{
    struct testbench *bench = &check->rig->bench;
    bench->host_link.adapter.on_byte = console_prints;
    host_link_send(&bench->host_link, rig_now(check->rig), bytes, size);
}

/* Runs until the controller has received `bytes`, which take less than 90 us each, and has printed
 * all its replies. */
static void wait(struct check *check, unsigned bytes)
{
    unsigned printed;

    rig_pass(check->rig, bytes * 90 * RIG_US);
    do {
        printed = text_size;
        rig_pass(check->rig, QUIET);
    } while (text_size != printed);
}

static uint32_t random_byte(uint32_t *random)
{
    uint32_t byte;
    do {
        *random = *random * 1664525u + 1013904223u;
        byte = *random >> 24;
    } while (byte == STOP);
    return byte;
}

enum flood { COMMANDS, WORDS, ONE_LINE, BINARY, FLOODS };

static void fill(char *bytes, enum flood flood, uint32_t random)
{
    static const char *const lines[] = {[COMMANDS] = "ping 1\n", [WORDS] = "no such command\n"};
    for (unsigned i = 0; i < FLOOD; i++) {
        switch (flood) {
        case COMMANDS:
        case WORDS: bytes[i] = lines[flood][i % strlen(lines[flood])]; break;
        case ONE_LINE: bytes[i] = 'x'; break;
        case BINARY:
        case FLOODS: bytes[i] = (char)random_byte(&random); break;
        }
    }
}

/* True if the console must answer the flood: one 0xFF in a line drops the line without a reply
 * (docs/bridge.md), so a line without 0xFF must be among them. */
static bool needs_reply(const char *bytes)
{
    bool whole = true;
    unsigned begin = 0; // of the line
    for (unsigned i = 0; i < FLOOD; i++) {
        if (bytes[i] == '\n' || bytes[i] == '\r') {
            if (whole && i > begin) {
                return true;
            }
            whole = true;
            begin = i + 1;
        } else if (bytes[i] == '\xFF') {
            whole = false;
        }
    }
    return whole && begin < FLOOD;
}

/* Checks that each line of the output is `ok` or a numbered error. Returns the number of errors. */
static unsigned errors_printed(struct check *check)
{
    unsigned errors = 0;
    for (char *line = strtok(text, "\r\n"); line; line = strtok(0, "\r\n")) {
        unsigned number = 0;
        char more = 0;
        if (sscanf(line, "error %u: %c", &number, &more) == 2) {
            errors++;
        } else if (strcmp(line, "ok") != 0) {
            check_fail(check, "the console printed \"%.30s\"", line);
        }
    }
    return errors;
}

/* Checks that the controller sent only complete PINGs of servo 1 and released the driver in time.
 */
static void check_bus(struct check *check)
{
    static const uint8_t ping[] = {0xFF, 0xFF, 1, 2, 1, 0xFB};
    const struct tap *sent = &check->rig->sent;
    for (unsigned i = 0; i < sent->count && i < RIG_ROOM; i++) {
        const struct tap_byte *byte = &sent->bytes[i];
        if (byte->byte != ping[i % sizeof(ping)]) {
            check_fail(check, "sent %02X on the bus", byte->byte);
        }
    }
    if (sent->count == 0 || sent->count % sizeof(ping)) {
        check_fail(check, "%u bytes on the bus", sent->count);
    }
    for (unsigned rule = 0; rule < RULE_COUNT; rule++) {
        if (check->rig->bench.rules.breaches[rule]) {
            check_fail(check, "rule broken: %s", rule_name(rule));
        }
    }
}

static void flood(struct check *check)
{
    rig_node(check->rig, 0)->servo.registers[TABLE_RETURN_DELAY] = RETURN_DELAY;
    for (enum flood kind = 0; kind < FLOODS; kind++) {
        for (unsigned phase = 0; phase < 100; phase++) {
            char bytes[FLOOD];
            if (!check_next(check, "flood %u, phase %u", kind, phase)) {
                continue;
            }
            fill(bytes, kind, phase + 1);
            text_size = 0;
            host_sends(check, "ping 1\n", 7);
            rig_pass(check->rig, 7 * 87 * RIG_US + phase * 13);
            host_sends(check, bytes, FLOOD);
            wait(check, FLOOD);
            host_sends(check, "\n", 1); // ends the line that the flood has begun
            wait(check, 1);
            bool numbered = errors_printed(check) > 0;
            if (!numbered && kind != COMMANDS && needs_reply(bytes)) {
                check_fail(check, "the console printed no error");
            }
            text_size = 0;
            host_sends(check, "ping 1\n", 7);
            wait(check, 7);
            if (strcmp(text, "ok\r\n") != 0 && strcmp(text, "ok\n") != 0) {
                check_fail(check, "the next command was answered \"%.30s\"", text);
            }
            check_bus(check);
        }
    }
}

const struct row rows_host[] = {
    {"F14",
     "host floods the console: commands, words, a line without end, binary; return delay 10 us",
     "1", flood, "atmega128 arbotix"},
    {0},
};
