/* SPDX-License-Identifier: MIT */
#include "script/script.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "script/lexer.h"

#define POLL_US           100   // period of the checks: firmware listens, expectation is met
#define PACKET_US         100   // after an expected packet
#define READY_AFTER_US    1000  // a PC does not send earlier
#define SCRIPT_ORDER_SIZE 4200  // an @send of 1024 bytes fits
#define RESET_AFTER_US    10000 // meanwhile the firmware replies to the end of a cut line

static uint64_t cycles(const struct script *script, uint64_t us)
{
    return us * script->clock_Hz / 1000000;
}

static const struct scenario_line *current(const struct script *script)
{
    return &script->scenario.line[script->next - 1];
}

unsigned script_line_number(const struct script *script)
{
    unsigned lines = script->next + script->enters; // the command behind `mode program` has begun
    return lines ? script->scenario.line[lines - 1].number : 0;
}

static void step_at(struct script *script, uint64_t time)
{
    schedule_at(script->schedule, &script->step, time);
}

static void finish(struct script *script, uint64_t now)
{
    script->done = true;
    script->ops->finished(script->ops->context, now);
}

/* Ends the scenario: a line asks for what is not there, or an expectation was not met. */
static void fail_expectation(struct script *script, uint64_t now, const char *what)
{
    script->ops->outcome(script->ops->context, now, SCRIPT_UNMET, what);
    finish(script, now);
}

/* Returns how many servos there are, on all buses. */
static unsigned find_servos(const struct script_ops *ops, bool there[IDS_MAX])
{
    const struct servos *servos;
    unsigned count = 0;
    for (unsigned bus = 0; (servos = ops->bus(ops->context, bus)) != 0; bus++) {
        for (unsigned i = 0; i < servos->count; i++) {
            there[servos->node[i].id] = true;
        }
        count += servos->count;
    }
    return count;
}

/* --- the lines --- */

/* Each function returns true if the next line may follow at once. Else it has armed the next step,
 * or the scenario has ended. */

static bool do_command(struct script *script, uint64_t now, const struct scenario_line *line)
{
    if (script->echo) {
        fprintf(script->out, "> %s\n", line->text);
    }
    script->awaits_reply = true;
    script->ops->console_send(script->ops->context, now, line->text, strlen(line->text));
    script->ops->console_send(script->ops->context, now, "\n", 1);
    schedule_at(script->schedule, &script->reply_timeout, now + cycles(script, line->ms * 1000ull));
    return false;
}

static bool do_servos(struct script *script, uint64_t now, const struct scenario_line *line)
{
    uint8_t ids[IDS_MAX];
    unsigned count = 0;
    ids_parse(line->text, true, ids, &count);
    environment_stop_ramps(&script->environment);
    script->ops->servos(script->ops->context, now, ids, count);
    return true;
}

static bool do_wait(struct script *script, uint64_t now, const struct scenario_line *line)
{
    step_at(script, now + cycles(script, line->ms * 1000ull));
    return false;
}

static bool do_at(struct script *script, uint64_t now, const struct scenario_line *line)
{
    uint64_t time = cycles(script, line->ms * 1000ull);
    if (time < now) {
        char what[80];
        snprintf(what, sizeof(what), "@at %u: it is %.3f ms already", line->ms,
                 (double)now * 1000.0 / script->clock_Hz);
        fail_expectation(script, now, what);
    } else {
        step_at(script, time);
    }
    return false;
}

static bool do_print(struct script *script, uint64_t now, const struct scenario_line *line)
{
    (void)now;
    fprintf(script->out, "%s\n", line->text);
    return true;
}

static bool do_echo(struct script *script, uint64_t now, const struct scenario_line *line)
{
    (void)now;
    script->echo = line->flag;
    script->ops->echo(script->ops->context, line->flag);
    return true;
}

static bool do_baud(struct script *script, uint64_t now, const struct scenario_line *line)
{
    (void)now;
    script->ops->bus_baud(script->ops->context, (uint32_t)line->value);
    return true;
}

static bool do_send(struct script *script, uint64_t now, const struct scenario_line *line)
{
    uint8_t bytes[SCENARIO_SEND_MAX];
    size_t size = 0;
    struct lexer_byte byte;
    for (const char *at = line->text; size < SCENARIO_SEND_MAX && lexer_byte(&at, &byte); size++) {
        bytes[size] = byte.byte;
    }
    step_at(script, script->ops->bus_send(script->ops->context, now, bytes, size));
    return false;
}

static bool do_fault(struct script *script, uint64_t now, const struct scenario_line *line)
{
    const char *wrong = script->ops->fault(script->ops->context, now, line->text);
    if (wrong) {
        char what[200];
        snprintf(what, sizeof(what), "%.80s: %s", line->source, wrong);
        fail_expectation(script, now, what);
    }
    return !wrong;
}

static bool do_reset(struct script *script, uint64_t now, const struct scenario_line *line)
{
    const struct reset_order *order = &line->reset;
    // Only a script whose console has listened is told of the reset; a poke is not.
    script->awaits_reset = script->started && !order->hang && !order->writes && order->us == 0;
    script->ops->reset(script->ops->context, now, order);
    if (!script->awaits_reset) {
        step_at(script, now + 1); // what happens now happens before the next line
    }
    return false;
}

/* `@load 1` is for all servos; a person may have meant servo 1. */
static void warn_of_no_ids(const struct script *script, const struct scenario_line *line)
{
    bool there[IDS_MAX] = {false};
    find_servos(script->ops, there);
    for (unsigned id = 0; id < IDS_MAX && line->all && script->scenario.path; id++) {
        if (there[id] && environment_equals_id(line->property, line->value, id)) {
            fprintf(script->out,
                    "%s:%u: warning: '%s' is for all servos; for servo %u a value is missing\n",
                    script->scenario.path, line->number, line->source, id);
        }
    }
}

static bool do_environment(struct script *script, uint64_t now, const struct scenario_line *line)
{
    const struct script_ops *ops = script->ops;
    uint64_t over = cycles(script, line->ms * 1000ull);
    struct servos *servos;
    unsigned place = 0;
    for (unsigned bus = 0; (servos = ops->bus(ops->context, bus)) != 0; bus++) {
        for (unsigned i = 0; i < servos->count; i++) {
            struct servo_node *node = &servos->node[i];
            if (++place == line->place || line->all || line->ids[node->id]) {
                environment_set(&script->environment, now, node, line->property, line->value, over);
            }
        }
    }
    warn_of_no_ids(script, line);
    return true;
}

/* A fresh servo stands at 512: an expectation of this value is met without any firmware. */
static void warn_of_fresh_servo(const struct script *script, const struct scenario_line *line)
{
    bool is_register =
        line->expectation.kind == EXPECT_SERVO && line->expectation.subject == EXPECT_REGISTER;
    if (is_register && script->ops->reset && script->scenario.path && !script->recorder.edges) {
        fprintf(script->out,
                "%s:%u: warning: met before the firmware has sent a packet; first let "
                "'@expect servo IDS torque on' wait for it\n",
                script->scenario.path, line->number);
    }
}

static bool do_expect(struct script *script, uint64_t now, const struct scenario_line *line)
{
    struct expect_sources *sources = &script->sources;
    if (!script->expecting) {
        sources->edges = script->recorder.edges;
        sources->end = now + cycles(script, line->expectation.ms * 1000ull);
    }
    char seen[400] = "";
    enum expect_result result = expect_check(&line->expectation, sources, now, seen, sizeof(seen));
    script->expecting = result == EXPECT_PENDING && now < sources->end;
    if (script->expecting) {
        uint64_t poll = now + cycles(script, POLL_US);
        step_at(script, poll < sources->end ? poll : sources->end);
    } else if (result != EXPECT_MET) {
        script->unmet = true;
        char what[800];
        snprintf(what, sizeof(what), "%.300s: not met; seen: %s", line->source, seen);
        fail_expectation(script, now, what);
    }
    if (result == EXPECT_MET) {
        warn_of_fresh_servo(script, line);
    }
    if (result == EXPECT_MET && line->expectation.kind == EXPECT_PACKET) {
        step_at(script,
                now +
                    cycles(script,
                           PACKET_US)); // the packet is reported in the middle of its last stop bit
        return false;
    }
    return result == EXPECT_MET;
}

static bool do_show(struct script *script, uint64_t now, const struct scenario_line *line)
{
    (void)now;
    expect_show(&line->expectation, &script->sources, script->out);
    return true;
}

/* When a line clears the recorder. */
enum clearing { CLEAR_NEVER, CLEAR_BEFORE, CLEAR_AFTER };

static const struct {
    bool (*run)(struct script *script, uint64_t now, const struct scenario_line *line);
    enum clearing clearing;
} verbs[] = {
    [SCENARIO_COMMAND] = {do_command, CLEAR_BEFORE},
    [SCENARIO_SERVOS] = {do_servos, CLEAR_NEVER},
    [SCENARIO_WAIT] = {do_wait, CLEAR_AFTER},
    [SCENARIO_AT] = {do_at, CLEAR_AFTER},
    [SCENARIO_PRINT] = {do_print, CLEAR_NEVER},
    [SCENARIO_ECHO] = {do_echo, CLEAR_NEVER},
    [SCENARIO_BAUD] = {do_baud, CLEAR_NEVER},
    [SCENARIO_SEND] = {do_send, CLEAR_BEFORE},
    [SCENARIO_FAULT] = {do_fault, CLEAR_NEVER},
    [SCENARIO_ENVIRONMENT] = {do_environment, CLEAR_NEVER},
    [SCENARIO_RESET] = {do_reset, CLEAR_NEVER},
    [SCENARIO_EXPECT] = {do_expect, CLEAR_NEVER},
    [SCENARIO_SHOW] = {do_show, CLEAR_NEVER},
};

/* --- line after line --- */

/* Returns true if the console listens. Else the command waits until it does. */
static bool listens(struct script *script, uint64_t now)
{
    if (!script->started && !script->command_waits) {
        script->command_waits = true;
        schedule_at(script->schedule, &script->reply_timeout,
                    now + cycles(script, SCENARIO_REPLY_MS * 1000ull));
    }
    return script->started;
}

/* Sends `mode program`, before the first command after a reset: from then on the console prints
 * nothing but replies. */
static void enter_mode_program(struct script *script, uint64_t now)
{
    static const char line[] = "mode program\n";
    script->enters = true;
    script->ops->console_send(script->ops->context, now, line, sizeof(line) - 1);
    schedule_at(script->schedule, &script->reply_timeout,
                now + cycles(script, SCENARIO_REPLY_MS * 1000ull));
}

static void clear_records(struct script *script, enum clearing clearing)
{
    if (script->next && verbs[current(script)->verb].clearing == clearing) {
        recorder_clear(&script->recorder);
    }
}

static void step(void *context, uint64_t now)
{
    struct script *script = context;
    if (script->started) {
        schedule_cancel(script->schedule, &script->reply_timeout);
    }
    clear_records(script, CLEAR_AFTER);
    bool go_on = !script->expecting || do_expect(script, now, current(script));
    while (go_on && script->next < script->scenario.count) {
        const struct scenario_line *line = &script->scenario.line[script->next];
        if (line->verb == SCENARIO_COMMAND && !listens(script, now)) {
            return;
        }
        if (line->verb == SCENARIO_COMMAND && !script->is_program) {
            enter_mode_program(script, now);
            return;
        }
        script->next++;
        clear_records(script, CLEAR_BEFORE);
        go_on = verbs[line->verb].run(script, now, line);
    }
    if (go_on) {
        finish(script, now);
    }
}

/* Checks whether the firmware listens, independently of the scenario. */
static void probe(void *context, uint64_t now)
{
    struct script *script = context;
    if (!script->ready) {
        script->ready = script->ops->console_ready(script->ops->context);
        schedule_at(script->schedule, &script->probe,
                    now + cycles(script, script->ready ? script->quiet_us : POLL_US));
        return;
    }
    if (script->quiet_us == RESET_AFTER_US) {
        script->reply_size = 0; // half a line from before the reset
    }
    script->started = true;
    if (script->command_waits) {
        script->command_waits = false;
        step(script, now);
    }
}

static void reply_timed_out(void *context, uint64_t now)
{
    struct script *script = context;
    char what[SCRIPT_REPLY_SIZE * 2] = "the firmware never listened";
    if (script->enters) {
        script->enters = false;
        script->next++; // to the line that the firmware did not receive
        snprintf(what, sizeof(what),
                 "%.180s: not sent; no reply to 'mode program' in %u ms, neither 'ok' nor "
                 "'error N: text'",
                 current(script)->text, SCENARIO_REPLY_MS);
    } else if (script->started) {
        snprintf(what, sizeof(what),
                 "%.180s: no reply in %u ms, neither 'ok' nor 'error N: text'; if it takes longer, "
                 "write 'within MS' at the end of the line",
                 current(script)->text, current(script)->ms);
    } else {
        script->next++; // to the line that the firmware did not receive
        schedule_cancel(script->schedule, &script->probe);
    }
    script->ops->outcome(script->ops->context, now, SCRIPT_SILENCE, what);
    finish(script, now);
}

/* --- what comes back --- */

static void reply_line(struct script *script, uint64_t now)
{
    const char *reply = script->reply;
    bool error = strncmp(reply, "error ", 6) == 0, ends = error || strcmp(reply, "ok") == 0;
    if (script->enters) { // a firmware without the command has no other mode
        script->is_program = ends;
        script->enters = !ends;
        if (ends) {
            step_at(script, now);
        }
        return;
    }
    if (script->echo) {
        fprintf(script->out, "%s\n", reply);
    }
    recorder_add_line(&script->recorder, reply);
    if (!script->awaits_reply || !ends) {
        return;
    }
    script->awaits_reply = false;
    const struct scenario_line *line = current(script);
    char what[SCRIPT_REPLY_SIZE * 2];
    snprintf(what, sizeof(what), "%.180s: %s", line->text, reply);
    enum script_outcome outcome = error == line->flag ? SCRIPT_GOOD
                                  : error             ? SCRIPT_UNEXPECTED_ERROR
                                                      : SCRIPT_UNEXPECTED_OK;
    script->ops->outcome(script->ops->context, now, outcome, what);
    step_at(script, now);
}

void script_receive(struct script *script, uint64_t now, uint8_t byte)
{
    if (byte == '\n') {
        script->reply[script->reply_size] = 0;
        script->reply_size = 0;
        reply_line(script, now);
    } else if (byte != '\r' && script->reply_size < SCRIPT_REPLY_SIZE - 1) {
        script->reply[script->reply_size++] = (char)byte;
    }
}

void script_record_packet(struct script *script, const struct transcript *transcript)
{
    recorder_add_packet(&script->recorder, transcript);
}

void script_was_reset(struct script *script, uint64_t now)
{
    script->ready = script->started = false;
    script->quiet_us = RESET_AFTER_US;
    if (script->ops->console_ready && !script->done) {
        schedule_at(script->schedule, &script->probe, now);
    }
    script->is_program = false;
    if (script->awaits_reset || script->awaits_reply || script->enters) {
        script->awaits_reset = script->awaits_reply = script->enters = false;
        schedule_cancel(script->schedule, &script->reply_timeout);
        step_at(script, now);
    }
}

/* --- begin and end --- */

static const char *missing_part(const struct script_ops *ops, const struct scenario_line *line)
{
    switch (line->verb) {
    case SCENARIO_COMMAND:
        return ops->console_send ? 0
               : ops->bus_send   ? "there is no console here: use @send"
                                 : "there is no console here: only lines that begin with @";
    case SCENARIO_SEND:
    case SCENARIO_BAUD: return ops->bus_send ? 0 : "only without firmware: cds55xx-sim bus";
    case SCENARIO_RESET: return ops->reset ? 0 : "there is no controller here";
    case SCENARIO_FAULT: return ops->fault ? 0 : "no faults can be ordered here";
    case SCENARIO_EXPECT:
        return line->expectation.kind != EXPECT_TEXT || ops->has_text ? 0
               : ops->bus_send ? "there is no firmware here that prints text"
                               : "the board has no USART for text: board.h has no BOARD_HOST_USART";
    default: return 0;
    }
}

/* The servos that are there when a line runs. */
struct present {
    bool ids[IDS_MAX];
    unsigned count; // several may share an ID
};

/* Returns what is wrong if two servos have one ID on a bus that does not allow it. */
static const char *reset_conflict(const struct script_ops *ops, const struct scenario_line *line)
{
    uint8_t ids[IDS_MAX];
    unsigned count = 0;
    const struct servos *servos = ops->bus(ops->context, 0);
    bool allowed = line->verb != SCENARIO_SERVOS || !servos || servos->duplicates;
    return allowed || !ids_parse(line->text, false, ids, &count)
               ? 0
               : "an ID occurs twice, and there is no --allow-duplicates";
}

/* Returns 0, or why the line cannot run. Updates `present` for @servos. */
static const char *check_line(const struct script_ops *ops, const struct scenario_line *line,
                              struct present *present, const char *where,
                              char what[SCRIPT_WHAT_SIZE])
{
    char list[32];
    int absent = scenario_absent(line, present->ids);
    if (absent >= 0) {
        snprintf(what, SCRIPT_WHAT_SIZE, "there is no servo %d%s; there: %s", absent, where,
                 ids_print(present->ids, list, sizeof(list)));
        return what;
    }
    if (line->verb == SCENARIO_SERVOS) {
        uint8_t ids[IDS_MAX];
        ids_parse(line->text, true, ids, &present->count);
    }
    if (line->verb == SCENARIO_ENVIRONMENT && line->place > present->count) {
        snprintf(what, SCRIPT_WHAT_SIZE, "%.40s: there are %u servos%s", line->source,
                 present->count, where);
        return what;
    }
    const char *wrong = missing_part(ops, line);
    return wrong ? wrong : reset_conflict(ops, line);
}

static bool check(const struct script *script)
{
    struct present present = {{false}, 0};
    char what[SCRIPT_WHAT_SIZE];
    present.count = find_servos(script->ops, present.ids);
    for (unsigned i = 0; i < script->scenario.count; i++) {
        const struct scenario_line *line = &script->scenario.line[i];
        const char *wrong = check_line(script->ops, line, &present, " at this line", what);
        if (wrong) {
            return scenario_complain(&script->scenario, line->number, wrong);
        }
    }
    return true;
}

bool script_read(struct script *script, const char *path)
{
    *script = (struct script){0};
    return scenario_read(&script->scenario, path);
}

void script_start_empty(struct script *script, struct schedule *schedule, uint32_t clock_Hz,
                        const struct script_ops *ops, FILE *out)
{
    script->schedule = schedule;
    script->clock_Hz = clock_Hz;
    script->ops = ops;
    script->out = out;
    script->quiet_us = READY_AFTER_US;
    environment_init(&script->environment, schedule, clock_Hz);
    recorder_init(&script->recorder);
    struct servos *servos;
    for (unsigned bus = 0; (servos = ops->bus(ops->context, bus)) != 0; bus++) {
        recorder_watch(&script->recorder, servos->net);
    }
    script->sources = (struct expect_sources){.recorder = &script->recorder,
                                              .rules = ops->rules,
                                              .bus = ops->bus,
                                              .context = ops->context};
    event_init(&script->step, step, script);
    event_init(&script->reply_timeout, reply_timed_out, script);
    event_init(&script->probe, probe, script);
}

bool script_start(struct script *script, struct schedule *schedule, uint32_t clock_Hz,
                  const struct script_ops *ops, FILE *out)
{
    script_start_empty(script, schedule, clock_Hz, ops, out);
    if (ops->console_ready) {
        schedule_at(schedule, &script->probe, schedule->now);
    }
    step_at(script, schedule->now + (ops->console_ready ? cycles(script, READY_AFTER_US) : 0));
    return check(script);
}

const char *script_order(struct script *script, uint64_t now, const char *text,
                         char what[SCRIPT_WHAT_SIZE])
{
    char line[SCRIPT_ORDER_SIZE];
    struct present present = {{false}, 0};
    while (isspace((unsigned char)*text)) {
        text++;
    }
    if (snprintf(line, sizeof(line), "@%s", text + (*text == '@')) >= (int)sizeof(line)) {
        return "the line is too long";
    }
    const char *wrong = scenario_read_line(&script->scenario, line);
    present.count = find_servos(script->ops, present.ids);
    wrong = wrong ? wrong : check_line(script->ops, script->scenario.line, &present, "", what);
    if (!wrong) {
        script->next = 0;
        script->done = script->expecting = false;
        recorder_clear(&script->recorder);
        step_at(script, now);
    }
    return wrong;
}

void script_cancel(struct script *script)
{
    schedule_cancel(script->schedule, &script->step);
    script->done = true;
}

void script_free(struct script *script)
{
    environment_free(&script->environment);
    scenario_free(&script->scenario);
}
