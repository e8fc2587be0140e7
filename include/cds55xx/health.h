/* SPDX-License-Identifier: MIT */
/* The state check, beside the application: finds servos that lost their state between two
 * transactions (power failed for a moment, so torque is off), and servos that come back. What it
 * finds is in struct cds_servo_state: presence, and CDS_INHIBIT_STATE_LOST. Manual: 2.4.2, 2.4.5,
 * registers 0x10, 0x18; R3, R31.
 *
 *     cds_health_begin(&health, &(struct cds_health_config){
 *         .servos = &servos, .period_us = CDS_HEALTH_PERIOD_US});
 *     for (;;) {
 *         cds_bus_poll(&bus);
 *         cds_health_poll(&health);
 *     }
 *
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

/* The usual period, in which each servo is asked once. */
#define CDS_HEALTH_PERIOD_US 1000000ul

/* From one PING of an OFFLINE servo to the next one. */
#define CDS_HEALTH_SEEK_US 100000ul

/* From a READ without a good reply to the next READ of this servo, at most, until it is OFFLINE. */
#define CDS_HEALTH_AGAIN_US 20000ul

/* Copied; `servos` stays in place. */
struct cds_health_config {
    struct cds_servos *servos; // begun
    uint32_t period_us;        // 10 000 to 1 000 000 000
};

/* Zero it (static storage is), then cds_health_begin(). The fields are internal. */
struct cds_health {
    struct cds_servos *servos;
    struct cds_cycle *cycle; // or NULL
    struct cds_request request;
    uint32_t step_us;    // from one servo to the next
    uint32_t look_us;    // when the next servo is asked
    uint32_t seek_us;    // when the next servo is asked that is OFFLINE or RETURNED
    uint8_t turn;        // entry of the servo that is asked next
    uint8_t sought;      // entry of the servo that is OFFLINE or RETURNED, or CDS_NO_ID
    uint8_t event_count; // of the servos, when it was chosen
    bool is_chosen;      // `sought` was not asked yet
    bool is_running;     // begun, and not aborted
    uint8_t asked; // presence of the servo asked last when it was asked; CDS_PRESENCE_OFFLINE:
                   // nothing is left to do with its answer
    uint8_t packet[CDS_PACKET_SIZE(2)];
    uint8_t reply; // to the READ
};

/* Begins. In each period each servo has its TORQUE_ENABLE read, one after the other and evenly
 * spread; a servo that is OFFLINE or answers no READ (status return level 0) is PINGed. Beside that
 * an OFFLINE servo is PINGed every CDS_HEALTH_SEEK_US, in turn, unless one is RETURNED. A RETURNED
 * servo is read at once, and after a failure again every CDS_HEALTH_SEEK_US; if it answers a PING
 * after CDS_SERVOS_MISSES failures, it answers no READ, and is taken for a servo that lost its
 * state, unless its torque was off. Noise may have been the reason: while its state counts as lost,
 * or its torque is off, READ and PING alternate. A READ that it answers makes its status return
 * level unknown again, and if torque is on, CDS_INHIBIT_STATE_LOST ends.
 *
 * A servo that gives no good answer is asked again within CDS_HEALTH_AGAIN_US, until it is OFFLINE.
 *
 * A lost state shows within a period, and 20 ms more beside a cycle, but not if torque was off: set
 * the speed again whenever torque is switched on. For 50 servos and a period of 1 s there are at
 * most 60 transactions a second of 0.25 ms each (1 Mbps, factory return delay). No transaction is
 * retried. Nothing is sent while the bus is in use, so other requests wait for one transaction.
 *
 * CDS_OK; CDS_BAD_ARGUMENT: the period is out of range; CDS_BUSY: the request of this check is in
 * flight, and nothing was changed. Divides 32-bit numbers: not for the hot path. */
enum cds_result cds_health_begin(struct cds_health *health, const struct cds_health_config *config);

/* From now on transactions begin only where they end before the next goals of `cycle`, which is on
 * the same bus and was begun; NULL: no cycle. CDS_OK; CDS_BAD_ARGUMENT: the goals leave less time
 * than a READ of the slowest servo takes; nothing was changed. A servo whose return delay later
 * grows beyond that time is not asked any more. */
enum cds_result cds_health_set_cycle(struct cds_health *health, struct cds_cycle *cycle);

/* Moves on by at most one transaction; call it from the main loop. */
void cds_health_poll(struct cds_health *health);

/* Ends the check: a request that waits is taken back. Polls do nothing until it begins again. */
void cds_health_abort(struct cds_health *health);

#ifdef __cplusplus
}
#endif

#endif
