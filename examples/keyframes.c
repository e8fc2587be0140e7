/* SPDX-License-Identifier: MIT */
/* Three joints, servos 1 to 3, go through key frames, again and again. A key frame is a pose, the
 * time of the way to it, and the time of the rest there. The table is in flash. */
#include <cds55xx/follow.h>
#include <cds55xx/robot.h>
#include <cds55xx/sequence.h>
#include <cds55xx/avr.h>
#include <avr/pgmspace.h>
#include "stop_report.h"

#define JOINT(id, name)                                                                            \
    CDS_JOINT(id, CDS_FORWARD, 150000, -90000, 90000, 31000, CDS_JOINT_CDS55XX, name)

CDS_JOINTS(joints) = {JOINT(1, "base"), JOINT(2, "elbow"), JOINT(3, "wrist")};
#define JOINTS CDS_JOINT_COUNT(joints)
CDS_ROBOT(robot, joints);
CDS_AVR_ROBOT(robot, 0)

struct frame {
    int16_t degrees[JOINTS]; // whole degrees
    uint16_t time_ms, dwell_ms;
    bool passes; // the joints pass this pose without a stop
};

static const struct frame frames[] PROGMEM = {
    {{0, 0, 0}, 1500, 500, false},
    {{40, -30, 0}, 1000, 0, true},
    {{80, 0, 45}, 1000, 500, false},
    {{-40, -60, -45}, 1500, 0, false},
};
#define FRAMES (sizeof frames / sizeof frames[0])

static struct cds_motion motion;
static struct cds_motion_joint motion_joints[JOINTS];
static struct cds_sequence sequence;
static struct cds_follow follow;
static struct cds_follow_joint follow_joints[JOINTS];
static uint16_t poses[2 * JOINTS];

/* Hands a key frame to the sequence. False: there is no key frame `index`. */
static bool read_frame(void *context, uint8_t index, struct cds_sequence_step *step, uint16_t *pose)
{
    struct frame frame;

    (void)context;
    if (index >= FRAMES)
        return false;
    memcpy_P(&frame, &frames[index], sizeof frame);
    *step = (struct cds_sequence_step){
        .time_ms = frame.time_ms, .dwell_ms = frame.dwell_ms, .passes = frame.passes};
    for (uint8_t i = 0; i < JOINTS; i++)
        if (cds_robot_to_position(&robot, i, 1000l * frame.degrees[i], &pose[i]) != CDS_OK)
            stop_report_beyond(&robot, index, i, 1000l * frame.degrees[i]);
    return true;
}

/* The robot itself reports a silent servo. */
static void begin_follow(struct cds_robot *self)
{
    cds_follow_begin(&follow, &(struct cds_follow_config){.cycle = &self->cycle,
                                                          .joints = follow_joints,
                                                          .skips_silent = true});
}

static void poll_sequence(struct cds_robot *self)
{
    uint8_t result = cds_sequence_poll(&sequence);

    if (self->state != CDS_ROBOT_RUNNING)
        return;
    if (cds_follow_poll(&follow) == CDS_TIMEOUT) // it is blocked or pushed away
        stop_report_not_following(self, sequence.step, follow.joint);
    // CDS_OK: the last repeat has ended; CDS_CANCELLED: the program has ended the sequence
    if (result != CDS_PENDING && result != CDS_OK && result != CDS_CANCELLED)
        stop_report_refused(self, result, sequence.step, &motion);
}

static void on_event(struct cds_robot *self)
{
    stop_report_note(self);
    if (self->event.kind != CDS_ROBOT_EVENT_STARTED)
        return;
    cds_robot_begin_motion(self, &motion, motion_joints, NULL);
    cds_sequence_begin(&sequence,
                       &(struct cds_sequence_config){.motion = &motion,
                                                     .poses = poses,
                                                     .read = read_frame,
                                                     .checks_all = true}); // before anything moves
    begin_follow(self);
    self->on_poll = poll_sequence; // in place of the poll of the motion
}

int main(void)
{
    cds_avr_clock_open();
    sei();
    cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M);
    robot.on_event = on_event;
    cds_robot_start(&robot);
    for (;;) {
        cds_robot_poll(&robot);
        stop_report_poll(&robot);
    }
}
