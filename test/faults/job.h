/* SPDX-License-Identifier: MIT */
/* The jobs of test/firmware/library/transactions.c and their outcomes: a struct in the RAM of that
 * program, which the host (rig.h) writes and reads from outside. The struct is packed and has
 * little-endian words, so that both compilers lay it out alike. */
#ifndef JOB_H
#define JOB_H

#include <stdint.h>

#include "cds55xx/servos.h" // struct cds_stats, struct cds_servo_counters

#define JOB_DATA_MAX  50 // the whole control table
#define JOB_FOUND_MAX 8

enum job_kind {
    JOB_PING,
    JOB_READ,
    JOB_WRITE,
    JOB_REG_WRITE,
    JOB_ACTION,
    JOB_SCAN,        // IDs `id` to `address`, at the rate of the bus
    JOB_SCAN_LISTED, // IDs `id` to `address`, at the six listed rates, with details
    JOB_LOOK,        // no transaction: reads what has arrived, reports state and counters
};

/* Whether the bus has a servos.h with servos 1 and 2; JOB_NEW_SERVOS: begins it anew. */
enum job_servos { JOB_WITHOUT_SERVOS, JOB_WITH_SERVOS, JOB_NEW_SERVOS };

/* The program puts these values on PORTB; the host records the time of each. */
enum job_mark { JOB_READY, JOB_BEGUN, JOB_ENDED, JOB_LOOKS };

struct __attribute__((packed)) job {
    uint8_t kind; // enum job_kind
    uint8_t id;
    uint8_t address;
    uint8_t length; // bytes to read, or bytes of `data` to write
    uint8_t retries;
    uint8_t pause;        // before the job, in units of 100 us; the bus is not polled meanwhile
    uint8_t return_delay; // that the bus is set to, in units of 2 us; 0: the longest
    uint8_t servos;       // enum job_servos
    uint8_t data[JOB_DATA_MAX];
};

/* What servos.h knows of a servo. */
struct __attribute__((packed)) job_known {
    struct cds_servo_counters counters;
    uint8_t return_delay, status_return_level, alarms, presence, misses, inhibited, torque;
};

struct __attribute__((packed)) job_outcome {
    uint8_t submitted; // enum cds_result of the call
    uint8_t result;    // enum cds_result of the transaction or of the scan
    uint8_t state;     // enum cds_bus_line at the end of the job
    uint8_t alarms;    // of all servos in servos.h
    uint8_t id;
    uint8_t error;
    uint8_t length;
    uint8_t spilled;            // bytes that changed in the packet buffer, or behind the reply
    uint8_t data[JOB_DATA_MAX]; // from cds_request_byte()
    uint16_t asked, found;      // of a scan
    // for each servo that a scan has found
    uint8_t ids[JOB_FOUND_MAX];
    uint8_t baud_regs[JOB_FOUND_MAX];     // rate at which it was found
    uint8_t own_baud_regs[JOB_FOUND_MAX]; // value of its register 0x04
    struct job_known known;               // of servo 1
    struct cds_stats stats;               // since the program began
};

struct __attribute__((packed)) job_board {
    uint8_t go;          // the host sets it, the program clears it
    uint8_t hold_vector; // vector of the handler that delays all other handlers
    uint16_t hold_loops; // duration of that handler, in loops of four cycles
    struct job job;
    struct job_outcome outcome;
};

#endif
