/* SPDX-License-Identifier: MIT */
/* The two packets of a cycle against a model: random goals, commits and changes of the permit.
 * Every packet that leaves is compared with the model, its checksum with a full sum. */
#include <stdlib.h>
#include <string.h>

#include "cds55xx/cycle.h"
#include "cds55xx/queue.h"
#include "bus_rig.h"
#include "unity.h"

#define SERVOS    21 // more than one poll checks
#define PERIOD_US 2000
#define SIZE      (8 + 5 * SERVOS)
#ifdef __AVR__
#define STEPS 200 // the simulated AVR is slower
#else
#define STEPS 10000
#endif
#define RUNS 10

enum state { NO_GOAL_YET, GOAL, OUT };

struct model_goal {
    uint8_t state; // enum state; NO_GOAL_YET in `back`: not set since the last commit
    uint16_t position, speed;
};

static struct cds_queue queue;
static struct cds_bus_hooks hooks;
static struct cds_cycle cycle;
static struct cds_feedback feedback[SERVOS];
static uint8_t packets[CDS_CYCLE_PACKETS_SIZE(SERVOS)];
static uint8_t ids[SERVOS];

static struct model_goal front[SERVOS], back[SERVOS];
static bool is_committed;
static bool is_filling;          // goals were set, or refused, since the last commit
static uint16_t highest[SERVOS]; // limit of each servo; 0: inhibited, with position 0 refused too
static uint16_t epoch;
static uint8_t changed_id;
static uint8_t checks_in_poll;
static uint32_t sent, sent_with_holes;

static uint16_t random_below(uint16_t end)
{
    return (uint16_t)((uint32_t)rand() % end);
}

static bool is_good(uint8_t i, uint16_t position)
{
    return highest[i] && position <= highest[i];
}

static enum cds_result permit_goal(void *context, uint8_t id, uint8_t *index, const uint8_t *goal)
{
    uint8_t i = 0;

    (void)context;
    while (ids[i] != id)
        TEST_ASSERT_LESS_THAN(SERVOS, ++i);
    checks_in_poll++;
    *index = i;
    if (is_good(i, (uint16_t)(goal[0] | goal[1] << 8)))
        return CDS_OK;
    return highest[i] ? CDS_LIMIT : CDS_INHIBITED;
}

static uint8_t changed_since(void *context, uint16_t *since)
{
    uint16_t changes = (uint16_t)(epoch - *since);

    (void)context;
    *since = epoch;
    return changes == 0 ? CDS_NO_ID : changes == 1 ? changed_id : CDS_BROADCAST_ID;
}

static void assert_checksum(const uint8_t *packet)
{
    TEST_ASSERT_EQUAL_HEX8(cds_packet_checksum(packet), packet[SIZE - 1]);
}

/* The block that counts for servo `i`: the last one with its ID (R22), or NULL. */
static const uint8_t *block_for(const uint8_t *packet, uint8_t i)
{
    for (uint8_t k = SERVOS; k--;)
        if (packet[7 + 5 * k] == ids[i])
            return packet + 7 + 5 * k;
    return NULL;
}

static void assert_packet(const uint8_t *packet)
{
    bool has_holes = false;

    assert_checksum(packet);
    for (uint8_t i = 0; i < SERVOS; i++) {
        const uint8_t *block = block_for(packet, i);

        if (front[i].state == GOAL) {
            TEST_ASSERT_NOT_NULL(block);
            TEST_ASSERT_EQUAL_UINT16(front[i].position, block[1] | block[2] << 8);
            TEST_ASSERT_EQUAL_UINT16(front[i].speed, block[3] | block[4] << 8);
        } else {
            TEST_ASSERT_NULL(block);
            has_holes = true;
        }
        TEST_ASSERT_LESS_OR_EQUAL_UINT8(CDS_ID_MAX, packet[7 + 5 * i]);
    }
    sent++;
    sent_with_holes += has_holes;
}

/* The fake permit learns nothing from what is sent or comes. */
static bool on_sending(void *context, struct cds_request *request)
{
    (void)context, (void)request;
    return false;
}

static void on_packet(void *context, enum cds_bus_event event, uint8_t id, uint8_t error)
{
    (void)context, (void)event, (void)id, (void)error;
}

static void model_checked(struct model_goal *goals)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        if (goals[i].state == GOAL && !is_good(i, goals[i].position))
            goals[i].state = OUT;
}

/* Asked right before each packet leaves: the check of the goals has ended. */
static enum cds_result permit(void *context, struct cds_request *request)
{
    (void)context;
    request->return_delay_us = bus.return_delay_us;
    request->is_muted = false;
    if (request->packet.bytes[CDS_AT_INSTRUCTION] == CDS_READ)
        return CDS_NO_REPLY_DUE;
    TEST_ASSERT_EQUAL_UINT16(epoch, request->permit_epoch);
    model_checked(front);
    model_checked(back);
    assert_packet(request->packet.bytes);
    return CDS_OK;
}

static void begin(void)
{
    struct cds_cycle_config config = {.bus = &bus,
                                      .ids = ids,
                                      .packets = packets,
                                      .feedback = feedback,
                                      .count = SERVOS,
                                      .period_us = PERIOD_US};

    TEST_ASSERT_EQUAL(CDS_OK, cds_cycle_begin(&cycle, &config));
}

void setUp(void)
{
    rig_open(0);
    port_fake.eager = &bus.link;
    memset(&cycle, 0, sizeof cycle);
    memset(front, 0, sizeof front);
    memset(back, 0, sizeof back);
    is_committed = is_filling = false;
    sent = sent_with_holes = 0;
    epoch = 1;
    cds_queue_begin(&queue, &bus);
    hooks = queue.hooks;
    hooks.permit = permit;
    hooks.on_sending = on_sending;
    hooks.on_packet = on_packet;
    hooks.permit_goal = permit_goal;
    hooks.changed_since = changed_since;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_attach(&bus, &hooks));
    for (uint8_t i = 0; i < SERVOS; i++) {
        ids[i] = (uint8_t)(i * 7 % 101);
        highest[i] = CDS_VALUE_MAX;
    }
    begin();
}

void tearDown(void)
{
    rig_check();
}

/* ---- the model ---- */

/* A servo that never had a goal is left out. */
static void model_commit(void)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        if (back[i].state != NO_GOAL_YET)
            front[i] = back[i];
        else if (front[i].state == NO_GOAL_YET)
            front[i].state = OUT;
    memset(back, 0, sizeof back);
    is_committed = true;
}

/* ---- steps ---- */

static void poll(void)
{
    uint8_t before[SIZE], written = 0;

    memcpy(before, cycle.front, SIZE);
    checks_in_poll = 0;
    cds_cycle_poll(&cycle);
    TEST_ASSERT_LESS_OR_EQUAL_UINT8(8, checks_in_poll);
    for (uint8_t i = 0; i < SERVOS; i++)
        if (memcmp(before + 7 + 5 * i, cycle.front + 7 + 5 * i, 5) != 0)
            written++;
    TEST_ASSERT_LESS_OR_EQUAL_UINT8(8, written);
    port_fake.now_us += random_below(200);
    cds_bus_poll(&bus);
    if (cycle.is_checking || cycle.epoch != epoch)
        return;
    model_checked(front);
    model_checked(back);
    if (is_committed)
        for (uint8_t i = 0; i < SERVOS; i++)
            TEST_ASSERT_EQUAL(front[i].state == OUT, cds_cycle_is_dropped(&cycle, i));
}

static void set_goal(uint8_t i)
{
    uint16_t position = random_below(CDS_VALUE_MAX + 1), speed = random_below(CDS_VALUE_MAX + 1);
    bool is_busy = cycle.goals.result == CDS_PENDING && cycle.goals.packet.bytes == cycle.back;
    enum cds_result result = cds_cycle_goal(&cycle, i, position, speed);

    is_filling |= !is_busy;
    if (is_busy) {
        TEST_ASSERT_EQUAL(CDS_BUSY, result);
    } else if (is_good(i, position)) {
        TEST_ASSERT_EQUAL(CDS_OK, result);
        back[i] = (struct model_goal){GOAL, position, speed};
    } else {
        TEST_ASSERT_EQUAL(highest[i] ? CDS_LIMIT : CDS_INHIBITED, result);
        if (!is_committed)
            front[i].state = OUT;
    }
}

static void commit(void)
{
    cds_cycle_commit(&cycle);
    if (is_filling)
        model_commit();
    is_filling = false;
    if (is_committed)
        assert_checksum(cycle.front);
}

/* The model knows what a check under way has found only when it is over. */
static void change(void)
{
    uint8_t i = (uint8_t)random_below(SERVOS), kind = (uint8_t)random_below(20);

    if (cycle.is_checking)
        return;
    epoch++;
    changed_id = ids[i];
    highest[i] = kind < 8 ? 0 : kind < 12 ? 1 + random_below(CDS_VALUE_MAX) : CDS_VALUE_MAX;
    if (kind < 19)
        return;
    changed_id = CDS_BROADCAST_ID;
    for (i = 0; i < SERVOS; i++)
        highest[i] = random_below(2) ? CDS_VALUE_MAX : 0;
}

static void step(void)
{
    uint8_t kind = (uint8_t)random_below(100);

    if (kind < 30)
        set_goal((uint8_t)random_below(SERVOS));
    else if (kind < 35)
        for (uint8_t i = 0; i < SERVOS; i++)
            set_goal(i);
    else if (kind < 37)
        for (uint8_t i = SERVOS; i--;)
            set_goal(i);
    else if (kind < 50)
        commit();
    else if (kind < 55)
        change();
    else
        poll();
}

void test_goals_random_match_the_model(void)
{
    for (uint8_t run = 0; run < RUNS; run++) {
        uint32_t before, all_before;

        setUp();
        srand(run + 1u);
        for (uint16_t i = 0; i < STEPS; i++)
            step();
        TEST_ASSERT_GREATER_THAN_UINT32(STEPS / 100, sent);
        TEST_ASSERT_GREATER_THAN_UINT32(STEPS / 200, sent_with_holes);
        while (cycle.is_checking)
            poll();
        for (uint8_t i = 0; i < SERVOS; i++)
            highest[i] = CDS_VALUE_MAX;
        epoch += 2;
        while (cycle.goals.result == CDS_PENDING || cycle.is_checking || cycle.epoch != epoch)
            poll();
        before = sent_with_holes;
        all_before = sent;
        for (uint8_t i = 0; i < SERVOS; i++)
            set_goal(i);
        commit();
        for (uint16_t i = 0; i < 1000; i++)
            poll();
        TEST_ASSERT_GREATER_THAN_UINT32(all_before, sent);
        TEST_ASSERT_EQUAL_UINT32(before, sent_with_holes);
    }
}

/* Damages the packet in front, and has all goals set but those below `from`. */
static void set_beside_damage(uint8_t from)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        set_goal(i);
    commit();
    for (uint8_t i = from; i < SERVOS; i++)
        set_goal(i);
    for (uint8_t i = 0; i < SERVOS; i++)
        cycle.front[8 + 5 * i] ^= 1;
    commit();
}

static bool is_damaged(uint8_t i)
{
    const uint8_t *block = cycle.front + 7 + 5 * i;

    return (uint16_t)(block[1] | block[2] << 8) != front[i].position;
}

void test_commit_with_all_goals_set_copies_no_block(void)
{
    set_beside_damage(0);
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_FALSE(is_damaged(i));
}

void test_commit_copies_only_blocks_that_were_not_set(void)
{
    set_beside_damage(3);
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_EQUAL(i < 3, is_damaged(i));
}

void test_goals_set_in_any_order_copy_no_block(void)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        set_goal(i);
    commit();
    for (uint8_t i = SERVOS; i--;)
        set_goal(i);
    TEST_ASSERT_EQUAL_UINT8(0, cycle.skipped); // the commit looks at no block
    cycle.front[8] ^= 1;
    commit();
    for (uint8_t i = 0; i < SERVOS; i++)
        TEST_ASSERT_FALSE(is_damaged(i));
}

/* Commits with each turn of the main loop must not keep the goals from being checked and sent. */
void test_commit_in_every_poll_of_the_check_still_sends_goals(void)
{
    for (uint8_t i = 0; i < SERVOS; i++)
        set_goal(i);
    commit();
    for (uint8_t i = 0; i < SERVOS - 1; i++)
        highest[i] = 0;
    epoch += 2;
    for (uint16_t i = 0; i < 200; i++) {
        set_goal(SERVOS - 1);
        commit();
        poll();
    }
    TEST_ASSERT_GREATER_THAN_UINT32(5, sent);
}
