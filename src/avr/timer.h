/* The registers of BOARD_CLOCK_TIMER, a 16-bit timer, whatever the chip calls them. */
#ifndef AVR_TIMER_H
#define AVR_TIMER_H

#include <avr/io.h>

#include "board.h"
#include "board_check.h"

#define TIMER_PASTE3_(a, b, c) a##b##c
#define TIMER_PASTE3(a, b, c)  TIMER_PASTE3_(a, b, c)

#define TIMER_CONTROL_B       TIMER_PASTE3(TCCR, BOARD_CLOCK_TIMER, B)
#define TIMER_COUNT           TIMER_PASTE3(TCNT, BOARD_CLOCK_TIMER, )
#define TIMER_COMPARE_A       TIMER_PASTE3(OCR, BOARD_CLOCK_TIMER, A)
#define TIMER_COMPARE_B       TIMER_PASTE3(OCR, BOARD_CLOCK_TIMER, B)
#define TIMER_COMPARE_C       TIMER_PASTE3(OCR, BOARD_CLOCK_TIMER, C)
#define TIMER_OVERFLOW_VECTOR TIMER_PASTE3(TIMER, BOARD_CLOCK_TIMER, _OVF_vect)
#define TIMER_PRESCALE_8      (1 << 1) // CSn1

#ifdef TIMSK // ATmega128: one register for timers 0 to 2
#if BOARD_CLOCK_TIMER != 1
#error "on this chip the clock must be timer 1"
#endif
#define TIMER_INTERRUPTS      TIMSK
#define TIMER_FLAGS           TIFR
#define TIMER_OVERFLOW_ENABLE (1 << TOIE1)
#define TIMER_OVERFLOW_FLAG   (1 << TOV1)
#define TIMER_COMPARE_FLAG_A  (1 << OCF1A)
#define TIMER_COMPARE_FLAG_B  (1 << OCF1B)
#else
#define TIMER_INTERRUPTS      TIMER_PASTE3(TIMSK, BOARD_CLOCK_TIMER, )
#define TIMER_FLAGS           TIMER_PASTE3(TIFR, BOARD_CLOCK_TIMER, )
#define TIMER_OVERFLOW_ENABLE 1        // TOIEn
#define TIMER_OVERFLOW_FLAG   1        // TOVn
#define TIMER_COMPARE_FLAG_A  (1 << 1) // OCFnA
#define TIMER_COMPARE_FLAG_B  (1 << 2)
#define TIMER_COMPARE_FLAG_C  (1 << 3)
#endif

#endif
