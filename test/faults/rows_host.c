/* A PC that floods the console while servos are spoken to: F14. With the controller's own firmware.
 */
#include "rows.h"

#include <string.h>

#define FLOOD     1500 // bytes, at the rate of the line without a gap
#define TEXT_ROOM 65536
#define PATIENCE  5    // register 0x05, 10 us: the handlers of the host link hold up the release
#define STOP      0x18 // Ctrl-X: torque off for all, which is no PING

static char text[TEXT_ROOM]; // what the console said
static unsigned text_size;

static void console_says(void *context, uint64_t now, uint8_t byte)
{
    (void)context, (void)now;
    if (text_size + 1 < TEXT_ROOM) {
        text[text_size++] = (char)byte;
        text[text_size] = 0;
    }
}

static void say(struct check *check, const char *bytes, unsigned size)
{
    struct testbench *bench = &check->rig->bench;
    bench->host_link.adapter.on_byte = console_says;
    host_link_send(&bench->host_link, rig_now(check->rig), bytes, size);
}

/* Until all is said and answered: a byte takes 87 us. */
static void wait(struct check *check, unsigned bytes)
{
    rig_pass(check->rig, (bytes * 90 + 60000) * RIG_US);
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

/* Every line is part of a reply that the help knows; returns how many were numbered errors. */
static unsigned errors_told(struct check *check)
{
    unsigned errors = 0;
    for (char *line = strtok(text, "\r\n"); line; line = strtok(0, "\r\n")) {
        unsigned number = 0;
        char more = 0;
        if (sscanf(line, "error %u: %c", &number, &more) == 2) {
            errors++;
        } else if (strcmp(line, "ok") != 0) {
            check_fail(check, "the console said \"%.30s\"", line);
        }
    }
    return errors;
}

/* Whole PINGs of servo 1, and the line let go of before it answers. */
static void check_bus(struct check *check)
{
    static const uint8_t ping[] = {0xFF, 0xFF, 1, 2, 1, 0xFB};
    const struct tap *sent = &check->rig->sent;
    for (unsigned i = 0; i < sent->count && i < RIG_ROOM; i++) {
        const struct tap_byte *byte = &sent->bytes[i];
        if (byte->byte != ping[i % sizeof(ping)]) {
            check_fail(check, "said %02X on the bus", byte->byte);
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
    rig_node(check->rig, 0)->servo.registers[TABLE_RETURN_DELAY] = PATIENCE;
    for (enum flood kind = 0; kind < FLOODS; kind++) {
        for (unsigned phase = 0; phase < 100; phase++) {
            char bytes[FLOOD];
            if (!check_next(check, "flood %u, phase %u", kind, phase)) {
                continue;
            }
            fill(bytes, kind, phase + 1);
            text_size = 0;
            say(check, "ping 1\n", 7);
            rig_pass(check->rig, 7 * 87 * RIG_US + phase * 13);
            say(check, bytes, FLOOD);
            wait(check, FLOOD);
            say(check, "\n", 1); // ends what the flood has begun
            wait(check, 1);
            bool numbered = errors_told(check) > 0;
            if (!numbered && kind != COMMANDS) {
                check_fail(check, "no error was told");
            }
            text_size = 0;
            say(check, "ping 1\n", 7);
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
