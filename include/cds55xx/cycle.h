/* The fixed-rate exchange of a whole robot: every period the goals of all servos go out in one SYNC
 * WRITE (manual 2.4.7), and what is left of the period is filled with feedback READs (2.4.2,
 * feedback.h), servo after servo. The servos renew their control loop every 4 ms (R29).
 *
 *     cds_cycle_begin(&cycle, &bus, ids, 18, packets, feedback, CDS_CYCLE_PERIOD_US);
 *     for (;;) {
 *         cds_bus_poll(&bus);
 *         cds_cycle_poll(&cycle);
 *         if (cycle.counters.periods has changed, or nothing was committed yet)
 *             cds_cycle_goal() for each servo that is to go elsewhere, then cds_cycle_commit();
 *     }
 *
 * A READ begins only if the bus is free and does not rest (cds_bus_rests()) and if the READ surely
 * ends before the next period, answered or not.
 * So the application's own requests go before READs, and urgent ones before all but the one in
 * flight; one that is not over when a period begins holds up its goals until it is. The true return
 * delay of the servos, told by cds_bus_set_return_delay(), makes room for more READs.
 *
 * Goals go out together or not at all: the application fills one packet while the other is sent.
 *
 * On a bus with a roster (servos.h) each goal is judged when it is set. A servo that is held later,
 * or whose limits are drawn closer than its goal, is dropped: its goal is sent no more, and those
 * of the others go on. cds_cycle_is_dropped() tells who is; the first goal for it that is taken
 * again, committed, takes it in. In the packet another servo's block stands twice meanwhile (R22).
 * What was taken once is not judged again while the roster does not change. When it does, the goals
 * of that period are up to 0.3 ms late if that concerns one servo, 0.8 ms if they waited behind the
 * very exchange that told it, 1.2 ms if more are concerned (50 servos, 16 MHz); none is missed.
 *
 * Of 50 servos at 250 Hz, 16 MHz, a roster takes 23 % of the CPU, and in each period 2 READs have
 * room, not 3: feedback is then 100 ms old at the most, not 68.
 *
 * All functions: main context.
 */
#ifndef CDS_CYCLE_H
#define CDS_CYCLE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/bus.h"      // struct cds_request
#include "cds55xx/feedback.h" // struct cds_feedback

#ifdef __cplusplus
extern "C" {
#endif

#define CDS_CYCLE_SERVOS_MAX 50   // 4 bytes to each in one packet (R23)
#define CDS_CYCLE_PERIOD_US  4000 // 250 Hz, the servos' own rate (R29)

/* Bytes of storage for the two packets of goals of `servos` servos, a constant: 1 to
 * CDS_CYCLE_SERVOS_MAX, or it does not compile. */
#define CDS_CYCLE_PACKETS_SIZE(servos)                                                             \
    (2u * CDS_SYNC_WRITE_SIZE(servos, 4) / ((servos) >= 1 && (servos) <= CDS_CYCLE_SERVOS_MAX))

/* Since cds_cycle_begin(); the application may put any of them back to 0. */
struct cds_cycle_counters {
    uint32_t periods; // whose goals were sent, or were to be
    uint32_t unsent;  // ... of them, those that the bus did not send: all servos were dropped, the
                      // line was not quiet, or it was too late when one was dropped in the queue
    uint32_t missed;  // whose goals were not, since polls came too late or others held the bus
    uint32_t reads;   // feedback READs that ended, well or not
    uint32_t failed;  // ... of them, those that brought no values
    uint32_t oldest_us; // longest time between two good replies of a servo
    uint16_t dropped;   // servos that were dropped, each time
};

/* All state of one cycle. Zero it (static storage is), then cds_cycle_begin(). */
struct cds_cycle {
    struct cds_bus *bus;
    const uint8_t *ids;            // the caller's
    struct cds_feedback *feedback; // the caller's, one for each of `ids`
    struct cds_request read;       // the feedback READ
    uint32_t next_us;              // when the next period begins
    uint8_t count;                 // servos
    uint8_t turn;                  // servo whose feedback is read next, or being read
    uint8_t *front, *back;         // the packet sent every period; and the one that is filled
    bool committed;                // there are goals to send
    bool filling;                  // the one in back holds all that the front one does, or newer
    bool refused;                  // goals were, at their turn: a servo was held while they waited
    bool reading;                  // a READ is on its way
    bool giving_way;               // no READ begins: somebody waits for his turn
    bool stopping;                 // cds_cycle_stop() was called
    uint16_t period_us;            // from one beginning to the next
    uint16_t goals_us;             // the goals on the wire
    uint16_t latest_us;            // goals that begin later than this would hold up the next ones
    uint32_t read_at_us;           // when the READ in flight was begun,
    uint16_t read_us;              // and how long it takes at the most
    struct cds_bus_observer *observer; // of the bus, when goals were judged last
    uint16_t epoch, filled_epoch; // its epoch, when all of the packet in front, or of the one in
                                  // back, was admitted
    bool holes, filled_holes;     // it has blocks of servos that were dropped
    struct cds_cycle_counters counters;
    uint32_t wire_us;                  // of `elapsed_us`, an exchange of the cycle was on the wire
    uint32_t elapsed_us;               // periods that are over
    struct cds_request goals;          // with the packet that was in front when they were sent
    uint8_t buffer[CDS_FEEDBACK_SIZE]; // of the READ
};

/* Starts a cycle for the `count` servos (1 to CDS_CYCLE_SERVOS_MAX) of `ids` (0 to 253) on an open
 * bus, a period every `period_us` microseconds from now on. `packets` is
 * CDS_CYCLE_PACKETS_SIZE(count) bytes, `feedback` one struct for each servo in the order of `ids`;
 * all of them stay in place until the cycle has stopped. No goal is sent before the first commit.
 * CDS_OK. CDS_BAD_ARGUMENT: no bus is open, count or an ID is out of range, or the goals do not fit
 * the period: they take (8 + 5 x count) byte times and CDS_REPLY_MARGIN_US. CDS_BUSY: this very
 * cycle is running and something of it is on its way; nothing was touched. */
enum cds_result cds_cycle_begin(struct cds_cycle *cycle, struct cds_bus *bus, const uint8_t *ids,
                                uint8_t count, uint8_t *packets, struct cds_feedback *feedback,
                                uint16_t period_us);

/* Sets the goal of servo `index` (0 to count - 1, of `ids`): position 0 to 1023 (0 to 300 degrees),
 * speed 0 to 1023 (62/1023 RPM each, 0: as fast as it can; R8, R10). It goes out with the next
 * commit; servos whose goal is not set anew keep theirs. CDS_OK. CDS_BAD_ARGUMENT: out of range,
 * nothing was set. CDS_BUSY: the goals before those committed last are still being sent; try again
 * when that is over, at most a period from now. CDS_LIMIT: beyond a soft limit; nothing was set,
 * and it keeps its goal. CDS_INHIBITED: the servo is held; nothing was set, and it is dropped by
 * the next poll, or from the beginning if it never had a goal. */
enum cds_result cds_cycle_goal(struct cds_cycle *cycle, uint8_t index, uint16_t position,
                               uint16_t speed);

/* All goals set since the last commit go out with the next period, and with each one after it until
 * the next commit. The first commit begins a period. CDS_OK, also if none was set.
 * CDS_BAD_ARGUMENT: some servo never had a goal and is not held; nothing was committed. */
enum cds_result cds_cycle_commit(struct cds_cycle *cycle);

/* Moves the cycle on; call it after cds_bus_poll() from the main loop, as often as possible: goals
 * go out when a poll finds that their period has begun. A period is missed when its goals would
 * hold up the next one's; the others stay where they were.
 * CDS_PENDING: it runs, or is stopping. CDS_OK: it has stopped, and its storage is the caller's. */
enum cds_result cds_cycle_poll(struct cds_cycle *cycle);

/* Stops it, also one that was never begun: nothing more is sent but what is on the wire already.
 * Poll until that is over. The servos stay at, or go on to, their last goals. */
void cds_cycle_stop(struct cds_cycle *cycle);

/* Is servo `index` (0 to count - 1, of `ids`) left out of the goals that are sent? True: it was
 * held, or its goal came to lie beyond a soft limit, and no goal for it was taken and committed
 * since. */
bool cds_cycle_is_dropped(const struct cds_cycle *cycle, uint8_t index);

/* Asks for the bus between READs, for an exchange of the caller's that lasts at most `us`
 * microseconds. True: submit it now, it ends before the next period. False, also while the bus
 * rests (cds_bus_rests()): ask again with each turn of the main loop; no READ begins until the next
 * period meanwhile, so that the turn comes. If `us` is above cds_cycle_room_us() it never does, and
 * READs go on. */
bool cds_cycle_gives_way(struct cds_cycle *cycle, uint16_t us);

/* The longest exchange, in microseconds, for which cds_cycle_gives_way() can ever be true; 0 if
 * there is none. */
uint16_t cds_cycle_room_us(const struct cds_cycle *cycle);

/* The age of the oldest feedback of all servos, in microseconds; CDS_FEEDBACK_NEVER if one was
 * never read. */
uint32_t cds_cycle_oldest_us(const struct cds_cycle *cycle);

/* Share of the time that an exchange of the cycle was on the wire, in thousandths, 0 to 1000: the
 * bytes sent and received, and of a READ that failed all the time it was waited for. Of the time
 * since begin, after 18 min more of the later. Divides 32-bit numbers: not for the hot path. */
uint16_t cds_cycle_utilisation_permille(const struct cds_cycle *cycle);

#ifdef __cplusplus
}
#endif

#endif
