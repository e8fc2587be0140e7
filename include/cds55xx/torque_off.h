/* Torque off for all: inhibits driving, tells all servos on the bus to let go and to forget their
 * registered writes, and reads back who did. Manual: 2.4.1, 2.4.2, registers 0x18 and 0x2C.
 *
 *     cds_torque_off_begin(&stop, &roster);
 *     while (cds_torque_off_poll(&stop) == CDS_PENDING)
 *         cds_bus_poll(&bus);
 *
 * From begin on nothing that can drive a servo is sent, to whatever ID: what waited in the queue
 * ends as CDS_INHIBITED, and cycles drop all servos. A broadcast is never answered, so torque off
 * is sent CDS_TORQUE_OFF_BROADCASTS times, right behind the exchange in flight (of which no try is
 * repeated if it drives) and before all that wait, urgent or not; these are out within 2 ms, a
 * cycle of 50 servos on an ATmega at 16 MHz beside it. Behind them REGISTERED_INSTRUCTION = 0 is
 * sent CDS_TORQUE_OFF_CLEARS times: a servo that hears one of these has no registered write left
 * for a later ACTION, unless it is locked (R6). Then TORQUE_ENABLE of each servo is read; a servo
 * that is not known to be off is told so itself, and read again, in CDS_TORQUE_OFF_ROUNDS rounds in
 * all: a silent servo costs five requests without an answer, and as many more for each repeat of
 * the bus.
 *
 * A servo that is not in the roster hears the broadcasts, but is not read back:
 * cds_torque_off_poll() tells nothing of it. Driving stays inhibited until cds_servos_release() or
 * cds_servos_allow(). Main context.
 */
#ifndef CDS_TORQUE_OFF_H
#define CDS_TORQUE_OFF_H

#include <stdbool.h>
#include <stddef.h> // NULL
#include <stdint.h>

#include "cds55xx/servos.h" // struct cds_servos

#ifdef __cplusplus
extern "C" {
#endif

/* Times that all are told to switch torque off, and then to forget a registered write. */
#define CDS_TORQUE_OFF_BROADCASTS 3
#define CDS_TORQUE_OFF_CLEARS     3

/* Times that each is looked at, at most. */
#define CDS_TORQUE_OFF_ROUNDS 3

/* Requests that may come to nothing, as the line is not quiet, before it is given up. */
#define CDS_TORQUE_OFF_TRIES 1000

/* What became of one servo: `stopped` of it in the roster. */
enum cds_torque_off_outcome {
    CDS_TORQUE_OFF_UNKNOWN, // it was not looked at
    CDS_TORQUE_OFF_OFF,     // its torque is off: read back
    CDS_TORQUE_OFF_ON,      // it is on still
    CDS_TORQUE_OFF_SILENT,  // no good answer
    CDS_TORQUE_OFF_MUTE,    // it is set not to answer a READ (status return level 0)
};

/* One stop. Zero it (static storage is), then cds_torque_off_begin(). */
struct cds_torque_off {
    struct cds_servos *roster;
    uint16_t tries;                 // requests that came to nothing
    uint8_t broadcasts;             // of torque off that went out
    uint8_t clears;                 // broadcasts of REGISTERED_INSTRUCTION = 0 that went out
    uint8_t round;                  // of looking
    uint8_t index;                  // servo being looked at
    uint8_t phase;                  // the stop's own
    uint8_t result;                 // enum cds_result of the whole
    struct cds_request requests[2]; // the broadcasts, by turns; then the first one looks
    uint8_t buffers[2][CDS_PACKET_SIZE(2)];
};

/* Inhibits driving and holds all servos of `roster` (CDS_INHIBIT_STOPPED), which cds_servos_begin()
 * has begun, and submits the first broadcasts; those behind follow out of cds_bus_poll(). Stop and
 * roster stay in place until it is over. One that is under way begins anew: all are told three
 * times from now on. CDS_OK; CDS_BAD_ARGUMENT: no bus is open, and driving is inhibited all the
 * same. */
enum cds_result cds_torque_off_begin(struct cds_torque_off *stop, struct cds_servos *roster);

/* Moves on by at most one exchange; call it and cds_bus_poll() from the main loop.
 * CDS_PENDING: not over yet. CDS_OK: all broadcasts are out, and every servo was read to be off.
 * Else all are out, but of some it is not known, by the worst of them: CDS_REFUSED: torque is on
 * still; CDS_TIMEOUT: no good answer; CDS_NO_REPLY_DUE: set not to answer. CDS_LINE_BUSY:
 * CDS_TORQUE_OFF_TRIES requests came to nothing; stop->broadcasts went out. CDS_BAD_ARGUMENT: the
 * bus is not open. */
enum cds_result cds_torque_off_poll(struct cds_torque_off *stop);

#ifdef __cplusplus
}
#endif

#endif
