/* What test/firmware/library/exchanges.c is told to do and what it tells of it: a struct in its RAM
 * that the host's side (rig.h) writes and reads from outside. Bytes and little-endian words,
 * packed, so that both compilers lay it out alike. */
#ifndef JOB_H
#define JOB_H

#include <stdint.h>

#include "cds55xx/servos.h" // struct cds_stats and those of a servo, which may grow

#define JOB_DATA_MAX  50 // the whole control table
#define JOB_FOUND_MAX 8

enum job_kind {
    JOB_PING,
    JOB_READ,
    JOB_WRITE,
    JOB_REG_WRITE,
    JOB_ACTION,
    JOB_SCAN,        // IDs `id` to `address`, at the bus's own rate
    JOB_SCAN_LISTED, // at the six listed rates, with details
    JOB_LOOK,        // nothing is asked: how things stand
};

enum job_roster { JOB_ALONE, JOB_ROSTER, JOB_ROSTER_ANEW }; // of servos 1 and 2

/* The program puts these on PORTB as it goes on; the host notes when. */
enum job_mark { JOB_READY, JOB_BEGUN, JOB_ENDED, JOB_LOOKS };

struct __attribute__((packed)) job {
    uint8_t kind; // enum job_kind
    uint8_t id;
    uint8_t address;
    uint8_t length; // of what is read, or of `data` to be written
    uint8_t repeats;
    uint8_t pause;  // before it, in units of 100 us, nobody polls
    uint8_t told;   // return delay that the bus is told of, in units of 2 us; 0: the longest
    uint8_t roster; // enum job_roster
    uint8_t data[JOB_DATA_MAX];
};

/* What the roster knows of a servo. */
struct __attribute__((packed)) job_known {
    struct cds_servo_counters counters;
    uint8_t return_delay, status_return_level, alarms, presence, misses, inhibited, torque;
};

struct __attribute__((packed)) job_outcome {
    uint8_t submitted; // enum cds_result of the call
    uint8_t result;    // of the exchange, or of the scan
    uint8_t state;     // enum cds_bus_line, when it had ended
    uint8_t alarms;    // of the roster
    uint8_t id;
    uint8_t error;
    uint8_t length;
    uint8_t spilled;              // bytes of the packet, and behind the reply due, that changed
    uint8_t data[JOB_DATA_MAX];   // as cds_request_byte() gives them
    uint16_t asked, found;        // of a scan
    uint8_t ids[JOB_FOUND_MAX];   // who was found,
    uint8_t bauds[JOB_FOUND_MAX]; // at what rate,
    uint8_t owns[JOB_FOUND_MAX];  // and what its register says
    struct job_known known;       // of servo 1
    struct cds_stats stats;       // since the program began
};

struct __attribute__((packed)) job_board {
    uint8_t go;          // the host sets it, the program clears it
    uint8_t hold_vector; // of the handler that holds all others up,
    uint16_t hold_loops; // so many times four cycles
    struct job job;
    struct job_outcome outcome;
};

#endif
