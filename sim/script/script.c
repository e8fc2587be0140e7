#include "script/script.h"

#include <stdlib.h>
#include <string.h>

#include "script/lexer.h"

#define POLL_US        100   // for the firmware to listen, and for what is expected
#define PACKET_US      100   // after one that was expected
#define READY_AFTER_US 1000  // a PC is not that fast either
#define RESET_AFTER_US 10000 // the rest of a line is answered meanwhile

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
    return script->next ? current(script)->number : 0;
}

static void step_at(struct script *script, uint64_t time)
{
    schedule_at(script->schedule, &script->step, time);
}

static void finish(struct script *script, uint64_t now)
{
    script->done = true;
    script->world->finished(script->world->owner, now);
}

static void unmet(struct script *script, uint64_t now, const char *what)
{
    script->world->outcome(script->world->owner, now, SCRIPT_UNMET, what);
    finish(script, now);
}

/* --- the lines -----------------------------------------------------------------------------------
 */

/* Each returns true when the next line may follow at once; else the step was put off, or the
 * scenario is over. */

static bool do_command(struct script *script, uint64_t now, const struct scenario_line *line)
{
    if (script->echo) {
        fprintf(script->out, "> %s\n", line->text);
    }
    script->waiting = true;
    script->world->say(script->world->owner, now, line->text, strlen(line->text));
    script->world->say(script->world->owner, now, "\n", 1);
    uint64_t patience = cycles(script, SCRIPT_PATIENCE_S * 1000000ull);
    schedule_at(script->schedule, &script->patience, now + patience);
    return false;
}

static bool do_servos(struct script *script, uint64_t now, const struct scenario_line *line)
{
    uint8_t ids[IDS_MAX];
    unsigned count = 0;
    ids_parse(line->text, true, ids, &count);
    causes_forget(&script->causes);
    script->world->servos(script->world->owner, now, ids, count);
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
        unmet(script, now, what);
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
    script->world->echo(script->world->owner, line->flag);
    return true;
}

static bool do_baud(struct script *script, uint64_t now, const struct scenario_line *line)
{
    (void)now;
    script->world->baud(script->world->owner, (uint32_t)line->value);
    return true;
}

static bool do_send(struct script *script, uint64_t now, const struct scenario_line *line)
{
    uint8_t bytes[SCENARIO_SEND_MAX];
    size_t size = 0;
    struct words_byte byte;
    for (const char *at = line->text; size < SCENARIO_SEND_MAX && words_byte(&at, &byte); size++) {
        bytes[size] = byte.byte;
    }
    step_at(script, script->world->send(script->world->owner, now, bytes, size));
    return false;
}

static bool do_fault(struct script *script, uint64_t now, const struct scenario_line *line)
{
    const char *wrong = script->world->fault(script->world->owner, now, line->text);
    if (wrong) {
        char what[200];
        snprintf(what, sizeof(what), "%.80s: %s", line->source, wrong);
        unmet(script, now, what);
    }
    return !wrong;
}

static bool do_upset(struct script *script, uint64_t now, const struct scenario_line *line)
{
    script->world->upset(script->world->owner, now, &line->upset);
    step_at(script, now + 1); // what happens now happens before the next line
    return false;
}

static bool do_cause(struct script *script, uint64_t now, const struct scenario_line *line)
{
    const struct script_world *world = script->world;
    uint64_t over = cycles(script, line->ms * 1000ull);
    struct servos *servos;
    for (unsigned bus = 0; (servos = world->bus(world->owner, bus)) != 0; bus++) {
        for (unsigned i = 0; i < servos->count; i++) {
            struct servo_node *node = &servos->node[i];
            if (line->all || line->ids[node->id]) {
                causes_set(&script->causes, now, node, line->cause, line->value, over);
            }
        }
    }
    return true;
}

static bool do_expect(struct script *script, uint64_t now, const struct scenario_line *line)
{
    struct expect_scene *scene = &script->scene;
    if (!script->expecting) {
        scene->edges = script->witness.edges;
        scene->end = now + cycles(script, line->expectation.ms * 1000ull);
    }
    char seen[400] = "";
    enum expect_verdict verdict = expect_judge(&line->expectation, scene, now, seen, sizeof(seen));
    script->expecting = verdict == EXPECT_NOT_YET && now < scene->end;
    if (script->expecting) {
        uint64_t poll = now + cycles(script, POLL_US);
        step_at(script, poll < scene->end ? poll : scene->end);
    } else if (verdict != EXPECT_MET) {
        char what[800];
        snprintf(what, sizeof(what), "%.300s: not met; seen: %s", line->source, seen);
        unmet(script, now, what);
    }
    if (verdict == EXPECT_MET && line->expectation.kind == EXPECT_PACKET) {
        step_at(script, now + cycles(script, PACKET_US)); // it is told in its last stop bit
        return false;
    }
    return verdict == EXPECT_MET;
}

static bool do_show(struct script *script, uint64_t now, const struct scenario_line *line)
{
    (void)now;
    expect_show(&line->expectation, &script->scene, script->out);
    return true;
}

/* What is forgotten of what was seen. */
enum memory { KEEPS, FORGETS_BEFORE, FORGETS_AFTER };

static const struct {
    bool (*run)(struct script *script, uint64_t now, const struct scenario_line *line);
    enum memory memory;
} verbs[] = {
    [SCENARIO_COMMAND] = {do_command, FORGETS_BEFORE},
    [SCENARIO_SERVOS] = {do_servos, KEEPS},
    [SCENARIO_WAIT] = {do_wait, FORGETS_AFTER},
    [SCENARIO_AT] = {do_at, FORGETS_AFTER},
    [SCENARIO_PRINT] = {do_print, KEEPS},
    [SCENARIO_ECHO] = {do_echo, KEEPS},
    [SCENARIO_BAUD] = {do_baud, KEEPS},
    [SCENARIO_SEND] = {do_send, FORGETS_BEFORE},
    [SCENARIO_FAULT] = {do_fault, KEEPS},
    [SCENARIO_CAUSE] = {do_cause, KEEPS},
    [SCENARIO_UPSET] = {do_upset, KEEPS},
    [SCENARIO_EXPECT] = {do_expect, KEEPS},
    [SCENARIO_SHOW] = {do_show, KEEPS},
};

/* --- line after line -----------------------------------------------------------------------------
 */

/* Does the console listen? If not, the command waits until it does. */
static bool listens(struct script *script, uint64_t now)
{
    if (!script->started && !script->held) {
        script->held = true;
        schedule_at(script->schedule, &script->patience,
                    now + cycles(script, SCRIPT_PATIENCE_S * 1000000ull));
    }
    return script->started;
}

static void forget(struct script *script, enum memory memory)
{
    if (script->next && verbs[current(script)->verb].memory == memory) {
        witness_forget(&script->witness);
    }
}

static void step(void *owner, uint64_t now)
{
    struct script *script = owner;
    if (script->started) {
        schedule_cancel(script->schedule, &script->patience);
    }
    forget(script, FORGETS_AFTER);
    bool go_on = !script->expecting || do_expect(script, now, current(script));
    while (go_on && script->next < script->scenario.count) {
        const struct scenario_line *line = &script->scenario.line[script->next];
        if (line->verb == SCENARIO_COMMAND && !listens(script, now)) {
            return;
        }
        script->next++;
        forget(script, FORGETS_BEFORE);
        go_on = verbs[line->verb].run(script, now, line);
    }
    if (go_on) {
        finish(script, now);
    }
}

/* Whatever the scenario does meanwhile. */
static void knock(void *owner, uint64_t now)
{
    struct script *script = owner;
    if (!script->ready) {
        script->ready = script->world->ready(script->world->owner);
        schedule_at(script->schedule, &script->knock,
                    now + cycles(script, script->ready ? script->hush_us : POLL_US));
        return;
    }
    if (script->hush_us == RESET_AFTER_US) {
        script->reply_size = 0; // half a byte of before the reset
    }
    script->started = true;
    if (script->held) {
        script->held = false;
        step(script, now);
    }
}

static void out_of_patience(void *owner, uint64_t now)
{
    struct script *script = owner;
    const char *what = "the firmware never listened";
    if (script->started) {
        what = current(script)->text;
    } else {
        script->next++; // to the line that nobody listened to
        schedule_cancel(script->schedule, &script->knock);
    }
    script->world->outcome(script->world->owner, now, SCRIPT_SILENCE, what);
    finish(script, now);
}

/* --- what comes back -----------------------------------------------------------------------------
 */

static void reply_line(struct script *script, uint64_t now)
{
    const char *reply = script->reply;
    if (script->echo) {
        fprintf(script->out, "%s\n", reply);
    }
    witness_reply(&script->witness, reply);
    bool error = strncmp(reply, "error ", 6) == 0;
    if (!script->waiting || (!error && strcmp(reply, "ok") != 0)) {
        return;
    }
    script->waiting = false;
    const struct scenario_line *line = current(script);
    char what[SCRIPT_REPLY_ROOM * 2];
    snprintf(what, sizeof(what), "%.180s: %s", line->text, reply);
    enum script_outcome outcome = error == line->flag ? SCRIPT_GOOD
                                  : error             ? SCRIPT_UNEXPECTED_ERROR
                                                      : SCRIPT_UNEXPECTED_OK;
    script->world->outcome(script->world->owner, now, outcome, what);
    step_at(script, now);
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

void script_packet(struct script *script, const struct transcript *transcript)
{
    witness_packet(&script->witness, transcript);
}

void script_was_reset(struct script *script, uint64_t now)
{
    script->ready = script->started = false;
    script->hush_us = RESET_AFTER_US;
    if (script->world->ready && !script->done) {
        schedule_at(script->schedule, &script->knock, now);
    }
    if (script->waiting) {
        script->waiting = false;
        schedule_cancel(script->schedule, &script->patience);
        step_at(script, now);
    }
}

/* --- begin and end -------------------------------------------------------------------------------
 */

static const char *lacks(const struct script_world *world, enum scenario_verb verb)
{
    switch (verb) {
    case SCENARIO_COMMAND:
        return world->say    ? 0
               : world->send ? "there is no console here: use @send"
                             : "there is no console here: only lines that begin with @";
    case SCENARIO_SEND:
    case SCENARIO_BAUD: return world->send ? 0 : "only without firmware: cds55xx-sim bus";
    case SCENARIO_UPSET: return world->upset ? 0 : "there is no controller here";
    case SCENARIO_FAULT: return world->fault ? 0 : "no faults can be ordered here";
    default: return 0;
    }
}

/* An ID stands twice, and the bus is not one that may have that. */
static const char *collides(const struct script_world *world, const struct scenario_line *line)
{
    uint8_t ids[IDS_MAX];
    unsigned count = 0;
    const struct servos *servos = world->bus(world->owner, 0);
    bool allowed = line->verb != SCENARIO_SERVOS || !servos || servos->duplicates;
    return allowed || !ids_parse(line->text, false, ids, &count)
               ? 0
               : "an ID occurs twice, and there is no --allow-duplicates";
}

static bool check(const struct script *script)
{
    const struct script_world *world = script->world;
    bool there[IDS_MAX] = {false};
    const struct servos *servos;
    for (unsigned bus = 0; (servos = world->bus(world->owner, bus)) != 0; bus++) {
        for (unsigned i = 0; i < servos->count; i++) {
            there[servos->node[i].id] = true;
        }
    }
    for (unsigned i = 0; i < script->scenario.count; i++) {
        const struct scenario_line *line = &script->scenario.line[i];
        char what[80];
        int absent = scenario_absent(line, there);
        snprintf(what, sizeof(what), "there is no servo %d at this line", absent);
        const char *wrong = absent >= 0 ? what : lacks(world, line->verb);
        wrong = wrong ? wrong : collides(world, line);
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

bool script_start(struct script *script, struct schedule *schedule, uint32_t clock_Hz,
                  const struct script_world *world, FILE *out)
{
    script->schedule = schedule;
    script->clock_Hz = clock_Hz;
    script->world = world;
    script->out = out;
    script->hush_us = READY_AFTER_US;
    causes_init(&script->causes, schedule, clock_Hz);
    witness_init(&script->witness);
    struct servos *servos;
    for (unsigned bus = 0; (servos = world->bus(world->owner, bus)) != 0; bus++) {
        witness_watch(&script->witness, servos->net);
    }
    script->scene = (struct expect_scene){.witness = &script->witness,
                                          .rules = world->rules,
                                          .bus = world->bus,
                                          .owner = world->owner};
    event_init(&script->step, step, script);
    event_init(&script->patience, out_of_patience, script);
    event_init(&script->knock, knock, script);
    if (world->ready) {
        schedule_at(schedule, &script->knock, schedule->now);
    }
    step_at(script, schedule->now + (world->ready ? cycles(script, READY_AFTER_US) : 0));
    return check(script);
}

void script_free(struct script *script)
{
    causes_free(&script->causes);
    scenario_free(&script->scenario);
}
