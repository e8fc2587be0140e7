/* SPDX-License-Identifier: MIT */
/* What a servo reports of itself, in one READ: position, speed, load, voltage, temperature, whether
 * a move is registered and whether it moves (registers 0x24 to 0x2E, manual 3.1; R35, R32).
 *
 * A READ that fails changes no value: the values of a struct cds_feedback are all from one good
 * reply, whose time stands beside them. All functions: main context.
 */
#ifndef CDS_FEEDBACK_H
#define CDS_FEEDBACK_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_request

#ifdef __cplusplus
extern "C" {
#endif

/* Bytes read, from PRESENT_POSITION to MOVING: the least buffer of a feedback request. */
#define CDS_FEEDBACK_SIZE 11

/* The age of values that were never read. */
#define CDS_FEEDBACK_NEVER UINT32_MAX

/* What one servo reported. Zero it (static storage is) before its first READ. */
struct cds_feedback {
    uint32_t time_us;    // of the reply that brought the values, on the clock of cds_port_now_us()
    uint16_t position;   // 0 to 1023: 0 to 300 degrees; this and the others as in the register
    uint16_t speed;      // bits 0 to 9: units of 62/1023 RPM; bit 10: CW (R35)
    uint16_t load;       // bits 0 to 9: of 1023, full torque; bit 10: CW
    uint8_t voltage;     // units of 0.1 V
    uint8_t temperature; // degrees Celsius
    uint8_t error;       // CDS_ERROR_* bits of the latest reply, one that refused included
    uint8_t result : 5;  // enum cds_result of the latest READ
    bool known : 1;      // there are values; false: all but error and result mean nothing
    bool registered : 1; // a REG WRITE waits for ACTION
    bool moving : 1;     // on its way to the goal
};

/* Asks servo `id` (0 to 253); the request's buffer must be at least CDS_FEEDBACK_SIZE bytes.
 * Results as cds_servo_read() (2.4.2). */
enum cds_result cds_feedback_read(struct cds_bus *bus, struct cds_request *request, uint8_t id);

/* Takes what `request`, which cds_feedback_read() had submitted, has brought; `time_us` is when the
 * reply came, as well as the caller knows: cds_port_now_us() if the bus is polled often.
 * CDS_PENDING: not over yet, nothing was touched. CDS_OK: all values are new. CDS_REFUSED: the
 * servo refused, only `error` and `result` are new. All else: how the READ failed; only `result` is
 * new. Values whose age has reached 35.8 min (2^31 us) by then are no longer known. */
enum cds_result cds_feedback_take(struct cds_feedback *feedback, const struct cds_request *request,
                                  uint32_t time_us);

/* Turns the CDS_FEEDBACK_SIZE `bytes` of registers 0x24 to 0x2E, read in whatever way, into values;
 * time, error, result and known are left to the caller. */
void cds_feedback_decode(struct cds_feedback *feedback, const uint8_t *bytes);

/* How old the values are, in microseconds, or CDS_FEEDBACK_NEVER. Right up to 71.6 min. */
uint32_t cds_feedback_age_us(const struct cds_feedback *feedback);

#ifdef __cplusplus
}
#endif

#endif
