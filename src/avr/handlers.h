/* The three handlers of a bus, by hand: what link.h says of its events, for a link and registers
 * that are constants. avr-gcc saves ten registers where three do, and at 1 Mbps the receive handler
 * runs every 160 cycles: these take half as long.
 *
 * GCC promises naked functions for assembly only: nothing else stands in them but cbi and sbi on
 * the enables. SREG is kept in r0; r24 and Z do the work. Whatever they write is volatile in C.
 * Cycles stand with each, entry and reti counted, for a program counter of two bytes.
 */
#ifndef AVR_HANDLERS_H
#define AVR_HANDLERS_H

#include <avr/interrupt.h>

#include "cds55xx/link.h" // struct cds_link, the events
#include "usart.h"        // AVR_REGISTER, AVR_STATE_*

// clang-format off

#define AVR_ENTER_                                                              \
    "push r0                  \n\t" "in   r0, __SREG__        \n\t"             \
    "push r24                 \n\t" "push r30                 \n\t"             \
    "push r31                 \n\t"

#define AVR_LEAVE_                                                              \
    "pop  r31                 \n\t" "pop  r30                 \n\t"             \
    "pop  r24                 \n\t" "out  __SREG__, r0        \n\t"             \
    "pop  r0                  \n\t" "reti                     \n\t"

#define AVR_COUNT_(counter)                                                     \
    "lds  r30, %[" counter "]   \n\t" "lds  r31, %[" counter "]+1 \n\t"             \
    "adiw r30, 1              \n\t"                                             \
    "sts  %[" counter "]+1, r31 \n\t" "sts  %[" counter "], r30   \n\t"

/* cds_link_on_rx_echo(), before what it has in common with the next. An echo: 60; a damaged one: 71. */
#define AVR_ECHO_                                                               \
    "lds  r24, %[state]       \n\t" "cpi  r24, %[listening]   \n\t"             \
    "breq 9f                  \n\t"                                             \
    "lds  r30, %[echo]        \n\t" "lds  r31, %[echo]+1      \n\t"             \
    "lds  r24, %[last]        \n\t" "inc  r24                 \n\t"             \
    "cp   r24, r30            \n\t" "breq 7f                  \n\t"             \
    "6: ld r24, Z+            \n\t"                                             \
    "sts  %[echo]+1, r31      \n\t" "sts  %[echo], r30        \n\t"             \
    "lds  r30, %[status]      \n\t" "andi r30, %[errors]      \n\t"             \
    "lds  r31, %[data]        \n\t" "eor  r24, r31            \n\t"             \
    "or   r24, r30            \n\t" "brne 8f                  \n\t"             \
    AVR_LEAVE_                                                                  \
    "7: sbiw r30, 1           \n\t" "lds  r24, %[last]+1      \n\t"             \
    "cp   r24, r31            \n\t" "breq 9f                  \n\t"             \
    "adiw r30, 1              \n\t" "rjmp 6b                  \n\t"             \
    "8:                       \n\t" AVR_COUNT_("echo_errors")                   \
    "rjmp 1f                  \n\t"                                             \
    "9:                       \n\t"

/* cds_link_on_rx(). A good byte: 54, with `echo` 59. The worst, with both errors: 82. */
#define AVR_ON_RX_(link, number, echo_part)                                     \
    __asm__ volatile(AVR_ENTER_ echo_part                                       \
    "lds  r24, %[status]      \n\t" "andi r24, %[errors]      \n\t"             \
    "brne 3f                  \n\t"                                             \
    "lds  r30, %[head]        \n\t" "lds  r24, %[tail]        \n\t"             \
    "sub  r24, r30            \n\t" /* minus what the ring holds */             \
    "cpi  r24, %[full]        \n\t" "breq 2f                  \n\t"             \
    "andi r30, %[mask]        \n\t" "ldi  r31, 0              \n\t"             \
    "subi r30, lo8(-(%[bytes]))\n\t" "sbci r31, hi8(-(%[bytes]))\n\t"           \
    "lds  r24, %[data]        \n\t" "st   Z, r24              \n\t"             \
    "lds  r24, %[head]        \n\t" "inc  r24                 \n\t"             \
    "sts  %[head], r24        \n\t" /* behind the byte it vouches for */        \
    "1:                       \n\t" AVR_LEAVE_                                  \
    "2:                       \n\t" AVR_COUNT_("overflows")                     \
    "rjmp 5f                  \n\t"                                             \
    "3: sbrs r24, %[framing]  \n\t" "rjmp 4f                  \n\t"             \
    AVR_COUNT_("framing_errors")                                                \
    "sbrs r24, %[overrun]     \n\t" "rjmp 5f                  \n\t"             \
    "4:                       \n\t" AVR_COUNT_("overruns")                      \
    "5: lds r24, %[data]      \n\t" /* taken, and not stored */                 \
    "lds  r30, %[head]        \n\t" "lds  r24, %[broken]      \n\t"             \
    "sbrs r24, 0              \n\t" "sts  %[broken_at], r30   \n\t"             \
    "ldi  r24, 1              \n\t" "sts  %[broken], r24      \n\t"             \
    "sts  %[whole_from], r30  \n\t" "rjmp 1b                  \n\t"             \
    :: [status] "n"(AVR_REGISTER3(number, UCSR, A)),                            \
       [data] "n"(AVR_REGISTER(number, UDR)),                                   \
       [errors] "n"(AVR_FRAMING_ERROR | AVR_OVERRUN),                           \
       [framing] "n"(AVR_FRAMING_ERROR_BIT), [overrun] "n"(AVR_OVERRUN_BIT),    \
       [full] "n"(256 - CDS_RING_SIZE), [mask] "n"(CDS_RING_SIZE - 1),          \
       [head] "i"(&(link).rx.head), [tail] "i"(&(link).rx.tail),                \
       [bytes] "i"(&(link).rx.bytes[0]), [overflows] "i"(&(link).ring_overflows), \
       [framing_errors] "i"(&(link).framing_errors),                            \
       [overruns] "i"(&(link).overruns), [broken] "i"(&(link).broken),          \
       [broken_at] "i"(&(link).broken_at), [whole_from] "i"(&(link).whole_from), \
       [state] "i"(&(link).state), [listening] "n"(CDS_LINK_LISTENING),         \
       [echo] "i"(&(link).echo), [last] "i"(&(link).last),                      \
       [echo_errors] "i"(&(link).echo_errors))

/* cds_link_on_tx_ready(). A byte: 47. The last one: 60. Packets may be longer than 256 bytes, so
 * equal low bytes of `cursor` and `last` do not yet mean the end. */
#define AVR_ON_TX_READY_(link, number, drain_state)                             \
    __asm__ volatile(AVR_ENTER_                                                 \
    "lds  r30, %[cursor]      \n\t" "lds  r31, %[cursor]+1    \n\t"             \
    "lds  r24, %[last]        \n\t" "cp   r24, r30            \n\t"             \
    "ld   r24, Z+             \n\t" "sts  %[data], r24        \n\t"             \
    "breq 2f                  \n\t"                                             \
    "1: sts %[cursor]+1, r31  \n\t" "sts  %[cursor], r30      \n\t"             \
    AVR_LEAVE_                                                                  \
    "2: lds r24, %[last]+1    \n\t" "sbiw r30, 1              \n\t"             \
    "cpse r24, r31            \n\t" "rjmp 3f                  \n\t"             \
    "ldi  r24, %[forget]      \n\t" "sts  %[status], r24      \n\t"             \
    "ldi  r24, %[drain]       \n\t" "sts  %[control], r24     \n\t"             \
    "ldi  r24, %[draining]    \n\t" "sts  %[state], r24       \n\t"             \
    AVR_LEAVE_                                                                  \
    "3: adiw r30, 1           \n\t" "rjmp 1b                  \n\t"             \
    :: [data] "n"(AVR_REGISTER(number, UDR)),                                   \
       [status] "n"(AVR_REGISTER3(number, UCSR, A)),                            \
       [control] "n"(AVR_REGISTER3(number, UCSR, B)),                           \
       [forget] "n"(AVR_TXC | AVR_U2X), [drain] "n"(drain_state),               \
       [draining] "n"(CDS_LINK_DRAINING), [cursor] "i"(&(link).cursor),         \
       [last] "i"(&(link).last), [state] "i"(&(link).state))

/* cds_link_on_tx_complete(), behind the enables, which were turned before anything was saved: 28 in
 * all. ldi and sts touch no flag. */
#define AVR_ON_TX_COMPLETE_(link, number)                                       \
    __asm__ volatile("push r24\n\t"                                             \
    "ldi  r24, %[listen]      \n\t" "sts  %[control], r24     \n\t"             \
    "ldi  r24, %[listening]   \n\t" "sts  %[state], r24       \n\t"             \
    "pop  r24                 \n\t" "reti                     \n\t"             \
    :: [control] "n"(AVR_REGISTER3(number, UCSR, B)),                           \
       [listen] "n"(AVR_STATE_LISTENING), [listening] "n"(CDS_LINK_LISTENING),  \
       [state] "i"(&(link).state))

// clang-format on

#ifdef USART_RX_vect // one USART only, without a number
#define AVR_VECTOR(usart, event) USART_##event##_vect
#else
#define AVR_VECTOR(usart, event) AVR_PASTE3(USART, usart, _##event##_vect)
#endif

/* By wiring: is there an echo, and what is UCSRnB with the last byte? */
#define AVR_HANDLERS_TWO_ENABLES(bus, number) AVR_HANDLERS_(bus, number, "", AVR_STATE_DRAINING)
#define AVR_HANDLERS_ONE_ENABLE(bus, number)  AVR_HANDLERS_(bus, number, "", AVR_STATE_DRAINING)
#define AVR_HANDLERS_ADAPTER(bus, number)     AVR_HANDLERS_(bus, number, "", AVR_STATE_DRAINING)
#define AVR_HANDLERS_ADAPTER_ECHO(bus, number)                                                     \
    AVR_HANDLERS_(bus, number, AVR_ECHO_, AVR_STATE_DRAINING)
#define AVR_HANDLERS_TIED(bus, number)                                                             \
    AVR_HANDLERS_(bus, number, AVR_ECHO_, AVR_STATE_TIED_DRAINING)

#define AVR_HANDLERS_(bus, number, echo, drain)                                                    \
    ISR(AVR_VECTOR(AVR_BUS(number, _USART), RX), ISR_NAKED)                                        \
    {                                                                                              \
        AVR_ON_RX_((bus).link, number, echo);                                                      \
    }                                                                                              \
    ISR(AVR_VECTOR(AVR_BUS(number, _USART), UDRE), ISR_NAKED)                                      \
    {                                                                                              \
        AVR_ON_TX_READY_((bus).link, number, drain);                                               \
    }                                                                                              \
    ISR(AVR_VECTOR(AVR_BUS(number, _USART), TX), ISR_NAKED)                                        \
    {                                                                                              \
        avr_usart_turn_around(number);                                                             \
        AVR_ON_TX_COMPLETE_((bus).link, number);                                                   \
    }

#endif
