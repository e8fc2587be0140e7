#include "servo/servos.h"

#include <stdio.h>
#include <stdlib.h>

#define SECOND_US  1000000u
#define STAGGER_US 80 // servos tick one after the other: 50 of them fill the 4 ms

static uint64_t cycles(const struct servos *servos, uint64_t us)
{
    return us * servos->clock_Hz / SECOND_US;
}

/* The manual: 2 000 000 / (register + 1) baud. */
static uint32_t bit_256(const struct servos *servos, uint8_t baud)
{
    return (uint32_t)((uint64_t)servos->clock_Hz * 256 * (baud + 1u) / 2000000u);
}

static void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    if (!memory) {
        fputs("out of memory\n", stderr);
        abort();
    }
    return memory;
}

/* --- hearing -------------------------------------------------------------------------------------
 */

static void byte_heard(void *owner, uint64_t now, const struct heard *heard);

static struct servo_ear *ear_for(struct servos *servos, uint8_t baud)
{
    if (!servos->ears[baud]) {
        struct servo_ear *ear = allocate(1, sizeof(*ear));
        *ear = (struct servo_ear){.servos = servos, .baud = baud};
        ear_init(&ear->ear, servos->schedule, servos->net, ear);
        ear->ear.on_byte = byte_heard;
        ear->ear.bit_256 = bit_256(servos, baud);
        servos->ears[baud] = ear;
    }
    return servos->ears[baud];
}

static void use_ear(struct servos *servos, uint8_t baud, int users)
{
    struct servo_ear *ear = ear_for(servos, baud);
    ear->users += (unsigned)users;
    if (ear->ear.enabled != (ear->users > 0)) {
        ear_enable(&ear->ear, ear->users > 0);
    }
}

static void follow_baud(struct servo_node *node)
{
    uint8_t baud = servo_baud(&node->servo);
    if (baud != node->baud) {
        node->misled = false;
        use_ear(node->servos, node->baud, -1);
        use_ear(node->servos, baud, 1);
        node->baud = baud;
    }
}

static bool shares_id(const struct servo_node *node)
{
    const struct servos *servos = node->servos;
    uint8_t id = node->servo.registers[TABLE_ID];
    for (unsigned i = 0; i < servos->count; i++) {
        const struct servo_node *other = &servos->node[i];
        if (other != node && other->servo.registers[TABLE_ID] == id) {
            return true;
        }
    }
    return false;
}

static void reply_is_due(struct servo_node *node, uint64_t end)
{
    struct servos *servos = node->servos;
    driver_excuse(&node->driver,
                  node->misled || node->late_us || (servos->duplicates && shares_id(node)));
    node->dies_after = SERVOS_NEVER;
    node->dark = 0;
    node->servo.reply.delay_us += node->late_us;
    if (servos->on_due) {
        servos->on_due(servos->meddler, node);
    }
    uint64_t delay = cycles(servos, node->servo.reply.delay_us);
    schedule_at(servos->schedule, &node->answer, end + delay);
}

/* A sender that is a little fast begins a byte before the ear's stop bit has ended. */
static uint64_t silence_before(const struct servo_ear *ear, const struct heard *heard)
{
    uint64_t silence = heard->start > ear->end ? heard->start - ear->end : 0;
    return silence * SECOND_US / ear->servos->clock_Hz;
}

/* The ear delivers in the middle of the stop bit; the return delay counts from its end. */
static void byte_heard(void *owner, uint64_t now, const struct heard *heard)
{
    (void)now;
    struct servo_ear *ear = owner;
    struct servos *servos = ear->servos;
    uint8_t baud = ear->baud;
    uint64_t silence_us = silence_before(ear, heard);
    ear->end = heard->end;
    for (unsigned i = 0; i < servos->count; i++) {
        struct servo_node *node = &servos->node[i];
        if (node->baud != baud || node->driver.enabled || event_armed(&node->answer)) {
            continue;
        }
        servo_silence(&node->servo, silence_us);
        if (servo_receive(&node->servo, heard->byte, heard->framing_error)) {
            reply_is_due(node, heard->end);
        }
        follow_baud(node);
    }
}

/* --- talking -------------------------------------------------------------------------------------
 */

static void set_talking(struct servo_node *node, uint64_t now, bool talking)
{
    if (node->driver.enabled == talking) {
        return;
    }
    driver_enable(&node->driver, now, talking);
    if (node->servos->on_talk) {
        node->servos->on_talk(node->servos->owner, now, node);
    }
}

static void say_next(struct servo_node *node, uint64_t now)
{
    const struct servo_reply *reply = &node->servo.reply;
    uint8_t byte = reply->bytes[node->said++];
    talker_say(&node->talker, now, bit_256(node->servos, reply->baud), byte);
}

/* The next byte of the reply, or the end of it, or of the servo. */
static void go_on(struct servo_node *node, uint64_t now)
{
    if (node->said == node->dies_after && node->dark) {
        servo_node_brown_out(node, now, node->dark);
    } else if (node->said == node->dies_after) {
        servo_node_power(node, now, true);
    } else if (node->said < node->servo.reply.size) {
        say_next(node, now);
        set_talking(node, now, true);
    } else {
        set_talking(node, now, false);
    }
}

static void answer(void *owner, uint64_t now)
{
    struct servo_node *node = owner;
    node->said = 0;
    go_on(node, now);
}

static void byte_begins(void *owner, uint64_t now)
{
    struct servo_node *node = owner;
    struct servos *servos = node->servos;
    if (servos->on_frame) {
        servos->on_frame(servos->meddler, now, node);
    }
    if (servos->on_byte) {
        servos->on_byte(servos->owner, now, node);
    }
}

static void byte_ended(void *owner, uint64_t now)
{
    go_on(owner, now);
}

static void fall_silent(struct servo_node *node, uint64_t now)
{
    schedule_cancel(node->servos->schedule, &node->answer);
    talker_stop(&node->talker, now);
    if (node->driver.enabled) {
        set_talking(node, now, false);
    }
}

/* --- the set of them -----------------------------------------------------------------------------
 */

static void tick(void *owner, uint64_t now)
{
    struct servo_node *node = owner;
    servo_tick(&node->servo);
    schedule_at(node->servos->schedule, &node->tick, now + cycles(node->servos, SERVO_TICK_US));
}

static void revive(void *owner, uint64_t now)
{
    servo_node_power(owner, now, true);
}

/* Never 0, and another one for each servo, also where two have one ID. */
static uint32_t jitter_seed(uint32_t seed, unsigned index, uint8_t id)
{
    uint32_t mixed = seed * 0x9E3779B1u ^ (index + 1) * 0x85EBCA77u ^ (id + 1u) * 0xC2B2AE3Du;
    return mixed ? mixed : 1;
}

void servos_init(struct servos *servos, struct schedule *schedule, struct net *net,
                 uint32_t clock_Hz)
{
    *servos = (struct servos){.schedule = schedule, .net = net, .clock_Hz = clock_Hz};
}

static void remove_all(struct servos *servos, uint64_t now)
{
    for (unsigned i = 0; i < servos->count; i++) {
        struct servo_node *node = &servos->node[i];
        fall_silent(node, now);
        schedule_cancel(servos->schedule, &node->tick);
        schedule_cancel(servos->schedule, &node->revival);
        use_ear(servos, node->baud, -1);
    }
    free(servos->node);
    servos->node = 0;
    servos->count = 0;
}

void servos_free(struct servos *servos)
{
    if (!servos->schedule) {
        return; // servos_init() was not called: the bus could not be set up
    }
    remove_all(servos, servos->schedule->now);
    for (unsigned i = 0; i < 256; i++) {
        free(servos->ears[i]);
        servos->ears[i] = 0;
    }
}

void servos_replace(struct servos *servos, uint64_t now, const uint8_t *ids, unsigned count)
{
    remove_all(servos, now);
    servos->node = allocate(count ? count : 1, sizeof(*servos->node));
    servos->count = count;
    for (unsigned i = 0; i < count; i++) {
        struct servo_node *node = &servos->node[i];
        node->servos = servos;
        node->id = ids[i];
        servo_init(&node->servo, ids[i]);
        driver_init(&node->driver, servos->net);
        talker_init(&node->talker, servos->schedule, &node->driver, node);
        node->talker.on_start = byte_begins;
        node->talker.on_end = byte_ended;
        event_init(&node->answer, answer, node);
        event_init(&node->tick, tick, node);
        event_init(&node->revival, revive, node);
        node->servo.quirks.seed = jitter_seed(servos->seed, i, ids[i]);
        node->baud = servo_baud(&node->servo);
        use_ear(servos, node->baud, 1);
        uint64_t phase = cycles(servos, i * STAGGER_US % SERVO_TICK_US);
        schedule_at(servos->schedule, &node->tick, now + cycles(servos, SERVO_TICK_US) + phase);
    }
}

void servo_node_power(struct servo_node *node, uint64_t now, bool on)
{
    schedule_cancel(node->servos->schedule, &node->revival);
    fall_silent(node, now);
    servo_power(&node->servo, on);
    follow_baud(node);
}

void servo_node_brown_out(struct servo_node *node, uint64_t now, uint64_t cycles)
{
    if (node->servo.powered) {
        servo_node_power(node, now, false);
        schedule_at(node->servos->schedule, &node->revival, now + cycles);
    }
}

void servo_node_baud(struct servo_node *node, uint8_t baud)
{
    node->servo.registers[TABLE_BAUD] = baud;
    follow_baud(node);
    node->misled = true;
}

void servos_power(struct servos *servos, uint64_t now, bool on)
{
    for (unsigned i = 0; i < servos->count; i++) {
        servo_node_power(&servos->node[i], now, on);
    }
}

bool servos_eeprom_set(struct servos *servos, unsigned index,
                       const uint8_t bytes[SERVO_EEPROM_SIZE])
{
    struct servo_node *node = &servos->node[index];
    bool good = servo_eeprom_set(&node->servo, bytes);
    follow_baud(node);
    return good;
}
