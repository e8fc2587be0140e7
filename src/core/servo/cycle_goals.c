/* SPDX-License-Identifier: MIT */
/* The two packets of goals of a cycle: `front` is sent, `back` is filled; see cycle.h. Each has one
 * block for each servo: ID and goal. */
#include <string.h>

#include "cds55xx/control_table.h" // CDS_REG_GOAL_POSITION, CDS_VALUE_MAX
#include "compiler.h"              // OPTIMIZER_BARRIER(), NOINLINE
#include "servo/cycle_internal.h"
#include "servo/goal.h"         // cds_goal_put(), CDS_GOAL_SIZE
#include "wire/word_internal.h" // cds_word_at()

#define BLOCK_SIZE      (1u + CDS_GOAL_SIZE)     // ID, goal
#define BLOCKS_AT       (CDS_AT_PARAMETERS + 2u) // behind address and length
#define NO_GOAL         UINT8_MAX                // high byte of a position that is not set
#define LEFT_OUT        CDS_BROADCAST_ID         // ID in the block of a servo that is left out
#define NOT_FILLING     UINT8_MAX                // `filled`: no goal was set since the last commit
#define CHECKS_PER_POLL 8
#define WORK_PER_POLL   32 // of mend(): 1 for each block, 5 more for a block that is written

/* True while this packet is on the wire or waits for it. */
static NOINLINE bool is_being_sent(const struct cds_cycle *cycle, const uint8_t *packet)
{
    return cycle->goals.result == CDS_PENDING && cycle->goals.packet.bytes == packet;
}

ALWAYS_INLINE uint8_t *fast_block_of(uint8_t *packet, uint8_t index)
{
    return packet + BLOCKS_AT + (uint8_t)(index * BLOCK_SIZE);
}

/* NOCLONE: saves 100 bytes. */
static NOCLONE uint8_t *block_of(uint8_t *packet, uint8_t index)
{
    return fast_block_of(packet, index);
}

ALWAYS_INLINE uint8_t sum_of(const uint8_t *goal)
{
    return (uint8_t)(goal[0] + goal[1] + goal[2] + goal[3]);
}

/* As sum_of(), for what is called seldom. NOINLINE: saves 20 bytes. */
static NOINLINE uint8_t shared_sum_of(const uint8_t *goal)
{
    return sum_of(goal);
}

/* True if the servo is in the packet. The block of a servo that is left out has the ID LEFT_OUT, or
 * the ID of another servo: mend(). */
static bool is_own(const struct cds_cycle *cycle, uint8_t *packet, uint8_t index)
{
    return *block_of(packet, index) == cycle->ids[index];
}

bool cds_cycle_is_dropped(const struct cds_cycle *cycle, uint8_t index)
{
    return index < cycle->count && !is_own(cycle, cycle->front, index);
}

uint16_t cds_cycle_sent_goal(const struct cds_cycle *cycle, uint8_t index)
{
    const uint8_t *block = block_of(cycle->front, index);

    if (!cycle->is_committed || !is_own(cycle, cycle->front, index))
        return CDS_CYCLE_NO_GOAL;
    return cds_word_at(block + 1);
}

/* Writes `from` to a block of `packet`; the checksum of the packet follows. */
static NOINLINE void put_block(struct cds_cycle *cycle, uint8_t *packet, uint8_t *block,
                               const uint8_t *from)
{
    uint8_t *checksum = packet + cycle->goals.packet.size - 1;
    uint8_t difference = 0;

    for (uint8_t i = BLOCK_SIZE; i; i--) {
        difference = (uint8_t)(difference + *block - *from);
        *block++ = *from++;
    }
    *checksum = (uint8_t)(*checksum + difference);
}

static void leave_out(struct cds_cycle *cycle, uint8_t *packet, uint8_t index)
{
    uint8_t *block = block_of(packet, index);
    uint8_t *checksum = packet + cycle->goals.packet.size - 1;

    *checksum = (uint8_t)(*checksum + *block - LEFT_OUT);
    *block = LEFT_OUT;
    cycle->mended = 0;
    cycle->has_left_out = true;
}

/* ---- begin ---- */

void cds_cycle_build_goals(struct cds_cycle *cycle, uint16_t size)
{
    static const uint8_t none[CDS_GOAL_SIZE] = {NO_GOAL, NO_GOAL, NO_GOAL, NO_GOAL};
    const struct cds_bus_hooks *hooks = cycle->bus->hooks;
    struct cds_packet *packet = &cycle->goals.packet;

    packet->bytes = cycle->front;
    packet->capacity = size;
    cds_packet_sync_begin(packet, CDS_REG_GOAL_POSITION, CDS_GOAL_SIZE);
    for (uint8_t i = 0; i < cycle->count; i++)
        cds_packet_sync_add(packet, cycle->ids[i], none);
    cds_packet_end(packet);
    memcpy(cycle->back, cycle->front, size);
    cycle->filled = NOT_FILLING;
    cycle->checked = cycle->mended = cycle->count;
    cycle->empty_sum = (uint8_t)(~cycle->front[size - 1] - cycle->count * sum_of(none));
    if (hooks && hooks->changed_since)
        hooks->changed_since(hooks->context, &cycle->epoch); // changes so far concern no goal
}

/* ---- setting goals ---- */

/* Asks the permit whether the servo at `index` may be sent the goal in `block`. */
ALWAYS_INLINE uint8_t ask_permit(struct cds_cycle *cycle, uint8_t index, const uint8_t *block)
{
    const struct cds_bus_hooks *hooks = cycle->bus->hooks;
    uint8_t result;

    cycle->index_offset = (uint8_t)(cycle->index_offset + index);
    result = (uint8_t)hooks->permit_goal(hooks->context, *block, &cycle->index_offset, block + 1);
    cycle->index_offset = (uint8_t)(cycle->index_offset - index);
    return result;
}

static NOINLINE bool has_permit(const struct cds_cycle *cycle)
{
    return cycle->bus->hooks && cycle->bus->hooks->permit_goal;
}

static void begin_filling(struct cds_cycle *cycle)
{
    cycle->filled = cycle->skipped = 0;
    cycle->sum = cycle->empty_sum;
    cycle->has_left_out = false;
    cycle->has_permit = has_permit(cycle);
}

/* Asks the permit about the goal that was written to `block`. If the permit refuses it, the goal
 * does not count. */
static NOINLINE enum cds_result check_new(struct cds_cycle *cycle, uint8_t index, uint8_t *block)
{
    uint8_t result;

    *block = cycle->ids[index];
    result = ask_permit(cycle, index, block);
    if (result != CDS_OK) {
        cycle->sum = (uint8_t)(cycle->sum - shared_sum_of(block + 1));
        if (!cycle->is_committed) // the others need not wait for this servo
            leave_out(cycle, cycle->front, index);
    } else if (cycle->filled == index) {
        cycle->filled++;
    }
    return (enum cds_result)result;
}

/* Sets the goal of the servo at `filled`. */
static NOINLINE enum cds_result append_goal(struct cds_cycle *cycle, uint8_t index,
                                            uint16_t position, uint16_t speed)
{
    uint8_t *block = fast_block_of(cycle->back, index);

    cds_goal_put(block + 1, position, speed);
    cycle->sum = (uint8_t)(cycle->sum + sum_of(block + 1));
    if (cycle->has_permit)
        return check_new(cycle, index, block);
    if (cycle->has_other_ids)
        *block = cycle->ids[index];
    cycle->filled = (uint8_t)(index + 1u);
    return CDS_OK;
}

/* Sets the goal of a servo before `filled`, which may have one already. */
static enum cds_result replace_goal(struct cds_cycle *cycle, uint8_t index, uint16_t position,
                                    uint16_t speed)
{
    uint8_t *block = block_of(cycle->back, index);
    uint8_t old[BLOCK_SIZE];
    enum cds_result result = CDS_OK;

    memcpy(old, block, sizeof old);
    cds_goal_put(block + 1, position, speed);
    cycle->sum = (uint8_t)(cycle->sum + shared_sum_of(block + 1));
    if (cycle->has_permit)
        result = check_new(cycle, index, block);
    else
        *block = cycle->ids[index];
    if (result != CDS_OK)
        memcpy(block, old, sizeof old);
    else if (old[2] == NO_GOAL)
        cycle->skipped--;
    else
        cycle->sum = (uint8_t)(cycle->sum - shared_sum_of(old + 1));
    return result;
}

/* The first goal since a commit, or one that is not set in the order of the servos. */
static NOINLINE enum cds_result set_out_of_order(struct cds_cycle *cycle, uint8_t index,
                                                 uint16_t position, uint16_t speed)
{
    if (cycle->filled == NOT_FILLING) {
        if (is_being_sent(cycle, cycle->back))
            return CDS_BUSY;
        begin_filling(cycle);
    }
    if (index < cycle->filled)
        return replace_goal(cycle, index, position, speed);
    for (; cycle->filled != index; cycle->filled++, cycle->skipped++)
        block_of(cycle->back, cycle->filled)[2] = NO_GOAL;
    return append_goal(cycle, index, position, speed);
}

enum cds_result cds_cycle_goal(struct cds_cycle *cycle, uint8_t index, uint16_t position,
                               uint16_t speed)
{
    uint8_t high = (uint8_t)(position >> 8);

    OPTIMIZER_BARRIER(high); // or gcc compares words: saves 4 cycles
    high = (uint8_t)(high | speed >> 8);
    if (index >= cycle->count || high > CDS_VALUE_MAX >> 8) // all bits of CDS_VALUE_MAX are 1
        return CDS_BAD_ARGUMENT;
    if (index != cycle->filled)
        return set_out_of_order(cycle, index, position, speed);
    return append_goal(cycle, index, position, speed);
}

/* True if the goal of servo `index` was set since the last commit. */
static NOINLINE bool is_set(const struct cds_cycle *cycle, uint8_t index)
{
    return cycle->filled != NOT_FILLING && index < cycle->filled &&
           block_of(cycle->back, index)[2] != NO_GOAL;
}

/* ---- servos that are left out ---- */

/* Makes `front` valid again after servos were left out; the packet keeps its size. The block of
 * each such servo becomes a copy of the first block of a servo that is in the packet: two equal
 * blocks set the same goal twice. Begins at block `mended`, and stops after `work` units. */
static void mend(struct cds_cycle *cycle, int16_t work)
{
    uint8_t i = cycle->mended, count = cycle->count;
    uint8_t *block, *whole = cycle->front + BLOCKS_AT;
    const uint8_t *id = cycle->ids, *end = id + count;

    for (; *whole != *id; whole += BLOCK_SIZE)
        if (++id == end) { // cds_cycle_goals_are_empty()
            leave_out(cycle, cycle->front, 0);
            cycle->mended = count;
            return;
        }
    block = block_of(cycle->front, i);
    for (id = cycle->ids + i; i < count && work > 0; i++, work--, block += BLOCK_SIZE) {
        if (*block == *id++)
            continue;
        work -= 5;
        put_block(cycle, cycle->front, block, whole);
    }
    cycle->mended = i;
}

bool cds_cycle_goals_are_empty(const struct cds_cycle *cycle)
{
    return cycle->front[BLOCKS_AT] == LEFT_OUT;
}

/* Checks the goals of `servos` servos, from servo `i` on, in `packet` again. Returns how many the
 * permit refused; they are left out of the packet. */
static NOINLINE uint8_t check_again(struct cds_cycle *cycle, uint8_t *packet, uint8_t i,
                                    uint8_t servos)
{
    const uint8_t *block = fast_block_of(packet, i);
    uint8_t refused = 0;

    for (; servos; servos--, i++, block += BLOCK_SIZE) {
        OPTIMIZER_BARRIER(cycle); // or gcc keeps addresses of its fields: saves 12 bytes
        if (*block != cycle->ids[i] || block[2] == NO_GOAL || ask_permit(cycle, i, block) == CDS_OK)
            continue;
        leave_out(cycle, packet, i);
        refused++;
    }
    return refused;
}

/* Returns the index of the next servo from `i` on that the last change concerns, or the count. */
static NOINLINE uint8_t next_changed(const struct cds_cycle *cycle, uint8_t i)
{
    uint8_t changed = cycle->changed_id;

    if (changed != CDS_BROADCAST_ID)
        while (i < cycle->count && cycle->ids[i] != changed)
            i++;
    return i;
}

/* Checks the goals again that the last change concerns, in both packets, as many as a poll may. */
static void check_some(struct cds_cycle *cycle)
{
    uint8_t i = next_changed(cycle, cycle->checked), left = (uint8_t)(cycle->count - i);
    bool is_filling = cycle->filled != NOT_FILLING;
    uint8_t servos = is_filling ? CHECKS_PER_POLL / 2 : CHECKS_PER_POLL;

    if (cycle->changed_id != CDS_BROADCAST_ID)
        servos = 1;
    if (servos > left)
        servos = left;
    cycle->checked = next_changed(cycle, (uint8_t)(i + servos));
    cycle->counters.dropped =
        (uint16_t)(cycle->counters.dropped + check_again(cycle, cycle->front, i, servos));
    if (is_filling)
        check_again(cycle, cycle->back, i, servos);
}

/* Asks which servos a change concerns. A round of checks under way begins again. */
static void note_changes(struct cds_cycle *cycle)
{
    const struct cds_bus_hooks *hooks = cycle->bus->hooks;
    bool is_first = cycle->epoch == 0; // goals may have been set before the hooks were attached
    uint8_t id = hooks->changed_since(hooks->context, &cycle->epoch);

    if (id == CDS_NO_ID && !is_first)
        return;
    if (is_first || (cycle->is_checking && cycle->changed_id != id))
        id = CDS_BROADCAST_ID;
    cycle->changed_id = id;
    cycle->checked = 0;
    cycle->is_checking = true;
}

/* Goals that wait for the bus are taken back and sent again after the check. The cycle checks only
 * the goal of the servo that has changed; the bus would check each goal: 2 ms for 18 servos. */
static NOINLINE void go_on_checking(struct cds_cycle *cycle)
{
    if (is_being_sent(cycle, cycle->front)) {
        if (cds_bus_cancel(cycle->bus, &cycle->goals) != CDS_OK)
            return; // they are on the wire
        cycle->sends_again = true;
    }
    if (!has_permit(cycle))
        cycle->checked = cycle->count;
    else if (cycle->checked != cycle->count)
        check_some(cycle);
    else
        mend(cycle, WORK_PER_POLL);
    cycle->is_checking = cycle->checked != cycle->count || cycle->mended != cycle->count;
}

bool cds_cycle_check_goals(struct cds_cycle *cycle)
{
    const struct cds_bus_hooks *hooks = cycle->bus->hooks;

    if (hooks && hooks->changed_since)
        note_changes(cycle);
    if (cycle->is_checking)
        go_on_checking(cycle);
    return !cycle->is_checking;
}

/* ---- commit ---- */

/* Before the first commit: leaves out the servos whose goal was not set. */
static void leave_out_unset(struct cds_cycle *cycle)
{
    for (uint8_t i = 0; i < cycle->count; i++)
        if (!is_set(cycle, i)) {
            leave_out(cycle, cycle->front, i);
            cycle->has_other_ids = true;
        }
}

/* Copies the blocks that were not set, from block `i` on, to the packet in back. True: a servo is
 * left out. */
static bool copy_blocks(struct cds_cycle *cycle, uint8_t i)
{
    uint8_t *block = block_of(cycle->back, i), *old = block_of(cycle->front, i);
    const uint8_t *id = cycle->ids + i;
    uint8_t sum = cycle->sum;
    bool has_holes = false;

    for (; i < cycle->count; i++, block += BLOCK_SIZE, old += BLOCK_SIZE, id++) {
        if (i >= cycle->filled || block[2] == NO_GOAL) {
            memcpy(block, old, BLOCK_SIZE);
            sum = (uint8_t)(sum + sum_of(block + 1));
        }
        if (*block == *id)
            continue;
        has_holes = true;
        sum = (uint8_t)(sum + *block - *id);
        if (*old == *id)
            cycle->counters.dropped++;
    }
    cycle->sum = sum;
    return has_holes;
}

void cds_cycle_commit(struct cds_cycle *cycle)
{
    uint8_t *filled = cycle->back;
    bool has_holes;

    if (cycle->filled == NOT_FILLING)
        return;
    if (!cycle->is_committed)
        leave_out_unset(cycle);
    has_holes = copy_blocks(cycle, cycle->skipped || cycle->has_left_out ? 0 : cycle->filled);
    filled[cycle->goals.packet.size - 1] = (uint8_t)~cycle->sum;
    if (!cycle->is_committed)
        cycle->next_us = cds_port_now_us(); // no period before the first commit is missed
    cycle->back = cycle->front;
    cycle->front = filled;
    cycle->filled = NOT_FILLING;
    cycle->is_committed = true;
    if (has_holes) {
        cycle->mended = 0;
        mend(cycle, INT16_MAX);
    }
}
