/* What commands of several files begin and poll. */
#ifndef CONTROLLER_SHARED_H
#define CONTROLLER_SHARED_H

#include <stdbool.h>
#include <stdint.h>

#include "flash.h" // CDS_FLASH

struct console;
struct robot_operation;

/* cycle.c: `config` is the period in us, a uint16_t; the servos are robot->group. */
extern const CDS_FLASH struct robot_operation cycle_operation;

/* servo.c: READ and WRITE of line.id: enum cds_result. What is written is console->job.set.data. */
uint8_t servo_read(struct console *console, uint8_t address, uint8_t length);
uint8_t servo_write(struct console *console, uint8_t address, uint8_t length);

/* setup.c: begins a setup in console->job that writes there to line.id: enum cds_result. */
uint8_t setup_write(struct console *console, uint8_t address, const uint8_t *data, uint8_t length);
bool setup_waits(struct console *console); // console_waits() of a setup in console->job
bool setup_poll(struct console *console);  // of any command with a setup in console->job

#endif
