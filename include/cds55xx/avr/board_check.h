/* SPDX-License-Identifier: MIT */
/* Checks board.h at compile time. The first mistake is one error that names the value and what is
 * right, and the compiler stops: else it would report pasted register names that do not exist. */
#ifndef CDS_AVR_BOARD_CHECK_H
#define CDS_AVR_BOARD_CHECK_H

#include <avr/io.h>

#include "board.h"
#include "cds55xx/avr/usart_pins.h"

#define CDS_AVR_CHECK_PASTE_(a, b)     a##b
#define CDS_AVR_CHECK_PASTE(a, b)      CDS_AVR_CHECK_PASTE_(a, b)
#define CDS_AVR_CHECK_PASTE3_(a, b, c) a##b##c
#define CDS_AVR_CHECK_PASTE3(a, b, c)  CDS_AVR_CHECK_PASTE3_(a, b, c)

/* An error whose text has the values of macros; those of #error are not expanded. */
#define CDS_AVR_CHECK_TEXT_(...)    #__VA_ARGS__
#define CDS_AVR_CHECK_TEXT(...)     CDS_AVR_CHECK_TEXT_(__VA_ARGS__)
#define CDS_AVR_CHECK_PRAGMA_(text) _Pragma(#text)
#define CDS_AVR_CHECK_PRAGMA(text)  CDS_AVR_CHECK_PRAGMA_(text)
#define CDS_AVR_CHECK_ERROR(...)    CDS_AVR_CHECK_PRAGMA(GCC error CDS_AVR_CHECK_TEXT(__VA_ARGS__))

/* What is there becomes a number other than 0; a name that is not defined is 0 to #if. */
#define CDS_AVR_CHECK_COUNT_1 1
#define CDS_AVR_CHECK_COUNT_2 2
#define CDS_AVR_CHECK_COUNT_3 3

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
#define CDS_AVR_CHECK_WIRING_ONE_ENABLE   2
#define CDS_AVR_CHECK_WIRING_TIED         3
#define CDS_AVR_CHECK_WIRING_ADAPTER      4
#define CDS_AVR_CHECK_WIRING_ADAPTER_ECHO 5

#ifdef PORTA
#define CDS_AVR_CHECK_PORT_A 10
#endif
#ifdef PORTB
#define CDS_AVR_CHECK_PORT_B 20
#endif
#ifdef PORTC
#define CDS_AVR_CHECK_PORT_C 30
#endif
#ifdef PORTD
#define CDS_AVR_CHECK_PORT_D 40
#endif
#ifdef PORTE
#define CDS_AVR_CHECK_PORT_E 50
#endif
#ifdef PORTF
#define CDS_AVR_CHECK_PORT_F 60
#endif
#ifdef PORTG
#define CDS_AVR_CHECK_PORT_G 70
#endif
#ifdef PORTH
#define CDS_AVR_CHECK_PORT_H 80
#endif
#ifdef PORTJ
#define CDS_AVR_CHECK_PORT_J 90
#endif
#ifdef PORTK
#define CDS_AVR_CHECK_PORT_K 100
#endif
#ifdef PORTL
#define CDS_AVR_CHECK_PORT_L 110
#endif

#define CDS_AVR_CHECK_BIT_0 1
#define CDS_AVR_CHECK_BIT_1 2
#define CDS_AVR_CHECK_BIT_2 3
#define CDS_AVR_CHECK_BIT_3 4
#define CDS_AVR_CHECK_BIT_4 5
#define CDS_AVR_CHECK_BIT_5 6
#define CDS_AVR_CHECK_BIT_6 7
#define CDS_AVR_CHECK_BIT_7 8

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

/* Of bus CDS_AVR_CHECK_BUS: the value of a line of board.h. BOARD_BUSn_RXD is no line: its value is
 * this name, for messages. */
#define CDS_AVR_CHECK_VALUE(end) CDS_AVR_CHECK_PASTE3(BOARD_BUS, CDS_AVR_CHECK_BUS, end)
#define CDS_AVR_CHECK_WIRING                                                                       \
    CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_WIRING_, CDS_AVR_CHECK_VALUE(_WIRING))

/* Port and bit of a pin in board.h as numbers, 0 for a wrong value; and one number of both. */
#define CDS_AVR_CHECK_PORT(key)                                                                    \
    CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_PORT_, CDS_AVR_CHECK_VALUE(_##key##_PORT))
#define CDS_AVR_CHECK_BIT(key)                                                                     \
    CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_BIT_, CDS_AVR_CHECK_VALUE(_##key##_BIT))
#define CDS_AVR_CHECK_IS_PIN(key) (CDS_AVR_CHECK_PORT(key) && CDS_AVR_CHECK_BIT(key))
#define CDS_AVR_CHECK_PIN(key)    (CDS_AVR_CHECK_PORT(key) + CDS_AVR_CHECK_BIT(key))

/* The same for the pin RXD or TXD of the USART. */
#define CDS_AVR_CHECK_RIGHT(key, end)                                                              \
    CDS_AVR_CHECK_PASTE3(CDS_AVR_##key, CDS_AVR_CHECK_VALUE(_USART), end)
#define CDS_AVR_CHECK_USART_PIN(key)                                                               \
    (CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_PORT_, CDS_AVR_CHECK_RIGHT(key, _PORT)) +                   \
     CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_BIT_, CDS_AVR_CHECK_RIGHT(key, _BIT)))

/* The words of messages: clang-format takes them for code. */
// clang-format off
#define CDS_AVR_CHECK_PIN_TEXT(key)                                                                \
    port CDS_AVR_CHECK_VALUE(_##key##_PORT) bit CDS_AVR_CHECK_VALUE(_##key##_BIT)
#define CDS_AVR_CHECK_USART_PIN_TEXT(key)                                                          \
    port CDS_AVR_CHECK_RIGHT(key, _PORT) bit CDS_AVR_CHECK_RIGHT(key, _BIT)
#define CDS_AVR_CHECK_NO_PIN_ERROR(key)                                                            \
    CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_VALUE(_##key) is on CDS_AVR_CHECK_PIN_TEXT(key);    \
                        use a port of __AVR_DEVICE_NAME__, a capital letter, and a bit from 0 to 7)
#define CDS_AVR_CHECK_SAME_PIN_ERROR(enable, key)                                                  \
    CDS_AVR_CHECK_ERROR(board.h: CDS_AVR_CHECK_VALUE(_##enable) is on                              \
                        CDS_AVR_CHECK_PIN_TEXT(enable), the pin of CDS_AVR_CHECK_VALUE(_##key);    \
                        use another pin)

#if defined UDR && !defined UDR0
#define CDS_AVR_CHECK_FAILED
#error "this chip is not supported: registers of its USART have no digit (UDR, not UDR0)"
#elif !defined UDR0
#define CDS_AVR_CHECK_FAILED
#error "no chip with a USART is named: compile with -mmcu (pkg-config --cflags has it)"
#elif CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_COUNT_, BOARD_BUS_COUNT)
#else
#define CDS_AVR_CHECK_FAILED
#error "board.h: wanted is BOARD_BUS_COUNT, 1 to 3"
#endif

/* A file that does not exist: after this error alone the preprocessor stops. */
#define CDS_AVR_CHECK_STOP "the compiler stops here: correct the error above"
#ifdef CDS_AVR_CHECK_FAILED
#include CDS_AVR_CHECK_STOP
#endif

#ifndef BOARD_BUS0_USART
#define CDS_AVR_CHECK_FAILED
#error "board.h: wanted is BOARD_BUS0_USART, the number of a USART"
#elif BOARD_BUS_COUNT > 1 && !defined BOARD_BUS1_USART
#define CDS_AVR_CHECK_FAILED
#error "board.h: wanted is BOARD_BUS1_USART, the number of a USART"
#elif BOARD_BUS_COUNT > 2 && !defined BOARD_BUS2_USART
#define CDS_AVR_CHECK_FAILED
#error "board.h: wanted is BOARD_BUS2_USART, the number of a USART"
#elif !defined BOARD_CLOCK_TIMER
#define CDS_AVR_CHECK_FAILED
#error "board.h: wanted is BOARD_CLOCK_TIMER, the number of a 16-bit timer"
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

#define CDS_AVR_CHECK_BUS 0
#include "cds55xx/avr/board_check_bus.h"
#if BOARD_BUS_COUNT > 1
#define CDS_AVR_CHECK_BUS 1
#include "cds55xx/avr/board_check_bus.h"
#endif
#if BOARD_BUS_COUNT > 2
#define CDS_AVR_CHECK_BUS 2
#include "cds55xx/avr/board_check_bus.h"
#endif

#if !defined CDS_AVR_CHECK_FAILED && defined BOARD_HOST_USART
#if CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_USART_, BOARD_HOST_USART)
#else
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_ERROR(board.h: the host link has USART BOARD_HOST_USART, but __AVR_DEVICE_NAME__
                    has no USART of this number; is this the board.h of another chip?)
#endif
#endif

/* At 16 MHz and with U2X the rate of a USART is 2000000 / divisor. */
#define CDS_AVR_CHECK_DIVISOR ((2000000 + BOARD_HOST_BAUD / 2) / BOARD_HOST_BAUD)
#if !defined CDS_AVR_CHECK_FAILED && defined BOARD_HOST_USART && defined BOARD_HOST_BAUD
#if BOARD_HOST_BAUD > 0 && CDS_AVR_CHECK_DIVISOR >= 1 && CDS_AVR_CHECK_DIVISOR <= 4096 &&          \
    CDS_AVR_CHECK_DIVISOR * BOARD_HOST_BAUD * 97 <= 200000000 &&                                   \
    CDS_AVR_CHECK_DIVISOR * BOARD_HOST_BAUD * 103 >= 200000000
#else
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_ERROR(board.h: the host link has the rate BOARD_HOST_BAUD; use a rate within 3 % of 2000000 / n bit/s,
                    n from 1 to 4096)
#endif
#endif

#ifndef CDS_AVR_CHECK_FAILED
#if defined BOARD_HOST_USART && (BOARD_HOST_USART == BOARD_BUS0_USART ||                           \
                                 (BOARD_BUS_COUNT > 1 && BOARD_HOST_USART == BOARD_BUS1_USART) ||  \
                                 (BOARD_BUS_COUNT > 2 && BOARD_HOST_USART == BOARD_BUS2_USART))
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_ERROR(board.h: the host link and a bus have the same USART, BOARD_HOST_USART)
#elif (BOARD_BUS_COUNT > 1 && BOARD_BUS1_USART == BOARD_BUS0_USART) ||                             \
    (BOARD_BUS_COUNT > 2 &&                                                                        \
     (BOARD_BUS2_USART == BOARD_BUS0_USART || BOARD_BUS2_USART == BOARD_BUS1_USART))
#define CDS_AVR_CHECK_FAILED
#error "board.h: two buses have the same USART"
#endif
#endif

#ifndef CDS_AVR_CHECK_FAILED
#if CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_TIMER_, BOARD_CLOCK_TIMER)
#else
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_ERROR(board.h: the clock has timer BOARD_CLOCK_TIMER, but __AVR_DEVICE_NAME__ has no
                    16-bit timer of this number; use 1, or 3, 4 or 5 if the chip has them)
#endif
#endif

/* TIMSK: one register for the interrupts of timers 0 to 2; timer.h knows no other one there. */
#if !defined CDS_AVR_CHECK_FAILED && defined TIMSK && BOARD_CLOCK_TIMER != 1
#define CDS_AVR_CHECK_FAILED
CDS_AVR_CHECK_ERROR(board.h: the clock has timer BOARD_CLOCK_TIMER; on __AVR_DEVICE_NAME__ use 1)
#endif
// clang-format on

#ifdef CDS_AVR_CHECK_FAILED
#include CDS_AVR_CHECK_STOP
#endif

#endif
