/* SPDX-License-Identifier: MIT */
/* What the operations of several transactions have in common: scan, identity, setup, diagnose,
 * group read, registered move, SYNC WRITE to many, torque off. x_begin(&x, ...) prepares one.
 * x_poll(&x) moves it on, from the main loop beside cds_bus_poll(). x_abort(&x) ends it early.
 *
 * Programs read `result` only. Main context.
 */
#ifndef CDS_STEPS_H
#define CDS_STEPS_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus, struct cds_request, struct cds_bus_lock

#ifdef __cplusplus
extern "C" {
#endif

/* What an operation knows of its steps. The program reads `result`. */
struct cds_steps {
    // internal:
    struct cds_bus *bus;
    struct cds_request *request; // of the step under way
    // to be read:
    uint8_t result; // enum cds_result: CDS_PENDING until the operation has ended
    // internal:
    uint8_t outcome;          // what it will end as; CDS_PENDING: not decided
    bool is_submitted;        // the request of the step was submitted
    bool is_exclusive;        // the operation holds the bus by `lock` until it ends
    uint16_t return_delay_us; // of the bus, to be restored
    struct cds_bus_lock lock; // its baud_reg is the rate to be restored
};

#ifdef __cplusplus
}
#endif

#endif
