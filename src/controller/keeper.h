/* What keeps the robot safe when nobody looks: the watch over the host link, the alarms of the
 * servos, and why the controller was last reset.
 *
 * The link is watched from the first byte that the host sends, if settings.link_loss_ms is not 0:
 * before that nobody has moved anything, so after a reset nothing is sent and nothing moves by
 * itself. A loss stays until keeper_clear(), also when the host is back.
 *
 * Main context.
 */
#ifndef CONTROLLER_KEEPER_H
#define CONTROLLER_KEEPER_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/roster.h" // struct cds_roster
#include "settings.h"

/* Values of settings.link_loss_action. */
enum keeper_action { KEEPER_SHOW, KEEPER_HOLD, KEEPER_TORQUE_OFF };

/* Bits of `reset_cause`: those of watchdog.h. */
enum keeper_reset {
    KEEPER_RESET_POWER = 1,
    KEEPER_RESET_EXTERNAL = 2,
    KEEPER_RESET_BROWN_OUT = 4,
    KEEPER_RESET_WATCHDOG = 8,
    KEEPER_RESET_JTAG = 16,
};

/* What the keeper knows. Fields without a word about writing are to be read only. */
struct keeper {
    const struct settings *settings;
    struct cds_roster *roster; // or NULL
    uint8_t *told;             // alarms told, of each servo of the roster
    uint32_t heard_us;         // when the host was last heard
    uint8_t reset_cause;       // enum keeper_reset
    uint8_t next;              // servo of the roster whose alarms are looked at next
    uint8_t alarm_id;          // whose `alarm` it is
    uint8_t alarm;             // to be told now: CDS_ERROR_* bits, or 0; who has told them clears it
    bool watching;             // the host has been heard since the watch was armed
    bool link_lost;            // until keeper_clear()
    bool hold;                 // likewise: no goal is to be sent
    bool torque_off_wanted;    // torque is to be switched off everywhere; who has done it clears it
};

/* `told` has a byte for each servo of `roster`; both may be NULL. `reset_cause`: enum keeper_reset
 * bits. `settings` may change at any time. */
void keeper_begin(struct keeper *keeper, const struct settings *settings, struct cds_roster *roster,
                  uint8_t *told, uint8_t reset_cause);

/* Bytes came from the host. */
void keeper_heard(struct keeper *keeper);

/* Once in each turn of the main loop, after keeper_heard(). Looks at the link and at the alarms of
 * one servo. */
void keeper_poll(struct keeper *keeper);

/* The loss of the link is seen to: servos that were held for it alone may be driven again; nothing
 * is sent. The watch begins anew with the next byte of the host. */
void keeper_clear(struct keeper *keeper);

#endif
