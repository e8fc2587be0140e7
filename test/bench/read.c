/* READs of 2 bytes from servo 1 at the return delays 2, 4, ... 32 us, and then what submitting one
 * costs, on an idle bus and behind another one. Last PINGs, with the main loop at ever other phases
 * when the last stop bit ends. All of it before the clock's first overflow: no other handler runs.
 */
#include "bench.h"

#define DELAYS 16
#define PINGS  64

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_PACKET_SIZE(2)], other_packet[CDS_PACKET_SIZE(2)];
static uint8_t other_packet_reply[2];
static uint8_t packet_reply[2];
static struct cds_request request = CDS_REQUEST(packet, packet_reply),
                          other = CDS_REQUEST(other_packet, other_packet_reply);
static volatile uint8_t servo = 1, address = CDS_REG_PRESENT_POSITION, length = 2;
static uint8_t good;

static void set_return_delay(uint8_t n)
{
    cds_servo_write_byte(&bus, &request, servo, CDS_REG_RETURN_DELAY, n);
    bench_wait(&bus);
    cds_bus_set_return_delay(&bus, (uint16_t)(2 * n));
}

BENCH_NOINLINE static void read(uint8_t id, uint8_t from, uint8_t count)
{
    mark(MARK_WHOLE);
    cds_servo_read(&bus, &request, id, from, count);
    while (cds_bus_poll(&bus)) {
    }
    unmark(MARK_WHOLE);
}

BENCH_NOINLINE static void submit(struct cds_request *which, uint8_t id, uint8_t from,
                                  uint8_t count)
{
    mark(MARK_CALL);
    cds_servo_read(&bus, which, id, from, count);
    unmark(MARK_CALL);
}

static void count_good(const struct cds_request *which)
{
    uint16_t position;

    if (cds_request_word(which, 0, &position) == CDS_OK && position == 512)
        good++;
}

/* 4 cycles a turn, and one more for an odd number of them. */
static void idle(uint8_t turns)
{
    if (turns & 1)
        __asm__ volatile("nop");
    if (turns & 2)
        __asm__ volatile("nop\n\tnop");
    for (turns >>= 2; turns; turns--)
        __asm__ volatile("nop");
}

int main(void)
{
    bench_open(&bus);
    for (uint8_t n = 1; n <= DELAYS; n++) {
        set_return_delay(n);
        read(servo, address, length);
        count_good(&request);
    }
    set_return_delay(1);
    cds_queue_attach(&bench_queue, &bus);
    for (uint8_t i = 0; i < 4; i++) {
        submit(&request, servo, address, length);
        idle(i);
        submit(&other, servo, address, length);
        bench_wait(&bus);
        count_good(&request);
        count_good(&other);
    }
    for (uint8_t i = 0; i < PINGS; i++) {
        cds_servo_ping(&bus, &request, servo);
        idle(i);
        bench_wait(&bus);
        if (request.result == CDS_OK)
            good++;
    }
    say("us", cds_port_now_us());
    say("good", good);
    say_end();
}
