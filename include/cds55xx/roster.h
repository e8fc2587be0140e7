/* The servos that a bus knows, each by its ID: how long it waits, what it answers, whether it is
 * there, what went wrong with it, and how far it may be driven. Learnt from all that passes on the
 * bus, whoever sends it, and applied to all that is sent, raw packets too. Manual: 3.1, registers
 * 0x05, 0x06 to 0x09, 0x10, 0x18, 0x1E to 0x21, 0x2C; 2.3 (error bits). Rulings R2, R3, R10, R16,
 * R17.
 *
 *     static struct cds_roster_servo servos[2] = {{.id = 1}, {.id = 2}};
 *     cds_roster_begin(&roster, &bus, servos, 2);
 *     cds_roster_set_limits(&roster, &servos[0], 200, 800, 512);
 *
 * What is refused is never sent: cds_bus_submit() and all that is built on it return
 *   CDS_NO_REPLY_DUE  a READ that the servo's status return level has it not answer
 *   CDS_LIMIT         a goal or speed beyond a soft limit of the servo
 *   CDS_HELD          torque on, a goal, a speed or ACTION for a servo that is held: it came back
 *                     without its state, was away, or was stopped. Torque off always passes
 *
 * A servo counts as away (CDS_PRESENCE_AWAY) after CDS_ROSTER_SILENCES exchanges without a reply in
 * a row. When it answers again it is CDS_PRESENCE_BACK, and held, until its TORQUE_ENABLE has been
 * read: watch.h does so by itself. If that is 0 where torque was on, it has lost its state
 * (CDS_HOLD_LOST), and stays held until cds_roster_release(). A servo that did not answer when it
 * was told something new about delay, level, mode or torque keeps what was known, until a READ of
 * that register says more.
 *
 * SYNC WRITE and broadcast count for every servo they reach: one of them held refuses the packet,
 * but not one that is away.
 * Main context.
 */
#ifndef CDS_ROSTER_H
#define CDS_ROSTER_H

#include <stdbool.h>
#include <stddef.h> // NULL
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus_observer

#ifdef __cplusplus
extern "C" {
#endif

/* Exchanges without a reply, one after the other, until a servo counts as away. */
#define CDS_ROSTER_SILENCES 3

/* In `return_delay`: not known; the bus's own is waited for. In `baud`: not known. */
#define CDS_ROSTER_UNKNOWN 255

/* Is the servo there? */
enum cds_presence {
    CDS_PRESENCE_UNKNOWN, // it was not asked yet
    CDS_PRESENCE_HERE,    // it answered, or missed no more than two exchanges since
    CDS_PRESENCE_AWAY,    // it does not answer
    CDS_PRESENCE_BACK,    // it answers again; what it remembers is not known yet
};

/* Why a servo is not driven: bits of `held`. */
enum cds_hold {
    CDS_HOLD_LOST = 1,    // its torque was on and is off: its RAM area is at the initial values
    CDS_HOLD_STOPPED = 2, // torque off for all was asked for: stop.h
};

/* What is known of one of the two angle limits, 0x06 and 0x08. */
enum cds_angle_limit {
    CDS_ANGLE_UNKNOWN,
    CDS_ANGLE_SET, // not 0: position mode, whatever the other one is
    CDS_ANGLE_0,   // both: endless turn
};

/* Of one servo; modulo 65536, since cds_roster_begin(). */
struct cds_roster_counters {
    uint16_t ok;          // exchanges that it answered
    uint16_t timeouts;    // ... that it did not
    uint16_t corrupt;     // ... of whose answer only damage came
    uint16_t late;        // its packets that came when it had been given up
    uint16_t extra;       // ... that came after its answer: two have its ID
    uint16_t foreign;     // ... that came when it was not asked, or of another length
    uint16_t echo_errors; // bytes said to it that came back changed
};

/* One servo. The caller sets `id`, 0 to 253; cds_roster_begin() the rest. Soft limits and what is
 * known beforehand may be set from then on; the rest is to be read. */
struct cds_roster_servo {
    struct cds_roster_counters counters;
    uint16_t lowest, highest;    // soft limits of its goal, 0 to 1023; 0 and 1023: none
    uint16_t fastest;            // soft limit of its speed, 0 to 1023, in both modes; 1023: none
    uint8_t id;                  // 0 to 253; follows a change of ID
    uint8_t maybe_id;            // ... that it may have instead, until it answers; 254: none
    uint8_t baud;                // register value of the rate it answers at, or CDS_ROSTER_UNKNOWN
    uint8_t return_delay;        // register 0x05, in 2 us, or CDS_ROSTER_UNKNOWN
    uint8_t status_return_level; // register 0x10; 2 until more is known
    uint8_t alarms;              // CDS_ERROR_* bits of all its packets, until acknowledged
    uint8_t presence;            // enum cds_presence
    uint8_t silences;            // exchanges in a row that it did not answer
    uint8_t held;                // CDS_HOLD_* bits
    uint8_t cw_limit, ccw_limit; // enum cds_angle_limit
    bool torque : 1;             // it has been switched on, as far as is known
    bool speed_known : 1;        // the speed it holds is within the limit
    bool speed_0 : 1;            // ... but may be 0
    bool goal_known : 1;         // the goal it holds is within the limits
    bool armed : 1;              // it has, or may have, a registered write
    bool armed_unjudged : 1;     // ... that was not judged by what holds now
    bool armed_torque : 1;       // ... of torque on
};

/* All of them. */
struct cds_roster {
    struct cds_bus_observer observer; // first: the bus knows this much
    struct cds_bus *bus;
    struct cds_roster_servo *servos;
    uint16_t echo_errors; // of the bus, when last looked at
    uint8_t count;        // of `servos`
    uint8_t last;         // the one found last: the next one asked for is often the next
    uint8_t alarms;       // of all servos, known or not, until acknowledged
    bool changed;         // what may be sent, while requests waited
    bool ambiguous;       // an ID may be that of more than one of them, or one may have another
    uint8_t refused_id;   // whom the last packet that was not admitted concerns, whosever it was
};

/* Watches `bus`, which must be open, for the `count` (0 to 254) servos `servos`, which stay in
 * place. CDS_OK; CDS_BAD_ARGUMENT: no bus is open, or an ID is above 253 or stands twice. */
enum cds_result cds_roster_begin(struct cds_roster *roster, struct cds_bus *bus,
                                 struct cds_roster_servo *servos, uint8_t count);

/* Takes servo `id`, 0 to 253, into the roster, whose array `servos` has place for `room` of them, 1
 * to 254; nothing is known of it yet. CDS_OK; CDS_BAD_ARGUMENT: the ID is above 253, or there
 * already; CDS_NO_ROOM: the array is full. */
enum cds_result cds_roster_add(struct cds_roster *roster, uint8_t id, uint8_t room);

/* Returns servo `id` (0 to 253) of the roster, or NULL. */
struct cds_roster_servo *cds_roster_find(struct cds_roster *roster, uint8_t id);

/* Sets the soft limits of `servo`, one of the roster: goals from `lowest` to `highest`, both 0 to
 * 1023 (0 to 300 degrees); speeds up to `fastest`, 0 to 1023 (62/1023 RPM each). With a limit of
 * speed, 0, which in position mode means as fast as it can, is refused there, and so is a goal for
 * a servo whose speed was not set before; with one of the goal, endless turn is. CDS_OK;
 * CDS_BAD_ARGUMENT: out of range, or lowest above highest; nothing was set. */
enum cds_result cds_roster_set_limits(struct cds_roster *roster, struct cds_roster_servo *servo,
                                      uint16_t lowest, uint16_t highest, uint16_t fastest);

/* May servo `id` (0 to 254) be driven? False: it is held, or back and not looked at yet; for 254,
 * one of them is. */
bool cds_roster_may_drive(struct cds_roster *roster, uint8_t id);

/* Takes note of the alarms of `servo`, one of the roster, or of all if it is NULL: returns the bits
 * that were latched, CDS_ERROR_*, and latches anew. */
uint8_t cds_roster_acknowledge(struct cds_roster *roster, struct cds_roster_servo *servo);

/* Holds `servo`, one of the roster, or all if it is NULL: not driven until released. Nothing is
 * sent. `why`: CDS_HOLD_* bits. */
void cds_roster_hold(struct cds_roster *roster, struct cds_roster_servo *servo, uint8_t why);

/* Lets `servo`, one of the roster, or all if it is NULL, be driven again. Nothing is sent and
 * nothing moves: torque is off, and the caller sets speed, goal and torque anew. One that is away
 * or back stays held by that. */
void cds_roster_release(struct cds_roster *roster, struct cds_roster_servo *servo);

#ifdef __cplusplus
}
#endif

#endif
