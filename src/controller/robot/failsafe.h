/* SPDX-License-Identifier: MIT */
/* The failsafe acts without a user: it watches the host link and the alarms of the servos, repeats
 * a stop that did not reach all servos, and applies the settings of the bus.
 *
 * The link is watched if settings.link_loss_ms is not 0, from the first byte of the host on: before
 * that no command has moved a servo. A loss of the link stays until failsafe_clear(), even if the
 * host returns.
 *
 * Main context. */
#ifndef CONTROLLER_FAILSAFE_H
#define CONTROLLER_FAILSAFE_H

#include <stdbool.h>
#include <stdint.h>

#include "robot/robot.h"    // struct robot, ROBOT_SERVOS
#include "robot/settings.h" // struct settings

/* Values of settings.link_loss_action. */
enum failsafe_action {
    FAILSAFE_SHOW,
    FAILSAFE_INHIBIT,
    FAILSAFE_TORQUE_OFF
} __attribute__((packed));

/* Bits of `reset_cause`: those of watchdog.h. */
enum failsafe_reset {
    FAILSAFE_RESET_POWER = 1,
    FAILSAFE_RESET_EXTERNAL = 2,
    FAILSAFE_RESET_BROWN_OUT = 4,
    FAILSAFE_RESET_WATCHDOG = 8,
    FAILSAFE_RESET_JTAG = 16,
} __attribute__((packed));

/* In `alarm` and `reported`, beside the CDS_ERROR_* bits: the servo is OFFLINE. */
#define FAILSAFE_OFFLINE 0x80

/* In `alarm`, the same bit, which is not in reported[next] then: the servo has switched its torque
 * off by itself, and is inhibited (CDS_INHIBIT_STATE_LOST). */
#define FAILSAFE_TORQUE_LOST 0x80

/* Fields are read only unless their comment says who writes them. */
struct failsafe {
    struct settings *settings;    // may change at any time
    struct settings_store *store; // of the settings
    struct robot *robot;
    uint32_t heard_us;             // time of the latest byte of the host
    const uint16_t *damaged_stops; // Ctrl-X found in damaged packets, counted by the host link
    uint16_t room_bytes;           // RAM that the variables leave to the stack; main writes it
    uint16_t spare_bytes;          // RAM of the stack that was never used; main writes it
    uint8_t reset_cause;           // enum failsafe_reset bits
    uint8_t next;                  // index of the servo whose alarms were compared last
    uint8_t alarm_id;              // servo that has `alarm`
    uint8_t alarm;         // CDS_ERROR_* bits, FAILSAFE_OFFLINE or FAILSAFE_TORQUE_LOST, to be
                           // printed; the printing code clears them
    bool watching;         // the host has sent a byte since the reset
    bool link_lost;        // until failsafe_clear()
    bool unsettled;        // the settings of the bus are not applied yet
    bool host_types : 1;   // the latest input of the host was a command, which the console has set,
                           // and not a packet, which main has set
    bool counts_stack : 1; // `status` asks for a count of `spare_bytes`; main clears it when done
    bool stop_is_repeated : 1; // failsafe_confirm_stop() has begun the stop; the console clears it
    uint8_t reported[ROBOT_SERVOS]; // what was reported in `alarm`, of each servo
};

/* Zero *failsafe first (static storage is). Then set its settings, store, damaged_stops and robot;
 * the robot must have begun. `reset_cause`: enum failsafe_reset bits. */
void failsafe_begin(struct failsafe *failsafe, uint8_t reset_cause);

/* Bytes came from the host. */
void failsafe_heard(struct failsafe *failsafe);

/* Applies settings of the bus that wait. If an operation has left the bus at another rate, that
 * rate becomes the setting. Sets which servos the list takes up: `grows` of the servos. Checks the
 * host link. Begins a stop again that has not reached every servo. Checks the alarms of one servo.
 * Call it often, after failsafe_heard(). */
void failsafe_poll(struct failsafe *failsafe);

/* Begins the stop again if a servo that did not answer it answers now. The stop then reads its
 * torque as off, or switches it off. Call it only while robot and console are idle: the stop would
 * abort an operation, and `stop` prints what the last stop has read. Chips with room call it. */
void failsafe_confirm_stop(struct failsafe *failsafe);

/* Applies the settings of the bus: rate, return delay and retries. Call it when they have changed.
 * At another rate a stop is sent again if no servo is in the list: nobody has answered it. False:
 * the bus is busy, and failsafe_poll() tries again. */
bool failsafe_apply_settings(struct failsafe *failsafe);

/* Servo `id` has left the list of the robot, and entry `from`, the last one, has moved to entry
 * `to`: so does what was reported of it. An alarm of `id` is not printed. */
void failsafe_move_servo(struct failsafe *failsafe, uint8_t from, uint8_t to, uint8_t id);

/* Acknowledges alarms and the loss of the link, and allows driving. Servos that lost their state
 * stay inhibited. Sends nothing. The link is watched again. False: torque off is under way, and
 * nothing was done. */
bool failsafe_clear(struct failsafe *failsafe);

#endif
