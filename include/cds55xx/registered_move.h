/* SPDX-License-Identifier: MIT */
/* The registered move: REG WRITE of a goal to each servo, then one ACTION, so that all servos start
 * at the same moment (manual 2.4.3, 2.4.4 and example 19; R20, R21, R39). If one servo does not
 * accept its goal, no ACTION is sent and the goals already registered are cleared.
 *
 *     static struct cds_goal goals[2] = {{1, 300, 100}, {2, 700, 100}};
 *     cds_registered_move_begin(&move, &(struct cds_registered_move_config){
 *         .bus = &bus, .request = &request, .goals = goals, .count = 2});
 *     while (cds_registered_move_poll(&move) == CDS_PENDING) {
 *         cds_bus_poll(&bus);
 *     }
 *
 * Main context.
 */
#ifndef CDS_REGISTERED_MOVE_H
#define CDS_REGISTERED_MOVE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"   // struct cds_request
#include "cds55xx/steps.h" // struct cds_steps

#ifdef __cplusplus
extern "C" {
#endif

/* Capacity of the request's packet, and of its reply with and without verification, in bytes. */
#define CDS_REGISTERED_MOVE_SIZE         CDS_PACKET_SIZE(5)
#define CDS_REGISTERED_MOVE_REPLY        1
#define CDS_REGISTERED_MOVE_VERIFY_REPLY 15 // registers 0x1E to 0x2C

/* How many times a goal is cleared again if the servo does not say that it is cleared. */
#define CDS_REGISTERED_MOVE_RETRIES 2

/* Has a servo a registered write, which the next ACTION on this bus starts? */
enum cds_registered {
    CDS_REGISTERED_NO,
    CDS_REGISTERED_YES,
    CDS_REGISTERED_IN_DOUBT, // REG WRITE was sent, and the servo did not answer since
} __attribute__((packed));

/* The goal of one servo, and what became of it. */
struct cds_goal {
    uint8_t id;         // 0 to 253
    uint16_t position;  // 0 to 1023: 0 to 300 degrees
    uint16_t speed;     // 0 to 1023: units of 62/1023 RPM; 0: as fast as the servo can
    uint8_t result;     // enum cds_result; CDS_PENDING: nothing was sent to the servo
    uint8_t error;      // CDS_ERROR_* bits of its latest reply to the move itself
    uint8_t registered; // enum cds_registered
};

/* All of it stays in place until the move has ended. */
struct cds_registered_move_config {
    struct cds_bus *bus;         // open
    struct cds_request *request; // capacities: CDS_REGISTERED_MOVE_SIZE and _REPLY, see above
    struct cds_goal *goals;      // id, position and speed are the caller's
    uint8_t count;               // of `goals`, 1 or more
    bool verify;                 // see cds_registered_move_begin()
};

/* One move: the caller reads `steps.result`, `acted` and the goals. */
struct cds_registered_move {
    struct cds_steps steps; // steps.result: enum cds_result of the whole
    struct cds_goal *goals; // config->goals
    uint8_t count;          // of `goals`
    bool acted;             // ACTION was sent, or may have been
    // internal:
    bool verifies;
    bool is_called_off; // the step in flight is the last one before the goals are cleared
    uint8_t next;       // goal of the step
    uint8_t retries;    // to clear it
    uint8_t phase;
    uint8_t reason; // enum cds_result: what the move will end as
};

/* Prepares the move; nothing is sent before the first poll. CDS_OK; CDS_BUSY: the request is in
 * use; CDS_BAD_ARGUMENT: the bus is not open, there is no goal, or a goal is out of range (its
 * `result` says which); CDS_NO_ROOM: a buffer of the request is too small.
 *
 * `verify` costs two READs for each servo. When all goals are registered, each must still be
 * (0x2C = 1): a power failure discards it. After ACTION each servo must hold its goal and its speed
 * and have nothing registered; a servo that did not hear ACTION is cleared, so that it does not
 * start with the next one. Write no goals to these servos meanwhile.
 *
 * A servo that does not answer REG WRITE (status return level 0 or 1) fails the move, unless the
 * level is known (servos.h): then its goal counts as registered without proof, and at level 1 a
 * verification proves it. A servo with limits must answer. */
enum cds_result cds_registered_move_begin(struct cds_registered_move *move,
                                          const struct cds_registered_move_config *config);

/* Moves on by at most one transaction; call it and cds_bus_poll() from the main loop. CDS_PENDING;
 * CDS_OK: ACTION was sent, which no servo answers, and, if verified, each servo has taken its goal
 * (its torque is not looked at). Else the reason of the first failure:
 *
 *   CDS_REFUSED       the servo answered with an error of the packet, or a READ found it without
 *                     its registered write or its goal
 *   CDS_TIMEOUT, CDS_CORRUPT, CDS_LINE_BUSY   the servo did not answer well
 *   CDS_NO_REPLY_DUE  the servo answers no READ (status return level 0), so it cannot be verified
 *   CDS_LIMIT         a goal is beyond a limit, a limit has changed, or ACTION would reach a servo
 *                     with limits that is not part of the move
 *   CDS_INHIBITED     a servo must not be driven, or an inhibit has changed
 *   CDS_RESERVED      a servo is reserved for another request: cds_servos_reserve()
 *   CDS_CANCELLED     the move was aborted, or the bus opened again
 *
 * Then `acted` is false: nothing moves; or true: servos whose result is CDS_OK move, and of the
 * others it is not known. A servo whose `registered` is not CDS_REGISTERED_NO would start with the
 * next ACTION: remove its power, or repeat the move when it answers. In particular a locked servo
 * (R6) takes a registered write but cannot be cleared. */
enum cds_result cds_registered_move_poll(struct cds_registered_move *move);

/* Sends no ACTION any more, clears what is registered, and then ends as CDS_CANCELLED: poll until
 * that is over. If ACTION was sent, only the verification ends. */
void cds_registered_move_abort(struct cds_registered_move *move);

#ifdef __cplusplus
}
#endif

#endif
