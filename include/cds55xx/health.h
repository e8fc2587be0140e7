/* The state check, which runs for ever beside the application: finds servos that lost their state
 * (power was gone for a moment, so torque is off) between two exchanges, and those that come back.
 * Manual: 2.4.2, 2.4.5, registers 0x10, 0x18; R3, R31.
 *
 *     cds_health_begin(&watch, &roster, CDS_HEALTH_PERIOD_US);
 *     for (;;) {
 *         cds_bus_poll(&bus);
 *         cds_health_poll(&watch);
 *         ...
 *     }
 *
 * Once a period, one after the other and evenly spread, each servo of the roster has TORQUE_ENABLE
 * read, or is PINGed if it is away or set not to answer a READ. Beside that one of those that are
 * away is PINGed every CDS_HEALTH_SEEK_US, in turn, and one that is back is read at once, if that
 * fails again after as long. So it sends, each second of 50 servos and a period of 1 s, at most 50
 * exchanges and 20 more; at 1 Mbps, factory return delay, 0.25 ms each. What comes of it stands in
 * the roster: who is away, here, or held as CDS_INHIBIT_STATE_LOST.
 *
 * A servo that answers no READ (status return level 0) cannot be looked at when it is back: it
 * counts as one that lost its state.
 *
 * So a lost state shows within a period of the power being back and, beside a cycle, 20 ms more.
 * Not before torque was switched on, though: of a servo whose torque is off nothing shows that its
 * speed is the initial one again. Set the speed anew whenever torque is switched on.
 *
 * It sends only when the bus is free, so other requests wait for one such exchange at most; and
 * beside a cycle only where there is time for it before the next goals: cds_health_set_cycle().
 * Main context.
 */
#ifndef CDS_HEALTH_H
#define CDS_HEALTH_H

#include <stdbool.h>
#include <stddef.h> // NULL
#include <stdint.h>

#include "cds55xx/cycle.h"  // struct cds_cycle
#include "cds55xx/servos.h" // struct cds_servos

#ifdef __cplusplus
extern "C" {
#endif

/* The usual time in which each servo is looked at once. */
#define CDS_HEALTH_PERIOD_US 1000000ul

/* From one PING of a servo that is away to that of the next one. */
#define CDS_HEALTH_SEEK_US 100000ul

/* A state check. Zero it (static storage is), then cds_health_begin(). */
struct cds_health {
    struct cds_servos *roster;
    struct cds_cycle *cycle; // beside which it runs, or NULL
    struct cds_request request;
    uint32_t step_us; // from one servo to the next
    uint32_t look_us; // when the next one is due
    uint32_t seek_us; // when the next PING of one that is away is
    uint32_t back_us; // when one that is back may be read again
    uint16_t epoch;   // of the roster, when those that are back were looked for
    uint8_t buffer[CDS_PACKET_SIZE(2)];
    uint8_t turn;   // servo that is due next
    uint8_t seeker; // servo that was PINGed last because it is away
    uint8_t back;   // servo that is back, or `count` of the roster: none
};

/* Begins a state check of the servos of `roster`, which cds_servos_begin() has begun, each once in
 * `period_us`, 10 000 to 1 000 000 000 microseconds. Watch and roster stay in place. CDS_OK;
 * CDS_BAD_ARGUMENT: the period is out of range; CDS_BUSY: this very watch has a request on its way.
 * Divides 32-bit numbers: not for the hot path. */
enum cds_result cds_health_begin(struct cds_health *watch, struct cds_servos *roster,
                                 uint32_t period_us);

/* From now on it stays out of the way of `cycle`, on the same bus, begun, and in place; of none if
 * NULL. Polled in any order. CDS_OK; CDS_BAD_ARGUMENT: goals leave less than the time of a READ of
 * the slowest servo, and nothing was set: return delays or the period must be other ones. A servo
 * whose return delay grows beyond that later is not looked at, and the others are as before. */
enum cds_result cds_health_set_cycle(struct cds_health *watch, struct cds_cycle *cycle);

/* Moves on by at most one exchange; call it from the main loop, for ever. */
void cds_health_poll(struct cds_health *watch);

#ifdef __cplusplus
}
#endif

#endif
