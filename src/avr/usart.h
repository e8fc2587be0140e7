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
#ifndef AVR_USART_H
#define AVR_USART_H

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>
#include <stdint.h>

#include "board.h"
#include "board_check.h"

/* Inlined wherever it is called; no copy is ever emitted. */
#define AVR_INLINE extern inline __attribute__((gnu_inline, always_inline))

/* Places a handler directly after the interrupt vectors: the linker scripts of avr-libc have the
 * section .trampolines there. The vector then reaches the handler by rjmp, which the linker option
 * --relax puts in place of jmp: saves 1 cycle. */
#define AVR_NEAR __attribute__((section(".trampolines")))

struct avr_pin {
    volatile uint8_t *port, *ddr;
    uint8_t mask;
};

/* The registers and pins of one bus. All constants; never stands in memory. */
struct avr_usart {
    volatile uint8_t *udr, *ucsra, *ucsrb, *ucsrc, *ubrrh, *ubrrl;
    struct avr_pin rxd, txd, tx_enable, rx_enable; // of one enable, it is tx_enable
    volatile uint8_t *rxd_level;                   // PINx of rxd
    uint8_t echoes;                                // not 0: RXD hears what TXD says
    uint8_t tied;                                  // not 0: TXD is the wire, TXEN drives it
};

#define AVR_PASTE_(a, b)     a##b
#define AVR_PASTE(a, b)      AVR_PASTE_(a, b)
#define AVR_PASTE3_(a, b, c) a##b##c
#define AVR_PASTE3(a, b, c)  AVR_PASTE3_(a, b, c)

/* BOARD_BUS<bus>_<key> of board.h, and what it means to the chip. */
#define AVR_BUS(bus, key)          AVR_PASTE3(BOARD_BUS, bus, key)
#define AVR_BUS_PIN(bus, key, end) AVR_PASTE3(BOARD_BUS, bus, AVR_PASTE3_(_, key, end))
#define AVR_REGISTER(bus, name)    &AVR_PASTE(name, AVR_BUS(bus, _USART))
#define AVR_REGISTER3(bus, a, b)   &AVR_PASTE3(a, AVR_BUS(bus, _USART), b)
#define AVR_PIN(bus, key)                                                                          \
    {                                                                                              \
        &AVR_PASTE(PORT, AVR_BUS_PIN(bus, key, _PORT)),                                            \
            &AVR_PASTE(DDR, AVR_BUS_PIN(bus, key, _PORT)),                                         \
            (uint8_t)(1u << AVR_BUS_PIN(bus, key, _BIT))                                           \
    }

#define AVR_NO_PIN                                                                                 \
    {                                                                                              \
        0, 0, 0                                                                                    \
    }

#define AVR_LEVEL(bus, key) &AVR_PASTE(PIN, AVR_BUS_PIN(bus, key, _PORT))

/* By wiring: the fields tx_enable and rx_enable of struct avr_usart. */
#define AVR_WIRING_TWO_ENABLES(bus)  AVR_PIN(bus, TX_ENABLE), AVR_PIN(bus, RX_ENABLE)
#define AVR_WIRING_ONE_ENABLE(bus)   AVR_PIN(bus, ENABLE), AVR_NO_PIN
#define AVR_WIRING_TIED(bus)         AVR_NO_PIN, AVR_NO_PIN
#define AVR_WIRING_ADAPTER(bus)      AVR_NO_PIN, AVR_NO_PIN
#define AVR_WIRING_ADAPTER_ECHO(bus) AVR_NO_PIN, AVR_NO_PIN

/* The smallest return delay, register 0x05, whose replies a bus of each wiring hears beside a host
 * link at 1 Mbps: `return_delay_needed` of make bench. Tied pins turn around by themselves. What an
 * adapter needs is not known, so every value is allowed there. */
#define AVR_DELAY_TWO_ENABLES  1
#define AVR_DELAY_ONE_ENABLE   1
#define AVR_DELAY_TIED         0
#define AVR_DELAY_ADAPTER      0
#define AVR_DELAY_ADAPTER_ECHO 0

#define AVR_SHORTEST_DELAY(number) AVR_PASTE(AVR_DELAY_, AVR_BUS(number, _WIRING))

/* By wiring: the fields `echoes` and `tied` of struct avr_usart. */
#define AVR_NATURE_TWO_ENABLES  0, 0
#define AVR_NATURE_ONE_ENABLE   0, 0
#define AVR_NATURE_TIED         1, 1
#define AVR_NATURE_ADAPTER      0, 0
#define AVR_NATURE_ADAPTER_ECHO 1, 0

/* In the order of struct avr_usart, without names: C++ takes this header too. */
#define AVR_USART_OF(bus)                                                                          \
    {                                                                                              \
        AVR_REGISTER(bus, UDR), AVR_REGISTER3(bus, UCSR, A), AVR_REGISTER3(bus, UCSR, B),          \
            AVR_REGISTER3(bus, UCSR, C), AVR_REGISTER3(bus, UBRR, H), AVR_REGISTER3(bus, UBRR, L), \
            AVR_PIN(bus, RXD), AVR_PIN(bus, TXD),                                                  \
            AVR_PASTE(AVR_WIRING_, AVR_BUS(bus, _WIRING))(bus), AVR_LEVEL(bus, RXD),               \
            AVR_PASTE(AVR_NATURE_, AVR_BUS(bus, _WIRING))                                          \
    }

/* The bits of UCSRnA, B and C stand at the same places in every USART of every ATmega here. */
enum {
    AVR_TXC = 1 << 6,
    AVR_UDRE = 1 << 5,
    AVR_FRAMING_ERROR_BIT = 4,
    AVR_FRAMING_ERROR = 1 << AVR_FRAMING_ERROR_BIT,
    AVR_OVERRUN_BIT = 3,
    AVR_OVERRUN = 1 << AVR_OVERRUN_BIT,
    AVR_U2X = 1 << 1,
    AVR_EIGHT_BITS = 3 << 1,
    /* UCSRnB in each state of the link */
    AVR_STATE_HIGH_Z = 0,
    AVR_STATE_LISTENING = 1 << 7 | 1 << 4, // RXCIE, RXEN
    AVR_STATE_BEGINNING = 1 << 3,          // TXEN
    AVR_STATE_TALKING = 1 << 5 | 1 << 3,   // UDRIE, TXEN
    // TXCIE, TXEN; and RXEN, RXCIE: RX enable is still off, but the receiver needs no more once it
    // is on
    AVR_STATE_DRAINING = 1 << 6 | 1 << 3 | 1 << 4 | 1 << 7,
    /* UCSRnB of a bus with an echo: the receiver stays on. Its interrupt is off while the packet
       begins: the echo of the first byte waits in the receiver until avr_usart_follow(). */
    AVR_STATE_ECHO_BEGINNING = 1 << 4 | 1 << 3,
    AVR_STATE_ECHO_TALKING = 1 << 7 | 1 << 4 | 1 << 5 | 1 << 3,
    /* UCSRnB of tied pins with the last byte: TXEN is off, so the driver lets go by itself after
       the stop bit */
    AVR_STATE_TIED_DRAINING = 1 << 7 | 1 << 4 | 1 << 6,
};

/* Sets the level of a pin. A pin that the wiring lacks (mask 0) takes no instruction, a pin that
 * the compiler knows one: sbi or cbi. On a board with several buses the pin may be known at run
 * time only. Then interrupts are off while the port is read and written: a handler may change the
 * enable of another bus in the same port. */
AVR_INLINE void avr_pin_put(struct avr_pin pin, bool high)
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

AVR_INLINE void avr_pin_high(struct avr_pin pin)
{
    avr_pin_put(pin, true);
}

AVR_INLINE void avr_pin_low(struct avr_pin pin)
{
    avr_pin_put(pin, false);
}

/* `port` is a bus of the board: 0 to BOARD_BUS_COUNT - 1. */
AVR_INLINE struct avr_usart avr_usart(uint8_t port)
{
    const struct avr_usart first = AVR_USART_OF(0);
#if BOARD_BUS_COUNT > 1
    const struct avr_usart second = AVR_USART_OF(1);
#endif
#if BOARD_BUS_COUNT > 2
    const struct avr_usart third = AVR_USART_OF(2);

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

AVR_INLINE void avr_usart_high_z(uint8_t port)
{
    struct avr_usart usart = avr_usart(port);

    *usart.ucsrb = AVR_STATE_HIGH_Z; // first: no handler may find the enables half way
    avr_pin_low(usart.tx_enable);
    avr_pin_low(usart.rx_enable);
}

/* The driver lets go, and the receiver hears: an instruction for each enable, which uses no
 * register and no flag. Tied pins and adapters let go by themselves. */
AVR_INLINE void avr_usart_turn_around(uint8_t port)
{
    struct avr_usart usart = avr_usart(port);

    avr_pin_low(usart.tx_enable);
    avr_pin_high(usart.rx_enable);
}

AVR_INLINE void avr_usart_listen(uint8_t port)
{
    struct avr_usart usart = avr_usart(port);

    avr_usart_turn_around(port);
    *usart.ucsrb = AVR_STATE_LISTENING;
}

AVR_INLINE uint8_t avr_usart_talk(uint8_t port, uint8_t byte)
{
    struct avr_usart usart = avr_usart(port);

    *usart.ucsrb = AVR_STATE_HIGH_Z; // first: no handler may find the enables half way
    avr_pin_low(usart.rx_enable);
    avr_pin_high(usart.tx_enable);
    *usart.ucsrb = usart.echoes ? AVR_STATE_ECHO_BEGINNING : AVR_STATE_BEGINNING;
    *usart.udr = byte;
    if (!(*usart.ucsra & AVR_UDRE)) // not yet in the shift register
        return 1;
    *usart.udr = byte;
    return 2;
}

AVR_INLINE void avr_usart_follow(uint8_t port)
{
    struct avr_usart usart = avr_usart(port);

    *usart.ucsrb = usart.echoes ? AVR_STATE_ECHO_TALKING : AVR_STATE_TALKING;
}

AVR_INLINE void avr_usart_tx(uint8_t port, uint8_t byte)
{
    *avr_usart(port).udr = byte;
}

AVR_INLINE void avr_usart_tx_last(uint8_t port, uint8_t byte)
{
    struct avr_usart usart = avr_usart(port);

    *usart.udr = byte;
    *usart.ucsra = AVR_TXC | AVR_U2X; // an older TXC would fire at once
    *usart.ucsrb = usart.tied ? AVR_STATE_TIED_DRAINING : AVR_STATE_DRAINING;
}

#endif
