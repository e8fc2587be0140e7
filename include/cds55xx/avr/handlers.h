/* SPDX-License-Identifier: MIT */
/* The three interrupt handlers of a bus, in assembly. Each does what the model in C of its event
 * does (link.h), for a link and registers that are constants. avr-gcc would save ten registers;
 * three suffice, and the handlers take half as long. At 1 Mbps the receive handler runs every 160
 * cycles.
 *
 * GCC supports only assembly in a naked function. The one exception here is
 * cds_avr_usart_turn_around(), which compiles to cbi and sbi. A handler saves r24, r30 and r31 on
 * the paths that use them. It saves SREG in r0 if it changes flags; lds, sts, ld, ldi, cpse and
 * sbrc change none. All fields that the handlers write are volatile in C.
 *
 * The comments give cycles, entry and reti included, for a program counter of two bytes and a
 * vector that reaches its handler by rjmp (CDS_AVR_NEAR).
 */
#ifndef CDS_AVR_HANDLERS_H
#define CDS_AVR_HANDLERS_H

#include <avr/interrupt.h>

#include "cds55xx/link.h"      // struct cds_link, the events
#include "cds55xx/avr/usart.h" // CDS_AVR_REGISTER, CDS_AVR_STATE_*, CDS_AVR_NEAR

// clang-format off

#define CDS_AVR_ENTER_                                                          \
    "push r0                  \n\t" "in   r0, __SREG__        \n\t"             \
    "push r31                 \n\t"

#define CDS_AVR_LEAVE_                                                          \
    "pop  r31                 \n\t" "out  __SREG__, r0        \n\t"             \
    "pop  r0                  \n\t" "reti                     \n\t"

#define CDS_AVR_COUNT_(counter)                                                 \
    "lds  r31, %[" counter "]   \n\t" "inc  r31              \n\t"              \
    "sts  %[" counter "], r31   \n\t"

/* The part of cds_link_on_rx_echo() before CDS_AVR_ON_RX_. Cycles of an echo: 56; damaged: 65. */
#define CDS_AVR_ECHO_                                                           \
    "lds  r31, %[state]       \n\t" "cpi  r31, %[listening]   \n\t"             \
    "breq 9f                  \n\t"                                             \
    "push r30                 \n\t" "push r24                 \n\t"             \
    "lds  r30, %[echo]        \n\t" "lds  r31, %[echo]+1      \n\t"             \
    "lds  r24, %[last]        \n\t" "inc  r24                 \n\t"             \
    "cp   r24, r30            \n\t" "breq 7f                  \n\t"             \
    "6: ld r24, Z+            \n\t"                                             \
    "sts  %[echo]+1, r31      \n\t" "sts  %[echo], r30        \n\t"             \
    "lds  r30, %[status]      \n\t" "andi r30, %[errors]      \n\t"             \
    "lds  r31, %[data]        \n\t" "eor  r24, r31            \n\t"             \
    "or   r24, r30            \n\t" "breq 8f                  \n\t"             \
    "lds  r30, %[echo_errors] \n\t" "lds  r31, %[echo_errors]+1\n\t"            \
    "adiw r30, 1              \n\t"                                             \
    "sts  %[echo_errors]+1, r31\n\t" "sts  %[echo_errors], r30\n\t"             \
    "8: pop r24               \n\t" "pop  r30                 \n\t"             \
    CDS_AVR_LEAVE_                                                              \
    "7: sbiw r30, 1           \n\t" "lds  r24, %[last]+1      \n\t"             \
    "cp   r24, r31            \n\t" "breq 8f                  \n\t"             \
    "adiw r30, 1              \n\t" "rjmp 6b                  \n\t"             \
    "8: pop r24               \n\t" "pop  r30                 \n\t"             \
    "9:                       \n\t"

/* cds_link_on_rx(). A good byte: 47, with `echo` 52. A damaged one: 50, with both errors 49. One that
 * finds the ring full: 49, after another damage 50. Interrupts are off, so no code reads
 * the ring between the store of the head and the store of the byte. After SREG is restored, r0 is
 * free and carries the byte.
 *
 * A damaged byte: cpi compares its error bits and sets the flags once. No instruction up to brlo and
 * brne changes the flags, so they choose the counter. */
#define CDS_AVR_ON_RX_(link, number, echo_part)                                 \
    __asm__ volatile(CDS_AVR_ENTER_ echo_part                                   \
    "lds  r31, %[status]      \n\t" "andi r31, %[errors]      \n\t"             \
    "brne 3f                  \n\t" "push r30                 \n\t"             \
    "lds  r30, %[head]        \n\t" "lds  r31, %[tail]        \n\t"             \
    "sub  r31, r30            \n\t" /* minus what the ring holds */             \
    "cpi  r31, %[full]        \n\t" "breq 1f                  \n\t"             \
    "mov  r31, r30            \n\t" "inc  r31                 \n\t"             \
    "sts  %[head], r31        \n\t"                                             \
    "andi r30, %[mask]        \n\t" "ldi  r31, 0              \n\t"             \
    "subi r30, lo8(-(%[bytes]))\n\t" "sbci r31, hi8(-(%[bytes]))\n\t"           \
    "out  __SREG__, r0        \n\t"                                             \
    "lds  r0, %[data]         \n\t" "st   Z, r0               \n\t"             \
    "pop  r30                 \n\t" "pop  r31                 \n\t"             \
    "pop  r0                  \n\t" "reti                     \n\t"             \
                                                                                \
    "1: lds r31, %[data]      \n\t" /* taken, and not stored */                 \
    "sts  %[whole_from], r30  \n\t"                                             \
    "lds  r31, %[broken]      \n\t" "sbrc r31, 0              \n\t"             \
    "rjmp 2f                  \n\t"                                             \
    "ldi  r31, %[for_room]    \n\t" "sts  %[broken], r31      \n\t"             \
    "sts  %[broken_at], r30   \n\t" "pop  r30                 \n\t"             \
    CDS_AVR_LEAVE_                                                              \
    "2:                       \n\t" CDS_AVR_COUNT_("overflows")                 \
    "pop  r30                 \n\t" CDS_AVR_LEAVE_                              \
                                                                                \
    "3: cpi r31, %[framing]   \n\t"                                             \
    "lds  r31, %[broken]      \n\t" "sbrc r31, 0              \n\t"             \
    "rjmp 5f                  \n\t"                                             \
    "ldi  r31, %[damaged]     \n\t" "sts  %[broken], r31      \n\t"             \
    "lds  r31, %[head]        \n\t" "sts  %[broken_at], r31   \n\t"             \
    "4: sts %[whole_from], r31\n\t"                                             \
    "lds  r31, %[data]        \n\t" /* taken, and not stored */                 \
    "brlo 6f                  \n\t" "brne 7f                  \n\t"             \
    CDS_AVR_COUNT_("framing_errors")                                            \
    "rjmp 8f                  \n\t"                                             \
    "5: lds r31, %[head]      \n\t" "rjmp 4b                  \n\t"             \
    "6:                       \n\t" CDS_AVR_COUNT_("overruns")                  \
    "rjmp 8f                  \n\t"                                             \
    "7:                       \n\t" CDS_AVR_COUNT_("both_errors")               \
    "8:                       \n\t" CDS_AVR_LEAVE_                              \
    :: [status] "i"(CDS_AVR_REGISTER3(number, UCSR, A)),                        \
       [data] "i"(CDS_AVR_REGISTER(number, UDR)),                               \
       [errors] "n"(CDS_AVR_FRAMING_ERROR | CDS_AVR_OVERRUN),                   \
       [framing] "n"(CDS_AVR_FRAMING_ERROR), /* an overrun is less, both are more */ \
       [full] "n"(256 - CDS_RING_SIZE), [mask] "n"(CDS_RING_SIZE - 1),          \
       [head] "i"(&(link).rx.head), [tail] "i"(&(link).rx.tail),                \
       [bytes] "i"(&(link).rx.bytes[0]), [overflows] "i"(&(link).ring_overflows), \
       [framing_errors] "i"(&(link).framing_errors),                            \
       [overruns] "i"(&(link).overruns), [both_errors] "i"(&(link).both_errors), \
       [broken] "i"(&(link).broken), [damaged] "n"(CDS_LINK_DAMAGED),           \
       [for_room] "n"(CDS_LINK_FULL), [broken_at] "i"(&(link).broken_at),       \
       [whole_from] "i"(&(link).whole_from),                                    \
       [state] "i"(&(link).state), [listening] "n"(CDS_LINK_LISTENING),         \
       [echo] "i"(&(link).echo), [last] "i"(&(link).last),                      \
       [echo_errors] "i"(&(link).echo_errors))

/* cds_link_on_tx_ready(). A byte: 39. The last one: 49. Packets may be longer than 256 bytes, so
 * equal low bytes of `cursor` and `last` do not yet mean the end. No flag is touched. */
#define CDS_AVR_ON_TX_READY_(link, number, drain_state)                         \
    __asm__ volatile(                                                           \
    "push r24                 \n\t" "push r30                 \n\t"             \
    "push r31                 \n\t"                                             \
    "lds  r30, %[cursor]      \n\t" "lds  r31, %[cursor]+1    \n\t"             \
    "lds  r24, %[last]        \n\t" "cpse r24, r30            \n\t"             \
    "rjmp 1f                  \n\t"                                             \
    "lds  r24, %[last]+1      \n\t" "cpse r24, r31            \n\t"             \
    "rjmp 1f                  \n\t"                                             \
    "ld   r24, Z              \n\t" "sts  %[data], r24        \n\t"             \
    "ldi  r24, %[forget]      \n\t" "sts  %[status], r24      \n\t"             \
    "ldi  r24, %[drain]       \n\t" "sts  %[control], r24     \n\t"             \
    "ldi  r24, %[draining]    \n\t" "sts  %[state], r24       \n\t"             \
    "rjmp 2f                  \n\t"                                             \
    "1: ld r24, Z+            \n\t" "sts  %[data], r24        \n\t"             \
    "sts  %[cursor]+1, r31    \n\t" "sts  %[cursor], r30      \n\t"             \
    "2: pop r31               \n\t" "pop  r30                 \n\t"             \
    "pop  r24                 \n\t" "reti                     \n\t"             \
    :: [data] "i"(CDS_AVR_REGISTER(number, UDR)),                               \
       [status] "i"(CDS_AVR_REGISTER3(number, UCSR, A)),                        \
       [control] "i"(CDS_AVR_REGISTER3(number, UCSR, B)),                       \
       [forget] "n"(CDS_AVR_TXC | CDS_AVR_U2X), [drain] "n"(drain_state),       \
       [draining] "n"(CDS_LINK_DRAINING), [cursor] "i"(&(link).cursor),         \
       [last] "i"(&(link).last), [state] "i"(&(link).state))

/* cds_link_on_tx_complete(), after cds_avr_usart_turn_around(), which runs before a register is saved.
 * Cycles of both: 24. */
#define CDS_AVR_ON_TX_COMPLETE_(link, number)                                   \
    __asm__ volatile("push r24\n\t"                                             \
    "ldi  r24, %[listen]      \n\t" "sts  %[control], r24     \n\t"             \
    "ldi  r24, %[listening]   \n\t" "sts  %[state], r24       \n\t"             \
    "pop  r24                 \n\t" "reti                     \n\t"             \
    :: [control] "i"(CDS_AVR_REGISTER3(number, UCSR, B)),                       \
       [listen] "n"(CDS_AVR_STATE_LISTENING), [listening] "n"(CDS_LINK_LISTENING), \
       [state] "i"(&(link).state))

// clang-format on

#ifdef USART_RX_vect // one USART only, without a number
#define CDS_AVR_VECTOR(usart, event) USART_##event##_vect
#else
#define CDS_AVR_VECTOR(usart, event) CDS_AVR_PASTE3(USART, usart, _##event##_vect)
#endif

/* By wiring: is there an echo, and what is UCSRnB with the last byte? */
#define CDS_AVR_HANDLERS_TWO_ENABLES(bus, number)                                                  \
    CDS_AVR_HANDLERS_(bus, number, "", CDS_AVR_STATE_DRAINING)
#define CDS_AVR_HANDLERS_ONE_ENABLE(bus, number)                                                   \
    CDS_AVR_HANDLERS_(bus, number, "", CDS_AVR_STATE_DRAINING)
#define CDS_AVR_HANDLERS_ADAPTER(bus, number)                                                      \
    CDS_AVR_HANDLERS_(bus, number, "", CDS_AVR_STATE_DRAINING)
#define CDS_AVR_HANDLERS_ADAPTER_ECHO(bus, number)                                                 \
    CDS_AVR_HANDLERS_(bus, number, CDS_AVR_ECHO_, CDS_AVR_STATE_DRAINING)
#define CDS_AVR_HANDLERS_TIED(bus, number)                                                         \
    CDS_AVR_HANDLERS_(bus, number, CDS_AVR_ECHO_, CDS_AVR_STATE_TIED_DRAINING)

#define CDS_AVR_HANDLERS_(bus, number, echo, drain)                                                \
    ISR(CDS_AVR_VECTOR(CDS_AVR_BOARD(number, _USART), RX), ISR_NAKED CDS_AVR_NEAR)                 \
    {                                                                                              \
        CDS_AVR_ON_RX_((bus).link, number, echo);                                                  \
    }                                                                                              \
    ISR(CDS_AVR_VECTOR(CDS_AVR_BOARD(number, _USART), UDRE), ISR_NAKED CDS_AVR_NEAR)               \
    {                                                                                              \
        CDS_AVR_ON_TX_READY_((bus).link, number, drain);                                           \
    }                                                                                              \
    ISR(CDS_AVR_VECTOR(CDS_AVR_BOARD(number, _USART), TX), ISR_NAKED CDS_AVR_NEAR)                 \
    {                                                                                              \
        cds_avr_usart_turn_around(number);                                                         \
        CDS_AVR_ON_TX_COMPLETE_((bus).link, number);                                               \
    }

#endif
