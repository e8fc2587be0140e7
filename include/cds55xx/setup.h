/* SPDX-License-Identifier: MIT */
/* Settings of a servo that are written only if they differ, and read back (an EEPROM wears).
 * Manual: 3.1; 2.4.1, 2.4.2. ID and baud rate: identity.h.
 *
 *     struct cds_setup_config config = {.bus = &bus, .request = &request, .id = 1,
 *                                       .setting = CDS_SETUP_RETURN_DELAY, .return_delay_us = 100};
 *     cds_setup_begin(&setup, &config);
 *     while (cds_setup_poll(&setup) == CDS_PENDING)
 *         cds_bus_poll(&bus);
 *
 * A READ that is lost ends it as CDS_TIMEOUT. Let the queue retry (cds_queue_set_retries()), or
 * begin again: a value that the servo holds is not written twice. Main context.
 */
#ifndef CDS_SETUP_H
#define CDS_SETUP_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/control_table.h" // CDS_REG_*
#include "cds55xx/steps.h"         // struct cds_steps

#ifdef __cplusplus
extern "C" {
#endif

/* What is set. */
enum cds_setup_setting {
    CDS_SETUP_REGISTERS,    // `length` bytes of `data` to `address` and on
    CDS_SETUP_RETURN_DELAY, // how long the servo waits before it replies
    CDS_SETUP_LOCK, // until its power is removed, only registers 0x18 to 0x23 can be written
                    // (R6; manual, example 20)
} __attribute__((packed));

/* What to set. Bus, request and data stay in place until the operation has ended. */
struct cds_setup_config {
    struct cds_bus *bus;         // open
    struct cds_request *request; // packet capacity: CDS_PACKET_SIZE(length + 1), 9 at least; reply
                                 // capacity: length. The other two settings: a length of 1
    uint8_t id;                  // 0 to 253
    uint8_t setting;             // enum cds_setup_setting

    // CDS_SETUP_REGISTERS:
    uint8_t address, length; // of the registers: not ID, not baud rate; length: 1 to 49
    const uint8_t *data;     // `length` bytes

    /* CDS_SETUP_RETURN_DELAY: 0 to what the bus waits for (cds_bus_set_return_delay(), at most
     * 508), rounded up to a multiple of 2 (manual, example 8). At least 2 where the driver must let
     * go of the wire first (two enables, or one): at 1 Mbps a servo with 0 replies before that, the
     * first byte is lost, and no reply is understood any more, the one to this WRITE included. An
     * unread WRITE of 1 to its register 0x05 puts that right. 0 is for tied pins. The library
     * cannot tell them apart here. Tell the bus when all its servos are set. */
    uint16_t return_delay_us;
};

/* One setting: the caller reads the first two fields and steps.result. */
struct cds_setup {
    bool is_written; // the WRITE was sent, or may have been
    uint8_t error;   // CDS_ERROR_* bits of the last reply, or, if the servo refused, of its refusal
    // internal:
    uint8_t id, address, length;
    uint8_t own; // a value of one byte
    uint8_t phase, reason;
    const uint8_t *data; // the caller's, or NULL: `own`
    // to be read:
    struct cds_steps steps; // steps.result: enum cds_result of the whole
};

/* Prepares one setting; nothing is sent before the first poll. CDS_OK; CDS_BAD_ARGUMENT: the bus is
 * not open, or a value is out of range; CDS_NO_ROOM: a buffer is too small; CDS_BUSY: the request
 * is on its way. Unless it is CDS_OK, nothing was changed: polling goes on with what was begun
 * before. */
enum cds_result cds_setup_begin(struct cds_setup *setup, const struct cds_setup_config *config);

/* Moves on by at most one transaction; call it and cds_bus_poll() from the main loop.
 *   CDS_PENDING    under way
 *   CDS_OK         the registers were read and hold the value: they did before, or do since
 *                  (setup->is_written)
 *   CDS_REFUSED    the servo refused (setup->error) and does not hold the value when read back; or
 *                  it acknowledged the WRITE and holds another value all the same
 *   CDS_TIMEOUT, CDS_CORRUPT   the servo could not be read, or the WRITE was lost and the old value
 *                  read back
 *   CDS_CANCELLED  aborted, or the request was cancelled, or the bus opened again
 *   CDS_LINE_BUSY  the line was not quiet; is_written says whether the WRITE was sent
 *   CDS_LIMIT, CDS_INHIBITED, CDS_TOO_EARLY   the permit (servos.h) refuses the WRITE
 *   CDS_NO_REPLY_DUE   the servo answers no READ (status return level 0) */
enum cds_result cds_setup_poll(struct cds_setup *setup);

/* Sends nothing more. Poll until the transaction in flight is over: the result is CDS_CANCELLED. */
void cds_setup_abort(struct cds_setup *setup);

#ifdef __cplusplus
}
#endif

#endif
