/* SPDX-License-Identifier: MIT */
/* The registers of BOARD_CLOCK_TIMER, a 16-bit timer, whatever the chip calls them. */
#ifndef CDS_AVR_TIMER_H
#define CDS_AVR_TIMER_H

#include <avr/io.h>

#include "board.h"
#include "cds55xx/avr/board_check.h"

#define CDS_AVR_TIMER_PASTE3_(a, b, c) a##b##c
#define CDS_AVR_TIMER_PASTE3(a, b, c)  CDS_AVR_TIMER_PASTE3_(a, b, c)

#define CDS_AVR_TIMER_CONTROL_A       CDS_AVR_TIMER_PASTE3(TCCR, BOARD_CLOCK_TIMER, A)
#define CDS_AVR_TIMER_CONTROL_B       CDS_AVR_TIMER_PASTE3(TCCR, BOARD_CLOCK_TIMER, B)
#define CDS_AVR_TIMER_COUNT           CDS_AVR_TIMER_PASTE3(TCNT, BOARD_CLOCK_TIMER, )
#define CDS_AVR_TIMER_COMPARE_A       CDS_AVR_TIMER_PASTE3(OCR, BOARD_CLOCK_TIMER, A)
#define CDS_AVR_TIMER_COMPARE_B       CDS_AVR_TIMER_PASTE3(OCR, BOARD_CLOCK_TIMER, B)
#define CDS_AVR_TIMER_COMPARE_C       CDS_AVR_TIMER_PASTE3(OCR, BOARD_CLOCK_TIMER, C)
#define CDS_AVR_TIMER_OVERFLOW_VECTOR CDS_AVR_TIMER_PASTE3(TIMER, BOARD_CLOCK_TIMER, _OVF_vect)
#define CDS_AVR_TIMER_PRESCALE_8      (1 << 1) // CSn1

#ifdef TIMSK // ATmega128: one register for timers 0 to 2
#if BOARD_CLOCK_TIMER != 1
#error "on this chip the clock must be timer 1"
#endif
#define CDS_AVR_TIMER_INTERRUPTS      TIMSK
#define CDS_AVR_TIMER_FLAGS           TIFR
#define CDS_AVR_TIMER_OVERFLOW_ENABLE (1 << TOIE1)
#define CDS_AVR_TIMER_OVERFLOW_FLAG   (1 << TOV1)
#define CDS_AVR_TIMER_COMPARE_FLAG_A  (1 << OCF1A)
#define CDS_AVR_TIMER_COMPARE_FLAG_B  (1 << OCF1B)
#else
#define CDS_AVR_TIMER_INTERRUPTS      CDS_AVR_TIMER_PASTE3(TIMSK, BOARD_CLOCK_TIMER, )
#define CDS_AVR_TIMER_FLAGS           CDS_AVR_TIMER_PASTE3(TIFR, BOARD_CLOCK_TIMER, )
#define CDS_AVR_TIMER_OVERFLOW_ENABLE 1        // TOIEn
#define CDS_AVR_TIMER_OVERFLOW_FLAG   1        // TOVn
#define CDS_AVR_TIMER_COMPARE_FLAG_A  (1 << 1) // OCFnA
#define CDS_AVR_TIMER_COMPARE_FLAG_B  (1 << 2)
#define CDS_AVR_TIMER_COMPARE_FLAG_C  (1 << 3)
#endif

#endif
