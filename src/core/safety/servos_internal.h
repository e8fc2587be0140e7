/* What the permit needs of the servos beside servos.h; not installed. Main context. */
#ifndef CDS_SERVOS_INTERNAL_H
#define CDS_SERVOS_INTERNAL_H

#include "cds55xx/servos.h" // struct cds_servos

/* Status return levels (R3). */
#define CDS_LEVEL_PING 0 // only PING is answered
#define CDS_LEVEL_READ 1 // PING and READ
#define CDS_LEVEL_ALL  2

#define CDS_FACTORY_ID 1 // what RESET leaves (R11, R25)

/* Entries or blocks that one call checks or learns; a search counts as 1 + count / 16. */
#define CDS_SERVOS_PER_CALL 8

/* Returns the entry of servo `id` and sets *index, or NULL. */
struct cds_servo_state *cds_servos_search(struct cds_servos *servos, uint8_t id, uint8_t *index);

/* As cds_servos_search(); *index is tried first. */
static inline struct cds_servo_state *cds_servos_at(struct cds_servos *servos, uint8_t id,
                                                    uint8_t *index)
{
    if (*index < servos->count && servos->states[*index].id == id)
        return &servos->states[*index];
    return cds_servos_search(servos, id, index);
}

/* As cds_servos_search(); the entry behind *index is tried first. Takes what that costs from
 * *budget, which ends at 0. */
struct cds_servo_state *cds_servos_next(struct cds_servos *servos, uint8_t id, uint8_t *index,
                                        uint8_t *budget);

/* True if the servo is inhibited itself, or its state is not known since it returned. */
static inline bool cds_servo_is_inhibited(const struct cds_servo_state *servo)
{
    return servo->inhibited || servo->presence == CDS_PRESENCE_RETURNED;
}

/* Counts a change of what the permit's answers for servo `id` use; CDS_BROADCAST_ID: for all. */
void cds_servos_note_change(struct cds_servos *servos, uint8_t id);

/* True if servo `id` with the entry `servo`, or NULL, may become `to`: no other known servo has
 * that ID, and there is room for a second entry. */
bool cds_servos_may_become(struct cds_servos *servos, const struct cds_servo_state *servo,
                           uint8_t id, uint8_t to);

#endif
