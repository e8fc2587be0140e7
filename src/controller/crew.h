/* The servos that the controller has met: a roster that grows by each servo that has an alarm or is
 * told how to answer, and, while it is open, by each servo that answers or is written to.
 *
 * Main context.
 */
#ifndef CONTROLLER_CREW_H
#define CONTROLLER_CREW_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/servos.h" // struct cds_servos

/* Zero it, then crew_begin(). Its fields are to be read only. */
struct crew {
    struct cds_servos roster; // first: the bus knows this much
    uint8_t room;             // servos that there may be
    bool crowded;             // there was one more: it is not looked at
    bool away;                // the bus is at another rate, or its servos are being looked for:
                              // what passes tells nothing of the servos. The caller sets it
    bool open;                // a servo that answers or is written to joins. Else only one that has
                              // an alarm or is told how to answer: to know a servo costs the bus
                              // 0.1 ms an exchange. The caller sets it
    uint16_t early;           // packets refused as CDS_TOO_EARLY, but in a scan; modulo 65536
};

/* Begins without a servo, on an open bus. `servos` has room for `room` (1 to 254) of them. Both
 * stay in place. */
void crew_begin(struct crew *crew, struct cds_bus *bus, struct cds_servo_state *servos,
                uint8_t room);

/* Takes servo `id` in, 0 to 253 (others are nobody), if it is not known. False: there is no room.
 */
bool crew_meet(struct crew *crew, uint8_t id);

#endif
