/* SPDX-License-Identifier: MIT */
/* Torque off for all: inhibits driving, tells all servos on the bus to switch torque off and to
 * discard their registered writes, and reads back which servos did. Manual: 2.4.1, 2.4.2, registers
 * 0x18 and 0x2C.
 *
 *     cds_torque_off_begin(&torque_off, &servos);
 *     while (cds_torque_off_poll(&torque_off) == CDS_PENDING) {
 *         cds_bus_poll(&bus);
 *     }
 *
 * Main context.
 */
#ifndef CDS_TORQUE_OFF_H
#define CDS_TORQUE_OFF_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/servos.h" // struct cds_servos
#include "cds55xx/steps.h"  // struct cds_steps

#ifdef __cplusplus
extern "C" {
#endif

/* How many times TORQUE_ENABLE = 0 is sent to all servos: no servo answers a broadcast. */
#define CDS_TORQUE_OFF_BROADCASTS 3

/* How many times REGISTERED_INSTRUCTION = 0 is sent after that. A locked servo (R6) ignores it. */
#define CDS_TORQUE_OFF_CLEARS 3

/* TORQUE_ENABLE of a servo is read so many times until it is 0. Before the second and the third
 * READ the servo is told itself. */
#define CDS_TORQUE_OFF_ROUNDS 3

/* Torque off ends as CDS_LINE_BUSY when its requests have waited for a quiet line in vain for so
 * long, in units of 56 us: 1.1 s at each rate. */
#define CDS_TORQUE_OFF_LINE_WAIT 20000

/* What became of one servo: `torque_off` of struct cds_servo_state. */
enum cds_torque_off_outcome {
    CDS_TORQUE_OFF_UNKNOWN, // not read yet
    CDS_TORQUE_OFF_OFF,     // read: torque is off
    CDS_TORQUE_OFF_ON,      // read: torque is still on
    CDS_TORQUE_OFF_SILENT,  // no good answer
    CDS_TORQUE_OFF_MUTE,    // the servo answers no READ (status return level 0)
} __attribute__((packed));

/* Zero it (static storage is), then cds_torque_off_begin(). */
struct cds_torque_off {
    struct cds_steps steps;    // steps.result: enum cds_result of the whole
    struct cds_servos *servos; // whose torque is switched off
    uint16_t line_wait;        // time that requests waited for a quiet line in vain, x 56 us
    uint8_t broadcasts;        // of TORQUE_ENABLE = 0 that were sent
    // internal:
    uint8_t submitted; // broadcasts
    uint8_t round;
    uint8_t index; // entry of the servo of the step
    uint8_t phase;
    struct cds_request requests[2]; // for broadcasts in turn; the first one also for the READs
    uint8_t packets[2][CDS_PACKET_SIZE(2)];
    uint8_t reply;
};

/* Inhibits driving, until cds_servos_release_all() or cds_servos_allow(), and submits the first
 * broadcasts. The others are submitted from within cds_bus_poll(). They leave after the transaction
 * in flight and before all requests that wait: with a queue the first three are sent within 2 ms (1
 * Mbps, 50 servos, an ATmega at 16 MHz with a cycle beside it). Without a queue the program must
 * poll torque off, and other requests may come between the broadcasts.
 *
 * Torque off passes the lock of an operation. An operation at another rate is aborted; if its
 * packet is on the wire, the first poll after the end of that transaction sends the broadcasts.
 *
 * Torque off may begin again at any time: then all servos are told and read again. A silent servo
 * costs five requests, and their retries. A servo that is not in the list hears the broadcasts and
 * is not read. CDS_OK; CDS_BAD_ARGUMENT: the bus is not open; driving is inhibited nevertheless. */
enum cds_result cds_torque_off_begin(struct cds_torque_off *off, struct cds_servos *servos);

/* Moves on by at most one transaction; call it and cds_bus_poll() from the main loop.
 *
 *   CDS_PENDING       not over yet
 *   CDS_OK            all broadcasts were sent, and every servo was read to be off
 *   CDS_REFUSED       all were sent; torque of a servo is still on
 *   CDS_TIMEOUT       all were sent; a servo did not answer well
 *   CDS_NO_REPLY_DUE  all were sent; a servo answers no READ
 *   CDS_LINE_BUSY     the line was in use for CDS_TORQUE_OFF_LINE_WAIT; `broadcasts` were sent
 *   CDS_CANCELLED     aborted
 *   CDS_BAD_ARGUMENT  the bus is not open
 *
 * Of CDS_REFUSED, CDS_TIMEOUT and CDS_NO_REPLY_DUE the first that applies to a servo. */
enum cds_result cds_torque_off_poll(struct cds_torque_off *off);

/* Ends it as CDS_CANCELLED: sends nothing more but what is on the wire. Driving stays inhibited. */
void cds_torque_off_abort(struct cds_torque_off *off);

#ifdef __cplusplus
}
#endif

#endif
