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
        .news = (uint8_t)(servos->news - 1u), // the first poll looks for a RETURNED servo
    };
    return CDS_OK;
}

/* The longest time a READ of one byte takes; a PING is shorter. */
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
    for (uint8_t i = 0; cycle && i < health->servos->count; i++)
        if (read_us(health, &health->servos->states[i]) > cds_cycle_spare_us(cycle))
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

/* Asks servo `index` what it can tell. True: its turn is over. */
static bool ask(struct cds_health *health, uint8_t index)
{
    struct cds_servos *servos = health->servos;
    struct cds_servo_state *servo = &servos->states[index];
    uint16_t us = read_us(health, servo);

    if (health->cycle && us > cds_cycle_spare_us(health->cycle))
        return true; // its return delay has grown; the others do not wait for it
    if (!has_time(health, us))
        return false;
    health->request.servo_index = index;
    if (servo->presence == CDS_PRESENCE_OFFLINE || servo->status_return_level == 0)
        return cds_servo_ping(servos->bus, &health->request, servo->id) == CDS_OK;
    return cds_servo_read(servos->bus, &health->request, servo->id, CDS_REG_TORQUE_ENABLE, 1) ==
           CDS_OK;
}

/* The next servo after entry `index` with this presence, or `count`. */
static uint8_t next_with(const struct cds_servos *servos, enum cds_presence presence, uint8_t index)
{
    for (uint8_t i = servos->count; i; i--) {
        index++;
        if (index >= servos->count)
            index = 0;
        if (servos->states[index].presence == presence)
            return index;
    }
    return servos->count;
}

/* Looks for a RETURNED servo. If it answers no READ, its state is taken for lost. */
static void find_returned(struct cds_health *health, uint32_t now_us)
{
    struct cds_servos *servos = health->servos;
    struct cds_servo_state *servo;

    health->news = servos->news;
    health->returned = next_with(servos, CDS_PRESENCE_RETURNED, health->returned);
    health->returned_us = now_us;
    if (health->returned == servos->count)
        return;
    servo = &servos->states[health->returned];
    if (servo->status_return_level == 0) {
        servo->presence = CDS_PRESENCE_ONLINE;
        cds_servos_inhibit(servos, servo, CDS_INHIBIT_STATE_LOST);
        health->news--; // the next poll looks for another one
    }
}

static void seek(struct cds_health *health, uint32_t now_us)
{
    uint8_t index = next_with(health->servos, CDS_PRESENCE_OFFLINE, health->sought);

    if (index < health->servos->count) {
        if (!ask(health, index))
            return;
        health->sought = index;
    }
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
    uint32_t now_us = cds_port_now_us();
    uint8_t count;

    OPTIMIZER_BARRIER(health);
    if (!health->is_running || health->request.result == CDS_PENDING)
        return;
    count = health->servos->count;
    if (health->news != health->servos->news)
        find_returned(health, now_us);
    if (health->returned < count && is_due(health->returned_us, now_us)) {
        if (ask(health, health->returned))
            health->returned_us = now_us + CDS_HEALTH_SEEK_US;
    } else if (is_due(health->seek_us, now_us)) {
        seek(health, now_us);
    } else if (count && is_due(health->look_us, now_us)) {
        look(health, now_us);
    }
}

void cds_health_abort(struct cds_health *health)
{
    if (health->is_running)
        cds_bus_cancel(health->servos->bus, &health->request);
    health->is_running = false;
}
