/* The servos that the controller has met: a roster that grows by whoever has an alarm or is told
 * how to answer, and, while it is open, by whoever answers and by whom something is written to.
 * What a hold keeps still includes servos that only ever heard a SYNC WRITE.
 *
 * Main context.
 */
#ifndef CONTROLLER_CREW_H
#define CONTROLLER_CREW_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/roster.h" // struct cds_roster

/* Zero it, then crew_begin(). Its fields are to be read only. */
struct crew {
    struct cds_roster roster; // first: the bus knows this much
    uint8_t room;             // servos that there may be
    bool crowded;             // there was one more: it is neither held nor looked at
    bool held;                // whoever is met from now on is held
    bool open; // who answers or is written to joins. Else only who has an alarm, is told how to
               // answer, or would be held: to know a servo costs the bus 0.1 ms an exchange. The
               // caller sets it
};

/* Begins without a servo, on an open bus. `servos` has room for `room` (1 to 254) of them. Both
 * stay in place. */
void crew_begin(struct crew *crew, struct cds_bus *bus, struct cds_roster_servo *servos,
                uint8_t room);

/* Takes servo `id` in, 0 to 253 (others are nobody), if it is not known. False: there is no room.
 */
bool crew_meet(struct crew *crew, uint8_t id);

/* Holds all (CDS_HOLD_STOPPED), those too that are met later; or none who is met later. */
void crew_hold(struct crew *crew);
void crew_unhold(struct crew *crew);

#endif
