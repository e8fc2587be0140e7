/* SPDX-License-Identifier: MIT */
#include "wire/schedule.h"

#include <stdlib.h>

#include "memory.h"

void schedule_init(struct schedule *schedule)
{
    *schedule = (struct schedule){0};
}

void schedule_free(struct schedule *schedule)
{
    free(schedule->heap);
    *schedule = (struct schedule){0};
}

void event_init(struct event *event, void (*run)(void *context, uint64_t now), void *context)
{
    *event = (struct event){.run = run, .context = context};
}

bool event_armed(const struct event *event)
{
    return event->slot != 0;
}

static bool before(const struct event *a, const struct event *b)
{
    if (a->time != b->time) {
        return a->time < b->time;
    }
    return a->rank != b->rank ? a->rank < b->rank : a->order < b->order;
}

static void place(struct schedule *schedule, struct event *event, size_t slot)
{
    schedule->heap[slot] = event;
    event->slot = slot;
}

static void sift_up(struct schedule *schedule, struct event *event)
{
    size_t slot = event->slot;
    for (; slot > 1 && before(event, schedule->heap[slot / 2]); slot /= 2) {
        place(schedule, schedule->heap[slot / 2], slot);
    }
    place(schedule, event, slot);
}

static void sift_down(struct schedule *schedule, struct event *event)
{
    size_t slot = event->slot;
    for (;;) {
        size_t child = slot * 2;
        if (child > schedule->size) {
            break;
        }
        if (child < schedule->size && before(schedule->heap[child + 1], schedule->heap[child])) {
            child++;
        }
        if (!before(schedule->heap[child], event)) {
            break;
        }
        place(schedule, schedule->heap[child], slot);
        slot = child;
    }
    place(schedule, event, slot);
}

/* Fills the place of an event that has run. Most events arm an event while they run, which fills
 * that place at once and saves a sift. Until then the event in the place sorts before all others,
 * so the heap stays valid. */
static void close_hole(struct schedule *schedule)
{
    if (schedule->hole) {
        schedule->hole = false;
        struct event *last = schedule->heap[schedule->size--];
        if (schedule->size) {
            place(schedule, last, 1);
            sift_down(schedule, last);
        }
    }
}

static void grow_heap(struct schedule *schedule)
{
    if (schedule->size + 1 < schedule->capacity) {
        return;
    }
    schedule->capacity = schedule->capacity ? schedule->capacity * 2 : 64;
    schedule->heap =
        memory_checked(realloc(schedule->heap, schedule->capacity * sizeof(*schedule->heap)));
}

void schedule_at(struct schedule *schedule, struct event *event, uint64_t time)
{
    schedule_cancel(schedule, event);
    grow_heap(schedule);
    event->time = time < schedule->now ? schedule->now : time;
    event->order = schedule->order++;
    if (schedule->hole) {
        schedule->hole = false;
        place(schedule, event, 1);
        sift_down(schedule, event);
    } else {
        schedule->size++;
        place(schedule, event, schedule->size);
        sift_up(schedule, event);
    }
    if (event->slot == 1 && schedule->on_earlier) {
        schedule->on_earlier(schedule->context, event->time);
    }
}

void schedule_cancel(struct schedule *schedule, struct event *event)
{
    size_t slot = event->slot;
    if (!slot) {
        return;
    }
    struct event *last = schedule->heap[schedule->size--];
    event->slot = 0;
    if (last == event) {
        return;
    }
    place(schedule, last, slot);
    sift_up(schedule, last);
    sift_down(schedule, last);
}

uint64_t schedule_next(struct schedule *schedule)
{
    close_hole(schedule);
    return schedule->size ? schedule->heap[1]->time : SCHEDULE_NEVER;
}

void schedule_run_until(struct schedule *schedule, uint64_t time)
{
    while (schedule->size && schedule->heap[1]->time <= time) {
        struct event *event = schedule->heap[1];
        event->slot = 0;
        schedule->hole = true;
        schedule->now = event->time;
        event->run(event->context, event->time);
        close_hole(schedule);
    }
    if (schedule->now < time) {
        schedule->now = time;
    }
}
