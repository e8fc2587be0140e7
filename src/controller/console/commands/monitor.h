/* SPDX-License-Identifier: MIT */
/* The command `monitor`: what its two forms of output share. */
#ifndef CONTROLLER_MONITOR_H
#define CONTROLLER_MONITOR_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/feedback.h" // struct cds_feedback
#include "console/console.h"  // console_job()

/* Range of the period, in ms. */
#define MONITOR_MS_MIN 10
#define MONITOR_MS_MAX 60000

/* Servos of a line or table. */
#define MONITOR_SERVOS 8

/* Values of a servo. */
#define MONITOR_VALUES 5
#define MONITOR_ABSENT MONITOR_VALUES       // instead of a value: the servo does not answer
#define MONITOR_LEAVE  (MONITOR_VALUES + 1) // instead of a value: go below the table

/* The job of the command. */
struct monitor {
    uint32_t next_us; // when the next line begins
    uint32_t period_us;
    struct cds_feedback feedback;
    uint16_t lines;
    uint16_t failed;
    uint8_t ids[MONITOR_SERVOS];
    uint8_t count;
    uint8_t index;    // servo being read
    uint8_t value;    // of that servo, being printed
    uint8_t below;    // rows of the table before that the cursor is above
    bool begun;       // the line has a value already
    bool is_table;    // prints a table that stays in place, else lines
    bool is_answered; // a servo has answered
    bool is_cleared;  // the table is cleared: the next one is not printed over it
};

_Static_assert(sizeof(struct monitor) <= CONSOLE_JOB_SIZE, "the job must fit");

static inline struct monitor *monitor_job(struct console *console)
{
    return console_job(console);
}

/* begin and poll of the command. */
uint8_t monitor_begin(struct console *console);
bool monitor_poll(struct console *console);

/* The register value of `value`, 0 to MONITOR_VALUES - 1, of the servo that has answered, and its
 * unit (enum cds_unit). */
uint16_t monitor_value(struct console *console, uint8_t value, uint8_t *unit);

/* In monitor_table.c, `monitor` of struct command_set: prints `value` of a servo in the table, or
 * that the servo is absent, in the table or in the line. MONITOR_LEAVE, when the command ends
 * within a table: moves the cursor below it. */
void monitor_table(struct console *console, uint8_t value);

/* In monitor_table.c, between two tables in mode person: prints what no command asked for. False:
 * there is nothing. */
bool monitor_report(struct console *console);

/* In monitor_table.c: clears the table, if one stands above the cursor. The next one comes at once.
 */
void monitor_clear_table(struct console *console);

#endif
