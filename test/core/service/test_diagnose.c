/* SPDX-License-Identifier: MIT */
/* Diagnoses against fake servos: findings at their thresholds, and what is given back. Causes on a
 * real wire: test/runs/test_diagnose.py. */
#include "cds55xx/diagnose.h"

#include "cds55xx/control_table.h"
#include "cds55xx/queue.h"
#include "bus_rig.h"
#include "permit_fake.h"
#include "servos_fake.h"
#include "unity.h"

#define ID          5
#define QUESTIONS   16 // to a servo: four PINGs, six READs of its ID, six of what it measures
#define FIRST_READ  4
#define MEASUREMENT 10

static struct cds_queue queue;
static uint8_t packet[CDS_DIAGNOSE_PACKET_SIZE], reply[CDS_DIAGNOSE_REPLY_SIZE];
static struct cds_request request;
static struct cds_diagnose diagnose;
static struct {
    uint32_t spoilt;  // bit n: the answer to question n of each examination of servo ID is damaged
    uint8_t to_id;    // questions to it so far
    uint8_t reads;    // READs to any servo so far
    uint8_t error;    // in answers to READ of measurements
    bool other_too;   // all answers of others are damaged
    bool once;        // ... of the first one only
    uint8_t cut;      // so many of the first bytes of answers of servo ID are lost,
    uint32_t whole;   // ... but not of these questions of each examination,
    uint8_t twin;     // ... and these bits of measurements are pulled low by another servo
    uint8_t damage;   // ... and these bits of the ID are wrong
    bool mute;        // it does not answer READ
    bool echoes;      // every byte comes back
    uint16_t lost;    // bytes that the receiver loses in each answer
    uint32_t silent;  // bit n: servo ID does not reply to packet n
    uint32_t late;    // bit n: it replies to packet n late, ...
    uint16_t late_us; // so many microseconds after the packet
    uint32_t replies_at; // when a late reply comes, 0: none does
    bool hides_limits;   // READ of the limits is not answered
    uint8_t bad_limits;  // so many READs of the limits get a damaged reply
    uint8_t echo_from;   // bytes of each packet that do not come back
    struct bytes {
        const char *bytes;
        uint8_t count;
        uint8_t from, to; // while so many transactions have ended
    } idle, behind;       // come while no packet of ours is sent; behind each reply
    bool collides;        // the first byte of each packet comes back changed
} world;

static void put(uint8_t index, uint8_t id, uint8_t baud)
{
    servo_fake_put(index, id, baud);
    memcpy(&servos.servo[index].table[CDS_REG_MAX_TEMPERATURE], "\x50\x3C\xA0", 3);
    servos.servo[index].table[CDS_REG_MAX_TORQUE] = 1;
    memcpy(&servos.servo[index].table[CDS_REG_PRESENT_VOLTAGE], "\x78\x20", 2);
}

static enum cds_result try_to_begin(uint8_t id)
{
    struct cds_diagnose_config config = {.bus = &bus, .request = &request, .id = id};

    return cds_diagnose_begin(&diagnose, &config);
}

static void begin(uint8_t id)
{
    TEST_ASSERT_EQUAL(CDS_OK, try_to_begin(id));
}

void setUp(void)
{
    rig_open(0);
    memset(&servos, 0, sizeof servos);
    memset(&world, 0, sizeof world);
    request = (struct cds_request)CDS_REQUEST(packet, reply);
    cds_bus_set_return_delay(&bus, 40);
    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(&queue, &bus));
    cds_queue_set_retries(&queue, 2);
    begin(ID);
}

static void assert_given_back(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
    TEST_ASSERT_EQUAL_UINT16(0, servos.writes);
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, port_fake.bauds[0]);
    TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, bus.baud_reg);
    TEST_ASSERT_EQUAL_UINT16(40, bus.return_delay_us);
    TEST_ASSERT_EQUAL_UINT8(2, queue.retries);
    TEST_ASSERT_NULL(bus.lock);
}

void tearDown(void)
{
    if (diagnose.steps.result != CDS_PENDING) {
        TEST_ASSERT_FALSE(request.ignores_stale);
        TEST_ASSERT_FALSE(request.ignores_servo_state);
        TEST_ASSERT_FALSE(request.no_retry);
        TEST_ASSERT_FALSE(request.passes_lock);
    }
    rig_check();
}

/* What is heard of servo ID's answer when the driver is let go too late. */
static void answer_cut(const uint8_t *sent)
{
    bool reads = sent[4] == CDS_READ;
    const uint8_t *parameters = &servos.servo[0].table[reads ? sent[5] : 0];
    uint8_t count = reads ? sent[6] : 0;
    uint8_t answer[20] = {0xFF, 0xFF, ID, (uint8_t)(count + 2), world.error};
    uint8_t sum = (uint8_t)(ID + count + 2 + world.error);

    for (uint8_t i = 0; i < count; i++) {
        answer[5 + i] = parameters[i];
        sum = (uint8_t)(sum + parameters[i]);
    }
    answer[5 + count] = (uint8_t)~sum;
    answer[2] ^= world.damage;
    if (count > 1)
        answer[5] &= (uint8_t)~world.twin;
    port_fake_hear(&bus.link, &answer[world.cut], (uint16_t)(6 + count - world.cut));
}

static bool has_bit(uint32_t bits, uint8_t index)
{
    return index < 32 && bits >> index & 1;
}

static bool is_between(uint8_t from, uint8_t to)
{
    return diagnose.transactions >= from && diagnose.transactions < to;
}

/* The servos answer what is on the line, or the world's damage does. */
static void meet(void)
{
    const uint8_t *sent = port_fake.sent;
    bool to_id = sent[CDS_AT_ID] == ID;
    bool measured = sent[4] == CDS_READ && sent[5] == CDS_REG_PRESENT_POSITION;

    world.reads = (uint8_t)(world.reads + (sent[4] == CDS_READ));
    if (world.echoes)
        port_fake_hear(&bus.link, sent + world.echo_from,
                       (uint16_t)(port_fake.sent_size - world.echo_from));
    for (uint16_t i = 0; i < world.lost; i++)
        cds_link_on_rx(&bus.link, 0, CDS_LINE_OVERRUN);
    if (world.bad_limits && sent[4] == CDS_READ && sent[5] == CDS_REG_RETURN_DELAY) {
        world.bad_limits--;
        port_fake_hear(&bus.link, (const uint8_t *)"\xFF\xFF\x05\x02\x00\x00", 6);
    } else if (to_id ? world.spoilt >> world.to_id % QUESTIONS & 1 : world.other_too)
        port_fake_hear(&bus.link, (const uint8_t *)"\xFF\xFF\x05\x02\x00\x00", 6);
    else if (to_id && ((world.mute && sent[4] == CDS_READ) ||
                       (world.hides_limits && sent[4] == CDS_READ && sent[5] == 5) ||
                       has_bit(world.silent, world.to_id)))
        ;
    else if (to_id && world.cut && !(world.whole >> world.to_id % QUESTIONS & 1))
        answer_cut(sent);
    else if (to_id && measured && world.error)
        port_fake_answer(&bus.link, ID, world.error, &servos.servo[0].table[sent[5]], sent[6]);
    else
        servos_hear(&bus);
    if (world.behind.count && is_between(world.behind.from, world.behind.to))
        port_fake_hear(&bus.link, (const uint8_t *)world.behind.bytes, world.behind.count);
    if (to_id && ++world.to_id == QUESTIONS && world.once)
        world.spoilt = 0;
}

static void turn(void)
{
    port_fake.now_us += bus.request ? 20 : 100;
    if (world.replies_at && port_fake.now_us >= world.replies_at) {
        world.replies_at = 0;
        meet();
    }
    if (bus.link.state != CDS_LINK_TALKING) {
        if (world.idle.count && is_between(world.idle.from, world.idle.to))
            port_fake_hear(&bus.link, (const uint8_t *)world.idle.bytes, world.idle.count);
        return;
    }
    if (world.collides)
        cds_link_on_rx_echo(&bus.link, 0, 0);
    if (!port_fake_transmit(&bus.link, 0))
        return;
    port_fake.now_us += (uint32_t)port_fake.sent_size * (port_fake.bauds[0] + 1u) * 5;
    if (port_fake.sent[CDS_AT_ID] == ID && has_bit(world.late, world.to_id))
        world.replies_at = port_fake.now_us + world.late_us;
    else
        meet();
    port_fake_forget();
}

static enum cds_result go_on(void)
{
    enum cds_result result;

    while ((result = cds_diagnose_poll(&diagnose)) == CDS_PENDING) {
        turn();
        cds_bus_poll(&bus);
    }
    return result;
}

static uint8_t found(void)
{
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    assert_given_back();
    TEST_ASSERT_EQUAL_UINT16(bus.stats.sent + bus.stats.line_busy, diagnose.transactions);
    TEST_ASSERT_EQUAL_UINT16(0, bus.stats.retried);
    return diagnose.finding;
}

/* The finding for these damaged answers, with another servo there (and as bad), or none. */
static uint8_t found_for(uint32_t spoilt, bool another, bool as_bad)
{
    setUp();
    put(0, ID, 1);
    if (another)
        put(1, 200, 1);
    world.spoilt = spoilt;
    world.other_too = as_bad;
    return found();
}

static uint32_t questions(uint8_t from, uint8_t count)
{
    return (((uint32_t)1 << count) - 1) << from;
}

void test_nonsense_is_refused(void)
{
    struct cds_bus closed = {.port = 0};
    struct cds_diagnose_config config = {.bus = &closed, .request = &request, .id = ID};

    TEST_ASSERT_EQUAL(CDS_BUSY, try_to_begin(ID)); // it is under way
    cds_diagnose_abort(&diagnose);
    TEST_ASSERT_EQUAL(CDS_CANCELLED, go_on());
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, cds_diagnose_begin(&diagnose, &config));
    TEST_ASSERT_EQUAL(CDS_BAD_ARGUMENT, try_to_begin(255));
    request.packet.capacity--;
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, try_to_begin(ID));
    request.packet.capacity++;
    request.reply_capacity--;
    TEST_ASSERT_EQUAL(CDS_NO_ROOM, try_to_begin(ID));
    request.reply_capacity++;
    request.result = CDS_PENDING;
    TEST_ASSERT_EQUAL(CDS_BUSY, try_to_begin(ID));
    request.result = CDS_OK;
    begin(254);
}

void test_a_servo_that_is_well(void)
{
    put(0, ID, 1);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
    TEST_ASSERT_EQUAL_UINT8(ID, diagnose.found_id);
    TEST_ASSERT_EQUAL_UINT8(QUESTIONS, diagnose.total.answered);
    TEST_ASSERT_EQUAL_UINT8(4, diagnose.probe.answered);
    TEST_ASSERT_EQUAL_UINT8(6, diagnose.same.answered);
    TEST_ASSERT_EQUAL_UINT8(6, diagnose.varying.answered);
    TEST_ASSERT_EQUAL_UINT16(20, diagnose.transactions);
    TEST_ASSERT_LESS_THAN_UINT32(100000, port_fake.now_us);
    TEST_ASSERT_GREATER_THAN_UINT32(70000, port_fake.now_us);
}

void test_nobody(void)
{
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_SILENCE, found());
    TEST_ASSERT_EQUAL_UINT16(31, diagnose.transactions);
    TEST_ASSERT_LESS_THAN_UINT32(300000, port_fake.now_us);
    TEST_ASSERT_EQUAL_UINT8(CDS_NO_ID, diagnose.found_id);
}

void test_listening_waits_for_other_requests_and_stale_replies(void)
{
    uint8_t other_buffer[8];
    struct cds_request other = CDS_REQUEST_WITHOUT_DATA(other_buffer);

    put(0, ID, 1);
    cds_diagnose_abort(&diagnose);
    go_on();
    other.no_retry = true;
    cds_packet_ping(&other.packet, 77);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &other));
    begin(ID);
    TEST_ASSERT_EQUAL(CDS_PENDING, cds_diagnose_poll(&diagnose));
    while (other.result == CDS_PENDING) {
        turn();
        cds_bus_poll(&bus);
    }
    cds_diagnose_poll(&diagnose);
    port_fake.now_us += 1900;
    port_fake_answer(&bus.link, 77, 0, NULL, 0);
    port_fake_answer(&bus.link, 78, 0, NULL, 0);
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, diagnose.finding);
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.not_due[CDS_EVENT_STALE_REPLY]);
}

void test_an_abort_at_any_poll_gives_all_back(void)
{
    for (uint16_t polls = 0; polls < 12000; polls = (uint16_t)(polls + 1 + polls / 5)) {
        setUp();
        put(0, 9, 103);
        for (uint16_t i = 0; i < polls; i++) {
            cds_diagnose_poll(&diagnose);
            turn();
            cds_bus_poll(&bus);
        }
        if (diagnose.steps.result != CDS_PENDING)
            break;
        cds_diagnose_abort(&diagnose);
        go_on();
        TEST_ASSERT_EQUAL(diagnose.finding == CDS_FINDING_NONE ? CDS_CANCELLED : CDS_OK,
                          diagnose.steps.result);
        assert_given_back();
    }
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_RATE, diagnose.finding);
}

static void go_on_for(uint16_t polls)
{
    while (polls-- && cds_diagnose_poll(&diagnose) == CDS_PENDING) {
        turn();
        cds_bus_poll(&bus);
    }
}

/* In the middle of listening, of questions, of a question with the bus's own delay, of a search at
 * other rates. */
void test_a_bus_that_is_opened_anew_is_its_opener_s(void)
{
    for (uint16_t polls = 1; polls < 8000; polls = (uint16_t)(polls + 1 + polls / 7)) {
        for (uint8_t told = 0; told < 2; told++) {
            setUp();
            put(0, polls & 1 ? ID : 9, polls & 1 ? 1 : 103);
            go_on_for(polls);
            if (diagnose.steps.result != CDS_PENDING)
                continue;
            cds_bus_open(&bus, 0, 7);
            if (told)
                cds_bus_set_return_delay(&bus, 20);
            TEST_ASSERT_EQUAL(CDS_CANCELLED, go_on());
            TEST_ASSERT_EQUAL_UINT8(7, bus.baud_reg);
            TEST_ASSERT_EQUAL_UINT16(told ? 20 : CDS_RETURN_DELAY_MAX_US, bus.return_delay_us);
        }
    }
}

void test_one_whose_request_is_cancelled_gives_all_back(void)
{
    put(0, ID, 1);
    do {
        TEST_ASSERT_EQUAL(CDS_PENDING, cds_diagnose_poll(&diagnose));
        if (diagnose.transactions == 5)
            port_fake_hear(&bus.link, (const uint8_t *)"\x55", 1); // the next one has to wait
        turn();
        cds_bus_poll(&bus);
    } while (!bus.request || port_fake_is_in_flight(&bus));
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_cancel(&bus, &request));
    TEST_ASSERT_EQUAL(CDS_CANCELLED, go_on());
    assert_given_back();
}

static enum cds_result refuse(struct cds_request *asked)
{
    asked->is_muted = !asked->ignores_servo_state;
    return asked->ignores_servo_state ? CDS_OK : CDS_NO_REPLY_DUE;
}

void test_what_the_permit_knows_of_servos_is_not_used(void)
{

    put(0, ID, 1);
    bus.hooks = NULL; // instead of the queue's
    permit_fake_attach(&bus, refuse);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
}

/* ---- the line ---- */

static void listen_to(uint8_t bytes, bool packets)
{
    put(0, ID, 1);
    while (port_fake.now_us < 30000) {
        cds_diagnose_poll(&diagnose);
        turn();
        cds_bus_poll(&bus);
    }
    for (uint8_t i = 0; i < bytes; i++)
        port_fake_hear(&bus.link, (const uint8_t *)"\x80", 1);
    if (packets)
        port_fake_answer(&bus.link, 77, 2, NULL, 0);
}

void test_up_to_three_bytes_unasked_are_nothing(void)
{
    listen_to(3, false);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
    setUp();
    listen_to(4, false);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found());
    TEST_ASSERT_EQUAL_UINT16(4, diagnose.unrequested_bytes);
    setUp();
    listen_to(3, false);
    cds_link_on_rx(&bus.link, 0, CDS_LINE_FRAMING);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found());
}

void test_a_packet_unasked_is_somebody_else_s(void)
{
    listen_to(0, true);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_COLLISION, found());
    TEST_ASSERT_EQUAL_UINT16(1, diagnose.unexpected_packets);
    TEST_ASSERT_EQUAL_UINT16(0, diagnose.transactions);
}

void test_a_line_that_is_low(void)
{
    port_fake.low = true;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_LINE_LOW, found());
    TEST_ASSERT_EQUAL_UINT16(0, diagnose.transactions);
}

/* The echo of a PING is a good answer with a voltage error, and a real answer comes behind it. */
void test_all_that_is_sent_comes_back(void)
{
    for (uint8_t there = 0; there < 2; there++) {
        setUp();
        if (there)
            put(0, ID, 1);
        world.echoes = true;
        TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_ECHO, found());
    }
}

void test_a_servo_whose_answer_to_PING_is_like_an_echo(void)
{
    uint8_t answers = 0;

    put(0, ID, 1);
    servos.servo[0].table[CDS_REG_PRESENT_VOLTAGE] = 55;
    world.error = CDS_ERROR_VOLTAGE;
    while (cds_diagnose_poll(&diagnose) == CDS_PENDING) {
        port_fake.now_us += 20;
        if (bus.link.state == CDS_LINK_TALKING && port_fake.lines[0] == FAKE_TALK &&
            port_fake_transmit(&bus.link, 0)) {
            if (port_fake.sent[4] == CDS_PING) {
                port_fake_answer(&bus.link, ID, CDS_ERROR_VOLTAGE, NULL, 0);
                answers++;
            } else {
                meet();
            }
        }
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL_UINT8(7, answers);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_LOW_SUPPLY, diagnose.finding);
    TEST_ASSERT_EQUAL_UINT16(5500, diagnose.value);
}

void test_bytes_that_this_controller_loses(void)
{
    put(0, ID, 1);
    world.lost = 1;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_BYTES_LOST, found());
    TEST_ASSERT_EQUAL_UINT16(4, diagnose.overruns);
}

/* ---- damage ---- */

void test_replies_one_damaged_is_ignored_two_are_noise(void)
{
    for (uint8_t at = 0; at < QUESTIONS; at++)
        TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found_for(questions(at, 1), false, false));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found_for(questions(0, 2), false, false));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE,
                            found_for(questions(QUESTIONS - 2, 2), false, false));
}

void test_one_bad_examination_is_nothing_if_the_next_one_is_clean(void)
{
    put(0, ID, 1);
    world.spoilt = questions(2, 5);
    world.once = true;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
    TEST_ASSERT_EQUAL_UINT16(QUESTIONS + 20, diagnose.transactions);
    TEST_ASSERT_EQUAL_UINT8(QUESTIONS, diagnose.total.answered);
}

void test_a_servo_that_was_deaf_at_first(void)
{
    put(0, ID, 1);
    put(1, 200, 1);
    servos.plan[0] = (struct servos_plan){1, CUT_BEFORE, 20};
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
    TEST_ASSERT_EQUAL_UINT8(ID, diagnose.found_id);
}

void test_damage_only_where_two_servos_would_differ(void)
{
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID,
                            found_for(questions(MEASUREMENT, 6), false, false));
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(QUESTIONS, diagnose.transactions); // without asking others
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID,
                            found_for(questions(MEASUREMENT, 5), false, false));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found_for(questions(MEASUREMENT, 4), false, false));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found_for(questions(FIRST_READ, 6), false, false));
}

void test_much_damage_is_judged_by_another_servo(void)
{
    for (uint8_t count = 8; count <= QUESTIONS; count = (uint8_t)(count + 4)) {
        uint32_t spoilt = questions(0, count);

        TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID, found_for(spoilt, true, false));
        TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found_for(spoilt, true, true));
    }
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found_for(questions(0, 7), true, false));
}

void test_much_damage_of_the_only_servo(void)
{
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found_for(questions(0, 11), false, false));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID, found_for(questions(0, 12), false, false));
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(300, diagnose.transactions);
    TEST_ASSERT_LESS_THAN_UINT32(400000, port_fake.now_us);
}

void test_bytes_that_begin_no_packet_are_damage_and_not_silence(void)
{
    put(0, ID, 1);
    world.cut = 1;
    world.damage = 0x0C;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID, found());
    TEST_ASSERT_EQUAL_UINT8(QUESTIONS, diagnose.total.damaged);
    TEST_ASSERT_EQUAL_UINT8(0, diagnose.total.silent);
}

static uint8_t found_cut(uint8_t cut, uint8_t error, uint8_t twin)
{
    setUp();
    put(0, ID, 1);
    put(1, 200, 1);
    world.cut = cut;
    world.error = error;
    servos.servo[0].table[CDS_REG_PRESENT_POSITION] = 3;
    world.twin = twin;
    return found();
}

void test_answers_whole_but_for_their_first_bytes_come_too_soon(void)
{
    for (uint8_t cut = 1; cut <= 4; cut++) {
        TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_REPLIES_TOO_EARLY, found_cut(cut, 0, 0));
        TEST_ASSERT_EQUAL_UINT8(QUESTIONS, diagnose.total.cut);
        TEST_ASSERT_EQUAL_UINT16(QUESTIONS, diagnose.transactions);
        TEST_ASSERT_EQUAL_UINT8(ID, diagnose.found_id);
    }
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_REPLIES_TOO_EARLY, found_cut(1, CDS_ERROR_OVERLOAD, 0));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_REPLIES_TOO_EARLY,
                            found_cut(1, CDS_ERROR_VOLTAGE, 0)); // no echo
    TEST_ASSERT_NOT_EQUAL(CDS_FINDING_REPLIES_TOO_EARLY,
                          found_cut(5, 0, 0)); // no ERROR: who can tell?
}

void test_twins_both_too_early_are_told_by_their_values(void)
{
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID, found_cut(1, 0, 1));
    TEST_ASSERT_EQUAL_UINT8(10, diagnose.total.cut);
}

void test_a_quarter_of_the_answers_coming_too_soon_is_enough(void)
{
    for (uint8_t cut = 3; cut <= QUESTIONS; cut++) {
        setUp();
        put(0, ID, 1);
        world.cut = 1;
        world.whole = questions(0, (uint8_t)(QUESTIONS - cut));
        TEST_ASSERT_EQUAL_UINT8(cut > 3 ? CDS_FINDING_REPLIES_TOO_EARLY : CDS_FINDING_NOISE,
                                found());
    }
}

void test_answers_that_come_too_soon_among_damaged_ones_are_noise(void)
{
    for (uint8_t damaged = 1; damaged <= 3; damaged++) {
        setUp();
        put(0, ID, 1);
        world.cut = 1;
        world.spoilt = questions(0, damaged);
        world.whole = questions(damaged, 8);
        TEST_ASSERT_EQUAL_UINT8(damaged < 3 ? CDS_FINDING_REPLIES_TOO_EARLY : CDS_FINDING_NOISE,
                                found());
    }
}

void test_lost_first_bytes_are_no_sign_of_two(void)
{
    put(0, ID, 1);
    world.cut = 1;
    world.spoilt = questions(0, 2);
    world.whole = questions(2, 9); // the last five come too soon, all where two would differ
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found());
}

void test_one_that_answers_PING_only_and_too_soon(void)
{
    put(0, ID, 1);
    world.cut = 1;
    world.mute = true;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_REPLIES_TOO_EARLY, found());
}

/* ---- what a servo says of itself ---- */

static uint8_t found_with(uint8_t error, uint8_t address, uint8_t value)
{
    setUp();
    put(0, ID, 1);
    world.error = error;
    servos.servo[0].table[address] = value;
    return found();
}

void test_limits_of_the_servo_value_at_the_limit_is_within(void)
{
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found_with(0, CDS_REG_PRESENT_VOLTAGE, 60));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_LOW_SUPPLY, found_with(0, CDS_REG_PRESENT_VOLTAGE, 59));
    TEST_ASSERT_EQUAL_UINT16(5900, diagnose.value);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found_with(0, CDS_REG_PRESENT_VOLTAGE, 160));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_HIGH_SUPPLY, found_with(0, CDS_REG_PRESENT_VOLTAGE, 255));
    TEST_ASSERT_EQUAL_UINT16(25500, diagnose.value);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found_with(0, CDS_REG_PRESENT_TEMPERATURE, 80));
    TEST_ASSERT_EQUAL_UINT16(0, diagnose.value);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OVERHEATED, found_with(0, CDS_REG_PRESENT_TEMPERATURE, 81));
    TEST_ASSERT_EQUAL_UINT16(81, diagnose.value);
}

void test_error_bits(void)
{
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_LOW_SUPPLY, found_with(CDS_ERROR_VOLTAGE, 0x18, 0));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OVERHEATED, found_with(CDS_ERROR_OVERHEATING, 0x18, 0));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OVERLOADED, found_with(CDS_ERROR_OVERLOAD, 0x18, 0));
    TEST_ASSERT_EQUAL_HEX8(CDS_ERROR_OVERLOAD, diagnose.error);
}

void test_max_torque_0_has_a_finding(void)
{
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NO_TORQUE, found_with(0, CDS_REG_MAX_TORQUE, 0));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OVERLOADED,
                            found_with(CDS_ERROR_OVERLOAD, CDS_REG_MAX_TORQUE, 0));
    setUp();
    put(0, ID, 1);
    servos.servo[0].table[CDS_REG_MAX_TORQUE] = 0;
    servos.servo[0].table[CDS_REG_MAX_TORQUE + 1] = 1;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
}

/* ---- causes that the line shows while it is used ---- */

#define ALL           (~(uint32_t)0)
#define FROM_STRANGER "\xFF\xFF\x4D\x02\x00\xB0"
#define FROM_ID       "\xFF\xFF\x05\x02\x00\xF8"
#define BYTES(literal, first, end)                                                                 \
    (struct bytes)                                                                                 \
    {                                                                                              \
        literal, sizeof literal - 1, first, end                                                    \
    }

void test_line_in_constant_use_is_babble_after_two_requests(void)
{
    put(0, ID, 1);
    world.idle = BYTES("\x80", 1, 255);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_BABBLE, found());
    TEST_ASSERT_EQUAL_UINT16(2, bus.stats.line_busy);
    TEST_ASSERT_EQUAL_UINT8(2, diagnose.total.busy);
    TEST_ASSERT_EQUAL_UINT8(1, diagnose.total.answered);
}

void test_line_in_use_for_one_request_is_no_finding(void)
{
    put(0, ID, 1);
    world.idle = BYTES("\x80", 6, 7);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
    TEST_ASSERT_EQUAL_UINT16(1, bus.stats.line_busy);
    TEST_ASSERT_EQUAL_UINT8(1, diagnose.total.busy);
    TEST_ASSERT_EQUAL_UINT8(15, diagnose.total.answered);
}

void test_busy_line_names_its_cause(void)
{
    put(0, ID, 1);
    world.idle = BYTES(FROM_STRANGER, 1, 255);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_COLLISION, found());
    TEST_ASSERT_EQUAL_UINT16(2, bus.stats.line_busy);
    setUp();
    put(0, ID, 1);
    world.idle = BYTES(FROM_ID, 1, 255);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID, found());
    TEST_ASSERT_EQUAL_UINT16(2, bus.stats.line_busy);
    TEST_ASSERT_EQUAL_UINT8(ID, diagnose.found_id);
}

void test_line_low_after_listening_is_line_low(void)
{
    put(0, ID, 1);
    while (diagnose.transactions == 0)
        go_on_for(1);
    port_fake.low = true;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_LINE_LOW, found());
    TEST_ASSERT_EQUAL_UINT16(2, bus.stats.line_busy);
}

void test_own_bytes_changed_twice_are_a_collision(void)
{
    put(0, ID, 1);
    world.collides = true;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_COLLISION, found());
    TEST_ASSERT_EQUAL_UINT16(4, diagnose.transactions); // the first series
    TEST_ASSERT_EQUAL_UINT16(4, diagnose.echo_errors);
}

void test_packets_of_others_during_reads_are_a_collision(void)
{
    put(0, ID, 1);
    world.behind = BYTES(FROM_STRANGER, 4, 6); // during READs of the ID
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_COLLISION, found());
    TEST_ASSERT_EQUAL_UINT16(10, diagnose.transactions);
    TEST_ASSERT_EQUAL_UINT16(2, diagnose.unexpected_packets);
    setUp();
    put(0, ID, 1);
    world.behind = BYTES(FROM_STRANGER, 10, 12); // during READs of what varies
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_COLLISION, found());
    TEST_ASSERT_EQUAL_UINT16(16, diagnose.transactions);
    setUp();
    put(0, ID, 1);
    world.behind = BYTES(FROM_STRANGER, 4, 5);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found()); // one is ignored
    TEST_ASSERT_EQUAL_UINT16(1, diagnose.unexpected_packets);
}

void test_packets_of_others_behind_pings_count_at_reads(void)
{
    put(0, ID, 1);
    world.behind = BYTES(FROM_STRANGER, 0, 4);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_COLLISION, found());
    TEST_ASSERT_EQUAL_UINT16(10, diagnose.transactions); // a PING may meet its own echo
}

void test_second_replies_to_reads_are_a_duplicate_id(void)
{
    put(0, ID, 1);
    world.behind = BYTES(FROM_ID, 4, 6);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID, found());
    TEST_ASSERT_EQUAL_UINT16(10, diagnose.transactions);
    TEST_ASSERT_EQUAL_UINT16(2, diagnose.duplicate_replies);
    setUp();
    put(0, ID, 1);
    world.behind = BYTES(FROM_ID, 4, 5);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found()); // one is ignored
}

void test_second_replies_to_pings_are_judged_by_reads(void)
{
    put(0, ID, 1);
    world.behind = BYTES(FROM_ID, 0, 4);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID, found());
    TEST_ASSERT_EQUAL_UINT16(10, diagnose.transactions);
}

/* A servo has answered just before the diagnosis, and two more of its packets come while the
 * diagnosis listens. */
static uint8_t found_after_replies(uint8_t count, uint8_t id)
{
    static uint8_t buffer[8];
    struct cds_request before = CDS_REQUEST_WITHOUT_DATA(buffer);

    setUp();
    cds_diagnose_abort(&diagnose);
    go_on();
    put(0, ID, 1);
    cds_packet_ping(&before.packet, ID);
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &before));
    while (before.result == CDS_PENDING) {
        turn();
        cds_bus_poll(&bus);
    }
    TEST_ASSERT_EQUAL(CDS_OK, before.result);
    world.to_id = 0;
    begin(ID);
    while (port_fake.now_us < 30000)
        go_on_for(1);
    while (count--)
        port_fake_answer(&bus.link, id, 0, NULL, 0);
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    assert_given_back();
    return diagnose.finding;
}

void test_unrequested_replies_of_last_servo_mean_duplicate_id(void)
{
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID, found_after_replies(2, ID));
    TEST_ASSERT_EQUAL_UINT8(ID, diagnose.found_id);
    TEST_ASSERT_EQUAL_UINT16(0, diagnose.transactions);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found_after_replies(1, ID)); // six bytes
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_COLLISION, found_after_replies(1, 77));
}

void test_echo_in_part_counts_if_nothing_or_a_reply_follows(void)
{
    static const char *const behind[] = {"",     "\xFF\xFF\x05", "\xFF\xFF", "\xFF",
                                         "\x55", "\x55\xFF",     "\xFF\x55"};

    for (uint8_t i = 0; i < 7; i++) {
        bool is_echo = i < 3;

        setUp();
        world.echoes = true;
        world.echo_from = 5; // so little of a PING is no reply without its first bytes
        world.behind = (struct bytes){behind[i], (uint8_t)strlen(behind[i]), 0, 255};
        TEST_ASSERT_EQUAL(is_echo, found() == CDS_FINDING_ECHO);
        TEST_ASSERT_EQUAL_UINT8(is_echo ? 4 : 0, diagnose.total.echoed); // the first series
        if (is_echo)
            TEST_ASSERT_EQUAL_UINT16(4, diagnose.transactions);
    }
}

void test_echo_of_a_broadcast_ping_is_an_echo(void)
{
    cds_diagnose_abort(&diagnose);
    go_on();
    begin(CDS_BROADCAST_ID);
    world.echoes = true;
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_ECHO, diagnose.finding);
    TEST_ASSERT_EQUAL_UINT16(3, diagnose.transactions);
}

void test_more_bytes_than_any_reply_are_damage(void)
{
    put(0, ID, 1);
    world.spoilt = ALL;
    world.behind =
        BYTES("\x05\x02\x00\xF8\x05\x02\x00\xF8\x05\x02\x00\xF8\x05\x02\x00\xF8", 0, QUESTIONS);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID, found()); // no other servo, all damaged
    TEST_ASSERT_EQUAL_UINT8(QUESTIONS, diagnose.total.damaged);
    TEST_ASSERT_EQUAL_UINT8(0, diagnose.total.cut);
}

/* ---- silence ---- */

void test_servo_that_answers_ping_only_is_examined_twice(void)
{
    put(0, ID, 1);
    world.mute = true;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NO_REPLY_BY_LEVEL, found());
    TEST_ASSERT_EQUAL_UINT16(4 + 6 + 1 + 4 + 6, diagnose.transactions); // one PING resynchronises
    TEST_ASSERT_EQUAL_UINT8(10, diagnose.total.asked); // the second examination alone
    TEST_ASSERT_EQUAL_UINT8(4, diagnose.total.answered);
    TEST_ASSERT_EQUAL_UINT8(6, diagnose.total.silent);
}

void test_servo_is_resynchronised_by_at_most_43_pings(void)
{
    put(0, ID, 1);
    world.silent = ALL << 4;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
    TEST_ASSERT_EQUAL_UINT16(32 + 1 + 20, diagnose.transactions); // packet 32 is answered
    setUp();
    put(0, ID, 1);
    servos.plan[0] = (struct servos_plan){5, CUT_BEFORE, SERVOS_FOREVER};
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_ID, found());
    TEST_ASSERT_EQUAL_UINT16(4 + 6 + 43 + 4, diagnose.transactions);
}

void test_late_replies_to_pings_are_slow(void)
{
    put(0, ID, 1);
    world.late = ALL;
    world.late_us = 900;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_SLOW, found());
    TEST_ASSERT_EQUAL_UINT16(0, diagnose.value); // not known
    TEST_ASSERT_EQUAL_UINT8(ID, diagnose.found_id);
    TEST_ASSERT_EQUAL_UINT16(4, diagnose.stale_replies);
    TEST_ASSERT_EQUAL_UINT16(4, diagnose.transactions);
}

static uint8_t found_late(uint32_t late)
{
    setUp();
    put(0, ID, 1);
    servos.servo[0].table[CDS_REG_RETURN_DELAY] = 150;
    world.late = late;
    world.late_us = 300;
    return found();
}

void test_servo_slower_than_the_bus_waits_is_slow_with_its_delay(void)
{
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_SLOW, found_late(ALL));
    TEST_ASSERT_EQUAL_UINT16(300, diagnose.value);
    TEST_ASSERT_EQUAL_UINT16(20, diagnose.transactions);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found_late(questions(17, 2))); // one of three in time
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_SLOW, found_late(questions(17, 3)));
}

void test_delay_is_not_checked_if_the_bus_waits_longest(void)
{
    cds_diagnose_abort(&diagnose);
    go_on();
    cds_bus_set_return_delay(&bus, CDS_RETURN_DELAY_MAX_US);
    begin(ID);
    put(0, ID, 1);
    world.late = ALL;
    world.late_us = 300;
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, diagnose.finding);
    TEST_ASSERT_EQUAL_UINT16(QUESTIONS + 1, diagnose.transactions);
    TEST_ASSERT_EQUAL_UINT16(CDS_RETURN_DELAY_MAX_US, bus.return_delay_us);
}

static enum cds_result allow(struct cds_request *asked)
{
    (void)asked;
    return CDS_OK;
}

static void ignore_packet(void *context, enum cds_bus_event event, uint8_t id, uint8_t error)
{
    (void)context;
    (void)event;
    (void)id;
    (void)error;
}

/* A diagnosis of servo ID on a bus with a permit that waits `wait_us`. Its replies come 300 us
 * late. */
static uint8_t found_late_with_permit(uint16_t wait_us, uint8_t return_delay)
{
    bus.hooks = NULL; // instead of the queue's
    rig_open(0);
    memset(&world, 0, sizeof world);
    permit_fake_attach(&bus, allow);
    permit_fake.hooks.on_packet = ignore_packet;
    cds_bus_set_return_delay(&bus, wait_us);
    begin(ID);
    put(0, ID, 1);
    servos.servo[0].table[CDS_REG_RETURN_DELAY] = return_delay;
    world.late = ALL;
    world.late_us = 300;
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    TEST_ASSERT_EQUAL_UINT16(wait_us, bus.return_delay_us);
    return diagnose.finding;
}

void test_servo_later_than_its_return_delay_is_slow(void)
{
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_SLOW, found_late_with_permit(CDS_RETURN_DELAY_MAX_US, 1));
    TEST_ASSERT_EQUAL_UINT16(2, diagnose.value);
    TEST_ASSERT_EQUAL_UINT16(20, diagnose.transactions);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found_late_with_permit(CDS_RETURN_DELAY_MAX_US, 150));
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_SLOW, found_late_with_permit(40, 150));
}

void test_limits_always_damaged_are_two_servos(void)
{
    put(0, ID, 1);
    world.bad_limits = 3;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_DUPLICATE_ID, found());
    TEST_ASSERT_EQUAL_UINT8(ID, diagnose.found_id);
    setUp();
    put(0, ID, 1);
    world.bad_limits = 2;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
}

void test_unknown_limits_leave_the_error_bits_to_judge(void)
{
    put(0, ID, 1);
    world.hides_limits = true;
    servos.servo[0].table[CDS_REG_PRESENT_VOLTAGE] = 255;
    servos.servo[0].table[CDS_REG_PRESENT_TEMPERATURE] = 255;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
    TEST_ASSERT_EQUAL_UINT16(QUESTIONS + 3 + 3, diagnose.transactions);
    setUp();
    put(0, ID, 1);
    world.hides_limits = true;
    world.error = CDS_ERROR_VOLTAGE;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_LOW_SUPPLY, found());
}

/* ---- other servos, other rates ---- */

static uint8_t found_of(uint8_t id)
{
    cds_diagnose_abort(&diagnose);
    go_on();
    begin(id);
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    assert_given_back();
    return diagnose.finding;
}

void test_servo_of_another_id_is_named(void)
{
    static const uint8_t others[] = {0, ID - 1, ID + 1, 200, CDS_ID_MAX};

    for (uint8_t i = 0; i < sizeof others; i++) {
        setUp();
        put(1, others[i], 1);
        TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_ID, found());
        TEST_ASSERT_EQUAL_UINT8(others[i], diagnose.found_id);
        TEST_ASSERT_EQUAL_UINT8(0, world.reads);
        TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, diagnose.found_baud_reg);
    }
}

void test_servos_that_answer_a_broadcast_at_once_are_sought(void)
{
    static const uint8_t others[] = {0, ID - 1, ID + 1, 200, CDS_ID_MAX - 1};

    for (uint8_t i = 0; i < sizeof others; i++) {
        setUp();
        put(1, others[i], 1);
        put(2, CDS_ID_MAX, 1);
        TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_ID, found());
        TEST_ASSERT_EQUAL_UINT8(others[i], diagnose.found_id);
        TEST_ASSERT_EQUAL_UINT8(0, world.reads);
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(300, diagnose.transactions);
    }
}

void test_any_servo_is_examined_alone_or_of_several(void)
{
    for (uint8_t count = 1; count <= 3; count++) {
        setUp();
        for (uint8_t i = 0; i < count; i++)
            put(i, (uint8_t)(9 + i), 1);
        TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found_of(CDS_BROADCAST_ID));
        TEST_ASSERT_EQUAL_UINT8(9, diagnose.found_id);
        TEST_ASSERT_EQUAL_UINT8(QUESTIONS, diagnose.total.answered);
    }
}

void test_any_servo_of_none_is_silence(void)
{
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_SILENCE, found_of(CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL_UINT8(CDS_NO_ID, diagnose.found_id);
    TEST_ASSERT_EQUAL_UINT16(3 + 5 * 2, diagnose.transactions);
}

void test_servo_at_each_other_listed_rate_is_found(void)
{
    static const uint8_t rates[] = {3, 7, 16, 34, 103};

    for (uint8_t i = 0; i < 2 * sizeof rates; i++) {
        setUp();
        put(0, ID, rates[i / 2]);
        TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_RATE, found_of(i & 1 ? CDS_BROADCAST_ID : ID));
        TEST_ASSERT_EQUAL_UINT8(ID, diagnose.found_id);
        TEST_ASSERT_EQUAL_UINT8(rates[i / 2], diagnose.found_baud_reg);
        TEST_ASSERT_EQUAL_UINT8(0, world.reads);
    }
}

void test_servo_at_the_known_rate_is_found_first(void)
{
    put(0, ID, 9);
    put(1, 8, 1);
    diagnose.known_baud_reg = 9;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_RATE, found());
    TEST_ASSERT_EQUAL_UINT8(ID, diagnose.found_id);
    TEST_ASSERT_EQUAL_UINT8(9, diagnose.found_baud_reg);
    setUp();
    put(0, ID, 9);
    put(1, 8, 1);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_ID, found());
}

void test_target_at_another_rate_counts_before_another_id(void)
{
    put(0, ID, 34);
    put(1, 9, 1);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_RATE, found());
    TEST_ASSERT_EQUAL_UINT8(ID, diagnose.found_id);
    TEST_ASSERT_EQUAL_UINT8(34, diagnose.found_baud_reg);
}

void test_several_servos_at_another_rate_have_no_id(void)
{
    put(1, 9, 34);
    put(2, 10, 34);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_RATE, found());
    TEST_ASSERT_EQUAL_UINT8(CDS_NO_ID, diagnose.found_id);
    TEST_ASSERT_EQUAL_UINT8(34, diagnose.found_baud_reg);
}

void test_one_lost_reply_at_another_rate_still_finds_the_servo(void)
{
    for (uint8_t lost = 1; lost < 4; lost++) {
        setUp();
        put(0, ID, 103);
        world.silent = questions((uint8_t)(3 + lost), 1); // the slowest rate is tried first
        TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_RATE, found());
        TEST_ASSERT_EQUAL_UINT8(103, diagnose.found_baud_reg);
    }
}

void test_damage_after_broadcasts_from_no_servo_is_noise(void)
{
    world.behind = BYTES("\x55\x55\x55", 4, 7); // behind three broadcast PINGs
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found());
    TEST_ASSERT_EQUAL_UINT8(CDS_NO_ID, diagnose.found_id);
    setUp();
    world.behind = BYTES("\x55\x55\x55", 4, 5);
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_SILENCE, found());
    TEST_ASSERT_EQUAL_UINT16(31, diagnose.transactions);
}

/* Replies of an ID that no servo has, of which the broadcast's replies are made up. */
void test_made_up_id_is_not_examined_but_a_servo_is_sought(void)
{
    put(1, 9, 1);
    put(2, 10, 1);
    world.behind = BYTES(FROM_STRANGER, 0, 3); // behind the damage of two replies
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found_of(CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL_UINT8(9, diagnose.found_id);
}

void test_one_reply_of_a_candidate_of_three_is_not_enough(void)
{
    for (uint8_t heard = 1; heard < 3; heard++) {
        setUp();
        put(1, 200, 1);
        world.behind = BYTES("\x55", 0, 0);
        servos.plan[0] = (struct servos_plan){8, LOSE_REPLY, 0}; // of the three PINGs that name it
        servos.plan[1] = (struct servos_plan){heard == 1 ? 9 : 99, LOSE_REPLY, 0};
        TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_ID, found());
        TEST_ASSERT_EQUAL_UINT8(200, diagnose.found_id);
        if (heard == 1) // it is sought among all IDs but the target's
            TEST_ASSERT_GREATER_THAN_UINT16(200, diagnose.transactions);
        else
            TEST_ASSERT_LESS_THAN_UINT16(50, diagnose.transactions);
    }
}

void test_target_that_answers_a_broadcast_is_examined_again(void)
{
    put(0, ID, 1);
    world.silent = questions(0, 4); // the first four PINGs of it
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
    TEST_ASSERT_EQUAL_UINT8(ID, diagnose.found_id);
    TEST_ASSERT_EQUAL_UINT16(4 + 3 + 3 + 20, diagnose.transactions);
}

void test_request_in_flight_delays_the_change_of_rate(void)
{
    static uint8_t buffer[8];
    struct cds_request other = CDS_REQUEST_WITHOUT_DATA(buffer);

    put(0, ID, 103);
    while (diagnose.transactions < 4 + 3)
        go_on_for(1);
    cds_packet_ping(&other.packet, 77);
    other.passes_lock = other.no_retry = true;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, &other));
    while (other.result == CDS_PENDING) {
        TEST_ASSERT_EQUAL_UINT8(CDS_BAUD_1M, port_fake.bauds[0]);
        go_on_for(1);
    }
    TEST_ASSERT_EQUAL(CDS_TIMEOUT, other.result);
    TEST_ASSERT_EQUAL(CDS_OK, go_on());
    assert_given_back();
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OTHER_RATE, diagnose.finding);
}

static enum cds_result refuse_all(struct cds_request *asked)
{
    (void)asked;
    return CDS_INHIBITED;
}

void test_refusal_of_the_permit_ends_the_diagnosis(void)
{
    put(0, ID, 1);
    bus.hooks = NULL; // instead of the queue's
    permit_fake_attach(&bus, refuse_all);
    TEST_ASSERT_EQUAL(CDS_INHIBITED, go_on());
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NONE, diagnose.finding);
    TEST_ASSERT_EQUAL_UINT16(0, diagnose.transactions);
    assert_given_back();
}

void test_end_of_a_broadcast_ping_is_an_echo_not_a_reply(void)
{
    world.echoes = true;
    world.echo_from = 2;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_ECHO, found_of(CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL_UINT16(3, diagnose.transactions);
}

void test_second_replies_to_a_broadcast_are_no_duplicate_id(void)
{
    put(1, 9, 1);
    world.behind = BYTES("\xFF\xFF\x09\x02\x00\xF4", 0, 3); // another servo answers, too
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found_of(CDS_BROADCAST_ID));
    TEST_ASSERT_EQUAL_UINT8(9, diagnose.found_id);
    TEST_ASSERT_EQUAL_UINT16(0, diagnose.duplicate_replies);
}

void test_replies_that_complain_of_the_packet_are_damage(void)
{
    put(0, ID, 1);
    put(1, 200, 1);
    servos.servo[0].error = servos.servo[1].error = CDS_ERROR_CHECKSUM;
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_NOISE, found());
    TEST_ASSERT_EQUAL_UINT8(QUESTIONS, diagnose.total.damaged);
    TEST_ASSERT_EQUAL_UINT8(0, diagnose.total.answered);
}

/* Instruction, address and length of each packet, in its order. */
void test_examination_sends_these_packets(void)
{
    static const struct {
        uint8_t count, instruction, address, length;
    } series[] = {{4, CDS_PING, 0, 0},
                  {6, CDS_READ, CDS_REG_ID, 1},
                  {6, CDS_READ, CDS_REG_PRESENT_POSITION, 8},
                  {1, CDS_READ, CDS_REG_RETURN_DELAY, 20},
                  {3, CDS_PING, 0, 0}};

    put(0, ID, 1);
    for (uint8_t i = 0; i < 5; i++) {
        for (uint8_t k = 0; k < series[i].count; k++) {
            const uint8_t *bytes = packet;
            uint8_t sent = world.to_id;

            while (bus.state < CDS_BUS_SENDING)
                go_on_for(1);
            TEST_ASSERT_EQUAL_UINT8(ID, bytes[CDS_AT_ID]);
            TEST_ASSERT_EQUAL_HEX8(series[i].instruction, bytes[CDS_AT_INSTRUCTION]);
            if (series[i].length) {
                TEST_ASSERT_EQUAL_HEX8(series[i].address, bytes[CDS_AT_PARAMETERS]);
                TEST_ASSERT_EQUAL_UINT8(series[i].length, bytes[CDS_AT_PARAMETERS + 1]);
            }
            while (world.to_id == sent || bus.request)
                go_on_for(1);
        }
    }
    TEST_ASSERT_EQUAL_UINT8(CDS_FINDING_OK, found());
}
