/* SPDX-License-Identifier: MIT */
/* What servos.c, id_in_doubt.c, permit.c and learn.c need of each other; not installed. Main
 * context. They mask a value for a field of 2 bits with 3u, so that -Wconversion accepts it. */
#ifndef CDS_SERVOS_INTERNAL_H
#define CDS_SERVOS_INTERNAL_H

#include "cds55xx/servos.h" // struct cds_servos
#include "compiler.h"       // ALWAYS_INLINE
#include "safety/limits.h"  // struct cds_written

/* Status return levels (R3). */
#define CDS_LEVEL_PING 0 // only PING is answered
#define CDS_LEVEL_READ 1 // PING and READ
#define CDS_LEVEL_ALL  2

#define CDS_FACTORY_ID 1 // what RESET leaves (R11, R25)

/* Returns the entry of servo `id` and sets *index, or NULL. */
struct cds_servo_state *cds_servos_search(const struct cds_servos *servos, uint8_t id,
                                          uint8_t *index);

/* As cds_servos_search(); *index is tried first. */
ALWAYS_INLINE struct cds_servo_state *cds_servos_at(const struct cds_servos *servos, uint8_t id,
                                                    uint8_t *index)
{
    if (*index < servos->count && servos->states[*index].id == id)
        return &servos->states[*index];
    return cds_servos_search(servos, id, index);
}

/* Goes through the servos that a SYNC WRITE or a broadcast reaches, some each call: to check it,
 * and later to learn from it. */
struct cds_walk {
    struct cds_written written; // what the packet writes, or the block
    struct cds_servos *servos;
    struct cds_servo_state *servo; // the servo reached, or NULL: it is not known
    bool is_sync_write;            // else a broadcast: it reaches all entries
    int8_t budget;                 // left for this call, in units of about 200 cycles of an AVR
};

#define CDS_WALK_ENDS UINT8_MAX // from cds_walk_next()

/* Begins the part of this call. The walk goes on where the last call for `request` has stopped; it
 * begins again if `epoch` differs. */
void cds_walk_begin(struct cds_walk *walk, struct cds_servos *servos,
                    const struct cds_request *request, uint16_t epoch);

/* Goes on to one more servo, whose check or learning costs `cost` units. CDS_OK; CDS_PENDING: no
 * more in this call; CDS_WALK_ENDS: there is none. A call that searches for the servo does nothing
 * else. */
uint8_t cds_walk_next(struct cds_walk *walk, uint8_t cost);

/* Returns not 0 if the servo is inhibited itself, or its state is not known since it returned. No
 * bool: saves 12 bytes a call. */
ALWAYS_INLINE uint8_t cds_servo_is_inhibited(const struct cds_servo_state *servo)
{
    uint8_t why = servo->inhibits;

    if (servo->presence == CDS_PRESENCE_RETURNED)
        why = UINT8_MAX;
    return why;
}

/* Counts a change of what the permit's answers for servo `id` use; CDS_BROADCAST_ID: for all. */
void cds_servos_note_change(struct cds_servos *servos, uint8_t id);

/* Returns the other entry of a servo whose ID is in doubt, or NULL. */
struct cds_servo_state *cds_servos_second(const struct cds_servos *servos,
                                          const struct cds_servo_state *servo);

/* True if servo `id` with the entry `servo`, or NULL, may become `to`: no other known servo has
 * that ID, and there is room for a second entry. */
bool cds_servos_may_become(const struct cds_servos *servos, const struct cds_servo_state *servo,
                           uint8_t id, uint8_t to);

/* The packet that gives `servo` the ID `id` was not answered. Returns the entry of the other ID, in
 * which the caller notes what the packet changed; a new entry is a copy of `servo`. NULL: the servo
 * has `id` already, or there is no room. */
struct cds_servo_state *cds_servos_doubt_id(struct cds_servos *servos,
                                            struct cds_servo_state *servo, uint8_t id);

/* The ID of `servo` is certain as soon as one of its two entries has answered a READ and the other
 * has missed three, or both have answered: then there are two servos. The lower entry stays where
 * it is. Not while driving is inhibited: torque_off goes through the entries. */
void cds_servos_settle_id(struct cds_servos *servos, struct cds_servo_state *servo);

/* Adds servo `id` if the list grows by it; `is_told` is not 0 for an alarm or a setting. Returns
 * its entry, or NULL. */
struct cds_servo_state *cds_servos_meet(struct cds_servos *servos, uint8_t id, uint8_t is_told);

/* Hooks of learn.c: see bus.h. */
bool cds_servos_on_sending(void *context, struct cds_request *request);
void cds_servos_on_packet(void *context, enum cds_bus_event event, uint8_t id, uint8_t error);

/* True if nothing is to be learnt from this READ of feedback: its servo is not in the list, or has
 * answered as before, which is counted. */
bool cds_servos_take_routine(const struct cds_servos *servos, const struct cds_request *request,
                             uint8_t result);

/* Learns from a transaction that has ended as `result`, enum cds_result. */
void cds_servos_learn_end(struct cds_servos *servos, struct cds_request *request, uint8_t result);

#endif
