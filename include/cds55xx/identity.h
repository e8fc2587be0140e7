/* Under which ID and at which baud rate a servo answers, changed as a transaction: is the new place
 * free, is the servo at the old one, write once, then look at both. The answer is where the servo
 * is now, whatever was lost on the way. Manual: 3.1, registers 0x03 and 0x04; 2.4.6 (RESET);
 * rulings R2, R24, R25.
 *
 * A look is up to three PINGs: one good answer is presence, three silences are absence. Where
 * silence is wanted, a damaged answer counts as one. The write is never repeated. All of a change
 * takes about 5 ms at 1 Mbps. There is nothing to roll back: one byte was written, or none.
 *
 * Keep other requests off the bus meanwhile. Main context.
 */
#ifndef CDS_IDENTITY_H
#define CDS_IDENTITY_H

#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus, struct cds_request

#ifdef __cplusplus
extern "C" {
#endif

/* Where the servo is. */
enum cds_identity_state {
    CDS_IDENTITY_UNDECIDED, // not over yet
    CDS_IDENTITY_CHANGED,   // answers at the new place and no longer at the old one
    CDS_IDENTITY_UNCHANGED, // answers at the old place
    CDS_IDENTITY_TAKEN,     // something answered at the new place before: nothing was written;
                            // at_from tells whether the servo is at the old one
    CDS_IDENTITY_LOST,      // answers well at neither: see cds_identity_look_again()
    CDS_IDENTITY_BOTH, // both answer: there were two servos in the old place, or there is noise
};

/* A place: what a servo must be spoken to with. */
struct cds_identity_place {
    uint8_t id;   // 0 to 253; CDS_BROADCAST_ID in the `from` of reset_all
    uint8_t baud; // register value
};

/* One transaction: the caller reads `state`, `at_from`, `at_to`, `written`, `error`, `result`. */
struct cds_identity {
    struct cds_bus *bus;
    struct cds_request *request;
    struct cds_identity_place from, to;
    uint8_t state;   // enum cds_identity_state
    uint8_t at_from; // enum cds_result of the last look there: CDS_OK, CDS_TIMEOUT, CDS_CORRUPT,
    uint8_t at_to;   // or CDS_PENDING if there was none
    uint8_t written; // not 0: the write was sent, or may have been
    uint8_t error;   // CDS_ERROR_* bits of the answer to it; 0 if none came
    uint8_t result;  // enum cds_result of the whole
    uint8_t address; // register to be written, the transaction's own like all below
    uint8_t phase, looks, reason, started, in_flight;
    uint16_t return_delay_us;
};

/* Each prepares a transaction; nothing is sent before the first poll. The servo is `id`, 0 to 253,
 * at the bus's rate. The request's buffer must be at least CDS_PACKET_SIZE(2) bytes; bus, request
 * and identity stay in place until it has ended. CDS_OK; CDS_BAD_ARGUMENT: no bus is open, ID or
 * rate out of range, or the new place is the old one; CDS_NO_ROOM: the buffer is too small;
 * CDS_BUSY: the request is on its way for someone else. Refused, it has touched nothing: polling
 * goes on with, or tells the result of, what was begun before.
 *
 * A new ID, `new_id` 0 to 253. */
enum cds_result cds_identity_change_id_begin(struct cds_identity *identity, struct cds_bus *bus,
                                             struct cds_request *request, uint8_t id,
                                             uint8_t new_id);

/* A new rate, `new_baud`, register value 0 to 254. Results as cds_identity_change_id_begin().
 * Others than the six of cds_scan_listed_bauds are gone after power-off, and the servo is then at
 * its last listed one (R24). */
enum cds_result cds_identity_change_baud_begin(struct cds_identity *identity, struct cds_bus *bus,
                                               struct cds_request *request, uint8_t id,
                                               uint8_t new_baud);

/* Factory values, at ID 1 and 1 Mbps. If that is where the servo is already, nobody can tell by
 * PING whether RESET was carried out: CHANGED then means that it was acknowledged; if it was not,
 * begin again, it does no harm. Results as cds_identity_change_id_begin(), but the new place
 * may be the old one. */
enum cds_result cds_identity_reset_begin(struct cds_identity *identity, struct cds_bus *bus,
                                         struct cds_request *request, uint8_t id);

/* Factory values for every servo that listens at the bus's rate, without looking first: all of them
 * have ID 1 afterwards. CHANGED: something answers there, and at_to is CDS_CORRUPT if there are
 * seen to be several. Results as cds_identity_change_id_begin(), but there is no ID to be wrong. */
enum cds_result cds_identity_reset_all_begin(struct cds_identity *identity, struct cds_bus *bus,
                                             struct cds_request *request);

/* Moves on by at most one exchange; call it and cds_bus_poll() from the main loop. When it ends,
 * the bus is at the rate where the servo answers: at the new one if CHANGED or BOTH, else at the
 * old one; cds_bus_set_baud() takes it elsewhere. CDS_PENDING: not over yet. CDS_OK: CHANGED.
 * Otherwise why not, and identity->state says where the servo is: CDS_REFUSED: the new place is
 * TAKEN, or the servo refused the write (error says why; locked, R6); CDS_TIMEOUT: it did not
 * answer, or not do what it was told; CDS_CORRUPT: damaged answers, or two servos; CDS_CANCELLED:
 * its request was cancelled; or the bus was opened anew, or told another return delay, and is left
 * as it is; state is UNDECIDED in both; CDS_LINE_BUSY: the line was not quiet; CDS_LIMIT,
 * CDS_INHIBITED: as cds_bus_submit(), nothing was written. */
enum cds_result cds_identity_poll(struct cds_identity *identity);

/* Looks at both places again, without writing, after a transaction that ended as LOST: a servo that
 * lost its power answers about a second after it is back. Then poll as before. CDS_OK;
 * CDS_BAD_ARGUMENT: it is not LOST; CDS_BUSY: the request is on its way. */
enum cds_result cds_identity_look_again(struct cds_identity *identity);

#ifdef __cplusplus
}
#endif

#endif
