/* What commands of several files begin and poll. */
#ifndef CONTROLLER_SHARED_H
#define CONTROLLER_SHARED_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/setup.h"   // struct cds_setup
#include "console/console.h" // struct console, console_job()

_Static_assert(sizeof(struct cds_setup) + 8 <= CONSOLE_JOB_SIZE, "the job must fit");

/* cycle.c: `config` is the period in us, a uint16_t; the servos are robot->group. */
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

/* servo.c: READ and WRITE of line.id: enum cds_result. What is written is the data of the struct
 * set_job. */
uint8_t servo_read(struct console *console, uint8_t address, uint8_t length);
uint8_t servo_write(struct console *console, uint8_t address, uint8_t length);

/* setup.c: begins a setup in the struct set_job that writes `data` to line.id: enum cds_result. */
uint8_t setup_write(struct console *console, uint8_t address, const uint8_t *data, uint8_t length);
bool setup_waits(struct console *console); // console_waits() of that setup
bool setup_poll(struct console *console);  // of any command with such a setup

#endif
