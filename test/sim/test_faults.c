/* SPDX-License-Identifier: MIT */
/* Every fault on a wire without an AVR: its effect on levels, bytes, framing and time. The tests
 * have their own model: an array of levels, one for each bit at 1 Mbit/s (1 us). */
#include "script/faults.h"
#include "unity.h"

#include <string.h>

#define CLOCK 16000000u
#define BIT   16u // cycles at 1 Mbit/s
#define FAST  (BIT * 256u)
#define US    16u
#define ROOM  6000

static struct schedule schedule;
static struct net sig, rxd;
static struct driver driver, rx_buffer;
static struct uart_tx tx;
static struct servos servos;
static struct faults faults;
static struct listener on_sig;

struct log {
    struct uart_rx rx;
    unsigned count;
    struct uart_frame heard[ROOM];
};
static struct log wire, receiver;

struct edge {
    uint64_t time;
    bool level;
};
static struct edge edges[200000];
static unsigned edge_count, glitches;
static uint64_t began, ended;     // a servo's driver
static uint64_t collided, parted; // cycles at which two senders begin and end to drive together

/* The bytes of the controller, sent without a gap. */
static const uint8_t *speech;
static unsigned left;
static uint32_t speed;

static void say_next(void *context, uint64_t now)
{
    (void)context;
    if (left) {
        left--;
        uart_tx_send(&tx, now, speed, *speech++);
    } else {
        driver_enable(&driver, now, false);
    }
}

static void says(void *context, uint64_t now)
{
    (void)context;
    faults_controller_byte(&faults, now, &tx);
}

static void on_byte(void *context, uint64_t now, const struct uart_frame *frame)
{
    struct log *log = context;
    (void)now;
    TEST_ASSERT_LESS_THAN_UINT(ROOM, log->count);
    log->heard[log->count++] = *frame;
}

/* Counts pulses of 0 cycles and does not keep them. */
static void on_level(void *context, uint64_t time, bool level)
{
    (void)context;
    if (edge_count && edges[edge_count - 1].time == time) {
        edge_count--;
        glitches++;
        return;
    }
    TEST_ASSERT_LESS_THAN_UINT(200000, edge_count);
    edges[edge_count++] = (struct edge){time, level};
}

static void on_driver(void *context, uint64_t time, struct driver *who)
{
    (void)context;
    if (who == &driver) {
        return;
    }
    if (who->enabled) {
        began = time;
        collided = sig.enabled == 2 ? time : collided;
    } else {
        ended = time;
        parted = sig.enabled == 1 ? time : parted;
    }
}

static void listen(struct log *log, struct net *net)
{
    uart_rx_init(&log->rx, &schedule, net, log);
    log->rx.bit_time_256 = FAST;
    log->rx.on_byte = on_byte;
    uart_rx_enable(&log->rx, true);
}

static void set_up(uint32_t seed)
{
    schedule_init(&schedule);
    net_init(&sig);
    net_init(&rxd);
    driver_init(&driver, &sig);
    driver_init(&rx_buffer, &rxd);
    uart_tx_init(&tx, &schedule, &driver, 0);
    tx.on_start = says;
    tx.on_end = say_next;
    on_sig = (struct listener){.on_level = on_level, .on_driver = on_driver};
    net_listen(&sig, &on_sig);
    servos_init(&servos, &schedule, &sig, CLOCK);
    servos.seed = seed;
    faults_init(&faults, &schedule, &servos, seed);
    faults_connect_receiver(&faults, &rxd);
    wire.count = receiver.count = edge_count = glitches = 0;
    began = ended = collided = parted = 0;
    listen(&wire, &sig);
    listen(&receiver, &rxd);
}

void setUp(void)
{
    static const uint8_t one[] = {1};
    set_up(0);
    servos_replace(&servos, 0, one, 1);
}

void tearDown(void)
{
    servos_free(&servos);
    schedule_free(&schedule);
}

static void again(void)
{
    tearDown();
    setUp();
}

static void order(const char *text)
{
    TEST_ASSERT_NULL_MESSAGE(faults_order(&faults, schedule.now, text), text);
}

static void orderf(const char *format, unsigned a, unsigned b, unsigned c)
{
    char text[80];
    snprintf(text, sizeof(text), format, a, b, c);
    order(text);
}

static void pass(uint64_t cycles)
{
    schedule_run_until(&schedule, schedule.now + cycles);
}

static void forget(void)
{
    wire.count = receiver.count = edge_count = glitches = 0;
    began = ended = collided = parted = 0;
}

/* Returns the end of the last stop bit. */
static uint64_t say_at(uint32_t bit_time_256, const uint8_t *bytes, unsigned size)
{
    driver_enable(&driver, schedule.now, true);
    speech = bytes;
    left = size;
    speed = bit_time_256;
    say_next(0, schedule.now);
    while (tx.busy) {
        schedule_run_until(&schedule, uart_tx_end(&tx));
    }
    return schedule.now;
}

static unsigned build(uint8_t *packet, const uint8_t *body, unsigned size)
{
    unsigned sum = 0;
    packet[0] = packet[1] = 0xFF;
    for (unsigned i = 0; i < size; i++) {
        packet[i + 2] = body[i];
        sum += body[i];
    }
    packet[size + 2] = (uint8_t)~sum;
    return size + 3;
}

/* Sends an instruction packet and drops what was received before its end. */
static uint64_t say(const uint8_t *body, unsigned size)
{
    uint8_t packet[64];
    pass(50 * US);
    uint64_t end = say_at(FAST, packet, build(packet, body, size));
    forget();
    return end;
}

static const uint8_t ping[] = {1, 2, 1};
static const uint8_t ping_7[] = {7, 2, 1};
static const uint8_t read_led[] = {7, 4, 2, 0x18, 2};
static const uint8_t read_goal[] = {1, 4, 2, 0x1E, 2};
static const uint8_t torque_on[] = {1, 4, 3, 0x18, 1};

/* Runs the whole transaction. Returns the end of the instruction packet. */
static uint64_t transact(const uint8_t *body, unsigned size)
{
    uint64_t end = say(body, size);
    pass(1000 * US);
    return end;
}

static void assert_heard(const struct log *log, const uint8_t *bytes, unsigned count)
{
    TEST_ASSERT_EQUAL_UINT(count, log->count);
    for (unsigned i = 0; i < count; i++) {
        TEST_ASSERT_EQUAL_HEX8(bytes[i], log->heard[i].byte);
        TEST_ASSERT_FALSE(log->heard[i].framing_error);
    }
}

static const uint8_t pong[] = {0xFF, 0xFF, 1, 2, 0, 0xFC};

static void assert_ping_is_answered(void)
{
    transact(ping, 3);
    assert_heard(&wire, pong, 6);
    TEST_ASSERT_FALSE(servos.node[0].driver.exempt);
}

/* --- the model --- */

#define SLOTS 2000 // bits

static bool model[SLOTS];

static void model_idle(void)
{
    memset(model, 1, sizeof(model));
}

static void model_and(unsigned at, const uint8_t *bytes, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        model[at + 10 * i] = false;
        for (unsigned bit = 0; bit < 8; bit++) {
            model[at + 10 * i + 1 + bit] &= bytes[i] >> bit & 1;
        }
    }
}

/* The wire must follow the model from `start` on, to the cycle. A glitch is allowed only where two
 * servos change in the same cycle in opposite directions. */
static void assert_wire_is_model(uint64_t start)
{
    unsigned next = 0;
    bool level = true;
    for (unsigned slot = 0; slot < SLOTS; slot++) {
        if (model[slot] != level) {
            TEST_ASSERT_LESS_THAN_UINT(edge_count, next);
            TEST_ASSERT_EQUAL_UINT64(start + slot * BIT, edges[next].time);
            TEST_ASSERT_EQUAL(model[slot], edges[next].level);
            level = model[slot];
            next++;
        }
    }
    TEST_ASSERT_EQUAL_UINT(edge_count, next);
    TEST_ASSERT_TRUE(glitches == 0 || servos.count == 2);
}

/* A UART must receive the same from the model: a byte begins with a falling edge, and its stop bit
 * is the tenth bit. */
static void assert_heard_is_model(uint64_t start)
{
    unsigned count = 0;
    for (unsigned slot = 1; slot + 9 < SLOTS; slot++) {
        if (!model[slot - 1] || model[slot]) {
            continue;
        }
        unsigned byte = 0;
        for (unsigned bit = 0; bit < 8; bit++) {
            byte |= (unsigned)model[slot + 1 + bit] << bit;
        }
        TEST_ASSERT_LESS_THAN_UINT(wire.count, count);
        TEST_ASSERT_EQUAL_HEX8(byte, wire.heard[count].byte);
        TEST_ASSERT_EQUAL(!model[slot + 9], wire.heard[count].framing_error);
        TEST_ASSERT_EQUAL_UINT64(start + slot * BIT, wire.heard[count].start);
        count++;
        slot += 9;
    }
    TEST_ASSERT_EQUAL_UINT(wire.count, count);
}

/* The model begins 1 bit before the reply, which is due one return delay (2 us) after `end`. */
static void assert_reply_is_model(uint64_t end)
{
    assert_wire_is_model(end + 2 * US - BIT);
    assert_heard_is_model(end + 2 * US - BIT);
}

static const uint8_t goal[] = {0xFF, 0xFF, 1, 4, 0, 0x00, 0x02, 0xF8}; // factory: 512

static void model_goal(void)
{
    model_idle();
    model_and(1, goal, 8);
}

/* --- F1, F2: flipped bits --- */

void test_F1_every_bit_of_a_reply_can_be_flipped(void)
{
    for (unsigned bit = 0; bit < 80; bit++) {
        again();
        orderf("flip out 1 %u %u", bit / 10, bit % 10, 0);
        uint64_t end = transact(read_goal, 5);
        model_goal();
        model[1 + bit] ^= true;
        assert_reply_is_model(end);
        TEST_ASSERT_TRUE(servos.node[0].driver.exempt);
        assert_ping_is_answered();
    }
}

void test_F2_any_two_bits_of_a_byte_can_be_flipped(void)
{
    for (unsigned byte = 0; byte < 8; byte++) {
        for (unsigned pair = 0; pair < 100; pair++) {
            if (pair / 10 >= pair % 10) {
                continue;
            }
            again();
            orderf("flip out 1 %u %u %u", byte, pair / 10, pair % 10);
            uint64_t end = transact(read_goal, 5);
            model_goal();
            model[1 + byte * 10 + pair / 10] ^= true;
            model[1 + byte * 10 + pair % 10] ^= true;
            assert_reply_is_model(end);
        }
    }
}

void test_F1_every_bit_of_an_instruction_packet_can_be_flipped(void)
{
    uint8_t packet[8];
    unsigned answers = 0;
    for (unsigned bit = 0; bit < 80; bit++) {
        again();
        unsigned size = build(packet, torque_on, 5);
        orderf("flip in 1 %u %u", bit / 10, bit % 10, 0);
        pass(100 * US);
        uint64_t start = schedule.now;
        uint64_t end = say_at(FAST, packet, size);
        unsigned instruction_edges = edge_count;
        pass(end - schedule.now);
        model_idle();
        model_and(1, packet, size);
        model[1 + bit] ^= true;
        edge_count = instruction_edges;
        assert_wire_is_model(start - BIT);
        pass(1000 * US);
        TEST_ASSERT_EQUAL_UINT8(0, servos.node[0].servo.registers[TABLE_TORQUE_ENABLE]);
        if (began) { // the servo has detected the wrong checksum
            TEST_ASSERT_EQUAL_HEX8(0x10, wire.heard[wire.count - 2].byte);
            TEST_ASSERT_TRUE(servos.node[0].driver.exempt);
            answers++;
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT(20, answers);
}

void test_bit_flipped_twice_is_unchanged(void)
{
    order("flip out 1 4 2");
    order("flip out 1 4 2");
    transact(ping, 3);
    assert_heard(&wire, pong, 6);
}

/* --- F3, F4: bytes lost and inserted --- */

void test_F3_every_byte_can_be_lost(void)
{
    for (unsigned byte = 0; byte < 8; byte++) {
        again();
        orderf("lose out 1 %u", byte, 0, 0);
        uint64_t end = transact(read_goal, 5);
        model_goal();
        memset(model + 1 + byte * 10, 1, 10);
        assert_reply_is_model(end);
        TEST_ASSERT_EQUAL_UINT(7, wire.count);
    }
}

void test_F3_instruction_packet_without_a_byte_is_ignored(void)
{
    for (unsigned byte = 0; byte < 6; byte++) {
        again();
        orderf("lose in 1 %u", byte, 0, 0);
        transact(ping, 3);
        TEST_ASSERT_EQUAL_UINT(0, wire.count);
        TEST_ASSERT_EQUAL_UINT64(0, began);
    }
}

void test_F4_any_byte_can_be_inserted_anywhere(void)
{
    static const uint8_t extra[] = {0x00, 0xFF, 0x55};
    for (unsigned i = 0; i < 27; i++) {
        unsigned at = i / 3;
        again();
        orderf("insert out 1 %u %u", at, extra[i % 3], 0);
        uint64_t end = transact(read_goal, 5);
        model_idle();
        model_and(1, goal, at);
        model_and(1 + at * 10, &extra[i % 3], 1);
        model_and(1 + at * 10 + 10, goal + at, 8 - at);
        assert_reply_is_model(end);
        TEST_ASSERT_EQUAL_UINT(9, wire.count);
        TEST_ASSERT_EQUAL_UINT64(end + 2 * US + 90 * BIT, ended);
    }
}

/* --- F5: echo --- */

/* The receive buffer is off while the controller sends. */
static void talk_with_buffer_shut(void)
{
    uint8_t packet[8];
    driver_enable(&rx_buffer, schedule.now, false);
    say_at(FAST, packet, build(packet, ping, 3));
}

void test_F5_echo_connects_the_receiver_to_the_wire(void)
{
    uint8_t both[12];
    memcpy(both + build(both, ping, 3), pong, 6);
    talk_with_buffer_shut();
    pass(1000 * US);
    TEST_ASSERT_EQUAL_UINT(0, receiver.count);
    assert_heard(&wire, both, 12);
    forget();
    order("echo on");
    talk_with_buffer_shut();
    pass(1000 * US);
    assert_heard(&receiver, both, 12);
    TEST_ASSERT_EQUAL_UINT64(wire.heard[0].start, receiver.heard[0].start);
    forget();
    order("echo off");
    talk_with_buffer_shut();
    pass(1000 * US);
    TEST_ASSERT_EQUAL_UINT(0, receiver.count);
}

/* --- F6: two servos with one ID --- */

static void put_twins(bool allowed)
{
    static const uint8_t twins[] = {7, 7};
    servos.duplicates = allowed;
    servos_replace(&servos, schedule.now, twins, 2);
    servos.node[1].servo.registers[TABLE_LED] = 1; // the two replies then differ
}

void test_F6_replies_of_same_id_are_anded_at_every_offset(void)
{
    static const uint8_t first[] = {0xFF, 0xFF, 7, 4, 0, 0, 0, 0xF4};
    static const uint8_t second[] = {0xFF, 0xFF, 7, 4, 0, 0, 1, 0xF3};
    for (unsigned offset = 0; offset <= 500; offset++) {
        again();
        put_twins(true);
        orderf("delay out 2 %u", offset, 0, 0);
        uint64_t end = say(read_led, 5);
        pass((2 + 81 + offset) * US);
        servos_power(&servos, schedule.now, false); // else they continue: see the next test
        pass(20 * US);
        model_idle();
        model_and(1, first, 8);
        model_and(1 + offset, second, 8);
        assert_reply_is_model(end);
        // at 80 one driver turns off in the cycle in which the other one turns on
        TEST_ASSERT_EQUAL_UINT64(offset <= 80 ? end + (2 + offset) * US : 0, collided);
        TEST_ASSERT_EQUAL_UINT64(end + 2 * US + (80 + offset) * BIT, ended);
    }
}

/* A reply that the other servo receives as a whole is a packet with its own ID and instruction 0.
 */
void test_F6_same_id_servos_reply_to_each_others_replies(void)
{
    static const uint8_t heard[] = {0xFF, 0xFF, 7,    2,    0,    0xF6, 0xFF, 0xFF, 7,
                                    2,    0,    0xF6, 0xFF, 0xFF, 7,    2,    0x40, 0xB6};
    put_twins(true);
    order("delay out 2 100");
    say(ping_7, 3);
    pass((2 + 160 + 2 + 60) * US);
    assert_heard(&wire, heard, 18);
}

void test_F6_turnaround_separates_servos_of_same_id(void)
{
    put_twins(true);
    order("turnaround 7 40");
    uint64_t end = transact(ping_7, 3);
    TEST_ASSERT_EQUAL_UINT64(end + 42 * US, wire.heard[0].start);
    TEST_ASSERT_EQUAL_UINT64(end + 82 * US, began);
    TEST_ASSERT_EQUAL_UINT64(end + 142 * US, ended);
    order("turnaround 7 0");
    transact(ping_7, 3);
    TEST_ASSERT_EQUAL_UINT(6, wire.count);
}

void test_F6_same_id_is_exempt_only_if_allowed(void)
{
    put_twins(false);
    transact(ping_7, 3);
    TEST_ASSERT_FALSE(servos.node[0].driver.exempt || servos.node[1].driver.exempt);
    put_twins(true);
    transact(ping_7, 3);
    TEST_ASSERT_TRUE(servos.node[0].driver.exempt && servos.node[1].driver.exempt);
    static const uint8_t other_id[] = {7, 4, 3, 3, 8};
    servos.node[1].servo.registers[TABLE_ID] = 9;
    transact(other_id, 5);
    TEST_ASSERT_FALSE(servos.node[0].driver.exempt);
}

/* --- F7, F8: a servo that dies --- */

void test_F7_a_servo_can_die_after_any_byte_of_its_reply(void)
{
    for (unsigned bytes = 0; bytes <= 8; bytes++) {
        again();
        transact(torque_on, 5);
        orderf("cut out 1 %u", bytes, 0, 0);
        uint64_t end = transact(read_goal, 5);
        assert_heard(&wire, goal, bytes);
        TEST_ASSERT_EQUAL_UINT64(bytes ? end + 2 * US + bytes * 10 * BIT : 0, ended);
        TEST_ASSERT_EQUAL_UINT8(0, servos.node[0].servo.registers[TABLE_TORQUE_ENABLE]);
        assert_ping_is_answered();
    }
}

void test_F7_power_can_stay_off_after_a_cut_reply(void)
{
    for (unsigned bytes = 0; bytes <= 8; bytes++) {
        again();
        orderf("cut out 1 %u 20", bytes, 0, 0);
        uint64_t end = transact(read_goal, 5);
        assert_heard(&wire, goal, bytes);
        uint64_t back = end + 2 * US + bytes * 10 * BIT + 20000 * US;
        schedule_run_until(&schedule, back - 1);
        TEST_ASSERT_FALSE(servos.node[0].servo.powered);
        pass(1);
        assert_ping_is_answered();
    }
}

void test_F7_without_a_cut_torque_stays_on(void)
{
    transact(torque_on, 5);
    transact(read_goal, 5);
    TEST_ASSERT_EQUAL_UINT8(1, servos.node[0].servo.registers[TABLE_TORQUE_ENABLE]);
}

void test_F8_a_brown_out_silences_and_resets_a_servo(void)
{
    transact(torque_on, 5);
    uint64_t end = say(read_goal, 5);
    pass(2 * US + 35 * BIT); // in the middle of its reply
    TEST_ASSERT_EQUAL_UINT(1, sig.enabled);
    order("brownout 1 20");
    TEST_ASSERT_EQUAL_UINT64(end + 2 * US + 35 * BIT, ended);
    TEST_ASSERT_TRUE(sig.level);
    for (unsigned ms = 2; ms < 20; ms += 2) {
        transact(ping, 3);
        TEST_ASSERT_EQUAL_UINT(0, wire.count);
    }
    schedule_run_until(&schedule, end + 2 * US + 35 * BIT + 20000 * US - 1);
    TEST_ASSERT_FALSE(servos.node[0].servo.powered);
    pass(1);
    TEST_ASSERT_TRUE(servos.node[0].servo.powered);
    TEST_ASSERT_EQUAL_UINT8(0, servos.node[0].servo.registers[TABLE_TORQUE_ENABLE]);
    assert_ping_is_answered();
}

void test_F8_servo_can_be_unplugged_as_any_byte_begins(void)
{
    for (unsigned byte = 0; byte < 7; byte++) {
        again();
        orderf("unplug in 2 %u 1,9 20", byte, 0, 0);
        transact(ping, 3);
        TEST_ASSERT_EQUAL_UINT(6, wire.count);
        wire.count = 0;
        uint64_t begins = schedule.now + 50 * US + byte * 10 * BIT;
        say(torque_on, 5);
        schedule_run_until(&schedule, begins + 20000 * US - 1);
        TEST_ASSERT_EQUAL_UINT(0, wire.count);
        TEST_ASSERT_FALSE(servos.node[0].servo.powered);
        pass(1);
        TEST_ASSERT_EQUAL_UINT8(0, servos.node[0].servo.registers[TABLE_TORQUE_ENABLE]);
        assert_ping_is_answered();
    }
}

void test_F8_power_that_is_switched_in_a_brown_out_ends_it(void)
{
    order("brownout 1 20");
    servo_node_power(&servos.node[0], schedule.now, false);
    pass(30000 * US);
    TEST_ASSERT_FALSE(servos.node[0].servo.powered);
    order("brownout 1 20");
    pass(30000 * US);
    TEST_ASSERT_FALSE(servos.node[0].servo.powered);
}

/* --- F9: babble --- */

void test_F9_a_babbler_never_stops(void)
{
    order("babble 0xA5");
    TEST_ASSERT_EQUAL_UINT(1, sig.enabled);
    TEST_ASSERT_EQUAL_UINT(1, sig.exempt);
    pass(1000 * 160);
    TEST_ASSERT_EQUAL_UINT(1000, wire.count);
    for (unsigned i = 0; i < 1000; i++) {
        TEST_ASSERT_EQUAL_HEX8(0xA5, wire.heard[i].byte);
        TEST_ASSERT_EQUAL_UINT64(i * 160, wire.heard[i].start);
    }
    pass(50);
    order("babble off"); // it completes its byte
    pass(1000 * 160);
    TEST_ASSERT_EQUAL_UINT(1001, wire.count);
    TEST_ASSERT_EQUAL_UINT(0, sig.enabled);
    TEST_ASSERT_EQUAL_UINT64(1001 * 160, ended);
    assert_ping_is_answered();
}

void test_F9_babble_of_headers_and_of_random_bytes(void)
{
    order("babble headers");
    pass(100 * 160);
    for (unsigned i = 0; i < 100; i++) {
        TEST_ASSERT_EQUAL_HEX8(0xFF, wire.heard[i].byte);
    }
    forget();
    order("babble random");
    pass(5000 * 160);
    bool seen[256] = {false};
    unsigned different = 0;
    for (unsigned i = 0; i < wire.count; i++) {
        different += !seen[wire.heard[i].byte];
        seen[wire.heard[i].byte] = true;
    }
    TEST_ASSERT_EQUAL_UINT(256, different);
}

void test_F9_babble_collides_with_all_at_the_rate_of_the_bus(void)
{
    static const uint32_t slow = 32 * 256;
    order("babble 0");
    say(ping, 3);
    pass(1000 * US);
    for (unsigned i = 0; i < wire.count; i++) {
        TEST_ASSERT_EQUAL_HEX8(0, wire.heard[i].byte & 0x7F);
    }
    order("babble off");
    pass(200);
    say_at(slow, pong, 6); // a status packet: servo 1 does nothing
    forget();
    order("babble 0x55");
    uint64_t start = schedule.now;
    pass(3200);
    TEST_ASSERT_EQUAL_UINT64(start + 32, edges[1].time);
}

/* --- F10: stuck line, noise --- */

void test_F10_a_line_stuck_low_is_one_framing_error_and_silence(void)
{
    pass(100);
    order("stuck low 5");
    pass(1);
    TEST_ASSERT_EQUAL_UINT64(100, edges[0].time);
    transact(ping, 3);
    TEST_ASSERT_FALSE(sig.level);
    pass(5000 * US - (schedule.now - 100) - 1);
    TEST_ASSERT_FALSE(sig.level);
    pass(1);
    TEST_ASSERT_TRUE(sig.level);
    TEST_ASSERT_EQUAL_UINT64(0, began);
    assert_ping_is_answered();
    again();
    order("stuck low");
    pass(100000 * US);
    TEST_ASSERT_EQUAL_UINT(1, wire.count);
    TEST_ASSERT_EQUAL_HEX8(0, wire.heard[0].byte);
    TEST_ASSERT_TRUE(wire.heard[0].framing_error);
    order("stuck off");
    assert_ping_is_answered();
}

void test_F10_a_new_order_ends_an_earlier_one(void)
{
    order("stuck low 5");
    order("stuck low");
    pass(6000 * US);
    TEST_ASSERT_FALSE(sig.level);
    order("stuck low 5");
    pass(1000 * US);
    order("stuck high 5");
    TEST_ASSERT_FALSE(sig.level); // at the end of this cycle
    pass(4500 * US);
    transact(ping, 3);
    TEST_ASSERT_EQUAL_UINT(0, wire.count);
    assert_ping_is_answered();
}

void test_F10_line_stuck_high_carries_no_bytes(void)
{
    uint64_t end = say(ping, 3);
    order("stuck high");
    pass(1000 * US);
    TEST_ASSERT_EQUAL_UINT(0, edge_count);
    TEST_ASSERT_EQUAL_UINT64(end + 2 * US, began); // the servo has replied
    TEST_ASSERT_TRUE(servos.node[0].driver.exempt);
    transact(ping, 3);
    TEST_ASSERT_EQUAL_UINT64(0, began); // it now receives nothing
    order("stuck off");
    assert_ping_is_answered();
}

/* Idle wire: each flip pulls the line low for one bit. */
void test_F10_noise_has_the_ordered_rate(void)
{
    order("noise 2000");
    pass(CLOCK);
    TEST_ASSERT_UINT_WITHIN(100, 4000, edge_count);
    for (unsigned i = 0; i + 1 < edge_count; i += 2) {
        TEST_ASSERT_FALSE(edges[i].level);
        TEST_ASSERT_EQUAL_UINT64(edges[i].time + BIT, edges[i + 1].time);
    }
    order("noise 0");
    forget();
    pass(CLOCK);
    TEST_ASSERT_EQUAL_UINT(0, edge_count);
}

/* A flip covers one bit of a byte: it sets a bit in 00 and clears one in FE. */
void test_F10_noise_flips_bits_either_way(void)
{
    static const char *babble[] = {"babble 0", "babble 0xFE"};
    for (unsigned i = 0; i < 2; i++) {
        again();
        order(babble[i]);
        order("noise 5000");
        pass(CLOCK / 20);
        unsigned flips[10] = {0}; // by number of changed bits in one byte
        for (unsigned b = 0; b < wire.count; b++) {
            unsigned wrong = wire.heard[b].byte ^ (i ? 0xFE : 0);
            flips[__builtin_popcount(wrong)]++;
        }
        TEST_ASSERT_GREATER_THAN_UINT(50, flips[1]);
        TEST_ASSERT_GREATER_THAN_UINT(flips[1] * 20, flips[0] * 20 + flips[1]);
    }
}

/* --- F12: another baud rate --- */

void test_F12_servo_at_another_rate_receives_no_packet(void)
{
    static const uint8_t registers[] = {0, 3, 7, 16, 34, 103, 254};
    for (unsigned i = 0; i < sizeof(registers); i++) {
        again();
        orderf("baud 1 %u", registers[i], 0, 0);
        for (unsigned n = 0; n < 20; n++) {
            transact(ping, 3);
            TEST_ASSERT_EQUAL_UINT(0, wire.count);
        }
        pass(CLOCK / 10); // longer than a byte
        uint32_t bit_time_256 = (registers[i] + 1u) * 8 * 256;
        uint8_t packet[8];
        wire.rx.bit_time_256 = bit_time_256;
        uint64_t end = say_at(bit_time_256, packet, build(packet, ping, 3));
        forget();
        pass(CLOCK / 10);
        assert_heard(&wire, pong, 6); // it replies at its own bit rate
        TEST_ASSERT_EQUAL_UINT64(end + 2 * US, began);
        TEST_ASSERT_TRUE(servos.node[0].driver.exempt);
    }
}

void test_F12_a_power_cycle_brings_the_saved_rate_back(void)
{
    order("baud 1 34");
    transact(ping, 3);
    TEST_ASSERT_EQUAL_UINT(0, wire.count);
    pass(CLOCK / 10);
    servos_power(&servos, schedule.now, true);
    assert_ping_is_answered();
}

/* What a UART of one bit rate receives from a sender of another rate, cycle by cycle. */
static unsigned hear(const bool *level, unsigned cycles, unsigned bit, struct uart_frame *out)
{
    unsigned count = 0;
    for (unsigned t = 1; t < cycles; t++) {
        if (!level[t - 1] || level[t] || t + bit / 2 >= cycles) {
            continue;
        }
        if (level[t + bit / 2]) { // not low in the middle: no start bit
            t += bit / 2;
            continue;
        }
        unsigned frame = 0;
        for (unsigned i = 0; i < 10; i++) {
            unsigned sample = t + i * bit + bit / 2;
            frame |= (unsigned)(sample >= cycles || level[sample]) << i;
        }
        out[count++] =
            (struct uart_frame){.byte = (uint8_t)(frame >> 1), .framing_error = !(frame >> 9)};
        t += 9 * bit + bit / 2 - 1;
    }
    return count;
}

/* All bytes, three in a row, between any two of the listed rates. */
void test_F12_bytes_at_another_rate_match_the_uart_model(void)
{
    static const unsigned registers[] = {1, 3, 7, 16, 34, 103};
    static bool level[40000];
    static struct uart_frame expected[400];
    for (unsigned pair = 0; pair < 36; pair++) {
        unsigned talk = (registers[pair / 6] + 1) * 8, rx = (registers[pair % 6] + 1) * 8;
        for (unsigned byte = 0; byte<256; byte += talk + rx> 400 ? 15 : 1) {
            uint8_t bytes[3] = {(uint8_t)byte, (uint8_t)(byte * 7 + 1), (uint8_t)~byte};
            again();
            pass(1);
            wire.rx.bit_time_256 = rx * 256;
            say_at(talk * 256, bytes, 3);
            pass(12 * rx);
            unsigned cycles = 1 + 30 * talk + 12 * rx;
            memset(level, 1, cycles);
            for (unsigned t = 0; t < 30 * talk; t++) {
                unsigned frame = 0x200u | bytes[t / talk / 10] * 2u;
                level[1 + t] = frame >> (t / talk % 10) & 1;
            }
            unsigned count = hear(level, cycles, rx, expected);
            TEST_ASSERT_EQUAL_UINT(count, wire.count);
            for (unsigned i = 0; i < count; i++) {
                TEST_ASSERT_EQUAL_HEX8(expected[i].byte, wire.heard[i].byte);
                TEST_ASSERT_EQUAL(expected[i].framing_error, wire.heard[i].framing_error);
            }
        }
    }
}

/* Computed by hand. A sample on an edge reads the level after the edge. */
void test_F12_bytes_at_half_and_at_twice_the_rate(void)
{
    static const struct {
        unsigned bit; // bit time of the receiver, cycles
        uint8_t byte, heard[2];
        bool wrong[2];
        unsigned count;
    } rows[] = {
        {32, 0xFF, {0}, {0}, 0},                   // low until the middle of a start bit only
        {32, 0x00, {0xF8}, {false}, 1},            // low for 144 cycles: samples at 16 to 112
        {8, 0x00, {0x00}, {true}, 1},              // low for longer than a frame
        {8, 0x01, {0x06}, {true}, 1},              // 00 11 000000
        {8, 0x55, {0x66, 0xE6}, {true, false}, 2}, // 00 11 00 11 00, then 00 11 00 1111
    };
    for (unsigned i = 0; i < sizeof(rows) / sizeof(rows[0]); i++) {
        again();
        wire.rx.bit_time_256 = rows[i].bit * 256;
        say_at(FAST, &rows[i].byte, 1);
        pass(1000);
        TEST_ASSERT_EQUAL_UINT(rows[i].count, wire.count);
        for (unsigned n = 0; n < wire.count; n++) {
            TEST_ASSERT_EQUAL_HEX8(rows[i].heard[n], wire.heard[n].byte);
            TEST_ASSERT_EQUAL(rows[i].wrong[n], wire.heard[n].framing_error);
        }
    }
}

static const char *as_text(const struct log *log)
{
    static char text[200];
    char *end = text;
    *end = 0;
    for (unsigned i = 0; i < log->count; i++) {
        end += sprintf(end, "%s%02X%s", i ? " " : "", log->heard[i].byte,
                       log->heard[i].framing_error ? "!" : "");
    }
    return text;
}

/* Computes the table of docs/internals/faults.md with another program. */
void test_F12_a_ping_at_other_rates(void)
{
    static const struct {
        unsigned reg;                   // of the slower or faster servo
        const char *heard, *heard_fast; // what it receives at 1 Mbit/s; what is received from it
    } rows[] = {
        {0, "FE FE 06! 18! 06! 9E", "84 EC"},
        {3, "84 EC", "FE FE 06! 18! 06! 9E"},
        {7, "80", "F8 F8 78! 80 00! 78! F8 F8"},
        {16, "FF", "80 80 80 00! 00! 00! 80 00! 80 80"},
        {34, "FE", "00! 00! 00! 00! 00! 00! 00! 00! 00! 00!"},
        {103, "FF", "00! 00! 00! 00! 00! 00! 00! 00! 00! 00!"},
    };
    uint8_t packet[8];
    unsigned size = build(packet, ping, 3);
    for (unsigned i = 0; i < sizeof(rows) / sizeof(rows[0]); i++) {
        uint32_t bit_time_256 = (rows[i].reg + 1) * 8 * 256;
        again();
        wire.rx.bit_time_256 = bit_time_256;
        servos_power(&servos, schedule.now, false);
        say_at(FAST, packet, size);
        pass(20000);
        TEST_ASSERT_EQUAL_STRING(rows[i].heard, as_text(&wire));
        forget();
        wire.rx.bit_time_256 = FAST;
        say_at(bit_time_256, packet, size);
        pass(20000);
        TEST_ASSERT_EQUAL_STRING(rows[i].heard_fast, as_text(&wire));
    }
}

/* --- F15, F16: late and wrong replies --- */

void test_F15_a_reply_can_be_late_to_the_microsecond(void)
{
    static const unsigned us[] = {0, 1, 610, 5000};
    for (unsigned i = 0; i < 4; i++) {
        again();
        orderf("delay out 1 %u", us[i], 0, 0);
        uint64_t end = say(ping, 3);
        pass(10000 * US);
        assert_heard(&wire, pong, 6);
        TEST_ASSERT_EQUAL_UINT64(end + (2 + us[i]) * US, began);
        TEST_ASSERT_TRUE(servos.node[0].driver.exempt);
        assert_ping_is_answered();
    }
}

void test_F15_turnaround_makes_every_reply_late(void)
{
    order("turnaround 1 300");
    for (unsigned i = 0; i < 3; i++) {
        uint64_t end = transact(ping, 3);
        assert_heard(&wire, pong, 6);
        TEST_ASSERT_EQUAL_UINT64(end + 302 * US, began);
        TEST_ASSERT_TRUE(servos.node[0].driver.exempt);
    }
    order("turnaround 1 0");
    assert_ping_is_answered();
}

void test_F15_a_reply_can_carry_any_id_with_a_right_checksum(void)
{
    for (unsigned id = 0; id < 256; id++) {
        again();
        orderf("id out 1 %u", id, 0, 0);
        transact(ping, 3);
        uint8_t expected[6];
        uint8_t body[] = {(uint8_t)id, 2, 0};
        build(expected, body, 3);
        assert_heard(&wire, expected, 6);
    }
}

void test_F16_a_reply_can_carry_any_length_with_a_right_checksum(void)
{
    for (unsigned length = 0; length < 256; length++) {
        again();
        orderf("length out 1 %u", length, 0, 0);
        transact(read_goal, 5);
        uint8_t expected[8];
        uint8_t body[] = {1, (uint8_t)length, 0, 0, 2};
        build(expected, body, 5);
        assert_heard(&wire, expected, 8);
    }
}

/* --- which packet --- */

static unsigned spoilt(void) // Sends a ping. Returns 1 if its reply has a flipped bit.
{
    transact(ping, 3);
    TEST_ASSERT_EQUAL_UINT(6, wire.count);
    return wire.heard[4].byte != 0;
}

void test_packets_count_from_the_order_on(void)
{
    spoilt();
    order("flip out 3 4 1");
    TEST_ASSERT_EQUAL_UINT(0, spoilt());
    TEST_ASSERT_EQUAL_UINT(0, spoilt());
    TEST_ASSERT_EQUAL_UINT(1, spoilt());
    TEST_ASSERT_EQUAL_UINT(0, spoilt());
    order("flip out every 4 8");
    TEST_ASSERT_EQUAL_UINT(1, spoilt());
    TEST_ASSERT_EQUAL_UINT(1, spoilt());
    order("clear");
    TEST_ASSERT_EQUAL_UINT(0, spoilt());
}

/* The reply of servo 1 gets the first number and is sent last. */
void test_an_order_waits_for_a_late_reply(void)
{
    static const uint8_t ids[] = {1, 7, 8};
    static const uint8_t ping_8[] = {8, 2, 1};
    servos_replace(&servos, schedule.now, ids, 3);
    order("delay out 1 5000");
    order("lose out 1 0");
    transact(ping, 3);
    transact(ping_7, 3);
    transact(ping_8, 3);
    TEST_ASSERT_EQUAL_UINT(6, wire.count);
    forget();
    pass(5000 * US);
    assert_heard(&wire, pong + 1, 5);
}

/* No gap, a longer header, and a packet that is cut and ends by silence. */
void test_controller_packet_ends_with_its_length_or_silence(void)
{
    static const uint8_t stream[] = {0xFF, 0xFF, 0xFE, 4, 3, 0x19, 1,    0xE0, //
                                     0xFF, 0xFF, 0xFF, 5, 2, 1,    0xF7,       //
                                     0xFF, 0xFF, 1,    9};
    order("lose in 1 7");
    order("lose in 2 6");
    order("lose in 3 3");
    order("lose in 4 0");
    say_at(FAST, stream, sizeof(stream));
    pass(31 * BIT);
    say_at(FAST, stream, 2);
    pass(200);
    static const uint8_t heard[] = {0xFF, 0xFF, 0xFE, 4,   3, 0x19, 1, //
                                    0xFF, 0xFF, 0xFF, 5,   2, 1,       //
                                    0xFF, 0xFF, 1,    0xFF};
    assert_heard(&wire, heard, sizeof(heard));
}

void test_report_counts_orders_without_effect(void)
{
    char text[200] = "";
    FILE *out = fmemopen(text, sizeof(text), "w");
    order("flip out 1 99 0");   // no such byte
    order("insert out 1 99 0"); // no such byte
    order("cut out 1 99");
    order("flip in 1 0 0");
    order("flip out 9 0 0"); // that packet has not come
    transact(ping, 3);
    pass(100);
    servos_power(&servos, schedule.now, true); // its start bit was lost, so no servo replied
    transact(ping, 3);
    transact(ping, 3);
    faults_report(&faults, "", out);
    fclose(out);
    TEST_ASSERT_EQUAL_STRING("faults:  acted 1 times; 4 of 5 orders came to nothing\n", text);
}

/* --- who is to blame --- */

/* LENGTH says 34: the servo takes the next packets as its rest and replies in the middle of a
 * packet. */
void test_servo_with_part_of_a_damaged_packet_is_exempt(void)
{
    static const uint8_t other[] = {9, 2, 1};
    uint8_t packet[8];
    unsigned size = build(packet, other, 3);
    order("flip in 1 3 6");
    transact(ping, 3);
    for (unsigned i = 0; i < 5; i++) {
        transact(other, 3);
        TEST_ASSERT_EQUAL_UINT64(0, began);
    }
    uint64_t start = schedule.now;
    say_at(FAST, packet, size); // 6 + 5 * 6 bytes, and two of this packet
    TEST_ASSERT_EQUAL_UINT64(start + 20 * BIT + 2 * US, began);
    TEST_ASSERT_TRUE(servos.node[0].driver.exempt);
    pass(1000 * US);
    transact(ping, 3);
    assert_ping_is_answered();
}

/* LENGTH says 10: the packet ends with the next packet, to which no servo replies. */
void test_reply_to_a_packet_of_another_servo_is_exempt(void)
{
    static const uint8_t all[] = {0xFE, 4, 3, 0x19, 1};
    order("flip in 1 3 4");
    transact(ping, 3);
    transact(all, 5);
    TEST_ASSERT_EQUAL_HEX8(0x10, wire.heard[4].byte);
    TEST_ASSERT_TRUE(servos.node[0].driver.exempt);
    assert_ping_is_answered();
}

/* A receiver may have taken the fault for a start bit. */
void test_fault_shortly_before_a_packet_exempts(void)
{
    for (unsigned gap = 159; gap <= 160; gap++) {
        pass(1000);
        order("stuck low 0");
        pass(gap);
        uint8_t packet[8];
        say_at(FAST, packet, build(packet, ping, 3));
        pass(1000 * US);
        TEST_ASSERT_EQUAL(gap == 159, servos.node[0].driver.exempt);
    }
}

void test_servo_that_waits_or_sends_during_a_fault_is_exempt(void)
{
    say(ping, 3);
    pass(1 * US); // its reply is due
    order("stuck high 0");
    TEST_ASSERT_TRUE(servos.node[0].driver.exempt);
    pass(1000 * US);
    say(ping, 3);
    pass(20 * US); // it sends
    TEST_ASSERT_EQUAL_UINT(1, sig.enabled);
    TEST_ASSERT_EQUAL_UINT(0, sig.exempt);
    order("stuck high 0");
    TEST_ASSERT_EQUAL_UINT(1, sig.exempt);
    pass(1000 * US);
    TEST_ASSERT_EQUAL_UINT(0, sig.exempt);
    assert_ping_is_answered();
}

void test_fault_of_one_servo_does_not_exempt_others(void)
{
    static const uint8_t ids[] = {1, 7};
    servos_replace(&servos, schedule.now, ids, 2);
    order("baud 7 34");
    order("turnaround 7 10");
    order("quirk 1 extra_turnaround_us 50");
    uint64_t end = transact(ping, 3);
    assert_heard(&wire, pong, 6);
    TEST_ASSERT_EQUAL_UINT64(end + 52 * US, began);
    TEST_ASSERT_FALSE(servos.node[0].driver.exempt);
}

/* --- orders --- */

void test_quirks_can_be_ordered(void)
{
    order("quirk 1 jitter_us 40");
    order("quirk 1 silent_after_power_up 1");
    order("quirk 1 sync_write_limit 1");
    const struct servo_quirks *quirks = &servos.node[0].servo.quirks;
    TEST_ASSERT_EQUAL_UINT(40, quirks->jitter_us);
    TEST_ASSERT_TRUE(quirks->silent_after_power_up);
    TEST_ASSERT_TRUE(quirks->sync_write_limit);
}

void test_bad_orders_are_refused_with_their_usage(void)
{
    static const char *const bad[] = {
        "",
        "fly",
        "flip",
        "flip in 1 0",
        "flip in 1 0 10",
        "flip in 0 0 1",
        "flip over 1 0 1",
        "flip in 1 0 1 2 3",
        "flip in 1 0 1 2 3 4 5 6 7 8 9",
        "flip in always 0 1",
        "lose in 1",
        "lose in 1 259",
        "lose in 1 -1",
        "insert in 1 0 0",
        "insert out 1 0 256",
        "cut in 1 3",
        "cut out 1 3 3600001",
        "unplug out 1 3 1 5",
        "unplug in 1 3 1",
        "unplug in 1 3 x 5",
        "delay out 1 10000001",
        "id out 1 256",
        "length out 1 x",
        "echo maybe",
        "babble",
        "babble 256",
        "babble off 1",
        "stuck",
        "stuck 1",
        "stuck low 3600001",
        "noise -1",
        "noise 1000001",
        "noise 5 5",
        "brownout 1",
        "brownout x 5",
        "brownout 254 5",
        "turnaround 1 x",
        "baud 1 255",
        "quirk 1 speed 5",
        "quirk 1 seed 65536",
        "clear all",
    };
    for (unsigned i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
        TEST_ASSERT_NOT_NULL_MESSAGE(faults_order(&faults, 0, bad[i]), bad[i]);
        TEST_ASSERT_NOT_NULL_MESSAGE(faults_check(bad[i]), bad[i]);
    }
    char longest[1300];
    memset(longest, ' ', sizeof(longest));
    longest[1299] = 0;
    TEST_ASSERT_NOT_NULL(faults_check(longest));
    TEST_ASSERT_EQUAL_STRING("echo on|off", faults_check("echo"));
    TEST_ASSERT_EQUAL_UINT(0, faults.orders);
}

void test_an_order_may_name_a_bus(void)
{
    TEST_ASSERT_EQUAL_UINT(2, fault_order_bus("2:echo on"));
    TEST_ASSERT_EQUAL_UINT(0, fault_order_bus("echo on"));
    TEST_ASSERT_NULL(faults_check("2:echo on"));
    TEST_ASSERT_NOT_NULL(faults_check("x:echo on"));
}

void test_orders_for_missing_servos_are_refused(void)
{
    TEST_ASSERT_EQUAL_STRING("no servo has that ID; a fault takes the IDs of this moment",
                             faults_order(&faults, 0, "baud 1,2 3"));
    faults.echo.net = 0;
    TEST_ASSERT_NOT_NULL(faults_order(&faults, 0, "echo on"));
    for (unsigned i = 0; i < 64; i++) {
        order("flip out 5 0 0");
    }
    TEST_ASSERT_NOT_NULL(faults_order(&faults, 0, "flip out 5 0 0"));
    order("clear");
    order("flip out 5 0 0");
}

/* --- one seed, one run --- */

/* FNV-1a over all edges of a run with all random faults. */
static uint64_t run_hash(uint32_t seed)
{
    static const uint8_t ids[] = {1, 7};
    tearDown();
    set_up(seed);
    servos_replace(&servos, 0, ids, 2);
    order("quirk 1,7 jitter_us 100");
    for (unsigned i = 0; i < 20; i++) {
        transact(ping, 3);
    }
    order("noise 3000");
    order("babble random");
    edge_count = 0;
    pass(CLOCK / 50);
    uint64_t hash = 0xCBF29CE484222325;
    for (unsigned i = 0; i < edge_count; i++) {
        hash = (hash ^ edges[i].time) * 0x100000001B3;
    }
    return hash;
}

void test_one_seed_gives_one_run(void)
{
    uint64_t first = run_hash(1);
    TEST_ASSERT_EQUAL_HEX64(first, run_hash(1));
    TEST_ASSERT_FALSE(first == run_hash(2));
    TEST_ASSERT_FALSE(first == run_hash(0));
}

void test_jitter_follows_the_seed_and_differs_for_same_id(void)
{
    put_twins(true);
    uint32_t twin = servos.node[1].servo.quirks.seed, first = servos.node[0].servo.quirks.seed;
    TEST_ASSERT_FALSE(twin == first);
    servos.seed = 5;
    put_twins(true);
    TEST_ASSERT_FALSE(first == servos.node[0].servo.quirks.seed);
}
