/* SPDX-License-Identifier: MIT */
/* Goals and feedback of a whole robot at a fixed rate: in each period the goals of all servos leave
 * in one SYNC WRITE (manual 2.4.7), and READs of feedback (feedback.h) fill what remains, servo
 * after servo.
 *
 *     cds_queue_attach(&queue, &bus);
 *     cds_cycle_begin(&cycle, &config);
 *     for (;;) {
 *         cds_bus_poll(&bus);
 *         cds_cycle_poll(&cycle);
 *         if (cycle.counters.periods has changed, or no goals were committed yet)
 *             cds_cycle_goal() for each servo that moves, then cds_cycle_commit();
 *     }
 *
 * A READ begins only if it surely ends before the next period. While the line is in use and another
 * request waits for it, no goals are submitted: that request ends first. All functions: main
 * context. */
#ifndef CDS_CYCLE_H
#define CDS_CYCLE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"      // struct cds_request
#include "cds55xx/feedback.h" // struct cds_feedback

#ifdef __cplusplus
extern "C" {
#endif

#define CDS_CYCLE_SERVOS_MAX 50   // goals that fit one packet (R23)
#define CDS_CYCLE_PERIOD_US  4000 // 250 Hz, the rate of the servos' control loop (R29)

/* Bytes of the two packets with the goals of `servos` servos, a constant. Does not compile if it is
 * not 1 to CDS_CYCLE_SERVOS_MAX. */
#define CDS_CYCLE_PACKETS_SIZE(servos)                                                             \
    (2u * CDS_SYNC_WRITE_SIZE(servos, 4) / ((servos) >= 1 && (servos) <= CDS_CYCLE_SERVOS_MAX))

/* What a cycle works on. It is copied; what the pointers point to stays in place until the cycle
 * has stopped. */
struct cds_cycle_config {
    struct cds_bus *bus;           // open; with a queue if other requests are sent beside the cycle
    const uint8_t *ids;            // the servos, each 0 to 253
    uint8_t *packets;              // CDS_CYCLE_PACKETS_SIZE(count) bytes
    struct cds_feedback *feedback; // one for each servo, in the order of `ids`
    uint8_t count;                 // servos, 1 to CDS_CYCLE_SERVOS_MAX
    uint16_t period_us;            // from the beginning of one period to the next
};

/* Since cds_cycle_begin(). The application may set each of them to 0. */
struct cds_cycle_counters {
    uint32_t periods;   // periods whose goals were sent, or counted as unsent
    uint32_t unsent;    // periods whose goals the bus did not send: all servos were left out, the
                        // line was not quiet, or the goals were refused too late in the period
    uint32_t missed;    // periods that passed because polls came too late or the bus was in use
    uint32_t reads;     // READs of feedback that ended, well or not
    uint32_t failed;    // READs that brought no values
    uint32_t oldest_us; // longest time between two good replies of one servo
    uint16_t dropped;   // times a servo was left out of the goals
};

/* All state of one cycle. Zero it (static storage is), then cds_cycle_begin(). The application
 * reads `counters`. */
struct cds_cycle {
    // internal:
    struct cds_bus *bus;
    const uint8_t *ids;            // of the servos
    struct cds_feedback *feedback; // one for each servo
    uint8_t *front;                // packet that is sent every period
    uint8_t *back;                 // packet that is filled
    uint8_t count;                 // servos
    uint8_t filled;                // blocks of `back` before this one are set or marked as not set
    uint8_t skipped;               // blocks of `back` that are marked as not set
    uint8_t sum;                   // bytes of `back` from the ID on, with all goals that are set
    uint8_t empty_sum;             // the sum when no goal is set
    uint8_t index_offset;          // hint: index of a servo for the permit, less its index in `ids`
    uint8_t checked;               // servos before this one were checked since the permit changed
    uint8_t changed_id;            // servo the change concerns, or CDS_BROADCAST_ID
    uint8_t mended;        // blocks that were looked at since a servo was left out of `front`
    uint8_t turn;          // servo whose feedback is read, or is read next
    bool has_permit : 1;   // goals are checked when they are set
    bool is_checking : 1;  // goals are checked again, or blocks written, before the next ones leave
    bool has_left_out : 1; // a goal set in `back` was refused later
    bool has_other_ids : 1; // a block of the packet has the ID of another servo, because its own
                            // servo has no goal
    bool is_committed : 1;  // there are goals to send
    bool sends_again : 1;   // the goals came back from the bus: after a check they are sent again
    bool is_reading : 1;    // a READ is in flight or waits
    bool is_yielding : 1;   // no READ begins: another request waits for its turn
    bool is_aborted : 1;    // cds_cycle_abort() was called
    uint8_t begun : 5;      // counts cds_cycle_begin(), and tells one run from the next
    uint16_t epoch;         // of the permit, when its changes were asked for; 0: never
    uint16_t period_us;     // from the beginning of one period to the next
    uint16_t goals_us;      // time of the goals on the wire
    uint16_t latest_us;     // goals that begin later in a period would hold up the next ones
    uint16_t read_bytes_us; // time of packet and reply of a READ on the wire
    uint32_t read_until_us; // when the READ in flight ends at the latest
    uint32_t next_us;       // when the next period begins
    uint32_t wire_us;       // part of `elapsed_us` with a transaction of the cycle on the wire
    uint32_t elapsed_us;    // periods that are over
    // to be read:
    struct cds_cycle_counters counters; // since cds_cycle_begin()
    // internal:
    struct cds_request goals;
    struct cds_request read;
    uint8_t read_packet[CDS_PACKET_SIZE(2)];
    uint8_t reply[CDS_FEEDBACK_SIZE]; // to the READ
};

/* Starts a cycle. READs begin; no goal is sent before the first commit, from which the periods of
 * goals count.
 * CDS_OK. CDS_BAD_ARGUMENT: the bus is not open, count or an ID is out of range, or the goals do
 * not fit the period: they take (8 + 5 x count) byte times and CDS_REPLY_MARGIN_US. CDS_BUSY: this
 * very cycle runs and has a request on its way; nothing was changed. */
enum cds_result cds_cycle_begin(struct cds_cycle *cycle, const struct cds_cycle_config *config);

/* Sets the goal of servo `index` (0 to count - 1, in the order of `ids`): position 0 to 1023 (0 to
 * 300 degrees), speed 0 to 1023 (62/1023 RPM each, 0: as fast as it can; R8, R10). The goal is sent
 * from the period after the next commit on. Servos whose goal is not set keep theirs. Setting them
 * in the order of `ids` costs least.
 *
 *   CDS_OK
 *   CDS_BAD_ARGUMENT  out of range; nothing was set
 *   CDS_BUSY          the goals of the commit before the last one are still being sent; try again
 *                     within a period
 *   CDS_LIMIT         the permit of the bus (servos.h) refuses the goal; the servo keeps its goal
 *   CDS_INHIBITED     the servo may not be driven; the next polls leave it out
 *
 * A servo whose first goal is refused, or was not set before the first commit, is left out until a
 * goal is set and committed. */
enum cds_result cds_cycle_goal(struct cds_cycle *cycle, uint8_t index, uint16_t position,
                               uint16_t speed);

/* In place of a position: the servo is sent no goal. */
#define CDS_CYCLE_NO_GOAL UINT16_MAX

/* Returns the position, 0 to 1023, that is sent to servo `index` (0 to count - 1) in each period.
 * CDS_CYCLE_NO_GOAL: nothing was committed yet, or the servo is left out. */
uint16_t cds_cycle_sent_goal(const struct cds_cycle *cycle, uint8_t index);

/* All goals set since the last commit are sent together in the next period, and in each one after
 * it until the next commit. If all goals were set, two pointers change places; else the goals that
 * were not set are copied. A servo that never had a goal is sent none. Does nothing if no goal was
 * set. */
void cds_cycle_commit(struct cds_cycle *cycle);

/* Moves the cycle on; call it after cds_bus_poll() from the main loop, as often as possible. A
 * period is missed if its goals would hold up those of the next one; the phase of the periods
 * stays. When the permit of the bus has changed, the goals it concerns are checked again, at most 8
 * in one poll, and no goals are sent meanwhile. A servo whose goal is refused is left out; the
 * others go on. CDS_PENDING: the cycle runs, or ends. CDS_OK: it has ended; its storage is free. */
enum cds_result cds_cycle_poll(struct cds_cycle *cycle);

/* Ends the cycle, also one that was never begun: no further packet leaves. Poll until a packet in
 * flight has ended. The servos go on to their last goals. */
void cds_cycle_abort(struct cds_cycle *cycle);

/* True if servo `index` (0 to count - 1) is left out of the goals that are sent: its goal was
 * refused or never set, and no goal was set and committed since. In the packet the goal of another
 * servo stands twice meanwhile (R22). */
bool cds_cycle_is_dropped(const struct cds_cycle *cycle, uint8_t index);

/* Asks for the bus between READs, for a transaction of at most `us` microseconds. True: submit it
 * now; it ends before the next period. False, also while the bus rests (cds_bus_is_resting()): ask
 * again with each turn of the main loop; until the next period no READ begins. Ask for no more than
 * cds_cycle_spare_us(). */
bool cds_cycle_yields(struct cds_cycle *cycle, uint16_t us);

/* The longest transaction that fits between the goals and the next period, in microseconds; 0:
 * none. */
uint16_t cds_cycle_spare_us(const struct cds_cycle *cycle);

/* Age of the oldest feedback of all servos, in microseconds; CDS_FEEDBACK_NEVER if a servo was
 * never read. */
uint32_t cds_cycle_oldest_us(const struct cds_cycle *cycle);

/* Share of the time with a transaction of the cycle on the wire, 0 to 1000 thousandths: bytes sent
 * and received, and the whole wait of a READ that failed. Counted since begin; after 18 min the
 * later time counts more. */
uint16_t cds_cycle_utilisation_permille(const struct cds_cycle *cycle);

#ifdef __cplusplus
}
#endif

#endif
