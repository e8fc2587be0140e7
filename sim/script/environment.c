/* SPDX-License-Identifier: MIT */
#include "script/environment.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "memory.h"
#include "script/lexer.h"

/* Below this supply the electronics of a servo do not run, in 0.1 V. */
#define DEAD_BELOW_DV 30

static const struct property_row {
    const char *word;
    int32_t scale; // 0: on or off
    int32_t lowest, highest;
    const char *wanted; // as the value
    const char *form;   // of the line
} rows[ENVIRONMENT_COUNT] = {
    [ENVIRONMENT_POWER] =
        {"power", 0, 0, 1, "on or off is wanted behind power [IDS]",
         "wanted: power [IDS] on|off, IDS as in 1-3 or 1,5; without IDS: all servos"},
    [ENVIRONMENT_SUPPLY] =
        {"supply", 10, 0, 255, "volts are wanted, 0 to 25.5, without V",
         "wanted: supply [IDS] VOLTS [over MS], IDS as in 1-3 or 1,5; without IDS: all servos"},
    [ENVIRONMENT_AMBIENT] =
        {"ambient", 1, 0, 255, "degrees Celsius are wanted, 0 to 255",
         "wanted: ambient [IDS] CELSIUS [over MS], IDS as in 1-3 or 1,5; without IDS: all servos"},
    [ENVIRONMENT_LOAD] =
        {"load", 1, -2046, 2046, "a load is wanted, -2046 to 2046 (1023: stall)",
         "wanted: load [IDS] UNITS [over MS], IDS as in 1-3 or 1,5; without IDS: all servos"},
    [ENVIRONMENT_BLOCK] =
        {"block", 0, 0, 1, "on or off is wanted behind block [IDS]",
         "wanted: block [IDS] on|off, IDS as in 1-3 or 1,5; without IDS: all servos"},
};

enum environment_property environment_find(const char *word)
{
    enum environment_property property = 0;
    while (property < ENVIRONMENT_COUNT && strcmp(rows[property].word, word) != 0) {
        property++;
    }
    return property;
}

bool environment_equals_id(enum environment_property property, int32_t value, unsigned id)
{
    return id && rows[property].scale && value == (int32_t)id * rows[property].scale;
}

const char *environment_check_for_all(enum environment_property property, int32_t value)
{
    return property != ENVIRONMENT_SUPPLY || value == 0 || value >= DEAD_BELOW_DV
               ? 0
               : "without IDS it is for all servos, and below 3 V they are off: name the servo, as "
                 "in @supply 1 7.4; to switch all off: @power off";
}

bool environment_is_dead(const struct servo_node *node)
{
    return node->servo.environment.supply_dV < DEAD_BELOW_DV;
}

bool environment_is_quantity(enum environment_property property)
{
    return rows[property].scale != 0;
}

const char *environment_form(enum environment_property property)
{
    return rows[property].form;
}

const char *environment_parse(enum environment_property property, const char *text, int32_t *value)
{
    const struct property_row *row = &rows[property];
    bool on = false;
    bool good = row->scale ? lexer_decimal(text, row->scale, row->lowest, row->highest, value)
                           : lexer_switch(text, &on);
    if (good && !row->scale) {
        *value = on;
    }
    return good ? 0 : row->wanted;
}

static int32_t value_of(const struct servo_node *node, enum environment_property property)
{
    const struct servo_environment *surroundings = &node->servo.environment;
    switch (property) {
    case ENVIRONMENT_SUPPLY: return surroundings->supply_dV;
    case ENVIRONMENT_AMBIENT: return surroundings->ambient_C;
    default: return surroundings->load; // the other properties are on or off and have no ramp
    }
}

/* A servo loses its power when the supply falls below the limit, and starts when it is back. */
static void set_supply(struct servo_node *node, uint64_t now, uint8_t supply_dV)
{
    struct servo_environment *surroundings = &node->servo.environment;
    bool was_dead = surroundings->supply_dV < DEAD_BELOW_DV, is_dead = supply_dV < DEAD_BELOW_DV;

    surroundings->supply_dV = supply_dV;
    if (is_dead != was_dead) {
        servo_node_power(node, now, !is_dead);
    }
}

static void set(struct servo_node *node, uint64_t now, enum environment_property property,
                int32_t value)
{
    struct servo_environment *surroundings = &node->servo.environment;
    switch (property) {
    case ENVIRONMENT_POWER:
        servo_node_power(node, now, value != 0 && surroundings->supply_dV >= DEAD_BELOW_DV);
        break;
    case ENVIRONMENT_SUPPLY: set_supply(node, now, (uint8_t)value); break;
    case ENVIRONMENT_AMBIENT: surroundings->ambient_C = (uint8_t)value; break;
    case ENVIRONMENT_LOAD: surroundings->load = (int16_t)value; break;
    default: surroundings->blocked = value != 0; break;
    }
}

static void step(void *context, uint64_t now)
{
    struct environment *environment = context;
    unsigned kept = 0;
    for (unsigned i = 0; i < environment->count; i++) {
        struct ramp ramp = environment->ramp[i];
        bool over = now >= ramp.end;
        int64_t change = over ? ramp.to - ramp.from
                              : (ramp.to - ramp.from) * (int64_t)(now - ramp.start) /
                                    (int64_t)(ramp.end - ramp.start);
        set(ramp.node, now, ramp.property, ramp.from + (int32_t)change);
        environment->ramp[kept] = ramp;
        kept += !over;
    }
    environment->count = kept;
    if (kept) {
        schedule_at(environment->schedule, &environment->step, now + environment->period);
    }
}

static void end_ramp(struct environment *environment, const struct servo_node *node,
                     enum environment_property property)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < environment->count; i++) {
        struct ramp ramp = environment->ramp[i];
        environment->ramp[kept] = ramp;
        kept += ramp.node != node || ramp.property != property;
    }
    environment->count = kept;
}

static void add_ramp(struct environment *environment, const struct ramp *ramp)
{
    if (environment->count == environment->capacity) {
        environment->capacity = environment->capacity ? environment->capacity * 2 : 32;
        environment->ramp = memory_checked(
            realloc(environment->ramp, environment->capacity * sizeof(*environment->ramp)));
    }
    environment->ramp[environment->count++] = *ramp;
}

void environment_set(struct environment *environment, uint64_t now, struct servo_node *node,
                     enum environment_property property, int32_t value, uint64_t over)
{
    end_ramp(environment, node, property);
    if (over == 0) {
        set(node, now, property, value);
        return;
    }
    struct ramp ramp = {node, property, value_of(node, property), value, now, now + over};
    add_ramp(environment, &ramp);
    if (!event_armed(&environment->step)) {
        schedule_at(environment->schedule, &environment->step, now + environment->period);
    }
}

void environment_stop_ramps(struct environment *environment)
{
    environment->count = 0;
}

void environment_init(struct environment *environment, struct schedule *schedule, uint32_t clock_Hz)
{
    *environment = (struct environment){.schedule = schedule, .period = clock_Hz / 1000};
    event_init(&environment->step, step, environment);
}

void environment_free(struct environment *environment)
{
    free(environment->ramp);
    environment->ramp = 0;
    environment->count = environment->capacity = 0;
}
