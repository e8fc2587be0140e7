/* Who is there, and has its state; see health.h. */
#include "cds55xx/health.h"

#include "cds55xx/servo.h" // cds_servo_ping(), cds_servo_read()
#include "compiler.h"      // OPTIMIZER_BARRIER(), NOINLINE

#define PERIOD_MIN_US 10000ul
#define PERIOD_MAX_US 1000000000ul
#define READ_BYTES    (CDS_PACKET_SIZE(2) + CDS_PACKET_SIZE(1))

enum cds_result cds_health_begin(struct cds_health *watch, struct cds_servos *roster,
                                 uint32_t period_us)
{
    uint32_t now_us = cds_port_now_us();

    OPTIMIZER_BARRIER(watch);
    if (period_us < PERIOD_MIN_US || period_us > PERIOD_MAX_US)
        return CDS_BAD_ARGUMENT;
    if (watch->request.result == CDS_PENDING)
        return CDS_BUSY;
    cds_bus_set_queue(roster->bus, true); // others send beside it
    *watch = (struct cds_health){
        .roster = roster,
        .step_us = roster->count ? period_us / roster->count : period_us,
        .look_us = now_us,
        .seek_us = now_us,
        .epoch = (uint16_t)(roster->observer.epoch - 1u), // who is back is looked for first
    };
    watch->request.packet.bytes = watch->buffer;
    watch->request.packet.capacity = sizeof watch->buffer;
    return CDS_OK;
}

/* The longest a READ of one byte of this servo may take; a PING is shorter. */
static NOINLINE uint16_t read_us(const struct cds_health *watch,
                                 const struct cds_servo_state *servo)
{
    const struct cds_bus *bus = watch->roster->bus;
    uint16_t delay_us = bus->return_delay_us;

    if (servo->return_delay != CDS_SERVOS_UNKNOWN)
        delay_us = (uint16_t)(2u * servo->return_delay);
    return (uint16_t)(READ_BYTES * bus->byte_time_us + delay_us + CDS_REPLY_MARGIN_US);
}

enum cds_result cds_health_set_cycle(struct cds_health *watch, struct cds_cycle *cycle)
{
    for (uint8_t i = 0; cycle && i < watch->roster->count; i++)
        if (read_us(watch, &watch->roster->servos[i]) > cds_cycle_room_us(cycle))
            return CDS_BAD_ARGUMENT;
    watch->cycle = cycle;
    return CDS_OK;
}

static bool is_due(uint32_t time_us, uint32_t now_us)
{
    return (int32_t)(now_us - time_us) >= 0;
}

/* Is there time for a transaction of `us` now? */
static bool has_room(struct cds_health *watch, uint16_t us, uint32_t now_us)
{
    struct cds_bus *bus = watch->roster->bus;

    if (watch->cycle)
        return cds_cycle_gives_way(watch->cycle, us);
    // in a rest it would wait in the queue, and others behind it
    return !bus->request && !cds_bus_rests(bus, now_us);
}

/* Asks it what it can tell, if it ever can be. False: not now. */
static bool ask(struct cds_health *watch, uint8_t index, uint32_t now_us)
{
    struct cds_servo_state *servo = &watch->roster->servos[index];
    struct cds_bus *bus = watch->roster->bus;
    uint16_t us = read_us(watch, servo);
    enum cds_result result;

    // never: its return delay has become known, or longer, since the watch was set beside the cycle
    if (watch->cycle && us > cds_cycle_room_us(watch->cycle))
        return true; // the others must not wait for it
    if (!has_room(watch, us, now_us))
        return false;
    if (servo->presence == CDS_PRESENCE_OFFLINE || servo->status_return_level == 0)
        result = cds_servo_ping(bus, &watch->request, servo->id);
    else
        result = cds_servo_read(bus, &watch->request, servo->id, CDS_REG_TORQUE_ENABLE, 1);
    watch->request.repeats = 0; // it has its turn again soon enough
    return result == CDS_OK;
}

/* The first servo that is back. One that cannot be asked what it remembers: nothing, for all that
 * is known. */
static void look_for_back(struct cds_health *watch)
{
    struct cds_servos *roster = watch->roster;

    watch->back = roster->count;
    for (uint8_t i = roster->count; i-- > 0;) {
        struct cds_servo_state *servo = &roster->servos[i];

        if (servo->presence != CDS_PRESENCE_RETURNED)
            continue;
        if (servo->status_return_level == 0) {
            servo->presence = CDS_PRESENCE_ONLINE;
            cds_servos_hold(roster, servo, CDS_INHIBIT_STATE_LOST);
        } else {
            watch->back = i;
        }
    }
    watch->epoch = roster->observer.epoch;
}

/* The next one that is away, or `count`. */
static uint8_t next_away(const struct cds_health *watch)
{
    const struct cds_servos *roster = watch->roster;
    uint8_t at = watch->seeker;

    for (uint8_t i = 0; i < roster->count; i++) {
        at++;
        if (at >= roster->count)
            at = 0;
        if (roster->servos[at].presence == CDS_PRESENCE_OFFLINE)
            return at;
    }
    return roster->count;
}

static void seek(struct cds_health *watch, uint32_t now_us)
{
    uint8_t away = next_away(watch);

    if (away < watch->roster->count) {
        if (!ask(watch, away, now_us))
            return;
        watch->seeker = away;
    }
    watch->seek_us = now_us + CDS_HEALTH_SEEK_US;
}

static void look(struct cds_health *watch, uint32_t now_us)
{
    if (!ask(watch, watch->turn, now_us))
        return;
    watch->turn++;
    if (watch->turn >= watch->roster->count)
        watch->turn = 0;
    watch->look_us += watch->step_us;
    if (is_due(watch->look_us, now_us)) // it was held up: no burst to make up for that
        watch->look_us = now_us + watch->step_us;
}

void cds_health_poll(struct cds_health *watch)
{
    uint32_t now_us = cds_port_now_us();
    uint8_t count;

    OPTIMIZER_BARRIER(watch);
    count = watch->roster->count;
    if (watch->request.result == CDS_PENDING || count == 0)
        return;
    if (watch->epoch != watch->roster->observer.epoch) {
        look_for_back(watch);
        watch->back_us = now_us;
    }
    if (watch->back < count && is_due(watch->back_us, now_us)) {
        if (ask(watch, watch->back, now_us))
            watch->back_us = now_us + CDS_HEALTH_SEEK_US;
    } else if (is_due(watch->seek_us, now_us)) {
        seek(watch, now_us);
    } else if (is_due(watch->look_us, now_us)) {
        look(watch, now_us);
    }
}
