/* SPDX-License-Identifier: MIT */
/* Runs a program on the PC at the host link (--host FILE): sends bytes, waits for bytes, and prints
 * the cycle at which each arrived. docs/simulator.md describes its commands. */
#ifndef SIM_PC_PROGRAM_H
#define SIM_PC_PROGRAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host/host_link.h"
#include "script/reset_injection.h"
#include "wire/schedule.h"

#define PC_RECEIVED_MAX 4096 // bytes of one `hear`

enum pc_verb { PC_SAY, PC_TEXT, PC_REST, PC_HEAR, PC_WAIT, PC_BAUD, PC_FLOOD, PC_RESET, PC_EXPECT };

struct pc_line {
    enum pc_verb verb;
    unsigned number;          // in the file, from 1
    const char *text;         // SAY, TEXT, EXPECT
    int32_t value;            // HEAR, FLOOD: bytes; WAIT: us; BAUD: bit/s
    uint32_t within_ms;       // HEAR, EXPECT
    int32_t seed;             // FLOOD
    struct reset_order reset; // RESET
};

struct pc_program {
    const char *path;
    char *text;
    struct pc_line *line;
    unsigned count, next;
    struct schedule *schedule;
    uint32_t clock_Hz;
    struct host_link *link;
    FILE *out;
    struct event step;
    bool done; // on_end was called
    bool waiting;
    uint64_t deadline;                 // of the present HEAR or EXPECT
    uint8_t received[PC_RECEIVED_MAX]; // since the latest `say`, `text` or `flood`
    uint64_t times[PC_RECEIVED_MAX];   // cycle of each received byte
    size_t size, printed;              // received bytes; bytes already printed
    int32_t flood;                     // bytes still to send
    uint32_t random;
    void *context;
    void (*on_reset)(void *context, uint64_t now, const struct reset_order *order);
    void (*on_end)(void *context, uint64_t now, const char *wrong); // wrong 0: no error
};

/* Parses the whole file. Returns false, with `file:line: what` on stderr. */
bool pc_program_read(struct pc_program *program, const char *path);
void pc_program_free(struct pc_program *program);

/* The program begins when the firmware listens. */
void pc_program_start(struct pc_program *program, struct schedule *schedule, uint32_t clock_Hz,
                      struct host_link *link, FILE *out);

/* True if the run may not end yet: lines are left. A flood in the last line may be cut short. */
bool pc_program_is_unfinished(const struct pc_program *program);

/* The number of the line of the file that is carried out, or waits for the firmware to receive. */
unsigned pc_program_line_number(const struct pc_program *program);

/* A byte from the firmware. */
void pc_program_receive(struct pc_program *program, uint64_t now, uint8_t byte);

#endif
