/* SPDX-License-Identifier: MIT */
/* Constructs the longest turnaround. At the end of a packet's last stop bit, interrupts have just
 * been turned off: by the tail of a handler of the host link, by a prologue that moves the stack
 * pointer, or by a write to the EEPROM. Then the overflow of the clock and a handler of the host
 * link run, because their vectors come before that of "transmit complete". The simulated host sends
 * at 1 Mbps without a gap: a byte every 160 cycles. Each packet is an ACTION by broadcast, which no
 * servo answers. The handlers are those of the firmware.
 *
 * The options (bench_option()) select what the program does and the moments of the four events.
 * scripts/measure.py sweeps them, then searches around the longest turnarounds. */
#include "avr/eeprom_driver.c"
#include "avr/serial.c"
#include "cds55xx/avr/timer.h"

#include "benchmark.h"

#define HOST_1M      1   // divisor of the host link
#define HOST_BYTE    160 // cycles from one byte of the host to the next
#define TICK         8   // cycles
#define TICKS_LEFT   33  // about; from the last byte in the buffer to the end of the packet
#define SENT         14  // bytes to the host, from before the packet until after its end
#define NOTHING_SENT UINT8_MAX
#define EEPROM_SPARE 0x200 // an address that no option uses
#define ZERO         128   // option value of an overflow at about the end of the packet

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static struct serial serial;
AVR_SERIAL(serial)

BENCH_REQUEST(request, 2);

/* What the program does when the packet ends. */
enum activity { LOOPS, CALLS, FRAMES, WRITES_EEPROM };

BENCH_NOINLINE static void call(void)
{
    __asm__ volatile("");
}

/* The compiler moves the stack pointer with interrupts off. */
BENCH_NOINLINE static void frame(void)
{
    volatile uint8_t bytes[8];

    __asm__ volatile("" ::"r"(&bytes[0]) : "memory");
}

/* The cli section ends before ret, the longest instruction. */
BENCH_NOINLINE static void write_eeprom(void)
{
    avr_eeprom_write(EEPROM_SPARE, 0);
}

/* Waits `cycles` plus a constant. */
BENCH_NOINLINE static void delay(uint8_t cycles)
{
    if (cycles & 1)
        __asm__ volatile("nop");
    if (cycles & 2)
        __asm__ volatile("nop\n\tnop");
    __asm__ volatile("lsr %0\n\tlsr %0\n\tinc %0\n"
                     "1: nop\n\tdec %0\n\tbrne 1b" // 4 cycles
                     : "+r"(cycles));
}

/* Sends bytes to the host, one every 160 cycles, until the packet has ended. */
static void send_to_host(void)
{
    for (uint8_t i = 0; i < SENT; i++)
        cds_ring_put(&serial.tx, 0x55);
    serial_send(&serial);
}

/* Waits until a byte of the host is stored. */
static void wait_for_host(void)
{
    uint8_t head = serial.rx.head;

    serial.rx.tail = head;
    while (serial.rx.head == head) {
    }
}

static void stay_busy(enum activity activity, uint8_t step)
{
    switch (activity) {
    case LOOPS:
        while (bench_is_sending(&bus)) {
        }
        break;
    case CALLS:
        while (bench_is_sending(&bus)) {
            call();
            call();
        }
        break;
    case FRAMES:
        while (bench_is_sending(&bus))
            frame();
        break;
    default:
        delay(step);
        write_eeprom();
        while (bench_is_sending(&bus)) {
        }
        break;
    }
}

/* The moments of the four events. */
struct moments {
    uint8_t phase;   // of the packet relative to the bytes of the host, in cycles
    int8_t overflow; // of the clock, in cycles from about the end of the packet
    uint8_t send;    // of the bytes to the host, in cycles, or NOTHING_SENT
    uint8_t write;   // to the EEPROM
};

static void one_case(enum activity activity, const struct moments *at)
{
    int8_t overflow = at->overflow;

    wait_for_host();
    if (at->send != NOTHING_SENT) {
        delay(at->send);
        send_to_host();
    }
    wait_for_host();
    delay(at->phase);
    cds_servo_action(&bus, &request, CDS_BROADCAST_ID);
    while (!bench_is_draining(&bus)) {
    }
    delay((uint8_t)overflow % TICK);
    CDS_AVR_TIMER_COUNT = (uint16_t) - (TICKS_LEFT + overflow / TICK);
    stay_busy(activity, at->write);
    bench_wait(&bus);
}

/* The moments of one event, from three options: the first one, the step, their number. */
struct range {
    uint8_t from, step, count;
};

static struct range range_of(uint8_t option)
{
    struct range range = {bench_option(option), bench_option((uint8_t)(option + 1)),
                          bench_option((uint8_t)(option + 2))};

    return range;
}

static uint8_t moment(const struct range *range, uint8_t i)
{
    return (uint8_t)(range->from + range->step * i);
}

int main(void)
{
    enum activity activity = (enum activity)bench_option(0);
    bool real = bench_option(1); // each write to the EEPROM waits for the one before it: 8.5 ms
    struct range phases = range_of(2), overflows = range_of(5), sends = range_of(8),
                 writes = range_of(11);
    struct moments at;

    bench_open(&bus);
    serial_open(&serial, HOST_1M);
    for (uint8_t i = 0; i < phases.count; i++)
        for (uint8_t j = 0; j < overflows.count; j++)
            for (uint8_t k = 0; k < sends.count; k++)
                for (uint8_t l = 0; l < writes.count; l++) {
                    at.phase = moment(&phases, i);
                    at.overflow = (int8_t)(moment(&overflows, j) - ZERO);
                    at.send = moment(&sends, k);
                    at.write = moment(&writes, l);
                    while (real && !avr_eeprom_ready())
                        serial.rx.tail = serial.rx.head;
                    one_case(activity, &at);
                }
    cli(); // nothing was printed, so say_end() must not wait for an interrupt
    sleep_enable();
    sleep_cpu();
}
