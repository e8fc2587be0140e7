/* The two packets of goals of a cycle: goals are set in one while the other is sent; see cycle.h.
 */
#include <string.h>

#include "cds55xx/control_table.h" // CDS_REG_GOAL_POSITION, CDS_VALUE_MAX
#include "compiler.h"              // OPTIMIZER_BARRIER(), NOINLINE
#include "servo/cycle_internal.h"
#include "servo/goal.h" // cds_goal_put(), CDS_GOAL_SIZE

#define BLOCK_SIZE       (1u + CDS_GOAL_SIZE)     // ID, goal
#define BLOCKS_AT        (CDS_AT_PARAMETERS + 2u) // behind address and length
#define NO_GOAL          UINT8_MAX                // high byte of a position that is not set
#define LEFT_OUT         CDS_BROADCAST_ID         // ID in the block of a servo that is left out
#define NOT_FILLING      UINT8_MAX                // `filled`: no goal was set since the last commit
#define CHECKS_PER_POLL  8                        // blocks
#define WRITTEN_PER_POLL 4                        // blocks

/* True while this packet is on the wire or waits for it. */
static bool is_being_sent(const struct cds_cycle *cycle, const uint8_t *packet)
{
    return cycle->goals.result == CDS_PENDING && cycle->goals.packet.bytes == packet;
}

static uint8_t *block_of(uint8_t *packet, uint8_t index)
{
    return packet + BLOCKS_AT + (uint8_t)(index * BLOCK_SIZE);
}

static uint8_t sum_of(const uint8_t *goal)
{
    return (uint8_t)(goal[0] + goal[1] + goal[2] + goal[3]);
}

/* The block of a servo that is left out has another ID. */
static bool is_own(const struct cds_cycle *cycle, uint8_t *packet, uint8_t index)
{
    return *block_of(packet, index) == cycle->ids[index];
}

bool cds_cycle_is_dropped(const struct cds_cycle *cycle, uint8_t index)
{
    return index < cycle->count && !is_own(cycle, cycle->front, index);
}

/* Writes the first `size` bytes of a block; the checksum of the packet follows. */
static NOINLINE void put_block(struct cds_cycle *cycle, uint8_t *packet, uint8_t index,
                               const uint8_t *from, uint8_t size)
{
    uint8_t *checksum = packet + cycle->goals.packet.size - 1, *block = block_of(packet, index);

    for (; size; size--) {
        *checksum = (uint8_t)(*checksum + *block - *from);
        *block++ = *from++;
    }
}

static void leave_out(struct cds_cycle *cycle, uint8_t *packet, uint8_t index)
{
    static const uint8_t id = LEFT_OUT;

    put_block(cycle, packet, index, &id, 1);
}

/* ---- begin ---- */

/* The servo whose answers of the permit have changed since the last call, CDS_BROADCAST_ID: more
 * than one, or CDS_NO_ID: none. */
static uint8_t changed_id(struct cds_cycle *cycle)
{
    const struct cds_bus_hooks *hooks = cycle->bus->hooks;

    return hooks && hooks->changed_since ? hooks->changed_since(hooks->context, &cycle->epoch)
                                         : CDS_NO_ID;
}

void cds_cycle_build_goals(struct cds_cycle *cycle, uint16_t size)
{
    static const uint8_t none[CDS_GOAL_SIZE] = {NO_GOAL, NO_GOAL, NO_GOAL, NO_GOAL};
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
    changed_id(cycle); // what changed before concerns no goal
}

/* ---- setting goals ---- */

/* Asks the permit whether servo `index` may be sent `goal`. Before the first commit a servo that is
 * refused is left out, so that the others need not wait for it. */
static NOINLINE enum cds_result check_goal(struct cds_cycle *cycle, uint8_t index,
                                           const uint8_t *goal)
{
    const struct cds_bus_hooks *hooks = cycle->bus->hooks;
    enum cds_result result;

    if (!hooks || !hooks->permit_goal)
        return CDS_OK;
    cycle->index_offset = (uint8_t)(cycle->index_offset + index);
    result = hooks->permit_goal(hooks->context, cycle->ids[index], &cycle->index_offset, goal);
    cycle->index_offset = (uint8_t)(cycle->index_offset - index);
    if (result != CDS_OK && !cycle->is_committed)
        leave_out(cycle, cycle->front, index);
    return result;
}

static void begin_filling(struct cds_cycle *cycle)
{
    const struct cds_bus_hooks *hooks = cycle->bus->hooks;

    cycle->filled = cycle->skipped = 0;
    cycle->sum = cycle->empty_sum;
    cycle->has_left_out = false;
    cycle->has_permit = hooks && hooks->permit_goal;
}

/* The goal of the block at `filled` stands there, and `sum` counts it. */
static NOINLINE enum cds_result check_appended(struct cds_cycle *cycle, uint8_t index, uint8_t sum)
{
    uint8_t *block = block_of(cycle->back, index);
    enum cds_result result = check_goal(cycle, index, block + 1);

    if (result == CDS_OK) {
        *block = cycle->ids[index];
        cycle->sum = sum;
        cycle->filled = (uint8_t)(index + 1u);
    }
    return result;
}

/* Sets the goal of the servo at `filled`. */
static NOINLINE enum cds_result append_goal(struct cds_cycle *cycle, uint8_t index,
                                            uint16_t position, uint16_t speed)
{
    uint8_t *goal = block_of(cycle->back, index) + 1;
    uint8_t sum = cycle->sum;

    cds_goal_put(goal, position, speed);
    sum = (uint8_t)(sum + sum_of(goal));
    if (cycle->has_permit)
        return check_appended(cycle, index, sum);
    cycle->sum = sum;
    cycle->filled = (uint8_t)(index + 1u);
    return CDS_OK;
}

/* Sets the goal of a servo before `filled`, which may have one already. */
static enum cds_result replace_goal(struct cds_cycle *cycle, uint8_t index, uint16_t position,
                                    uint16_t speed)
{
    uint8_t *block = block_of(cycle->back, index);
    uint8_t goal[CDS_GOAL_SIZE];
    enum cds_result result;

    cds_goal_put(goal, position, speed);
    result = check_goal(cycle, index, goal);
    if (result != CDS_OK)
        return result;
    if (block[2] == NO_GOAL)
        cycle->skipped--;
    else
        cycle->sum = (uint8_t)(cycle->sum - sum_of(block + 1));
    cycle->sum = (uint8_t)(cycle->sum + sum_of(goal));
    *block = cycle->ids[index];
    memcpy(block + 1, goal, sizeof goal);
    return CDS_OK;
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
static bool is_set(const struct cds_cycle *cycle, uint8_t index)
{
    return cycle->filled != NOT_FILLING && index < cycle->filled &&
           block_of(cycle->back, index)[2] != NO_GOAL;
}

/* ---- servos that are left out ---- */

/* The packet keeps its size: each block of a servo that is left out becomes equal to the first
 * block of a servo that is not; of blocks with one ID the last counts (R22). Writes at most
 * `blocks`. */
static void mend(struct cds_cycle *cycle, uint8_t blocks)
{
    uint8_t whole = 0;

    while (whole < cycle->count && !is_own(cycle, cycle->front, whole))
        whole++;
    if (whole == cycle->count) { // is_empty()
        leave_out(cycle, cycle->front, 0);
        cycle->mended = cycle->count;
    }
    for (; cycle->mended < cycle->count; cycle->mended++) {
        if (is_own(cycle, cycle->front, cycle->mended))
            continue;
        if (blocks-- == 0)
            return;
        put_block(cycle, cycle->front, cycle->mended, block_of(cycle->front, whole), BLOCK_SIZE);
    }
}

bool cds_cycle_goals_are_empty(const struct cds_cycle *cycle)
{
    return *block_of(cycle->front, 0) == LEFT_OUT;
}

/* Checks the goal of servo `index` in `packet` again. True: the servo is left out from now on. */
static bool drop(struct cds_cycle *cycle, uint8_t *packet, uint8_t index)
{
    const uint8_t *goal = block_of(packet, index) + 1;

    if (!is_own(cycle, packet, index) || goal[1] == NO_GOAL ||
        check_goal(cycle, index, goal) == CDS_OK)
        return false;
    leave_out(cycle, packet, index);
    return true;
}

/* Checks the goals again that the last change concerns, at most CHECKS_PER_POLL blocks. */
static void check_some(struct cds_cycle *cycle)
{
    uint8_t blocks = CHECKS_PER_POLL;

    for (; cycle->checked < cycle->count; cycle->checked++) {
        uint8_t i = cycle->checked;

        if (cycle->changed_id != CDS_BROADCAST_ID && cycle->changed_id != cycle->ids[i])
            continue;
        if (blocks < 2)
            return;
        blocks--;
        if (drop(cycle, cycle->front, i)) {
            cycle->counters.dropped++;
            cycle->mended = 0;
        }
        if (!is_set(cycle, i))
            continue;
        blocks--;
        if (drop(cycle, cycle->back, i))
            cycle->has_left_out = true;
    }
}

/* A round of checks under way begins anew. */
static void begin_checks(struct cds_cycle *cycle, uint8_t id)
{
    if (cycle->is_checking && cycle->changed_id != id)
        id = CDS_BROADCAST_ID;
    cycle->changed_id = id;
    cycle->checked = 0;
    cycle->is_checking = true;
}

static NOINLINE void go_on_checking(struct cds_cycle *cycle)
{
    if (is_being_sent(cycle, cycle->front))
        return; // the bus asks the permit before the packet leaves
    if (cycle->checked != cycle->count)
        check_some(cycle);
    else
        mend(cycle, WRITTEN_PER_POLL);
    cycle->is_checking = cycle->checked != cycle->count || cycle->mended != cycle->count;
}

bool cds_cycle_goals_are_good(struct cds_cycle *cycle)
{
    bool is_first = cycle->epoch == 0; // goals may have been set before the hooks were attached
    uint8_t id = changed_id(cycle);

    if (is_first && cycle->epoch)
        id = CDS_BROADCAST_ID;
    if (id != CDS_NO_ID)
        begin_checks(cycle, id);
    if (!cycle->is_checking)
        return true;
    go_on_checking(cycle);
    return false;
}

/* ---- commit ---- */

/* Each servo has a goal, or is left out. */
static bool have_goals(const struct cds_cycle *cycle)
{
    for (uint8_t i = 0; i < cycle->count; i++)
        if (!is_set(cycle, i) && is_own(cycle, cycle->front, i))
            return false;
    return true;
}

/* Copies the blocks that were not set, from block `i` on, to the packet in back. True: a servo is
 * left out. */
static bool copy_blocks(struct cds_cycle *cycle, uint8_t i)
{
    bool has_holes = false;

    for (; i < cycle->count; i++) {
        uint8_t *block = block_of(cycle->back, i), *old = block_of(cycle->front, i);
        uint8_t id = cycle->ids[i];

        if (!is_set(cycle, i)) {
            memcpy(block, old, BLOCK_SIZE);
            cycle->sum = (uint8_t)(cycle->sum + sum_of(block + 1));
        }
        if (*block == id)
            continue;
        has_holes = true;
        cycle->sum = (uint8_t)(cycle->sum + *block - id);
        if (*old == id)
            cycle->counters.dropped++;
    }
    return has_holes;
}

enum cds_result cds_cycle_commit(struct cds_cycle *cycle)
{
    uint8_t *filled = cycle->back;
    bool has_holes;

    if (cycle->filled == NOT_FILLING)
        return CDS_OK;
    if (!cycle->is_committed && !have_goals(cycle))
        return CDS_BAD_ARGUMENT;
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
        mend(cycle, UINT8_MAX);
    }
    return CDS_OK;
}
