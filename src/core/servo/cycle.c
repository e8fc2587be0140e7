/* Goals out, feedback in, at a fixed rate; see cycle.h. */
#include "cds55xx/cycle.h"

#include <string.h>

#include "cds55xx/control_table.h" // CDS_REG_GOAL_POSITION, CDS_VALUE_MAX
#include "servo/goal.h"            // cds_goal_put(), CDS_GOAL_SIZE
#include "compiler.h"              // OPTIMIZER_BARRIER(), NOINLINE
#include "bus/bus_internal.h"      // cds_was_not_sent()

#define BLOCK_SIZE  (1u + CDS_GOAL_SIZE)     // ID, goal
#define BLOCKS_AT   (CDS_AT_PARAMETERS + 2u) // behind address and length
#define NO_GOAL     UINT8_MAX                // high byte of a position that was never set
#define NO_SERVO    CDS_BROADCAST_ID // ID of a dropped servo's block that nobody stands in for
#define READ_BYTES  (CDS_PACKET_SIZE(2) + CDS_PACKET_SIZE(CDS_FEEDBACK_SIZE))
#define SUBMIT_US   20          // from our look at the clock to the bus's own, at 16 MHz
#define CATCH_UP    32          // periods passed over in one poll, however late it is
#define HALVE_AT_US (1ul << 30) // both times of the utilisation, so that neither wraps

static NOINLINE void count(uint32_t *counter)
{
    ++*counter;
}

static NOINLINE void add(uint32_t *sum_us, uint16_t us)
{
    *sum_us += us;
}

static NOINLINE bool on_its_way(const struct cds_cycle *cycle)
{
    return cycle->goals.result == CDS_PENDING || cycle->read.result == CDS_PENDING;
}

/* Goals refused go out again from cds_cycle_poll(): the bus is not called out of itself. */
static void goals_ended(struct cds_request *request)
{
    struct cds_cycle *cycle = (struct cds_cycle *)request->owner;

    cycle->refused = false;
    if (request->result == CDS_INHIBITED || request->result == CDS_LIMIT)
        cycle->refused = true;
    else if (request->result != CDS_OK)
        count(&cycle->counters.unsent);
}

/* Both packets, whole, with goals that are still to be set. */
static void build_goals(struct cds_cycle *cycle, uint16_t size)
{
    struct cds_request *request = &cycle->goals;
    uint8_t *none = cycle->back; // for now

    request->packet.bytes = cycle->front;
    request->packet.room = size;
    request->reply_parameters = CDS_REPLY_NONE;
    request->urgent = true;
    request->on_end = goals_ended;
    request->owner = cycle;
    memset(none, NO_GOAL, CDS_GOAL_SIZE);
    cds_packet_sync_begin(&request->packet, CDS_REG_GOAL_POSITION, CDS_GOAL_SIZE);
    for (uint8_t i = 0; i < cycle->count; i++)
        cds_packet_sync_add(&request->packet, cycle->ids[i], none);
    cds_packet_end(&request->packet);
    memcpy(cycle->back, cycle->front, size);
}

/* All goals in front are judged, by the observer as it is now. */
static NOINLINE void note_vetted(struct cds_cycle *cycle)
{
    cycle->observer = cycle->bus->observer;
    if (cycle->observer)
        cycle->epoch = cycle->observer->epoch;
}

static bool are_ids(const uint8_t *ids, uint8_t count)
{
    for (; count; count--)
        if (*ids++ > CDS_ID_MAX)
            return false;
    return true;
}

enum cds_result cds_cycle_begin(struct cds_cycle *cycle, struct cds_bus *bus, const uint8_t *ids,
                                uint8_t count, uint8_t *packets, struct cds_feedback *feedback,
                                uint16_t period_us)
{
    uint16_t size = (uint16_t)CDS_SYNC_WRITE_SIZE((uint16_t)count, CDS_GOAL_SIZE);
    uint32_t goals_us = (uint32_t)size * bus->byte_time_us;

    if (on_its_way(cycle))
        return CDS_BUSY;
    if (bus->byte_time_us == 0 || count == 0 || count > CDS_CYCLE_SERVOS_MAX ||
        !are_ids(ids, count) || goals_us + CDS_REPLY_MARGIN_US > period_us)
        return CDS_BAD_ARGUMENT;
    *cycle = (struct cds_cycle){.bus = bus,
                                .ids = ids,
                                .feedback = feedback,
                                .count = count,
                                .front = packets,
                                .back = packets + size};
    cycle->filling = true;
    cycle->period_us = period_us;
    cycle->goals_us = (uint16_t)goals_us;
    cycle->latest_us = (uint16_t)(period_us - cycle->goals_us - CDS_REPLY_MARGIN_US);
    cycle->next_us = cds_port_now_us();
    cds_bus_set_queue(bus, true); // others send beside it
    note_vetted(cycle);           // goals are judged when they are set
    cycle->filled_epoch = cycle->epoch;
    build_goals(cycle, size);
    cycle->read.packet.bytes = cycle->buffer;
    cycle->read.packet.room = sizeof cycle->buffer;
    return CDS_OK;
}

/* Is this packet on the wire, or waiting for that? */
static bool is_being_sent(const struct cds_cycle *cycle, const uint8_t *packet)
{
    return cycle->goals.result == CDS_PENDING && cycle->goals.packet.bytes == packet;
}

/* ---- whose goals are sent ---- */

static uint8_t *block_of(uint8_t *packet, uint8_t index)
{
    return packet + BLOCKS_AT + index * BLOCK_SIZE;
}

/* A dropped servo's block says so itself: it has another one's ID. */
bool cds_cycle_is_dropped(const struct cds_cycle *cycle, uint8_t index)
{
    return index < cycle->count && *block_of(cycle->front, index) != cycle->ids[index];
}

/* The packet keeps its size, so another servo's block stands for each one that is dropped: the same
 * as that servo's own, as the last block of an ID wins (R22). Then the checksum. */
static void finish_goals(const struct cds_cycle *cycle, uint8_t *packet, bool *holes)
{
    uint8_t *block = packet + BLOCKS_AT;
    const uint8_t *whole = NULL, *id = cycle->ids;
    bool dropped = false;
    uint8_t left = *holes ? cycle->count : 0;

    for (uint8_t i = left; i; i--, block += BLOCK_SIZE) {
        if (*block == *id++)
            whole = block;
        else
            dropped = true;
    }
    for (; left; left--) {
        block -= BLOCK_SIZE;
        if (*block == *--id)
            continue;
        if (whole)
            memcpy(block, whole, BLOCK_SIZE);
        else
            *block = NO_SERVO;
    }
    *holes = dropped;
    if (whole || !dropped) // else it is not sent
        packet[cycle->goals.packet.size - 1u] = cds_packet_checksum(packet);
}

/* Has the observer admitted every goal in front, and would say the same again? */
static bool is_vetted(const struct cds_cycle *cycle)
{
    const struct cds_bus_observer *observer = cycle->bus->observer;

    return !observer || (cycle->observer == observer && cycle->epoch == observer->epoch);
}

static bool is_admitted(const struct cds_cycle *cycle, const uint8_t *block)
{
    return cds_bus_would_admit(cycle->bus, block[0], CDS_REG_GOAL_POSITION, block + 1,
                               CDS_GOAL_SIZE) == CDS_OK;
}

/* Leaves out servo `id`, whose block this is, if it is not admitted any more. True: it was left out
 * now. */
static NOINLINE bool drop(struct cds_cycle *cycle, uint8_t *block, uint8_t id)
{
    if (*block != id || is_admitted(cycle, block))
        return false;
    *block = NO_SERVO;
    return true;
}

/* Whom did the roster's last changes concern, since the goals in front were judged? */
static uint8_t who_changed(const struct cds_cycle *cycle)
{
    const struct cds_bus_observer *observer = cycle->bus->observer;
    bool one = cycle->observer == observer && (uint16_t)(observer->epoch - cycle->epoch) == 1;

    return one ? observer->changed_id : CDS_BROADCAST_ID;
}

/* If the roster has changed since the goals were judged: judges anew whom that concerns, as 50
 * servos take a millisecond. Those being filled follow for whom is dropped, and for the others when
 * they are committed; those that wait in the queue are judged by the bus when their turn comes. */
static void vet(struct cds_cycle *cycle)
{
    uint8_t *block = block_of(cycle->front, 0);
    bool dropped = false;
    uint8_t who;

    if (!cycle->committed || is_vetted(cycle) || is_being_sent(cycle, cycle->front))
        return;
    who = who_changed(cycle);
    for (uint8_t i = 0; i < cycle->count; i++, block += BLOCK_SIZE) {
        uint8_t id = cycle->ids[i];

        if (who != CDS_BROADCAST_ID && who != id)
            continue;
        if (drop(cycle, block, id)) {
            dropped = true;
            cycle->counters.dropped++;
        }
        if (cycle->filling && *block != id && // perhaps with a goal that was to bring it back
            drop(cycle, block_of(cycle->back, i), id))
            cycle->filled_holes = true;
    }
    if (dropped) {
        cycle->holes = true;
        finish_goals(cycle, cycle->front, &cycle->holes);
    }
    note_vetted(cycle);
}

/* The observer's word; apart, as 50 goals in 4 ms need no frame for this if there is none. */
static NOINLINE enum cds_result judge_goal(struct cds_cycle *cycle, uint8_t *block, uint8_t id,
                                           uint16_t position, uint16_t speed)
{
    uint8_t goal[CDS_GOAL_SIZE];
    enum cds_result result;

    cds_goal_put(goal, position, speed);
    result = cds_bus_would_admit(cycle->bus, id, CDS_REG_GOAL_POSITION, goal, CDS_GOAL_SIZE);
    if (result == CDS_OK) {
        *block = id;
    } else if (result == CDS_INHIBITED && block[2] == NO_GOAL) {
        *block = NO_SERVO; // the others need not wait for it
        cycle->filled_holes = true;
    }
    return result;
}

/* What is not set anew is to stay as it is, not as it was before that. */
static void follow_front(struct cds_cycle *cycle)
{
    memcpy(cycle->back, cycle->front, cycle->goals.packet.size);
    cycle->filled_epoch = cycle->epoch;
    cycle->filled_holes = cycle->holes;
    cycle->filling = true;
}

enum cds_result cds_cycle_goal(struct cds_cycle *cycle, uint8_t index, uint16_t position,
                               uint16_t speed)
{
    enum cds_result result = CDS_OK;
    uint8_t *block;

    if (index >= cycle->count || position > CDS_VALUE_MAX || speed > CDS_VALUE_MAX)
        return CDS_BAD_ARGUMENT;
    if (is_being_sent(cycle, cycle->back))
        return CDS_BUSY;
    if (!cycle->filling)
        follow_front(cycle);
    block = block_of(cycle->back, index);
    if (cycle->bus->observer)
        result = judge_goal(cycle, block, cycle->ids[index], position, speed);
    if (result == CDS_OK)
        cds_goal_put(block + 1, position, speed);
    return result;
}

static bool all_set(struct cds_cycle *cycle)
{
    const uint8_t *block = block_of(cycle->back, 0), *id = cycle->ids;

    for (uint8_t i = cycle->count; i; i--, block += BLOCK_SIZE)
        if (*block == *id++ && block[2] == NO_GOAL)
            return false;
    return true;
}

enum cds_result cds_cycle_commit(struct cds_cycle *cycle)
{
    uint8_t *filled = cycle->back;

    if (!cycle->filling)
        return CDS_OK;
    if (!cycle->committed && !all_set(cycle))
        return CDS_BAD_ARGUMENT;
    finish_goals(cycle, filled, &cycle->filled_holes);
    if (!cycle->committed)
        cycle->next_us = cds_port_now_us(); // none of the periods before it can have been missed
    cycle->back = cycle->front;
    cycle->front = filled;
    cycle->epoch = cycle->filled_epoch;
    cycle->holes = cycle->filled_holes;
    cycle->filling = false;
    cycle->committed = true;
    return CDS_OK;
}

/* ---- period after period ---- */

/* Until the next period begins; 0 if it is due. */
static NOINLINE uint16_t left_us(const struct cds_cycle *cycle, uint32_t now_us)
{
    int32_t left_us = (int32_t)(cycle->next_us - now_us);

    return left_us > 0 ? (uint16_t)left_us : 0;
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

/* Is there nobody left to send the goals in front to? */
static bool is_empty(struct cds_cycle *cycle)
{
    return *block_of(cycle->front, 0) == NO_SERVO;
}

/* False: not sent, or some are on their way still. */
static NOINLINE bool send_goals(struct cds_cycle *cycle)
{
    struct cds_request *request = &cycle->goals;

    if (request->result == CDS_PENDING)
        return false;
    request->packet.bytes = cycle->front;
    request->vetted = is_vetted(cycle);
    return cds_bus_submit(cycle->bus, request) == CDS_OK;
}

/* The next period has begun, or more than one. */
static void begin_period(struct cds_cycle *cycle)
{
    int32_t late_us;

    vet(cycle);
    late_us = (int32_t)(cds_port_now_us() - cycle->next_us); // that may have taken a while
    for (uint8_t i = 0; late_us > (int32_t)cycle->latest_us && i < CATCH_UP; i++) {
        if (cycle->committed)
            count(&cycle->counters.missed);
        pass_period(cycle);
        late_us -= cycle->period_us;
    }
    if (late_us < 0 || late_us > (int32_t)cycle->latest_us)
        return;
    if (cycle->committed) {
        if (is_empty(cycle))
            count(&cycle->counters.unsent);
        else if (send_goals(cycle))
            add(&cycle->wire_us, cycle->goals_us);
        else
            return; // still waiting in the queue since the last period
        count(&cycle->counters.periods);
    }
    cycle->giving_way = false;
    pass_period(cycle);
}

/* Refused at their turn, since a servo is: now without it, if they still do not hold up the next
 * ones. */
static void send_again(struct cds_cycle *cycle)
{
    cycle->refused = false;
    vet(cycle);
    if (left_us(cycle, cds_port_now_us()) < cycle->period_us - cycle->latest_us ||
        is_empty(cycle) || !send_goals(cycle))
        count(&cycle->counters.unsent);
}

/* The longest a feedback READ may take. */
static uint16_t read_us(const struct cds_bus *bus, uint16_t return_delay_us)
{
    return (uint16_t)(READ_BYTES * bus->byte_time_us + return_delay_us + CDS_REPLY_MARGIN_US);
}

static NOINLINE void next_turn(struct cds_cycle *cycle)
{
    cycle->turn++;
    if (cycle->turn >= cycle->count)
        cycle->turn = 0;
}

static void begin_read(struct cds_cycle *cycle, uint32_t now_us)
{
    struct cds_bus *bus = cycle->bus;
    uint16_t us = (uint16_t)(read_us(bus, bus->return_delay_us) + SUBMIT_US);
    enum cds_result result;

    if (left_us(cycle, now_us) < us || cds_bus_rests(bus, now_us))
        return; // in a rest it would wait in the queue, and might hold up the next goals
    result = cds_feedback_read(bus, &cycle->read, cycle->ids[cycle->turn]);
    if (result == CDS_NO_REPLY_DUE) { // and the others must not wait for it
        cycle->feedback[cycle->turn].result = CDS_NO_REPLY_DUE;
        next_turn(cycle);
    }
    if (result != CDS_OK)
        return;
    cycle->read.repeats = 0; // there is no time for it; the servo's next turn will do
    cycle->read_at_us = now_us;
    cycle->read_us = us;
    cycle->reading = true;
}

/* The READ has ended. If this poll is late, its reply was there all the same by its deadline. */
static NOINLINE void take_feedback(struct cds_cycle *cycle, uint32_t now_us)
{
    struct cds_feedback *feedback = &cycle->feedback[cycle->turn];
    uint32_t taken_us = now_us - cycle->read_at_us, between_us;
    bool known = feedback->known;

    if (taken_us > cycle->read_us)
        taken_us = cycle->read_us;
    now_us = cycle->read_at_us + taken_us;
    between_us = now_us - feedback->time_us;
    cycle->reading = false;
    next_turn(cycle);
    count(&cycle->counters.reads);
    if (cds_feedback_take(feedback, &cycle->read, now_us) == CDS_OK) {
        add(&cycle->wire_us, (uint16_t)(READ_BYTES * cycle->bus->byte_time_us));
        if (known && between_us > cycle->counters.oldest_us)
            cycle->counters.oldest_us = between_us;
    } else {
        if (!cds_was_not_sent(cycle->read.result))
            add(&cycle->wire_us, (uint16_t)taken_us);
        count(&cycle->counters.failed);
    }
}

/* Apart, so that asking while a READ is on its way needs no frame. */
static NOINLINE enum cds_result go_on(struct cds_cycle *cycle)
{
    uint32_t now_us = cds_port_now_us();

    if (cycle->reading && cycle->read.result != CDS_PENDING)
        take_feedback(cycle, now_us);
    if (cycle->stopping)
        return on_its_way(cycle) ? CDS_PENDING : CDS_OK;
    if (cycle->refused)
        send_again(cycle);
    if (cycle->reading)
        return CDS_PENDING;
    if (left_us(cycle, now_us) == 0)
        begin_period(cycle);
    else if (!cycle->bus->request && cycle->committed && !is_vetted(cycle))
        vet(cycle); // rather than when goals are due
    else if (!cycle->bus->request && !cycle->giving_way)
        begin_read(cycle, now_us);
    return CDS_PENDING;
}

/* While a READ is on its way nothing begins, goals neither: queued behind it they would count as
 * begun, and wait while the application computes the next ones. */
enum cds_result cds_cycle_poll(struct cds_cycle *cycle)
{
    OPTIMIZER_BARRIER(cycle);
    if (cycle->reading && cycle->read.result == CDS_PENDING && !cycle->refused)
        return CDS_PENDING;
    return go_on(cycle);
}

void cds_cycle_stop(struct cds_cycle *cycle)
{
    if (cycle->bus) { // else it was never begun
        cds_bus_cancel(cycle->bus, &cycle->goals);
        cds_bus_cancel(cycle->bus, &cycle->read);
    }
    cycle->stopping = true;
}

uint16_t cds_cycle_room_us(const struct cds_cycle *cycle)
{
    return cycle->latest_us > 2 * SUBMIT_US ? (uint16_t)(cycle->latest_us - 2 * SUBMIT_US) : 0;
}

bool cds_cycle_gives_way(struct cds_cycle *cycle, uint16_t us)
{
    uint32_t now_us = cds_port_now_us();
    uint16_t left = left_us(cycle, now_us);
    bool idle = !cycle->bus->request && !cds_bus_rests(cycle->bus, now_us);

    if (cycle->stopping)
        return idle;
    cycle->giving_way = false;
    if (idle && left >= SUBMIT_US && left - SUBMIT_US >= us)
        return true;
    if (us <= cds_cycle_room_us(cycle)) // else nothing is worth it
        cycle->giving_way = true;
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
