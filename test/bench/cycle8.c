/* Goals, position and speed, of 50 servos at 250 Hz in one SYNC WRITE, and READs of 8 bytes, servo
 * after servo, in what is left of each period: by the calls of group.h and servo.h alone. For as
 * many seconds as the first byte of the EEPROM says; the second one is the return delay, register
 * 0x05.
 *
 * The library is called when a packet has left, when most of a reply has come, when the rest has,
 * and when a period begins; PB0 is high while it runs. */
#include <cds55xx/group.h>

#include <string.h>

#include "bench.h"

#define SERVOS       50
#define BYTES        8
#define PERIODS      250                            // in a second
#define TICKS_PER_US ((uint16_t)(F_CPU / 8000000u)) // of the clock's timer
#define PERIOD_TICKS (4000u * TICKS_PER_US)
#define REPLY        CDS_PACKET_SIZE(BYTES)
#define READ_US      ((CDS_PACKET_SIZE(2) + REPLY) * 10u)
#define SLACK_US     14 // for our own work before and behind a READ
#define MOST         9  // bytes of a reply: taken while the next three come

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t goals_packets[2][CDS_SYNC_WRITE_SIZE(SERVOS, 4)];
static struct cds_request goals[2] = {CDS_REQUEST(goals_packets[0]), CDS_REQUEST(goals_packets[1])};
static uint8_t read_packets[2][CDS_PACKET_SIZE(2)];
static struct cds_request requests[2] = {CDS_REQUEST(read_packets[0]),
                                         CDS_REQUEST(read_packets[1])};
static uint8_t feedback[SERVOS][BYTES];

static uint8_t front;       // packet that is sent next
static bool built;          // it is whole
static uint8_t turn;        // servo that is read next, by requests[turn & 1]
static bool reading;        // the one before it
static uint16_t read_ticks; // a READ takes
static uint16_t begins;     // a period, by the timer
static uint8_t due, step;   // library's turn: head of the ring when it is, then so much further on
static uint32_t periods, missed, reads, failed;

/* Goals of the next period into the packet that is not on the wire. */
static void build(void)
{
    struct cds_request *to = &goals[front];

    mark(MARK_WHOLE);
    cds_group_sync_begin(to, CDS_REG_GOAL_POSITION, 4);
    unmark(MARK_WHOLE);
    for (uint8_t i = 0; i < SERVOS; i++) {
        uint16_t position = (4u * (uint16_t)periods + 20u * i) & 0x3FF;

        if (position & 0x200)
            position = 0x3FF - position;
        mark(MARK_WHOLE);
        cds_group_sync_add_goal(to, (uint8_t)(i + 1), 256 + position, 300);
        unmark(MARK_WHOLE);
    }
    built = true;
}

static void begin_period(uint16_t now)
{
    enum cds_result result;

    mark(MARK_WHOLE);
    result = cds_group_sync_send(&bus, &goals[front]);
    unmark(MARK_WHOLE);
    failed += result != CDS_OK;
    front ^= 1;
    built = false;
    periods++;
    begins += PERIOD_TICKS;
    while ((int16_t)(now - begins) >= 0) {
        missed++;
        begins += PERIOD_TICKS;
    }
}

static void begin_read(void)
{
    enum cds_result result;

    mark(MARK_WHOLE);
    result = cds_servo_read(&bus, &requests[turn & 1], (uint8_t)(turn + 1),
                            CDS_REG_PRESENT_POSITION, BYTES);
    unmark(MARK_WHOLE);
    failed += result != CDS_OK;
    due = (uint8_t)(bus.link.rx.head + MOST);
    step = 3;
    reading = true;
    turn++;
    if (turn == SERVOS)
        turn = 0;
}

/* What servo `index` has said; the bus is at work on the next. */
static void take(uint8_t index)
{
    const struct cds_request *request = &requests[index & 1];

    failed += request->result != CDS_OK || request->length != BYTES;
    memcpy(feedback[index], request->packet.bytes, BYTES);
    reads++;
}

/* The bus is idle. */
static void go_on(void)
{
    bool ended = reading;
    uint8_t index = (uint8_t)((turn ? turn : SERVOS) - 1);
    uint16_t now = TCNT1;

    reading = false;
    if ((int16_t)(begins - now) >= (int16_t)read_ticks)
        begin_read();
    else if ((int16_t)(now - begins) >= 0 && built)
        begin_period(now);
    if (ended)
        take(index);
}

static bool is_time(void)
{
    return (int16_t)(TCNT1 - begins) >= 0;
}

/* Until a packet has left, `due` bytes of a reply have come, or a period begins. */
static void wait(void)
{
    if (bus.link.state != CDS_LINK_LISTENING) {
        while (bus.link.state != CDS_LINK_LISTENING) {
        }
        return;
    }
    while (!reading || (int8_t)(bus.link.rx.head - due) < 0)
        if (is_time())
            return;
    due = (uint8_t)(due + step);
    step = 1;
}

static void run(uint32_t until)
{
    bool busy = false;

    begins = TCNT1 + PERIOD_TICKS;
    while (busy || periods + missed < until) {
        if (!busy)
            go_on();
        if (!built)
            build();
        wait();
        mark(MARK_WHOLE);
        busy = cds_bus_poll(&bus);
        unmark(MARK_WHOLE);
    }
}

int main(void)
{
    uint8_t delay = bench_option(1);

    bench_open(&bus);
    cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID, CDS_REG_RETURN_DELAY, delay);
    bench_wait(&bus);
    cds_bus_set_return_delay(&bus, (uint16_t)(2 * delay));
    read_ticks = (uint16_t)((READ_US + 2u * delay + SLACK_US) * TICKS_PER_US);
    cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1);
    bench_wait(&bus);
    run((uint32_t)PERIODS * bench_option(0));
    bench_wait(&bus);
    say("periods", periods);
    say("missed", missed);
    say("reads", reads);
    say("failed", failed);
    say_end();
}
