/* SPDX-License-Identifier: MIT */
/* Runs the injections of `make faults` and checks each of them, whatever the fault:
 *
 * - The call ends by its deadline, and not before its deadline if it failed. The driver is
 *   released. No rule of the wire is broken.
 * - The controller sends the packet of the request and nothing else.
 * - Outcome, values and counters are those that oracle.h predicts from the received bytes.
 * - No byte is stored behind the reply.
 * - The library takes a value that no servo sent only where this was predicted.
 * - No servo holds a value that was not requested, unless it received a packet that says so.
 * - The next transaction, without a fault, succeeds.
 *
 * Each row (rows.h) decides which outcomes its fault may have. */
#ifndef CHECK_H
#define CHECK_H

#include <stdbool.h>
#include <stdint.h>

#include "oracle.h"
#include "rig.h"

/* Time that the program itself takes at 16 MHz. The deadline does not include it: the program
 * builds the packet before the deadline starts, and reads the ring before it reads the clock. */
#define CHECK_PROCESSING_US 130u
#define CHECK_BYTE_US       3u // to parse and copy a byte of data
#define CHECK_BYTE_TIED_US  8u // while bytes keep coming: on tied pins handlers take most cycles

/* Times that the bus allows for. */
#define CHECK_RETURN_DELAY_US 508u // default of the bus
#define CHECK_MARGIN_US       100u
#define CHECK_QUIET_US        20u // two byte times
/* A reply that begins up to this long after its packet is never taken for the reply to another
 * packet: after a missing reply, no packet with a reply is sent before this time is over. */
#define CHECK_STALE_REPLY_US 2000u
/* The bus gives up a request that cannot be sent after the duration of the longest reply. */
#define CHECK_QUIET_WAIT_US (56u * 10u + CHECK_RETURN_DELAY_US + CHECK_MARGIN_US)

#define OUTCOME(result) (1u << (result))
#define GOOD            OUTCOME(CDS_OK)
#define FAILED          (OUTCOME(CDS_TIMEOUT) | OUTCOME(CDS_CORRUPT))
#define RULE(rule)      (1u << (rule))

struct row;

/* One attempt: the bytes received from the start of a packet to the start of the next packet, as
 * struct oracle_span. Near the deadline it is uncertain how many bytes were in time. */
struct check_span {
    struct oracle_asked asked;
    bool has_packet; // false: bytes before the first packet of the injection
    struct oracle_byte bytes[RIG_ROOM];
    uint64_t times[RIG_ROOM];
    unsigned count;
    uint64_t echo_from, echo_until; // while the controller drives the line
    unsigned echoes;
    unsigned in_time_least, in_time_most;
    bool good;  // the attempt ended as CDS_OK
    int result; // enum cds_result of a failed attempt; -1: any failure
    uint8_t last_id;
    bool last_ok;
};

/* Expected counters: a lower or an upper bound of each. */
struct check_counters {
    unsigned malformed, noise_bytes, stale_replies, duplicate_replies, unexpected_packets;
};

struct check {
    struct rig *rig;
    const struct row *row;
    uint32_t part, parts, seed; // run part 1 to `parts` of the injections; `seed` divides them
    bool counting;              // true: count the injections, run none
    unsigned index, total;
    void (*on_progress)(const struct check *check);

    // results of the row
    unsigned injections, failures;
    unsigned undetected;    // values taken that no servo sent
    unsigned misunderstood; // servos that carried out a damaged packet
    unsigned lost;    // good packets without reply: a servo took them for bytes of another one
    uint64_t longest; // latest end of a call after its deadline, in cycles

    // the current injection
    char text[120];
    bool failed;
    // check_next() resets the following fields; a row may set them
    bool predicts_wrong_value; // the library must take a wrong value
    bool allows_wrong_value;   // it may: damage all over a reply can make the checksum right
    bool allows_wrong_command; // a servo may carry out a packet that was not sent
    bool powered_up;           // servo 0 loses its power after the transaction
    bool allows_overruns;      // a handler delays the receive handler
    bool skips_oracle;         // bytes overran or are not recorded: the oracle cannot predict
    bool allows_ring_overflow;
    uint64_t low_until;   // cycle up to which the row keeps the line in use
    int level;            // status return level that the bus knows of the servo
    uint8_t return_delay; // as in struct job
    uint8_t pause;        // pause before the next transaction, as in struct job
    int baud;             // register 0x04 of servo 0 if the fault has set it; else -1
    uint32_t rules;       // RULE() of each rule that may be broken
    uint32_t slack_us;    // additional time that the program may take
    uint8_t next_id;      // servo of the good transaction after the fault

    struct oracle_asked asked;        // packet of `job`
    struct job job;                   // the latest transaction
    struct job_outcome outcome;       // of `job`
    struct job_outcome latest;        // of the latest job of any kind
    struct cds_stats stats_before;    // at the start of the injection
    struct cds_stats last_stats;      // counted during `job`
    struct cds_stats injection_stats; // counted since the start of the injection, by check_settle()
    unsigned attempts;                // of `job`
    struct check_span span;           // the latest attempt
    struct check_counters least, most; // expected counters of the attempts before it
    uint8_t last_id;                   // servo that was asked last for a reply
    bool last_ok;                      // its reply was taken
    uint64_t corrupt_at;               // latest end of a transaction as CDS_CORRUPT
    // the bus rests after a failure; the rest ends between these times
    uint64_t rest_least, rest_most;
    unsigned bytes_assigned; // received bytes that belong to a span
    unsigned framing_errors; // of all received bytes
    unsigned echo_errors;
    struct servo *servos; // state of each servo before the injection
};

/* Prepares a rig that has just been opened. */
void check_open(struct check *check);
void check_close(struct check *check);

/* Begins the injection that `format` describes. Returns false if this run does not include it.
 * Returns true if the row must inject the fault and run the checks. */
bool check_next(struct check *check, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Runs the job. Checks only that it ends. */
void check_job(struct check *check, const struct job *job);

/* Runs the job and checks its transaction. */
void check_run(struct check *check, const struct job *job);
/* Runs a job that the library must refuse with `result`: nothing is sent. */
void check_refused(struct check *check, const struct job *job, enum cds_result result);
/* Assigns the bytes received so far to their span, then clears the record of the rig. */
void check_forget(struct check *check);
/* Waits until the line and the bus are quiet, updates `injection_stats` and `latest`, and checks
 * the counters. */
void check_settle(struct check *check);
/* The bytes of a whole reply may still arrive at the deadline: allows the time to handle them. */
void check_allow_late_bytes(struct check *check, const struct job *job);
/* Bytes arrive without end: allows the time to handle them, and ring overflows. */
void check_allow_babble(struct check *check);
/* Checks that the outcome is one of `outcomes`, a sum of OUTCOME(). */
void check_outcome(struct check *check, unsigned outcomes);
/* Removes the fault. Checks that the line becomes quiet, that the next transaction succeeds and
 * that the servos hold what was requested. Restores the servos. */
void check_after(struct check *check);
/* check_run(), check_outcome() and check_after(). */
void check_all(struct check *check, const struct job *job, unsigned outcomes);

/* Checks for a job of any kind: sent = ok + timeouts + corrupt. */
void check_sent_total(struct check *check);

void check_fail(struct check *check, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The packet that a job sends. */
void check_asked(const struct job *job, struct oracle_asked *asked);
/* The reply to a job without a fault; returns its size. */
unsigned check_reply(const struct check *check, const struct job *job, uint8_t *packet);
const char *check_name(const struct job *job);

#endif
