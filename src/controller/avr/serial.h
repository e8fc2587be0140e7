/* SPDX-License-Identifier: MIT */
/* The controller's serial port to the PC: full duplex, 8N1, a ring for each direction.
 *
 * When the PC sends more than the ring holds, or a byte comes damaged, the receive handler turns
 * its interrupt off until the main loop has called serial_resume_after_gap(). So a gap is always at
 * the end of the bytes in the ring, and a flood takes only as much CPU time as the main loop gives
 * it.
 */
#ifndef AVR_SERIAL_H
#define AVR_SERIAL_H

#include <avr/interrupt.h>
#include <stdbool.h>
#include <stdint.h>

#include "board.h"
#include "cds55xx/ring.h"      // struct cds_ring
#include "cds55xx/avr/usart.h" // CDS_AVR_PASTE, CDS_AVR_U2X

#if !defined BOARD_HOST_USART || !defined BOARD_HOST_BAUD
#error "the console wants BOARD_HOST_USART and _BAUD in board.h; or name a FIRMWARE in board.mk"
#endif

struct serial {
    struct cds_ring rx;
    struct cds_ring tx;
    volatile uint8_t broken; // 1: bytes were lost; the handler takes no byte until it is cleared
    volatile uint16_t gaps;  // times that bytes were lost, modulo 65536
};

#define SERIAL_REGISTER_(a, b) CDS_AVR_PASTE3(a, BOARD_HOST_USART, b)
#define SERIAL_DATA            CDS_AVR_PASTE(UDR, BOARD_HOST_USART)
#define SERIAL_STATUS          SERIAL_REGISTER_(UCSR, A)
#define SERIAL_CONTROL         SERIAL_REGISTER_(UCSR, B)

enum {
    SERIAL_QUIET = 1 << 4 | 1 << 3,        // RXEN and TXEN, no interrupt
    SERIAL_IDLE = SERIAL_QUIET | 1 << 7,   // and RXCIE
    SERIAL_DEAF = UINT8_MAX & ~(1 << 7),   // mask: all but RXCIE
    SERIAL_SENDING = SERIAL_IDLE | 1 << 5, // and UDRIE
};

/* UBRR with U2X for the rate nearest to `baud`. At 16 MHz 115200 is 2.1 % off, as on every Arduino.
 */
#define SERIAL_DIVISOR(baud) ((uint16_t)((F_CPU + 4UL * (baud)) / (8UL * (baud)) - 1))

/* Opens the port at F_CPU / 8 / (divisor + 1) bit/s, SERIAL_DIVISOR(BOARD_HOST_BAUD) for the
 * board's own rate. Both rings are emptied, `gaps` stays. Main context. */
void serial_open(struct serial *serial, uint16_t divisor);

/* Starts to send the bytes in tx. Main context, after bytes were put there. */
void serial_send(struct serial *serial);

/* After bytes were lost: once the main loop has taken all bytes before the gap, drops the bytes
 * that came right after it, restarts reception, and returns true. Else returns false and does
 * nothing. Main context. */
bool serial_resume_after_gap(struct serial *serial);

// clang-format off

/* Uses `out` where it reaches the register: saves a cycle. */
#define SERIAL_CONTROL_IS_R24_                                                  \
    ".if %[control] < 0x60    \n\t" "out %[control]-0x20, r24 \n\t"             \
    ".else                    \n\t" "sts  %[control], r24     \n\t"             \
    ".endif                   \n\t"

/* The turnaround of the bus must not wait for the host. So each handler first turns its own
 * interrupts off by one store to UCSRnB and enables all others. At its end it turns its own
 * interrupts on again, the one for sending only if there is more to send. sei takes effect after the
 * next instruction. cli at the end changes no other flag; without it the handlers of a host that
 * sends without a pause would nest until the stack is full. Other interrupts are off for 12 cycles at
 * the beginning and 9 at the end, 1 less each where `out` reaches UCSRnB, and the two handlers may
 * run one after the other. `make bench` measures as return_delay_needed which return delay servos
 * need while the host floods the link at 1 Mbps. In assembly for the reasons in handlers.h. */
#define SERIAL_ENTER_                                                           \
    "push r24                 \n\t" "ldi  r24, %[quiet]       \n\t"             \
    "sei                      \n\t" SERIAL_CONTROL_IS_R24_                      \
    "push r0                  \n\t" "in   r0, __SREG__        \n\t"             \
    "push r30                 \n\t" "push r31                 \n\t"

#define SERIAL_LEAVE_                                                           \
    "lds  r30, %[tx_head]     \n\t" "lds  r24, %[tx_tail]     \n\t"             \
    "cp   r30, r24            \n\t" "ldi  r24, %[sending]     \n\t"             \
    "brne 9f                  \n\t" "ldi  r24, %[idle]        \n\t"             \
    "9: lds r30, %[broken]    \n\t" "sbrc r30, 0              \n\t"             \
    "andi r24, %[deaf]        \n\t"                                             \
    "pop  r31                 \n\t" "pop  r30                 \n\t"             \
    "out  __SREG__, r0        \n\t" "pop  r0                  \n\t"             \
    "cli                      \n\t" SERIAL_CONTROL_IS_R24_                      \
    "pop  r24                 \n\t" "reti                     \n\t"

#define SERIAL_OPERANDS_(serial)                                                \
    [control] "n"(&SERIAL_CONTROL), [data] "n"(&SERIAL_DATA),                   \
    [quiet] "n"(SERIAL_QUIET), [idle] "n"(SERIAL_IDLE),                         \
    [sending] "n"(SERIAL_SENDING), [deaf] "n"(SERIAL_DEAF),                     \
    [broken] "i"(&(serial).broken), [mask] "n"(CDS_RING_SIZE - 1),              \
    [tx_head] "i"(&(serial).tx.head), [tx_tail] "i"(&(serial).tx.tail)

/* A byte came. Its status is read first, since reading the byte clears it. */
#define SERIAL_ON_RX_(serial)                                                   \
    __asm__ volatile(SERIAL_ENTER_                                              \
    "lds  r24, %[status]      \n\t" "andi r24, %[errors]      \n\t"             \
    "lds  r30, %[broken]      \n\t" "or   r24, r30            \n\t"             \
    "brne 2f                  \n\t"                                             \
    "lds  r30, %[head]        \n\t" "lds  r24, %[tail]        \n\t"             \
    "sub  r24, r30            \n\t" "cpi  r24, %[full]        \n\t"             \
    "breq 2f                  \n\t"                                             \
    "andi r30, %[mask]        \n\t" "ldi  r31, 0              \n\t"             \
    "subi r30, lo8(-(%[bytes]))\n\t" "sbci r31, hi8(-(%[bytes]))\n\t"           \
    "lds  r24, %[data]        \n\t" "st   Z, r24              \n\t"             \
    "lds  r24, %[head]        \n\t" "inc  r24                 \n\t"             \
    "sts  %[head], r24        \n\t"                                             \
    "1:                       \n\t" SERIAL_LEAVE_                               \
    "2: lds r24, %[data]      \n\t" /* read, but not stored */                  \
    "lds  r24, %[broken]      \n\t" "sbrc r24, 0              \n\t"             \
    "rjmp 1b                  \n\t"                                             \
    "ldi  r24, 1              \n\t" "sts  %[broken], r24      \n\t"             \
    "lds  r30, %[gaps]        \n\t" "lds  r31, %[gaps]+1      \n\t"             \
    "adiw r30, 1              \n\t" "sts  %[gaps]+1, r31      \n\t"             \
    "sts  %[gaps], r30        \n\t" "rjmp 1b                  \n\t"             \
    :: SERIAL_OPERANDS_(serial), [status] "n"(&SERIAL_STATUS),                  \
       [errors] "n"(CDS_AVR_FRAMING_ERROR | CDS_AVR_OVERRUN),                   \
       [full] "n"(256 - CDS_RING_SIZE), [head] "i"(&(serial).rx.head),          \
       [tail] "i"(&(serial).rx.tail), [bytes] "i"(&(serial).rx.bytes[0]),       \
       [gaps] "i"(&(serial).gaps))

/* The transmitter can take a byte. */
#define SERIAL_ON_TX_READY_(serial)                                             \
    __asm__ volatile(SERIAL_ENTER_                                              \
    "lds  r30, %[tx_tail]     \n\t" "lds  r24, %[tx_head]     \n\t"             \
    "cp   r24, r30            \n\t" "breq 1f                  \n\t"             \
    "mov  r24, r30            \n\t" "andi r30, %[mask]        \n\t"             \
    "ldi  r31, 0              \n\t"                                             \
    "subi r30, lo8(-(%[bytes]))\n\t" "sbci r31, hi8(-(%[bytes]))\n\t"           \
    "ld   r30, Z              \n\t" "sts  %[data], r30        \n\t"             \
    "inc  r24                 \n\t" "sts  %[tx_tail], r24     \n\t"             \
    "1:                       \n\t" SERIAL_LEAVE_                               \
    :: SERIAL_OPERANDS_(serial), [bytes] "i"(&(serial).tx.bytes[0]))

// clang-format on

/* Binds the board's BOARD_HOST_USART to `serial`, a struct serial with static storage. */
#define AVR_SERIAL(serial)                                                                         \
    ISR(CDS_AVR_PASTE3(USART, BOARD_HOST_USART, _RX_vect), ISR_NAKED CDS_AVR_NEAR)                 \
    {                                                                                              \
        SERIAL_ON_RX_(serial);                                                                     \
    }                                                                                              \
    ISR(CDS_AVR_PASTE3(USART, BOARD_HOST_USART, _UDRE_vect), ISR_NAKED CDS_AVR_NEAR)               \
    {                                                                                              \
        SERIAL_ON_TX_READY_(serial);                                                               \
    }

#endif
