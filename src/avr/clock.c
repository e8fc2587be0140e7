/* The timer of the clock, and of each bus; see clock.h. */
#include "clock.h"

#include <avr/io.h>
#include <stdbool.h>

#include "board.h"
#include "cds55xx/port.h" // what is implemented here
#include "timer.h"        // registers of BOARD_CLOCK_TIMER
#include "usart.h"        // AVR_INLINE

#define AVR_CLOCK_SOON 20 // ticks: longer than it takes to set it

void cds_avr_clock_open(void)
{
    TIMER_CONTROL_B = TIMER_PRESCALE_8;
    cds_avr_clock_count_();
}

/* Each bus has a compare unit of the timer: A, B or C. */
AVR_INLINE uint8_t compare_flag(uint8_t port)
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

uint16_t cds_port_ticks(void)
{
    return TIMER_COUNT;
}

/* Ticks of so many times `each_us`, and `*ticks` microseconds: the lower 16 bits, and returns those
 * above. For so few bits avr-gcc would call a function that multiplies to 32. */
AVR_INLINE uint8_t sum_up(uint16_t count, uint16_t each_us, uint16_t *ticks)
{
    uint16_t low = *ticks;
    uint8_t high;

    __asm__("mul  %B2, %B3   \n\t"
            "mov  %1, r0     \n\t"
            "mul  %A2, %A3   \n\t"
            "add  %A0, r0    \n\t"
            "adc  %B0, r1    \n\t"
            "clr  r1         \n\t" // and the carry stays
            "adc  %1, r1     \n\t"
            "mul  %A2, %B3   \n\t"
            "add  %B0, r0    \n\t"
            "adc  %1, r1     \n\t"
            "mul  %B2, %A3   \n\t"
            "add  %B0, r0    \n\t"
            "adc  %1, r1     \n\t"
            "clr  r1         \n\t"
            "lsl  %A0        \n\t"
            "rol  %B0        \n\t"
            "rol  %1         \n\t"
            : "+&r"(low), "=&r"(high)
            : "r"(count), "r"(each_us)
            : "r0");
    *ticks = low;
    return high;
}

/* The timer sets the flag when it passes the compare register, every 32 ms. What was passed while a
 * handler held up these lines would expire late: so it is moved to a few microseconds from now, or
 * counted as a lap that is over. */
uint8_t cds_port_set_timer(uint8_t port, uint16_t from, uint16_t count, uint16_t each_us,
                           uint16_t more_us)
{
    uint16_t wait = more_us, passed;
    uint8_t laps = sum_up(count, each_us, &wait);

    for (;;) {
        set_compare(port, (uint16_t)(from + wait));
        TIMER_FLAGS = compare_flag(port);
        passed = (uint16_t)(TIMER_COUNT - from);
        if (passed < wait || (TIMER_FLAGS & compare_flag(port)))
            return laps;
        if (laps && passed != wait) // it would have rung by now, and does so again in time
            return (uint8_t)(laps - 1u);
        wait = (uint16_t)(passed + AVR_CLOCK_SOON);
    }
}

void cds_port_restart_timer(uint8_t port)
{
    TIMER_FLAGS = compare_flag(port);
}

bool cds_port_timer_expired(uint8_t port)
{
    return TIMER_FLAGS & compare_flag(port);
}
