/* Goals, position and speed, of 50 servos at 250 Hz in one SYNC WRITE, and READs of 8 bytes, servo
 * after servo, in what is left of each period: by the calls of group.h and servo.h alone. For as
 * many seconds as the first byte of the EEPROM says; the second one is the return delay, register
 * 0x05.
 *
 * The library is called when a handler of the bus has done something, and when a period begins; PB0
 * is high while it runs. */
#include <cds55xx/group.h>

#include "bench.h"

#define SERVOS       50
#define BYTES        8
#define PERIOD_US    4000u
#define SECOND_US    1000000ul
#define READ_US      ((CDS_PACKET_SIZE(2) + CDS_PACKET_SIZE(BYTES)) * 10u)
#define SLACK_US     14                             // for our own work before and behind a READ
#define TICKS_PER_US ((uint16_t)(F_CPU / 8000000u)) // of the clock's timer

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t goals_packets[2][CDS_SYNC_WRITE_SIZE(SERVOS, 4)];
static struct cds_request goals[2] = {CDS_REQUEST(goals_packets[0]), CDS_REQUEST(goals_packets[1])};
static uint8_t read_packets[2][CDS_PACKET_SIZE(2)];
static struct cds_request requests[2] = {CDS_REQUEST(read_packets[0]),
                                         CDS_REQUEST(read_packets[1])};
static uint8_t feedback[SERVOS][BYTES];

static uint8_t front;    // packet that is sent next
static bool built;       // it is whole
static uint8_t turn;     // servo that is read next, by requests[turn & 1]
static bool reading;     // the one before it
static uint16_t read_us; // a READ takes
static uint32_t next_us; // a period begins
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

static void begin_period(uint32_t now_us)
{
    enum cds_result result;

    mark(MARK_WHOLE);
    result = cds_group_sync_send(&bus, &goals[front]);
    unmark(MARK_WHOLE);
    failed += result != CDS_OK;
    front ^= 1;
    built = false;
    periods++;
    next_us += PERIOD_US;
    while ((int32_t)(now_us - next_us) >= 0) {
        missed++;
        next_us += PERIOD_US;
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
    turn = (uint8_t)(turn + 1) % SERVOS;
}

/* What servo `index` has said; the bus is at work on the next. */
static void take(uint8_t index)
{
    for (uint8_t i = 0; i < BYTES; i++) {
        mark(MARK_WHOLE);
        failed += cds_request_byte(&requests[index & 1], i, &feedback[index][i]) != CDS_OK;
        unmark(MARK_WHOLE);
    }
    reads++;
}

static uint32_t now_us(void)
{
    uint32_t now;

    mark(MARK_WHOLE);
    now = cds_port_now_us();
    unmark(MARK_WHOLE);
    return now;
}

/* The bus is idle. */
static void go_on(void)
{
    bool ended = reading;
    uint8_t index = (uint8_t)((turn ? turn : SERVOS) - 1);
    uint32_t now = now_us();

    reading = false;
    if ((int32_t)(now - next_us) >= 0 && built) {
        begin_period(now);
    } else if (next_us - now >= read_us) {
        begin_read();
        reading = true;
    }
    if (ended)
        take(index);
}

/* Until a packet has left, a byte has come, or a period begins. */
static void wait(void)
{
    static uint8_t seen_state, seen_head;
    uint16_t begins = (uint16_t)((next_us + 1) * TICKS_PER_US);

    while (bus.link.state == seen_state && bus.link.rx.head == seen_head &&
           (bus.request || (int16_t)(TCNT1 - begins) < 0)) {
    }
    seen_state = bus.link.state;
    seen_head = bus.link.rx.head;
}

static void run(uint32_t until_us)
{
    bool busy = false;

    next_us = now_us() + PERIOD_US;
    until_us += next_us;
    for (;;) {
        if (!busy) {
            if ((int32_t)(next_us - until_us) >= 0)
                return;
            go_on();
        }
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
    read_us = (uint16_t)(READ_US + 2u * delay + SLACK_US);
    cds_servo_write_byte(&bus, &requests[0], CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1);
    bench_wait(&bus);
    run(SECOND_US * bench_option(0));
    bench_wait(&bus);
    say("periods", periods);
    say("missed", missed);
    say("reads", reads);
    say("failed", failed);
    say_end();
}
