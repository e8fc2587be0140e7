/* SPDX-License-Identifier: MIT */
/* A bus with random servos, line and main loop, compared with a model. Replies are late, damaged,
 * refused, from another servo or missing. Polls are 1 us to 40 ms apart. Requests wait, are
 * retried, cancelled, and submitted from on_end. The seed is fixed, so that two runs agree. */
#include "cds55xx/bus.h"

#include <string.h>

#include "cds55xx/queue.h"
#include "port_fake.h"
#include "unity.h"

#define PORT      1
#define JOBS      4
#define BYTE_US   10
#define LINE_SIZE 128
#define ANY       40   // most parameters of a reply of any length
#define WHOLE     0xFF // in place of the index of a damaged byte

#ifdef __AVR__
#define STEPS 500
#else
#define STEPS 20000
#endif

enum storm {
    SLOW_AND_TOLD,
    QUICK,
    SLOW_AND_NOT_TOLD,
    SLOWER_THAN_REGISTER_0X05, // register 0x05 allows 508 us
};

/* A request, and the reply to its latest attempt. */
struct job {
    bool was_sent; // since the submit
    struct cds_request request;
    uint8_t buffer[CDS_PACKET_SIZE(2)], reply[CDS_REPLY_ANY], packet[CDS_PACKET_SIZE(2)];
    uint8_t token, id, error, length;
    bool good; // whole, and no earlier byte can hide it
    uint32_t begun_us, good_us;
    uint16_t longest_gap_us;
};

struct arrival {
    uint32_t at_us;
    uint8_t byte, line_errors;
};

static struct cds_bus bus;
static struct cds_queue queue;
static struct job jobs[JOBS];
static struct arrival line[LINE_SIZE];
static uint8_t arrivals, arrived;
static struct job *talking; // the request whose packet is on the line
static bool stuck;          // that packet never ends
static enum storm storm;
static uint8_t tokens;
static uint16_t submitted, ended, ok, sent, unsent;
static uint32_t random_state;

static uint16_t random_below(uint16_t limit)
{
    random_state = random_state * 1103515245u + 12345u;
    return (uint16_t)((random_state >> 16) % limit);
}

static bool one_in(uint16_t count)
{
    return random_below(count) == 0;
}

/* Returns a parameter of the reply to the attempt with this token; never FF, as a header has. */
static uint8_t parameter(uint8_t token, uint8_t index)
{
    return (uint8_t)(token * 37u + index * 11u) & 0x7F;
}

static void arrive(uint32_t *at_us, uint8_t byte, uint8_t line_errors)
{
    *at_us += BYTE_US;
    TEST_ASSERT_TRUE(arrivals < LINE_SIZE);
    line[arrivals++] = (struct arrival){*at_us, byte, line_errors};
}

/* Schedules the bytes of a reply. The byte at index `harmed` has a flipped bit, is damaged or lost.
 */
static void arrive_reply(uint32_t *at_us, const struct job *job, uint8_t harmed)
{
    uint8_t bytes[CDS_PACKET_SIZE(CDS_REPLY_MAX + 1)] = {0xFF, 0xFF, job->id,
                                                         (uint8_t)(job->length + 2), job->error};
    uint8_t size = (uint8_t)(job->length + 6), sum = 0;

    for (uint8_t i = 0; i < job->length; i++)
        bytes[5 + i] = parameter(job->token, i);
    for (uint8_t i = 2; i < size - 1; i++)
        sum = (uint8_t)(sum + bytes[i]);
    bytes[size - 1] = (uint8_t)~sum;
    for (uint8_t i = 0; i < size; i++) {
        if (i != harmed)
            arrive(at_us, bytes[i], 0);
        else if (i >= CDS_AT_ERROR &&
                 one_in(2)) // a flipped bit in ID or LENGTH could make another good packet
            arrive(at_us, bytes[i] ^ 1, 0);
        else if (one_in(2))
            arrive(at_us, bytes[i], (uint8_t)(1 + random_below(3)));
    }
}

/* Schedules bytes before the reply. */
static void arrive_first(uint32_t *at_us, const struct job *job)
{
    struct job other = *job;

    other.token = (uint8_t)(job->token + 1);
    switch (random_below(5)) {
    case 0: arrive(at_us, 0, CDS_LINE_FRAMING); break;
    case 1:
        for (uint8_t i = 0; i < 5; i++)
            arrive(at_us, (uint8_t)(one_in(3) ? 0xFF : random_below(0x7F)), 0);
        break;
    case 2:
        other.error = CDS_ERROR_NONE_SUCH;
        arrive_reply(at_us, &other, WHOLE);
        break;
    case 3:
        other.id = 252;
        arrive_reply(at_us, &other, WHOLE);
        break;
    default:
        if (job->request.any_length)
            break;
        other.length = (uint8_t)(job->request.reply_parameters + 1);
        arrive_reply(at_us, &other, WHOLE);
        break;
    }
}

/* Returns the time from the packet to the reply. If the bus is set to 0 us, a stale reply can pass
 * for another reply only if it comes as late as allowed. */
static uint16_t return_delay_us(void)
{
    switch (storm) {
    case QUICK: return 0;
    case SLOW_AND_TOLD: return random_below(CDS_RETURN_DELAY_MAX_US);
    case SLOW_AND_NOT_TOLD:
        return (uint16_t)(CDS_RETURN_DELAY_MAX_US - random_below(one_in(3) ? 500 : 25));
    default: return random_below(CDS_STALE_REPLY_US);
    }
}

/* Schedules the reply of the servo. */
static void answer(struct job *job)
{
    const struct cds_request *request = &job->request;
    uint8_t id = job->packet[CDS_AT_ID], before = arrivals, harmed = WHOLE;
    uint32_t at_us = port_fake.now_us;

    job->token = ++tokens;
    job->id = (uint8_t)(id == CDS_BROADCAST_ID ? random_below(250) : id);
    job->error = (uint8_t)(one_in(5) ? CDS_ERROR_RANGE | CDS_ERROR_VOLTAGE : 0);
    job->length = (uint8_t)(request->any_length ? random_below(ANY) : request->reply_parameters);
    if (job->error && one_in(2))
        job->length = 0;
    at_us += return_delay_us();
    if (arrived != arrivals && (int32_t)(line[arrivals - 1].at_us - at_us) > 0)
        return; // the bus was opened again, and an earlier reply still arrives
    if (id != CDS_BROADCAST_ID && job->length < 9 && one_in(3))
        arrive_first(&at_us, job);
    if (one_in(5))
        harmed = (uint8_t)random_below((uint16_t)(job->length + 6));
    arrive_reply(&at_us, job, harmed);
    job->good = harmed == WHOLE;
    if (arrivals - before > job->length + 6 && job->length != request->reply_parameters)
        job->good = false; // bytes before it may have begun a longer packet
    job->good_us = at_us;
}

/* The packet is sent: checks that it is the submitted packet, in a retry too. */
static void leave(struct job *job)
{
    uint16_t size = job->request.packet.size;

    TEST_ASSERT_TRUE(port_fake_transmit(&bus.link, PORT));
    TEST_ASSERT_EQUAL_UINT16(size, port_fake.sent_size);
    TEST_ASSERT_EQUAL_UINT8_ARRAY(job->packet, port_fake.sent, size);
    if (job->request.reply_parameters != CDS_REPLY_NONE && !one_in(6))
        answer(job);
}

static struct job *job_of(struct cds_request *request)
{
    return request->context;
}

/* Call it after each call that can begin or abort a packet. */
static void look(void)
{
    bool talks = port_fake.lines[PORT] == FAKE_TALK;

    if (talks && !talking) {
        talking = job_of(bus.request);
        talking->begun_us = port_fake.now_us;
        talking->good = false;
        talking->was_sent = true;
        talking->longest_gap_us = 0;
        stuck = one_in(30);
        sent++;
    } else if (!talks) {
        talking = NULL;
    }
}

static void pass(uint16_t us)
{
    uint32_t until_us = port_fake.now_us + us;

    if (talking && !stuck) {
        uint32_t leaves_us = talking->begun_us + (uint32_t)talking->request.packet.size * BYTE_US;

        if ((int32_t)(leaves_us - until_us) <= 0) {
            port_fake.now_us = leaves_us;
            leave(talking);
            talking = NULL;
        }
    }
    for (; arrived != arrivals && (int32_t)(line[arrived].at_us - until_us) <= 0; arrived++)
        if (port_fake.lines[PORT] == FAKE_LISTEN)
            cds_link_on_rx(&bus.link, line[arrived].byte, line[arrived].line_errors);
    if (arrived == arrivals)
        arrived = arrivals = 0;
    port_fake.now_us = until_us;
    if (port_fake_is_in_flight(&bus) && job_of(bus.request)->longest_gap_us < us)
        job_of(bus.request)->longest_gap_us = us;
}

static uint32_t deadline_us(const struct job *job)
{
    const struct cds_request *request = &job->request;
    uint32_t us = job->begun_us + (uint32_t)request->packet.size * BYTE_US + CDS_REPLY_MARGIN_US;

    if (request->reply_parameters == CDS_REPLY_NONE)
        return us;
    return us + CDS_PACKET_SIZE(request->reply_parameters) * BYTE_US + request->return_delay_us;
}

static void check_value(const struct job *job)
{
    const struct cds_request *request = &job->request;

    TEST_ASSERT_EQUAL_UINT8(job->id, request->id);
    TEST_ASSERT_EQUAL_HEX8(job->error, request->error);
    TEST_ASSERT_EQUAL_UINT8(job->length, request->length);
    for (uint8_t i = 0; i < job->length; i++)
        TEST_ASSERT_EQUAL_HEX8(parameter(job->token, i), request->reply[i]);
}

static void check_failure(const struct job *job)
{
    uint32_t late_us = port_fake.now_us - deadline_us(job);

    TEST_ASSERT_TRUE(job->request.result == CDS_TIMEOUT || job->request.result == CDS_CORRUPT);
    TEST_ASSERT_FALSE(job->good && (int32_t)(job->good_us - deadline_us(job)) <= 0);
    TEST_ASSERT_TRUE((int32_t)late_us >= 0);
    if (job->longest_gap_us < 100) // a reply takes up to 12 polls to find and take
        TEST_ASSERT_TRUE(late_us <= 13u * job->longest_gap_us);
}

static void submit(struct job *job);

static void on_end(struct cds_request *request)
{
    struct job *job = job_of(request);

    ended++;
    if (request->result == CDS_OK) {
        ok++;
        if (request->reply_parameters != CDS_REPLY_NONE)
            check_value(job);
    } else if (bus.stats.line_busy != unsent) { // the packet was not sent
        unsent++;
        TEST_ASSERT_EQUAL(job->was_sent ? CDS_TIMEOUT : CDS_LINE_BUSY, request->result);
    } else {
        check_failure(job);
    }
    look(); // the next packet may have begun
    if (one_in(2))
        submit(&jobs[random_below(JOBS)]);
}

static void build(struct cds_request *request)
{
    static const uint8_t nothing = 0;
    struct cds_packet *packet = &request->packet;
    uint8_t id = (uint8_t)(4 + random_below(3));
    uint8_t length = (uint8_t)(1 + random_below(one_in(3) ? CDS_REPLY_MAX : 10));

    request->reply_parameters = 0;
    request->any_length = false;
    if (storm == SLOW_AND_NOT_TOLD)
        length = 2; // the length of a stale reply
    switch (random_below(8)) {
    case 0: cds_packet_ping(packet, one_in(2) ? CDS_BROADCAST_ID : id); break;
    case 1: cds_packet_write(packet, id, 0x19, &nothing, 1); break; // as READ of 0
    case 2:
        cds_packet_action(packet, CDS_BROADCAST_ID);
        request->reply_parameters = CDS_REPLY_NONE;
        break;
    case 3:
        cds_packet_read(packet, id, 0, ANY);
        request->reply_parameters = ANY;
        request->any_length = true;
        break;
    default:
        cds_packet_read(packet, id, (uint8_t)(CDS_REPLY_MAX - length), length);
        request->reply_parameters = length;
        break;
    }
}

static void submit(struct job *job)
{
    struct cds_request *request = &job->request;

    if (request->result == CDS_PENDING)
        return;
    build(request);
    memcpy(job->packet, job->buffer, request->packet.size);
    cds_queue_set_retries(&queue, (uint8_t)random_below(3));
    request->priority = (uint8_t)random_below(3);
    job->was_sent = false;
    TEST_ASSERT_EQUAL(CDS_OK, cds_bus_submit(&bus, request));
    submitted++;
    look();
}

static void open_again(void)
{
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    talking = NULL;
    submitted = ended = ok = sent = unsent = 0;
}

static void meddle(void)
{
    struct job *job = &jobs[random_below(JOBS)];

    port_fake.low = one_in(30);
    if (one_in(3))
        submit(job);
    else if (one_in(20) && cds_bus_cancel(&bus, &job->request) == CDS_OK)
        ended++;
    if (one_in(500))
        open_again();
    if (storm == QUICK && one_in(20))
        cds_bus_set_return_delay(&bus, one_in(2) ? CDS_RETURN_DELAY_MAX_US : 0);
    else if (storm == SLOW_AND_NOT_TOLD)
        cds_bus_set_return_delay(&bus, 0);
    else if (storm == SLOWER_THAN_REGISTER_0X05 && one_in(20))
        cds_bus_set_return_delay(&bus, one_in(2) ? CDS_RETURN_DELAY_MAX_US : 20);
    look();
}

static uint16_t next_gap_us(void)
{
    if (storm == SLOW_AND_NOT_TOLD && !one_in(50))
        return (uint16_t)(1 + random_below(8));
    if (one_in(100))
        return (uint16_t)(1000 * (1 + random_below(40)));
    return (uint16_t)(1 + random_below(one_in(10) ? 500 : 40));
}

static void poll(void)
{
    cds_bus_poll(&bus);
    look();
}

/* Lets all requests end, then checks the stats. */
static void come_to_rest(void)
{
    struct cds_stats count;

    port_fake.low = false;
    for (uint16_t i = 0; bus.request; i++) {
        TEST_ASSERT_TRUE(i < 5000);
        pass(20);
        poll();
    }
    cds_bus_stats(&bus, &count);
    TEST_ASSERT_EQUAL_UINT16(submitted, ended);
    TEST_ASSERT_EQUAL_UINT16(sent, count.sent);
    TEST_ASSERT_EQUAL_UINT16(ok, count.ok);
    TEST_ASSERT_EQUAL_UINT16(unsent, count.line_busy);
    TEST_ASSERT_EQUAL_UINT16(count.sent, (uint16_t)(count.ok + count.timeouts + count.corrupt));
    TEST_ASSERT_EQUAL_UINT16(0, port_fake.breaches);
}

static void rage(enum storm which, uint32_t seed)
{
    storm = which;
    random_state = seed;
    for (uint16_t i = 0; i < STEPS; i++) {
        meddle();
        pass(next_gap_us());
        poll();
        if (i % 128 == 127)
            come_to_rest();
    }
    come_to_rest();
}

void setUp(void)
{
    port_fake_reset();
    memset(&bus, 0, sizeof bus);
    memset(jobs, 0, sizeof jobs);
    arrivals = arrived = 0;
    for (uint8_t i = 0; i < JOBS; i++) {
        struct cds_request *request = &jobs[i].request;

        request->packet.bytes = jobs[i].buffer;
        request->packet.capacity = sizeof jobs[i].buffer;
        request->reply = jobs[i].reply;
        request->reply_capacity = sizeof jobs[i].reply;
        request->on_end = on_end;
        request->context = &jobs[i];
    }
    cds_bus_open(&bus, PORT, CDS_BAUD_1M);
    TEST_ASSERT_EQUAL(CDS_OK, cds_queue_attach(&queue, &bus));
    open_again();
}

void tearDown(void)
{
}

void test_servos_as_slow_as_the_bus_was_told(void)
{
    rage(SLOW_AND_TOLD, 1);
}

void test_quick_servos_and_a_bus_told_now_this_now_that(void)
{
    rage(QUICK, 2);
}

void test_storm_of_servos_slower_than_told_gives_no_stale_value(void)
{
    for (uint8_t i = 0; i < 10; i++)
        rage(SLOW_AND_NOT_TOLD, 3u + i);
}

void test_storm_of_servos_up_to_2_ms_late_gives_no_stale_value(void)
{
    rage(SLOWER_THAN_REGISTER_0X05, 4);
}
