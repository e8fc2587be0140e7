/* What keeps the robot safe when nobody looks: the watch over the host link, the alarms of the
 * servos, and why the controller was last reset; and its settings.
 *
 * The link is watched from the first byte that the host sends, if settings.link_loss_ms is not 0:
 * before that nobody has moved anything, so after a reset nothing is sent and nothing moves by
 * itself. A loss stays until failsafe_clear(), also when the host is back.
 *
 * Main context.
 */
#ifndef CONTROLLER_FAILSAFE_H
#define CONTROLLER_FAILSAFE_H

#include <stdbool.h>
#include <stdint.h>

#include "robot/robot.h"    // struct robot, ROBOT_SERVOS
#include "robot/settings.h" // struct settings

/* Values of settings.link_loss_action. */
enum failsafe_action { FAILSAFE_SHOW, FAILSAFE_HOLD, FAILSAFE_TORQUE_OFF } __attribute__((packed));

/* Bits of `reset_cause`: those of watchdog.h. */
enum failsafe_reset {
    FAILSAFE_RESET_POWER = 1,
    FAILSAFE_RESET_EXTERNAL = 2,
    FAILSAFE_RESET_BROWN_OUT = 4,
    FAILSAFE_RESET_WATCHDOG = 8,
    FAILSAFE_RESET_JTAG = 16,
} __attribute__((packed));

/* What the failsafe knows. Fields without a word about writing are to be read only. */
struct failsafe {
    struct settings *settings;    // may change at any time
    struct settings_store *store; // of them
    struct robot *robot;
    uint32_t heard_us;             // when the host was last heard
    const uint16_t *damaged_stops; // Ctrl-X found in damaged packets: host.h counts them
    uint16_t room_bytes;           // of RAM that the variables leave to the stack; main writes both
    uint16_t spare_bytes;          // ... of them, never used, as of the last count
    uint8_t reset_cause;           // enum failsafe_reset bits
    uint8_t next;                  // servo of the robot whose alarms are looked at next
    uint8_t alarm_id;              // whose `alarm` it is
    uint8_t alarm;     // to be told now: CDS_ERROR_* bits, or 0; who has told them clears them
    bool watching;     // the host has been heard since the reset
    bool link_lost;    // until failsafe_clear()
    bool unsettled;    // what the settings say of the bus is not in force yet
    bool counts_stack; // `status` asks for a count of `spare_bytes`; main clears it when done
    uint8_t told[ROBOT_SERVOS]; // alarms told, of each servo
};

/* Zero *failsafe first (static storage is), and set its settings, store, damaged_stops and robot,
 * which has begun.
 * `reset_cause`: enum failsafe_reset bits. */
void failsafe_begin(struct failsafe *failsafe, uint8_t reset_cause);

/* Bytes came from the host. */
void failsafe_heard(struct failsafe *failsafe);

/* Often, after failsafe_heard() and beside robot_poll(). Looks at the link and at the alarms of one
 * servo. A rate of the bus that somebody else has changed is the setting from then on. */
void failsafe_poll(struct failsafe *failsafe);

/* Brings what the settings say of the bus into force, to be called when they have been changed.
 * False: not yet, the bus is busy; failsafe_poll() goes on with it. */
bool failsafe_follow(struct failsafe *failsafe);

/* Alarms and the loss of the link are seen to; servos that were held for it or for a stop, and for
 * nothing else, may be driven again. Nothing is sent. The watch begins anew. False: torque off is
 * under way, nothing was done. */
bool failsafe_clear(struct failsafe *failsafe);

#endif
