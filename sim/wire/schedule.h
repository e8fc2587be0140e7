/* SPDX-License-Identifier: MIT */
/* The event queue of simulated time.
 *
 * The unit of time is one cycle of the controller's clock. Time 0 is the start of the run. An event
 * is a field of the struct that needs it. A run is deterministic: events of one cycle run in the
 * order of their ranks, events of one rank in the order in which they were armed. The queue runs by
 * itself (schedule_run_until()) or simavr drives it (avr/machine.h). */
#ifndef SIM_SCHEDULE_H
#define SIM_SCHEDULE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SCHEDULE_NEVER UINT64_MAX

struct event {
    void (*run)(void *context, uint64_t now); // `now` is the time of the event, never later
    void *context;
    uint64_t time;
    uint64_t order; // number of events that were armed before this one
    uint8_t rank;   // the lowest rank of a cycle runs first; set it between event_init() and
                    // schedule_at()
    size_t slot;    // index in the heap; 0: not armed
};

struct schedule {
    struct event **heap; // heap[1] is the next event
    size_t size;
    size_t capacity;
    bool hole; // heap[1] is the running event, which is no longer armed
    uint64_t order;
    uint64_t now; // time of the latest event that has run
    void (*on_earlier)(void *context,
                       uint64_t time); // the next event is now earlier than before; may be 0
    void *context;
};

void schedule_init(struct schedule *schedule);
void schedule_free(struct schedule *schedule);

void event_init(struct event *event, void (*run)(void *context, uint64_t now), void *context);
bool event_armed(const struct event *event);

/* Arms the event, or moves an armed event. A time in the past means now. */
void schedule_at(struct schedule *schedule, struct event *event, uint64_t time);
void schedule_cancel(struct schedule *schedule, struct event *event);

/* Returns the time of the next event, or SCHEDULE_NEVER. */
uint64_t schedule_next(struct schedule *schedule);

/* Runs each event up to and including `time`, also events that these events arm. */
void schedule_run_until(struct schedule *schedule, uint64_t time);

#endif
