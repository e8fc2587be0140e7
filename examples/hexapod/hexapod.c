/* SPDX-License-Identifier: MIT */
/* A hexapod of 18 servos walks 6 s in a tripod gait, then stands. Three feet stand and push back
 * while the other three are lifted and swing forward. docs/img/hexapod.svg shows it from above.
 * Torque goes off if a servo fails, a leg is blocked, or the gait is refused.
 *
 * Leg n has the servos 3n + 1 (coxa: turns about the vertical axis), 3n + 2 (femur) and 3n + 3
 * (tibia); legs 0, 1, 2 stand on the right side from front to rear, 3, 4, 5 on the left side. At
 * 150 degrees a leg points straight out, its femur is level and its tibia points down. */
#include <cds55xx/gait.h>
#include <cds55xx/robot.h>
#include <cds55xx/avr.h>

#define WALK_PERIODS 1500 // 6 s

/* All joints: 60 degrees to both sides of the middle, 45 RPM. */
#define JOINT(id, name)                                                                            \
    CDS_JOINT(id, CDS_FORWARD, 150000, -60000, 60000, 45000, CDS_JOINT_CDS55XX, name)
#define LEG(first_id, leg)                                                                         \
    JOINT(first_id, "coxa " leg), JOINT(first_id + 1, "femur " leg),                               \
        JOINT(first_id + 2, "tibia " leg)

CDS_JOINTS(joints) = {
    LEG(1, "R1"), LEG(4, "R2"), LEG(7, "R3"), LEG(10, "L1"), LEG(13, "L2"), LEG(16, "L3"),
};
CDS_ROBOT(robot, joints);
CDS_AVR_ROBOT(robot, 0)

/* A joint that swings about `rest`, in steps of 300 / 1023 degrees. `turn`: 0 to 359 degrees. */
#define SWINGS(rest_position, steps, turn, shape)                                                  \
    {                                                                                              \
        .rest = (rest_position), .sines = {                                                        \
            {.amplitude = (steps), .phase = CDS_GAIT_PHASE(turn), .multiple = 1, .wave = shape}    \
        }                                                                                          \
    }
/* A leg: the coxa swings 20 degrees to both sides. While it swings forward, the femur, 30 degrees
 * above the level, goes up by 25 degrees and the tibia folds by 15. `side`: 1 right, -1 left, where
 * the servos are mirrored. `turn`: where in its step the leg begins; from 0 to 180 it is lifted. */
#define WALKS(side, turn)                                                                          \
    SWINGS(512, (side)*68, ((turn) + 270) % 360, CDS_GAIT_SINE),                                   \
        SWINGS(512 + (side)*102, (side)*85, turn, CDS_GAIT_LIFT),                                  \
        SWINGS(512, (side)*51, turn, CDS_GAIT_LIFT)

CDS_GAIT_TABLE(tripod) = {
    WALKS(1, 0), WALKS(1, 180), WALKS(1, 0), WALKS(-1, 180), WALKS(-1, 0), WALKS(-1, 180),
};
static struct cds_gait_state states[CDS_JOINT_COUNT(joints)];
static struct cds_gait gait;

/* False: the cycle was not begun, or a time of the gait is out of range. */
static bool begin_to_walk(void)
{
    struct cds_gait_config config = {.cycle = &robot.cycle,
                                     .servos = &robot.servos,
                                     .joints = tripod,
                                     .states = states,
                                     .period_ms = 1000,
                                     .ramp_ms = 1500};

    return cds_gait_begin(&gait, &config) == CDS_OK;
}

/* Goes on with the gait. False: the gait or one of its goals was refused. */
static bool walk(void)
{
    enum cds_result result = cds_gait_poll(&gait);

    return result == CDS_PENDING || result == CDS_OK;
}

int main(void)
{
    bool walks = false;

    cds_avr_clock_open();
    sei();
    cds_robot_open(&robot, &robot_config, 0, CDS_BAUD_1M);
    cds_robot_start(&robot);
    for (;; cds_robot_poll(&robot)) {
        if (robot.state != CDS_ROBOT_RUNNING)
            continue;
        if (!walks)
            walks = begin_to_walk();
        if (robot.cycle.counters.periods >= WALK_PERIODS)
            cds_gait_stop(&gait);
        if (!walks || !walk())
            cds_robot_stop(&robot);
    }
}
