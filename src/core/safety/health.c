/* SPDX-License-Identifier: MIT */
/* The state check; see health.h. */
#include "cds55xx/health.h"

#include "cds55xx/servo.h" // cds_servo_ping(), cds_servo_read()
#include "compiler.h"      // OPTIMIZER_BARRIER(), NOINLINE

#define PERIOD_MIN_US 10000ul
#define PERIOD_MAX_US 1000000000ul
#define READ_BYTES    (CDS_PACKET_SIZE(2) + CDS_PACKET_SIZE(1))

enum cds_result cds_health_begin(struct cds_health *health, const struct cds_health_config *config)
{
    struct cds_servos *servos = config->servos;
    uint32_t now_us = cds_port_now_us();

    OPTIMIZER_BARRIER(health);
    if (config->period_us < PERIOD_MIN_US || config->period_us > PERIOD_MAX_US)
        return CDS_BAD_ARGUMENT;
    if (health->request.result == CDS_PENDING)
        return CDS_BUSY;
    *health = (struct cds_health){
        .servos = servos,
        .is_running = true,
        .request = {.packet = {.bytes = health->packet, .capacity = sizeof health->packet},
                    .reply = &health->reply,
                    .reply_capacity = 1,
                    .no_retry = true}, // the servo has another turn soon
        .step_us = servos->count ? config->period_us / servos->count : config->period_us,
        .look_us = now_us,
        .seek_us = now_us,
        .event_count = (uint8_t)(servos->event_count - 1u), // a servo may have RETURNED
        .asked = CDS_PRESENCE_OFFLINE,
    };
    return CDS_OK;
}

/* The longest time a READ of one byte takes; a PING is shorter. NOINLINE: saves 28 bytes. */
static NOINLINE uint16_t read_us(const struct cds_health *health,
                                 const struct cds_servo_state *servo)
{
    const struct cds_bus *bus = health->servos->bus;
    uint16_t delay_us = bus->return_delay_us;

    if (servo->return_delay != CDS_SERVOS_UNKNOWN)
        delay_us = (uint16_t)(2u * servo->return_delay);
    return (uint16_t)(READ_BYTES * bus->byte_time_us + delay_us + CDS_REPLY_MARGIN_US);
}

enum cds_result cds_health_set_cycle(struct cds_health *health, struct cds_cycle *cycle)
{
    const struct cds_servo_state *servo = health->servos->states;
    uint16_t spare_us = cycle ? cds_cycle_spare_us(cycle) : UINT16_MAX;

    for (uint8_t i = health->servos->count; i; i--, servo++)
        if (read_us(health, servo) > spare_us)
            return CDS_BAD_ARGUMENT;
    health->cycle = cycle;
    return CDS_OK;
}

static bool is_due(uint32_t time_us, uint32_t now_us)
{
    return (int32_t)(now_us - time_us) >= 0;
}

/* True if there is time for a transaction of `us` now. */
static bool has_time(struct cds_health *health, uint16_t us)
{
    const struct cds_bus *bus = health->servos->bus;

    if (health->cycle)
        return cds_cycle_yields(health->cycle, us);
    // while the bus rests, the request would wait, and others behind it
    return !bus->request && !cds_bus_is_resting(bus);
}

/* Asks servo `index` for its state, by READ or PING. True: its turn is over. A RETURNED servo that
 * has answered no READ is asked by PING whether it is there. A servo that was found to answer no
 * READ has lost its state, or its torque is off; it is asked by READ again, since noise may have
 * been the reason. */
static bool ask(struct cds_health *health, uint8_t index)
{
    struct cds_servos *servos = health->servos;
    const struct cds_servo_state *servo = &servos->states[index];
    uint16_t us = read_us(health, servo);
    uint8_t presence = servo->presence;
    bool is_mute = servo->status_return_level == 0;
    enum cds_result result;

    if (health->cycle && us > cds_cycle_spare_us(health->cycle))
        return true; // its return delay has grown; the others do not wait for it
    if (!has_time(health, us))
        return false;
    health->request.servo_index = index;
    health->request.ignores_servo_state = is_mute;
    if (presence == CDS_PRESENCE_OFFLINE ||
        (is_mute &&
         (servo->misses || (servo->torque && !(servo->inhibits & CDS_INHIBIT_STATE_LOST)))) ||
        (presence == CDS_PRESENCE_RETURNED && servo->misses == CDS_SERVOS_MISSES))
        result = cds_servo_ping(servos->bus, &health->request, servo->id);
    else
        result = cds_servo_read(servos->bus, &health->request, servo->id, CDS_REG_TORQUE_ENABLE, 1);
    if (result == CDS_OK)
        health->asked = presence;
    return result == CDS_OK;
}

/* A servo that was RETURNED has answered, or not. If it answers a PING after three READs without an
 * answer, its status return level is 0, and its state is taken for lost, unless torque was off. */
static void take_returned(struct cds_health *health)
{
    const struct cds_request *request = &health->request;
    struct cds_servos *servos = health->servos;
    struct cds_servo_state *servo = cds_servos_find(servos, request->packet.bytes[CDS_AT_ID]);
    bool is_ping = request->packet.bytes[CDS_AT_INSTRUCTION] == CDS_PING;

    if (!servo || servo->presence != CDS_PRESENCE_RETURNED)
        return;
    if (request->result == CDS_TIMEOUT && servo->misses < CDS_SERVOS_MISSES)
        servo->misses = (servo->misses + 1u) & 3u;
    if (request->result != CDS_OK || !is_ping)
        return;
    servo->status_return_level = 0;
    servo->presence = CDS_PRESENCE_ONLINE;
    servos->event_count++;
    if (servo->torque)
        cds_servos_inhibit(servos, servo, CDS_INHIBIT_STATE_LOST);
}

/* True if the READ without a good reply was counted as a miss of its servo. A servo whose rate is
 * not the rate of the bus has none. */
static bool has_missed(const struct cds_health *health)
{
    const struct cds_servos *servos = health->servos;
    uint8_t index = health->request.servo_index;

    return health->request.result != CDS_OK && index < servos->count &&
           servos->states[index].misses;
}

/* Takes the answer of the servo asked last. A servo that has missed has the next turn, until it is
 * OFFLINE: so an unplugged servo shows within a period. */
static void take_answer(struct cds_health *health, uint32_t now_us)
{
    if (health->asked == CDS_PRESENCE_RETURNED) {
        take_returned(health);
    } else if (has_missed(health)) {
        health->turn = health->request.servo_index;
        if (!is_due(health->look_us, now_us + CDS_HEALTH_AGAIN_US))
            health->look_us = now_us + CDS_HEALTH_AGAIN_US;
    }
    health->asked = CDS_PRESENCE_OFFLINE;
}

/* Chooses the servo to seek: the next one that is RETURNED, else the next one that is OFFLINE. The
 * servo is asked at once if it is RETURNED and the servos have had an event. */
static void choose(struct cds_health *health, uint32_t now_us)
{
    const struct cds_servos *servos = health->servos;
    bool is_at_once = health->sought == CDS_NO_ID;
    uint8_t index = health->sought, presence = CDS_PRESENCE_UNKNOWN;

    health->sought = CDS_NO_ID;
    for (uint8_t i = servos->count; i && presence != CDS_PRESENCE_RETURNED; i--) {
        index++;
        if (index >= servos->count)
            index = 0;
        presence = servos->states[index].presence;
        if (presence == CDS_PRESENCE_RETURNED ||
            (presence == CDS_PRESENCE_OFFLINE && health->sought == CDS_NO_ID))
            health->sought = index;
    }
    if (is_at_once ||
        (presence == CDS_PRESENCE_RETURNED && health->event_count != servos->event_count))
        health->seek_us = now_us;
    health->event_count = servos->event_count;
    health->is_chosen = true;
}

static void seek(struct cds_health *health, uint32_t now_us)
{
    if (!ask(health, health->sought))
        return;
    health->is_chosen = false;
    health->seek_us = now_us + CDS_HEALTH_SEEK_US;
}

static void look(struct cds_health *health, uint32_t now_us)
{
    if (health->turn >= health->servos->count)
        health->turn = 0;
    if (!ask(health, health->turn))
        return;
    health->turn++;
    health->look_us += health->step_us;
    if (is_due(health->look_us, now_us)) // turns that were missed are not made up for
        health->look_us = now_us + health->step_us;
}

void cds_health_poll(struct cds_health *health)
{
    uint32_t now_us;

    OPTIMIZER_BARRIER(health);
    if (!health->is_running || health->request.result == CDS_PENDING || !health->servos->count)
        return;
    now_us = cds_port_now_us();
    if (health->asked != CDS_PRESENCE_OFFLINE)
        take_answer(health, now_us);
    if (!health->is_chosen || health->event_count != health->servos->event_count)
        choose(health, now_us);
    else if (health->sought < health->servos->count && is_due(health->seek_us, now_us))
        seek(health, now_us);
    else if (is_due(health->look_us, now_us))
        look(health, now_us);
}

void cds_health_abort(struct cds_health *health)
{
    if (health->is_running)
        cds_bus_cancel(health->servos->bus, &health->request);
    health->is_running = false;
}
