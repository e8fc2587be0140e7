/* SPDX-License-Identifier: MIT */
/* Sequences of poses: step after step by timed moves (motion.h), with rests between them or through
 * a pose without a stop, once, several times or for ever.
 *
 *     cds_sequence_begin(&sequence, &(struct cds_sequence_config){
 *         .motion = &motion, .read = read_step, .poses = poses, .repeats = 3});
 *     for (;;) {
 *         cds_bus_poll(&bus);
 *         cds_cycle_poll(&cycle);
 *         cds_sequence_poll(&sequence);
 *     }
 *
 * The steps come from a function of the program, so they may stand in flash, RAM or EEPROM. The
 * override is that of the motion. All functions: main context. */
#ifndef CDS_SEQUENCE_H
#define CDS_SEQUENCE_H

#include "cds55xx/motion.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One step: the way to a pose, and how long the joints stay there. */
struct cds_sequence_step {
    uint32_t time_ms;      // of the way: 1 to CDS_MOTION_TIME_MAX_MS
    uint16_t dwell_ms;     // rest at the pose, also of the last step; a step that passes has none
    uint16_t acceleration; // of a trapezoid, as in struct cds_move
    uint8_t curve;         // enum cds_motion_curve
    uint8_t event;         // handed to on_pose
    bool passes;           // the joints pass the pose on their way to that of the next step
    bool may_take_longer;  // a time that is too short is stretched
};

/* What a sequence works on. It is copied; what the pointers point to stays in place. */
struct cds_sequence_config {
    struct cds_motion *motion; // begun
    uint16_t *poses;           // room for two poses: twice as many positions as there are joints
    void *context;             // handed to the functions
    /* Reads step `index`, 0 to 255, and its pose, CDS_POSE_NONE for each joint that takes no part.
     * False: there is no such step. Called for each step of a run and for the index behind its last
     * step; perhaps twice for the index behind a step that passes. With checks_all also before
     * the first step begins. */
    bool (*read)(void *context, uint8_t index, struct cds_sequence_step *step, uint16_t *pose);
    /* Asked again with each poll until it is true: may step `index` begin? Not asked for a step
     * that follows one that passes: the joints would have to stop at the pose. NULL: always. */
    bool (*may_begin)(void *context, uint8_t index);
    void (*on_pose)(void *context, uint8_t index, uint8_t event); // the pose of this step was sent;
                                                                  // NULL: not called
    uint16_t repeats; // how often the sequence runs; 0: for ever
    bool checks_all;  // the steps of the first two runs are checked before anything moves
                      // (cds_motion_try()); each other run is as the second one. A step takes 7
                      // polls, and 3 for each servo of the cycle, or 4 if it begins or ends at a
                      // pose that is passed; each longer time that is tried then takes 2, and up
                      // to 1 for each servo. Not for a `read` that has steps for ever
};

/* A buffer for a step that was read. The fields are internal. */
struct cds_sequence_slot {
    struct cds_sequence_step step;
    uint8_t index;
    uint16_t run;
};

/* A sequence. Zero it (static storage is), then cds_sequence_begin(). The program reads the first
 * four fields; the rest is internal. */
struct cds_sequence {
    uint8_t result;   // CDS_PENDING while it runs; then how it ended
    uint8_t step;     // from 0 on: to whose pose the joints go, or where they rest; at the end: the
                      // last step, or that of a move that was refused or has ended
    uint16_t run;     // of that step, from 0 on
    bool is_checking; // steps are checked, and none has begun: checks_all
    // internal:
    struct cds_sequence_config config;
    struct cds_sequence_slot slots[2]; // the step under way and the next one
    uint8_t slot;                      // index of the slot with the step under way, or, while the
                                       // joints rest at a pose, with the step that begins next
    uint8_t state;
    uint8_t event;          // of the step under way
    bool passes;            // the step under way passes its pose
    bool is_paused;         // until cds_sequence_resume()
    uint16_t step_dwell_ms; // of the step under way
    uint16_t dwell_ms;      // of the pose where the joints are at rest
    uint32_t dwell_from_us; // when they came to rest
    uint32_t pass_rate;     // highest rate beside a passed pose, in 1/65536
    bool has_passed;        // while steps are tried: the step before passes its pose
};

/* Begins; the first poll begins the first step. So begin it while the robot runs: a sequence that
 * is begun while the robot is stopped moves the joints after the next cds_robot_start(). It
 * replaces a sequence whose joints rest between two steps: look at sequence.result first. CDS_OK;
 * CDS_BAD_ARGUMENT: there is no step; CDS_BUSY: a move of the motion is under way. */
enum cds_result cds_sequence_begin(struct cds_sequence *sequence,
                                   const struct cds_sequence_config *config);

/* Moves sequence and motion on, in place of cds_motion_poll(). Returns sequence.result:
 *
 *   CDS_PENDING    it runs
 *   CDS_OK         all steps are over, or it was never begun: then the motion is not polled
 *   CDS_CANCELLED  it was aborted; the joints may still brake
 *   else           why the move of sequence.step was refused or has ended: motion.h. A move behind
 *                  a passed pose is refused while the joints move: they come to rest */
enum cds_result cds_sequence_poll(struct cds_sequence *sequence);

/* Brings the joints to rest on their way, at `deceleration` as for cds_motion_pause(), until
 * cds_sequence_resume(). If the joints rest at a pose already, or the steps are checked, the next
 * step does not begin. Do nothing if the sequence does not run. */
void cds_sequence_pause(struct cds_sequence *sequence, uint16_t deceleration);
void cds_sequence_resume(struct cds_sequence *sequence);

/* Ends the sequence: sequence.result is CDS_CANCELLED at once, and the joints brake as by
 * cds_motion_abort(). They rest when motion.result is not CDS_PENDING. Does nothing if it does not
 * run. */
void cds_sequence_abort(struct cds_sequence *sequence, uint16_t deceleration);

#ifdef __cplusplus
}
#endif

#endif
