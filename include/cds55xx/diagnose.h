/* SPDX-License-Identifier: MIT */
/* Finds out why a servo does not answer: looks at the line, at the servo and at the servos around
 * it, and ends with one finding and what to do about it. It sends PING and READ only, and writes
 * nothing (manual 2.4.2, 2.4.5; registers: 3.1).
 *
 * The findings, in the order in which they are looked for, and their thresholds:
 * docs/diagnose.md. A diagnosis at 1 Mbps takes
 *   0.1 s and 20 transactions if the servo answers well,
 *   0.3 s and 31 if no servo answers,
 *   0.4 s and at most 300 with a search for other servos (2.2 s at 19200 bit/s); twice as many for
 *   CDS_BROADCAST_ID.
 * Two servos that agree in every bit and in time pass for one.
 *
 * The operation holds the bus from begin to end (cds_bus_lock()). What the permit knows of servos
 * is not used. Main context.
 */
#ifndef CDS_DIAGNOSE_H
#define CDS_DIAGNOSE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/steps.h" // struct cds_steps

#ifdef __cplusplus
extern "C" {
#endif

/* X(name, number, text, remedy) */
#define CDS_FINDINGS(X)                                                                            \
    X(CDS_FINDING_NONE, 0, "nothing found yet", "wait until the diagnosis has ended")              \
    X(CDS_FINDING_OK, 1, "one servo answers well, as far as the wire shows",                       \
      "nothing to do; count the servos: two may agree in every bit")                               \
    X(CDS_FINDING_LINE_LOW, 2, "the line is held low",                                             \
      "look for a short circuit, a turned plug, a driver without power")                           \
    X(CDS_FINDING_BABBLE, 3, "the line is never quiet",                                            \
      "unplug servos one by one until it is quiet: the last is at fault")                          \
    X(CDS_FINDING_ECHO, 4, "the line echoes, against the board file",                              \
      "check RX enable, or declare the echo there")                                                \
    X(CDS_FINDING_COLLISION, 5, "another device sends on this line",                               \
      "unplug the other controller or PC adapter")                                                 \
    X(CDS_FINDING_NOISE, 6, "noise on the line, or a loose plug",                                  \
      "check plugs, ground, cable length; keep off motor and mains cables")                        \
    X(CDS_FINDING_BYTES_LOST, 7, "this controller was too late for bytes",                         \
      "shorten interrupt handlers, or use ISR_NOBLOCK")                                            \
    X(CDS_FINDING_DUPLICATE_ID, 8, "two servos seem to have this ID",                              \
      "connect one alone and give it another ID")                                                  \
    X(CDS_FINDING_SILENCE, 9, "no servo answers at any listed rate",                               \
      "check power, plug, wiring; then 'scan rescue', or 'new' with this servo alone")             \
    X(CDS_FINDING_OTHER_RATE, 10, "the servo answers at another baud rate",                        \
      "'bus RATE', then 'baud ID RATE' to change it")                                              \
    X(CDS_FINDING_OTHER_ID, 11, "no servo has this ID, but others answer",                         \
      "check its plug and power; then its ID: 'scan'")                                             \
    X(CDS_FINDING_NO_REPLY_BY_LEVEL, 12, "the servo answers PING only",                            \
      "set STATUS_RETURN_LEVEL to 1 (READ) or 2 (all)")                                            \
    X(CDS_FINDING_SLOW, 13, "the servo answers later than the bus waits",                          \
      "'write ID RETURN_DELAY 2', or 'settings return_delay 254'; else replace it")                \
    X(CDS_FINDING_LOW_SUPPLY, 14, "the servo's supply is below MIN_VOLTAGE",                       \
      "charge the battery; check cables and plugs under load")                                     \
    X(CDS_FINDING_HIGH_SUPPLY, 15, "the servo's supply is above MAX_VOLTAGE",                      \
      "lower the supply: it harms the servo")                                                      \
    X(CDS_FINDING_OVERHEATED, 16, "the servo is hotter than MAX_TEMPERATURE",                      \
      "torque off, and take load away until it is cool")                                           \
    X(CDS_FINDING_OVERLOADED, 17, "the load exceeds the servo's torque",                           \
      "find what blocks the servo, or lessen the load")                                            \
    X(CDS_FINDING_REPLIES_TOO_EARLY, 18, "the servo answers before this controller listens",       \
      "write RETURN_DELAY 1 or more: the servo hears it; 0 is for tied pins")                      \
    X(CDS_FINDING_NO_TORQUE, 19, "MAX_TORQUE is 0: no torque",                                     \
      "'set ID MAX_TORQUE 100%', then power off and on")

/* CDS_FINDING_OK, ...: what each one means stands in the list. */
enum cds_finding {
#define CDS_FINDING_ENUM_(name, number, text, remedy) name = number,
    CDS_FINDINGS(CDS_FINDING_ENUM_)
#undef CDS_FINDING_ENUM_
} __attribute__((packed));

/* Capacities of the request. */
#define CDS_DIAGNOSE_PACKET_SIZE CDS_PACKET_SIZE(2)
#define CDS_DIAGNOSE_REPLY_SIZE  20

/* What to diagnose. Bus and request stay in place until the operation has ended. */
struct cds_diagnose_config {
    struct cds_bus *bus;         // at the rate and with the return delay that the servo should have
    struct cds_request *request; // capacities: CDS_DIAGNOSE_PACKET_SIZE, _REPLY_SIZE
    uint8_t id;                  // 0 to 253; CDS_BROADCAST_ID: the servo that is found first
};

/* How transactions ended. */
struct cds_diagnose_tally {
    uint8_t asked;    // transactions
    uint8_t answered; // of these: with a good reply
    uint8_t damaged;  // with damage, or with a reply that complains of a damaged packet
    uint8_t silent;   // with nothing heard
    uint8_t busy;     // not possible: the line was not quiet
    uint8_t echoed;   // of all: what was heard began with bytes of the packet
    uint8_t cut;      // of the damaged: whole but for the first bytes
};

/* One diagnosis: the caller reads the fields down to `varying`, and steps.result. */
struct cds_diagnose {
    uint8_t finding;        // enum cds_finding; stands when polling ends with CDS_OK
    uint8_t found_id;       // of the servo that was examined or found, or CDS_NO_ID
    uint8_t found_baud_reg; // rate at which it answered
    uint8_t error;          // CDS_ERROR_* bits of its last reply to a READ
    uint16_t value;        // SLOW: return delay in us, 0 if it is not known; LOW_, HIGH_SUPPLY: mV;
                           // OVERHEATED: degrees Celsius
    uint16_t transactions; // progress: PINGs and READs that are over

    // Evidence: what the stats of the bus counted, and the tallies of transactions
    uint16_t unrequested_bytes;        // damaged ones included, while the line was listened to
    uint16_t duplicate_replies;        // of servo found_id
    uint16_t stale_replies;            // of servo found_id
    uint16_t unexpected_packets;       // of other stations
    uint16_t echo_errors;              // own bytes that came back changed
    uint16_t overruns;                 // bytes that this controller lost
    struct cds_diagnose_tally total;   // all with the servo examined; of these:
    struct cds_diagnose_tally probe;   // PING
    struct cds_diagnose_tally same;    // READ of the ID: equal in two servos with one ID
    struct cds_diagnose_tally varying; // READ of registers in which they differ

    // the caller may set it before the first poll:
    uint8_t known_baud_reg; // rate at which the servo answered last: it is tried before the listed
                            // ones; at first the bus's own, which is not tried again
    // internal:
    struct cds_diagnose_tally series;
    uint8_t phase, purpose, target, candidate, seek_id;
    uint8_t baud_reg, rates_left;
    uint8_t position; // of the ring, before the reply to the packet in flight
    uint8_t voltage, temperature;
    uint16_t wait_us; // for the servo, of requests other than the diagnosis
    bool has_limits, hears_crowd, has_looked_again;
    uint8_t limits[CDS_DIAGNOSE_REPLY_SIZE];
    uint32_t since_us, pause_us;
    struct cds_stats base;
    // to be read:
    struct cds_steps steps; // steps.result: enum cds_result of the whole
};

/* Prepares a diagnosis and locks the bus; nothing is sent before the first poll. CDS_OK;
 * CDS_BAD_ARGUMENT: the bus is not open, or `id` is 0xFF; CDS_NO_ROOM: a buffer of the request is
 * too small; CDS_BUSY: the request is on its way, or an operation holds the bus. Unless it is
 * CDS_OK, nothing was changed. */
enum cds_result cds_diagnose_begin(struct cds_diagnose *diagnose,
                                   const struct cds_diagnose_config *config);

/* Moves on by at most one transaction; call it and cds_bus_poll() from the main loop, at least
 * every millisecond, or unrequested bytes are lost. At the end the bus has its own rate and return
 * delay back.
 *   CDS_PENDING    under way
 *   CDS_OK         diagnose->finding says what was found
 *   CDS_CANCELLED  aborted, its request was cancelled, or the bus was opened again (and is left as
 *                  it is) */
enum cds_result cds_diagnose_poll(struct cds_diagnose *diagnose);

/* Sends nothing more. Poll until the transaction in flight is over: the result is CDS_CANCELLED. */
void cds_diagnose_abort(struct cds_diagnose *diagnose);

#ifdef __cplusplus
}
#endif

#endif
