/* SPDX-License-Identifier: MIT */
/* The curves of a timed move; see curve_internal.h and docs/internals/motion.md. A comment such as
 * Q16 says that a value counts in 1/65536. */
#include "robot/curve_internal.h"

#include "cds55xx/motion.h" // enum cds_motion_curve

#define HALF       32768u
#define RAMP_LEAST 1024u // of the time, Q16: 1/64

/* The highest speed of minimum jerk is 15/8 of the mean speed, at half the time. */
#define RATE_MINIMUM_JERK (CDS_CURVE_RATE_1 / 8u * 15u)

uint16_t cds_curve_root(uint32_t value)
{
    uint16_t root = 0;

    for (uint16_t bit = 1u << 15; bit; bit >>= 1)
        if ((uint32_t)(root | bit) * (uint16_t)(root | bit) <= value)
            root |= bit;
    return root;
}

void cds_curve_set(struct cds_curve *curve, uint8_t kind)
{
    curve->kind = kind;
    curve->rate = kind == CDS_MOTION_MINIMUM_JERK ? RATE_MINIMUM_JERK : CDS_CURVE_RATE_1;
}

/* The share f of the time for speeding up solves f (1 - f) = ramp_ratio; the highest speed is 1 /
 * (1 - f) of the mean speed. */
void cds_curve_set_trapezoid(struct cds_curve *curve, uint16_t ramp_ratio)
{
    uint32_t square = 65536 - 4 * (uint32_t)ramp_ratio; // of 1 - 2 f, Q16
    uint16_t root = square > UINT16_MAX ? UINT16_MAX : cds_curve_root(square << 16);
    uint32_t inverse_ramp;

    curve->kind = CDS_MOTION_TRAPEZOID;
    curve->ramp = (uint16_t)((65536ul - root) / 2);
    if (curve->ramp < RAMP_LEAST)
        curve->ramp = RAMP_LEAST;
    inverse_ramp = (((uint32_t)1024 << 16) + curve->ramp / 2) / curve->ramp;
    curve->inverse_ramp = inverse_ramp > UINT16_MAX ? UINT16_MAX : (uint16_t)inverse_ramp;
    curve->rate = (uint16_t)(((uint32_t)CDS_CURVE_RATE_1 << 16) / (65536ul - curve->ramp));
}

/* 10 t^3 - 15 t^4 + 6 t^5 for a time up to 1/2. */
static uint16_t jerk_progress(uint16_t time)
{
    uint16_t t = (uint16_t)(2u * time - (time == HALF));    // Q17
    uint16_t square = (uint16_t)((uint32_t)t * t >> 16);    // Q18
    uint16_t cube = (uint16_t)((uint32_t)square * t >> 16); // Q19
    uint16_t factor = (uint16_t)(40960u - (uint16_t)((15ul * t) >> 5) +
                                 (uint16_t)((6ul * square) >> 6)); // Q12: 4 to 10

    return (uint16_t)((uint32_t)cube * factor >> 15);
}

/* 30 t^2 (1 - t)^2, Q14. */
static uint16_t jerk_rate(uint16_t time)
{
    uint16_t product = (uint16_t)((uint32_t)time * (65536ul - time) >> 16); // t (1 - t), Q16

    return (uint16_t)(30ul * ((uint32_t)product * product >> 15) >> 3);
}

/* The share of `ramp` that `time` is, Q16. */
static uint16_t share_of_ramp(const struct cds_curve *curve, uint16_t time)
{
    uint32_t share = (uint32_t)time * curve->inverse_ramp >> 10;

    return share > UINT16_MAX ? UINT16_MAX : (uint16_t)share;
}

/* For a time up to 1/2. */
static uint16_t trapezoid_progress(const struct cds_curve *curve, uint16_t time)
{
    uint16_t share = share_of_ramp(curve, time), half_ramp = curve->ramp / 2, progress;

    if (time < curve->ramp)
        progress =
            (uint16_t)((uint32_t)half_ramp * (uint16_t)((uint32_t)share * share >> 16) >> 16);
    else
        progress = (uint16_t)(time - half_ramp);
    return (uint16_t)((uint32_t)progress * curve->rate / CDS_CURVE_RATE_1);
}

static uint16_t trapezoid_rate(const struct cds_curve *curve, uint16_t time)
{
    if (time > HALF)
        time = (uint16_t)(0u - time);
    return (uint16_t)((uint32_t)curve->rate * share_of_ramp(curve, time) >> 16);
}

/* The second half of each curve is the first one, turned. */
uint16_t cds_curve_progress(const struct cds_curve *curve, uint16_t time)
{
    uint16_t first = time > HALF ? (uint16_t)(0u - time) : time, progress = first;

    if (curve->kind == CDS_MOTION_MINIMUM_JERK)
        progress = jerk_progress(first);
    else if (curve->kind == CDS_MOTION_TRAPEZOID)
        progress = trapezoid_progress(curve, first);
    if (time <= HALF)
        return progress;
    return progress ? (uint16_t)(0u - progress) : UINT16_MAX; // the whole way does not fit
}

uint16_t cds_curve_rate(const struct cds_curve *curve, uint16_t time)
{
    if (curve->kind == CDS_MOTION_MINIMUM_JERK)
        return jerk_rate(time);
    if (curve->kind == CDS_MOTION_TRAPEZOID)
        return trapezoid_rate(curve, time);
    return curve->rate;
}

/* t - t^3 + t^4 / 2. The square is rounded down, so the product may exceed the 1/2 at the end of
 * the way. */
uint16_t cds_curve_braking_progress(uint16_t time)
{
    uint16_t square = (uint16_t)((uint32_t)time * time >> 16);
    uint32_t factor = 65536 - ((uint32_t)square * (uint32_t)(65536 - time / 2u) >> 16);
    uint16_t progress = (uint16_t)((uint32_t)time * factor >> 16);

    return progress < 32768 ? progress : 32768;
}

/* 1 - 3 t^2 + 2 t^3 */
uint16_t cds_curve_braking_rate(uint16_t time)
{
    uint16_t square = (uint16_t)((uint32_t)time * time >> 16);

    return (uint16_t)(CDS_CURVE_RATE_1 - ((uint32_t)square * (49152u - time / 2u) >> 16));
}
