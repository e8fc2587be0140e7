/* SPDX-License-Identifier: MIT */
/* What a packet writes into one servo, and the soft limits of that servo; not installed. Main
 * context. */
#ifndef CDS_LIMITS_H
#define CDS_LIMITS_H

#include "cds55xx/servos.h" // struct cds_servo_state

/* Which registers are written, or were read: bits of `sets`. */
enum cds_sets {
    CDS_SETS_ID = 1,
    CDS_SETS_REPLY = 2, // baud rate, return delay, status return level
    CDS_SETS_MODE = 4,  // angle limits
    CDS_SETS_TORQUE = 8,
    CDS_SETS_GAIN = 16,        // compliance margins, proportions, punch
    CDS_SETS_GOAL = 32,        // one byte of it, or both
    CDS_SETS_SPEED = 64,       // one byte of it, or both
    CDS_SETS_REGISTERED = 128, // 0x2C
    CDS_SETS_DRIVE = CDS_SETS_MODE | CDS_SETS_TORQUE | CDS_SETS_GOAL | CDS_SETS_SPEED,
} __attribute__((packed));

/* How the contents of registers became known. Passed as uint8_t: saves registers. */
enum cds_source {
    CDS_SOURCE_READ,     // the servo was read
    CDS_SOURCE_ANSWERED, // it has answered the packet that wrote it
    CDS_SOURCE_SENT,     // no reply was due
    CDS_SOURCE_LOST,     // the reply is missing: written or not
} __attribute__((packed));

/* `length` bytes of servo `id`, from register `address` on. */
struct cds_written {
    const uint8_t *data;
    uint8_t address, length, id;
    uint8_t sets; // CDS_SETS_* bits
    uint8_t left; // bytes of a SYNC WRITE behind `data` and its `length`
};

/* Returns the CDS_SETS_* bits of `length` registers from `address` on. */
uint8_t cds_written_sets(uint8_t address, uint8_t length);

/* Describes what the packet `bytes` writes: a WRITE, REG WRITE or SYNC WRITE. For a SYNC WRITE
 * *written then stands before block `index`, and cds_written_next() goes on to that block. False:
 * the packet writes nothing. */
bool cds_written_by(const uint8_t *bytes, uint8_t index, struct cds_written *written);

/* Goes on to the next block of a SYNC WRITE. There is one if `left` is more than `length`; else
 * `left` bytes are cut off. */
void cds_written_next(struct cds_written *written);

/* True if the packet is TORQUE_ENABLE = 0, and nothing else. */
bool cds_written_is_torque_off(const uint8_t *bytes);

/* Returns the byte of register `reg`, or NULL if it is not written. */
const uint8_t *cds_written_byte(const struct cds_written *written, uint8_t reg);

/* Returns the value of register `reg`, or `otherwise` if it is not written. */
uint8_t cds_written_value(const struct cds_written *written, uint8_t reg, uint8_t otherwise);

/* Returns CDS_OK, or CDS_LIMIT: after this write the servo would go beyond a soft limit, or might.
 * The registers that the servo holds already count, too. Notes a permitted speed of 0. */
uint8_t cds_limits_check(struct cds_servos *servos, struct cds_servo_state *servo,
                         const struct cds_written *written);

/* Does what cds_limits_check() does, for goal and speed only; `data` as in registers 0x1E to 0x21.
 * Faster, because a cycle sets 50 goals in 4 ms. */
enum cds_result cds_limits_check_goal(struct cds_servos *servos, struct cds_servo_state *servo,
                                      const uint8_t *data);

/* Learns mode, goal and speed from *written. A READ makes them known. A write makes no goal and no
 * speed known. After a write an angle limit is known only if it was known before and the servo has
 * answered. True if an answer of the permit may have changed. */
bool cds_limits_learn(struct cds_servo_state *servo, const struct cds_written *written,
                      uint8_t source);

#endif
