/* SPDX-License-Identifier: MIT */
/* Changes the ID or the baud rate of a servo, or resets it, and finds out where the servo is then.
 * Is the new place free? Is the servo at the old one? Write once, then look at both. The answer is
 * where the servo is now, whatever was lost on the way. Manual: 3.1, registers 0x03 and 0x04; 2.4.6
 * (RESET); rulings R2, R24, R25.
 *
 * A look is up to three PINGs: one good reply is presence, three silences are absence. Where
 * silence is wanted, a damaged reply counts as presence. The write is never retried. A change takes
 * about 5 ms at 1 Mbps. There is nothing to roll back: one byte was written, or none.
 *
 * The operation holds the bus from begin to end (cds_bus_lock()). Main context.
 */
#ifndef CDS_IDENTITY_H
#define CDS_IDENTITY_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/steps.h" // struct cds_steps

#ifdef __cplusplus
extern "C" {
#endif

/* What is changed. */
enum cds_identity_change {
    CDS_IDENTITY_ID,    // the ID becomes new_id
    CDS_IDENTITY_BAUD,  // the rate becomes new_baud_reg. A rate other than the six of
                        // cds_scan_listed_baud_regs is gone after power-off, and the servo is then
                        // at its last listed one (R24)
    CDS_IDENTITY_RESET, // factory values: ID 1, 1 Mbps. If the servo is there already, CHANGED
                        // means that it acknowledged the RESET; else begin again, it does no harm
    CDS_IDENTITY_RESET_ALL, // factory values for every servo that listens at the bus's rate,
                            // without looking first: all have ID 1 afterwards. CHANGED: a servo
                            // answers there; at_to is CDS_CORRUPT if several do
} __attribute__((packed));

/* Where the servo is. */
enum cds_identity_state {
    CDS_IDENTITY_UNDECIDED, // not over yet; cancelled; or the line was in use before the write
    CDS_IDENTITY_CHANGED, // answers at the new place and no longer at the old one. If both are the
                          // same place: answers there, and nothing was written
    CDS_IDENTITY_UNCHANGED, // answers at the old place
    CDS_IDENTITY_TAKEN, // a servo answered at the new place before: nothing was written; at_from
                        // tells whether the servo is at the old one
    CDS_IDENTITY_LOST,  // answers well at neither: see cds_identity_look_again()
    CDS_IDENTITY_BOTH,  // both answer: two servos were in the old place, or there is noise
} __attribute__((packed));

/* What to change. Bus and request stay in place until the operation has ended. */
struct cds_identity_config {
    struct cds_bus *bus;         // at the rate of the servo
    struct cds_request *request; // packet capacity: CDS_PACKET_SIZE(2)
    uint8_t change;              // enum cds_identity_change
    uint8_t id;                  // of the servo, 0 to 253; RESET_ALL: not used
    uint8_t new_id;              // 0 to 253, for CDS_IDENTITY_ID
    uint8_t new_baud_reg;        // 0 to 254, for CDS_IDENTITY_BAUD
};

/* ID and rate that a servo answers to. */
struct cds_identity_place {
    uint8_t id;       // 0 to 253; CDS_BROADCAST_ID in the `from` of RESET_ALL
    uint8_t baud_reg; // 0 to 254
};

/* One change: the caller reads the first six fields and steps.result. */
struct cds_identity {
    uint8_t state;   // enum cds_identity_state
    uint8_t at_from; // enum cds_result of the last look there: CDS_OK, CDS_TIMEOUT, CDS_CORRUPT,
    uint8_t at_to;   // or CDS_PENDING if there was none
    bool is_written; // the write was sent, or may have been
    uint8_t error;   // CDS_ERROR_* bits of the reply to the write; 0 if none came
    struct cds_identity_place from, to; // where the servo was, and where it must answer
    // internal:
    uint8_t change;
    uint8_t phase;
    uint8_t looks;
    uint8_t reason;
    // to be read:
    struct cds_steps steps; // steps.result: enum cds_result of the whole
};

/* Prepares a change and locks the bus; nothing is sent before the first poll. CDS_OK;
 * CDS_BAD_ARGUMENT: the bus is not open, or ID or rate is out of range; CDS_NO_ROOM: the packet's
 * buffer is too small; CDS_BUSY: the request is on its way, or an operation holds the bus. Unless
 * it is CDS_OK, nothing was changed. */
enum cds_result cds_identity_begin(struct cds_identity *identity,
                                   const struct cds_identity_config *config);

/* Moves on by at most one transaction; call it and cds_bus_poll() from the main loop. At the end
 * the bus is at the rate where the servo answers: the new one if CHANGED or BOTH, else the old one.
 *   CDS_PENDING    under way
 *   CDS_OK         CHANGED
 * else identity->state says where the servo is, and the result why:
 *   CDS_REFUSED    TAKEN, or the servo refused the write (identity->error; locked, R6)
 *   CDS_TIMEOUT    the servo did not answer, or did not do what it was told
 *   CDS_CORRUPT    damaged replies, or two servos
 *   CDS_LINE_BUSY  the line was in use: before the write UNDECIDED, nothing was written
 *   CDS_CANCELLED  aborted, its request was cancelled, or the bus was opened again (and is left as
 *                  it is): UNDECIDED
 *   CDS_LIMIT, CDS_INHIBITED   as cds_bus_submit(): nothing was written */
enum cds_result cds_identity_poll(struct cds_identity *identity);

/* Sends nothing more. Poll until the transaction in flight is over: the result is CDS_CANCELLED. */
void cds_identity_abort(struct cds_identity *identity);

/* Looks at both places again, without writing, after a change that ended as LOST: a servo that lost
 * its power answers about a second after power is back. Then poll as before. CDS_OK;
 * CDS_BAD_ARGUMENT: it is not LOST; CDS_BUSY: the request is on its way, or an operation holds the
 * bus; CDS_NO_ROOM does not come: the buffers were checked. */
enum cds_result cds_identity_look_again(struct cds_identity *identity);

#ifdef __cplusplus
}
#endif

#endif
