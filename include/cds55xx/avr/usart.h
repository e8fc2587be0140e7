/* SPDX-License-Identifier: MIT */
/* The bus USARTs of the board, as register constants, and the port's verbs as inline functions.
 *
 * Everything is always inlined: with a constant `port` each verb becomes the two to six stores it
 * means. Direction is changed by one whole store to UCSRnB, never by |=, and by sbi and cbi on the
 * enables, which no interrupt can tear, or with interrupts off.
 *
 * BOARD_BUSn_WIRING says how bus n hangs on its USART:
 *   TWO_ENABLES  a buffer each way, an enable for each (TX_ENABLE, RX_ENABLE); if nothing is said
 *   ONE_ENABLE   two buffers on one pin (ENABLE): high talks, low listens
 *   TIED         TXD and RXD joined to the wire. TXEN drives it: cleared behind the last byte, it
 *                lets go by itself at the end of the stop bit. The receiver stays on, since a reply
 *                without return delay begins in that very cycle, and a receiver turned on amid
 *                a byte of our own would hear nonsense. So each byte comes back, as an echo.
 *   ADAPTER      TXD and RXD go to a circuit that drives the wire while TXD has a frame, and lets
 *                RXD hear the others only. No enable; between packets TXD is an output and high, as
 *                an edge on it would be taken for a start bit.
 *   ADAPTER_ECHO the same, but RXD hears the wire always: each byte comes back, as of tied pins.
 */
#ifndef CDS_AVR_USART_H
#define CDS_AVR_USART_H

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>
#include <stdint.h>

#include "board.h"
#include "cds55xx/avr/board_check.h"
#include "cds55xx/port.h" // what is implemented here

#if F_CPU != 16000000
#error "the servos' rates, 2 Mbps / (n + 1), need F_CPU = 16 MHz: then UBRR is n, with no error"
#endif

/* Inlined wherever it is called; no copy is ever emitted. */
#define CDS_AVR_INLINE extern inline __attribute__((gnu_inline, always_inline))

/* Places a handler directly after the interrupt vectors: the linker scripts of avr-libc have the
 * section .trampolines there. The vector then reaches the handler by rjmp, which the linker option
 * --relax puts in place of jmp: saves 1 cycle. */
#define CDS_AVR_NEAR __attribute__((section(".trampolines")))

struct cds_avr_pin {
    volatile uint8_t *port, *ddr;
    uint8_t mask;
};

/* The registers and pins of one bus. All constants; never stands in memory. */
struct cds_avr_usart {
    volatile uint8_t *udr, *ucsra, *ucsrb, *ucsrc, *ubrrh, *ubrrl;
    struct cds_avr_pin rxd, txd;
    volatile uint8_t *rxd_level;             // PINx of rxd
    struct cds_avr_pin tx_enable, rx_enable; // of one enable, it is tx_enable
    uint8_t echoes;                          // not 0: RXD hears what TXD says
    uint8_t tied;                            // not 0: TXD is the wire, TXEN drives it
};

#define CDS_AVR_PASTE_(a, b)     a##b
#define CDS_AVR_PASTE(a, b)      CDS_AVR_PASTE_(a, b)
#define CDS_AVR_PASTE3_(a, b, c) a##b##c
#define CDS_AVR_PASTE3(a, b, c)  CDS_AVR_PASTE3_(a, b, c)

/* BOARD_BUS<bus>_<key> of board.h, and what it means to the chip. */
#define CDS_AVR_BOARD(bus, key) CDS_AVR_PASTE3(BOARD_BUS, bus, key)
#define CDS_AVR_BOARD_PIN(bus, key, end)                                                           \
    CDS_AVR_PASTE3(BOARD_BUS, bus, CDS_AVR_PASTE3_(_, key, end))
#define CDS_AVR_REGISTER(bus, name)  &CDS_AVR_PASTE(name, CDS_AVR_BOARD(bus, _USART))
#define CDS_AVR_REGISTER3(bus, a, b) &CDS_AVR_PASTE3(a, CDS_AVR_BOARD(bus, _USART), b)
#define CDS_AVR_PIN(bus, key)                                                                      \
    {                                                                                              \
        &CDS_AVR_PASTE(PORT, CDS_AVR_BOARD_PIN(bus, key, _PORT)),                                  \
            &CDS_AVR_PASTE(DDR, CDS_AVR_BOARD_PIN(bus, key, _PORT)),                               \
            (uint8_t)(1u << CDS_AVR_BOARD_PIN(bus, key, _BIT))                                     \
    }

#define CDS_AVR_NO_PIN                                                                             \
    {                                                                                              \
        0, 0, 0                                                                                    \
    }

#define CDS_AVR_LEVEL(bus, key) &CDS_AVR_PASTE(PIN, CDS_AVR_BOARD_PIN(bus, key, _PORT))

/* By wiring: the fields tx_enable, rx_enable, echoes and tied of struct cds_avr_usart. */
#define CDS_AVR_WIRING_TWO_ENABLES(bus)                                                            \
    CDS_AVR_PIN(bus, TX_ENABLE), CDS_AVR_PIN(bus, RX_ENABLE), 0, 0
#define CDS_AVR_WIRING_ONE_ENABLE(bus)   CDS_AVR_PIN(bus, ENABLE), CDS_AVR_NO_PIN, 0, 0
#define CDS_AVR_WIRING_TIED(bus)         CDS_AVR_NO_PIN, CDS_AVR_NO_PIN, 1, 1
#define CDS_AVR_WIRING_ADAPTER(bus)      CDS_AVR_NO_PIN, CDS_AVR_NO_PIN, 0, 0
#define CDS_AVR_WIRING_ADAPTER_ECHO(bus) CDS_AVR_NO_PIN, CDS_AVR_NO_PIN, 1, 0

/* The smallest return delay, register 0x05, whose replies a bus of each wiring hears beside a host
 * link at 1 Mbps: `return_delay_needed` of make bench. Tied pins turn around by themselves. What an
 * adapter needs is not known, so every value is allowed there. */
#define CDS_AVR_DELAY_TWO_ENABLES  1
#define CDS_AVR_DELAY_ONE_ENABLE   1
#define CDS_AVR_DELAY_TIED         0
#define CDS_AVR_DELAY_ADAPTER      0
#define CDS_AVR_DELAY_ADAPTER_ECHO 0

#define CDS_AVR_SHORTEST_DELAY(number) CDS_AVR_PASTE(CDS_AVR_DELAY_, CDS_AVR_BOARD(number, _WIRING))

/* In the order of struct cds_avr_usart, without names: C++ takes this header too. */
#define CDS_AVR_USART_OF(bus)                                                                      \
    {                                                                                              \
        CDS_AVR_REGISTER(bus, UDR), CDS_AVR_REGISTER3(bus, UCSR, A),                               \
            CDS_AVR_REGISTER3(bus, UCSR, B), CDS_AVR_REGISTER3(bus, UCSR, C),                      \
            CDS_AVR_REGISTER3(bus, UBRR, H), CDS_AVR_REGISTER3(bus, UBRR, L),                      \
            CDS_AVR_PIN(bus, RXD), CDS_AVR_PIN(bus, TXD), CDS_AVR_LEVEL(bus, RXD),                 \
            CDS_AVR_PASTE(CDS_AVR_WIRING_, CDS_AVR_BOARD(bus, _WIRING))(bus)                       \
    }

/* The bits of UCSRnA, B and C stand at the same places in every USART of every ATmega here. */
enum {
    CDS_AVR_TXC = 1 << 6,
    CDS_AVR_UDRE = 1 << 5,
    CDS_AVR_FRAMING_ERROR_BIT = 4,
    CDS_AVR_FRAMING_ERROR = 1 << CDS_AVR_FRAMING_ERROR_BIT,
    CDS_AVR_OVERRUN_BIT = 3,
    CDS_AVR_OVERRUN = 1 << CDS_AVR_OVERRUN_BIT,
    CDS_AVR_U2X = 1 << 1,
    CDS_AVR_EIGHT_BITS = 3 << 1,
    /* UCSRnB in each state of the link */
    CDS_AVR_STATE_HIGH_Z = 0,
    CDS_AVR_STATE_LISTENING = 1 << 7 | 1 << 4, // RXCIE, RXEN
    CDS_AVR_STATE_BEGINNING = 1 << 3,          // TXEN
    CDS_AVR_STATE_TALKING = 1 << 5 | 1 << 3,   // UDRIE, TXEN
    // TXCIE, TXEN; and RXEN, RXCIE: RX enable is still off, but the receiver needs no more once it
    // is on
    CDS_AVR_STATE_DRAINING = 1 << 6 | 1 << 3 | 1 << 4 | 1 << 7,
    /* UCSRnB of a bus with an echo: the receiver stays on. Its interrupt is off while the packet
       begins: the echo of the first byte waits in the receiver until cds_avr_usart_follow(). */
    CDS_AVR_STATE_ECHO_BEGINNING = 1 << 4 | 1 << 3,
    CDS_AVR_STATE_ECHO_TALKING = 1 << 7 | 1 << 4 | 1 << 5 | 1 << 3,
    /* UCSRnB of tied pins with the last byte: TXEN is off, so the driver lets go by itself after
       the stop bit */
    CDS_AVR_STATE_TIED_DRAINING = 1 << 7 | 1 << 4 | 1 << 6,
};

/* Sets the level of a pin. A pin that the wiring lacks (mask 0) takes no instruction, a pin that
 * the compiler knows one: sbi or cbi. On a board with several buses the pin may be known at run
 * time only. Then interrupts are off while the port is read and written: a handler may change the
 * enable of another bus in the same port. */
CDS_AVR_INLINE void cds_avr_pin_put(struct cds_avr_pin pin, bool high)
{
    bool known = __builtin_constant_p(pin.mask);
    uint8_t sreg = 0;

    if (!known) {
        sreg = SREG;
        cli();
    }
    if (pin.mask && high)
        *pin.port |= pin.mask;
    else if (pin.mask)
        *pin.port &= (uint8_t)~pin.mask;
    if (!known)
        SREG = sreg;
}

CDS_AVR_INLINE void cds_avr_pin_high(struct cds_avr_pin pin)
{
    cds_avr_pin_put(pin, true);
}

CDS_AVR_INLINE void cds_avr_pin_low(struct cds_avr_pin pin)
{
    cds_avr_pin_put(pin, false);
}

/* `port` is a bus of the board: 0 to BOARD_BUS_COUNT - 1. */
CDS_AVR_INLINE struct cds_avr_usart cds_avr_usart(uint8_t port)
{
    const struct cds_avr_usart first = CDS_AVR_USART_OF(0);
#if BOARD_BUS_COUNT > 1
    const struct cds_avr_usart second = CDS_AVR_USART_OF(1);
#endif
#if BOARD_BUS_COUNT > 2
    const struct cds_avr_usart third = CDS_AVR_USART_OF(2);

    if (port == 2)
        return third;
#endif
#if BOARD_BUS_COUNT > 1
    if (port == 1)
        return second;
#endif
    (void)port;
    return first;
}

CDS_AVR_INLINE void cds_avr_usart_high_z(uint8_t port)
{
    struct cds_avr_usart usart = cds_avr_usart(port);

    *usart.ucsrb = CDS_AVR_STATE_HIGH_Z; // first: no handler may find the enables half way
    cds_avr_pin_low(usart.tx_enable);
    cds_avr_pin_low(usart.rx_enable);
}

/* The driver lets go, and the receiver hears: an instruction for each enable, which uses no
 * register and no flag. Tied pins and adapters let go by themselves. */
CDS_AVR_INLINE void cds_avr_usart_turn_around(uint8_t port)
{
    struct cds_avr_usart usart = cds_avr_usart(port);

    cds_avr_pin_low(usart.tx_enable);
    cds_avr_pin_high(usart.rx_enable);
}

CDS_AVR_INLINE void cds_avr_usart_listen(uint8_t port)
{
    struct cds_avr_usart usart = cds_avr_usart(port);

    cds_avr_usart_turn_around(port);
    *usart.ucsrb = CDS_AVR_STATE_LISTENING;
}

CDS_AVR_INLINE uint8_t cds_avr_usart_talk(uint8_t port, uint8_t byte)
{
    struct cds_avr_usart usart = cds_avr_usart(port);

    *usart.ucsrb = CDS_AVR_STATE_HIGH_Z; // first: no handler may find the enables half way
    cds_avr_pin_low(usart.rx_enable);
    cds_avr_pin_high(usart.tx_enable);
    *usart.ucsrb = usart.echoes ? CDS_AVR_STATE_ECHO_BEGINNING : CDS_AVR_STATE_BEGINNING;
    *usart.udr = byte;
    if (!(*usart.ucsra & CDS_AVR_UDRE)) // not yet in the shift register
        return 1;
    *usart.udr = byte;
    return 2;
}

CDS_AVR_INLINE void cds_avr_usart_follow(uint8_t port)
{
    struct cds_avr_usart usart = cds_avr_usart(port);

    *usart.ucsrb = usart.echoes ? CDS_AVR_STATE_ECHO_TALKING : CDS_AVR_STATE_TALKING;
}

CDS_AVR_INLINE void cds_avr_usart_tx(uint8_t port, uint8_t byte)
{
    *cds_avr_usart(port).udr = byte;
}

CDS_AVR_INLINE void cds_avr_usart_tx_last(uint8_t port, uint8_t byte)
{
    struct cds_avr_usart usart = cds_avr_usart(port);

    *usart.udr = byte;
    *usart.ucsra = CDS_AVR_TXC | CDS_AVR_U2X; // an older TXC would fire at once
    *usart.ucsrb = usart.tied ? CDS_AVR_STATE_TIED_DRAINING : CDS_AVR_STATE_DRAINING;
}

/* Sets the rate; receiver and driver are off. */
CDS_AVR_INLINE void cds_avr_usart_open(uint8_t port, uint8_t baud)
{
    struct cds_avr_usart usart = cds_avr_usart(port);

    cds_avr_usart_high_z(port);
    *usart.ucsra = CDS_AVR_U2X;
    *usart.ucsrc = CDS_AVR_EIGHT_BITS;
    *usart.ubrrh = 0;
    *usart.ubrrl = baud;
}

CDS_AVR_INLINE bool cds_avr_usart_line_is_high(uint8_t port)
{
    struct cds_avr_usart usart = cds_avr_usart(port);

    return *usart.rxd_level & usart.rxd.mask;
}

CDS_AVR_INLINE void cds_avr_pin_output(struct cds_avr_pin pin)
{
    if (pin.mask)
        *pin.ddr |= pin.mask;
}

/* Makes the pins of a bus listen: the driver off, the receiver on. */
CDS_AVR_INLINE void cds_avr_usart_pins_listen(uint8_t port)
{
    struct cds_avr_usart usart = cds_avr_usart(port);

    cds_avr_pin_high(usart.rx_enable);
    cds_avr_pin_output(usart.rx_enable);
    cds_avr_pin_low(usart.tx_enable);
    cds_avr_pin_output(usart.tx_enable);
    cds_avr_pin_high(usart.rxd); // pull-up: RXD floats while the receive buffer is off
    cds_avr_pin_high(usart.txd); // an idle line is high, also while the transmitter is off
    if (!usart.tied)             // there an output would hold the servos' wire
        cds_avr_pin_output(usart.txd);
}

CDS_AVR_INLINE void cds_avr_usart_all_pins_listen(void)
{
    cds_avr_usart_pins_listen(0);
#if BOARD_BUS_COUNT > 1
    cds_avr_usart_pins_listen(1);
#endif
#if BOARD_BUS_COUNT > 2
    cds_avr_usart_pins_listen(2);
#endif
}

/* The verbs of port.h for all buses of the board, as functions that the library calls.
 *
 * cds_avr_pins_at_reset() runs before stack, .data and everything else: from the first instructions
 * after a reset the servos have the line. It consists only of sbi, cbi and, for TXD and RXD on high
 * ports, lds, ori and sts, so it needs no stack and no r1. */
#define CDS_AVR_USART_FUNCTIONS_                                                                   \
    void cds_port_open(uint8_t port, uint8_t baud)                                                 \
    {                                                                                              \
        cds_avr_usart_open(port, baud);                                                            \
    }                                                                                              \
    void cds_port_high_z(uint8_t port)                                                             \
    {                                                                                              \
        cds_avr_usart_high_z(port);                                                                \
    }                                                                                              \
    void cds_port_listen(uint8_t port)                                                             \
    {                                                                                              \
        cds_avr_usart_listen(port);                                                                \
    }                                                                                              \
    uint8_t cds_port_talk(uint8_t port, uint8_t byte)                                              \
    {                                                                                              \
        return cds_avr_usart_talk(port, byte);                                                     \
    }                                                                                              \
    void cds_port_follow(uint8_t port)                                                             \
    {                                                                                              \
        cds_avr_usart_follow(port);                                                                \
    }                                                                                              \
    bool cds_port_line_is_high(uint8_t port)                                                       \
    {                                                                                              \
        return cds_avr_usart_line_is_high(port);                                                   \
    }                                                                                              \
    void cds_port_tx(uint8_t port, uint8_t byte)                                                   \
    {                                                                                              \
        cds_avr_usart_tx(port, byte);                                                              \
    }                                                                                              \
    void cds_port_tx_last(uint8_t port, uint8_t byte)                                              \
    {                                                                                              \
        cds_avr_usart_tx_last(port, byte);                                                         \
    }                                                                                              \
    __attribute__((naked, used, section(".init1"))) void cds_avr_pins_at_reset(void)               \
    {                                                                                              \
        cds_avr_usart_all_pins_listen();                                                           \
    }

#endif
