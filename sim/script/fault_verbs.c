/* SPDX-License-Identifier: MIT */
#include "script/fault_verbs.h"

#include <string.h>

#define SECOND_US 1000000u

enum { HEADER = 0xFF, OFFSET_ID = 2, OFFSET_LENGTH = 3 };

static uint64_t cycles(const struct faults *faults, uint64_t us)
{
    return us * faults->servos->clock_Hz / SECOND_US;
}

static uint32_t random_number(struct faults *faults)
{
    faults->random ^= faults->random << 13;
    faults->random ^= faults->random >> 17;
    faults->random ^= faults->random << 5;
    return faults->random;
}

/* --- faults that act when a byte begins --- */

static void flip_bits(struct faults *faults, const struct fault_order *order, uint64_t now,
                      const struct uart_tx *tx)
{
    for (unsigned i = 1; i < order->numbers; i++) {
        unsigned bit = order->number[i];
        uint64_t from = uart_tx_bit_time(tx, bit);
        uint64_t until = uart_tx_bit_time(tx, bit + 1);
        fault_override(faults, now, (struct fault_pulse){from, until, NET_INVERTED});
        fault_notify(faults, from, until, order->verb);
    }
}

static void lose_byte(struct faults *faults, const struct fault_order *order, uint64_t now,
                      const struct uart_tx *tx)
{
    uint64_t until = uart_tx_end(tx);
    fault_override(faults, now, (struct fault_pulse){now, until, NET_HIGH});
    fault_notify(faults, now, until, order->verb);
}

/* Servos lose power when the byte begins. */
static void unplug(struct faults *faults, const struct fault_order *order, uint64_t now,
                   const struct uart_tx *tx)
{
    (void)tx;
    uint64_t time = cycles(faults, order->number[1] * 1000ull);
    fault_find_absent(faults, order, faults->absent);
    for (unsigned i = 0; i < faults->servos->count; i++) {
        struct servo_node *node = &faults->servos->node[i];
        if (order->ids[node->servo.registers[TABLE_ID]]) {
            servo_node_brown_out(node, now, time);
            fault_notify(faults, now, now + time, order->verb);
        }
    }
}

/* --- faults that change a reply before it is sent --- */

static void set_byte(struct servo_reply *reply, unsigned at, uint8_t value)
{
    reply->bytes[at] = value;
    unsigned sum = 0;
    for (unsigned i = OFFSET_ID; i + 1 < reply->size; i++) {
        sum += reply->bytes[i];
    }
    reply->bytes[reply->size - 1] = (uint8_t)~sum;
}

static bool set_id(const struct fault_order *order, struct servo_node *node)
{
    set_byte(&node->servo.reply, OFFSET_ID, (uint8_t)order->number[0]);
    return true;
}

static bool set_length(const struct fault_order *order, struct servo_node *node)
{
    set_byte(&node->servo.reply, OFFSET_LENGTH, (uint8_t)order->number[0]);
    return true;
}

static bool insert_byte(const struct fault_order *order, struct servo_node *node)
{
    struct servo_reply *reply = &node->servo.reply;
    unsigned at = order->number[0];
    if (at > reply->size || reply->size == SERVO_PACKET_MAX) {
        return false;
    }
    memmove(reply->bytes + at + 1, reply->bytes + at, reply->size - at);
    reply->bytes[at] = (uint8_t)order->number[1];
    reply->size++;
    return true;
}

static bool cut_reply(const struct fault_order *order, struct servo_node *node)
{
    uint64_t ms = order->numbers > 1 ? order->number[1] : 0;
    node->power_loss_after = (uint16_t)order->number[0];
    node->off_cycles = ms * node->servos->clock_Hz / 1000u;
    return node->power_loss_after <= node->servo.reply.size;
}

static bool delay_reply(const struct fault_order *order, struct servo_node *node)
{
    node->servo.reply.delay_us += order->number[0];
    return true;
}

/* --- faults that act on a servo at once --- */

static uint64_t brown_out(struct faults *faults, const struct fault_order *order, uint64_t now,
                          struct servo_node *node)
{
    uint64_t time = cycles(faults, order->number[0] * 1000ull);
    servo_node_brown_out(node, now, time);
    return now + time;
}

/* Among servos that share an ID, each one replies later than the one before. */
static uint64_t add_delay(struct faults *faults, const struct fault_order *order, uint64_t now,
                          struct servo_node *node)
{
    unsigned place = 1;
    for (const struct servo_node *other = faults->servos->node; other < node; other++) {
        place += other->servo.registers[TABLE_ID] == node->servo.registers[TABLE_ID];
    }
    node->extra_delay_us = order->number[0] * place;
    return now;
}

static uint64_t set_baud(struct faults *faults, const struct fault_order *order, uint64_t now,
                         struct servo_node *node)
{
    (void)faults;
    servo_node_baud(node, (uint8_t)order->number[0]);
    return now;
}

static uint64_t set_quirk(struct faults *faults, const struct fault_order *order, uint64_t now,
                          struct servo_node *node)
{
    (void)faults;
    struct servo_quirks *quirks = &node->servo.quirks;
    uint16_t value = (uint16_t)order->number[0];
    switch ((enum fault_quirk)order->choice) {
    case FAULT_QUIRK_SILENT: quirks->silent_after_power_up = value; break;
    case FAULT_QUIRK_SYNC_WRITE: quirks->sync_write_limit = value; break;
    case FAULT_QUIRK_TURNAROUND: quirks->extra_turnaround_us = value; break;
    case FAULT_QUIRK_JITTER: quirks->jitter_us = value; break;
    case FAULT_QUIRKS: break;
    }
    return now;
}

/* --- faults that last --- */

static void set_stuck(struct faults *faults, uint64_t now, enum net_override stuck)
{
    schedule_cancel(faults->schedule, &faults->unstick);
    faults->stuck = stuck;
    fault_exempt_senders(faults, now);
    schedule_at(faults->schedule, &faults->edge, now);
}

static void unstick(void *context, uint64_t now)
{
    set_stuck(context, now, NET_AS_DRIVEN);
}

static void stick(struct faults *faults, const struct fault_order *order, uint64_t now)
{
    static const enum net_override stuck[] = {[FAULT_STUCK_OFF] = NET_AS_DRIVEN,
                                              [FAULT_STUCK_LOW] = NET_LOW,
                                              [FAULT_STUCK_HIGH] = NET_HIGH};
    uint64_t until = now;
    set_stuck(faults, now, stuck[order->choice]);
    if (order->numbers) {
        until = now + cycles(faults, order->number[0] * 1000ull);
        schedule_at(faults->schedule, &faults->unstick, until);
    }
    fault_notify(faults, now, until, order->verb);
}

/* The next flip comes after up to 2 mean distances. */
static void plan_flip(struct faults *faults, uint64_t now)
{
    uint32_t mean = faults->servos->clock_Hz / faults->noise;
    schedule_at(faults->schedule, &faults->flip, now + 1 + random_number(faults) % (2 * mean));
}

/* A flip lasts one bit time, so it covers the middle of exactly one bit. */
static void flip(void *context, uint64_t now)
{
    struct faults *faults = context;
    uint64_t until = now + uart_cycles_of_half_bits(faults->bit_time_256, 2);
    fault_override(faults, now, (struct fault_pulse){now, until, NET_INVERTED});
    fault_notify(faults, now, until, FAULT_NOISE);
    plan_flip(faults, now);
}

static void make_noise(struct faults *faults, const struct fault_order *order, uint64_t now)
{
    schedule_cancel(faults->schedule, &faults->flip);
    faults->noise = order->number[0];
    if (faults->noise) {
        plan_flip(faults, now);
    }
}

static void babble_on(void *context, uint64_t now)
{
    struct faults *faults = context;
    driver_enable(&faults->babbler, now, faults->babbling != FAULT_BABBLE_OFF);
    if (faults->babbling == FAULT_BABBLE_OFF) {
        return;
    }
    uint8_t byte = faults->babble_byte;
    if (faults->babbling == FAULT_BABBLE_RANDOM) {
        byte = (uint8_t)(random_number(faults) >> 8);
    }
    uart_tx_send(&faults->babble, now, faults->bit_time_256, byte);
    fault_exempt_senders(faults, uart_tx_end(&faults->babble));
}

static void babble(struct faults *faults, const struct fault_order *order, uint64_t now)
{
    faults->babbling = (enum fault_babble)order->choice;
    faults->babble_byte = order->numbers ? (uint8_t)order->number[0] : HEADER;
    fault_notify(faults, now, now, order->verb);
    if (!faults->babble.busy) {
        babble_on(faults, now);
    }
}

static void set_echo(struct faults *faults, const struct fault_order *order, uint64_t now)
{
    driver_set(&faults->echo, now, order->choice == FAULT_ON, faults->sig->level);
    fault_notify(faults, now, now, order->verb);
}

static void sig_level(void *context, uint64_t now, bool level)
{
    struct faults *faults = context;
    driver_level(&faults->echo, now, level);
}

static void clear(struct faults *faults, const struct fault_order *order, uint64_t now)
{
    (void)order;
    (void)now;
    for (unsigned i = 0; i < faults->pending_count; i++) {
        faults->unused += !faults->pending[i].acted;
    }
    faults->pending_count = 0;
}

/* --- the verbs --- */

// clang-format off
const struct fault_verb_ops fault_verbs[FAULT_VERBS] = {
    [FAULT_FLIP] = {.byte = flip_bits},
    [FAULT_LOSE] = {.byte = lose_byte},
    [FAULT_INSERT] = {.reply = insert_byte},
    [FAULT_CUT] = {.reply = cut_reply},
    [FAULT_DELAY] = {.reply = delay_reply},
    [FAULT_ID] = {.reply = set_id},
    [FAULT_LENGTH] = {.reply = set_length},
    [FAULT_ECHO] = {.now = set_echo},
    [FAULT_BABBLE] = {.now = babble},
    [FAULT_STUCK] = {.now = stick},
    [FAULT_NOISE] = {.now = make_noise},
    [FAULT_BROWNOUT] = {.servo = brown_out},
    [FAULT_UNPLUG] = {.byte = unplug},
    [FAULT_TURNAROUND] = {.servo = add_delay},
    [FAULT_BAUD] = {.servo = set_baud},
    [FAULT_QUIRK] = {.servo = set_quirk},
    [FAULT_CLEAR] = {.now = clear},
};
// clang-format on

void fault_verbs_init(struct faults *faults)
{
    event_init(&faults->unstick, unstick, faults);
    event_init(&faults->flip, flip, faults);
    driver_init(&faults->babbler, faults->sig);
    driver_exempt(&faults->babbler, true);
    uart_tx_init(&faults->babble, faults->schedule, &faults->babbler, faults);
    faults->babble.on_end = babble_on;
}

void faults_connect_receiver(struct faults *faults, struct net *rxd)
{
    driver_init(&faults->echo, rxd);
    faults->on_sig = (struct listener){.context = faults, .on_level = sig_level};
    net_listen(faults->sig, &faults->on_sig);
}
