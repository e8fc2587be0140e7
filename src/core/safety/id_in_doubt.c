/* SPDX-License-Identifier: MIT */
/* A servo whose ID is in doubt has two entries, each with the index of the other one in `second`;
 * see docs/internals/permit.md. */
#include "compiler.h" // NOINLINE
#include "safety/servos_internal.h"

NOINLINE struct cds_servo_state *cds_servos_second(const struct cds_servos *servos,
                                                   const struct cds_servo_state *servo)
{
    return servo->second < servos->count ? &servos->states[servo->second] : NULL;
}

bool cds_servos_may_become(const struct cds_servos *servos, const struct cds_servo_state *servo,
                           uint8_t id, uint8_t to)
{
    uint8_t index;

    if (to == id)
        return true;
    if (to > CDS_ID_MAX)
        return !servo; // no servo can have such an ID
    if (cds_servos_search(servos, to, &index))
        return servo && servo->second == index;
    return !servo || (servo->second == CDS_NO_ID && servos->count < servos->capacity);
}

struct cds_servo_state *cds_servos_doubt_id(struct cds_servos *servos,
                                            struct cds_servo_state *servo, uint8_t id)
{
    struct cds_servo_state *other = cds_servos_second(servos, servo);

    if (id == servo->id || (!other && servos->count == servos->capacity))
        return NULL;
    if (other) { // the servo may be either entry: only what both entries have in common is known
        uint8_t speed_0 = (other->held | servo->held) & CDS_HELD_SPEED_0;

        other->held = (other->held & servo->held) | speed_0;
    } else {
        other = &servos->states[servos->count];
        *other = *servo;
        other->counters = (struct cds_servo_counters){0};
        cds_servos_search(servos, servo->id, &other->second); // no division
        other->id = id;
        servo->second = servos->count++;
    }
    servo->has_answered = other->has_answered = false;
    servo->misses = other->misses = 0;
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
    return other;
}

/* Removes entry `index`; the last entry moves to its place. */
static void remove_entry(struct cds_servos *servos, uint8_t index)
{
    struct cds_servo_state *place = &servos->states[index], *other;

    servos->count--;
    if (index == servos->count)
        return;
    *place = servos->states[servos->count];
    other = cds_servos_second(servos, place);
    if (other)
        other->second = index;
}

void cds_servos_settle_id(struct cds_servos *servos, struct cds_servo_state *servo)
{
    struct cds_servo_state *lower = servo, *higher = cds_servos_second(servos, servo);
    uint8_t index;

    if (!higher || servos->all_inhibited)
        return;
    if (higher < lower) {
        lower = higher;
        higher = servo;
    }
    if (lower->has_answered && higher->has_answered) {
        lower->second = higher->second = CDS_NO_ID;
    } else if ((lower->has_answered && higher->misses == CDS_SERVOS_MISSES) ||
               (higher->has_answered && lower->misses == CDS_SERVOS_MISSES)) {
        index = lower->second;
        if (higher->has_answered)
            *lower = *higher;
        lower->second = CDS_NO_ID;
        remove_entry(servos, index);
    } else {
        return;
    }
    cds_servos_note_change(servos, CDS_BROADCAST_ID);
}
