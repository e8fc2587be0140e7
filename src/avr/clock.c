/* The microsecond clock; see clock.h. */
#include "clock.h"

#include <avr/io.h>
#include <stdbool.h>

#include "board.h"
#include "cds55xx/port.h" // cds_port_now_us()
#include "timer.h"        // registers of BOARD_CLOCK_TIMER
#include "usart.h"        // AVR_INLINE

#define AVR_CLOCK_SOON 20 // ticks: longer than it takes to set it

void cds_avr_clock_open(void)
{
    TIMER_CONTROL_B = 0;
    TIMER_COUNT = 0;
    cds_avr_clock.overflows[0] = cds_avr_clock.overflows[1] = cds_avr_clock.overflows[2] = 0;
    TIMER_FLAGS = TIMER_OVERFLOW_FLAG; // an old overflow must not count
    TIMER_INTERRUPTS |= TIMER_OVERFLOW_ENABLE;
    TIMER_CONTROL_B = TIMER_PRESCALE_8;
}

/* Without turning interrupts off, which would hold up the turnaround of a bus: if the handler ran
 * amid the reading of its count, all is read again. Half of 40 bits, of which 32 are kept. */
uint32_t cds_port_now_us(void)
{
    union {
        struct {
            uint16_t ticks;
            uint8_t overflows[2];
        } part;
        uint32_t whole;
    } now;
    uint8_t top;
    bool overflowed;

    do {
        now.part.overflows[0] = cds_avr_clock.overflows[0];
        now.part.overflows[1] = cds_avr_clock.overflows[1];
        top = cds_avr_clock.overflows[2];
        now.part.ticks = TIMER_COUNT;
        overflowed = TIMER_FLAGS & TIMER_OVERFLOW_FLAG;
    } while (now.part.overflows[0] != cds_avr_clock.overflows[0]);
    if (overflowed && (int16_t)now.part.ticks >= 0) { // before `ticks`; its handler has yet to run
        now.whole += 0x10000;
        if (now.whole < 0x10000)
            top++;
    }
    now.whole >>= 1;
    if (top & 1)
        now.whole |= 0x80000000;
    return now.whole;
}

/* Each bus has a compare unit of the timer: A, B or C. */
AVR_INLINE uint8_t alarm_flag(uint8_t port)
{
#if BOARD_BUS_COUNT > 2
    if (port == 2)
        return TIMER_COMPARE_FLAG_C;
#endif
#if BOARD_BUS_COUNT > 1
    if (port == 1)
        return TIMER_COMPARE_FLAG_B;
#endif
    (void)port;
    return TIMER_COMPARE_FLAG_A;
}

AVR_INLINE void set_compare(uint8_t port, uint16_t ticks)
{
#if BOARD_BUS_COUNT > 2
    if (port == 2) {
        TIMER_COMPARE_C = ticks;
        return;
    }
#endif
#if BOARD_BUS_COUNT > 1
    if (port == 1) {
        TIMER_COMPARE_B = ticks;
        return;
    }
#endif
    (void)port;
    TIMER_COMPARE_A = ticks;
}

uint16_t cds_port_short_us(void)
{
    return TIMER_COUNT >> 1;
}

/* The timer sets the flag when it passes the compare register, every 32 ms. What was passed while a
 * handler held up these lines would ring late: so it is moved to a few microseconds from now, or
 * counted as a lap that is over. */
uint8_t cds_port_set_alarm(uint8_t port, uint16_t from_us, uint32_t us)
{
    uint32_t ticks = us << 1;
    uint16_t from = (uint16_t)(from_us << 1), wait = (uint16_t)ticks, passed;
    uint8_t laps = (uint8_t)(ticks >> 16);

    for (;;) {
        set_compare(port, (uint16_t)(from + wait));
        TIMER_FLAGS = alarm_flag(port);
        passed = (uint16_t)(TIMER_COUNT - from);
        if (passed < wait || (TIMER_FLAGS & alarm_flag(port)))
            break;
        if (laps && passed > wait) { // it would have rung by now, and does so again in time
            laps--;
            break;
        }
        wait = (uint16_t)(passed + AVR_CLOCK_SOON);
    }
    return laps;
}

void cds_port_silence_alarm(uint8_t port)
{
    TIMER_FLAGS = alarm_flag(port);
}

bool cds_port_alarm_rings(uint8_t port)
{
    return TIMER_FLAGS & alarm_flag(port);
}
