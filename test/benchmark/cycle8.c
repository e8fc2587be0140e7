/* SPDX-License-Identifier: MIT */
/* A cycle by sync_write.h and servo.h alone: at 250 Hz one SYNC WRITE of position and speed to 50
 * servos. READs of 8 bytes, servo after servo, fill the remaining time of each period. EEPROM: byte
 * 0 is the number of seconds, byte 1 the return delay (register 0x05).
 *
 * One packet is on the wire, and the next waits behind it in the bus's queue. The program looks at
 * the link to call the library only when something is there: polled without end, the bus would have
 * the same share, and idle polls the remaining CPU time. PB0 is high while the library runs. */
#include <cds55xx/sync_write.h>

#include <string.h>

#include "benchmark.h"

#define SERVOS       50
#define BYTES        8
#define PERIODS      250                            // in a second
#define TICKS_PER_US ((uint16_t)(F_CPU / 8000000u)) // of the clock's timer
#define PERIOD_TICKS (4000u * TICKS_PER_US)
#define REPLY        CDS_PACKET_SIZE(BYTES)
#define READ_US      ((CDS_PACKET_SIZE(2) + REPLY) * 10u)
#define GAP_TICKS    (6u * TICKS_PER_US) // a READ takes so much longer, for our own work
#define HEAD         6                   // bytes of a reply: by then it is known to be one
#define FEW          2                   // more of them, taken while as many come

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t goals_packets[2][CDS_SYNC_WRITE_SIZE(SERVOS, 4)];
static struct cds_request goals[2] = {CDS_REQUEST_WITHOUT_DATA(goals_packets[0]),
                                      CDS_REQUEST_WITHOUT_DATA(goals_packets[1])};
static uint8_t read_packets[2][CDS_PACKET_SIZE(2)];
static uint8_t replies[2][BYTES];
static struct cds_request requests[2] = {CDS_REQUEST(read_packets[0], replies[0]),
                                         CDS_REQUEST(read_packets[1], replies[1])};
static uint8_t feedback[SERVOS][BYTES];

static uint8_t front;                              // goals that are sent next
static uint8_t id = 1;                             // servo that is asked next
static uint8_t asked;                              // how many READs are under way: 0 to 2,
static struct cds_request *on_wire = &requests[0]; // the first of them,
static const struct cds_request *last;             // of the period before, still to be taken,
static uint8_t *values = feedback[0];              // and where values go
static int16_t read_ticks;                         // a READ takes
static uint16_t begins;                            // a period, by the timer
static uint32_t periods, missed, reads, failed;

/* Puts the goals of the next period into the packet that is not on the wire. */
static void build(void)
{
    struct cds_request *to = &goals[front];

    mark(MARK_WHOLE);
    cds_sync_write_begin(to, CDS_REG_GOAL_POSITION, 4);
    unmark(MARK_WHOLE);
    for (uint8_t i = 0; i < SERVOS; i++) {
        uint16_t position = (4u * (uint16_t)periods + 20u * i) & 0x3FF;

        if (position & 0x200)
            position = 0x3FF - position;
        mark(MARK_WHOLE);
        cds_sync_write_add_goal(to, (uint8_t)(i + 1), 256 + position, 300);
        unmark(MARK_WHOLE);
    }
}

static struct cds_request *other(const struct cds_request *request)
{
    return request == &requests[0] ? &requests[1] : &requests[0];
}

/* Submits one more READ, behind the request on the wire. */
static void ask(void)
{
    enum cds_result result;

    mark(MARK_WHOLE);
    result =
        cds_servo_read(&bus, asked ? other(on_wire) : on_wire, id, CDS_REG_PRESENT_POSITION, BYTES);
    unmark(MARK_WHOLE);
    failed += result != CDS_OK;
    id = id == SERVOS ? 1 : (uint8_t)(id + 1);
    asked++;
}

/* Returns the time until the next period, in ticks. */
static int16_t left(void)
{
    return (int16_t)(begins - TCNT1);
}

/* Submits the goals, and a READ behind them. */
static void begin_period(void)
{
    enum cds_result result;

    mark(MARK_WHOLE);
    result = cds_sync_write_send(&bus, &goals[front]);
    unmark(MARK_WHOLE);
    failed += result != CDS_OK;
    front ^= 1;
    periods++;
    begins += PERIOD_TICKS;
    while (left() <= 0) {
        missed++;
        begins += PERIOD_TICKS;
    }
    ask();
}

/* Takes the reply of `request`, while the bus works on the next request. */
static void take(const struct cds_request *request)
{
    memcpy(values, request->reply, BYTES);
    if (request->result != CDS_OK || request->length != BYTES)
        failed++;
    reads++;
    values += BYTES;
    if (values == feedback[SERVOS])
        values = feedback[0];
}

/* Waits until a packet has left or `due` bytes of a reply have arrived, for a limited time. */
static void wait(uint8_t due)
{
    uint8_t spins = 0;

    while (bus.link.state != CDS_LINK_LISTENING) {
    }
    while ((int8_t)(bus.link.rx.head - due) < 0 && --spins) {
    }
}

static void poll(void)
{
    mark(MARK_WHOLE);
    cds_bus_poll(&bus);
    unmark(MARK_WHOLE);
}

/* Polls only when the link has work: when a packet has begun, when it has left and `bytes` of the
 * reply have arrived, and every few bytes after that. */
static void see_through(const struct cds_request *request, uint8_t bytes)
{
    uint8_t due = (uint8_t)(bus.link.rx.head + bytes);

    poll();
    while (request->result == CDS_PENDING) {
        wait(due);
        poll();
        due = (uint8_t)(due + FEW);
    }
}

/* Submits READs, one on the wire and one behind it, while they end before the next period. */
static void read_on(void)
{
    int16_t time = left(); // the first has just begun

    while (asked) {
        const struct cds_request *request = on_wire;

        if (time >= 2 * read_ticks)
            ask();
        see_through(request, HEAD);
        time = left();
        on_wire = other(on_wire);
        if (--asked)
            take(request);
        else
            last = request; // once the goals are on their way
    }
}

static void run(uint32_t until)
{
    build();
    begins = TCNT1 + PERIOD_TICKS;
    while (periods + missed < until) {
        while (left() > 0) {
        }
        begin_period();
        if (last)
            take(last);
        build();
        see_through(&goals[front ^ 1], 0);
        read_on();
    }
}

int main(void)
{
    uint8_t delay = bench_option(1);

    bench_open(&bus);
    cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID, CDS_REG_RETURN_DELAY, delay);
    bench_wait(&bus);
    cds_bus_set_return_delay(&bus, (uint16_t)(2 * delay));
    read_ticks = (int16_t)((READ_US + 2u * delay) * TICKS_PER_US + GAP_TICKS);
    cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1);
    bench_wait(&bus);
    run((uint32_t)PERIODS * bench_option(0));
    take(last);
    say("periods", periods);
    say("missed", missed);
    say("reads", reads);
    say("failed", failed);
    say_end();
}
