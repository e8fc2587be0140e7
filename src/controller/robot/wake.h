/* Looks whether every servo of the group is well, and then lets each hold the position that it has.
 * For a motion that nobody watches: nothing is written before all servos are known to be well.
 *
 * Main context. */
#ifndef CONTROLLER_WAKE_H
#define CONTROLLER_WAKE_H

#include "robot/robot.h" // struct robot

/* Bytes read of a servo: from the angle limits to the present temperature, 0x06 to 0x2B. */
#define WAKE_READ_SIZE 38

/* Why a servo is not well. */
enum wake_reason {
    WAKE_WELL,
    WAKE_SILENT,  // no good reply, WAKE_TRIES times
    WAKE_ALARM,   // voltage, temperature or load
    WAKE_VOLTAGE, // outside registers 0x0C and 0x0D
    WAKE_MODE,    // endless turn
    WAKE_REFUSED, // does not take goal or torque, is being turned, or may not be driven
} __attribute__((packed));

#define WAKE_TRIES      3
#define WAKE_NEAR_STEPS 3 // a servo holds if its goal is so near to its position

/* Zero it (static storage is), then wake_begin(). Programs read the first four fields. */
struct wake {
    uint8_t why;                    // enum wake_reason of servo `id`
    uint8_t id;                     // of the servo that is not well
    uint16_t lowest[ROBOT_SERVOS];  // angle limits of each servo of the group, 0 to 1023:
    uint16_t highest[ROBOT_SERVOS]; // known after the check
    uint8_t index;                  // in the group
    uint8_t phase;
    uint8_t tries;
    bool holds; // the check was before
    bool is_submitted;
    struct cds_request request;
    uint8_t packet[CDS_PACKET_SIZE(3)];
    uint8_t reply[WAKE_READ_SIZE];
};

/* Begins to check the servos of robot->group, 1 or more; sends only READs. */
void wake_begin(struct wake *wake);

/* After the check: begins to let the servos hold. Each gets its position as goal, which is read
 * back, and then torque. A servo whose torque is on stays as it is. */
void wake_hold(struct wake *wake);

/* Goes on by at most one transaction. CDS_PENDING; CDS_OK: all servos are well, or hold;
 * CDS_REFUSED: servo wake->id is not well, wake->why tells; the servos before it may have torque.
 */
enum cds_result wake_poll(struct wake *wake, struct robot *robot);

#endif
