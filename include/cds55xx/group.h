/* Many servos at once: SYNC WRITE (manual 2.4.7), and the registered move of example 19.
 *
 * Main context.
 */
#ifndef CDS_GROUP_H
#define CDS_GROUP_H

#include <stdbool.h>
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
enum cds_result cds_group_sync_begin(struct cds_request *request, uint8_t address, uint8_t length);

/* One servo's block: ID 0 to 253 and its `length` bytes; or, for a SYNC WRITE of GOAL_POSITION and
 * MOVING_SPEED (length 4), its goal 0 to 1023 (0 to 300 degrees) and its speed 0 to 1023 (62/1023
 * RPM each, 0: as fast as it can; R8, R10). */
void cds_group_sync_add(struct cds_request *request, uint8_t id, const uint8_t *data);
void cds_group_sync_add_goal(struct cds_request *request, uint8_t id, uint16_t position,
                             uint16_t speed);

/* Sends it; nothing is answered. As cds_servo_write(), plus CDS_NO_ROOM if a block did not fit and
 * CDS_BAD_ARGUMENT if begin refused or a block was out of range. The same packet may be sent again.
 */
enum cds_result cds_group_sync_send(struct cds_bus *bus, struct cds_request *request);

/* What one servo of a registered move is to do, and what became of it. */
struct cds_goal {
    uint8_t id;        // 0 to 253
    uint16_t position; // 0 to 1023: 0 to 300 degrees
    uint16_t speed;    // 0 to 1023: units of 62/1023 RPM, 0 is as fast as it can
    uint8_t result;    // enum cds_result of its REG WRITE; CDS_PENDING if it was not asked
    uint8_t error;     // CDS_ERROR_* bits of its answer
};

/* A registered move: REG WRITE to each servo, each answer checked, then one ACTION to all, so that
 * all start at the same moment. If one does not accept, those already armed are disarmed (register
 * 0x2C = 0, R39), last first, and nothing moves. */
struct cds_group_move {
    struct cds_bus *bus;
    struct cds_request *request;
    struct cds_goal *goals;
    uint8_t count;
    uint8_t next;   // goal being armed, or disarmed
    uint8_t phase;  // the move's own
    uint8_t reason; // why it is being called off: enum cds_result
    uint8_t result; // enum cds_result of the whole
};

/* Prepares the move; nothing is sent before the first poll. The request's buffer must be at least
 * CDS_PACKET_SIZE(5) bytes; `count` is 1 or more; request, goals and move stay in place until the
 * move has ended. */
void cds_group_move_begin(struct cds_group_move *move, struct cds_bus *bus,
                          struct cds_request *request, struct cds_goal *goals, uint8_t count);

/* Moves on by at most one exchange; call it and cds_bus_poll() from the main loop.
 * CDS_PENDING: not over yet. CDS_OK: ACTION was sent. CDS_REFUSED: a servo answered with an error
 * of the packet. CDS_TIMEOUT, CDS_CORRUPT: a servo did not answer well. CDS_BAD_ARGUMENT,
 * CDS_NO_ROOM: as servo.h. In all but the first two no ACTION is sent; goals[i].result and .error
 * tell who and why. A servo that does not even answer the disarming stays in doubt: see to it
 * before the next ACTION. */
enum cds_result cds_group_move_poll(struct cds_group_move *move);

#ifdef __cplusplus
}
#endif

#endif
