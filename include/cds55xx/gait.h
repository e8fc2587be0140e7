/* SPDX-License-Identifier: MIT */
/* Gait generator: each joint swings about its rest position as a sum of up to three sines, all of
 * one base period. In each period of a cycle (cycle.h) a joint gets its next goal, and the speed
 * that leads there. It starts where the joints are and ends in the rest positions, without a jump.
 *
 *     CDS_GAIT_TABLE(wave) = {
 *         {.rest = 512, .sines = {{.amplitude = 80, .multiple = 1}}},
 *         {.rest = 400, .sines = {{.amplitude = 60, .multiple = 1, .wave = CDS_GAIT_LIFT}}}};
 *     static struct cds_gait_state states[2];
 *     cds_gait_begin(&gait, &(struct cds_gait_config){.cycle = &cycle, .servos = &servos,
 *         .joints = wave, .states = states, .period_ms = 1000, .ramp_ms = 1500});
 *
 * Then the main loop calls cds_gait_poll() behind cds_cycle_poll(), and the program sets no goals
 * of the joints. Formulas, bounds: docs/internals/motion.md. Manual: 2.4.7, registers 0x1E, 0x20;
 * R8, R10. All functions: main context. */
#ifndef CDS_GAIT_H
#define CDS_GAIT_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/motion.h" // CDS_POSE_NONE; struct cds_cycle, cds_servos, cds_register_profile

#ifdef __cplusplus
extern "C" {
#endif

#define CDS_GAIT_SINES       3     // of a joint
#define CDS_GAIT_MULTIPLES   4     // a sine has the base period, or 1/2, 1/3 or 1/4 of it
#define CDS_GAIT_GROUPS      4     // of sines that have a common scale
#define CDS_GAIT_TIME_MIN_MS 100   // of the base period
#define CDS_GAIT_TIME_MAX_MS 60000 // of the base period and the ramp

/* `degrees`, 0 to 65535, as the phase of a sine: 360 are a turn. A constant. */
#define CDS_GAIT_PHASE(degrees) ((uint16_t)(65536ul * (degrees) / 360))

/* How a sine swings while its phase goes through a turn. */
enum cds_gait_wave {
    CDS_GAIT_SINE, // between -amplitude and +amplitude
    CDS_GAIT_LIFT, // to the amplitude and back as the square of a sine in the first half of the
                   // turn, 0 in the second one: a foot that is lifted, and then stands
} __attribute__((packed));

/* A sine. An amplitude of 0 ends the list: the later sines of the joint are ignored. */
struct cds_gait_sine {
    int16_t amplitude; // -511 to 511 position steps (300 / 1023 degrees each)
    uint16_t phase;    // at the beginning of the base period: CDS_GAIT_PHASE()
    uint8_t multiple;  // of the base frequency: 1 to CDS_GAIT_MULTIPLES
    uint8_t wave;      // enum cds_gait_wave
    uint8_t group;     // 0 to CDS_GAIT_GROUPS - 1: cds_gait_set_scale()
};

/* What a joint does. */
struct cds_gait_joint {
    uint16_t rest; // position about which it swings, 0 to 1023; CDS_POSE_NONE: it takes no part
    struct cds_gait_sine sines[CDS_GAIT_SINES]; // their sum is its swing
};

/* A table of joints stands in flash on an AVR, from C and from C++. CDS_GAIT_TABLE(name) begins its
 * definition. */
#if defined __FLASH
#define CDS_GAIT_FLASH       __flash
#define CDS_GAIT_TABLE(name) static const __flash struct cds_gait_joint name[]
#elif defined __AVR__
#define CDS_GAIT_FLASH
#define CDS_GAIT_TABLE(name) static const struct cds_gait_joint name[] __attribute__((__progmem__))
#else
#define CDS_GAIT_FLASH
#define CDS_GAIT_TABLE(name) static const struct cds_gait_joint name[]
#endif

/* What a gait works on. It is copied; what the pointers point to stays in place. */
struct cds_gait_config {
    struct cds_cycle *cycle;   // begun; its servos are the joints, in the same order
    struct cds_servos *servos; // their soft limits; NULL: none
    const CDS_GAIT_FLASH struct cds_gait_joint *joints; // CDS_GAIT_TABLE(): one for each servo
    struct cds_gait_state *states;                      // one for each servo
    const struct cds_register_profile *const *profiles; // one for each servo; NULL: all CDS55xx
    uint16_t period_ms; // base period: CDS_GAIT_TIME_MIN_MS to CDS_GAIT_TIME_MAX_MS
    uint16_t ramp_ms;   // of start, stop and each change: period_ms to CDS_GAIT_TIME_MAX_MS
};

/* One joint. The fields are internal. */
struct cds_gait_state {
    uint16_t start;    // where it was, in steps
    uint16_t position; // of its last goal, in 1/256 step, modulo 256 steps
    uint16_t scale;    // speed of a step per period, in register units
    uint16_t fastest;  // the most that is sent, in register units
    uint16_t reserve;  // added to the speed that leads to the next goal
    uint8_t sines;     // that it has
    bool takes_part;
};

/* The values that ramps change, in 1/16384: the scales of the groups, and the speed. */
#define CDS_GAIT_RAMPED (CDS_GAIT_GROUPS + 1)

/* A gait. Zero it (static storage is), then cds_gait_begin(). The program reads the first four
 * fields; the rest is internal. */
struct cds_gait {
    uint8_t result;       // CDS_PENDING while it is checked, runs or is paused; then how it ended
    bool is_under_way;    // the check is over, and joints move
    uint8_t joint;        // for which the gait was refused or ended
    uint32_t shortest_ms; // result CDS_LIMIT: the shortest base period that works, if ramp_ms is
                          // lengthened by the same factor, rounded up; 0: a position limit was the
                          // reason, or a speed limit of 0
    // internal:
    struct cds_gait_config config;
    uint8_t count;                 // of joints
    uint8_t cycle_begun;           // cycle.begun when the gait was begun
    uint8_t index;                 // joint that is checked, or whose goal is set next
    uint8_t outcome;               // of a gait that is ending
    bool is_starting : 1;          // joints leave the positions where they were
    bool is_ramping : 1;           // values change
    bool is_stopping : 1;          // cds_gait_stop() was called
    bool is_at_rest : 1;           // these goals are the rest positions, and the last ones
    bool is_ending : 1;            // ends as soon as the joints stand still
    uint16_t rate;                 // at which the time runs, in 1/16384
    uint16_t rate_goal;            // the rate that `rate` approaches
    uint16_t rate_step;            // largest change of `rate` in a period; while a gait that is
                                   // paused is checked: the deceleration of the pause
    uint16_t peak;                 // highest speed of a joint, in register units
    uint32_t periods;              // of the cycle, when the last goals were set
    uint32_t phase;                // of the base period, in 1/2^32
    uint32_t phase_step;           // in a period
    uint32_t ramp;                 // time of the ramp, in 1/2^32
    uint32_t ramp_step;            // in a period
    uint16_t ramp_progress;        // in 1/65536 of the change
    int16_t set[CDS_GAIT_RAMPED];  // by the program
    int16_t from[CDS_GAIT_RAMPED]; // when the ramp began
    int16_t to[CDS_GAIT_RAMPED];   // when it ends
    int16_t now[CDS_GAIT_RAMPED];
    uint16_t phases[CDS_GAIT_MULTIPLES + 1]; // of these goals
};

/* Checks the gait, a joint in each cds_gait_poll(), then begins it: within ramp_ms the joints go
 * from their last goals, or from where they are, over to their swing. All scales and the speed are
 * 100 %. Call cds_gait_set_scale() and cds_gait_set_speed() after cds_gait_begin() to start with
 * other values.
 *
 * Returns CDS_OK: it is checked now. CDS_BUSY: the gait has not ended, and its cycle still runs.
 * CDS_BAD_ARGUMENT: the cycle was not begun, or a time is out of range; nothing was changed. */
enum cds_result cds_gait_begin(struct cds_gait *gait, const struct cds_gait_config *config);

/* Moves on; call it after cds_cycle_poll() from the main loop. Each call checks one joint, or sets
 * the goals of at most 4. Returns gait.result:
 *
 *   CDS_PENDING       it is checked, runs or is paused
 *   CDS_OK            stopped; the last goals are the rest positions
 *   CDS_CANCELLED     aborted; the joints stand still
 *   CDS_LIMIT         not begun: gait.joint starts beyond a soft limit, rest -+ the sum of its
 *                     amplitudes is beyond one, or it would be too fast: gait.shortest_ms
 *   CDS_INHIBITED     not begun: gait.joint may not be driven
 *   CDS_TIMEOUT       not begun: the cycle has not read the position of gait.joint yet, or not in
 *                     the last 0.5 s
 *   CDS_BAD_ARGUMENT  not begun: a value in the table is out of range for gait.joint; or with its
 *                     first goals: a joint that takes no part never had a goal (cycle.h)
 *   CDS_INHIBITED while it runs: the cycle was aborted, or was begun again since
 *   CDS_LIMIT, CDS_INHIBITED while it runs: the permit refused a goal of gait.joint; the other
 *                     joints have stopped where they were */
enum cds_result cds_gait_poll(struct cds_gait *gait);

/* Ends the gait in the rest positions: all scales go to 0 within ramp_ms. A ramp under way ends
 * first; the speed stays as it is. Resumes a gait that is paused. A gait that is checked ends as
 * CDS_CANCELLED at once. */
void cds_gait_stop(struct cds_gait *gait);

/* Sets the scale of the sines of `group`, 0 to CDS_GAIT_GROUPS - 1, to `percent` of their
 * amplitude, -100 to 100. So one side of a robot steps shorter or backwards, and the robot turns.
 * Changes within ramp_ms; changes that come meanwhile begin together when it is over. CDS_OK;
 * CDS_BAD_ARGUMENT: out of range. */
enum cds_result cds_gait_set_scale(struct cds_gait *gait, uint8_t group, int8_t percent);

/* Sets how fast the gait runs: `percent` of the base frequency, -100 (backwards) to 100; 0 stands
 * still in the middle of a step. Changes as cds_gait_set_scale(). CDS_OK; CDS_BAD_ARGUMENT: out of
 * range. */
enum cds_result cds_gait_set_speed(struct cds_gait *gait, int8_t percent);

/* Brings the joints to a standstill on their way, at `deceleration` at most (speed register units
 * per second, 1 or more; what the sines slow down by themselves adds to that). cds_gait_resume()
 * speeds up at the same rate. A gait that is checked begins paused. */
void cds_gait_pause(struct cds_gait *gait, uint16_t deceleration);
void cds_gait_resume(struct cds_gait *gait);

/* As cds_gait_pause(), then the gait has ended as CDS_CANCELLED. A gait that is checked, or whose
 * cycle was aborted, ends at once. */
void cds_gait_abort(struct cds_gait *gait, uint16_t deceleration);

#ifdef __cplusplus
}
#endif

#endif
