/* SPDX-License-Identifier: MIT */
/* The microsecond clock, read with interrupts on and off around the overflow of its timer, must
 * never go back or jump. Prints how often it did, how many timers expired early or late, and how
 * many were set to a wrong time. */
#include <cds55xx/port.h>
#include <cds55xx/avr.h>

#include "say.h"
#include "cds55xx/avr/timer.h" // CDS_AVR_TIMER_COMPARE_A

CDS_AVR_CLOCK()

#define LONGEST_STEP_US 20 // two readings and the handler between them

#define SEEN_TICKS 100 // longer than setting the timer and its handler take

#define LATEST_RING_US                                                                             \
    30 // a poll of the timer, a read of the clock, and the clock's handler between them

struct time {
    uint16_t count, each_us, more_us;
};

static uint32_t in_us(const struct time *time)
{
    return (uint32_t)time->count * time->each_us + time->more_us;
}

/* How late the timer expires that is set to `time` after now, `late_us` after now: it must never
 * expire early. Looked at all the time. */
static int32_t ringing_late_us(const struct time *time, uint16_t late_us)
{
    uint16_t from = cds_port_ticks();
    uint32_t from_us = cds_port_now_us();
    uint8_t laps;

    while (cds_port_now_us() - from_us < late_us) {
    }
    laps = cds_port_set_timer(0, from, time->count, time->each_us, time->more_us);
    for (;;) {
        while (!cds_port_timer_expired(0)) {
        }
        if (laps == 0)
            return (int32_t)(cds_port_now_us() - from_us - in_us(time));
        laps--;
        cds_port_restart_timer(0);
    }
}

static uint32_t wrong_alarms(void)
{
    static const struct time lasts[] = {{2, 46, 608},    {15, 1275, 875},  {256, 128, 0},
                                        {255, 255, 708}, {60, 1275, 4500}, {300, 325, 804}};
    static const uint16_t late_us[] = {0, 100, 9000, 16000};
    uint32_t wrong = 0;

    for (uint8_t i = 0; i < sizeof lasts / sizeof *lasts; i++)
        for (uint8_t j = 0; j < sizeof late_us / sizeof *late_us; j++) {
            uint32_t us = in_us(&lasts[i]);
            int32_t late = ringing_late_us(&lasts[i], late_us[j]);

            if (late_us[j] > us)
                late -= late_us[j] - (int32_t)us; // it cannot ring before it is set
            if (late < 0 || late > LATEST_RING_US)
                wrong++;
        }
    return wrong;
}

/* Every length of a transaction at many rates: checks that the timer is set to the exact tick and
 * counts the right number of wraps. Leaves out lengths that expire before this check can run. */
static uint32_t wrong_sums(void)
{
    uint32_t wrong = 0;

    for (uint16_t baud = 0; baud < 255; baud += 17)
        for (uint16_t count = 6; count <= 314; count += 11) {
            struct time time = {count, (uint16_t)(5 * (baud + 1)), (uint16_t)(100 + 2 * baud)};
            uint32_t ticks = CDS_PORT_TICKS_PER_US * in_us(&time);
            uint16_t from = cds_port_ticks();
            uint8_t laps = cds_port_set_timer(0, from, time.count, time.each_us, time.more_us);

            if ((uint16_t)ticks > SEEN_TICKS &&
                (laps != ticks >> 16 || CDS_AVR_TIMER_COMPARE_A != (uint16_t)(from + ticks)))
                wrong++;
        }
    return wrong;
}

/* A timer with one wrap to go that reaches its tick while it is being set, in any cycle of that
 * code: the match has already happened, and the wrap must not count as over too. */
static uint32_t wrong_laps(void)
{
    uint32_t wrong = 0;

    for (uint16_t us = 0; us < 40; us++)
        for (uint8_t cycles = 0; cycles < 16; cycles++) {
            uint16_t from = cds_port_ticks();
            uint8_t laps;

            for (uint8_t i = 0; i < cycles; i++)
                __asm__ __volatile__("nop");
            laps = cds_port_set_timer(0, from, 1, CDS_AVR_CLOCK_OVERFLOW_US, us);
            while ((uint16_t)(cds_port_ticks() - from) < 100 * CDS_PORT_TICKS_PER_US) {
            }
            wrong += laps == 0 && cds_port_timer_expired(0);
        }
    return wrong;
}

int main(void)
{
    uint32_t wrong = 0, readings = 0, before_us, now_us = 0;

    say_open();
    cds_avr_clock_open();
    sei();
    while (now_us < 10ul * CDS_AVR_CLOCK_OVERFLOW_US) {
        before_us = now_us;
        if (readings & 1) { // every other pair without interrupts: the overflow then waits for us
            cli();
            before_us = cds_port_now_us();
        }
        now_us = cds_port_now_us();
        sei();
        if (now_us - before_us > LONGEST_STEP_US)
            wrong++;
        readings++;
    }
    say("readings", readings);
    say("wrong", wrong);
    say("alarms", wrong_alarms());
    say("sums", wrong_sums());
    say("laps", wrong_laps());
    say_end();
}
