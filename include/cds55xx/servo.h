/* SPDX-License-Identifier: MIT */
/* One servo: the six instructions that speak to one ID (manual 2.4.1 to 2.4.6). Main context.
 *
 * Each call builds its packet in the request's buffer and submits it. A refused packet is not sent,
 * and request->result holds the refusal, too. A call returns:
 * - CDS_OK: poll the bus until request->result is not CDS_PENDING
 * - CDS_BUSY: this request is in flight or waits, and stays as it is; or another request is, and
 *   the bus has no queue (queue.h); or an operation holds the bus (steps.h)
 * - CDS_BAD_ARGUMENT: ID, address or length is out of range, or the bus is not open
 * - CDS_NO_ROOM: the request's buffer is too small for the packet or its reply
 * - CDS_NO_REPLY_DUE, CDS_LIMIT, CDS_INHIBITED, CDS_TOO_EARLY: the permit (servos.h) refuses
 *
 * IDs are 0 to 253, and CDS_BROADCAST_ID where a call says so. Addresses are CDS_REG_* of
 * control_table.h. A length counts bytes. A value is in the register's own unit. */
#ifndef CDS_SERVO_H
#define CDS_SERVO_H

#include <stdint.h>

#include "cds55xx/bus.h"           // struct cds_request
#include "cds55xx/control_table.h" // CDS_REG_*

#ifdef __cplusplus
extern "C" {
#endif

/* Asks whether a servo is there. A broadcast is answered by a servo that is alone on the bus;
 * request->id is its ID (2.4.5, R1). */
enum cds_result cds_servo_ping(struct cds_bus *bus, struct cds_request *request, uint8_t id);

/* Reads `length` bytes (1 to 50) from `address` on; cds_request_byte() and cds_request_word() give
 * them (2.4.2). */
enum cds_result cds_servo_read(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                               uint8_t address, uint8_t length);

/* Writes `length` bytes (1 to 50) of `data` from `address` on, or one byte, or one word. Broadcast
 * too (2.4.1). `data` must not lie in the packet's buffer, where the packet is built. */
enum cds_result cds_servo_write(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                uint8_t address, const uint8_t *data, uint8_t length);
enum cds_result cds_servo_write_byte(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                     uint8_t address, uint8_t value);
enum cds_result cds_servo_write_word(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                     uint8_t address, uint16_t value);

/* As cds_servo_write(), but the servo keeps it until ACTION. Broadcast too (2.4.3). */
enum cds_result cds_servo_reg_write(struct cds_bus *bus, struct cds_request *request, uint8_t id,
                                    uint8_t address, const uint8_t *data, uint8_t length);

/* Carries out what was registered. Broadcast too (2.4.4). */
enum cds_result cds_servo_action(struct cds_bus *bus, struct cds_request *request, uint8_t id);

/* Factory values: the servo is ID 1 at 1 Mbps afterwards. Broadcast resets every servo, and then
 * all have the same ID (2.4.6, R25). */
enum cds_result cds_servo_reset(struct cds_bus *bus, struct cds_request *request, uint8_t id);

#ifdef __cplusplus
}
#endif

#endif
