/* Torque off for all: holds every servo of the roster, tells all that are on the bus to let go, and
 * looks who did. Manual: 2.4.1, 2.4.2, register 0x18.
 *
 *     cds_stop_begin(&stop, &roster);
 *     while (cds_stop_poll(&stop) == CDS_PENDING)
 *         cds_bus_poll(&bus);
 *
 * From begin on nothing that drives a servo of the roster is sent: what waited in the queue ends as
 * CDS_HELD, and cycles drop all of them. The broadcast is never answered, so it is sent
 * CDS_STOP_BROADCASTS times, right behind the exchange in flight (of which no try is repeated if it
 * drives) and before all that wait, urgent or not; they are out within 2 ms, a cycle of 50 servos
 * on an ATmega at 16 MHz beside it. Then TORQUE_ENABLE of each servo is read; whoever is not known
 * to be off is told so itself, and read again, in CDS_STOP_ROUNDS rounds in all: 50 servos that are
 * all silent take 0.2 s at 1 Mbps, and as much more for each repeat of the bus.
 *
 * A servo that is not in the roster hears the broadcasts, but is neither held nor looked at. Servos
 * stay held until cds_roster_release(). Main context.
 */
#ifndef CDS_STOP_H
#define CDS_STOP_H

#include <stdbool.h>
#include <stddef.h> // NULL
#include <stdint.h>

#include "cds55xx/roster.h" // struct cds_roster

#ifdef __cplusplus
extern "C" {
#endif

/* Times that all are told. */
#define CDS_STOP_BROADCASTS 3

/* Times that each is looked at, at most. */
#define CDS_STOP_ROUNDS 3

/* Requests that may come to nothing, as the line is not quiet, before it is given up: 1.2 s at
 * 1 Mbps, 29 s at 19200. */
#define CDS_STOP_TRIES 1000

/* What became of one servo: `stopped` of it in the roster. */
enum cds_stop_outcome {
    CDS_STOP_UNKNOWN, // it was not looked at
    CDS_STOP_OFF,     // its torque is off: read back
    CDS_STOP_ON,      // it is on still
    CDS_STOP_SILENT,  // no good answer
    CDS_STOP_MUTE,    // it is set not to answer a READ (status return level 0)
};

/* One stop. Zero it (static storage is), then cds_stop_begin(). */
struct cds_stop {
    struct cds_roster *roster;
    uint16_t tries;                 // requests that came to nothing
    uint8_t broadcasts;             // that went out
    uint8_t round;                  // of looking
    uint8_t index;                  // servo being looked at
    uint8_t phase;                  // the stop's own
    uint8_t result;                 // enum cds_result of the whole
    struct cds_request requests[2]; // the broadcasts, by turns; then the first one looks
    uint8_t buffers[2][CDS_PACKET_SIZE(2)];
};

/* Holds all servos of `roster` (CDS_HOLD_STOPPED), which cds_roster_begin() has begun, and submits
 * the first broadcasts; those behind follow out of cds_bus_poll(). Stop and roster stay in place
 * until it is over. One that is under way begins anew: all are told three times from now on.
 * CDS_OK; CDS_BAD_ARGUMENT: no bus is open, and all are held all the same. */
enum cds_result cds_stop_begin(struct cds_stop *stop, struct cds_roster *roster);

/* Moves on by at most one exchange; call it and cds_bus_poll() from the main loop.
 * CDS_PENDING: not over yet. CDS_OK: all broadcasts are out, and every servo was read to be off.
 * Else all are out, but of some it is not known, by the worst of them: CDS_REFUSED: torque is on
 * still; CDS_TIMEOUT: no good answer; CDS_NO_REPLY_DUE: set not to answer. CDS_LINE_BUSY:
 * CDS_STOP_TRIES requests came to nothing; stop->broadcasts went out. CDS_BAD_ARGUMENT: the bus is
 * not open. */
enum cds_result cds_stop_poll(struct cds_stop *stop);

#ifdef __cplusplus
}
#endif

#endif
