/* SPDX-License-Identifier: MIT */
/* The curves of a timed move: which share of its way a joint has gone at which share of the time;
 * not installed. The basis of one moment serves all joints: each joint then costs some
 * multiplications. docs/internals/motion.md has the formulas. Any context. */
#ifndef CDS_CURVE_INTERNAL_H
#define CDS_CURVE_INTERNAL_H

#include <stdint.h>

#include "cds55xx/motion.h" // struct cds_curve

/* Speeds are in 1/16384 of the mean speed of the move. */
#define CDS_CURVE_RATE_1 16384u

#define CDS_CURVE_TRIANGLE 16384u // `ramp_ratio` of the trapezoid that keeps no speed

/* Linear and minimum jerk. `kind`: enum cds_motion_curve but for the trapezoid. */
void cds_curve_set(struct cds_curve *curve, uint8_t kind);

/* Trapezoid. `ramp_ratio` is mean speed / (acceleration x time), in 1/65536: f (1 - f) of the share
 * f of the time for speeding up, 0 to 16384, which is a triangle. A share below 1/64 becomes 1/64.
 */
void cds_curve_set_trapezoid(struct cds_curve *curve, uint16_t ramp_ratio);

/* Returns the share of the way, in 1/65536, after the share `time` of the time, in 1/65536. */
uint16_t cds_curve_progress(const struct cds_curve *curve, uint16_t time);

/* Returns the speed after the share `time` of the time, in 1/16384 of the mean speed. */
uint16_t cds_curve_rate(const struct cds_curve *curve, uint16_t time);

/* A joint that moves at a speed when the move begins brakes to 0 within a window: returns how far
 * it goes until the share `time` of the window, in 1/65536 of speed x window. The whole way is
 * 1/2. */
uint16_t cds_curve_braking_progress(uint16_t time);

/* Returns the speed that is left, in 1/16384 of the speed at the beginning. */
uint16_t cds_curve_braking_rate(uint16_t time);

/* Returns the square root of `value`, rounded down. */
uint16_t cds_curve_root(uint32_t value);

#endif
