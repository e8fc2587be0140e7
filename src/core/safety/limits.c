/* SPDX-License-Identifier: MIT */
/* Soft limits of one servo; see limits.h. Manual: 3.1, 0x06 to 0x09, 0x18, 0x1E to 0x21; R10, R16.
 */
#include "safety/limits.h"

#include "cds55xx/control_table.h"  // CDS_REG_*, CDS_VALUE_MAX
#include "cds55xx/packet.h"         // CDS_AT_*
#include "compiler.h"               // NOINLINE
#include "safety/servos_internal.h" // cds_servos_note_change()
#include "wire/word_internal.h"     // cds_word_at()

/* ---- what a packet writes ---- */

/* True if any of the registers `first` to `last` is written. A macro saves 8 bytes a use against a
 * function that returns a bool. */
#define TOUCHES(first, last) (address <= (last) && end > (first))

NOINLINE uint8_t cds_written_sets(uint8_t address, uint8_t length)
{
    uint8_t end = (uint8_t)(address + length), sets = 0; // `end`: the register after the last

    if (length == 0 || address >= CDS_TABLE_SIZE)
        return 0;
    if (end < address) // longer than any servo takes
        return UINT8_MAX;
    if (address <= CDS_REG_STATUS_RETURN_LEVEL) {
        if (TOUCHES(CDS_REG_ID, CDS_REG_ID))
            sets |= CDS_SETS_ID;
        if (TOUCHES(CDS_REG_BAUD_RATE, CDS_REG_RETURN_DELAY) || end > CDS_REG_STATUS_RETURN_LEVEL)
            sets |= CDS_SETS_REPLY;
        if (TOUCHES(CDS_REG_CW_ANGLE_LIMIT, CDS_REG_CCW_ANGLE_LIMIT + 1))
            sets |= CDS_SETS_MODE;
    }
    if (TOUCHES(CDS_REG_TORQUE_ENABLE, CDS_REG_TORQUE_ENABLE))
        sets |= CDS_SETS_TORQUE;
    if (end <= CDS_REG_CW_COMPLIANCE_MARGIN)
        return sets;
    if (TOUCHES(CDS_REG_CW_COMPLIANCE_MARGIN, CDS_REG_CCW_PROPORTION) ||
        TOUCHES(CDS_REG_PUNCH, CDS_REG_PUNCH + 1))
        sets |= CDS_SETS_GAIN;
    if (TOUCHES(CDS_REG_GOAL_POSITION, CDS_REG_GOAL_POSITION + 1))
        sets |= CDS_SETS_GOAL;
    if (TOUCHES(CDS_REG_MOVING_SPEED, CDS_REG_MOVING_SPEED + 1))
        sets |= CDS_SETS_SPEED;
    if (TOUCHES(CDS_REG_REGISTERED_INSTRUCTION, CDS_REG_REGISTERED_INSTRUCTION))
        sets |= CDS_SETS_REGISTERED;
    return sets;
}

NOINLINE bool cds_written_by(const uint8_t *bytes, uint8_t index, struct cds_written *written)
{
    uint8_t count = (uint8_t)(bytes[CDS_AT_LENGTH] - CDS_LENGTH_MIN), length, before;

    if (count < 2)
        return false;
    written->address = bytes[CDS_AT_PARAMETERS];
    written->id = bytes[CDS_AT_ID];
    written->data = bytes + CDS_AT_PARAMETERS + 1;
    if (bytes[CDS_AT_INSTRUCTION] == CDS_SYNC_WRITE) {
        length = bytes[CDS_AT_SYNC_LENGTH];
        before = (uint8_t)(index * (uint8_t)(length + 1u)); // a packet has fewer bytes than 256
        written->data = bytes + CDS_AT_PARAMETERS + 2 + before - length; // up to the block
        written->left = (uint8_t)(count - 2u - before);
    } else {
        length = (uint8_t)(count - 1u);
        written->left = 0;
    }
    written->length = length;
    written->sets = cds_written_sets(written->address, length);
    return true;
}

void cds_written_next(struct cds_written *written)
{
    written->left = (uint8_t)(written->left - written->length - 1);
    written->data += (uint8_t)(written->length + 1u);
    written->id = written->data[-1];
}

NOINLINE const uint8_t *cds_written_byte(const struct cds_written *written, uint8_t reg)
{
    uint8_t index = (uint8_t)(reg - written->address);

    return index < written->length && reg >= written->address ? written->data + index : NULL;
}

NOINLINE uint8_t cds_written_value(const struct cds_written *written, uint8_t reg,
                                   uint8_t otherwise)
{
    const uint8_t *byte = cds_written_byte(written, reg);

    return byte ? *byte : otherwise;
}

NOINLINE bool cds_written_is_torque_off(const uint8_t *bytes)
{
    return bytes[CDS_AT_INSTRUCTION] == CDS_WRITE && bytes[CDS_AT_LENGTH] == CDS_LENGTH_MIN + 2 &&
           bytes[CDS_AT_PARAMETERS] == CDS_REG_TORQUE_ENABLE && bytes[CDS_AT_PARAMETERS + 1] == 0;
}

/* ---- what may be written ---- */

#define HELD_POSITION (CDS_HELD_CW_SET | CDS_HELD_CCW_SET) // any of them: position mode
#define HELD_TURN     (CDS_HELD_CW_0 | CDS_HELD_CCW_0)     // both of them: endless turn
#define HELD_CW       (CDS_HELD_CW_SET | CDS_HELD_CW_0)
#define HELD_CCW      (CDS_HELD_CCW_SET | CDS_HELD_CCW_0)

enum mode { MODE_UNKNOWN, MODE_POSITION, MODE_TURN } __attribute__((packed));

ALWAYS_INLINE uint8_t mode_of(uint8_t held)
{
    if (held & HELD_POSITION)
        return MODE_POSITION;
    return (held & HELD_TURN) == HELD_TURN ? MODE_TURN : MODE_UNKNOWN;
}

ALWAYS_INLINE uint16_t magnitude_at(const uint8_t *data)
{
    return cds_word_at(data) & CDS_VALUE_MAX;
}

ALWAYS_INLINE bool has_goal_limit(const struct cds_servo_state *servo)
{
    return servo->lowest > 0 || servo->highest < CDS_VALUE_MAX;
}

/* Without an upper limit a goal above 1023 passes: the servo itself refuses it. */
ALWAYS_INLINE bool is_within(const struct cds_servo_state *servo, uint16_t goal)
{
    return goal >= servo->lowest && (goal <= servo->highest || servo->highest == CDS_VALUE_MAX);
}

/* Notes that the servo may hold a speed of 0 from now on: other answers of the permit depend on it.
 */
static NOINLINE void note_speed_0(struct cds_servos *servos, struct cds_servo_state *servo)
{
    if (servo->held & CDS_HELD_SPEED_0)
        return;
    servo->held |= CDS_HELD_SPEED_0;
    cds_servos_note_change(servos, servo->id);
}

/* In endless turn a servo ignores the goal, and stands still at speed 0. In position mode speed 0
 * means: as fast as the servo can. */
NOINLINE enum cds_result cds_limits_check_goal(struct cds_servos *servos,
                                               struct cds_servo_state *servo, const uint8_t *data)
{
    uint16_t magnitude;
    uint8_t mode;

    if (!servo->has_limits)
        return CDS_OK;
    magnitude = magnitude_at(data + 2);
    if (!is_within(servo, cds_word_at(data)) || magnitude > servo->fastest)
        return CDS_LIMIT;
    mode = mode_of(servo->held);
    if (magnitude)
        return mode == MODE_POSITION || !has_goal_limit(servo) ? CDS_OK : CDS_LIMIT;
    if (mode != MODE_TURN && servo->fastest < CDS_VALUE_MAX)
        return CDS_LIMIT;
    note_speed_0(servos, servo);
    return CDS_OK;
}

/* Returns the word of register `reg`, low byte first (R28), or NULL if a byte is not written.
 * NOINLINE: saves 40 bytes. */
static NOINLINE const uint8_t *word_of(const struct cds_written *written, uint8_t reg)
{
    uint8_t index = (uint8_t)(reg - written->address);

    return index + 1u < written->length && reg >= written->address ? written->data + index : NULL;
}

/* Returns the two bits of the angle limit at `reg` after the write, as CDS_HELD_CW_SET and
 * CDS_HELD_CW_0. `known`: the same bits before the write. */
static uint8_t angle_after(uint8_t known, const struct cds_written *written, uint8_t reg)
{
    const uint8_t *word = word_of(written, reg);

    if (word)
        return word[0] || word[1] ? CDS_HELD_CW_SET : CDS_HELD_CW_0;
    if (cds_written_value(written, reg, 0) || cds_written_value(written, (uint8_t)(reg + 1), 0))
        return CDS_HELD_CW_SET;
    known &= HELD_CW;
    return cds_written_byte(written, reg) || cds_written_byte(written, (uint8_t)(reg + 1))
               ? known & CDS_HELD_CW_0
               : known;
}

/* Returns the CDS_HELD_* bits after the write or READ. If one byte of the speed is missing, only
 * CDS_HELD_SPEED_0 is set for it. */
static NOINLINE uint8_t held_after(const struct cds_servo_state *servo,
                                   const struct cds_written *written)
{
    uint8_t held = servo->held, sets = written->sets;
    const uint8_t *word;

    if (sets & CDS_SETS_MODE)
        held = (uint8_t)((held & ~(HELD_CW | HELD_CCW)) |
                         angle_after(held, written, CDS_REG_CW_ANGLE_LIMIT) |
                         angle_after(held >> 2, written, CDS_REG_CCW_ANGLE_LIMIT) << 2);
    if (sets & CDS_SETS_GOAL) {
        held &= (uint8_t)~CDS_HELD_GOAL;
        word = word_of(written, CDS_REG_GOAL_POSITION);
        if (word && is_within(servo, cds_word_at(word)))
            held |= CDS_HELD_GOAL;
    }
    if (sets & CDS_SETS_SPEED) {
        held = (uint8_t)((held & ~CDS_HELD_SPEED) | CDS_HELD_SPEED_0);
        word = word_of(written, CDS_REG_MOVING_SPEED);
        if (word && magnitude_at(word) <= servo->fastest)
            held |= CDS_HELD_SPEED;
        if (word && magnitude_at(word))
            held &= (uint8_t)~CDS_HELD_SPEED_0;
    }
    return held;
}

/* When torque is switched on, or the mode changes to position mode, a servo goes to the goal in its
 * registers, at the speed in its registers. */
uint8_t cds_limits_check(struct cds_servos *servos, struct cds_servo_state *servo,
                         const struct cds_written *written)
{
    uint8_t sets = written->sets, before = servo->held, after, mode_before, mode;
    const uint8_t speed_is_0 = CDS_HELD_SPEED | CDS_HELD_SPEED_0;

    if (!servo->has_limits)
        return CDS_OK;
    after = held_after(servo, written);
    mode_before = mode_of(before);
    mode = mode_of(after);
    if (!cds_written_value(written, CDS_REG_TORQUE_ENABLE, 0))
        sets &= (uint8_t)~CDS_SETS_TORQUE; // from here on the bit means: torque is switched on
    if (sets & CDS_SETS_TORQUE &&
        (mode_before == MODE_UNKNOWN || !(before & CDS_HELD_GOAL) || !(before & CDS_HELD_SPEED)))
        return CDS_LIMIT; // mode, goal or speed was not read
    if (has_goal_limit(servo)) {
        if (!(after & CDS_HELD_GOAL) && (sets & (CDS_SETS_TORQUE | CDS_SETS_GOAL) ||
                                         (sets & CDS_SETS_MODE && mode_before != MODE_POSITION)))
            return CDS_LIMIT;
        if (mode != MODE_POSITION &&
            (sets & (CDS_SETS_TORQUE | CDS_SETS_MODE) ||
             (sets & CDS_SETS_SPEED && (after & speed_is_0) != speed_is_0)))
            return CDS_LIMIT;
    }
    if (servo->fastest < CDS_VALUE_MAX) {
        if ((sets & (CDS_SETS_GOAL | CDS_SETS_SPEED)) == CDS_SETS_GOAL)
            return CDS_LIMIT; // the speed of the move is not certain
        if ((sets & (CDS_SETS_TORQUE | CDS_SETS_SPEED) ||
             (sets & CDS_SETS_MODE && (mode == MODE_UNKNOWN || mode != mode_before))) &&
            (!(after & CDS_HELD_SPEED) || (after & CDS_HELD_SPEED_0 && mode != MODE_TURN)))
            return CDS_LIMIT;
    }
    if (sets & CDS_SETS_SPEED && (after & speed_is_0) == speed_is_0)
        note_speed_0(servos, servo);
    return CDS_OK;
}

/* ---- what the servo holds ---- */

bool cds_limits_learn(struct cds_servo_state *servo, const struct cds_written *written,
                      uint8_t source)
{
    uint8_t before = servo->held, after = held_after(servo, written), changed = before ^ after;

    if (source != CDS_SOURCE_READ) { // only a READ makes goal and speed known
        if (source != CDS_SOURCE_ANSWERED)
            changed &= HELD_CW | HELD_CCW;
        changed &= (uint8_t) ~(CDS_HELD_GOAL | CDS_HELD_SPEED);
        after = before ^ changed;
        if (changed & HELD_CW && (source != CDS_SOURCE_ANSWERED || !(before & HELD_CW)))
            after &= (uint8_t)~HELD_CW;
        if (changed & HELD_CCW && (source != CDS_SOURCE_ANSWERED || !(before & HELD_CCW)))
            after &= (uint8_t)~HELD_CCW;
        changed = before ^ after;
    }
    if (changed & (HELD_CW | HELD_CCW))
        servo->is_registered = false; // its registered write was checked in the other mode
    servo->held = after;
    return changed;
}
