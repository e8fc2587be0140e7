/* SPDX-License-Identifier: MIT */
/* Goals out, feedback in, at a fixed rate; see cycle.h. */
#include "cds55xx/cycle.h"

#include "bus/bus_internal.h"      // cds_bus_submit_prechecked(), cds_was_not_sent()
#include "bus/line_internal.h"     // GATE_LINE
#include "cds55xx/control_table.h" // CDS_REG_*, CDS_VALUE_MAX
#include "compiler.h"              // OPTIMIZER_BARRIER(), NOINLINE
#include "servo/cycle_internal.h"
#include "servo/goal.h" // CDS_GOAL_SIZE

#define READ_BYTES  (CDS_PACKET_SIZE(2) + CDS_PACKET_SIZE(CDS_FEEDBACK_SIZE))
#define SUBMIT_US   20          // from reading the clock to the first start bit, at 16 MHz
#define CATCH_UP    8           // periods passed over in one poll, however late it is
#define HALVE_AT_US (1ul << 30) // both times of the utilisation, so that neither wraps

static NOINLINE void count(uint32_t *counter)
{
    ++*counter;
}

static NOINLINE void add(uint32_t *sum_us, uint16_t us)
{
    *sum_us += us;
}

static NOINLINE bool is_on_its_way(const struct cds_cycle *cycle)
{
    return cycle->goals.result == CDS_PENDING || cycle->read.result == CDS_PENDING;
}

/* ---- begin ---- */

/* If the permit has refused the goals when their turn came, cds_cycle_poll() checks each one and
 * sends them again. */
static void goals_ended(struct cds_request *request)
{
    struct cds_cycle *cycle = (struct cds_cycle *)request->context;

    cycle->sends_again = request->result == CDS_INHIBITED || request->result == CDS_LIMIT;
    if (request->result != CDS_OK && !cycle->sends_again)
        count(&cycle->counters.unsent);
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
                                .begun = (cycle->begun + 1u) & 31u,
                                .period_us = config->period_us,
                                .goals_us = (uint16_t)goals_us,
                                .goals = {.reply_parameters = CDS_REPLY_NONE,
                                          .priority = CDS_PRIORITY_HIGH,
                                          .on_end = goals_ended,
                                          .context = cycle}};
    cycle->read_bytes_us = (uint16_t)(READ_BYTES * bus->byte_time_us);
    cycle->latest_us = (uint16_t)(config->period_us - cycle->goals_us - CDS_REPLY_MARGIN_US);
    cycle->next_us = cds_port_now_us();
    cds_cycle_build_goals(cycle, size);
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

/* True if another request waits while the line is in use. Goals have a higher priority: submitted
 * now, they would begin the wait of that request again. In a cycle whose period is shorter than the
 * wait, the wait would never end. */
static bool line_is_awaited(const struct cds_bus *bus)
{
    return bus->state == CDS_BUS_WAITING_FOR_LINE && bus->gate & GATE_LINE;
}

/* False: the bus did not take them, or earlier goals are still on their way. */
static NOINLINE bool send_goals(struct cds_cycle *cycle)
{
    struct cds_bus *bus = cycle->bus;
    struct cds_request *request = &cycle->goals;
    uint16_t epoch = 0;

    if (request->result == CDS_PENDING || line_is_awaited(bus))
        return false;
    if (bus->hooks && bus->hooks->changed_since)
        epoch = cycle->epoch;
    request->packet.bytes = cycle->front;
    return cds_bus_submit_prechecked(bus, request, epoch) == CDS_OK;
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
        if (cds_cycle_goals_are_empty(cycle))
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

/* The goals were refused on the bus, or taken back, and were checked since. They leave if they do
 * not hold up those of the next period. */
static void send_again(struct cds_cycle *cycle, uint32_t now_us)
{
    cycle->sends_again = false;
    if (remaining_us(cycle, now_us) < cycle->period_us - cycle->latest_us ||
        cds_cycle_goals_are_empty(cycle) || !send_goals(cycle))
        count(&cycle->counters.unsent);
}

/* ---- feedback ---- */

static NOINLINE void next_turn(struct cds_cycle *cycle)
{
    cycle->turn++;
    if (cycle->turn >= cycle->count)
        cycle->turn = 0;
}

/* The longest time of a READ, from reading the clock on. */
static uint16_t read_us(const struct cds_cycle *cycle)
{
    return (uint16_t)(cycle->read_bytes_us + cycle->bus->return_delay_us + CDS_REPLY_MARGIN_US +
                      SUBMIT_US);
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

static void begin_read(struct cds_cycle *cycle, uint32_t now_us, uint16_t remaining)
{
    const struct cds_bus *bus = cycle->bus;
    uint16_t us = read_us(cycle);
    enum cds_result result;

    if (remaining < us || cds_bus_is_resting(bus))
        return; // while the bus rests the READ would wait, and might hold up the next goals
    result = submit_read(cycle);
    if (result == CDS_NO_REPLY_DUE) { // the other servos must not wait for this one
        cycle->feedback[cycle->turn].result = CDS_NO_REPLY_DUE;
        next_turn(cycle);
    }
    if (result != CDS_OK)
        return;
    cycle->read_until_us = now_us + us;
    cycle->is_reading = true;
}

/* The READ has ended. Its reply came by its deadline, also if this poll is late. */
static void take_feedback(struct cds_cycle *cycle, uint32_t now_us)
{
    struct cds_feedback *feedback = &cycle->feedback[cycle->turn];
    const struct cds_request *read = &cycle->read;
    int32_t early_us = (int32_t)(cycle->read_until_us - now_us);

    if (early_us < 0) {
        now_us = cycle->read_until_us;
        early_us = 0;
    }
    cycle->is_reading = false;
    next_turn(cycle);
    count(&cycle->counters.reads);
    if (read->result == CDS_OK && read->length == CDS_FEEDBACK_SIZE) {
        uint32_t between_us = now_us - feedback->time_us;

        add(&cycle->wire_us, cycle->read_bytes_us);
        if (feedback->known && between_us > cycle->counters.oldest_us)
            cycle->counters.oldest_us = between_us;
    } else {
        if (!cds_was_not_sent(read->result))
            add(&cycle->wire_us, (uint16_t)(read_us(cycle) - (uint16_t)early_us));
        count(&cycle->counters.failed);
    }
    cds_feedback_take(feedback, read, now_us); // last: saves 40 cycles of saved registers
}

/* ---- polls ---- */

static void move_on(struct cds_cycle *cycle, uint32_t now_us)
{
    uint16_t remaining;

    if (!cds_cycle_check_goals(cycle))
        return;
    if (cycle->sends_again)
        send_again(cycle, now_us);
    remaining = remaining_us(cycle, now_us);
    if (remaining == 0)
        begin_period(cycle, now_us);
    else if (!cds_bus_is_busy(cycle->bus) && !cycle->is_yielding)
        begin_read(cycle, now_us, remaining);
}

/* NOINLINE: cds_cycle_poll() then saves no registers while a READ is in flight. */
static NOINLINE enum cds_result move_on_or_end(struct cds_cycle *cycle)
{
    uint32_t now_us = cds_port_now_us();

    if (cycle->is_reading)
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
    if (cycle->is_reading && cycle->read.result == CDS_PENDING)
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

NOINLINE uint16_t cds_cycle_spare_us(const struct cds_cycle *cycle)
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
