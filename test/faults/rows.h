/* SPDX-License-Identifier: MIT */
/* The rows of `make faults`: each injects one fault at every position. */
#ifndef ROWS_H
#define ROWS_H

#include "check.h"

struct row {
    const char *name;   // unique; begins with the number of the fault in docs/internals/faults.md
    const char *what;   // text of the table in docs/internals/faults.md
    const char *servos; // IDs on the bus
    void (*run)(struct check *check);
    const char *boards; // names with a space between; 0: all
};

/* rows_host runs the controller's firmware, all others run transactions.c. */
extern const struct row rows_wire[], rows_servo[], rows_line[], rows_handler[], rows_host[];

/* The transactions that faults are injected into, with servo 1. */
#define ROWS_JOBS 8
extern const struct job rows_jobs[ROWS_JOBS];
unsigned rows_reply_size(const struct job *job);
unsigned rows_packet_size(const struct job *job);

/* The allowed outcomes of a transaction whose reply comes `us` late, if the deadline allows for
 * `allowed_us`. A reply is good if it is in time by 40 us or more. A reply that is later than the
 * deadline may still be taken by the poll that sees the deadline: the bytes that arrive during the
 * poll before it count (30 us, and the time of 20 bytes at most). Then CDS_TIMEOUT. */
unsigned rows_outcome_of_late_reply(const struct check *check, const struct job *job, unsigned us,
                                    unsigned allowed_us);
#define ROWS_ALLOWED_us 606u // return delay 508 and margin 100, less the 2 us of the servo itself

#endif
