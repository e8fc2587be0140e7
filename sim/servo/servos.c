/* SPDX-License-Identifier: MIT */
#include "servo/servos.h"

#include <stdlib.h>

#include "memory.h"

#define SECOND_US  1000000u
#define STAGGER_US 80 // servos tick one after the other: 50 servos fill the 4 ms

static uint64_t cycles(const struct servos *servos, uint64_t us)
{
    return us * servos->clock_Hz / SECOND_US;
}

/* The manual: 2 000 000 / (register + 1) bit/s. */
static uint32_t bit_time_256(const struct servos *servos, uint8_t baud)
{
    return (uint32_t)((uint64_t)servos->clock_Hz * 256 * (baud + 1u) / 2000000u);
}

/* --- hearing --- */

static void byte_received(void *context, uint64_t now, const struct uart_frame *frame);

static struct servo_receiver *receiver_for(struct servos *servos, uint8_t baud)
{
    if (!servos->receivers[baud]) {
        struct servo_receiver *receiver = memory_checked(calloc(1, sizeof(*receiver)));
        *receiver = (struct servo_receiver){.servos = servos, .baud = baud};
        uart_rx_init(&receiver->rx, servos->schedule, servos->net, receiver);
        receiver->rx.on_byte = byte_received;
        receiver->rx.bit_time_256 = bit_time_256(servos, baud);
        servos->receivers[baud] = receiver;
    }
    return servos->receivers[baud];
}

static void use_receiver(struct servos *servos, uint8_t baud, int users)
{
    struct servo_receiver *receiver = receiver_for(servos, baud);
    receiver->users += (unsigned)users;
    if (receiver->rx.enabled != (receiver->users > 0)) {
        uart_rx_enable(&receiver->rx, receiver->users > 0);
    }
}

/* Lets the servo listen at the rate that its register has now. The caller waits for the end of a
 * reply: a receiver at the new rate would be in a frame of the reply when the next packet begins,
 * and would lose that packet. */
static void follow_baud(struct servo_node *node)
{
    uint8_t baud = servo_baud(&node->servo);
    if (baud != node->baud) {
        node->has_wrong_baud = false;
        use_receiver(node->servos, node->baud, -1);
        use_receiver(node->servos, baud, 1);
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
    driver_exempt(&node->driver, node->has_wrong_baud || node->extra_delay_us ||
                                     (servos->duplicates && shares_id(node)));
    node->power_loss_after = SERVOS_NEVER;
    node->off_cycles = 0;
    node->servo.reply.delay_us += node->extra_delay_us;
    if (servos->fault_on_reply) {
        servos->fault_on_reply(servos->fault_context, node);
    }
    uint64_t delay = cycles(servos, node->servo.reply.delay_us);
    schedule_at(servos->schedule, &node->reply_delay, end + delay);
}

/* A slightly fast sender begins a byte before the receiver's stop bit has ended: the silence is
 * then 0. */
static uint64_t silence_before(const struct servo_receiver *receiver,
                               const struct uart_frame *frame)
{
    uint64_t silence = frame->start > receiver->end ? frame->start - receiver->end : 0;
    return silence * SECOND_US / receiver->servos->clock_Hz;
}

/* The receiver delivers in the middle of the stop bit. The return delay counts from its end. */
static void byte_received(void *context, uint64_t now, const struct uart_frame *frame)
{
    (void)now;
    struct servo_receiver *receiver = context;
    struct servos *servos = receiver->servos;
    uint8_t baud = receiver->baud;
    uint64_t silence_us = silence_before(receiver, frame);
    receiver->end = frame->end;
    for (unsigned i = 0; i < servos->count; i++) {
        struct servo_node *node = &servos->node[i];
        if (node->baud != baud || node->driver.enabled || event_armed(&node->reply_delay)) {
            continue;
        }
        servo_silence(&node->servo, silence_us);
        if (servo_receive(&node->servo, frame->byte, frame->framing_error)) {
            reply_is_due(node, frame->end);
        } else {
            follow_baud(node);
        }
    }
}

/* --- talking --- */

static void set_sending(struct servo_node *node, uint64_t now, bool sending)
{
    if (node->driver.enabled == sending) {
        return;
    }
    driver_enable(&node->driver, now, sending);
    if (node->servos->on_drive) {
        node->servos->on_drive(node->servos->context, now, node);
    }
}

static void say_next(struct servo_node *node, uint64_t now)
{
    const struct servo_reply *reply = &node->servo.reply;
    uint8_t byte = reply->bytes[node->bytes_sent++];
    uart_tx_send(&node->tx, now, bit_time_256(node->servos, reply->baud), byte);
}

/* Sends the next byte of the reply, or ends the reply, or cuts the power as a fault orders. */
static void send_next(struct servo_node *node, uint64_t now)
{
    if (node->bytes_sent == node->power_loss_after && node->off_cycles) {
        servo_node_brown_out(node, now, node->off_cycles);
    } else if (node->bytes_sent == node->power_loss_after) {
        servo_node_power(node, now, true);
    } else if (node->bytes_sent < node->servo.reply.size) {
        say_next(node, now);
        set_sending(node, now, true);
    } else {
        set_sending(node, now, false);
        follow_baud(node);
    }
}

static void answer(void *context, uint64_t now)
{
    struct servo_node *node = context;
    node->bytes_sent = 0;
    send_next(node, now);
}

static void byte_begins(void *context, uint64_t now)
{
    struct servo_node *node = context;
    struct servos *servos = node->servos;
    if (servos->fault_on_byte) {
        servos->fault_on_byte(servos->fault_context, now, node);
    }
    if (servos->on_byte) {
        servos->on_byte(servos->context, now, node);
    }
}

static void byte_ended(void *context, uint64_t now)
{
    send_next(context, now);
}

static void stop_reply(struct servo_node *node, uint64_t now)
{
    schedule_cancel(node->servos->schedule, &node->reply_delay);
    uart_tx_stop(&node->tx, now);
    if (node->driver.enabled) {
        set_sending(node, now, false);
    }
}

/* --- all servos of a bus --- */

static void tick(void *context, uint64_t now)
{
    struct servo_node *node = context;
    servo_tick(&node->servo);
    schedule_at(node->servos->schedule, &node->tick, now + cycles(node->servos, SERVO_TICK_US));
}

static void return_power(void *context, uint64_t now)
{
    servo_node_power(context, now, true);
}

/* Never 0, and different for each servo, also for servos with the same ID. */
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
        stop_reply(node, now);
        schedule_cancel(servos->schedule, &node->tick);
        schedule_cancel(servos->schedule, &node->power_return);
        use_receiver(servos, node->baud, -1);
    }
    free(servos->node);
    servos->node = 0;
    servos->count = 0;
}

void servos_free(struct servos *servos)
{
    if (!servos->schedule) {
        return; // servos_init() was not called: the set-up has failed
    }
    remove_all(servos, servos->schedule->now);
    for (unsigned i = 0; i < 256; i++) {
        free(servos->receivers[i]);
        servos->receivers[i] = 0;
    }
}

void servos_replace(struct servos *servos, uint64_t now, const uint8_t *ids, unsigned count)
{
    remove_all(servos, now);
    servos->node = memory_checked(calloc(count ? count : 1, sizeof(*servos->node)));
    servos->count = count;
    for (unsigned i = 0; i < count; i++) {
        struct servo_node *node = &servos->node[i];
        node->servos = servos;
        node->id = ids[i];
        servo_init(&node->servo, ids[i]);
        driver_init(&node->driver, servos->net);
        uart_tx_init(&node->tx, servos->schedule, &node->driver, node);
        node->tx.on_start = byte_begins;
        node->tx.on_end = byte_ended;
        event_init(&node->reply_delay, answer, node);
        event_init(&node->tick, tick, node);
        event_init(&node->power_return, return_power, node);
        node->servo.quirks.seed = jitter_seed(servos->seed, i, ids[i]);
        node->baud = servo_baud(&node->servo);
        use_receiver(servos, node->baud, 1);
        uint64_t phase = cycles(servos, i * STAGGER_US % SERVO_TICK_US);
        schedule_at(servos->schedule, &node->tick, now + cycles(servos, SERVO_TICK_US) + phase);
    }
}

void servo_node_power(struct servo_node *node, uint64_t now, bool on)
{
    schedule_cancel(node->servos->schedule, &node->power_return);
    stop_reply(node, now);
    servo_power(&node->servo, on);
    follow_baud(node);
}

void servo_node_brown_out(struct servo_node *node, uint64_t now, uint64_t cycles)
{
    if (node->servo.powered) {
        servo_node_power(node, now, false);
        schedule_at(node->servos->schedule, &node->power_return, now + cycles);
    }
}

void servo_node_baud(struct servo_node *node, uint8_t baud)
{
    node->servo.registers[TABLE_BAUD] = baud;
    follow_baud(node);
    node->has_wrong_baud = true;
}

void servos_power(struct servos *servos, uint64_t now, bool on)
{
    for (unsigned i = 0; i < servos->count; i++) {
        servo_node_power(&servos->node[i], now, on);
    }
}

bool servos_set_eeprom(struct servos *servos, unsigned index,
                       const uint8_t bytes[SERVO_EEPROM_SIZE])
{
    struct servo_node *node = &servos->node[index];
    bool good = servo_set_eeprom(&node->servo, bytes);
    follow_baud(node);
    return good;
}

bool servos_have(const struct servos *servos, uint8_t id)
{
    for (unsigned i = 0; i < servos->count; i++) {
        if (servos->node[i].servo.registers[TABLE_ID] == id) {
            return true;
        }
    }
    return false;
}
