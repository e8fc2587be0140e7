#include "script/environment.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "script/lexer.h"

static const struct cause_row {
    const char *word;
    int32_t scale; // 0: on or off
    int32_t lowest, highest;
    const char *wanted;
} rows[CAUSE_COUNT] = {
    [CAUSE_POWER] = {"power", 0, 0, 1, "on or off is wanted"},
    [CAUSE_SUPPLY] = {"supply", 10, 0, 255, "volts are wanted, 0 to 25.5"},
    [CAUSE_AMBIENT] = {"ambient", 1, 0, 255, "degrees Celsius are wanted, 0 to 255"},
    [CAUSE_LOAD] = {"load", 1, -2046, 2046, "a load is wanted, -2046 to 2046 (1023: stall)"},
    [CAUSE_BLOCK] = {"block", 0, 0, 1, "on or off is wanted"},
};

enum cause cause_find(const char *word)
{
    enum cause cause = 0;
    while (cause < CAUSE_COUNT && strcmp(rows[cause].word, word) != 0) {
        cause++;
    }
    return cause;
}

bool cause_is_quantity(enum cause cause)
{
    return rows[cause].scale != 0;
}

const char *cause_parse(enum cause cause, const char *text, int32_t *value)
{
    const struct cause_row *row = &rows[cause];
    bool on = false;
    bool good = row->scale ? words_decimal(text, row->scale, row->lowest, row->highest, value)
                           : words_switch(text, &on);
    if (good && !row->scale) {
        *value = on;
    }
    return good ? 0 : row->wanted;
}

static int32_t value_of(const struct servo_node *node, enum cause cause)
{
    const struct servo_world *world = &node->servo.world;
    switch (cause) {
    case CAUSE_SUPPLY: return world->supply_dV;
    case CAUSE_AMBIENT: return world->ambient_C;
    default: return world->load; // what is no quantity has no ramp
    }
}

static void set(struct servo_node *node, uint64_t now, enum cause cause, int32_t value)
{
    struct servo_world *world = &node->servo.world;
    switch (cause) {
    case CAUSE_POWER: servo_node_power(node, now, value != 0); break;
    case CAUSE_SUPPLY: world->supply_dV = (uint8_t)value; break;
    case CAUSE_AMBIENT: world->ambient_C = (uint8_t)value; break;
    case CAUSE_LOAD: world->load = (int16_t)value; break;
    default: world->blocked = value != 0; break;
    }
}

static void step(void *owner, uint64_t now)
{
    struct causes *causes = owner;
    unsigned kept = 0;
    for (unsigned i = 0; i < causes->count; i++) {
        struct ramp ramp = causes->ramp[i];
        bool over = now >= ramp.end;
        int64_t way = over ? ramp.to - ramp.from
                           : (ramp.to - ramp.from) * (int64_t)(now - ramp.start) /
                                 (int64_t)(ramp.end - ramp.start);
        set(ramp.node, now, ramp.cause, ramp.from + (int32_t)way);
        causes->ramp[kept] = ramp;
        kept += !over;
    }
    causes->count = kept;
    if (kept) {
        schedule_at(causes->schedule, &causes->step, now + causes->period);
    }
}

static void end_ramp(struct causes *causes, const struct servo_node *node, enum cause cause)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < causes->count; i++) {
        struct ramp ramp = causes->ramp[i];
        causes->ramp[kept] = ramp;
        kept += ramp.node != node || ramp.cause != cause;
    }
    causes->count = kept;
}

static void add_ramp(struct causes *causes, const struct ramp *ramp)
{
    if (causes->count == causes->room) {
        causes->room = causes->room ? causes->room * 2 : 32;
        struct ramp *bigger = realloc(causes->ramp, causes->room * sizeof(*bigger));
        if (!bigger) {
            fputs("out of memory\n", stderr);
            abort();
        }
        causes->ramp = bigger;
    }
    causes->ramp[causes->count++] = *ramp;
}

void causes_set(struct causes *causes, uint64_t now, struct servo_node *node, enum cause cause,
                int32_t value, uint64_t over)
{
    end_ramp(causes, node, cause);
    if (over == 0) {
        set(node, now, cause, value);
        return;
    }
    struct ramp ramp = {node, cause, value_of(node, cause), value, now, now + over};
    add_ramp(causes, &ramp);
    if (!event_armed(&causes->step)) {
        schedule_at(causes->schedule, &causes->step, now + causes->period);
    }
}

void causes_forget(struct causes *causes)
{
    causes->count = 0;
}

void causes_init(struct causes *causes, struct schedule *schedule, uint32_t clock_Hz)
{
    *causes = (struct causes){.schedule = schedule, .period = clock_Hz / 1000};
    event_init(&causes->step, step, causes);
}

void causes_free(struct causes *causes)
{
    free(causes->ramp);
    causes->ramp = 0;
    causes->count = causes->room = 0;
}
