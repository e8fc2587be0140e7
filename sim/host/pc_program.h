/* A program on the PC at the host link: says bytes, waits for bytes, and tells when each came, to
 * the cycle. One command a line: docs/simulator.md. */
#ifndef SIM_PC_PROGRAM_H
#define SIM_PC_PROGRAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host/host_link.h"
#include "wire/schedule.h"
#include "script/reset_injection.h"

#define PC_HEARD_MAX 4096 // bytes of one `hear`

enum pc_verb { PC_SAY, PC_TEXT, PC_REST, PC_HEAR, PC_WAIT, PC_BAUD, PC_FLOOD, PC_RESET };

struct pc_line {
    enum pc_verb verb;
    unsigned number;          // in the file, from 1
    const char *text;         // SAY, TEXT
    int32_t value;            // HEAR, FLOOD: bytes; WAIT: us; BAUD
    int32_t within_ms;        // HEAR
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
    bool hearing;
    uint64_t deadline;              // of what is waited for
    uint8_t received[PC_HEARD_MAX]; // since the last `say`, `text` or `flood`
    uint64_t times[PC_HEARD_MAX];   // of each
    size_t size, taken;             // of them; told already
    int32_t flood;                  // bytes left
    uint32_t random;
    void *context;
    void (*on_reset)(void *context, uint64_t now, const struct reset_order *order);
    void (*on_end)(void *context, uint64_t now, const char *wrong); // 0: all went well
};

/* Reads and checks the whole file. False, with `file:line: what` on stderr. */
bool pc_program_read(struct pc_program *program, const char *path);
void pc_program_free(struct pc_program *program);

/* Begins when the firmware listens. */
void pc_program_start(struct pc_program *program, struct schedule *schedule, uint32_t clock_Hz,
                      struct host_link *link, FILE *out);

/* A byte that the firmware said. */
void pc_program_receive(struct pc_program *program, uint64_t now, uint8_t byte);

#endif
