/* Settings of a servo that are written only if they differ, and read back (an EEPROM wears).
 * Manual: 3.1; 2.4.1, 2.4.2. ID and baud rate: identity.h.
 *
 * A READ that is lost ends it as CDS_TIMEOUT: cds_bus_set_repeats() has it repeated, or begin
 * again; what stands already is not written twice. Main context.
 */
#ifndef CDS_SETUP_H
#define CDS_SETUP_H

#include <stdint.h>

#include "cds55xx/bus.h"           // struct cds_bus, struct cds_request
#include "cds55xx/control_table.h" // CDS_REG_*

#ifdef __cplusplus
extern "C" {
#endif

/* One setting; the caller reads `written`, `error` and `result`. */
struct cds_setup {
    struct cds_bus *bus;
    struct cds_request *request;
    const uint8_t *data;         // the caller's, or `own`
    uint8_t own;                 // a value of one byte
    uint8_t id, address, length; // where it goes, and its bytes
    uint8_t written;             // not 0: the WRITE was sent, or may have been
    uint8_t error;  // CDS_ERROR_* bits of the last answer, or, if it refused, of its refusal
    uint8_t result; // enum cds_result of the whole
    uint8_t phase, reason, in_flight; // its own
};

/* Each prepares one setting of servo `id`, 0 to 253; nothing is sent before the first poll. The
 * request's buffer must hold the packet, CDS_PACKET_SIZE(length + 1) bytes (length 1: also for the
 * two below it), and at least CDS_PACKET_SIZE(2); bus, request, data and setup stay in place until
 * it has ended. CDS_OK; CDS_BAD_ARGUMENT: out of range; CDS_NO_ROOM: the buffer is too small;
 * CDS_BUSY: the request is on its way for someone else. Refused, it has touched nothing: polling
 * goes on with, or tells the result of, what was begun before.
 *
 * `length` bytes of `data` (1 to 49) to `address` and on; not ID and not baud rate. */
enum cds_result cds_setup_write_begin(struct cds_setup *setup, struct cds_bus *bus,
                                      struct cds_request *request, uint8_t id, uint8_t address,
                                      const uint8_t *data, uint8_t length);

/* How long the servo waits before it answers: at least `delay_us` microseconds, 0 to what the bus
 * waits for (cds_bus_set_return_delay(); at most 508), in steps of 2 (manual, example 8). Tell the
 * bus when all its servos are set. 2 at least where an enable must let go of the wire first (two
 * enables, or one): at 1 Mbps a servo with 0 answers before that, the first byte is lost, and no
 * answer is understood any more, nor the one to this. WRITE of 1 to its register, unread, puts that
 * right. 0 is for tied pins. Which one this is cannot be told here. Results as
 * cds_setup_write_begin(). */
enum cds_result cds_setup_return_delay_begin(struct cds_setup *setup, struct cds_bus *bus,
                                             struct cds_request *request, uint8_t id,
                                             uint16_t delay_us);

/* Locks it: until its power is removed only registers 0x18 to 0x23 can be written (R6; manual,
 * example 20). Results as cds_setup_write_begin(). */
enum cds_result cds_setup_lock_begin(struct cds_setup *setup, struct cds_bus *bus,
                                     struct cds_request *request, uint8_t id);

/* Moves on by at most one exchange; call it and cds_bus_poll() from the main loop.
 * CDS_PENDING: not over yet. CDS_OK: the registers were read and hold the value, whether they did
 * before or (setup->written) do since. CDS_REFUSED: the servo refused, setup->error says why, and
 * does not hold it when read back; or it holds another value all the same. CDS_TIMEOUT,
 * CDS_CORRUPT: it could not be read, or the WRITE was lost and the old value read back.
 * CDS_CANCELLED: the bus was opened anew. CDS_LINE_BUSY: nothing was sent. CDS_NO_REPLY_DUE,
 * CDS_LIMIT, CDS_INHIBITED: as cds_bus_submit(). A servo of status return level 0 answers no READ,
 * and so cannot be set up with this. */
enum cds_result cds_setup_poll(struct cds_setup *setup);

#ifdef __cplusplus
}
#endif

#endif
