/* The registered move: REG WRITE to each servo, each answer checked, then one ACTION to all, so
 * that all start at the same moment (manual 2.4.3, 2.4.4 and example 19; R20, R21, R39).
 *
 * If one servo does not accept, no ACTION is sent, nothing moves, and every servo that was asked is
 * disarmed: register 0x2C = 0, which discards what it keeps, and read back. A refusing servo too,
 * for it keeps what was registered before (R21).
 *
 * ACTION is a broadcast and not answered: without verification CDS_OK means that it was sent. It
 * starts whatever else is registered on the bus too. A servo that is not to answer REG WRITE
 * (status return level 0 or 1) fails the move, unless a roster knows that it does not (servos.h):
 * then it counts as armed unproven, and at level 1 verification proves it.
 *
 * All functions: main context.
 */
#ifndef CDS_REGISTERED_MOVE_H
#define CDS_REGISTERED_MOVE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"           // struct cds_request
#include "cds55xx/control_table.h" // CDS_REG_*

#ifdef __cplusplus
extern "C" {
#endif

/* The request's buffer, in bytes. */
#define CDS_REGISTERED_MOVE_SIZE CDS_PACKET_SIZE(5)
#define CDS_GROUP_VERIFY_SIZE    15 // with verification: registers 0x1E to 0x2C are read

/* How often a servo that is not seen to be disarmed is asked again. */
#define CDS_REGISTERED_MOVE_RETRIES 2

/* Does a servo keep a move that the next ACTION on this bus would start? */
enum cds_armed {
    CDS_ARMED_NO,
    CDS_ARMED_YES,
    CDS_ARMED_IN_DOUBT, // it was asked to, and did not answer since
};

/* What one servo of a registered move is to do, and what became of it. */
struct cds_goal {
    uint8_t id;        // 0 to 253
    uint16_t position; // 0 to 1023: 0 to 300 degrees
    uint16_t speed;    // 0 to 1023: units of 62/1023 RPM, 0 is as fast as it can
    uint8_t result;    // enum cds_result: what it failed with, if it did; CDS_PENDING: not asked
    uint8_t error;     // CDS_ERROR_* bits of its latest answer to the move itself
    uint8_t armed;     // enum cds_armed
};

/* A registered move. */
struct cds_registered_move {
    struct cds_bus *bus;
    struct cds_request *request;
    struct cds_goal *goals;
    uint8_t count; // of `goals`
    bool acted;    // ACTION was sent, or may have been: what follows of the move is under way
    bool verified; // all below is the move's own
    bool sent;     // an exchange is on its way
    uint8_t next;  // goal whose turn it is
    uint8_t tries; // to disarm it
    uint8_t phase;
    uint8_t reason; // why it failed: enum cds_result
    uint8_t result; // enum cds_result of the whole
};

/* Prepares the move; nothing is sent before the first poll. The request's buffer must be at least
 * CDS_REGISTERED_MOVE_SIZE bytes; `count` is 1 or more; request, goals and move stay in place until
 * the move has ended. */
void cds_registered_move_begin(struct cds_registered_move *move, struct cds_bus *bus,
                               struct cds_request *request, struct cds_goal *goals, uint8_t count);

/* Before the first poll, if wanted: two READs more for each servo (status return level 1 or 2), and
 * a buffer of CDS_GROUP_VERIFY_SIZE bytes. When all are armed, each must still be (0x2C = 1), else
 * the move is called off: power that fails unarms. After ACTION each must have taken its goal and
 * its speed and be armed no more: a servo that lost power or met another limit in between says
 * nothing by itself. One that is still armed did not hear ACTION; it is disarmed, so that it does
 * not start with the next. Write no goals to these servos meanwhile. A lost READ fails the move,
 * unless cds_bus_set_repeats() has it repeated. */
void cds_registered_move_set_verify(struct cds_registered_move *move);

/* Moves on by at most one exchange; call it and cds_bus_poll() from the main loop.
 * CDS_PENDING: not over yet. CDS_OK: ACTION was sent, and, if verified, each servo has taken its
 * goal; it moves if its torque is on, which is not looked at.
 * CDS_BAD_ARGUMENT: no bus is open, there is no goal, or some are out of range (their results say
 * which); CDS_NO_ROOM: the request's buffer is too small; in both nothing was sent. Else what the
 * first servo, or ACTION, failed with: CDS_REFUSED, it answered with an error of the packet, or is
 * not armed or not at its goal when read; CDS_TIMEOUT, CDS_CORRUPT, it did not answer well;
 * CDS_LINE_BUSY; CDS_NO_REPLY_DUE: by the roster it does not answer the READs of a verification
 * (status return level 0); CDS_LIMIT, CDS_INHIBITED: it must not be driven so (servos.h; disarming
 * always may). Then move->acted tells the two apart: false, nothing moves; true, those whose result
 * is CDS_OK do, of the others it is not known.
 *
 * When it has ended badly, goals[i].armed tells who is not, by its own word, disarmed: it would
 * start with the next ACTION. Remove its power, or begin anew when it answers. In particular a
 * locked servo (R6) can be armed, but not disarmed. After an ACTION that is not verified none
 * counts as armed. */
enum cds_result cds_registered_move_poll(struct cds_registered_move *move);

#ifdef __cplusplus
}
#endif

#endif
