/* SPDX-License-Identifier: MIT */
/* The rig of `make faults`: a board that runs test/firmware/library/transactions.c, servos on its
 * bus, and taps that record sent and received bytes. The machine starts once and runs one job after
 * the other. All times are in CPU cycles. */
#ifndef RIG_H
#define RIG_H

#include <stdbool.h>
#include <stdint.h>

#include "testbench.h"
#include "job.h"

#define RIG_US      16u  // cycles
#define RIG_BYTE    160u // cycles at 1 Mbit/s
#define RIG_ROOM    8192 // bytes that a tap keeps; later bytes are only counted
#define RIG_ANSWERS 16
#define RIG_TIMED   4

struct tap {
    unsigned count;
    struct tap_byte {
        uint64_t time; // received: middle of the stop bit; sent: start bit
        uint8_t byte;
        bool bad; // framing error
    } bytes[RIG_ROOM];
};

/* A reply as the servo built it, before the fault changes it. */
struct answer {
    unsigned size;
    uint8_t bytes[SERVO_PACKET_MAX];
};

/* An order that is executed during a transaction. */
struct timed_order {
    struct rig *rig;
    struct event event;
    char text[80];
};

struct rig {
    struct testbench bench;
    struct testbench_options options;
    uint32_t job_at; // address of job_board
    struct event limit;
    bool timed_out;               // the time limit was reached
    uint64_t begun, ended, ready; // of the latest job
    struct tap sent, received, servos_received;
    uint32_t overruns; // bytes overwritten in the receiver
    struct answer answers[RIG_ANSWERS];
    unsigned answer_count; // later replies are only counted
    struct timed_order timed[RIG_TIMED];
    uint64_t released;   // when the TX enable last turned off
    uint64_t hold_until; // when the holding handler last ended
    struct event hold;   // raises the holding handler
    int64_t hold_after;  // cycles after the first byte of the next packet; INT64_MIN: not raised
};

/* `servos` is as for --servos; servos may share an ID. `console`: the ELF is the controller's own
 * firmware, which takes no jobs. Returns false, with one line on stderr. */
bool rig_open(struct rig *rig, const char *elf, const char *boards, const char *board,
              const char *servos, bool console);
void rig_close(struct rig *rig);

uint64_t rig_now(const struct rig *rig);
struct servo_node *rig_node(struct rig *rig, unsigned index);
bool rig_tied(const struct rig *rig);

/* Clears the taps, except that of the servos, and the counts of the rules. */
void rig_forget(struct rig *rig);
void rig_pass(struct rig *rig, uint64_t cycles);
/* Injects a fault (docs/faults.md). A wrong order ends the program. */
void rig_order(struct rig *rig, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Injects a fault `cycles` from now. */
void rig_order_in(struct rig *rig, uint64_t cycles, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Runs until no servo and no controller sends or is about to send. Returns false after 50 000 steps
 * of 20 us. */
bool rig_settle(struct rig *rig);

/* rig_begin() starts a job. rig_wait() runs until it is done, and returns false if that takes more
 * than `cycles`. */
void rig_begin(struct rig *rig, const struct job *job);
bool rig_wait(struct rig *rig, uint64_t cycles, struct job_outcome *outcome);

/* Raises the holding handler `after` cycles after the first byte of the next packet. The handler
 * belongs to the program, takes 4 cycles times `loops` and delays all other handlers. */
void rig_hold(struct rig *rig, int64_t after, uint16_t loops);

/* Returns true if the controller has released the wire and receives. */
bool rig_listens(const struct rig *rig);

#endif
