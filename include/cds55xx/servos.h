/* The servos that a bus knows, each by its ID: how long it waits, what it answers, whether it is
 * there, what went wrong with it, and how far it may be driven. Learnt from all that passes on the
 * bus, whoever sends it, and applied to all that is sent, raw packets too. Manual: 3.1, registers
 * 0x05, 0x06 to 0x09, 0x10, 0x18, 0x1E to 0x21, 0x2C; 2.3 (error bits). Rulings R2, R3, R10, R16,
 * R17.
 *
 *     static struct cds_servo_state servos[2] = {{.id = 1}, {.id = 2}};
 *     cds_servos_begin(&roster, &bus, servos, 2);
 *     cds_servos_set_limits(&roster, &servos[0], 200, 800, 512);
 *
 * What is refused is never sent: cds_bus_submit() and all that is built on it return
 *   CDS_NO_REPLY_DUE  a READ that the servo's status return level has it not answer
 *   CDS_LIMIT         what would, or may, take the servo beyond a soft limit: see below
 *   CDS_INHIBITED          torque on, a goal, a speed, an angle limit (mode) or ACTION for a servo
 * that is held: it came back without its state, was away and was not looked at yet, or was stopped.
 * A packet to one servo that is away is refused too, except ACTION. Torque off always passes
 *   CDS_TOO_EARLY     a return delay below `shortest_delay`, to any servo
 *
 * While driving is inhibited (cds_servos_hold() of all), CDS_INHIBITED refuses every packet that
 * can drive a servo, whether the roster knows the servo or not: also RESET, ACTION, REG WRITE of
 * these registers, and every instruction that the manual does not know. PING, READ and other writes
 * pass.
 *
 * A servo counts as away (CDS_PRESENCE_OFFLINE) after CDS_SERVOS_SILENCES exchanges without a reply
 * in a row, at the rate at which it was met or last answered: what a scan does at others counts for
 * nothing. When it answers again it is CDS_PRESENCE_RETURNED, and held, until its TORQUE_ENABLE has
 * been read: health.h does so by itself. If that is 0 where torque was on, it has lost its state
 * (CDS_INHIBIT_STATE_LOST), and stays held until cds_servos_release(). Of a write that was not
 * answered, of delay, level or torque, the more careful of both values counts, until a READ says
 * more.
 *
 * SYNC WRITE and broadcast count for every servo they reach: one of them held refuses the packet,
 * but not one that is away. What waits in the queue is judged again at its turn, by what was learnt
 * meanwhile.
 *
 * With soft limits it counts what the servo holds already, as it may go on with that. That must be
 * known: from a READ, or from a WRITE that was answered; SYNC WRITE, broadcast, and what a status
 * return level below 2 leaves unanswered make nothing known. CDS_LIMIT refuses,
 *   with a limit of the goal:  a goal beyond it; a speed but 0, unless position mode is known (READ
 *                              0x06 to 0x09, or one of the two words that is not 0); endless turn;
 *                              torque on, unless the servo holds a goal within it in position mode;
 *                              a change to position mode without such a goal
 *   with a limit of the speed: a speed beyond it; 0, which in position mode means as fast as it
 *                              can, unless endless turn is known; torque on, a goal alone, and
 *                              another mode, unless the servo holds a speed within it, but 0 only
 *                              for endless turn
 *   with either:               half a word; ACTION for a servo whose registered write was judged by
 *                              other limits or in another mode, or is not known
 * So first the mode, then the limits, then goal and speed to each by a WRITE, then torque.
 *
 * CDS_LIMIT refuses to any servo of the roster a REG WRITE of ID to angle limits or of the status
 * return level (0x03 to 0x09, 0x10): nobody would know what became of it. A servo has a registered
 * write until it answers ACTION, or 0x2C is 0 as it says: an ACTION to all tells nothing.
 *
 * A servo whose change of ID, or RESET, was not answered may have either ID: it counts for both,
 * until it answers by one of them that no other may have. CDS_LIMIT refuses it a third. If two have
 * the same ID, what is refused for one is.
 * Main context.
 */
#ifndef CDS_SERVOS_H
#define CDS_SERVOS_H

#include <stdbool.h>
#include <stddef.h> // NULL
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus_observer

#ifdef __cplusplus
extern "C" {
#endif

/* Exchanges without a reply, one after the other, until a servo counts as away. */
#define CDS_SERVOS_SILENCES 3

/* In `return_delay`: not known; the bus's own is waited for. In `baud`: not known. */
#define CDS_SERVOS_UNKNOWN 255

/* Is the servo there? */
enum cds_presence {
    CDS_PRESENCE_UNKNOWN,  // it was not asked yet
    CDS_PRESENCE_ONLINE,   // it answered, or missed no more than two exchanges since
    CDS_PRESENCE_OFFLINE,  // it does not answer
    CDS_PRESENCE_RETURNED, // it answers again; what it remembers is not known yet
};

/* Why a servo is not driven: bits of `held`. */
enum cds_hold {
    CDS_INHIBIT_STATE_LOST =
        1,                   // its torque was on and is off: its RAM area is at the initial values
    CDS_INHIBIT_STOPPED = 2, // torque off for all was asked for: torque_off.h
};

/* What is known of one of the two angle limits, 0x06 and 0x08. */
enum cds_angle_limit {
    CDS_ANGLE_UNKNOWN,
    CDS_ANGLE_SET, // not 0: position mode, whatever the other one is
    CDS_ANGLE_0,   // both: endless turn
};

/* Of one servo, since cds_servos_begin(): modulo 65536; what should never be, up to 255, which
 * then means that many or more. */
struct cds_servo_counters {
    uint16_t ok;         // exchanges that it answered
    uint16_t timeouts;   // ... that it did not
    uint16_t corrupt;    // ... of whose answer only damage came
    uint8_t late;        // its packets that came when it had been given up
    uint8_t extra;       // ... that came after its answer: two have its ID
    uint8_t foreign;     // ... that came when it was not asked, or of another length
    uint8_t echo_errors; // bytes said to it that came back changed
};

/* One servo. The caller sets `id`, 0 to 253; cds_servos_begin() the rest. What is known beforehand
 * may be set from then on: return_delay, status_return_level, baud, and ccw_limit, which as
 * CDS_ANGLE_SET says position mode. The rest is to be read. */
struct cds_servo_state {
    struct cds_servo_counters counters;
    uint16_t lowest, highest; // soft limits of its goal, 0 to 1023; 0 and 1023: none
    uint16_t fastest;         // soft limit of its speed, 0 to 1023, in both modes; 1023: none
    uint8_t id;               // 0 to 253; follows a change of ID
    uint8_t maybe_id;         // ... that it may have instead, until it answers; 254: none
    uint8_t baud;             // register value of the rate it answers at, or CDS_SERVOS_UNKNOWN
    uint8_t return_delay;     // register 0x05, in 2 us, or CDS_SERVOS_UNKNOWN
    uint8_t alarms;           // CDS_ERROR_* bits of all its packets, until acknowledged
    uint8_t presence : 2;     // enum cds_presence
    uint8_t held : 2;         // CDS_HOLD_* bits
    uint8_t silences : 2;     // exchanges in a row that it did not answer, up to 3
    uint8_t status_return_level : 2; // register 0x10; 2 until more is known
    uint8_t cw_limit : 2;            // enum cds_angle_limit
    uint8_t ccw_limit : 2;           // likewise
    bool torque : 1;                 // it has been switched on, as far as is known
    bool speed_known : 1;            // the speed it holds is within the limit
    bool speed_0 : 1;                // ... but may be 0
    bool goal_known : 1;             // the goal it holds is within the limits
    uint8_t stopped : 3; // enum cds_torque_off_outcome of the last torque off for all: torque_off.h
    bool armed : 1;      // it has, or may have, a registered write
    bool armed_unjudged : 1; // ... that was not judged by what holds now
    bool armed_torque : 1;   // ... of torque on
};

/* All of them. */
struct cds_servos {
    struct cds_bus_observer observer; // first: the bus knows this much
    struct cds_bus *bus;
    struct cds_servo_state *servos;
    uint16_t echo_errors;   // of the bus, when last looked at
    uint8_t count;          // of `servos`
    uint8_t last;           // the one found last: the next one asked for is often the next
    uint8_t alarms;         // of all servos, known or not, until acknowledged
    bool changed;           // what may be sent, while requests waited
    bool inhibited;         // nothing that can drive a servo is sent, to whatever ID
    uint8_t shortest_delay; // smallest value of register 0x05 (2 us each) that may be written; set
                            // by the caller after cds_servos_begin()
    bool ambiguous;         // an ID may be that of more than one of them, or one may have another
    uint8_t refused_id; // whom the last packet that was not admitted concerns; one refused later,
                        // as when a move is taken back, overwrites it
};

/* Watches `bus`, which must be open, for the `count` (0 to 254) servos `servos`, which stay in
 * place. Ends the drive inhibit and sets shortest_delay to 0. CDS_OK; CDS_BAD_ARGUMENT: no bus is
 * open, or an ID is above 253 or stands twice. */
enum cds_result cds_servos_begin(struct cds_servos *roster, struct cds_bus *bus,
                                 struct cds_servo_state *servos, uint8_t count);

/* Takes servo `id`, 0 to 253, into the roster, whose array `servos` has place for `room` of them, 1
 * to 254; nothing is known of it yet. CDS_OK; CDS_BAD_ARGUMENT: the ID is above 253, or there
 * already; CDS_NO_ROOM: the array is full. */
enum cds_result cds_servos_add(struct cds_servos *roster, uint8_t id, uint8_t room);

/* Returns servo `id` (0 to 253) of the roster, or NULL. Of several with this ID the one found
 * first; if none has it, one that may have it. */
struct cds_servo_state *cds_servos_find(struct cds_servos *roster, uint8_t id);

/* Sets the soft limits of `servo`, one of the roster: goals from `lowest` to `highest`, both 0 to
 * 1023 (0 to 300 degrees); speeds up to `fastest`, 0 to 1023 (62/1023 RPM each). What that refuses
 * is said above. Where a limit is drawn closer, goal or speed must be set anew; a registered write
 * is not carried out any more. What is on its way already is; the servo itself is not told. CDS_OK;
 * CDS_BAD_ARGUMENT: out of range, or lowest above highest; nothing was set. */
enum cds_result cds_servos_set_limits(struct cds_servos *roster, struct cds_servo_state *servo,
                                      uint16_t lowest, uint16_t highest, uint16_t fastest);

/* May servo `id` (0 to 253) be driven? False for every ID while driving is inhibited. Else false:
 * it is held, away, or back and not looked at yet. For 254, all of them: false if one is held, or
 * back and not looked at yet; one that is away stops no packet to others, and does not count.
 * Whoever is to stop when one falls silent asks for each ID.
 */
bool cds_servos_may_drive(struct cds_servos *roster, uint8_t id);

/* Takes note of the alarms of `servo`, one of the roster, or of all if it is NULL: returns the bits
 * that were latched, CDS_ERROR_*, and latches anew. */
uint8_t cds_servos_acknowledge(struct cds_servos *roster, struct cds_servo_state *servo);

/* Holds `servo`, one of the roster: the bus does not drive the servo until it is released. NULL:
 * all of them, and driving is inhibited: the bus refuses every packet that can drive a servo, known
 * to the roster or not. Nothing is sent. `why`: CDS_HOLD_* bits. */
void cds_servos_hold(struct cds_servos *roster, struct cds_servo_state *servo, uint8_t why);

/* Lets `servo`, one of the roster, be driven again. NULL: all of them, and driving is no longer
 * inhibited. Nothing is sent and nothing moves: torque is off, and the caller sets speed, goal and
 * torque anew. While driving is inhibited, the release of one servo does not let it be driven. A
 * servo that is back stays held until its TORQUE_ENABLE was read, and one that is away is not
 * driven before. */
void cds_servos_release(struct cds_servos *roster, struct cds_servo_state *servo);

/* Ends the inhibit, and CDS_INHIBIT_STOPPED of all servos; a servo that lost its state stays held.
 * Nothing is sent. */
void cds_servos_allow(struct cds_servos *roster);

#ifdef __cplusplus
}
#endif

#endif
