/* Many servos in one packet: SYNC WRITE (manual 2.4.7), a servo at a time into the buffer that is
 * sent. For more servos than a packet holds: sync_write_many.h; to know that each has taken its
 * goal before any starts: registered_move.h.
 *
 * Main context.
 */
#ifndef CDS_SYNC_WRITE_H
#define CDS_SYNC_WRITE_H

#include <stdint.h>

#include "cds55xx/bus.h"           // struct cds_request
#include "cds55xx/control_table.h" // CDS_REG_*

#ifdef __cplusplus
extern "C" {
#endif

/* SYNC WRITE: begin, add a servo at a time, send. Begin and add write into the request's buffer,
 * which must be CDS_SYNC_WRITE_SIZE(servos, length) bytes; what does not fit is noticed by send.
 * `length`: bytes for each servo, 1 to 50, from `address` on. Begin returns CDS_OK,
 * CDS_BAD_ARGUMENT (address and length outside the control table), or CDS_BUSY (the request is on
 * its way; then add does nothing either). */
enum cds_result cds_sync_write_begin(struct cds_request *request, uint8_t address, uint8_t length);

/* One servo's block: ID 0 to 253 and its `length` bytes of `data`; or, for a SYNC WRITE of
 * GOAL_POSITION and MOVING_SPEED (length 4), the goal `position` 0 to 1023 (0 to 300 degrees) and
 * `speed` 0 to 1023 (62/1023 RPM each, 0: as fast as it can; R8, R10). */
void cds_sync_write_add(struct cds_request *request, uint8_t id, const uint8_t *data);
void cds_sync_write_add_goal(struct cds_request *request, uint8_t id, uint16_t position,
                             uint16_t speed);

/* Sends it; nothing is answered. As cds_servo_write(), plus CDS_NO_ROOM if a block did not fit and
 * CDS_BAD_ARGUMENT if begin refused, a block was out of range or a goal added where `length` is not
 * 4. The same packet may be sent again.
 */
enum cds_result cds_sync_write_send(struct cds_bus *bus, struct cds_request *request);

#ifdef __cplusplus
}
#endif

#endif
