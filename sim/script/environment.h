/* What the world does to the servos, over time: power, supply, ambient temperature, load, a blocked
 * output. */
#ifndef SIM_ENVIRONMENT_H
#define SIM_ENVIRONMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "wire/schedule.h"
#include "servo/servos.h"

enum cause { CAUSE_POWER, CAUSE_SUPPLY, CAUSE_AMBIENT, CAUSE_LOAD, CAUSE_BLOCK, CAUSE_COUNT };

/* One that changes little by little. */
struct ramp {
    struct servo_node *node;
    enum cause cause;
    int32_t from, to;
    uint64_t start, end;
};

struct causes {
    struct schedule *schedule;
    uint64_t period; // of a step: 1 ms
    struct event step;
    struct ramp *ramp;
    unsigned count;
    unsigned room;
};

/* The cause of that name, or CAUSE_COUNT. */
enum cause cause_find(const char *word);

/* Its value as a scenario writes it, in the unit of struct servo_world. Returns 0, or what is
 * wanted. Only what is a quantity can change little by little. */
const char *cause_parse(enum cause cause, const char *text, int32_t *value);
bool cause_is_quantity(enum cause cause);

void causes_init(struct causes *causes, struct schedule *schedule, uint32_t clock_Hz);
void causes_free(struct causes *causes);

/* From now on, or reached in equal steps `over` cycles from now. */
void causes_set(struct causes *causes, uint64_t now, struct servo_node *node, enum cause cause,
                int32_t value, uint64_t over);

/* The servos are going to be others: no ramp goes on. */
void causes_forget(struct causes *causes);

#endif
