/* What the world does to the servos, over time: power, supply, ambient temperature, load, a blocked
 * output. */
#ifndef SIM_ENVIRONMENT_H
#define SIM_ENVIRONMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/schedule.h"
#include "servo/servos.h"

enum environment_property {
    ENVIRONMENT_POWER,
    ENVIRONMENT_SUPPLY,
    ENVIRONMENT_AMBIENT,
    ENVIRONMENT_LOAD,
    ENVIRONMENT_BLOCK,
    ENVIRONMENT_COUNT
};

/* One that changes little by little. */
struct ramp {
    struct servo_node *node;
    enum environment_property property;
    int32_t from, to;
    uint64_t start, end;
};

struct environment {
    struct schedule *schedule;
    uint64_t period; // of a step: 1 ms
    struct event step;
    struct ramp *ramp;
    unsigned count;
    unsigned capacity;
};

/* The cause of that name, or CAUSE_COUNT. */
enum environment_property environment_find(const char *word);

/* Its value as a scenario writes it, in the unit of struct servo_world. Returns 0, or what is
 * wanted. Only what is a quantity can change little by little. */
const char *environment_parse(enum environment_property property, const char *text, int32_t *value);
bool environment_is_quantity(enum environment_property property);

void environment_init(struct environment *environment, struct schedule *schedule,
                      uint32_t clock_Hz);
void environment_free(struct environment *environment);

/* From now on, or reached in equal steps `over` cycles from now. */
void environment_set(struct environment *environment, uint64_t now, struct servo_node *node,
                     enum environment_property property, int32_t value, uint64_t over);

/* The servos are going to be others: no ramp goes on. */
void environment_stop_ramps(struct environment *environment);

#endif
