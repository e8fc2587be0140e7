/* What is known of the servos of a bus, and what may be sent to them; see servos.h. */
#include "cds55xx/servos.h"

#include <stddef.h>

#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX
#include "safety/permit.h"         // cds_permit_check()
#include "servo/goal.h"            // CDS_GOAL_SIZE
#include "safety/limits.h"         // cds_limits_check()
#include "safety/observe.h"
#include "compiler.h"    // NOINLINE
#include "safety/part.h" // struct cds_part

#define FACTORY_ID           1 // what RESET leaves (R11, R25)
#define FACTORY_RETURN_DELAY 1
#define NO_ID                CDS_BROADCAST_ID // in maybe_id
#define LEVEL_ALL            2                // status return levels: all is answered,
#define LEVEL_READ           1                // READ and PING,
#define LEVEL_PING           0                // PING only (R3)
#define VETTED               1                // bits of `vetted` of a request: the caller's,
#define MUTED                2                // and ours: that no reply is due was said here

static struct cds_servos *of(struct cds_bus_observer *observer)
{
    return (struct cds_servos *)observer; // its first member
}

/* ---- who is meant ---- */

static struct cds_servo_state *by_id(struct cds_servos *roster, uint8_t id)
{
    uint8_t at = roster->last;
    struct cds_servo_state *servo = &roster->servos[at];

    for (uint8_t i = roster->count; i; i--) {
        if (servo->id == id) {
            roster->last = at;
            return servo;
        }
        at++;
        servo++;
        if (at == roster->count) {
            at = 0;
            servo = roster->servos;
        }
    }
    return NULL;
}

/* The first one from `servo` on that `id` may mean, or NULL. */
static struct cds_servo_state *from(const struct cds_servos *roster, uint8_t id,
                                    struct cds_servo_state *servo)
{
    const struct cds_servo_state *end = roster->servos + roster->count;

    for (; servo < end; servo++)
        if (id == CDS_BROADCAST_ID || servo->id == id || servo->maybe_id == id)
            return servo;
    return NULL;
}

static bool means_several(const struct cds_servos *roster, uint8_t id)
{
    return id == CDS_BROADCAST_ID || roster->ambiguous;
}

/* All that `id` may mean, one after the other, the first one behind NULL; one at the most, mostly,
 * and found soon. */
static struct cds_servo_state *next_of(struct cds_servos *roster, uint8_t id,
                                       struct cds_servo_state *servo)
{
    if (means_several(roster, id))
        return from(roster, id, servo ? servo + 1 : roster->servos);
    return servo ? NULL : by_id(roster, id);
}

struct cds_servo_state *cds_servos_find(struct cds_servos *roster, uint8_t id)
{
    struct cds_servo_state *servo = by_id(roster, id);

    return servo || id == CDS_BROADCAST_ID ? servo : next_of(roster, id, NULL);
}

/* Can nobody else have sent what came from `id`? */
static bool is_alone(struct cds_servos *roster, uint8_t id)
{
    return !next_of(roster, id, next_of(roster, id, NULL));
}

/* What may be sent to `servo`, or to all if it is NULL, is not what it was. */
static void note_change(struct cds_servos *roster, const struct cds_servo_state *servo)
{
    roster->observer.epoch++;
    roster->observer.changed_id = servo ? servo->id : CDS_BROADCAST_ID;
    roster->changed = true;
}

static bool are_distinct(const struct cds_servo_state *servos, uint8_t count)
{
    const struct cds_servo_state *end = servos + count, *other;

    for (; servos < end; servos++) {
        if (servos->id > CDS_ID_MAX)
            return false;
        for (other = servos + 1; other < end; other++)
            if (other->id == servos->id)
                return false;
    }
    return true;
}

/* Is there any doubt who has which ID? */
static bool is_ambiguous(const struct cds_servos *roster)
{
    const struct cds_servo_state *servo = roster->servos;

    for (uint8_t i = roster->count; i; i--, servo++)
        if (servo->maybe_id != NO_ID)
            return true;
    return !are_distinct(roster->servos, roster->count);
}

/* `servo` has another ID, or may have: goals to any of them are judged anew. */
NOINLINE static void learn_id(struct cds_servos *roster, struct cds_servo_state *servo, uint8_t id,
                              bool certain)
{
    if (certain) {
        servo->id = id;
        servo->maybe_id = NO_ID;
        roster->ambiguous = is_ambiguous(roster);
    } else if (id != servo->id) {
        servo->maybe_id = id;
        roster->ambiguous = true;
    }
    note_change(roster, NULL);
}

/* ---- what is learnt ---- */

static void disarm(struct cds_servo_state *servo)
{
    servo->armed = false;
    servo->armed_unjudged = false;
    servo->armed_torque = false;
}

/* What is registered was judged by what is known no more. */
static void unsettle(struct cds_servo_state *servo)
{
    if (servo->armed)
        servo->armed_unjudged = true;
}

/* Not `certain`: it may hold this, or what it held before. */
NOINLINE static void stay_careful(struct cds_servo_state *servo,
                                  const struct cds_servo_state *before)
{
    if (servo->cw_limit != before->cw_limit)
        servo->cw_limit = CDS_ANGLE_UNKNOWN;
    if (servo->ccw_limit != before->ccw_limit)
        servo->ccw_limit = CDS_ANGLE_UNKNOWN;
    if (!before->goal_known)
        servo->goal_known = false;
    if (!before->speed_known)
        servo->speed_known = false;
    if (before->speed_0)
        servo->speed_0 = true;
}

/* Mode, goal and speed. What waits is judged anew; goals of a cycle, which bring their speed, only
 * if the mode is another one. */
static void learn_drive(struct cds_servos *roster, struct cds_servo_state *servo,
                        const struct cds_span *span, bool certain)
{
    struct cds_servo_state before = *servo;

    cds_limits_take(servo, span);
    if (!certain)
        stay_careful(servo, &before);
    if (servo->cw_limit != before.cw_limit || servo->ccw_limit != before.ccw_limit) {
        note_change(roster, servo);
        unsettle(servo);
    }
    if (servo->goal_known != before.goal_known || servo->speed_known != before.speed_known ||
        servo->speed_0 != before.speed_0)
        roster->changed = true;
    if ((before.goal_known && !servo->goal_known) || (before.speed_known && !servo->speed_known) ||
        (servo->speed_0 && !before.speed_0))
        unsettle(servo);
}

/* A goal or speed that may have come, or not. It was admitted, so nothing is known by it, and what
 * was known is still so. But in endless turn the speed may be 0 now: taken so whatever it is, as it
 * comes 250 times a second, and the second one then tells nothing new. */
static void learn_doubtful_speed(struct cds_servos *roster, struct cds_servo_state *servo)
{
    if (servo->speed_0 || cds_limits_mode(servo) != CDS_MODE_TURN)
        return;
    servo->speed_0 = true;
    roster->changed = true;
    unsettle(servo);
}

/* A setting, if it is there. True: it was another one. */
static bool learn_byte(uint8_t *setting, const struct cds_span *span, uint8_t reg)
{
    uint8_t before = *setting;

    *setting = cds_span_value(span, reg, before);
    return *setting != before;
}

static void learn_settings(struct cds_servos *roster, struct cds_servo_state *servo,
                           const struct cds_span *span)
{
    uint8_t level = servo->status_return_level;

    learn_byte(&servo->baud, span, CDS_REG_BAUD_RATE);
    if (learn_byte(&servo->return_delay, span, CDS_REG_RETURN_DELAY))
        roster->changed = true;
    if (learn_byte(&level, span, CDS_REG_STATUS_RETURN_LEVEL)) {
        servo->status_return_level = level < LEVEL_ALL ? level & 1u : LEVEL_ALL;
        roster->changed = true;
    }
}

static void learn_registered(struct cds_servos *roster, struct cds_servo_state *servo,
                             uint8_t registered)
{
    if (!registered && servo->armed) {
        disarm(servo);
        roster->changed = true;
    } else if (registered && !servo->armed) { // by whom, and what?
        servo->armed = true;
        unsettle(servo);
        roster->changed = true;
    }
}

/* The servo holds this: it was read, or written and acknowledged, or, not `certain`, written as far
 * as anybody can know. */
static void learn(struct cds_servos *roster, struct cds_servo_state *servo,
                  const struct cds_span *span, bool certain)
{
    const uint8_t *registered;

    if (span->address <= CDS_REG_STATUS_RETURN_LEVEL)
        learn_settings(roster, servo, span);
    if (span->address <= CDS_REG_CCW_ANGLE_LIMIT + 1) {
        learn_drive(roster, servo, span, certain);
    } else if (cds_span_touches(span, CDS_REG_GOAL_POSITION, CDS_REG_MOVING_SPEED + 1) &&
               cds_limits_any(servo)) { // without, set_limits() says that they are not known
        if (certain)
            learn_drive(roster, servo, span, true);
        else if (cds_span_touches(span, CDS_REG_MOVING_SPEED, CDS_REG_MOVING_SPEED + 1))
            learn_doubtful_speed(roster, servo);
    }
    registered = cds_span_byte(span, CDS_REG_REGISTERED_INSTRUCTION);
    if (registered && certain)
        learn_registered(roster, servo, *registered);
}

static void learn_written(struct cds_servos *roster, struct cds_servo_state *servo,
                          const struct cds_span *span, bool certain)
{
    const uint8_t *byte;

    learn(roster, servo, span, certain);
    if ((byte = cds_span_byte(span, CDS_REG_TORQUE_ENABLE)))
        servo->torque = *byte;
    if ((byte = cds_span_byte(span, CDS_REG_ID)))
        learn_id(roster, servo, *byte, certain);
}

/* What it holds is not known any more. */
static void forget(struct cds_servos *roster, struct cds_servo_state *servo)
{
    servo->speed_known = false;
    servo->goal_known = false;
    unsettle(servo);
    roster->changed = true;
}

/* Torque that is off where it was on: power was gone for a moment, or an alarm has shut it down. */
static void learn_read(struct cds_servos *roster, struct cds_servo_state *servo,
                       const struct cds_span *span, bool certain)
{
    const uint8_t *torque = cds_span_byte(span, CDS_REG_TORQUE_ENABLE);

    if (torque) {
        bool changed = servo->presence == CDS_PRESENCE_RETURNED;

        if (servo->torque && !*torque) {
            servo->held |= CDS_INHIBIT_STATE_LOST;
            changed = true;
        }
        if (changed && !*torque)
            forget(roster, servo);
        if (changed)
            note_change(roster, servo); // not else: whoever sends the same again is judged anew
        servo->torque = *torque;
        servo->presence = CDS_PRESENCE_ONLINE;
    }
    learn(roster, servo, span, certain);
}

/* Not `certain`: it may be what it was, under the ID it had. */
static void learn_reset(struct cds_servos *roster, struct cds_servo_state *servo, bool certain)
{
    forget(roster, servo);
    servo->cw_limit = servo->ccw_limit = CDS_ANGLE_UNKNOWN;
    servo->status_return_level = LEVEL_ALL;
    servo->baud = CDS_SERVOS_UNKNOWN;
    if (certain) {
        disarm(servo);
        servo->torque = false;
        servo->cw_limit = CDS_ANGLE_0;
        servo->ccw_limit = CDS_ANGLE_SET;
        servo->return_delay = FACTORY_RETURN_DELAY;
        servo->baud = CDS_BAUD_1M;
    } else if (servo->return_delay < FACTORY_RETURN_DELAY) {
        servo->return_delay = FACTORY_RETURN_DELAY;
    }
    learn_id(roster, servo, FACTORY_ID, certain);
}

/* ---- all servos that an instruction packet reaches, and with what ---- */

/* Torque off, and nothing else: always admitted, and without delay. */
static bool is_torque_off(const uint8_t *bytes)
{
    return bytes[CDS_AT_INSTRUCTION] == CDS_WRITE && bytes[CDS_AT_LENGTH] == CDS_LENGTH_MIN + 2 &&
           bytes[CDS_AT_PARAMETERS] == CDS_REG_TORQUE_ENABLE && bytes[CDS_AT_PARAMETERS + 1] == 0;
}

/* ---- what may be sent ---- */

ALWAYS_INLINE bool is_held(const struct cds_servo_state *servo)
{
    return servo->held || servo->presence == CDS_PRESENCE_RETURNED;
}

bool cds_servos_may_drive(struct cds_servos *roster, uint8_t id)
{
    const struct cds_servo_state *servo = roster->servos;
    bool all = id == CDS_BROADCAST_ID;

    if (roster->inhibited)
        return false;
    for (uint8_t i = roster->count; i; i--, servo++)
        if ((all || servo->id == id || servo->maybe_id == id) &&
            (is_held(servo) || (!all && servo->presence == CDS_PRESENCE_OFFLINE)))
            return false;
    return true;
}

/* May its ID be `id` from now on? Not if there would then be three of them that it may have. */
static bool may_become(const struct cds_servo_state *servo, uint8_t id)
{
    return servo->maybe_id == NO_ID || id == servo->id || id == servo->maybe_id;
}

/* Can everybody go on knowing where and how the servo is? Nobody would know when an ACTION that may
 * not be heard has changed its ID, rate, delay, mode or level. */
static bool stays_known(const struct cds_servo_state *servo, const struct cds_part *part)
{
    if (part->instruction == CDS_REG_WRITE &&
        (cds_span_touches(&part->span, CDS_REG_ID, CDS_REG_CCW_ANGLE_LIMIT + 1) ||
         cds_span_byte(&part->span, CDS_REG_STATUS_RETURN_LEVEL)))
        return false;
    return may_become(servo, cds_span_value(&part->span, CDS_REG_ID, servo->id));
}

/* ACTION drives whoever has a registered write. */
static enum cds_result judge_action(const struct cds_servo_state *servo)
{
    if (servo->armed && is_held(servo))
        return CDS_INHIBITED;
    return servo->armed_unjudged && cds_limits_any(servo) ? CDS_LIMIT : CDS_OK;
}

/* Of many servos one that is away stops no other: it does not hear this, and if it is just back,
 * its torque is off. */
static enum cds_result judge(const struct cds_servo_state *servo, const struct cds_part *part)
{
    bool held = is_held(servo);

    if (servo->presence == CDS_PRESENCE_OFFLINE && part->instruction != CDS_SYNC_WRITE &&
        part->id != CDS_BROADCAST_ID)
        held = true;
    if (part->instruction == CDS_ACTION)
        return judge_action(servo);
    if (part->instruction == CDS_RESET)
        return may_become(servo, FACTORY_ID) ? CDS_OK : CDS_LIMIT;
    if (held && cds_span_drives(&part->span))
        return CDS_INHIBITED;
    if (!stays_known(servo, part))
        return CDS_LIMIT;
    return cds_limits_check(servo, &part->span);
}

/* A part of a packet to all whom its ID means. `refused_id`: whom it must not go to. */
static enum cds_result judge_part(struct cds_servos *roster, const struct cds_part *part,
                                  uint8_t *refused_id)
{
    struct cds_servo_state *servo = NULL;

    while ((servo = next_of(roster, part->id, servo))) {
        enum cds_result result = judge(servo, part);

        if (result != CDS_OK) {
            *refused_id = servo->id;
            return result;
        }
    }
    return CDS_OK;
}

NOINLINE static enum cds_result judge_block(struct cds_servos *roster, uint8_t id, uint8_t address,
                                            const uint8_t *data, uint8_t length)
{
    struct cds_part part = {{data, address, length}, id, CDS_SYNC_WRITE};

    if (roster->inhibited && cds_span_may_move(&part.span))
        return CDS_INHIBITED;
    return judge_part(roster, &part, &id);
}

enum cds_result cds_servos_admit_block(struct cds_bus_observer *observer, uint8_t id,
                                       uint8_t address, const uint8_t *data, uint8_t length)
{
    struct cds_servos *roster = of(observer);
    uint8_t next = (uint8_t)(roster->last + 1u);
    const struct cds_servo_state *servo;

    if (roster->ambiguous || roster->inhibited || address != CDS_REG_GOAL_POSITION ||
        length != CDS_GOAL_SIZE)
        return judge_block(roster, id, address, data, length);
    if (next >= roster->count) // by the short way: 50 of them in 4 ms
        next = 0;
    servo = &roster->servos[next];
    if (next < roster->count && servo->id == id)
        roster->last = next;
    else
        servo = by_id(roster, id);
    if (!servo)
        return CDS_OK;
    return is_held(servo) ? CDS_INHIBITED : cds_limits_check_goal(servo, data);
}

/* One servo's part of many goes by the short way. */
static enum cds_result judge_writes(struct cds_servos *roster, const uint8_t *bytes,
                                    uint8_t *refused_id)
{
    const struct cds_span *span;
    struct cds_part part;
    enum cds_result result = CDS_OK;

    if (is_torque_off(bytes))
        return CDS_OK;
    for (uint8_t i = 0; result == CDS_OK && cds_part_of(bytes, i, &part); i++) {
        span = &part.span;
        *refused_id = part.id;
        if (part.instruction != CDS_SYNC_WRITE || means_several(roster, part.id))
            result = judge_part(roster, &part, refused_id);
        else
            result = cds_servos_admit_block(&roster->observer, part.id, span->address, span->data,
                                            span->length);
    }
    return result;
}

/* What the servo's own settings mean for this exchange: of several that may have this ID, the
 * slowest, and the one that says most. */
static enum cds_result suit(struct cds_servos *roster, struct cds_request *request, uint8_t id,
                            uint8_t instruction)
{
    struct cds_servo_state *servo = next_of(roster, id, NULL);
    uint16_t delay_us = 0;
    uint8_t level = LEVEL_PING;

    if (request->vetted & MUTED)
        request->reply_parameters = 0;
    request->vetted &= (uint8_t)~MUTED;
    if (!servo)
        return CDS_OK;
    for (; servo; servo = next_of(roster, id, servo)) {
        uint16_t its_us = roster->bus->return_delay_us;

        if (servo->return_delay != CDS_SERVOS_UNKNOWN)
            its_us = (uint16_t)(2u * servo->return_delay);
        if (its_us > delay_us)
            delay_us = its_us;
        if (servo->status_return_level > level)
            level = servo->status_return_level;
    }
    cds_bus_set_return_delay_of_(request, delay_us);
    if (instruction == CDS_READ)
        return level == LEVEL_PING ? CDS_NO_REPLY_DUE : CDS_OK;
    if (instruction != CDS_PING && level <= LEVEL_READ &&
        request->reply_parameters != CDS_REPLY_NONE) {
        request->reply_parameters = CDS_REPLY_NONE;
        request->vetted |= MUTED;
    }
    return CDS_OK;
}

static enum cds_result judge_packet(struct cds_servos *roster, struct cds_request *request)
{
    const uint8_t *bytes = request->packet.bytes;
    uint8_t id = bytes[CDS_AT_ID], instruction = bytes[CDS_AT_INSTRUCTION], refused_id = id;
    enum cds_result result = CDS_OK;

    switch (instruction) {
    case CDS_WRITE:
    case CDS_REG_WRITE:
    case CDS_SYNC_WRITE: result = judge_writes(roster, bytes, &refused_id); break;
    case CDS_ACTION:
    case CDS_RESET:
        result = judge_part(roster, &(struct cds_part){.id = id, .instruction = instruction},
                            &refused_id);
        break;
    default: break;
    }
    if (result == CDS_OK && id != CDS_BROADCAST_ID)
        result = suit(roster, request, id, instruction);
    if (result != CDS_OK)
        roster->refused_id = refused_id;
    return result;
}

/* What has waited while something changed is judged anew at its turn. */
NOINLINE static enum cds_result judge_anew(struct cds_servos *roster, struct cds_request *request)
{
    uint8_t vetted = request->vetted;

    if (!roster->bus->request)
        roster->changed = false; // nobody has waited since
    if (request->result == CDS_PENDING) {
        request->vetted = vetted & MUTED;
        if (!roster->changed)
            return CDS_OK;
    } else {
        request->vetted = 0;
        if (vetted & VETTED)
            return CDS_OK;
    }
    return judge_packet(roster, request);
}

enum cds_result cds_servos_admit(struct cds_bus_observer *observer, struct cds_request *request)
{
    struct cds_servos *roster = of(observer);
    enum cds_result result = cds_permit_check(roster, request->packet.bytes);

    if (result != CDS_OK) {
        roster->refused_id = request->packet.bytes[CDS_AT_ID];
        return result;
    }
    if (roster->count)
        return judge_anew(roster, request);
    request->vetted = 0;
    return CDS_OK;
}

/* ---- what has happened ---- */

/* One that may have either of two IDs has the one it has answered by, if nobody else can have. */
static void answered(struct cds_servos *roster, struct cds_servo_state *servo, uint8_t id)
{
    servo->counters.ok++;
    servo->silences = 0;
    servo->baud = roster->bus->baud;
    if (servo->maybe_id != NO_ID && is_alone(roster, id))
        learn_id(roster, servo, id, true);
    if (servo->presence == CDS_PRESENCE_OFFLINE) {
        servo->presence = CDS_PRESENCE_RETURNED;
        note_change(roster, servo);
    } else if (servo->presence == CDS_PRESENCE_UNKNOWN) {
        servo->presence = CDS_PRESENCE_ONLINE;
    }
}

/* Silence tells something only where the servo is to be heard: at its rate, by its ID. */
static void not_answered(struct cds_servos *roster, struct cds_servo_state *servo)
{
    servo->counters.timeouts++;
    if (servo->baud != roster->bus->baud || servo->maybe_id != NO_ID)
        return;
    if (servo->silences < CDS_SERVOS_SILENCES)
        servo->silences = (servo->silences + 1u) & 3u;
    if (servo->silences == CDS_SERVOS_SILENCES && servo->presence != CDS_PRESENCE_OFFLINE) {
        servo->presence = CDS_PRESENCE_OFFLINE;
        note_change(roster, servo);
    }
}

/* Goals of a cycle, which come 250 times a second: nobody answers, so they make nothing known, and
 * who is beyond his limits was not among them. Endless turn: see above. */
static bool are_old_news(const struct cds_servos *roster, const uint8_t *bytes)
{
    const uint8_t *parameters = bytes + CDS_AT_PARAMETERS;
    const struct cds_servo_state *servo = roster->servos;

    if (bytes[CDS_AT_INSTRUCTION] != CDS_SYNC_WRITE || bytes[CDS_AT_LENGTH] < CDS_LENGTH_MIN + 2 ||
        parameters[0] != CDS_REG_GOAL_POSITION || parameters[1] != CDS_GOAL_SIZE)
        return false;
    for (uint8_t i = roster->count; i; i--, servo++)
        if (servo->fastest < CDS_VALUE_MAX && !servo->speed_0 &&
            (servo->cw_limit & servo->ccw_limit) == CDS_ANGLE_0)
            return false;
    return true;
}

static void learn_parts(struct cds_servos *roster, const uint8_t *bytes, bool certain)
{
    struct cds_servo_state *servo;
    struct cds_part part;

    if (are_old_news(roster, bytes))
        return;
    if (is_torque_off(bytes) && bytes[CDS_AT_ID] == CDS_BROADCAST_ID) { // is not to take long
        servo = roster->servos;
        for (uint8_t i = roster->count; i; i--, servo++)
            servo->torque = false;
        return;
    }
    for (uint8_t i = 0; cds_part_of(bytes, i, &part); i++) {
        servo = next_of(roster, part.id, NULL);
        while (servo) { // whose ID changes here must not be met by it again
            struct cds_servo_state *next = next_of(roster, part.id, servo);

            learn_written(roster, servo, &part.span, certain);
            servo = next;
        }
    }
}

/* A write whose reply was lost may have been carried out all the same. Of two possibilities, the
 * careful one: the longer delay, the level that says more, no rate, both IDs, torque on. */
static void doubt(struct cds_servos *roster, struct cds_servo_state *servo,
                  const struct cds_span *span)
{
    uint8_t return_delay = servo->return_delay, level = servo->status_return_level;
    bool torque = servo->torque;

    learn_written(roster, servo, span, false);
    if (return_delay > servo->return_delay)
        servo->return_delay = return_delay;
    if (level > servo->status_return_level)
        servo->status_return_level = level & 3u;
    if (cds_span_byte(span, CDS_REG_BAUD_RATE))
        servo->baud = CDS_SERVOS_UNKNOWN;
    if (torque)
        servo->torque = true;
}

/* A REG WRITE was heard, or may have been. It was judged when it was sent. */
static void arm(struct cds_servos *roster, struct cds_servo_state *servo,
                const struct cds_span *span, bool certain)
{
    learn(roster, servo, span, false); // ACTION is to come
    if (certain)
        disarm(servo); // the last one counts
    if (cds_limits_check(servo, span) != CDS_OK)
        servo->armed_unjudged = true;
    if (cds_span_value(span, CDS_REG_TORQUE_ENABLE, 0))
        servo->armed_torque = true;
    servo->armed = true;
    roster->changed = true;
}

static void act(struct cds_servo_state *servo, bool certain)
{
    if (servo->armed_torque)
        servo->torque = true;
    if (certain)
        disarm(servo);
}

/* What the packet has done, or may have, to one it was meant for. `lost`: its reply is. */
static void learn_packet(struct cds_servos *roster, struct cds_servo_state *servo,
                         const struct cds_bus_news *news, bool certain, bool lost)
{
    const uint8_t *bytes = news->request->packet.bytes;
    struct cds_part part = {.span = {bytes, news->address, news->request->length}}; // of a READ

    switch (news->instruction) {
    case CDS_WRITE: // lost
        if (cds_part_of(bytes, 0, &part))
            doubt(roster, servo, &part.span);
        break;
    case CDS_REG_WRITE:
        if (cds_part_of(bytes, 0, &part))
            arm(roster, servo, &part.span, certain);
        break;
    case CDS_ACTION: act(servo, certain); break;
    case CDS_RESET: learn_reset(roster, servo, certain); break;
    case CDS_READ:
        if (!lost)
            learn_read(roster, servo, &part.span, certain);
        break;
    default: break;
    }
}

/* The packet was carried out, as far as anybody can know; for certain, only if the servo says so
 * and no other can have said it. `servo`: the first that its ID may mean. */
static void carried_out(struct cds_servos *roster, struct cds_servo_state *servo,
                        const struct cds_bus_news *news, bool due)
{
    bool lost = news->result != CDS_OK;
    bool certain = false;

    if (due && !lost && servo)
        certain = !next_of(roster, news->id, servo);
    if (!lost && (news->instruction == CDS_WRITE || news->instruction == CDS_SYNC_WRITE)) {
        learn_parts(roster, news->request->packet.bytes, certain);
        return;
    }
    while (servo) { // as above
        struct cds_servo_state *next = next_of(roster, news->id, servo);

        learn_packet(roster, servo, news, certain, lost);
        servo = next;
    }
}

/* Adds to what should never be; it stays at the most that it can be. */
NOINLINE static void add_oddities(uint8_t *counter, uint16_t more)
{
    uint8_t room = (uint8_t)(UINT8_MAX - *counter);

    if (more > room)
        more = room;
    *counter = (uint8_t)(*counter + more);
}

static void count_echo_errors(struct cds_servos *roster, struct cds_servo_state *servo)
{
    uint16_t echo_errors = cds_link_count(&roster->bus->link.echo_errors);
    uint16_t more = (uint16_t)(echo_errors - roster->echo_errors);

    if (servo && more)
        add_oddities(&servo->counters.echo_errors, more);
    roster->echo_errors = echo_errors;
}

static void note_presence(struct cds_servos *roster, struct cds_servo_state *servo,
                          const struct cds_bus_news *news)
{
    while (servo) {
        struct cds_servo_state *next = next_of(roster, news->id, servo);

        if (news->result == CDS_OK)
            answered(roster, servo, news->id);
        else if (news->result == CDS_TIMEOUT)
            not_answered(roster, servo);
        else
            servo->counters.corrupt++;
        servo = next;
    }
}

/* `one`: as `servo`, but NULL if all were asked. */
static void ended(struct cds_servos *roster, struct cds_servo_state *servo,
                  struct cds_servo_state *one, const struct cds_bus_news *news)
{
    bool due = news->request->reply_parameters != CDS_REPLY_NONE;

    count_echo_errors(roster, one);
    if (due)
        note_presence(roster, one, news);
    if (!(news->error & CDS_ERRORS_OF_PACKET))
        carried_out(roster, servo, news, due);
}

static void count_undue(struct cds_servo_counters *counters, uint8_t event)
{
    uint8_t *counter = &counters->foreign;

    if (event == CDS_BUS_LATE)
        counter = &counters->late;
    else if (event == CDS_BUS_EXTRA)
        counter = &counters->extra;
    add_oddities(counter, 1);
}

NOINLINE static void take_news(struct cds_servos *roster, const struct cds_bus_news *news)
{
    struct cds_servo_state *servo = next_of(roster, news->id, NULL);
    struct cds_servo_state *one = news->id == CDS_BROADCAST_ID ? NULL : servo;

    roster->alarms |= news->error;
    if (one)
        one->alarms |= news->error;
    if (news->event == CDS_BUS_ENDED)
        ended(roster, servo, one, news);
    else if (servo)
        count_undue(&servo->counters, news->event);
}

/* Who has asked for nobody does not pay: short, so that few registers are saved. */
void cds_servos_on_news(struct cds_bus_observer *observer, const struct cds_bus_news *news)
{
    struct cds_servos *roster = of(observer);

    if (roster->count)
        take_news(roster, news);
    else
        roster->alarms |= news->error;
}

/* ---- what the caller asks for ---- */

/* A servo of which nothing is known. */
static void meet(struct cds_servo_state *servo, uint8_t id, uint8_t baud)
{
    *servo = (struct cds_servo_state){
        .highest = CDS_VALUE_MAX,
        .fastest = CDS_VALUE_MAX,
        .id = id,
        .maybe_id = NO_ID,
        .baud = baud,
        .return_delay = CDS_SERVOS_UNKNOWN,
        .status_return_level = LEVEL_ALL,
    };
}

enum cds_result cds_servos_begin(struct cds_servos *roster, struct cds_bus *bus,
                                 struct cds_servo_state *servos, uint8_t count)
{
    uint16_t epoch = 0;

    if (bus->byte_time_us == 0 || count > CDS_ID_MAX + 1 || !are_distinct(servos, count))
        return CDS_BAD_ARGUMENT;
    if (bus->observer) // whoever was told something by it is told something else now
        epoch = (uint16_t)(bus->observer->epoch + 1u);
    for (uint8_t i = 0; i < count; i++)
        meet(&servos[i], servos[i].id, bus->baud);
    *roster = (struct cds_servos){
        .observer = {.admit = cds_servos_admit,
                     .admit_block = cds_servos_admit_block,
                     .on_news = cds_servos_on_news,
                     .epoch = epoch,
                     .changed_id = CDS_BROADCAST_ID},
        .bus = bus,
        .changed = true,
        .servos = servos,
        .echo_errors = cds_link_count(&bus->link.echo_errors),
        .count = count,
    };
    cds_bus_set_observer(bus, &roster->observer);
    return CDS_OK;
}

enum cds_result cds_servos_add(struct cds_servos *roster, uint8_t id, uint8_t room)
{
    struct cds_servo_state *servo;

    if (id > CDS_ID_MAX || cds_servos_find(roster, id))
        return CDS_BAD_ARGUMENT;
    if (roster->count >= room)
        return CDS_NO_ROOM;
    if (roster->count == 0)
        roster->echo_errors = cds_link_count(&roster->bus->link.echo_errors);
    servo = &roster->servos[roster->count++];
    meet(servo, id, roster->bus->baud);
    note_change(roster, servo);
    return CDS_OK;
}

enum cds_result cds_servos_set_limits(struct cds_servos *roster, struct cds_servo_state *servo,
                                      uint16_t lowest, uint16_t highest, uint16_t fastest)
{
    if (lowest > highest || highest > CDS_VALUE_MAX || fastest > CDS_VALUE_MAX)
        return CDS_BAD_ARGUMENT;
    if (fastest < servo->fastest)
        servo->speed_known = false;
    if (lowest > servo->lowest || highest < servo->highest)
        servo->goal_known = false;
    unsettle(servo);
    servo->lowest = lowest;
    servo->highest = highest;
    servo->fastest = fastest;
    note_change(roster, servo);
    return CDS_OK;
}

uint8_t cds_servos_acknowledge(struct cds_servos *roster, struct cds_servo_state *servo)
{
    uint8_t alarms = servo ? servo->alarms : roster->alarms;
    struct cds_servo_state *each = roster->servos;

    roster->alarms = 0;
    for (uint8_t i = roster->count; i; i--, each++) {
        if (!servo || servo == each)
            each->alarms = 0;
        roster->alarms |= each->alarms;
    }
    return alarms;
}

/* Of `servo`, or of all, the bits `why` are set, and of the others those of `keep` stay. */
NOINLINE static void set_held(struct cds_servos *roster, struct cds_servo_state *servo,
                              uint8_t keep, uint8_t why)
{
    struct cds_servo_state *each = roster->servos;

    note_change(roster, servo);
    for (uint8_t i = roster->count; i; i--, each++) {
        if (!servo || servo == each)
            each->held = (uint8_t)((each->held & keep) | why) & 3u;
    }
}

void cds_servos_hold(struct cds_servos *roster, struct cds_servo_state *servo, uint8_t why)
{
    if (!servo)
        roster->inhibited = true;
    set_held(roster, servo, UINT8_MAX, why);
}

void cds_servos_allow(struct cds_servos *roster)
{
    roster->inhibited = false;
    set_held(roster, NULL, CDS_INHIBIT_STATE_LOST, 0);
}

void cds_servos_release(struct cds_servos *roster, struct cds_servo_state *servo)
{
    if (!servo)
        roster->inhibited = false;
    set_held(roster, servo, 0, 0);
}
