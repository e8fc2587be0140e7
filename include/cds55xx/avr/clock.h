/* SPDX-License-Identifier: MIT */
/* The microsecond clock: a 16-bit timer at F_CPU / 8, two ticks a microsecond, and a count of its
 * overflows, every 32 768 us; and the timer of each bus. */
#ifndef CDS_AVR_CLOCK_H
#define CDS_AVR_CLOCK_H

#include <avr/interrupt.h>
#include <stdbool.h>
#include <stdint.h>

#include "board.h"
#include "cds55xx/avr/library.h" // CDS_AVR_REFER_TO_LIBRARY_
#include "cds55xx/avr/timer.h"   // registers of BOARD_CLOCK_TIMER
#include "cds55xx/avr/usart.h"   // CDS_AVR_INLINE, CDS_AVR_NEAR
#include "cds55xx/port.h"        // what is implemented here

#define CDS_AVR_CLOCK_OVERFLOW_US 32768u
#define CDS_AVR_CLOCK_SOON        20 // ticks: longer than setting the timer takes

#ifdef __cplusplus
extern "C" {
#endif

/* What the clock knows besides its timer. */
struct cds_avr_clock {
    volatile uint8_t overflows[3]; // low byte first; written by the handler
};

/* The program's one clock; CDS_AVR_CLOCK() of avr.h defines it. */
extern struct cds_avr_clock cds_avr_clock;

/* Starts the clock, at 0 us if the timer did not run before. Main context, once, before the first
 * bus is opened. */
void cds_avr_clock_open(void);

#ifdef __cplusplus
}
#endif

/* Each bus has a compare unit of the timer: A, B or C. */
CDS_AVR_INLINE uint8_t cds_avr_clock_compare_flag(uint8_t port)
{
#if BOARD_BUS_COUNT > 2
    if (port == 2)
        return CDS_AVR_TIMER_COMPARE_FLAG_C;
#endif
#if BOARD_BUS_COUNT > 1
    if (port == 1)
        return CDS_AVR_TIMER_COMPARE_FLAG_B;
#endif
    (void)port;
    return CDS_AVR_TIMER_COMPARE_FLAG_A;
}

CDS_AVR_INLINE void cds_avr_clock_set_compare(uint8_t port, uint16_t ticks)
{
#if BOARD_BUS_COUNT > 2
    if (port == 2) {
        CDS_AVR_TIMER_COMPARE_C = ticks;
        return;
    }
#endif
#if BOARD_BUS_COUNT > 1
    if (port == 1) {
        CDS_AVR_TIMER_COMPARE_B = ticks;
        return;
    }
#endif
    (void)port;
    CDS_AVR_TIMER_COMPARE_A = ticks;
}

/* Ticks of so many times `each_us`, and `*ticks` microseconds: the lower 16 bits, and returns those
 * above. For so few bits avr-gcc would call a function that multiplies to 32. */
CDS_AVR_INLINE uint8_t cds_avr_clock_sum_up(uint16_t count, uint16_t each_us, uint16_t *ticks)
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
CDS_AVR_INLINE uint8_t cds_avr_clock_set_timer(uint8_t port, uint16_t from, uint16_t count,
                                               uint16_t each_us, uint16_t more_us)
{
    uint16_t wait = more_us, passed;
    uint8_t laps = cds_avr_clock_sum_up(count, each_us, &wait);

    for (;;) {
        cds_avr_clock_set_compare(port, (uint16_t)(from + wait));
        CDS_AVR_TIMER_FLAGS = cds_avr_clock_compare_flag(port);
        passed = (uint16_t)(CDS_AVR_TIMER_COUNT - from);
        if (passed < wait || (CDS_AVR_TIMER_FLAGS & cds_avr_clock_compare_flag(port)))
            return laps;
        if (laps && passed != wait) // it would have rung by now, and does so again in time
            return (uint8_t)(laps - 1u);
        wait = (uint16_t)(passed + CDS_AVR_CLOCK_SOON);
    }
}

/* Counts the overflow. The line's turnaround must not wait for it: other handlers are let in at
 * once. By hand: 14 bytes less than from C. inc changes no carry, and sts changes no flag. */
CDS_AVR_INLINE void cds_avr_clock_on_overflow(void)
{
    __asm__ volatile(
        "sei                    \n\t"
        "push r24               \n\t"
        "in   r24, __SREG__     \n\t"
        "push r24               \n\t"
        "lds  r24, %[low]       \n\t"
        "inc  r24               \n\t"
        "sts  %[low], r24       \n\t"
        "brne 1f                \n\t"
        "lds  r24, %[middle]    \n\t"
        "inc  r24               \n\t"
        "sts  %[middle], r24    \n\t"
        "brne 1f                \n\t"
        "lds  r24, %[high]      \n\t"
        "inc  r24               \n\t"
        "sts  %[high], r24      \n\t"
        "1: pop r24             \n\t"
        "out  __SREG__, r24     \n\t"
        "pop  r24               \n\t"
        "reti                   \n\t"
        :
        : [low] "i"(&cds_avr_clock.overflows[0]), [middle] "i"(&cds_avr_clock.overflows[1]),
          [high] "i"(&cds_avr_clock.overflows[2]));
}

/* Without turning interrupts off, which would hold up the turnaround of a bus: if the handler ran
 * amid the reading of its count, all is read again. Half of 40 bits, of which 32 are kept. */
CDS_AVR_INLINE uint32_t cds_avr_clock_now_us(void)
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
        now.part.ticks = CDS_AVR_TIMER_COUNT;
        overflowed = CDS_AVR_TIMER_FLAGS & CDS_AVR_TIMER_OVERFLOW_FLAG;
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

/* Arduino's core sets the timers to 8-bit PWM before setup(). After a reset this register is 0. */
#ifdef ARDUINO
#define CDS_AVR_CLOCK_END_PWM_() (CDS_AVR_TIMER_CONTROL_A = 0)
#else
#define CDS_AVR_CLOCK_END_PWM_() ((void)0)
#endif

/* The clock, its handler, and the functions of port.h that read the clock and set the timers. */
#define CDS_AVR_CLOCK_FUNCTIONS_                                                                   \
    struct cds_avr_clock cds_avr_clock;                                                            \
    void cds_avr_clock_open(void)                                                                  \
    {                                                                                              \
        CDS_AVR_REFER_TO_LIBRARY_();                                                               \
        CDS_AVR_CLOCK_END_PWM_();                                                                  \
        CDS_AVR_TIMER_CONTROL_B = CDS_AVR_TIMER_PRESCALE_8;                                        \
        CDS_AVR_TIMER_FLAGS = CDS_AVR_TIMER_OVERFLOW_FLAG; /* an old overflow must not count */    \
        CDS_AVR_TIMER_INTERRUPTS |= CDS_AVR_TIMER_OVERFLOW_ENABLE;                                 \
    }                                                                                              \
    ISR(CDS_AVR_TIMER_OVERFLOW_VECTOR, ISR_NAKED CDS_AVR_NEAR)                                     \
    {                                                                                              \
        cds_avr_clock_on_overflow();                                                               \
    }                                                                                              \
    uint32_t cds_port_now_us(void)                                                                 \
    {                                                                                              \
        return cds_avr_clock_now_us();                                                             \
    }                                                                                              \
    uint16_t cds_port_ticks(void)                                                                  \
    {                                                                                              \
        return CDS_AVR_TIMER_COUNT;                                                                \
    }                                                                                              \
    uint8_t cds_port_set_timer(uint8_t port, uint16_t from, uint16_t count, uint16_t each_us,      \
                               uint16_t more_us)                                                   \
    {                                                                                              \
        return cds_avr_clock_set_timer(port, from, count, each_us, more_us);                       \
    }                                                                                              \
    void cds_port_restart_timer(uint8_t port)                                                      \
    {                                                                                              \
        CDS_AVR_TIMER_FLAGS = cds_avr_clock_compare_flag(port);                                    \
    }                                                                                              \
    bool cds_port_timer_expired(uint8_t port)                                                      \
    {                                                                                              \
        return CDS_AVR_TIMER_FLAGS & cds_avr_clock_compare_flag(port);                             \
    }

#endif
