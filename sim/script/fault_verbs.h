/* SPDX-License-Identifier: MIT */
/* What each fault does (fault_verbs.c), and what faults.c does for it. Only these two files use it.
 * To add a fault or a quirk: CONTRIBUTING.md, "Add a fault". */
#ifndef SIM_FAULT_VERBS_H
#define SIM_FAULT_VERBS_H

#include "script/faults.h"

/* What a verb acts on. `byte`: a byte that begins. `reply`: a reply that is due; returns false if
 * it cannot act. `servo`: each servo that the order names, at once; returns
 * the end of the fault. `now`: the wire, or all orders, at once. */
struct fault_verb_ops {
    void (*byte)(struct faults *faults, const struct fault_order *order, uint64_t now,
                 const struct uart_tx *tx);
    bool (*reply)(const struct fault_order *order, struct servo_node *node);
    uint64_t (*servo)(struct faults *faults, const struct fault_order *order, uint64_t now,
                      struct servo_node *node);
    void (*now)(struct faults *faults, const struct fault_order *order, uint64_t now);
};

extern const struct fault_verb_ops fault_verbs[FAULT_VERBS];

/* Prepares the faults that last: stuck, noise, babble. */
void fault_verbs_init(struct faults *faults);

/* A fault acts until `until`. Servos that send or are about to send are exempt from the rules, and
 * so are replies to the controller's present packet. */
void fault_exempt_senders(struct faults *faults, uint64_t until);

/* Overrides the level of the wire from pulse.from to pulse.until. */
void fault_override(struct faults *faults, uint64_t now, struct fault_pulse pulse);

/* Counts an action and reports it to faults->on_act. */
void fault_notify(struct faults *faults, uint64_t now, uint64_t until, enum fault_verb verb);

/* Adds the IDs of the order that no servo has now. */
void fault_find_absent(const struct faults *faults, const struct fault_order *order,
                       bool absent[IDS_MAX]);

#endif
