/* SPDX-License-Identifier: MIT */
/* Random packets against the permit (docs/internals/permit.md), on this machine under the
 * sanitizers. A model of three servos receives the packets on the wire. The model decides whether a
 * packet was allowed; what the library reports is not used.
 *
 * usage: permit_random STEPS [SEED]
 *
 * Steps: requests of every kind, which wait in the queue and are retried; limits, inhibits and
 * releases; lost packets and replies; power losses; changes of ID, resets, status return levels; a
 * registered move. A packet fails if it can drive while driving is inhibited, drives an inhibited
 * servo, or makes a servo move beyond a limit. Then the packet is printed; exit status 1. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cds55xx/servo.h"
#include "cds55xx/servos.h"
#include "port_fake.h"

#define SERVOS   3
#define REQUESTS 4
#define CAPACITY 6

/* The behaviour of a servo in the manual, as far as the permit depends on it. */
static struct model {
    uint8_t table[CDS_TABLE_SIZE];
    uint8_t registered[CDS_TABLE_SIZE], registered_at, registered_size; // size 0: none
    uint16_t present;
    uint8_t dark; // number of packets for which it still has no power
    // what this program has set in the library:
    uint16_t lowest, highest, fastest;
    bool inhibited;
    bool was_returned, mode_read, goal_read; // mode_read, goal_read: since the servo is RETURNED
    bool torque_known_on; // a reply said that torque is on; no packet switched it off since
} models[SERVOS];

static struct cds_bus bus;
static struct cds_queue queue;
static struct cds_servos servos;
static struct cds_servo_state states[CAPACITY];
static struct cds_request requests[REQUESTS];
static uint8_t packets[REQUESTS][64], replies[REQUESTS][CDS_REPLY_MAX];
static bool inhibited,
    revoked[REQUESTS]; // `revoked`: waited at the time of an inhibit; must not be sent
static uint32_t seed, first_seed, step, failures, heard, drove, moves, torques;

static uint32_t any(uint32_t count)
{
    seed = seed * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)(seed >> 4) * count) >> 28);
}

static uint16_t word(const struct model *model, uint8_t reg)
{
    return (uint16_t)(model->table[reg] | model->table[reg + 1] << 8);
}

static void put(struct model *model, uint8_t reg, uint16_t value)
{
    model->table[reg] = (uint8_t)value;
    model->table[reg + 1] = (uint8_t)(value >> 8);
}

/* ---- checks ---- */

static void fail(const char *what, const struct model *model)
{
    failures++;
    printf("seed %u, step %u, servo %d (ID %u): %s:", first_seed, step, (int)(model - models),
           model ? model->table[3] : 0, what);
    for (uint16_t i = 0; i < port_fake.sent_size; i++)
        printf(" %02X", port_fake.sent[i]);
    printf("\n");
}

static bool touches(uint8_t at, uint8_t size, uint8_t first, uint8_t last)
{
    return size && at <= last && at + size > first;
}

static bool may_move(uint8_t at, uint8_t size, const uint8_t *data)
{
    return touches(at, size, 0x06, 0x09) || touches(at, size, 0x1A, 0x21) ||
           touches(at, size, 0x30, 0x31) || (touches(at, size, 0x18, 0x18) && data[0x18 - at]);
}

static bool packet_may_move(const uint8_t *bytes)
{
    uint8_t count = (uint8_t)(bytes[3] - 2);

    switch (bytes[4]) {
    case 1: return count > 0;
    case 2: return count > 2;
    case 3:
    case 4: return count > 1 && may_move(bytes[5], (uint8_t)(count - 1), bytes + 6);
    case 0x83:
        for (uint8_t i = 2; i < count; i = (uint8_t)(i + 1 + bytes[6]))
            if (may_move(bytes[5], bytes[6], bytes + 5 + i + 1))
                return true;
        return false;
    default: return true;
    }
}

/* Checks the servo after a write: the values that the write has changed must be within the limits.
 */
static void check_limits(const struct model *model, uint8_t at, uint8_t size, bool torque_before,
                         bool position_before)
{
    bool position = word(model, 0x06) || word(model, 0x08);
    bool mode = touches(at, size, 0x06, 0x09) && position != position_before;
    bool torque = model->table[0x18] && (!torque_before || touches(at, size, 0x18, 0x18));
    bool goal = touches(at, size, 0x1E, 0x1F), speed = touches(at, size, 0x20, 0x21);
    uint16_t magnitude = word(model, 0x20) & 0x3FF, target = word(model, 0x1E);
    bool moves_to_goal = position && target != model->present;
    bool goal_limited = model->lowest > 0 || model->highest < 1023;

    if (!(mode || torque || goal || speed))
        return;
    drove++;
    if (model->inhibited)
        fail("drives an inhibited servo", model);
    if (!model->table[0x18])
        return;
    if (touches(at, size, 0x18, 0x18) && (goal_limited || model->fastest < 1023) &&
        !(model->mode_read && model->goal_read))
        fail("torque on, and mode, goal or speed was not read", model);
    torques++;
    if (goal_limited && (goal || mode || torque) && moves_to_goal &&
        (target < model->lowest || target > model->highest))
        fail("goal beyond its limits", model);
    if (goal_limited && !position && magnitude && (speed || mode || torque))
        fail("turns without limit", model);
    if (moves_to_goal && (magnitude == 0 || magnitude > model->fastest) && model->fastest < 1023)
        fail("too fast", model);
    if (!position && magnitude > model->fastest)
        fail("turns too fast", model);
    moves++;
}

/* ---- the servos ---- */

static void power_up(struct model *model)
{
    memset(model->table + 0x18, 0, CDS_TABLE_SIZE - 0x18);
    put(model, 0x1E, model->present);
    model->registered_size = 0;
}

static void carry_out(struct model *model, uint8_t at, const uint8_t *data, uint8_t size)
{
    bool torque = model->table[0x18], position = word(model, 0x06) || word(model, 0x08);

    if (model->inhibited && may_move(at, size, data) && !touches(at, size, 0x1A, 0x1D) &&
        !touches(at, size, 0x30, 0x31))
        fail("drives an inhibited servo", model);
    memcpy(model->table + at, data, size);
    check_limits(model, at, size, torque, position);
    if (model->table[0x18] && (word(model, 0x06) || word(model, 0x08)))
        model->present = word(model, 0x1E);
    if (touches(at, size, 0x2C, 0x2C) && !model->table[0x2C])
        model->registered_size = 0;
}

static uint8_t write_is_good(uint8_t at, const uint8_t *data, uint8_t size)
{
    uint16_t goal;

    if (!size || at + size > CDS_TABLE_SIZE)
        return 8;
    if (at <= 3 && at + size > 3 && data[3 - at] > 253)
        return 8;
    if (at <= 0x1E && at + size > 0x1F) {
        goal = (uint16_t)(data[0x1E - at] | data[0x1F - at] << 8);
        if (goal > 1023)
            return 2;
    }
    return 0;
}

/* Returns the ERROR of the reply. */
static uint8_t obey(struct model *model, const uint8_t *bytes)
{
    uint8_t count = (uint8_t)(bytes[3] - 2), at = bytes[5], error = 0;

    switch (bytes[4]) {
    case 1:
    case 2: return 0;
    case 3:
        error = write_is_good(at, bytes + 6, (uint8_t)(count - 1));
        if (!error)
            carry_out(model, at, bytes + 6, (uint8_t)(count - 1));
        return error;
    case 4:
        error = write_is_good(at, bytes + 6, (uint8_t)(count - 1));
        if (error)
            return error;
        model->registered_at = at;
        model->registered_size = (uint8_t)(count - 1);
        memcpy(model->registered, bytes + 6, model->registered_size);
        model->table[0x2C] = 1;
        return 0;
    case 5:
        if (!model->registered_size)
            return 0x40;
        count = model->registered_size;
        model->registered_size = 0;
        model->table[0x2C] = 0;
        carry_out(model, model->registered_at, model->registered, count);
        return 0;
    case 6:
        memset(model->table, 0, sizeof model->table);
        model->table[3] = model->table[4] = model->table[5] = 1;
        put(model, 8, 1023);
        model->table[0x10] = 2;
        power_up(model);
        return 0;
    case 0x83:
        for (uint8_t i = 2; i + bytes[6] < count; i = (uint8_t)(i + 1 + bytes[6]))
            if (bytes[5 + i] == model->table[3] && !write_is_good(at, bytes + 6 + i, bytes[6]))
                carry_out(model, at, bytes + 6 + i, bytes[6]);
        return 0;
    default: return 0x40;
    }
}

static bool writes_torque(const uint8_t *bytes)
{
    uint8_t length = bytes[4] == 0x83 ? bytes[6] : (uint8_t)(bytes[3] - 3);

    return (bytes[4] == 3 || bytes[4] == 0x83) && touches(bytes[5], length, 0x18, 0x18);
}

/* Notes what the library must know after the reply of `model`; NULL: no reply. */
static void note_known(const uint8_t *bytes, struct model *model, uint8_t error)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        if (writes_torque(bytes) || bytes[4] == 5 || bytes[4] == 6 || bytes[5] == 3)
            models[i].torque_known_on = false;
    if (!model || error)
        return;
    if (bytes[4] == 3 && writes_torque(bytes))
        model->torque_known_on = bytes[6 + 0x18 - bytes[5]];
    if (bytes[4] == 2 && !touches(bytes[5], bytes[6], 0x18, 0x18)) {
        model->mode_read |= bytes[5] <= 6 && bytes[5] + bytes[6] > 9;
        model->goal_read |= bytes[5] <= 0x1E && bytes[5] + bytes[6] > 0x21;
    }
    if (bytes[4] != 2 || !touches(bytes[5], bytes[6], 0x18, 0x18))
        return;
    if (model->torque_known_on && !model->table[0x18])
        model->inhibited = true,
        model->mode_read = model->goal_read = false; // the servo lost its state
    model->torque_known_on = model->table[0x18];
    model->mode_read |= bytes[5] <= 6 && bytes[5] + bytes[6] > 9;
    model->goal_read |= bytes[5] <= 0x1E && bytes[5] + bytes[6] > 0x21;
}

/* A reply of servo `id` arrives. An OFFLINE servo becomes RETURNED, and mode and goal must be read
 * again. */
static void note_return(struct model *model, uint8_t id)
{
    const struct cds_servo_state *entry = cds_servos_find(&servos, id);

    if (!entry || entry->presence != CDS_PRESENCE_OFFLINE || bus.request->is_muted)
        return; // a reply that is not due does not change the presence
    model->mode_read = model->goal_read = false;
    model->was_returned = true;
}

/* The servos receive the packet on the wire and answer. */
static void deliver_packet(void)
{
    const uint8_t *bytes = port_fake.sent, *data = NULL;
    bool is_lost = any(12) == 0, is_reply_lost = any(10) == 0, all = bytes[2] == 0xFE;
    uint8_t answers = 0, id = 0, error = 0, size = 0, dark_again = 0xFF;
    struct model *answering = NULL;

    heard++;
    if (inhibited && packet_may_move(bytes))
        fail("may move while driving is inhibited", models);
    if (any(60) == 0)
        dark_again = (uint8_t)any(SERVOS);
    for (uint8_t i = 0; i < SERVOS; i++) {
        struct model *model = &models[i];
        struct cds_servo_state *entry = cds_servos_find(&servos, model->table[3]);
        uint8_t level = model->table[0x10], asked = model->table[3];

        if (entry && entry->presence == CDS_PRESENCE_RETURNED && !model->was_returned)
            model->mode_read = model->goal_read = false;
        model->was_returned = entry && entry->presence == CDS_PRESENCE_RETURNED;
        if (model->dark) {
            model->dark--;
            continue;
        }
        if (is_lost || (!all && bytes[2] != asked))
            continue;
        if (entry && entry->presence == CDS_PRESENCE_RETURNED && packet_may_move(bytes) &&
            (bytes[4] == 3 || bytes[4] == 5) &&
            !touches(bytes[5], (uint8_t)(bytes[3] - 3), 0x1A, 0x1D) &&
            !touches(bytes[5], (uint8_t)(bytes[3] - 3), 0x30, 0x31))
            fail("drives a servo that has returned", model);
        error = obey(model, bytes);
        id = asked;
        if (bytes[4] == 2) {
            data = model->table + bytes[5];
            size = bytes[6];
        }
        if (!all && (bytes[4] == 1 || level > (bytes[4] != 2)))
            answers++, answering = model;
        if (dark_again == i) {
            model->dark = (uint8_t)(1 + any(12));
            power_up(model);
        }
    }
    if (answers != 1 || is_reply_lost)
        answering = NULL;
    if (answering)
        note_return(answering, id);
    note_known(bytes, answering, error);
    if (answers > 1)
        port_fake_hear(&bus.link, (const uint8_t *)"\xFF\xFF\x01\x02\x00\x00", 6);
    else if (answers && !is_reply_lost)
        port_fake_answer(&bus.link, id, error, data, size);
}

/* ---- random steps ---- */

/* If a packet has begun, sends it and lets the servos answer. */
static void serve(void)
{
    if (bus.link.state != CDS_LINK_TALKING)
        return;
    if (revoked[bus.request - requests] && packet_may_move(bus.request->packet.bytes))
        fail("waited when driving was inhibited", models);
    port_fake_transmit(&bus.link, 0);
    deliver_packet();
}

static void turn(void)
{
    port_fake.now_us += 20 + any(60);
    if (bus.request && any(8) == 0)
        port_fake.now_us += 3000;
    for (uint32_t i = any(6); i; i--) {
        cds_bus_poll(&bus);
        serve();
    }
}

static struct cds_request *idle_request(void)
{
    uint32_t index = any(REQUESTS);

    if (requests[index].result == CDS_PENDING)
        return NULL;
    revoked[index] = false;
    return &requests[index];
}

static uint8_t any_id(void)
{
    uint32_t pick = any(10);

    if (pick < 7)
        return models[any(SERVOS)].table[3];
    return pick == 7 ? 0xFE : pick == 8 ? (uint8_t)any(10) : states[any(CAPACITY)].id;
}

/* Random data for registers that can move a servo, with values near the limits. */
static uint8_t any_data(uint8_t *at, uint8_t *data)
{
    static const uint8_t starts[] = {3,    5,    6,    6,    8,    8,    9,    0x10,
                                     0x18, 0x18, 0x18, 0x19, 0x1C, 0x1E, 0x1E, 0x1E,
                                     0x1E, 0x1F, 0x20, 0x20, 0x2C, 0x30};
    static const uint8_t sizes[] = {1, 1, 4, 4, 2, 2, 1, 1, 1, 1, 10,
                                    7, 4, 4, 4, 2, 4, 3, 2, 2, 1, 2};
    uint32_t pick = any(sizeof starts);
    uint8_t size = sizes[pick];

    *at = starts[pick];
    memset(data, 0, 32);
    for (uint8_t i = 0; i < size; i++)
        data[i] = (uint8_t)(any(3) ? any(3) : any(256));
    if (*at == 0x10)
        data[0] = (uint8_t)any(3);
    if (*at == 3)
        data[0] = (uint8_t)(1 + any(9));
    if (*at == 6 || *at == 8)
        for (uint8_t i = 1; i < size; i = (uint8_t)(i + 2))
            data[i] &= 3;
    if (*at == 6 && any(2))
        memset(data, 0, size);
    if (*at == 0x18 && size == 10)
        data[0] = (uint8_t)any(2);
    return size;
}

static void submit_sync(struct cds_request *request)
{
    uint8_t at, data[32], size = any_data(&at, data);

    cds_packet_sync_begin(&request->packet, at, size);
    for (uint32_t i = 1 + any(3); i; i--)
        cds_packet_sync_add(&request->packet, models[any(SERVOS)].table[3], data);
    if (any(8) == 0)
        cds_packet_put(&request->packet, 1);
    if (cds_packet_end(&request->packet) == CDS_OK) {
        request->reply_parameters = CDS_REPLY_NONE;
        cds_bus_submit(&bus, request);
    }
}

/* Makes the READs that the permit demands before torque on. */
static void submit_read(struct cds_request *request, uint8_t id)
{
    static const uint8_t spans[][2] = {{0x18, 1},  {0x06, 4}, {0x1E, 4},
                                       {0x05, 29}, {0x24, 8}, {0x06, 28}};
    const uint8_t *span = spans[any(6)];

    cds_servo_read(&bus, request, id, span[0], span[1]);
}

static void submit_any(void)
{
    struct cds_request *request = idle_request();
    uint8_t at, data[32], size, id = any_id();

    if (!request)
        return;
    request->priority = (uint8_t)any(3);
    request->servo_index = (uint8_t)any(8);
    size = any_data(&at, data);
    switch (any(13)) {
    case 0: cds_servo_ping(&bus, request, id == 0xFE ? 1 : id); break;
    case 1:
    case 2:
    case 3: submit_read(request, id == 0xFE ? 1 : id); break;
    case 4: cds_servo_write_byte(&bus, request, id, 0x18, (uint8_t)any(2)); break;
    case 5: submit_sync(request); break;
    case 6: cds_servo_reg_write(&bus, request, id, at, data, size); break;
    case 7: cds_servo_action(&bus, request, any(2) ? 0xFE : id); break;
    case 8:
        if (any(6) == 0)
            cds_servo_reset(&bus, request, id);
        else
            cds_servo_read(&bus, request, id == 0xFE ? 1 : id, 0x05, 29);
        break;
    default: cds_servo_write(&bus, request, id, at, data, size); break;
    }
}

/* Takes one step of a registered move with the first request. Sometimes the steps are out of order,
 * or the request is another one. */
static void registered_move_step(void)
{
    static uint8_t phase;
    struct cds_request *request = &requests[any(12) ? 0 : 1];
    uint8_t data[4] = {(uint8_t)any(256), (uint8_t)(1 + any(3)), (uint8_t)any(256),
                       (uint8_t)any(2)};

    if (request->result == CDS_PENDING)
        return;
    revoked[request - requests] = false;
    if (any(12) == 0)
        phase = (uint8_t)any(SERVOS + 3);
    if (phase == 0)
        bus.hooks->set_move(bus.hooks->context, any(9) ? request : NULL);
    else if (phase <= SERVOS)
        cds_servo_reg_write(&bus, request, models[phase - 1].table[3], 0x1E, data, 4);
    else
        cds_servo_action(&bus, request, 0xFE);
    if (request->result == CDS_PENDING || phase == 0 || any(8) == 0)
        phase = (uint8_t)((phase + 1) % (SERVOS + 2));
}

/* Returns the entry of this servo. The library must have it under the servo's ID. */
static struct cds_servo_state *entry_of(const struct model *model)
{
    struct cds_servo_state *entry = cds_servos_find(&servos, model->table[3]);

    if (!entry &&
        !port_fake_is_in_flight(&bus)) // otherwise the reply that changes the ID may still come
        fail("not in the list under its ID", model);
    if (entry && entry->second < servos.count && any(2))
        entry = &states[entry->second]; // the entry of its other possible ID
    return entry;
}

static void set_limits(struct model *model)
{
    struct cds_servo_state *entry = entry_of(model);
    uint16_t lowest = 0, highest = 1023, fastest = 1023;

    if (any(4)) {
        lowest = (uint16_t)any(400);
        highest = (uint16_t)(400 + any(400));
    }
    if (any(3) == 0)
        fastest = (uint16_t)any(600);
    if (entry && cds_servos_set_limits(&servos, entry, lowest, highest, fastest) == CDS_OK) {
        model->lowest = lowest;
        model->highest = highest;
        model->fastest = fastest;
    }
}

static void release_all(void)
{
    cds_servos_release_all(&servos);
    inhibited = false;
    for (uint8_t i = 0; i < SERVOS; i++)
        models[i].inhibited = false;
}

static void guard(void)
{
    struct model *model = &models[any(SERVOS)];
    struct cds_servo_state *entry;

    switch (any(12)) {
    case 0:
        cds_servos_inhibit_all(&servos);
        inhibited = true;
        for (uint8_t i = 0; i < REQUESTS; i++) // retries of the request in flight as well
            revoked[i] = requests[i].result == CDS_PENDING;
        if (any(2) == 0)
            release_all();
        break;
    case 1:
    case 2: release_all(); break;
    case 3:
        if ((entry = entry_of(model))) {
            cds_servos_inhibit(&servos, entry, CDS_INHIBIT_STOPPED);
            model->inhibited = true;
        }
        break;
    case 4:
    case 5:
    case 6:
    case 7:
        if ((entry = entry_of(model))) {
            cds_servos_release(&servos, entry);
            model->inhibited = false;
        }
        break;
    case 8: cds_servos_allow_reset(&servos, false); break;
    default: set_limits(model); break;
    }
}

static void begin(void)
{
    memset(&bus, 0, sizeof bus);
    memset(&servos, 0, sizeof servos);
    memset(states, 0, sizeof states);
    memset(models, 0, sizeof models);
    port_fake_reset();
    for (uint8_t i = 0; i < REQUESTS; i++)
        requests[i] = (struct cds_request)CDS_REQUEST(packets[i], replies[i]);
    for (uint8_t i = 0; i < SERVOS; i++) {
        models[i].table[3] = states[i].id = (uint8_t)(i + 2);
        models[i].table[0x10] = 2;
        put(&models[i], 8, 1023);
        models[i].highest = models[i].fastest = 1023;
        models[i].present = 500;
        power_up(&models[i]);
    }
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_servos_begin(
        &servos,
        &(struct cds_servos_config){
            .bus = &bus, .queue = &queue, .states = states, .count = SERVOS, .capacity = CAPACITY});
    cds_queue_set_retries(&queue, (uint8_t)any(3));
    inhibited = false;
    memset(revoked, 0, sizeof revoked);
}

int main(int argc, char **argv)
{
    uint32_t steps;

    if (argc < 2) {
        fprintf(stderr, "usage: permit_random STEPS [SEED]\n");
        return 2;
    }
    steps = (uint32_t)strtoul(argv[1], NULL, 0);
    seed = first_seed = argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 0) : 1;
    for (step = 0; step < steps && failures < 5; step++) {
        if (step % 2000 == 0)
            begin();
        if (any(3) == 0)
            submit_any();
        serve();
        if (any(8) == 0)
            registered_move_step();
        serve();
        if (any(40) == 0)
            guard();
        turn();
    }
    printf("%u steps: %u packets heard, %u writes drove, %u of them with torque on\n", step, heard,
           drove, moves);
    if (failures == 0 && (drove < heard / 50 || moves < heard / 2000)) {
        printf("too little has moved for a judgement\n");
        failures++;
    }
    puts(failures || port_fake.breaches ? "FAILED" : "ok");
    return failures || port_fake.breaches;
}
