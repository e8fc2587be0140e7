/* The rig of `make faults`: a board that runs test/firmware/library/exchanges.c, servos on its bus,
 * and taps that write down what was said and heard. The machine is started once and does one job
 * after the other. All time is in CPU cycles. */
#ifndef RIG_H
#define RIG_H

#include <stdbool.h>
#include <stdint.h>

#include "testbench.h"
#include "job.h"

#define RIG_US      16u  // cycles
#define RIG_BYTE    160u // cycles at 1 Mbps
#define RIG_ROOM    8192 // bytes that a tap keeps; later ones are counted only
#define RIG_ANSWERS 16
#define RIG_TIMED   4

struct tap {
    unsigned count;
    struct tap_byte {
        uint64_t time; // heard: mid stop bit; said: start bit
        uint8_t byte;
        bool bad; // framing error
    } bytes[RIG_ROOM];
};

/* A reply as the servo meant it, before any fault has touched it. */
struct answer {
    unsigned size;
    uint8_t bytes[SERVO_PACKET_MAX];
};

/* An order that is given in the course of an exchange. */
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
    bool late;                    // the limit was met
    uint64_t begun, ended, ready; // of the latest job
    struct tap said, heard, servos_heard;
    uint32_t overruns; // bytes overwritten in the receiver
    struct answer answers[RIG_ANSWERS];
    unsigned answer_count; // later ones are counted only
    struct timed_order timed[RIG_TIMED];
    uint64_t released;   // when the TX enable last went off
    uint64_t hold_until; // when the handler that holds up the others was last left
    struct event hold;   // raises it
    int64_t hold_after;  // the first byte of the next packet; INT64_MIN: not to be raised
};

/* False, with one line on stderr. `servos`: as for --servos; several may have one ID. `console`: it
 * is the controller's own firmware, which takes no jobs. */
bool rig_open(struct rig *rig, const char *elf, const char *boards, const char *board,
              const char *servos, bool console);
void rig_close(struct rig *rig);

uint64_t rig_now(const struct rig *rig);
struct servo_node *rig_node(struct rig *rig, unsigned index);
bool rig_tied(const struct rig *rig);

/* The taps forget, but for that of the servos; the rules too. */
void rig_forget(struct rig *rig);
void rig_pass(struct rig *rig, uint64_t cycles);
/* A fault order as in docs/faults.md; a bad one ends the program. */
void rig_order(struct rig *rig, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The same, so many cycles from now. */
void rig_order_in(struct rig *rig, uint64_t cycles, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Until nobody talks or is about to. False: not within a second. */
bool rig_settle(struct rig *rig);

/* Gives the job; rig_wait() then runs until it is done, at most so long. False: it is not. */
void rig_begin(struct rig *rig, const struct job *job);
bool rig_wait(struct rig *rig, uint64_t cycles, struct job_outcome *outcome);

/* A handler of the program's, of 4 cycles times `loops` and some, is raised so long after the first
 * byte of the next packet. */
void rig_hold(struct rig *rig, int64_t after, uint16_t loops);

/* The controller has let go of the wire and hears it. */
bool rig_listens(const struct rig *rig);

#endif
