/* The event queue: what happens next, in simulated time.
 *
 * Time is counted in cycles of the controller's clock from the start of the run. Events are
 * embedded in their owners; a run is deterministic because events of one cycle happen in the order
 * of their ranks, and of one rank in the order in which they were armed. It runs on its own
 * (schedule_run_until) or is driven by simavr (machine.h).
 */
#ifndef SIM_SCHEDULE_H
#define SIM_SCHEDULE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SCHEDULE_NEVER UINT64_MAX

struct event {
    void (*run)(void *context, uint64_t now); // `now` is the event's own time, never late
    void *context;
    uint64_t time;
    uint64_t order; // how many events had been armed before this one
    uint8_t rank;   // lower ones first in a cycle; 0, or set between event_init() and arming
    size_t slot;    // place in the heap, counted from 1; 0: not armed
};

struct schedule {
    struct event **heap; // heap[1] is the next event
    size_t size;
    size_t capacity;
    bool hole; // heap[1] is the event that runs now: no longer armed, its place not yet filled
    uint64_t order;
    uint64_t now; // time of the latest event that ran
    void (*on_earlier)(void *context,
                       uint64_t time); // the head has moved to an earlier time; may be 0
    void *context;
};

void schedule_init(struct schedule *schedule);
void schedule_free(struct schedule *schedule);

void event_init(struct event *event, void (*run)(void *context, uint64_t now), void *context);
bool event_armed(const struct event *event);

/* Arms the event, or moves it when it is armed already. A time in the past means now. */
void schedule_at(struct schedule *schedule, struct event *event, uint64_t time);
void schedule_cancel(struct schedule *schedule, struct event *event);

/* Time of the next event, or SCHEDULE_NEVER. */
uint64_t schedule_next(struct schedule *schedule);

/* Runs every event up to and including `time`, those that they arm included. */
void schedule_run_until(struct schedule *schedule, uint64_t time);

#endif
