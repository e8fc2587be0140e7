/* SPDX-License-Identifier: MIT */
/* Switches torque of a servo on without a movement: reads the servo, sets its position as its goal,
 * reads the goal back, then switches torque on. Manual: 3.1, registers 0x05 to 0x2E.
 *
 *     struct cds_torque_on_config config = {.bus = &bus, .request = &request, .id = 1,
 *                                           .last = CDS_TORQUE_ON_SWITCH};
 *     cds_torque_on_begin(&torque_on, &config);
 *     while (cds_torque_on_poll(&torque_on) == CDS_PENDING)
 *         cds_bus_poll(&bus);
 *
 * A robot of several servos checks all of them before it writes to one: `first` and `last` choose
 * the part. Main context.
 */
#ifndef CDS_TORQUE_ON_H
#define CDS_TORQUE_ON_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/packet.h"        // CDS_PACKET_SIZE()
#include "cds55xx/steps.h"         // struct cds_steps

#ifdef __cplusplus
extern "C" {
#endif

/* Why a servo does not get torque. */
enum cds_reason {
    CDS_REASON_NONE,
    CDS_REASON_NO_REPLY,     // no good reply: CDS_TIMEOUT, CDS_CORRUPT or CDS_LINE_BUSY
    CDS_REASON_ALARM,        // voltage, temperature or load: CDS_ERRORS_OF_CONDITION
    CDS_REASON_RETURN_DELAY, // the servo does not take the return delay; is it locked (0x2F)?
    CDS_REASON_MODE,         // endless turn: both angle limits, 0x06 and 0x08, are 0
    CDS_REASON_VOLTAGE,      // outside of registers 0x0C and 0x0D of the servo
    CDS_REASON_POSITION,     // the servo is outside of its soft limits: turn it back by hand
    CDS_REASON_REFUSED,      // the servo does not take goal or torque
    CDS_REASON_INHIBITED,    // the program has inhibited driving, or reserved the servo
} __attribute__((packed));

/* The parts of the operation, in their order. */
enum cds_torque_on_part {
    CDS_TORQUE_ON_CHECK,  // READ: is the servo well?
    CDS_TORQUE_ON_GOAL,   // READ, WRITE of the position as the goal, READ: is it the goal?
    CDS_TORQUE_ON_SWITCH, // WRITE of TORQUE_ENABLE
} __attribute__((packed));

/* What a READ of the operation reads: registers 0x05 to 0x2E. */
#define CDS_TORQUE_ON_READ_FROM CDS_REG_RETURN_DELAY
#define CDS_TORQUE_ON_READ_SIZE 42

/* Capacity of the request's packet, in bytes. */
#define CDS_TORQUE_ON_PACKET_SIZE CDS_PACKET_SIZE(5)

/* The goal is set again if the servo is more than so many steps from it when it is read back. */
#define CDS_TORQUE_ON_NEAR_STEPS 3
/* The operation ends after so many goals, since a hand turns the servo. */
#define CDS_TORQUE_ON_GOALS 3

/* What to do. Bus and request stay in place until the operation has ended. */
struct cds_torque_on_config {
    struct cds_bus *bus; // open
    struct cds_request
        *request;          // packet capacity: CDS_TORQUE_ON_PACKET_SIZE; reply capacity:
                           // CDS_TORQUE_ON_READ_SIZE. Other fields: as the caller has set them
    uint8_t id;            // 0 to 253
    uint8_t first, last;   // enum cds_torque_on_part: `first` to `last`
    bool checks_condition; // an alarm, or a voltage outside of the servo's limits, ends it
    uint16_t speed;        // of the goal, 1 to 1023; 0: the servo keeps MOVING_SPEED, which is
                           // written again with the goal, unless it is 0
};

/* One servo. The caller reads the first two fields and steps.result. */
struct cds_torque_on {
    uint8_t reason; // enum cds_reason: why the operation has not ended as CDS_OK
    uint16_t goal;  // that was set, 0 to 1023
    // internal:
    uint8_t id, phase, last, goals;
    bool checks_condition;
    uint16_t speed;
    // to be read:
    struct cds_steps steps; // steps.result: enum cds_result of the whole
};

/* Prepares one servo; nothing is sent before the first poll. If the parts go from the READ to
 * torque, a servo whose torque is on stays as it is. CDS_OK; CDS_BAD_ARGUMENT: the bus is not open,
 * or a value is out of range; CDS_NO_ROOM: a buffer is too small; CDS_BUSY: the request is on its
 * way. Unless it is CDS_OK, nothing was changed. */
enum cds_result cds_torque_on_begin(struct cds_torque_on *on,
                                    const struct cds_torque_on_config *config);

/* Moves on by at most one transaction; call it and cds_bus_poll() from the main loop. A servo whose
 * outcome is not CDS_OK has no torque by this operation, unless the reply to the last WRITE was
 * lost. The request's reply has the registers of the last READ.
 *
 *   CDS_PENDING    under way
 *   CDS_OK         all parts are done, or torque was on already
 *   CDS_REFUSED    reason: alarm, mode, voltage; or CDS_REASON_REFUSED: request->error has bits of
 *                  CDS_ERRORS_OF_PACKET, or has none: the goal reads back as another one, or the
 *                  servo is being turned
 *   CDS_CANCELLED  aborted, or the request was cancelled
 *   others         of cds_bus_submit() and of the transaction: request->result */
enum cds_result cds_torque_on_poll(struct cds_torque_on *on);

/* Ends it as CDS_CANCELLED: sends nothing more but what is on the wire. */
void cds_torque_on_abort(struct cds_torque_on *on);

#ifdef __cplusplus
}
#endif

#endif
