/* Goals out, feedback in, at a fixed rate; see cycle.h. */
#include "cds55xx/cycle.h"

#include <string.h>

#include "bus/bus_internal.h"      // cds_bus_submit_checked(), cds_was_not_sent()
#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX
#include "compiler.h"              // OPTIMIZER_BARRIER(), NOINLINE
#include "servo/goal.h"            // cds_goal_put(), CDS_GOAL_SIZE

#define BLOCK_SIZE      (1u + CDS_GOAL_SIZE)     // ID, goal
#define BLOCKS_AT       (CDS_AT_PARAMETERS + 2u) // behind address and length
#define NO_GOAL         UINT8_MAX                // high byte of a position that is not set
#define LEFT_OUT        CDS_BROADCAST_ID         // ID in the block of a servo that is left out
#define NOT_FILLING     UINT8_MAX                // `filled`: no goal was set since the last commit
#define BLOCKS_PER_POLL 8                        // checked, or written, in one poll
#define READ_BYTES      (CDS_PACKET_SIZE(2) + CDS_PACKET_SIZE(CDS_FEEDBACK_SIZE))
#define SUBMIT_US       20          // from reading the clock to the first start bit, at 16 MHz
#define CATCH_UP        32          // periods passed over in one poll, however late it is
#define HALVE_AT_US     (1ul << 30) // both times of the utilisation, so that neither wraps

static NOINLINE void count(uint32_t *counter)
{
    ++*counter;
}

static NOINLINE void add(uint32_t *sum_us, uint16_t us)
{
    *sum_us += us;
}

static bool is_on_its_way(const struct cds_cycle *cycle)
{
    return cycle->goals.result == CDS_PENDING || cycle->read.result == CDS_PENDING;
}

/* True while this packet is on the wire or waits for it. */
static bool is_being_sent(const struct cds_cycle *cycle, const uint8_t *packet)
{
    return cycle->goals.result == CDS_PENDING && cycle->goals.packet.bytes == packet;
}

/* ---- blocks of a packet ---- */

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

/* True if there is no servo to send the goals in front to. */
static bool is_empty(struct cds_cycle *cycle)
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

/* Checks the goals again that the last change concerns, at most BLOCKS_PER_POLL blocks. */
static void check_some(struct cds_cycle *cycle)
{
    uint8_t blocks = BLOCKS_PER_POLL;

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

static bool is_checked(const struct cds_cycle *cycle)
{
    return cycle->checked == cycle->count && cycle->mended == cycle->count;
}

/* A round of checks under way begins anew. */
static void note_changes(struct cds_cycle *cycle)
{
    const struct cds_bus_hooks *hooks = cycle->bus->hooks;
    bool is_first = cycle->epoch == 0;
    uint8_t id;

    if (!hooks || !hooks->changed_since)
        return;
    id = hooks->changed_since(hooks->context, &cycle->epoch);
    if (id == CDS_NO_ID && !is_first)
        return;
    if (is_first || (cycle->checked != cycle->count && cycle->changed_id != id))
        id = CDS_BROADCAST_ID;
    cycle->changed_id = id;
    cycle->checked = 0;
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

/* ---- begin ---- */

/* The permit refuses the goals when their turn has come. cds_cycle_poll() sends them again: the bus
 * is not called from its own poll. */
static void goals_ended(struct cds_request *request)
{
    struct cds_cycle *cycle = (struct cds_cycle *)request->context;

    cycle->is_refused = request->result == CDS_INHIBITED || request->result == CDS_LIMIT;
    if (request->result != CDS_OK && !cycle->is_refused)
        count(&cycle->counters.unsent);
}

/* Both packets, whole, with goals that are not set yet. */
static void build_goals(struct cds_cycle *cycle, uint16_t size)
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
    cycle->empty_sum = (uint8_t)(~cycle->front[size - 1] - cycle->count * sum_of(none));
}

static void build_read(struct cds_cycle *cycle)
{
    struct cds_request *read = &cycle->read;

    read->packet.bytes = cycle->read_packet;
    read->packet.capacity = sizeof cycle->read_packet;
    read->reply = cycle->reply;
    read->reply_capacity = read->reply_parameters = CDS_FEEDBACK_SIZE;
    read->no_retry = true;
    cds_packet_read(&read->packet, cycle->ids[0], CDS_REG_PRESENT_POSITION, CDS_FEEDBACK_SIZE);
}

static bool are_ids(const uint8_t *ids, uint8_t count)
{
    for (; count; count--)
        if (*ids++ > CDS_ID_MAX)
            return false;
    return true;
}

enum cds_result cds_cycle_begin(struct cds_cycle *cycle, const struct cds_cycle_config *config)
{
    struct cds_bus *bus = config->bus;
    uint16_t size = (uint16_t)CDS_SYNC_WRITE_SIZE((uint16_t)config->count, CDS_GOAL_SIZE);
    uint32_t goals_us = (uint32_t)size * bus->byte_time_us;

    if (is_on_its_way(cycle))
        return CDS_BUSY;
    if (bus->state == CDS_BUS_CLOSED || config->count == 0 ||
        config->count > CDS_CYCLE_SERVOS_MAX || !are_ids(config->ids, config->count) ||
        goals_us + CDS_REPLY_MARGIN_US > config->period_us)
        return CDS_BAD_ARGUMENT;
    *cycle = (struct cds_cycle){.bus = bus,
                                .ids = config->ids,
                                .feedback = config->feedback,
                                .front = config->packets,
                                .back = config->packets + size,
                                .count = config->count,
                                .filled = NOT_FILLING,
                                .period_us = config->period_us,
                                .goals_us = (uint16_t)goals_us,
                                .goals = {.reply_parameters = CDS_REPLY_NONE,
                                          .priority = CDS_PRIORITY_HIGH,
                                          .on_end = goals_ended,
                                          .context = cycle}};
    cycle->latest_us = (uint16_t)(config->period_us - cycle->goals_us - CDS_REPLY_MARGIN_US);
    cycle->next_us = cds_port_now_us();
    cycle->checked = cycle->mended = cycle->count;
    build_goals(cycle, size);
    build_read(cycle);
    return CDS_OK;
}

/* ---- goals, period after period ---- */

/* Time until the next period begins; 0: it is due. */
static NOINLINE uint16_t remaining_us(const struct cds_cycle *cycle, uint32_t now_us)
{
    int32_t us = (int32_t)(cycle->next_us - now_us);

    return us > 0 ? (uint16_t)us : 0;
}

static NOINLINE void pass_period(struct cds_cycle *cycle)
{
    add(&cycle->next_us, cycle->period_us);
    add(&cycle->elapsed_us, cycle->period_us);
    if (cycle->elapsed_us & HALVE_AT_US) {
        cycle->elapsed_us >>= 1;
        cycle->wire_us >>= 1;
    }
}

/* False: the bus did not take them, or earlier goals are still on their way. */
static NOINLINE bool send_goals(struct cds_cycle *cycle)
{
    const struct cds_bus_hooks *hooks = cycle->bus->hooks;
    struct cds_request *request = &cycle->goals;
    uint16_t epoch = hooks && hooks->changed_since ? cycle->epoch : 0;

    if (request->result == CDS_PENDING)
        return false;
    request->packet.bytes = cycle->front;
    return cds_bus_submit_checked(cycle->bus, request, epoch) == CDS_OK;
}

/* The next period has begun, or more than one. */
static void begin_period(struct cds_cycle *cycle, uint32_t now_us)
{
    int32_t late_us = (int32_t)(now_us - cycle->next_us);

    for (uint8_t i = 0; late_us > (int32_t)cycle->latest_us && i < CATCH_UP; i++) {
        if (cycle->is_committed)
            count(&cycle->counters.missed);
        pass_period(cycle);
        late_us -= cycle->period_us;
    }
    if (late_us < 0 || late_us > (int32_t)cycle->latest_us)
        return;
    if (cycle->is_committed) {
        if (is_empty(cycle))
            count(&cycle->counters.unsent);
        else if (send_goals(cycle))
            add(&cycle->wire_us, cycle->goals_us);
        else
            return; // the next poll tries again
        count(&cycle->counters.periods);
    }
    cycle->is_yielding = false;
    pass_period(cycle);
}

/* The goals were refused on the bus: now without the servo that was refused, if they do not hold up
 * those of the next period. */
static void send_again(struct cds_cycle *cycle, uint32_t now_us)
{
    cycle->is_refused = false;
    if (remaining_us(cycle, now_us) < cycle->period_us - cycle->latest_us || is_empty(cycle) ||
        !send_goals(cycle))
        count(&cycle->counters.unsent);
}

/* ---- feedback ---- */

static NOINLINE void next_turn(struct cds_cycle *cycle)
{
    cycle->turn++;
    if (cycle->turn >= cycle->count)
        cycle->turn = 0;
}

/* Submits the READ of the servo whose turn it is. Only ID and checksum of its packet change. */
static enum cds_result submit_read(struct cds_cycle *cycle)
{
    uint8_t *bytes = cycle->read_packet, id = cycle->ids[cycle->turn];

    bytes[CDS_AT_PARAMETERS + 2] = (uint8_t)(bytes[CDS_AT_PARAMETERS + 2] + bytes[CDS_AT_ID] - id);
    bytes[CDS_AT_ID] = id;
    cycle->read.servo_index = (uint8_t)(cycle->turn + cycle->index_offset);
    return cds_bus_submit(cycle->bus, &cycle->read);
}

static void begin_read(struct cds_cycle *cycle, uint32_t now_us)
{
    const struct cds_bus *bus = cycle->bus;
    uint16_t us = (uint16_t)(READ_BYTES * bus->byte_time_us + bus->return_delay_us +
                             CDS_REPLY_MARGIN_US + SUBMIT_US);
    enum cds_result result;

    if (remaining_us(cycle, now_us) < us || cds_bus_is_resting(bus))
        return; // while the bus rests the READ would wait, and might hold up the next goals
    result = submit_read(cycle);
    if (result == CDS_NO_REPLY_DUE) { // the other servos must not wait for this one
        cycle->feedback[cycle->turn].result = CDS_NO_REPLY_DUE;
        next_turn(cycle);
    }
    if (result != CDS_OK)
        return;
    cycle->read_at_us = now_us;
    cycle->read_us = us;
    cycle->is_reading = true;
}

/* The READ has ended. Its reply came by its deadline, also if this poll is late. */
static NOINLINE void take_feedback(struct cds_cycle *cycle, uint32_t now_us)
{
    struct cds_feedback *feedback = &cycle->feedback[cycle->turn];
    uint32_t taken_us = now_us - cycle->read_at_us, between_us;
    bool was_known = feedback->known;

    if (taken_us > cycle->read_us)
        taken_us = cycle->read_us;
    now_us = cycle->read_at_us + taken_us;
    between_us = now_us - feedback->time_us;
    cycle->is_reading = false;
    next_turn(cycle);
    count(&cycle->counters.reads);
    if (cds_feedback_take(feedback, &cycle->read, now_us) == CDS_OK) {
        add(&cycle->wire_us, (uint16_t)(READ_BYTES * cycle->bus->byte_time_us));
        if (was_known && between_us > cycle->counters.oldest_us)
            cycle->counters.oldest_us = between_us;
    } else {
        if (!cds_was_not_sent(cycle->read.result))
            add(&cycle->wire_us, (uint16_t)taken_us);
        count(&cycle->counters.failed);
    }
}

/* ---- polls ---- */

/* The goals in front are checked and mended before any leave. */
static void move_on(struct cds_cycle *cycle, uint32_t now_us)
{
    note_changes(cycle);
    if (!is_checked(cycle)) {
        if (is_being_sent(cycle, cycle->front))
            return; // the bus has the permit check them
        if (cycle->checked != cycle->count)
            check_some(cycle);
        else
            mend(cycle, BLOCKS_PER_POLL);
    } else if (cycle->is_refused) {
        send_again(cycle, now_us);
    } else if (cycle->is_reading) {
        return;
    } else if (remaining_us(cycle, now_us) == 0) {
        begin_period(cycle, now_us);
    } else if (!cds_bus_is_busy(cycle->bus) && !cycle->is_yielding) {
        begin_read(cycle, now_us);
    }
}

/* NOINLINE: cds_cycle_poll() then saves no registers while a READ is in flight. */
static NOINLINE enum cds_result move_on_or_end(struct cds_cycle *cycle)
{
    uint32_t now_us = cds_port_now_us();

    if (cycle->is_reading && cycle->read.result != CDS_PENDING)
        take_feedback(cycle, now_us);
    if (cycle->is_aborted)
        return is_on_its_way(cycle) ? CDS_PENDING : CDS_OK;
    move_on(cycle, now_us);
    return CDS_PENDING;
}

/* While a READ is in flight nothing begins. Goals queued behind it would count as begun, and wait
 * while the application computes the next ones. */
enum cds_result cds_cycle_poll(struct cds_cycle *cycle)
{
    OPTIMIZER_BARRIER(cycle);
    if (cycle->is_reading && cycle->read.result == CDS_PENDING && !cycle->is_refused)
        return CDS_PENDING;
    return move_on_or_end(cycle);
}

void cds_cycle_abort(struct cds_cycle *cycle)
{
    if (cycle->bus) { // else it was never begun
        cds_bus_cancel(cycle->bus, &cycle->goals);
        cds_bus_cancel(cycle->bus, &cycle->read);
    }
    cycle->is_aborted = true;
}

uint16_t cds_cycle_spare_us(const struct cds_cycle *cycle)
{
    return cycle->latest_us > 2 * SUBMIT_US ? (uint16_t)(cycle->latest_us - 2 * SUBMIT_US) : 0;
}

bool cds_cycle_yields(struct cds_cycle *cycle, uint16_t us)
{
    uint16_t remaining = remaining_us(cycle, cds_port_now_us());
    bool is_free = !cds_bus_is_busy(cycle->bus) && !cds_bus_is_resting(cycle->bus);

    if (cycle->is_aborted)
        return is_free;
    cycle->is_yielding = false;
    if (is_free && remaining >= SUBMIT_US && remaining - SUBMIT_US >= us)
        return true;
    if (us <= cds_cycle_spare_us(cycle)) // else the time never comes
        cycle->is_yielding = true;
    return false;
}

uint32_t cds_cycle_oldest_us(const struct cds_cycle *cycle)
{
    uint32_t oldest_us = 0;

    for (uint8_t i = 0; i < cycle->count; i++) {
        uint32_t age_us = cds_feedback_age_us(&cycle->feedback[i]);

        if (age_us > oldest_us)
            oldest_us = age_us;
    }
    return oldest_us;
}

uint16_t cds_cycle_utilisation_permille(const struct cds_cycle *cycle)
{
    uint32_t thousandth_us = cycle->elapsed_us / 1000;

    return (uint16_t)(thousandth_us ? cycle->wire_us / thousandth_us : 0);
}
