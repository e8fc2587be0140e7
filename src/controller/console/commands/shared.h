/* Functions and types that several files of commands use. */
#ifndef CONTROLLER_SHARED_H
#define CONTROLLER_SHARED_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/setup.h"   // struct cds_setup
#include "console/console.h" // struct console, console_job()

_Static_assert(sizeof(struct cds_setup) + 8 <= CONSOLE_JOB_SIZE, "the job must fit");

/* In cycle.c. Its `config` is the period in us, a uint16_t; its servos are robot->group. */
extern const CDS_FLASH struct robot_operation cycle_operation;

/* The job of a command that writes registers. */
struct set_job {
    struct cds_setup setup;
    uint8_t data[4];      // what servo_write() writes
    uint8_t no_limits[4]; // angle limits that make an endless turn: 0
};

static inline struct set_job *set_job(struct console *console)
{
    return console_job(console);
}

/* In servo.c: submit a READ or a WRITE to line.id. The WRITE sends `data` of the struct set_job.
 * They return enum cds_result. */
uint8_t servo_read(struct console *console, uint8_t address, uint8_t length);
uint8_t servo_write(struct console *console, uint8_t address, uint8_t length);

/* In setup.c: begins a setup in the struct set_job that writes `data` to line.id. Returns enum
 * cds_result. */
uint8_t setup_write(struct console *console, uint8_t address, const uint8_t *data, uint8_t length);

/* For the poll of a command with such a setup. Returns true while the setup goes on. When it
 * returns false, it has stored the outcome in console->error and console->servo_error. */
bool setup_waits(struct console *console);

/* The poll of a command that does only such a setup: prints whether the registers were written. */
bool setup_poll(struct console *console);

#endif
