/* SPDX-License-Identifier: MIT */
#include "script/faults.h"

#include <inttypes.h>
#include <string.h>

#include "script/fault_verbs.h"

#define DEFAULT_bps 1000000u
#define GAP_BITS    30 // silence that ends a packet of the controller

enum { HEADER = 0xFF };

/* --- exemption from the rules --- */

void fault_exempt_senders(struct faults *faults, uint64_t until)
{
    faults->exempts_replies = true;
    faults->exempts_until = until > faults->exempts_until ? until : faults->exempts_until;
    for (unsigned i = 0; i < faults->servos->count; i++) {
        struct servo_node *node = &faults->servos->node[i];
        if (node->driver.enabled || event_armed(&node->reply_delay)) {
            driver_exempt(&node->driver, true);
        }
    }
}

void faults_controller_reset(struct faults *faults, uint64_t now)
{
    faults->resets++;
    fault_exempt_senders(faults, now);
}

void fault_notify(struct faults *faults, uint64_t now, uint64_t until, enum fault_verb verb)
{
    faults->acts++;
    if (faults->on_act) {
        faults->on_act(faults->context, now, until, fault_verb_name(verb));
    }
}

void fault_find_absent(const struct faults *faults, const struct fault_order *order,
                       bool absent[IDS_MAX])
{
    for (unsigned id = 0; id < IDS_MAX; id++) {
        absent[id] |= order->ids[id] && !servos_have(faults->servos, (uint8_t)id);
    }
}

/* --- overrides of the wire --- */

static enum net_override get_override(void *context, uint64_t time)
{
    const struct faults *faults = context;
    enum net_override override = faults->stuck;
    for (unsigned i = 0; override != NET_LOW && override != NET_HIGH && i < faults->pulses; i++) {
        const struct fault_pulse *pulse = &faults->pulse[i];
        if (time < pulse->from || time >= pulse->until) {
            continue;
        }
        bool twice = override == NET_INVERTED && pulse->override == NET_INVERTED;
        override = twice ? NET_AS_DRIVEN : pulse->override;
    }
    return override;
}

/* Drops overrides that have ended, and arms itself for the next edge of an override. */
static void edge(void *context, uint64_t now)
{
    struct faults *faults = context;
    uint64_t next = SCHEDULE_NEVER;
    unsigned kept = 0;
    for (unsigned i = 0; i < faults->pulses; i++) {
        struct fault_pulse pulse = faults->pulse[i];
        uint64_t time = pulse.from > now ? pulse.from : pulse.until;
        if (time > now) {
            faults->pulse[kept++] = pulse;
            next = time < next ? time : next;
        }
    }
    faults->pulses = kept;
    if (kept) {
        schedule_at(faults->schedule, &faults->edge, next);
    }
    net_update(faults->sig, now);
}

void fault_override(struct faults *faults, uint64_t now, struct fault_pulse pulse)
{
    if (faults->pulses < FAULTS_PULSES_MAX) {
        faults->pulse[faults->pulses++] = pulse;
        schedule_at(faults->schedule, &faults->edge, now);
    }
    fault_exempt_senders(faults, pulse.until);
}

/* --- orders --- */

static const char *add_pending(struct faults *faults, const struct fault_order *order)
{
    if (faults->pending_count == FAULTS_PENDING_MAX) {
        return "64 faults wait for their packets already";
    }
    struct pending_fault *pending = &faults->pending[faults->pending_count++];
    *pending = (struct pending_fault){.order = *order};
    pending->order.packet +=
        order->from_servo ? faults->replies : faults->controller_packet.packets;
    return 0;
}

static const char *change_servos(struct faults *faults, const struct fault_order *order,
                                 uint64_t now)
{
    bool found[IDS_MAX] = {false};
    for (unsigned i = 0; i < faults->servos->count; i++) {
        uint8_t id = faults->servos->node[i].servo.registers[TABLE_ID];
        if (order->ids[id]) {
            found[id] = true;
            struct servo_node *node = &faults->servos->node[i];
            fault_notify(faults, now, fault_verbs[order->verb].servo(faults, order, now, node),
                         order->verb);
        }
    }
    return memcmp(found, order->ids, sizeof(found)) == 0
               ? 0
               : "no servo has that ID; a fault takes the IDs of this moment";
}

const char *faults_order(struct faults *faults, uint64_t now, const char *text)
{
    struct fault_order order;
    const char *wrong = fault_order_parse(&order, text);
    if (wrong) {
        return wrong;
    }
    if (order.verb == FAULT_ECHO && !faults->echo.net) {
        return "there is no controller's receiver to join to the wire";
    }
    faults->orders++;
    if (fault_verbs[order.verb].servo) {
        return change_servos(faults, &order, now);
    }
    if (fault_verbs[order.verb].now) {
        fault_verbs[order.verb].now(faults, &order, now);
        return 0;
    }
    return add_pending(faults, &order);
}

const char *faults_check(const char *text)
{
    struct fault_order order;
    return fault_order_parse(&order, text);
}

/* --- packets and bytes by sender --- */

static bool is_for(const struct fault_order *order, bool from_servo, uint32_t packet)
{
    return order->from_servo == from_servo && (order->every || order->packet == packet);
}

/* Drops orders for packets before `packet`. */
static void drop_orders(struct faults *faults, bool from_servo, uint32_t packet)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < faults->pending_count; i++) {
        struct pending_fault *pending = &faults->pending[i];
        const struct fault_order *order = &pending->order;
        if (order->from_servo == from_servo && !order->every && order->packet < packet) {
            faults->unused += !pending->acted;
        } else {
            faults->pending[kept++] = *pending;
        }
    }
    faults->pending_count = kept;
}

static void act_on_byte(struct faults *faults, uint64_t now, bool from_servo, uint32_t packet,
                        unsigned byte, const struct uart_tx *tx)
{
    for (unsigned i = 0; i < faults->pending_count; i++) {
        struct pending_fault *pending = &faults->pending[i];
        if (fault_verbs[pending->order.verb].byte && is_for(&pending->order, from_servo, packet) &&
            pending->order.number[0] == byte) {
            pending->acted = true;
            fault_verbs[pending->order.verb].byte(faults, &pending->order, now, tx);
        }
    }
}

/* Returns the number of the oldest reply that is being sent or is due. */
static uint32_t oldest_reply(const struct faults *faults)
{
    uint32_t oldest = faults->replies;
    for (unsigned i = 0; i < faults->servos->count; i++) {
        const struct servo_node *node = &faults->servos->node[i];
        bool under_way = node->driver.enabled || event_armed(&node->reply_delay);
        oldest = under_way && node->reply < oldest ? node->reply : oldest;
    }
    return oldest;
}

/* A servo may reply unexpectedly to what a fault made of a packet, or to what remains of an earlier
 * packet. Such a reply is exempt from the rules. */
static void reply_due(void *fault_context, struct servo_node *node)
{
    struct faults *faults = fault_context;
    const struct controller_packet *controller_packet = &faults->controller_packet;
    node->reply = ++faults->replies;
    drop_orders(faults, true, oldest_reply(faults));
    bool exempt =
        (faults->acts || faults->resets) &&
        (faults->exempts_replies || node->has_partial_packet || !controller_packet->complete);
    for (unsigned i = 0; i < faults->pending_count; i++) {
        struct pending_fault *pending = &faults->pending[i];
        if (fault_verbs[pending->order.verb].reply && is_for(&pending->order, true, node->reply)) {
            if (fault_verbs[pending->order.verb].reply(&pending->order, node)) {
                pending->acted = exempt = true;
                fault_notify(faults, faults->schedule->now, faults->schedule->now,
                             pending->order.verb);
            }
        }
    }
    driver_exempt(&node->driver, node->driver.exempt || exempt);
}

static void servo_byte(void *fault_context, uint64_t now, const struct servo_node *node)
{
    act_on_byte(fault_context, now, true, node->reply, node->bytes_sent - 1u, &node->tx);
}

static void begin_packet(struct faults *faults, uint64_t now)
{
    faults->controller_packet =
        (struct controller_packet){.packets = faults->controller_packet.packets + 1};
    drop_orders(faults, false, faults->controller_packet.packets);
    uint64_t frame = uart_cycles_of_half_bits(faults->bit_time_256, 2 * UART_FRAME_BITS);
    faults->exempts_replies =
        faults->babbling != FAULT_BABBLE_OFF || faults->stuck != NET_AS_DRIVEN ||
        now < faults->exempts_until + frame; // a frame with wrong bits may still continue
    for (unsigned i = 0; i < faults->servos->count; i++) {
        struct servo_node *node = &faults->servos->node[i];
        node->has_partial_packet = node->servo.codec.size > node->servo.codec.first;
    }
}

/* Any number of header bytes is one header (R27). LENGTH counts the bytes after it. */
static void follow_packet(struct controller_packet *controller_packet, uint8_t byte)
{
    if (!controller_packet->id && byte != HEADER && controller_packet->byte >= 2) {
        controller_packet->id = controller_packet->byte;
    }
    if (controller_packet->id && controller_packet->byte == controller_packet->id + 1) {
        controller_packet->size = controller_packet->byte + 1 + byte;
    }
    controller_packet->complete = controller_packet->byte + 1 == controller_packet->size;
}

void faults_controller_byte(struct faults *faults, uint64_t now, const struct uart_tx *tx)
{
    struct controller_packet *controller_packet = &faults->controller_packet;
    uint64_t gap = uart_cycles_of_half_bits(tx->bit_time_256, 2 * GAP_BITS);
    faults->bit_time_256 = tx->bit_time_256;
    if (controller_packet->complete || !controller_packet->packets ||
        now > controller_packet->end + gap) {
        begin_packet(faults, now);
    } else {
        controller_packet->byte++;
    }
    controller_packet->end = uart_tx_end(tx);
    follow_packet(controller_packet, (uint8_t)(tx->frame >> 1));
    act_on_byte(faults, now, false, controller_packet->packets, controller_packet->byte, tx);
}

/* --- set-up --- */

void faults_init(struct faults *faults, struct schedule *schedule, struct servos *servos,
                 uint32_t seed)
{
    uint32_t mixed = seed * 0x9E3779B1u ^ 0x85EBCA77u;
    *faults = (struct faults){.schedule = schedule,
                              .servos = servos,
                              .sig = servos->net,
                              .bit_time_256 = uart_bit_time_256(servos->clock_Hz, DEFAULT_bps),
                              .random = mixed ? mixed : 1};
    servos->fault_context = faults;
    servos->fault_on_reply = reply_due;
    servos->fault_on_byte = servo_byte;
    faults->sig->context = faults;
    faults->sig->get_override = get_override;
    event_init(&faults->edge, edge, faults);
    faults->edge.rank = NET_OVERRIDE_RANK;
    fault_verbs_init(faults);
}

/* An unplug that waits for its packet may name a servo that is not there when the packet comes. */
static void report_absent(const struct faults *faults, const char *where, FILE *out)
{
    char list[64];
    bool absent[IDS_MAX];
    memcpy(absent, faults->absent, sizeof(absent));
    for (unsigned i = 0; i < faults->pending_count; i++) {
        if (!faults->pending[i].acted) {
            fault_find_absent(faults, &faults->pending[i].order, absent);
        }
    }
    if (memchr(absent, true, sizeof(absent))) {
        fprintf(out, "faults:  %sunplug named servos that were not there: %s\n", where,
                ids_print(absent, list, sizeof(list)));
    }
}

void faults_report(const struct faults *faults, const char *where, FILE *out)
{
    if (!faults->orders) {
        return;
    }
    uint32_t idle = faults->unused;
    for (unsigned i = 0; i < faults->pending_count; i++) {
        idle += !faults->pending[i].acted;
    }
    fprintf(out,
            "faults:  %sacted %" PRIu32 " times; %" PRIu32 " of %" PRIu32
            " orders came to nothing\n",
            where, faults->acts, idle, faults->orders);
    report_absent(faults, where, out);
}
