/* SPDX-License-Identifier: MIT */
/* Checks board.h at compile time. Each error message names the line that is missing or wrong.
 * Without these checks the compiler would report pasted register names that do not exist. */
#ifndef CDS_AVR_BOARD_CHECK_H
#define CDS_AVR_BOARD_CHECK_H

#include <avr/io.h>

#include "board.h"

#define CDS_AVR_CHECK_PASTE_(a, b)     a##b
#define CDS_AVR_CHECK_PASTE(a, b)      CDS_AVR_CHECK_PASTE_(a, b)
#define CDS_AVR_CHECK_PASTE3_(a, b, c) a##b##c
#define CDS_AVR_CHECK_PASTE3(a, b, c)  CDS_AVR_CHECK_PASTE3_(a, b, c)
#define CDS_AVR_CHECK_TEXT_(text)      #text
#define CDS_AVR_CHECK_TEXT(text)       CDS_AVR_CHECK_TEXT_(text)
#ifdef __cplusplus
#define CDS_AVR_CHECK_ASSERT static_assert
#else
#define CDS_AVR_CHECK_ASSERT __extension__ _Static_assert
#endif

/* What is defined becomes 1; a name that is not is 0 to #if. */
#ifdef UDR0
#define CDS_AVR_CHECK_USART_0 1
#endif
#ifdef UDR1
#define CDS_AVR_CHECK_USART_1 1
#endif
#ifdef UDR2
#define CDS_AVR_CHECK_USART_2 1
#endif
#ifdef UDR3
#define CDS_AVR_CHECK_USART_3 1
#endif
#define CDS_AVR_CHECK_WIRING_TWO_ENABLES  1
#define CDS_AVR_CHECK_WIRING_ONE_ENABLE   1
#define CDS_AVR_CHECK_WIRING_TIED         1
#define CDS_AVR_CHECK_WIRING_ADAPTER      1
#define CDS_AVR_CHECK_WIRING_ADAPTER_ECHO 1

/* A bit from 0 to 7 becomes itself: one character. Any other one stays the name of a macro that
 * does not exist, which is longer. */
#define CDS_AVR_CHECK_BIT_0 0
#define CDS_AVR_CHECK_BIT_1 1
#define CDS_AVR_CHECK_BIT_2 2
#define CDS_AVR_CHECK_BIT_3 3
#define CDS_AVR_CHECK_BIT_4 4
#define CDS_AVR_CHECK_BIT_5 5
#define CDS_AVR_CHECK_BIT_6 6
#define CDS_AVR_CHECK_BIT_7 7

/* Port and bit of a pin, each one character long; a macro that is not defined is its own name. */
#define CDS_AVR_CHECK_PIN(bus, key)                                                                \
    CDS_AVR_CHECK_ASSERT(                                                                          \
        sizeof(CDS_AVR_CHECK_TEXT(CDS_AVR_CHECK_PASTE3(BOARD_BUS, bus, _##key##_PORT))) == 2,      \
        "board.h: wanted is BOARD_BUS" #bus "_" #key "_PORT, a letter");                           \
    CDS_AVR_CHECK_ASSERT(                                                                          \
        sizeof(CDS_AVR_CHECK_TEXT(CDS_AVR_CHECK_PASTE(                                             \
            CDS_AVR_CHECK_BIT_, CDS_AVR_CHECK_PASTE3(BOARD_BUS, bus, _##key##_BIT)))) == 2,        \
        "board.h: wanted is BOARD_BUS" #bus "_" #key "_BIT, 0 to 7");

#define CDS_AVR_CHECK_PINS_TWO_ENABLES(bus)                                                        \
    CDS_AVR_CHECK_PIN(bus, TX_ENABLE) CDS_AVR_CHECK_PIN(bus, RX_ENABLE)
#define CDS_AVR_CHECK_PINS_ONE_ENABLE(bus) CDS_AVR_CHECK_PIN(bus, ENABLE)
#define CDS_AVR_CHECK_PINS_TIED(bus)
#define CDS_AVR_CHECK_PINS_ADAPTER(bus)
#define CDS_AVR_CHECK_PINS_ADAPTER_ECHO(bus)

#define CDS_AVR_CHECK_BUS(bus)                                                                     \
    CDS_AVR_CHECK_PIN(bus, RXD)                                                                    \
    CDS_AVR_CHECK_PIN(bus, TXD)                                                                    \
    CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_PINS_, CDS_AVR_CHECK_PASTE3(BOARD_BUS, bus, _WIRING))(bus)

#if defined UDR && !defined UDR0
#error "this chip is not supported: registers of its USART have no digit (UDR, not UDR0)"
#endif

#if !defined BOARD_BUS_COUNT || BOARD_BUS_COUNT < 1 || BOARD_BUS_COUNT > 3
#error "board.h: wanted is BOARD_BUS_COUNT, 1 to 3"
#endif

#ifndef BOARD_BUS0_WIRING
#define BOARD_BUS0_WIRING TWO_ENABLES
#endif
#ifndef BOARD_BUS1_WIRING
#define BOARD_BUS1_WIRING TWO_ENABLES
#endif
#ifndef BOARD_BUS2_WIRING
#define BOARD_BUS2_WIRING TWO_ENABLES
#endif

#if !CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_USART_, BOARD_BUS0_USART)
#error "board.h: BOARD_BUS0_USART is missing, or this chip has no USART of that number"
#elif !CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_WIRING_, BOARD_BUS0_WIRING)
#error "board.h: there is no such BOARD_BUS0_WIRING (cds55xx/avr/usart.h has them)"
#else
CDS_AVR_CHECK_BUS(0)
#endif

#if BOARD_BUS_COUNT > 1
#if !CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_USART_, BOARD_BUS1_USART)
#error "board.h: BOARD_BUS1_USART is missing, or this chip has no USART of that number"
#elif !CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_WIRING_, BOARD_BUS1_WIRING)
#error "board.h: there is no such BOARD_BUS1_WIRING (cds55xx/avr/usart.h has them)"
#else
CDS_AVR_CHECK_BUS(1)
#endif
#endif

#if BOARD_BUS_COUNT > 2
#if !CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_USART_, BOARD_BUS2_USART)
#error "board.h: BOARD_BUS2_USART is missing, or this chip has no USART of that number"
#elif !CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_WIRING_, BOARD_BUS2_WIRING)
#error "board.h: there is no such BOARD_BUS2_WIRING (cds55xx/avr/usart.h has them)"
#else
CDS_AVR_CHECK_BUS(2)
#endif
#endif

/* TCNTnH: only a timer of 16 bits has it. */
#ifdef TCNT1H
#define CDS_AVR_CHECK_TIMER_1 1
#endif
#ifdef TCNT3H
#define CDS_AVR_CHECK_TIMER_3 1
#endif
#ifdef TCNT4H
#define CDS_AVR_CHECK_TIMER_4 1
#endif
#ifdef TCNT5H
#define CDS_AVR_CHECK_TIMER_5 1
#endif
#ifndef BOARD_CLOCK_TIMER
#error "board.h: wanted is BOARD_CLOCK_TIMER, the number of a 16-bit timer"
#elif !CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_TIMER_, BOARD_CLOCK_TIMER)
#error "board.h: BOARD_CLOCK_TIMER is no 16-bit timer of this chip: 1, or perhaps 3, 4, 5"
#endif

#endif
