/* What servos.c, permit.c and learn.c need of each other; not installed. Main context. */
#ifndef CDS_SERVOS_INTERNAL_H
#define CDS_SERVOS_INTERNAL_H

#include "cds55xx/servos.h" // struct cds_servos
#include "compiler.h"       // ALWAYS_INLINE

/* Status return levels (R3). */
#define CDS_LEVEL_PING 0 // only PING is answered
#define CDS_LEVEL_READ 1 // PING and READ
#define CDS_LEVEL_ALL  2

#define CDS_FACTORY_ID 1 // what RESET leaves (R11, R25)

/* What one call may check or learn, in units of about 200 cycles of an AVR: a goal counts 1, torque
 * 1 or 2, another block or entry 3 or 4, a search 1 + count / 16. */
#define CDS_SERVOS_PER_CALL 4

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

/* Goes through the entries in the order of a packet, some each call. */
struct cds_walk {
    struct cds_servo_state *servo; // the entry that is tried first,
    uint8_t index;                 // and its index
    int8_t budget;                 // no more in this call if it is not above 0
};

ALWAYS_INLINE void cds_walk_begin(struct cds_walk *walk, const struct cds_servos *servos,
                                  uint8_t index)
{
    walk->index = index;
    walk->servo = &servos->states[index];
    walk->budget = CDS_SERVOS_PER_CALL;
}

ALWAYS_INLINE void cds_walk_pay(struct cds_walk *walk, uint8_t cost)
{
    walk->budget = (int8_t)(walk->budget - cost);
}

/* Returns the entry of servo `id`, or NULL. */
struct cds_servo_state *cds_walk_to(struct cds_walk *walk, const struct cds_servos *servos,
                                    uint8_t id);

/* Returns not 0 if the servo is inhibited itself, or its state is not known since it returned. No
 * bool: saves 12 bytes a call. */
ALWAYS_INLINE uint8_t cds_servo_is_inhibited(const struct cds_servo_state *servo)
{
    uint8_t why = servo->inhibited;

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

/* Adds servo `id` if the list grows by it; `is_due` is not 0 for an alarm or a setting. Returns its
 * entry, or NULL. */
struct cds_servo_state *cds_servos_meet(struct cds_servos *servos, uint8_t id, uint8_t is_due);

/* Hooks of learn.c: see bus.h. */
bool cds_servos_on_sending(void *context, struct cds_request *request);
void cds_servos_on_packet(void *context, enum cds_bus_event event, uint8_t id, uint8_t error);

/* True for a READ of feedback that its servo has answered as ever: counted, and nothing new. */
bool cds_servos_is_routine(const struct cds_servos *servos, const struct cds_request *request,
                           uint8_t result);

/* Learns from a transaction that has ended as `result`, enum cds_result. */
void cds_servos_learn_end(struct cds_servos *servos, struct cds_request *request, uint8_t result);

#endif
