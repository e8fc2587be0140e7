#include "script/faults.h"

#include <inttypes.h>
#include <string.h>

#define SECOND_US   1000000u
#define DEFAULT_bps 1000000u
#define GAP_BITS    30 // silence that ends a packet of the controller

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

/* --- who is to blame --- */

/* Until `until` the level of the wire is not that of its drivers. A servo that sends or is about to
 * send is exempt from the rules. */
static void disturb(struct faults *faults, uint64_t until)
{
    faults->disturbed = true;
    faults->disturbed_until = until > faults->disturbed_until ? until : faults->disturbed_until;
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
    disturb(faults, now);
}

static void notify(struct faults *faults, uint64_t now, uint64_t until, enum fault_verb verb)
{
    faults->acts++;
    if (faults->on_act) {
        faults->on_act(faults->context, now, until, fault_verb_name(verb));
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

static void override(struct faults *faults, uint64_t now, struct fault_pulse pulse)
{
    if (faults->pulses < FAULTS_PULSES_MAX) {
        faults->pulse[faults->pulses++] = pulse;
        schedule_at(faults->schedule, &faults->edge, now);
    }
    disturb(faults, pulse.until);
}

/* --- faults of a byte --- */

static void flip_bits(struct faults *faults, const struct fault_order *order, uint64_t now,
                      const struct uart_tx *tx)
{
    for (unsigned i = 1; i < order->numbers; i++) {
        unsigned bit = order->number[i];
        uint64_t from = uart_tx_bit_time(tx, bit);
        uint64_t until = uart_tx_bit_time(tx, bit + 1);
        override(faults, now, (struct fault_pulse){from, until, NET_INVERTED});
        notify(faults, from, until, order->verb);
    }
}

static void lose_byte(struct faults *faults, const struct fault_order *order, uint64_t now,
                      const struct uart_tx *tx)
{
    uint64_t until = uart_tx_end(tx);
    override(faults, now, (struct fault_pulse){now, until, NET_HIGH});
    notify(faults, now, until, order->verb);
}

/* --- faults of a reply --- */

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

/* --- faults of a servo --- */

static uint64_t brown_out(struct faults *faults, const struct fault_order *order, uint64_t now,
                          struct servo_node *node)
{
    uint64_t time = cycles(faults, order->number[0] * 1000ull);
    servo_node_brown_out(node, now, time);
    return now + time;
}

/* Runs when a byte of the controller begins. */
static void unplug(struct faults *faults, const struct fault_order *order, uint64_t now,
                   const struct uart_tx *tx)
{
    (void)tx;
    uint64_t time = cycles(faults, order->number[1] * 1000ull);
    for (unsigned i = 0; i < faults->servos->count; i++) {
        struct servo_node *node = &faults->servos->node[i];
        if (order->ids[node->servo.registers[TABLE_ID]]) {
            servo_node_brown_out(node, now, time);
            notify(faults, now, now + time, order->verb);
        }
    }
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
    disturb(faults, now);
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
    notify(faults, now, until, order->verb);
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
    uint64_t until = now + uart_half_bits(faults->bit_256, 2);
    override(faults, now, (struct fault_pulse){now, until, NET_INVERTED});
    notify(faults, now, until, FAULT_NOISE);
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
    uart_tx_send(&faults->babble, now, faults->bit_256, byte);
    disturb(faults, uart_tx_end(&faults->babble));
}

static void babble(struct faults *faults, const struct fault_order *order, uint64_t now)
{
    faults->babbling = (enum fault_babble)order->choice;
    faults->babble_byte = order->numbers ? (uint8_t)order->number[0] : HEADER;
    notify(faults, now, now, order->verb);
    if (!faults->babble.busy) {
        babble_on(faults, now);
    }
}

static void set_echo(struct faults *faults, const struct fault_order *order, uint64_t now)
{
    driver_set(&faults->echo, now, order->choice == FAULT_ON, faults->sig->level);
    notify(faults, now, now, order->verb);
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

/* --- orders --- */

/* What a verb acts on. `byte`: a byte that begins. `reply`: a reply that is due; returns false if
 * it cannot act. `servo`: a servo; returns the end of the fault. `now`: acts at once. */
static const struct {
    void (*byte)(struct faults *faults, const struct fault_order *order, uint64_t now,
                 const struct uart_tx *tx);
    bool (*reply)(const struct fault_order *order, struct servo_node *node);
    uint64_t (*servo)(struct faults *faults, const struct fault_order *order, uint64_t now,
                      struct servo_node *node);
    void (*now)(struct faults *faults, const struct fault_order *order, uint64_t now);
} verbs[FAULT_VERBS] = {
    [FAULT_FLIP] = {.byte = flip_bits},      [FAULT_LOSE] = {.byte = lose_byte},
    [FAULT_INSERT] = {.reply = insert_byte}, [FAULT_CUT] = {.reply = cut_reply},
    [FAULT_DELAY] = {.reply = delay_reply},  [FAULT_ID] = {.reply = set_id},
    [FAULT_LENGTH] = {.reply = set_length},  [FAULT_ECHO] = {.now = set_echo},
    [FAULT_BABBLE] = {.now = babble},        [FAULT_STUCK] = {.now = stick},
    [FAULT_NOISE] = {.now = make_noise},     [FAULT_BROWNOUT] = {.servo = brown_out},
    [FAULT_UNPLUG] = {.byte = unplug},       [FAULT_TURNAROUND] = {.servo = add_delay},
    [FAULT_BAUD] = {.servo = set_baud},      [FAULT_QUIRK] = {.servo = set_quirk},
    [FAULT_CLEAR] = {.now = clear},
};

static const char *add_pending(struct faults *faults, const struct fault_order *order)
{
    if (faults->pending_count == FAULTS_PENDING_MAX) {
        return "64 faults wait for their packets already";
    }
    struct pending_fault *pending = &faults->pending[faults->pending_count++];
    *pending = (struct pending_fault){.order = *order};
    pending->order.packet += order->out ? faults->replies : faults->packet_in.packets;
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
            notify(faults, now, verbs[order->verb].servo(faults, order, now, node), order->verb);
        }
    }
    return memcmp(found, order->ids, sizeof(found)) == 0 ? 0 : "no servo has that ID";
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
    if (verbs[order.verb].servo) {
        return change_servos(faults, &order, now);
    }
    if (verbs[order.verb].now) {
        verbs[order.verb].now(faults, &order, now);
        return 0;
    }
    return add_pending(faults, &order);
}

const char *faults_check(const char *text)
{
    struct fault_order order;
    return fault_order_parse(&order, text);
}

/* --- who begins which byte of which packet --- */

static bool is_for(const struct fault_order *order, bool out, uint32_t packet)
{
    return order->out == out && (order->every || order->packet == packet);
}

/* Drops orders for packets before `packet`. */
static void drop_orders(struct faults *faults, bool out, uint32_t packet)
{
    unsigned kept = 0;
    for (unsigned i = 0; i < faults->pending_count; i++) {
        struct pending_fault *pending = &faults->pending[i];
        const struct fault_order *order = &pending->order;
        if (order->out == out && !order->every && order->packet < packet) {
            faults->unused += !pending->acted;
        } else {
            faults->pending[kept++] = *pending;
        }
    }
    faults->pending_count = kept;
}

static void act_on_byte(struct faults *faults, uint64_t now, bool out, uint32_t packet,
                        unsigned byte, const struct uart_tx *tx)
{
    for (unsigned i = 0; i < faults->pending_count; i++) {
        struct pending_fault *pending = &faults->pending[i];
        if (verbs[pending->order.verb].byte && is_for(&pending->order, out, packet) &&
            pending->order.number[0] == byte) {
            pending->acted = true;
            verbs[pending->order.verb].byte(faults, &pending->order, now, tx);
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

/* A servo may reply unexpectedly to what a fault made of a packet, or to the rest of an earlier
 * packet. Such a reply is exempt from the rules. */
static void reply_due(void *fault_context, struct servo_node *node)
{
    struct faults *faults = fault_context;
    const struct controller_packet *packet_in = &faults->packet_in;
    node->reply = ++faults->replies;
    drop_orders(faults, true, oldest_reply(faults));
    bool exempt = (faults->acts || faults->resets) &&
                  (faults->disturbed || node->has_partial_packet || !packet_in->complete);
    for (unsigned i = 0; i < faults->pending_count; i++) {
        struct pending_fault *pending = &faults->pending[i];
        if (verbs[pending->order.verb].reply && is_for(&pending->order, true, node->reply)) {
            if (verbs[pending->order.verb].reply(&pending->order, node)) {
                pending->acted = exempt = true;
                notify(faults, faults->schedule->now, faults->schedule->now, pending->order.verb);
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
    faults->packet_in = (struct controller_packet){.packets = faults->packet_in.packets + 1};
    drop_orders(faults, false, faults->packet_in.packets);
    uint64_t frame = uart_half_bits(faults->bit_256, 2 * UART_FRAME_BITS);
    faults->disturbed =
        faults->babbling != FAULT_BABBLE_OFF || faults->stuck != NET_AS_DRIVEN ||
        now < faults->disturbed_until + frame; // a frame with wrong bits may still continue
    for (unsigned i = 0; i < faults->servos->count; i++) {
        struct servo_node *node = &faults->servos->node[i];
        node->has_partial_packet = node->servo.codec.size > node->servo.codec.first;
    }
}

/* Any number of header bytes is one header (R27). LENGTH counts the bytes after it. */
static void follow_packet(struct controller_packet *packet_in, uint8_t byte)
{
    if (!packet_in->id && byte != HEADER && packet_in->byte >= 2) {
        packet_in->id = packet_in->byte;
    }
    if (packet_in->id && packet_in->byte == packet_in->id + 1) {
        packet_in->size = packet_in->byte + 1 + byte;
    }
    packet_in->complete = packet_in->byte + 1 == packet_in->size;
}

void faults_controller_byte(struct faults *faults, uint64_t now, const struct uart_tx *tx)
{
    struct controller_packet *packet_in = &faults->packet_in;
    uint64_t gap = uart_half_bits(tx->bit_256, 2 * GAP_BITS);
    faults->bit_256 = tx->bit_256;
    if (packet_in->complete || !packet_in->packets || now > packet_in->end + gap) {
        begin_packet(faults, now);
    } else {
        packet_in->byte++;
    }
    packet_in->end = uart_tx_end(tx);
    follow_packet(packet_in, (uint8_t)(tx->frame >> 1));
    act_on_byte(faults, now, false, packet_in->packets, packet_in->byte, tx);
}

/* --- set-up --- */

void faults_init(struct faults *faults, struct schedule *schedule, struct servos *servos,
                 uint32_t seed)
{
    uint32_t mixed = seed * 0x9E3779B1u ^ 0x85EBCA77u;
    *faults = (struct faults){.schedule = schedule,
                              .servos = servos,
                              .sig = servos->net,
                              .bit_256 = uart_bit_256(servos->clock_Hz, DEFAULT_bps),
                              .random = mixed ? mixed : 1};
    servos->fault_context = faults;
    servos->fault_on_reply = reply_due;
    servos->fault_on_byte = servo_byte;
    faults->sig->context = faults;
    faults->sig->get_override = get_override;
    event_init(&faults->edge, edge, faults);
    faults->edge.rank = NET_OVERRIDE_RANK;
    event_init(&faults->unstick, unstick, faults);
    event_init(&faults->flip, flip, faults);
    driver_init(&faults->babbler, faults->sig);
    driver_exempt(&faults->babbler, true);
    uart_tx_init(&faults->babble, schedule, &faults->babbler, faults);
    faults->babble.on_end = babble_on;
}

void faults_connect_receiver(struct faults *faults, struct net *rxd)
{
    driver_init(&faults->echo, rxd);
    faults->on_sig = (struct listener){.context = faults, .on_level = sig_level};
    net_listen(faults->sig, &faults->on_sig);
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
}
