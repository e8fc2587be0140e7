/* SPDX-License-Identifier: MIT */
/* Checks board.h at compile time. The first mistake is one error, which names the value and those
 * that are right. Then the compiler stops: else it would report pasted register names that do not
 * exist. If a value is a string, or a number between single quotes, the preprocessor prints errors
 * of its own before.
 *
 * Also sets BOARD_BUSn_WIRING to TWO_ENABLES if board.h does not name a wiring. */
#ifndef CDS_AVR_BOARD_CHECK_H
#define CDS_AVR_BOARD_CHECK_H

#include <avr/io.h>

#include "board.h"
#include "cds55xx/avr/usart_pins.h"

#define CDS_AVR_CHECK_PASTE_(a, b)        a##b
#define CDS_AVR_CHECK_PASTE(a, b)         CDS_AVR_CHECK_PASTE_(a, b)
#define CDS_AVR_CHECK_PASTE4_(a, b, c, d) a##b##c##d
#define CDS_AVR_CHECK_PASTE4(a, b, c, d)  CDS_AVR_CHECK_PASTE4_(a, b, c, d)

/* An error whose text has the values of macros; those of #error are not expanded. */
#define CDS_AVR_CHECK_TEXT_(...)    #__VA_ARGS__
#define CDS_AVR_CHECK_TEXT(...)     CDS_AVR_CHECK_TEXT_(__VA_ARGS__)
#define CDS_AVR_CHECK_PRAGMA_(text) _Pragma(#text)
#define CDS_AVR_CHECK_PRAGMA(text)  CDS_AVR_CHECK_PRAGMA_(text)
#define CDS_AVR_CHECK_ERROR(...)    CDS_AVR_CHECK_PRAGMA(GCC error CDS_AVR_CHECK_TEXT(__VA_ARGS__))

/* Included after an error. The file does not exist: a failed #include ends the preprocessor at
 * once, which #error does not. */
#define CDS_AVR_CHECK_STOP "the compiler stops here: correct the error above"

/* Each allowed value has a macro whose value is not 0. #if takes any other name as 0. */
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
/* TIMSK: one register for the interrupts of timers 0 to 2; timer.h knows no other one there. */
#ifdef TCNT5H
#define CDS_AVR_CHECK_TIMERS 1, 3, 4 or 5
#elif defined TCNT3H && !defined TIMSK
#define CDS_AVR_CHECK_TIMERS 1 or 3
#else
#define CDS_AVR_CHECK_TIMERS 1
#endif

/* 1 if a value is between parentheses, or if it is empty; else 0. PROBE expands to a second
 * argument 1 only if a parenthesis follows it. */
#define CDS_AVR_CHECK_SECOND_(a, b, ...) b
#define CDS_AVR_CHECK_SECOND(...)        CDS_AVR_CHECK_SECOND_(__VA_ARGS__)
#define CDS_AVR_CHECK_PROBE(...)         , 1,
#define CDS_AVR_CHECK_IS_PAREN(value)    CDS_AVR_CHECK_SECOND(CDS_AVR_CHECK_PROBE value, 0, 0)
#define CDS_AVR_CHECK_IS_EMPTY(value)                                                              \
    (CDS_AVR_CHECK_SECOND(CDS_AVR_CHECK_PROBE value(), 0, 0) && !CDS_AVR_CHECK_IS_PAREN(value))

/* KNOWN(PORT, D) is CDS_AVR_CHECK_PORT_D. A value between parentheses cannot be pasted, so it is
 * left out: CDS_AVR_CHECK_PORT_ is not defined. */
#define CDS_AVR_CHECK_WORD_0(value) value
#define CDS_AVR_CHECK_WORD_1(value)
#define CDS_AVR_CHECK_WORD(value)                                                                  \
    CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_WORD_, CDS_AVR_CHECK_IS_PAREN(value))(value)
#define CDS_AVR_CHECK_KNOWN(list, value)                                                           \
    CDS_AVR_CHECK_PASTE(CDS_AVR_CHECK_##list##_, CDS_AVR_CHECK_WORD(value))

/* VALUE(0, _RXD, _BIT): the value of BOARD_BUS0_RXD_BIT. VALUE(0, _RXD, ) expands to the name
 * BOARD_BUS0_RXD, which messages print. OF_BUS, OF_PIN: the same of the bus or pin that is checked.
 * IS_MISSING: the line is missing, or has no value. */
#define CDS_AVR_CHECK_VALUE(bus, key, end)       CDS_AVR_CHECK_PASTE4(BOARD_BUS, bus, key, end)
#define CDS_AVR_CHECK_IS_DEFINED_(bus, key, end) defined BOARD_BUS##bus##key##end
#define CDS_AVR_CHECK_IS_DEFINED(bus, key, end)  CDS_AVR_CHECK_IS_DEFINED_(bus, key, end)
#define CDS_AVR_CHECK_IS_MISSING(bus, key, end)                                                    \
    !CDS_AVR_CHECK_IS_DEFINED(bus, key, end) ||                                                    \
        CDS_AVR_CHECK_IS_EMPTY(CDS_AVR_CHECK_VALUE(bus, key, end))

/* VALUE of the bus and of the pin that are checked. */
#define CDS_AVR_CHECK_OF_BUS(key) CDS_AVR_CHECK_VALUE(CDS_AVR_CHECK_BUS, key, )
#define CDS_AVR_CHECK_OF_PIN(end) CDS_AVR_CHECK_VALUE(CDS_AVR_CHECK_BUS, CDS_AVR_CHECK_KEY, end)

#define CDS_AVR_CHECK_WIRING(bus) CDS_AVR_CHECK_KNOWN(WIRING, CDS_AVR_CHECK_VALUE(bus, _WIRING, ))

/* PORT and BIT: 0 if wrong. PIN: their sum, unique for each pin. */
#define CDS_AVR_CHECK_PORT(bus, key) CDS_AVR_CHECK_KNOWN(PORT, CDS_AVR_CHECK_VALUE(bus, key, _PORT))
#define CDS_AVR_CHECK_BIT(bus, key)  CDS_AVR_CHECK_KNOWN(BIT, CDS_AVR_CHECK_VALUE(bus, key, _BIT))
#define CDS_AVR_CHECK_PIN(bus, key)  (CDS_AVR_CHECK_PORT(bus, key) + CDS_AVR_CHECK_BIT(bus, key))

/* HAS_PIN(C, 3): avr/io.h defines PORTC3 or PC3, by the chip. */
#define CDS_AVR_CHECK_HAS_PIN_(port, bit) (defined PORT##port##bit || defined P##port##bit)
#define CDS_AVR_CHECK_HAS_PIN(port, bit)  CDS_AVR_CHECK_HAS_PIN_(port, bit)

/* USART_PIN: the pin that the data sheet gives to RXD or TXD. */
#define CDS_AVR_CHECK_DATASHEET(usart, key, end) CDS_AVR_CHECK_PASTE4(CDS_AVR, key, usart, end)
#define CDS_AVR_CHECK_USART_PIN(usart, key)                                                        \
    (CDS_AVR_CHECK_KNOWN(PORT, CDS_AVR_CHECK_DATASHEET(usart, key, _PORT)) +                       \
     CDS_AVR_CHECK_KNOWN(BIT, CDS_AVR_CHECK_DATASHEET(usart, key, _BIT)))

/* clang-format would break the words of messages as if they were code. */
// clang-format off
/* Beside CDS_AVR_CHECK_WIRING_..., the list of the wirings. */
#define CDS_AVR_CHECK_WIRINGS TWO_ENABLES, ONE_ENABLE, TIED, ADAPTER or ADAPTER_ECHO
#define CDS_AVR_CHECK_PIN_TEXT(key)                                                                \
    port CDS_AVR_CHECK_VALUE(CDS_AVR_CHECK_BUS, key, _PORT)                                        \
    bit CDS_AVR_CHECK_VALUE(CDS_AVR_CHECK_BUS, key, _BIT)
#define CDS_AVR_CHECK_USART_PIN_TEXT(key)                                                          \
    port CDS_AVR_CHECK_DATASHEET(CDS_AVR_CHECK_OF_BUS(_USART), key, _PORT)                         \
    bit CDS_AVR_CHECK_DATASHEET(CDS_AVR_CHECK_OF_BUS(_USART), key, _BIT)

#if defined UDR && !defined UDR0
#error "this chip is not supported: registers of its USART have no digit (UDR, not UDR0)"
#include CDS_AVR_CHECK_STOP
#elif !defined UDR0
#error "no chip with a USART is named: compile with -mmcu (pkg-config --cflags has it)"
#include CDS_AVR_CHECK_STOP
#elif CDS_AVR_CHECK_KNOWN(COUNT, BOARD_BUS_COUNT)
#else
#error "board.h: BOARD_BUS_COUNT is missing or not 1 to 3"
#include CDS_AVR_CHECK_STOP
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

#ifdef BOARD_HOST_USART
#if CDS_AVR_CHECK_IS_EMPTY(BOARD_HOST_USART)
#error "board.h: BOARD_HOST_USART has no value; write the number of a USART"
#include CDS_AVR_CHECK_STOP
#elif CDS_AVR_CHECK_KNOWN(USART, BOARD_HOST_USART)
#else
CDS_AVR_CHECK_ERROR(board.h: the host link has USART BOARD_HOST_USART, but __AVR_DEVICE_NAME__
                    has no USART of this number; is this the board.h of another chip?)
#include CDS_AVR_CHECK_STOP
#endif
#endif

#if defined BOARD_HOST_USART && !defined BOARD_HOST_BAUD
#error "board.h: BOARD_HOST_BAUD is missing; write the rate of the host link, as in 115200"
#include CDS_AVR_CHECK_STOP
#endif

/* At 16 MHz and with U2X the rate of a USART is 2000000 / divisor. */
#define CDS_AVR_CHECK_DIVISOR ((2000000 + BOARD_HOST_BAUD / 2) / BOARD_HOST_BAUD)
#if defined BOARD_HOST_USART && defined BOARD_HOST_BAUD
#if BOARD_HOST_BAUD > 0 && CDS_AVR_CHECK_DIVISOR >= 1 && CDS_AVR_CHECK_DIVISOR <= 4096 &&          \
    CDS_AVR_CHECK_DIVISOR * BOARD_HOST_BAUD * 97 <= 200000000 &&                                   \
    CDS_AVR_CHECK_DIVISOR * BOARD_HOST_BAUD * 103 >= 200000000
#else
CDS_AVR_CHECK_ERROR(board.h: the host link has the rate BOARD_HOST_BAUD; use a rate within 3 % of 2000000 / n bit/s,
                    n from 1 to 4096)
#include CDS_AVR_CHECK_STOP
#endif
#endif

#if defined BOARD_HOST_USART && (BOARD_HOST_USART == BOARD_BUS0_USART ||                           \
                                 (BOARD_BUS_COUNT > 1 && BOARD_HOST_USART == BOARD_BUS1_USART) ||  \
                                 (BOARD_BUS_COUNT > 2 && BOARD_HOST_USART == BOARD_BUS2_USART))
CDS_AVR_CHECK_ERROR(board.h: the host link and a bus have the same USART, BOARD_HOST_USART)
#include CDS_AVR_CHECK_STOP
#elif (BOARD_BUS_COUNT > 1 && BOARD_BUS1_USART == BOARD_BUS0_USART) ||                             \
    (BOARD_BUS_COUNT > 2 &&                                                                        \
     (BOARD_BUS2_USART == BOARD_BUS0_USART || BOARD_BUS2_USART == BOARD_BUS1_USART))
#error "board.h: two buses have the same USART"
#include CDS_AVR_CHECK_STOP
#endif

/* After the values: an enable of one bus is compared with the pins of all buses. */
#define CDS_AVR_CHECK_BUS 0
#include "cds55xx/avr/board_check_enables.h"
#if BOARD_BUS_COUNT > 1
#define CDS_AVR_CHECK_BUS 1
#include "cds55xx/avr/board_check_enables.h"
#endif
#if BOARD_BUS_COUNT > 2
#define CDS_AVR_CHECK_BUS 2
#include "cds55xx/avr/board_check_enables.h"
#endif

#if !defined BOARD_CLOCK_TIMER || CDS_AVR_CHECK_IS_EMPTY(BOARD_CLOCK_TIMER)
#error "board.h: BOARD_CLOCK_TIMER is missing; write the number of a 16-bit timer"
#include CDS_AVR_CHECK_STOP
#elif CDS_AVR_CHECK_KNOWN(TIMER, BOARD_CLOCK_TIMER)
#else
CDS_AVR_CHECK_ERROR(board.h: the clock has timer BOARD_CLOCK_TIMER, but __AVR_DEVICE_NAME__ has no
                    16-bit timer of this number; use CDS_AVR_CHECK_TIMERS)
#include CDS_AVR_CHECK_STOP
#endif

#if defined TIMSK && BOARD_CLOCK_TIMER != 1
CDS_AVR_CHECK_ERROR(board.h: the clock has timer BOARD_CLOCK_TIMER; on __AVR_DEVICE_NAME__ use 1)
#include CDS_AVR_CHECK_STOP
#endif

/* CDS_AVR_BUS(bus, number) pastes the wiring of bus `number` to CDS_AVR_HANDLERS_: one error if the
 * board does not have this bus. */
#if BOARD_BUS_COUNT < 2
#undef BOARD_BUS1_WIRING
#define BOARD_BUS1_WIRING NO_SUCH_BUS
#endif
#if BOARD_BUS_COUNT < 3
#undef BOARD_BUS2_WIRING
#define BOARD_BUS2_WIRING NO_SUCH_BUS
#endif
#define BOARD_BUS3_WIRING NO_SUCH_BUS
#define CDS_AVR_HANDLERS_NO_SUCH_BUS(object, number)                                               \
    CDS_AVR_CHECK_ERROR(board.h has no bus number for object: it has BOARD_BUS_COUNT of them,     \
                        and the first one is bus 0)
// clang-format on

#endif
