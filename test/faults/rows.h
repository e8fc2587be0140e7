/* The rows of `make faults`: one fault, injected at every position. */
#ifndef ROWS_H
#define ROWS_H

#include "check.h"

struct row {
    const char *name;   // unique; begins with the fault's number in faults.md
    const char *what;   // for people
    const char *servos; // on the bus
    void (*run)(struct check *check);
    const char *boards; // its wirings; 0: all
};

/* rows_host: with the controller's firmware in place of exchanges.c. */
extern const struct row rows_wire[], rows_servo[], rows_line[], rows_handler[], rows_host[];

/* The exchanges that faults are injected into: with servo 1. */
#define ROWS_JOBS 8
extern const struct job rows_jobs[ROWS_JOBS];
unsigned rows_reply_size(const struct job *job);
unsigned rows_packet_size(const struct job *job);

/* What may become of a reply that comes `us` late, if the bus allows for `allowed_us`: 40 us before
 * and more it is good. Behind it, what came by the first poll that saw the deadline pass: the one
 * before it took 30 us, and its time for each byte, 20 at the most. */
unsigned rows_late_outcome(const struct check *check, const struct job *job, unsigned us,
                           unsigned allowed_us);
#define ROWS_ALLOWED_us 606u // a return delay of 508 and a margin of 100, less the servo's own 2

#endif
