/* Every call of cds_bus_poll() marked, in all that may happen in one: READs of all lengths, polled
 * at once and when the whole reply is there; a queue, whose next request begins in the poll that
 * ends one; timeouts and repeats; all of it counted; and the same again and again while the bench
 * damages replies, puts noise on the line and bytes FF before and behind replies. */
#include <cds55xx/sync_write.h>

#include "bench.h"

#define SERVOS  50
#define REPEATS 2
#define ABSENT  99
#define QUEUE   3
#define ROUNDS  16

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packets[QUEUE][CDS_PACKET_SIZE(CDS_REPLY_MAX)];
static uint8_t replies[QUEUE][CDS_REPLY_MAX];
static struct cds_request requests[QUEUE] = {CDS_REQUEST(packets[0], replies[0]),
                                             CDS_REQUEST(packets[1], replies[1]),
                                             CDS_REQUEST(packets[2], replies[2])};
static uint8_t goals_packet[CDS_SYNC_WRITE_SIZE(SERVOS, 4)];
static struct cds_request goals = CDS_REQUEST_WITHOUT_DATA(goals_packet);
static struct cds_stats counters; // asked for, so that all is counted
static uint32_t polls;

static bool poll(void)
{
    bool busy;

    mark(MARK_POLL);
    busy = cds_bus_poll(&bus);
    unmark(MARK_POLL);
    polls++;
    return busy;
}

/* `late`: so much later than the poll before, in us. */
static void run(uint16_t late_us)
{
    uint32_t from_us;

    do {
        from_us = cds_port_now_us();
        while (cds_port_now_us() - from_us < late_us) {
        }
    } while (poll());
}

/* Every seventh length, from the first on. */
static void reads(uint16_t late_us, uint8_t first)
{
    for (uint8_t length = first; length <= CDS_REPLY_MAX; length = (uint8_t)(length + 7)) {
        for (uint8_t i = 0; i < QUEUE; i++)
            cds_servo_read(&bus, &requests[i], (uint8_t)(i + 1), CDS_REG_RESERVED_00, length);
        run(late_us);
    }
}

static void goals_behind_a_read(uint16_t late_us)
{
    cds_servo_read(&bus, &requests[0], 1, CDS_REG_PRESENT_POSITION, 8);
    cds_sync_write_begin(&goals, CDS_REG_GOAL_POSITION, 4);
    for (uint8_t id = 1; id <= SERVOS; id++)
        cds_sync_write_add_goal(&goals, id, 512, 0);
    cds_sync_write_send(&bus, &goals);
    cds_servo_ping(&bus, &requests[1], ABSENT);
    run(late_us);
}

int main(void)
{
    static const uint16_t late_us[] = {0, 40, 1000};

    bench_open(&bus);
    cds_queue_attach(&bench_queue, &bus);
    cds_queue_set_retries(&bench_queue, REPEATS);
    for (uint8_t i = 0; i < ROUNDS; i++) {
        for (uint8_t j = 0; j < sizeof(late_us) / sizeof(late_us[0]); j++) {
            reads(late_us[j], (uint8_t)(i % 7 + 1));
            goals_behind_a_read(late_us[j]);
        }
    }
    cds_bus_stats(&bus, &counters);
    say("polls", polls);
    say("ok", counters.ok);
    say_end();
}
