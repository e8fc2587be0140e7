/* SPDX-License-Identifier: MIT */
/* Changes the environment of the servos over time: power, supply, ambient temperature, load, a
 * blocked output. */
#ifndef SIM_ENVIRONMENT_H
#define SIM_ENVIRONMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "servo/servos.h"
#include "wire/schedule.h"

enum environment_property {
    ENVIRONMENT_POWER,
    ENVIRONMENT_SUPPLY,
    ENVIRONMENT_AMBIENT,
    ENVIRONMENT_LOAD,
    ENVIRONMENT_BLOCK,
    ENVIRONMENT_COUNT
};

/* A property that changes in equal steps. */
struct ramp {
    struct servo_node *node;
    enum environment_property property;
    int32_t from, to;
    uint64_t start, end;
};

struct environment {
    struct schedule *schedule;
    uint64_t period; // of the steps: 1 ms
    struct event step;
    struct ramp *ramp;
    unsigned count;
    unsigned capacity;
};

/* Returns the property with that name, or ENVIRONMENT_COUNT. */
enum environment_property environment_find(const char *word);

/* Parses a value of a scenario into the unit of struct servo_environment. Returns 0, or what is
 * wanted. Only a quantity can change in steps. */
const char *environment_parse(enum environment_property property, const char *text, int32_t *value);
const char *environment_form(enum environment_property property); // "wanted: power [IDS] on|off"
bool environment_is_quantity(enum environment_property property);
/* True if a person may have meant the value as the ID of a servo: `load 1`. */
bool environment_equals_id(enum environment_property property, int32_t value, unsigned id);
/* Returns why a line without IDS may not set the value, or 0. */
const char *environment_check_for_all(enum environment_property property, int32_t value);
/* True if the supply of the servo is below that at which it runs. */
bool environment_is_dead(const struct servo_node *node);

void environment_init(struct environment *environment, struct schedule *schedule,
                      uint32_t clock_Hz);
void environment_free(struct environment *environment);

/* Sets the property now, or in equal steps that end `over` cycles from now. */
void environment_set(struct environment *environment, uint64_t now, struct servo_node *node,
                     enum environment_property property, int32_t value, uint64_t over);

/* Ends all ramps. Call it before the servos are replaced. */
void environment_stop_ramps(struct environment *environment);

#endif
