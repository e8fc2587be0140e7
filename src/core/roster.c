/* What is known of the servos of a bus, and what may be sent to them; see roster.h. */
#include "cds55xx/roster.h"

#include <stddef.h>

#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX
#include "goal.h"                  // CDS_GOAL_SIZE
#include "limits.h"                // cds_limits_check()

#define FACTORY_ID           1 // what RESET leaves (R11, R25)
#define FACTORY_RETURN_DELAY 1
#define LEVEL_ALL            2 // status return levels: all is answered,
#define LEVEL_READ           1 // READ and PING,
#define LEVEL_PING           0 // PING only (R3)

static struct cds_roster *of(struct cds_bus_observer *observer)
{
    return (struct cds_roster *)observer; // its first member
}

struct cds_roster_servo *cds_roster_find(struct cds_roster *roster, uint8_t id)
{
    uint8_t at = roster->last;
    struct cds_roster_servo *servo = &roster->servos[at];

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

/* What may be sent to `servo`, or to all if it is NULL, is not what it was. */
static void note_change(struct cds_roster *roster, const struct cds_roster_servo *servo)
{
    roster->observer.epoch++;
    roster->observer.changed_id = servo ? servo->id : CDS_BROADCAST_ID;
    roster->changed = true;
}

/* ---- what is learnt ---- */

/* Does a transfer of `length` bytes from `address` on hold this register of one byte? Then where.
 */
static const uint8_t *byte_of(uint8_t reg, uint8_t address, const uint8_t *data, uint8_t length)
{
    return reg >= address && reg - address < length ? data + (reg - address) : NULL;
}

static void learn_zero(bool *zero, uint8_t reg, uint8_t address, const uint8_t *data,
                       uint8_t length)
{
    const uint8_t *low = byte_of(reg, address, data, length);
    const uint8_t *high = byte_of((uint8_t)(reg + 1), address, data, length);

    if (low && high)
        *zero = *low == 0 && *high == 0;
    else if ((low && *low) || (high && *high))
        *zero = false;
}

static void learn_settings(struct cds_roster_servo *servo, uint8_t address, const uint8_t *data,
                           uint8_t length)
{
    const uint8_t *it;

    if ((it = byte_of(CDS_REG_RETURN_DELAY, address, data, length)))
        servo->return_delay = *it;
    if ((it = byte_of(CDS_REG_STATUS_RETURN_LEVEL, address, data, length)))
        servo->status_return_level = *it;
    learn_zero(&servo->cw_limit_0, CDS_REG_CW_ANGLE_LIMIT, address, data, length);
    learn_zero(&servo->ccw_limit_0, CDS_REG_CCW_ANGLE_LIMIT, address, data, length);
}

/* The servo holds these bytes from `address` on: written and acknowledged, or read. */
static void learn(struct cds_roster_servo *servo, uint8_t address, const uint8_t *data,
                  uint8_t length)
{
    const uint8_t *it;

    if ((it = byte_of(CDS_REG_REGISTERED_INSTRUCTION, address, data, length)))
        servo->armed = *it;
    if (address > CDS_REG_MOVING_SPEED) // feedback, which comes often
        return;
    if (address <= CDS_REG_STATUS_RETURN_LEVEL)
        learn_settings(servo, address, data, length);
    if (byte_of(CDS_REG_MOVING_SPEED, address, data, length))
        servo->speed_known = cds_limits_check(servo, address, data, length) == CDS_OK;
}

static void learn_written(struct cds_roster_servo *servo, uint8_t address, const uint8_t *data,
                          uint8_t length)
{
    const uint8_t *torque = byte_of(CDS_REG_TORQUE_ENABLE, address, data, length);
    const uint8_t *id = byte_of(CDS_REG_ID, address, data, length);

    learn(servo, address, data, length);
    if (torque)
        servo->torque = *torque;
    if (id)
        servo->id = *id;
}

/* Torque that is off where it was on: power was gone for a moment, or an alarm has shut it down. */
static void learn_read(struct cds_roster *roster, struct cds_roster_servo *servo, uint8_t address,
                       const uint8_t *data, uint8_t length)
{
    const uint8_t *torque = byte_of(CDS_REG_TORQUE_ENABLE, address, data, length);

    if (torque) {
        bool lost = servo->torque && !*torque;

        if (lost)
            servo->held |= CDS_HOLD_LOST;
        if (lost || (!*torque && servo->presence == CDS_PRESENCE_BACK))
            servo->speed_known = false;
        if (lost || servo->presence == CDS_PRESENCE_BACK)
            note_change(roster, servo); // not else: whoever sends the same again is judged anew
        servo->torque = *torque;
        servo->presence = CDS_PRESENCE_HERE;
    }
    learn(servo, address, data, length);
}

static void forget(struct cds_roster_servo *servo)
{
    servo->torque = false;
    servo->speed_known = false;
    servo->armed = false;
}

static void learn_reset(struct cds_roster *roster, struct cds_roster_servo *servo)
{
    forget(servo);
    servo->cw_limit_0 = false;
    servo->ccw_limit_0 = false;
    servo->return_delay = FACTORY_RETURN_DELAY;
    servo->status_return_level = LEVEL_ALL;
    if (!cds_roster_find(roster, FACTORY_ID)) // else there are two of them now, and one is known
        servo->id = FACTORY_ID;
}

/* ---- all servos that an instruction packet reaches, and with what ---- */

/* A part of a packet: data for one servo, or for all of them. */
struct part {
    uint8_t id, address, length;
    bool alone; // it is all of the packet
    const uint8_t *data;
};

/* Part `index` of the packet `bytes`, a WRITE, REG WRITE or SYNC WRITE; false if there is none. */
static bool part_of(const uint8_t *bytes, uint8_t index, struct part *part)
{
    const uint8_t *parameters = bytes + CDS_AT_PARAMETERS;
    uint8_t count = (uint8_t)(bytes[CDS_AT_LENGTH] - CDS_LENGTH_MIN);
    uint8_t block = (uint8_t)(parameters[1] + 1u);

    part->address = parameters[0];
    part->alone = bytes[CDS_AT_INSTRUCTION] != CDS_SYNC_WRITE;
    if (part->alone) {
        part->id = bytes[CDS_AT_ID];
        part->data = parameters + 1;
        part->length = (uint8_t)(count - 1u);
        return index == 0 && count > 1;
    }
    part->length = parameters[1];
    part->data = parameters + 2 + (uint16_t)index * block;
    part->id = *part->data++;
    return (uint16_t)(index + 1u) * block + 2u <= count;
}

/* Torque off, and nothing else: always admitted, and without delay. */
static bool is_torque_off(const uint8_t *bytes)
{
    return bytes[CDS_AT_INSTRUCTION] == CDS_WRITE && bytes[CDS_AT_LENGTH] == CDS_LENGTH_MIN + 2 &&
           bytes[CDS_AT_PARAMETERS] == CDS_REG_TORQUE_ENABLE && bytes[CDS_AT_PARAMETERS + 1] == 0;
}

static bool writes(uint8_t instruction)
{
    return instruction == CDS_WRITE || instruction == CDS_REG_WRITE ||
           instruction == CDS_SYNC_WRITE;
}

/* ---- what may be sent ---- */

static bool is_held(const struct cds_roster_servo *servo)
{
    return servo->held || servo->presence == CDS_PRESENCE_BACK;
}

bool cds_roster_may_drive(struct cds_roster *roster, uint8_t id)
{
    for (uint8_t i = 0; i < roster->count; i++) {
        const struct cds_roster_servo *servo = &roster->servos[i];

        if ((id == CDS_BROADCAST_ID || servo->id == id) && is_held(servo))
            return false;
    }
    return true;
}

/* Would this write drive the servo, so that it must not go to one that is held? */
static bool drives(uint8_t address, const uint8_t *data, uint8_t length)
{
    const uint8_t *torque = byte_of(CDS_REG_TORQUE_ENABLE, address, data, length);

    return (torque && *torque) ||
           (address <= CDS_REG_MOVING_SPEED + 1 && address + length > CDS_REG_GOAL_POSITION);
}

/* Of many servos one that is away stops no other: it does not hear this, and if it is just back,
 * its torque is off. */
static enum cds_result judge(const struct cds_roster_servo *servo, const struct part *part)
{
    bool away = servo->presence == CDS_PRESENCE_AWAY && part->alone && part->id != CDS_BROADCAST_ID;

    if ((is_held(servo) || away) && drives(part->address, part->data, part->length))
        return CDS_HELD;
    return cds_limits_check(servo, part->address, part->data, part->length);
}

static enum cds_result judge_part(struct cds_roster *roster, const struct part *part)
{
    const struct cds_roster_servo *servo;
    enum cds_result result = CDS_OK;

    if (part->id != CDS_BROADCAST_ID) {
        servo = cds_roster_find(roster, part->id);
        return servo ? judge(servo, part) : CDS_OK;
    }
    for (uint8_t i = 0; i < roster->count && result == CDS_OK; i++) {
        roster->refused_id = roster->servos[i].id;
        result = judge(&roster->servos[i], part);
    }
    return result;
}

static enum cds_result judge_writes(struct cds_roster *roster, const uint8_t *bytes)
{
    enum cds_result result = CDS_OK;
    struct part part;

    for (uint8_t i = 0; result == CDS_OK && part_of(bytes, i, &part); i++) {
        roster->refused_id = part.id;
        result = judge_part(roster, &part);
    }
    return result;
}

/* ACTION drives whoever has a registered write. */
static enum cds_result judge_action(struct cds_roster *roster, uint8_t id)
{
    for (uint8_t i = 0; i < roster->count; i++) {
        const struct cds_roster_servo *servo = &roster->servos[i];

        if ((id == CDS_BROADCAST_ID || servo->id == id) && servo->armed && is_held(servo)) {
            roster->refused_id = servo->id;
            return CDS_HELD;
        }
    }
    return CDS_OK;
}

/* What the servo's own settings mean for this exchange. */
static enum cds_result suit(const struct cds_roster_servo *servo, struct cds_request *request,
                            uint8_t instruction)
{
    if (servo->return_delay != CDS_ROSTER_UNKNOWN)
        request->return_delay_us = (uint16_t)(2u * servo->return_delay);
    if (instruction == CDS_READ && servo->status_return_level == LEVEL_PING)
        return CDS_NO_REPLY_DUE;
    if (instruction != CDS_PING && instruction != CDS_READ &&
        servo->status_return_level <= LEVEL_READ)
        request->reply_parameters = CDS_REPLY_NONE;
    return CDS_OK;
}

static enum cds_result judge_packet(struct cds_roster *roster, struct cds_request *request)
{
    const uint8_t *bytes = request->packet.bytes;
    uint8_t id = bytes[CDS_AT_ID], instruction = bytes[CDS_AT_INSTRUCTION];
    enum cds_result result = CDS_OK;
    const struct cds_roster_servo *servo;

    if (writes(instruction) && !is_torque_off(bytes))
        result = judge_writes(roster, bytes);
    else if (instruction == CDS_ACTION)
        result = judge_action(roster, id);
    servo = id == CDS_BROADCAST_ID ? NULL : cds_roster_find(roster, id);
    if (result == CDS_OK && servo) {
        roster->refused_id = id;
        result = suit(servo, request, instruction);
    }
    return result;
}

/* What only looks, or lets go. */
static bool drives_nobody(const uint8_t *bytes)
{
    return bytes[CDS_AT_INSTRUCTION] == CDS_PING || bytes[CDS_AT_INSTRUCTION] == CDS_READ ||
           is_torque_off(bytes);
}

/* What has waited while something changed is judged anew at its turn. */
static __attribute__((noinline)) enum cds_result judge_anew(struct cds_roster *roster,
                                                            struct cds_request *request)
{
    bool again = request->result == CDS_PENDING, vetted = request->vetted;

    request->vetted = false;
    if (!roster->bus->request)
        roster->changed = false; // nobody has waited since
    if (again ? !roster->changed || drives_nobody(request->packet.bytes) : vetted)
        return CDS_OK;
    return judge_packet(roster, request);
}

static enum cds_result admit(struct cds_bus_observer *observer, struct cds_request *request)
{
    struct cds_roster *roster = of(observer);

    if (roster->count)
        return judge_anew(roster, request);
    request->vetted = false;
    return CDS_OK;
}

/* The goal and speed that nobody minds, by the shortest way: a cycle has 50 of them in 4 ms.
 * Whoever is not let through here is judged in full. */
static bool is_harmless(const struct cds_roster_servo *servo, const uint8_t *data)
{
    uint16_t goal = (uint16_t)(data[0] | (uint16_t)data[1] << 8);
    uint16_t speed = (uint16_t)(data[2] | (uint16_t)data[3] << 8);

    return !servo->held && servo->presence != CDS_PRESENCE_BACK && !servo->cw_limit_0 &&
           goal >= servo->lowest && goal <= servo->highest &&
           (servo->fastest == CDS_VALUE_MAX || (speed > 0 && speed <= servo->fastest));
}

static __attribute__((noinline)) enum cds_result judge_block(const struct cds_roster_servo *servo,
                                                             uint8_t address, const uint8_t *data,
                                                             uint8_t length)
{
    struct part part = {.id = servo->id, .address = address, .length = length, .data = data};

    return judge(servo, &part);
}

static enum cds_result admit_block(struct cds_bus_observer *observer, uint8_t id, uint8_t address,
                                   const uint8_t *data, uint8_t length)
{
    struct cds_roster *roster = of(observer);
    uint8_t next = roster->last + 1u < roster->count ? (uint8_t)(roster->last + 1u) : 0;
    const struct cds_roster_servo *servo = &roster->servos[next];

    if (next < roster->count && servo->id == id)
        roster->last = next;
    else
        servo = cds_roster_find(roster, id);
    if (!servo ||
        (address == CDS_REG_GOAL_POSITION && length == CDS_GOAL_SIZE && is_harmless(servo, data)))
        return CDS_OK;
    return judge_block(servo, address, data, length);
}

/* ---- what has happened ---- */

static void note_alarms(struct cds_roster *roster, struct cds_roster_servo *servo, uint8_t error)
{
    roster->alarms |= error;
    if (servo)
        servo->alarms |= error;
}

static void answered(struct cds_roster *roster, struct cds_roster_servo *servo)
{
    servo->counters.ok++;
    servo->silences = 0;
    if (servo->presence == CDS_PRESENCE_AWAY) {
        servo->presence = CDS_PRESENCE_BACK;
        note_change(roster, servo);
    } else if (servo->presence == CDS_PRESENCE_UNKNOWN) {
        servo->presence = CDS_PRESENCE_HERE;
    }
}

static void not_answered(struct cds_roster *roster, struct cds_roster_servo *servo)
{
    servo->counters.timeouts++;
    if (servo->silences < CDS_ROSTER_SILENCES)
        servo->silences++;
    if (servo->silences == CDS_ROSTER_SILENCES && servo->presence != CDS_PRESENCE_AWAY) {
        servo->presence = CDS_PRESENCE_AWAY;
        note_change(roster, servo);
    }
}

/* Goals of a cycle, which come 250 times a second: what they tell is that a speed within its limit
 * was set. Who is held was not among them. */
static bool are_old_news(const struct cds_roster *roster, const uint8_t *bytes)
{
    const uint8_t *parameters = bytes + CDS_AT_PARAMETERS;
    const struct cds_roster_servo *servo = roster->servos;

    if (bytes[CDS_AT_INSTRUCTION] != CDS_SYNC_WRITE || parameters[0] != CDS_REG_GOAL_POSITION ||
        parameters[1] != CDS_GOAL_SIZE)
        return false;
    for (uint8_t i = roster->count; i; i--, servo++)
        if (!servo->speed_known && !servo->held && servo->fastest < CDS_VALUE_MAX)
            return false;
    return true;
}

static void learn_parts(struct cds_roster *roster, const uint8_t *bytes)
{
    struct cds_roster_servo *servo;
    struct part part;

    if (are_old_news(roster, bytes))
        return;
    if (is_torque_off(bytes) && bytes[CDS_AT_ID] == CDS_BROADCAST_ID) { // is not to take long
        for (uint8_t k = 0; k < roster->count; k++)
            roster->servos[k].torque = false;
        return;
    }
    for (uint8_t i = 0; part_of(bytes, i, &part); i++) {
        for (uint8_t k = 0; part.id == CDS_BROADCAST_ID && k < roster->count; k++)
            learn_written(&roster->servos[k], part.address, part.data, part.length);
        servo = part.id == CDS_BROADCAST_ID ? NULL : cds_roster_find(roster, part.id);
        if (servo)
            learn_written(servo, part.address, part.data, part.length);
    }
}

/* A write whose reply was lost may have been carried out all the same. Of two possibilities, the
 * careful one: the longer delay; that torque is on; that a write is registered. */
static void doubt(struct cds_roster_servo *servo, const uint8_t *bytes)
{
    struct part part;
    const uint8_t *it;

    if (!part_of(bytes, 0, &part))
        return;
    it = byte_of(CDS_REG_RETURN_DELAY, part.address, part.data, part.length);
    if (it && servo->return_delay != CDS_ROSTER_UNKNOWN && *it > servo->return_delay)
        servo->return_delay = *it;
    it = byte_of(CDS_REG_TORQUE_ENABLE, part.address, part.data, part.length);
    if (it && *it)
        servo->torque = true;
    if (byte_of(CDS_REG_MOVING_SPEED, part.address, part.data, part.length))
        servo->speed_known = false;
}

static void act(struct cds_roster *roster, uint8_t id)
{
    for (uint8_t i = 0; i < roster->count; i++)
        if (id == CDS_BROADCAST_ID || roster->servos[i].id == id)
            roster->servos[i].armed = false;
}

/* The packet was carried out, as far as anybody can know. */
static void carried_out(struct cds_roster *roster, struct cds_roster_servo *servo,
                        const struct cds_bus_news *news)
{
    const uint8_t *bytes = news->request->packet.bytes;

    switch (news->instruction) {
    case CDS_WRITE:
    case CDS_SYNC_WRITE: learn_parts(roster, bytes); break;
    case CDS_ACTION: act(roster, bytes[CDS_AT_ID]); break;
    case CDS_REG_WRITE:
        if (servo)
            servo->armed = true;
        break;
    case CDS_READ:
        if (servo)
            learn_read(roster, servo, news->address, bytes, news->request->length);
        break;
    case CDS_RESET:
        for (uint8_t i = 0; bytes[CDS_AT_ID] == CDS_BROADCAST_ID && i < roster->count; i++)
            forget(&roster->servos[i]); // which of them is whose ID 1 now, nobody knows
        if (servo)
            learn_reset(roster, servo);
        break;
    default: break;
    }
}

static void ended(struct cds_roster *roster, struct cds_roster_servo *servo,
                  const struct cds_bus_news *news)
{
    bool due = news->request->reply_parameters != CDS_REPLY_NONE;
    uint16_t echo_errors = cds_link_count(&roster->bus->link.echo_errors);

    if (servo)
        servo->counters.echo_errors =
            (uint16_t)(servo->counters.echo_errors + (echo_errors - roster->echo_errors));
    roster->echo_errors = echo_errors;
    if (servo && due) {
        if (news->result == CDS_OK)
            answered(roster, servo);
        else if (news->result == CDS_TIMEOUT)
            not_answered(roster, servo);
        else
            servo->counters.corrupt++;
    }
    if (news->result == CDS_OK && !(news->error & CDS_ERRORS_OF_PACKET))
        carried_out(roster, servo, news);
    else if (servo && news->result != CDS_OK && news->instruction == CDS_REG_WRITE)
        servo->armed = true;
    else if (servo && news->result != CDS_OK && news->instruction == CDS_WRITE)
        doubt(servo, news->request->packet.bytes);
}

static __attribute__((noinline)) void take_news(struct cds_roster *roster,
                                                const struct cds_bus_news *news)
{
    struct cds_roster_servo *servo =
        news->id == CDS_BROADCAST_ID ? NULL : cds_roster_find(roster, news->id);

    note_alarms(roster, servo, news->error);
    if (news->event == CDS_BUS_ENDED)
        ended(roster, servo, news);
    else if (servo && news->event == CDS_BUS_LATE)
        servo->counters.late++;
    else if (servo && news->event == CDS_BUS_EXTRA)
        servo->counters.extra++;
    else if (servo)
        servo->counters.foreign++;
}

/* Who has asked for nobody does not pay: short, so that few registers are saved. */
static void on_news(struct cds_bus_observer *observer, const struct cds_bus_news *news)
{
    struct cds_roster *roster = of(observer);

    if (roster->count)
        take_news(roster, news);
    else
        roster->alarms |= news->error;
}

/* ---- what the caller asks for ---- */

static bool are_distinct(const struct cds_roster_servo *servos, uint8_t count)
{
    for (uint8_t i = 0; i < count; i++) {
        if (servos[i].id > CDS_ID_MAX)
            return false;
        for (uint8_t k = 0; k < i; k++)
            if (servos[k].id == servos[i].id)
                return false;
    }
    return true;
}

/* A servo of which nothing is known. */
static void meet(struct cds_roster_servo *servo, uint8_t id)
{
    *servo = (struct cds_roster_servo){
        .highest = CDS_VALUE_MAX,
        .fastest = CDS_VALUE_MAX,
        .id = id,
        .return_delay = CDS_ROSTER_UNKNOWN,
        .status_return_level = LEVEL_ALL,
    };
}

enum cds_result cds_roster_begin(struct cds_roster *roster, struct cds_bus *bus,
                                 struct cds_roster_servo *servos, uint8_t count)
{
    if (bus->byte_time_us == 0 || count > CDS_ID_MAX + 1 || !are_distinct(servos, count))
        return CDS_BAD_ARGUMENT;
    for (uint8_t i = 0; i < count; i++)
        meet(&servos[i], servos[i].id);
    *roster = (struct cds_roster){
        .observer = {.admit = admit, .admit_block = admit_block, .on_news = on_news},
        .bus = bus,
        .servos = servos,
        .echo_errors = cds_link_count(&bus->link.echo_errors),
        .count = count,
    };
    bus->observer = &roster->observer;
    return CDS_OK;
}

enum cds_result cds_roster_add(struct cds_roster *roster, uint8_t id, uint8_t room)
{
    if (id > CDS_ID_MAX || cds_roster_find(roster, id))
        return CDS_BAD_ARGUMENT;
    if (roster->count >= room)
        return CDS_NO_ROOM;
    if (roster->count == 0)
        roster->echo_errors = cds_link_count(&roster->bus->link.echo_errors);
    meet(&roster->servos[roster->count++], id);
    note_change(roster, &roster->servos[roster->count - 1]);
    return CDS_OK;
}

enum cds_result cds_roster_set_limits(struct cds_roster *roster, struct cds_roster_servo *servo,
                                      uint16_t lowest, uint16_t highest, uint16_t fastest)
{
    if (lowest > highest || highest > CDS_VALUE_MAX || fastest > CDS_VALUE_MAX)
        return CDS_BAD_ARGUMENT;
    if (fastest < servo->fastest)
        servo->speed_known = false;
    servo->lowest = lowest;
    servo->highest = highest;
    servo->fastest = fastest;
    note_change(roster, servo);
    return CDS_OK;
}

uint8_t cds_roster_acknowledge(struct cds_roster *roster, struct cds_roster_servo *servo)
{
    uint8_t alarms = servo ? servo->alarms : roster->alarms;

    for (uint8_t i = 0; i < roster->count; i++)
        if (!servo || servo == &roster->servos[i])
            roster->servos[i].alarms = 0;
    roster->alarms = 0;
    for (uint8_t i = 0; servo && i < roster->count; i++)
        roster->alarms |= roster->servos[i].alarms;
    return alarms;
}

void cds_roster_hold(struct cds_roster *roster, struct cds_roster_servo *servo, uint8_t why)
{
    note_change(roster, servo);
    for (uint8_t i = 0; i < roster->count; i++)
        if (!servo || servo == &roster->servos[i])
            roster->servos[i].held |= why;
}

void cds_roster_release(struct cds_roster *roster, struct cds_roster_servo *servo)
{
    note_change(roster, servo);
    for (uint8_t i = 0; i < roster->count; i++)
        if (!servo || servo == &roster->servos[i])
            roster->servos[i].held = 0;
}
