/* SPDX-License-Identifier: MIT */
/* What is known of each servo of a bus, and the permit, which decides which packets may leave.
 * Everything is learnt from the packets that pass. Rules of the permit: docs/internals/permit.md.
 *
 *     static struct cds_servo_state states[3] = {{.id = 1}, {.id = 2}};
 *     static struct cds_queue queue;
 *     static struct cds_servos servos;
 *     cds_servos_begin(&servos, &(struct cds_servos_config){
 *         .bus = &bus, .queue = &queue, .states = states, .count = 2, .capacity = 3});
 *     cds_servos_set_limits(&servos, &states[0], 200, 800, 512);
 *
 * cds_bus_submit() then also returns CDS_LIMIT, CDS_INHIBITED, CDS_TOO_EARLY, CDS_RESERVED or
 * CDS_NO_REPLY_DUE: the packet is not sent. Main context.
 */
#ifndef CDS_SERVOS_H
#define CDS_SERVOS_H

#include <stdbool.h>
#include <stddef.h> // NULL
#include <stdint.h>

#include "cds55xx/bus.h"   // struct cds_bus_hooks
#include "cds55xx/queue.h" // struct cds_queue

#ifdef __cplusplus
extern "C" {
#endif

/* Transactions in a row without a reply until a servo counts as OFFLINE. A damaged reply counts as
 * none only after a READ of TORQUE_ENABLE, which the state check sends (health.h). */
#define CDS_SERVOS_MISSES 3

/* In `return_delay` and `baud_reg`: not known. */
#define CDS_SERVOS_UNKNOWN 255

/* In `status_return_level`: not known. Replies are expected as at level 2. */
#define CDS_LEVEL_UNKNOWN 3

/* Whether a servo answers. */
enum cds_presence {
    CDS_PRESENCE_UNKNOWN,  // the servo was not asked yet
    CDS_PRESENCE_ONLINE,   // it answers, and missed no more than two transactions in a row
    CDS_PRESENCE_OFFLINE,  // it missed CDS_SERVOS_MISSES transactions in a row
    CDS_PRESENCE_RETURNED, // it was OFFLINE and answers again; its TORQUE_ENABLE was not read yet
} __attribute__((packed));

/* Why a servo must not be driven: bits. */
enum cds_inhibit {
    CDS_INHIBIT_STATE_LOST = 1, // its torque was on and is off: its RAM area is at initial values;
                                // or it answered no READ, so nobody knows (health.h)
    CDS_INHIBIT_STOPPED = 2,    // the caller has inhibited it
} __attribute__((packed));

/* Which mode, goal and speed the servo holds in its registers, as far as is known: bits. Two bits
 * for each angle limit; none set: the limit is not known. */
enum cds_held {
    CDS_HELD_CW_SET = 0x01,    // the limit 0x06 is not 0: position mode, whatever 0x08 is
    CDS_HELD_CW_0 = 0x02,      // the limit 0x06 is 0; if 0x08 is 0, too: endless turn
    CDS_HELD_CCW_SET = 0x04,   // the limit 0x08 is not 0: position mode, whatever 0x06 is
    CDS_HELD_CCW_0 = 0x08,     // the limit 0x08 is 0; if 0x06 is 0, too: endless turn
    CDS_HELD_GOAL = 0x10,      // the goal was read and is within the limits
    CDS_HELD_SPEED = 0x20,     // the speed was read and is within the limit
    CDS_HELD_SPEED_0 = 0x40,   // the speed may be 0
    CDS_HELD_LOSS_TOLD = 0x80, // set by the caller that has told the loss of state; ends with the
                               // next loss
} __attribute__((packed));

/* When the list grows by a servo that is not in it, up to the capacity. */
enum cds_servos_growth {
    CDS_GROWS_NEVER,
    CDS_GROWS_ON_ALARM_OR_SETTING, // the servo reports error bits, or registers 0x00 to 0x10 of it
                                   // are written
    CDS_GROWS_ALWAYS,              // also when it answers, sends a packet or is written to
} __attribute__((packed));

/* Counts of one servo since it is in the list. The first three are modulo 65536, the others stay at
 * 255. */
struct cds_servo_counters {
    uint16_t ok;                // transactions that it answered
    uint16_t timeouts;          // transactions without a good reply, and without damage
    uint16_t corrupt;           // transactions without a good reply, but with damage
    uint8_t stale_replies;      // its packets that came after their deadline
    uint8_t duplicate_replies;  // its packets that came after its reply: two servos share its ID
    uint8_t unexpected_packets; // its packets that no request asked for, or of another length
    uint8_t echo_errors;        // bytes sent to it that came back changed
};

/* One servo. The caller sets `id`; cds_servos_begin() sets all other fields. The caller may then
 * set what it knows beforehand: return_delay, status_return_level, baud_reg. */
struct cds_servo_state {
    struct cds_servo_counters counters; // of its transactions and packets
    uint16_t lowest, highest;           // soft limits of its goal, 0 to 1023; 0 and 1023: none
    uint16_t fastest;                   // soft limit of its speed, 0 to 1023; 1023: none
    uint8_t id;                         // 0 to 253; follows a change of ID
    uint8_t second;       // index of the entry with the other ID the servo may have, or
                          // CDS_NO_ID: its ID is certain
    uint8_t baud_reg;     // register value of the rate it answers at, or CDS_SERVOS_UNKNOWN; at
                          // first that of the bus
    uint8_t return_delay; // register 0x05 in 2 us, or CDS_SERVOS_UNKNOWN
    uint8_t alarms;       // CDS_ERROR_* bits of all its packets, until acknowledged
    uint8_t presence : 2; // enum cds_presence
    uint8_t inhibits : 2; // CDS_INHIBIT_* bits of this servo: cds_servos_inhibits()
    uint8_t misses : 2;   // transactions in a row without its reply, up to 3
    uint8_t status_return_level : 2; // register 0x10, or CDS_LEVEL_UNKNOWN; at first 2
    uint8_t held;                    // mode, goal and speed in its registers: CDS_HELD_* bits
    bool has_limits : 1;             // a soft limit of its goal or of its speed is set
    bool torque : 1;                 // torque is on, as far as is known
    bool has_answered : 1;           // it answered a READ since its ID became uncertain
    bool is_registered : 1;          // it has answered the REG WRITE of the registered move
    bool registered_torque : 1;      // it may have a registered write that switches torque on
    uint8_t torque_off : 3;          // enum cds_torque_off_outcome: torque_off.h
};

/* True if the servo is known to be in endless turn. */
static inline bool cds_servo_is_endless(const struct cds_servo_state *servo)
{
    return (uint8_t)(~servo->held & (CDS_HELD_CW_0 | CDS_HELD_CCW_0)) == 0;
}

/* Where cds_servos_begin() finds what it works with. */
struct cds_servos_config {
    struct cds_bus *bus;            // open
    struct cds_queue *queue;        // its requests wait and are retried; NULL: no queue
    struct cds_servo_state *states; // `capacity` entries, the first `count` with their IDs
    uint8_t count;                  // 0 to 254
    uint8_t capacity;               // `count` to 254
    uint8_t grows;                  // enum cds_servos_growth
    uint8_t shortest_delay;         // the smallest value of register 0x05 the board can bear; it
                                    // stays until the next cds_servos_begin()
};

/* All servos of a bus. Zero it (static storage is), then cds_servos_begin(). */
struct cds_servos {
    // internal:
    struct cds_bus_hooks hooks;
    // to be read:
    struct cds_bus *bus;            // whose servos these are
    struct cds_queue *queue;        // or NULL
    struct cds_servo_state *states; // entry 0 to `count` - 1
    uint8_t count;                  // of entries
    uint8_t capacity;               // the most entries there may be
    // the caller may set these two at any time:
    uint8_t grows;  // enum cds_servos_growth
    bool is_paused; // nothing is learnt from replies and their absence, and delays and
                    // levels are not used: for an operation that tries other rates
    // to be read:
    uint8_t shortest_delay; // a smaller value of register 0x05 is not written: CDS_TOO_EARLY
    bool may_reset_all;     // a RESET of all servos may be sent: cds_servos_allow_reset()
    bool all_inhibited;     // every packet that can drive any servo is refused
    uint8_t reserved_count; // servos that are reserved: cds_servos_reserve()
    bool is_full;           // a servo was met for which the list has no room
    uint8_t alarms;         // of all servos, known or not, until acknowledged
    uint8_t event_count;    // counts changes of error bits or presence, modulo 256
    uint8_t refused_id;     // of the servo for which the last refused packet was refused
    uint16_t too_early;     // packets refused as CDS_TOO_EARLY, modulo 65536
    uint16_t epoch;         // counts changes of what the permit's answers use; never 0
    // internal:
    uint16_t inhibit_epoch; // `epoch` when driving was inhibited last
    uint16_t echo_errors;   // of the bus, when the last transaction ended
    uint8_t changed_id;     // the servo of the last change, or CDS_BROADCAST_ID
    bool move_is_valid;     // no limit and no inhibit has changed since the move began
    bool move_is_answered;  // every REG WRITE of the move was answered
    uint8_t walked;         // blocks or entries that the walk of `walk_request` has reached
    uint8_t walk_index;     // entry that is tried first for the next block
    uint16_t walk_epoch;    // while the walk checks: its `epoch`; 0: the packet was sent, and the
                            // walk learns from it
    const struct cds_request *walk_request; // the request that the walk checks or learns from: some
                                            // of its servos in each call
    const struct cds_request *move_request; // of the registered move under way, or NULL
    const struct cds_request *reserved_for; // cds_servos_reserve()
    const uint8_t *reserved_ids;            // `reserved_count` of them
};

/* Attaches to config->bus, and to config->queue if there is one, and begins with `count` servos of
 * which nothing is known. The bus, the queue, the states and `servos` stay in place. Driving is not
 * inhibited, and the queue's retries are 0. Do not attach the queue by cds_queue_attach() before.
 * Entries 0 to `count` - 1 stay where they are; an entry that was added may move: find it by its
 * ID. CDS_OK; CDS_BUSY: other hooks are attached to the bus, or a request is in flight;
 * CDS_BAD_ARGUMENT: the bus is not open, or `count` is above `capacity`: nothing was changed; or an
 * ID is above 253 or stands twice: no servo is known then. */
enum cds_result cds_servos_begin(struct cds_servos *servos, const struct cds_servos_config *config);

/* Removes all servos from the list. The inhibit, shortest_delay and grows stay. */
void cds_servos_forget(struct cds_servos *servos);

/* Forgets the servos from index `count` on: those that joined last. As cds_servos_forget(). */
void cds_servos_forget_from(struct cds_servos *servos, uint8_t count);

/* Forgets `servo`, an entry; the last entry moves to its place. An unknown servo may be driven:
 * only for a servo that is gone. CDS_OK; CDS_BUSY: the bus or its queue has a request;
 * CDS_BAD_ARGUMENT: the ID of the servo is in doubt. Otherwise nothing was done. */
enum cds_result cds_servos_forget_one(struct cds_servos *servos, struct cds_servo_state *servo);

/* Adds servo `id`, 0 to 253; nothing is known of it yet. CDS_OK; CDS_BAD_ARGUMENT: the ID is above
 * 253, or in the list already; CDS_NO_ROOM: the list is full, and is_full says so from now on. */
enum cds_result cds_servos_add(struct cds_servos *servos, uint8_t id);

/* Returns the entry of servo `id`, 0 to 253, or NULL. */
struct cds_servo_state *cds_servos_find(struct cds_servos *servos, uint8_t id);

/* Sets the soft limits of `servo`, an entry: goals from `lowest` to `highest` (0 to 1023: 0 to 300
 * degrees), speeds up to `fastest` (0 to 1023, in 62/1023 RPM). Nothing is sent.
 *
 * Torque on is refused (CDS_LIMIT) until a servo with limits was read: 0x06, 4 bytes (mode), and
 * 0x1E, 4 bytes (goal and speed, within the limits). cds_robot_start() (robot.h) does so. After
 * a limit was narrowed, 0x1E must be read again. Each call ends the permission of a registered move
 * under way: its further REG WRITE and ACTION are refused.
 *
 * CDS_OK; CDS_BAD_ARGUMENT: out of range, or `lowest` above `highest`; nothing was set. */
enum cds_result cds_servos_set_limits(struct cds_servos *servos, struct cds_servo_state *servo,
                                      uint16_t lowest, uint16_t highest, uint16_t fastest);

/* True if servo `id`, 0 to 253, may be driven: driving is not inhibited, and the servo is neither
 * inhibited nor OFFLINE nor RETURNED; an unknown servo may. For CDS_BROADCAST_ID: true if no known
 * servo is inhibited or RETURNED; one that is OFFLINE does not count. */
bool cds_servos_may_drive(struct cds_servos *servos, uint8_t id);

/* Clears the alarms of `servo`, an entry, or of all if it is NULL. Returns the CDS_ERROR_* bits
 * that were latched. */
uint8_t cds_servos_acknowledge(struct cds_servos *servos, struct cds_servo_state *servo);

/* Inhibits driving: no packet that can drive a servo leaves from now on, whether its servo is known
 * or not. Takes the same time for any number of servos. Nothing is sent. */
void cds_servos_inhibit_all(struct cds_servos *servos);

/* Inhibits `servo`, an entry, for `why` (CDS_INHIBIT_* bits). Nothing is sent. */
void cds_servos_inhibit(struct cds_servos *servos, struct cds_servo_state *servo, uint8_t why);

/* Returns the CDS_INHIBIT_* bits that apply to `servo`: its own, and CDS_INHIBIT_STOPPED while
 * driving is inhibited for all. */
static inline uint8_t cds_servos_inhibits(const struct cds_servos *servos,
                                          const struct cds_servo_state *servo)
{
    return (uint8_t)(servo->inhibits | (servos->all_inhibited ? CDS_INHIBIT_STOPPED : 0));
}

/* Three calls end inhibits:
 *
 *                                   inhibit of     INHIBIT_STOPPED   INHIBIT_STATE_LOST
 *                                   all servos     of a servo        of a servo
 *   cds_servos_allow()              ends           ends, each servo  stays
 *   cds_servos_release(.., servo)   stays          ends, this servo  ends, this servo
 *   cds_servos_release_all()        ends           ends, each servo  ends, each servo
 *
 * They send nothing. A packet that was refused stays refused. A RETURNED servo stays inhibited
 * until its TORQUE_ENABLE was read. INHIBIT_STATE_LOST of a servo that was taken to answer no READ
 * also ends by itself: a READ shows that its torque is on. */

/* Ends both inhibits of `servo`, an entry. Torque may be on or off: the caller sets speed, goal and
 * torque again. */
void cds_servos_release(struct cds_servos *servos, struct cds_servo_state *servo);

/* Ends the inhibit of all servos and both inhibits of each servo. */
void cds_servos_release_all(struct cds_servos *servos);

/* Ends a stop: the inhibit of all servos and CDS_INHIBIT_STOPPED of each servo. The caller releases
 * a servo with CDS_INHIBIT_STATE_LOST when its state is set again. */
void cds_servos_allow(struct cds_servos *servos);

/* For the operation that resets all servos on purpose. If `is_allowed`, a RESET by broadcast may be
 * sent although servos are known. When it is sent, every known servo becomes unknown and is
 * inhibited as CDS_INHIBIT_STATE_LOST; it keeps its entry, ID and limits. */
void cds_servos_allow_reset(struct cds_servos *servos, bool is_allowed);

/* Reserves the servos with the `count` IDs `ids` for `request`, as the goals of a cycle. Refused as
 * CDS_RESERVED is each other packet that would set goal, speed, angle limit, ID, baud rate, return
 * delay or status return level of one of them, each other SYNC WRITE of these registers to whatever
 * servos, and each other ACTION or RESET that reaches one. `count` 0: none is reserved any more.
 * `ids` stays in place until then. */
void cds_servos_reserve(struct cds_servos *servos, const struct cds_request *request,
                        const uint8_t *ids, uint8_t count);

#ifdef __cplusplus
}
#endif

#endif
