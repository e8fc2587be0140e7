/* The microsecond clock; see clock.h. */
#include "clock.h"

#include <avr/io.h>
#include <stdbool.h>

#include "board.h"
#include "cds55xx/port.h" // cds_port_now_us()
#include "timer.h"        // registers of BOARD_CLOCK_TIMER

void cds_avr_clock_open(void)
{
    TIMER_CONTROL_B = 0;
    TIMER_COUNT = 0;
    cds_avr_clock.overflows_us = 0;
    TIMER_FLAGS = TIMER_OVERFLOW_FLAG; // an old overflow must not count
    TIMER_INTERRUPTS |= TIMER_OVERFLOW_ENABLE;
    TIMER_CONTROL_B = TIMER_PRESCALE_8;
}

/* Without turning interrupts off, which would hold up the turnaround of a bus: if the handler ran
 * between the two readings of its count, they are taken again. */
uint32_t cds_port_now_us(void)
{
    uint32_t now_us;
    uint16_t ticks;
    bool overflowed;

    do {
        now_us = cds_avr_clock.overflows_us;
        ticks = TIMER_COUNT;
        overflowed = TIMER_FLAGS & TIMER_OVERFLOW_FLAG;
    } while (now_us != cds_avr_clock.overflows_us);
    if (overflowed && ticks < AVR_CLOCK_OVERFLOW_US)
        now_us +=
            AVR_CLOCK_OVERFLOW_US; // it overflowed before `ticks`, and its handler has yet to run
    return now_us + (ticks >> 1);
}
