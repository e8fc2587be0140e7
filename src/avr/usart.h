/* The bus USARTs of the board, as register constants, and the port's verbs as inline functions.
 *
 * Everything is always inlined: with a constant `port` each verb becomes the two to six stores it
 * means. Direction is changed by one whole store to UCSRnB, never by |=, and by sbi and cbi on the
 * enables, which no interrupt can tear.
 */
#ifndef AVR_USART_H
#define AVR_USART_H

#include <avr/io.h>
#include <stdint.h>

#include "board.h"

/* Inlined wherever it is called; no copy is ever emitted. */
#define AVR_INLINE extern inline __attribute__((gnu_inline, always_inline))

/* The registers and pins of one bus. All constants; never stands in memory. */
struct avr_usart {
    volatile uint8_t *udr, *ucsra, *ucsrb, *ucsrc, *ubrrh, *ubrrl;
    volatile uint8_t *rxd_port, *txd_port, *txd_ddr;
    volatile uint8_t *tx_enable_port, *tx_enable_ddr, *rx_enable_port, *rx_enable_ddr;
    uint8_t rxd, txd, tx_enable, rx_enable; // masks
};

#define AVR_PASTE_(a, b)     a##b
#define AVR_PASTE(a, b)      AVR_PASTE_(a, b)
#define AVR_PASTE3_(a, b, c) a##b##c
#define AVR_PASTE3(a, b, c)  AVR_PASTE3_(a, b, c)
#define AVR_BUS(bus, key)    AVR_PASTE3(BOARD_BUS, bus, key)
#define AVR_BUS_PORT(bus, key)                                                                     \
    AVR_PASTE(PORT, AVR_PASTE3(BOARD_BUS, bus, AVR_PASTE3_(_, key, _PORT)))
#define AVR_BUS_DDR(bus, key) AVR_PASTE(DDR, AVR_PASTE3(BOARD_BUS, bus, AVR_PASTE3_(_, key, _PORT)))
#define AVR_BUS_MASK(bus, key)                                                                     \
    (uint8_t)(1u << AVR_PASTE3(BOARD_BUS, bus, AVR_PASTE3_(_, key, _BIT)))

#define AVR_USART_OF(bus)                                                                          \
    (struct avr_usart)                                                                             \
    {                                                                                              \
        .udr = &AVR_PASTE(UDR, AVR_BUS(bus, _USART)),                                              \
        .ucsra = &AVR_PASTE3(UCSR, AVR_BUS(bus, _USART), A),                                       \
        .ucsrb = &AVR_PASTE3(UCSR, AVR_BUS(bus, _USART), B),                                       \
        .ucsrc = &AVR_PASTE3(UCSR, AVR_BUS(bus, _USART), C),                                       \
        .ubrrh = &AVR_PASTE3(UBRR, AVR_BUS(bus, _USART), H),                                       \
        .ubrrl = &AVR_PASTE3(UBRR, AVR_BUS(bus, _USART), L), .rxd_port = &AVR_BUS_PORT(bus, RXD),  \
        .rxd = AVR_BUS_MASK(bus, RXD), .txd_port = &AVR_BUS_PORT(bus, TXD),                        \
        .txd = AVR_BUS_MASK(bus, TXD), .txd_ddr = &AVR_BUS_DDR(bus, TXD),                          \
        .tx_enable_port = &AVR_BUS_PORT(bus, TX_ENABLE),                                           \
        .tx_enable_ddr = &AVR_BUS_DDR(bus, TX_ENABLE), .tx_enable = AVR_BUS_MASK(bus, TX_ENABLE),  \
        .rx_enable_port = &AVR_BUS_PORT(bus, RX_ENABLE),                                           \
        .rx_enable_ddr = &AVR_BUS_DDR(bus, RX_ENABLE), .rx_enable = AVR_BUS_MASK(bus, RX_ENABLE),  \
    }

/* The bits of UCSRnA, B and C stand at the same places in every USART of every ATmega here. */
enum {
    AVR_TXC = 1 << 6,
    AVR_FRAMING_ERROR = 1 << 4,
    AVR_OVERRUN = 1 << 3,
    AVR_U2X = 1 << 1,
    AVR_EIGHT_BITS = 3 << 1,
    /* UCSRnB in each state of the link */
    AVR_STATE_HIGH_Z = 0,
    AVR_STATE_LISTENING = 1 << 7 | 1 << 4, // RXCIE, RXEN
    AVR_STATE_TALKING = 1 << 5 | 1 << 3,   // UDRIE, TXEN
    AVR_STATE_DRAINING = 1 << 6 | 1 << 3,  // TXCIE, TXEN
};

/* `port` is a bus of the board: 0 to BOARD_BUS_COUNT - 1. */
AVR_INLINE struct avr_usart avr_usart(uint8_t port)
{
#if BOARD_BUS_COUNT > 2
    if (port == 2)
        return AVR_USART_OF(2);
#endif
#if BOARD_BUS_COUNT > 1
    if (port == 1)
        return AVR_USART_OF(1);
#endif
    (void)port;
    return AVR_USART_OF(0);
}

AVR_INLINE void avr_usart_high_z(uint8_t port)
{
    struct avr_usart usart = avr_usart(port);

    *usart.ucsrb = AVR_STATE_HIGH_Z; // first: no handler may find the enables half way
    *usart.tx_enable_port &= (uint8_t)~usart.tx_enable;
    *usart.rx_enable_port &= (uint8_t)~usart.rx_enable;
}

AVR_INLINE void avr_usart_listen(uint8_t port)
{
    struct avr_usart usart = avr_usart(port);

    *usart.tx_enable_port &= (uint8_t)~usart.tx_enable;
    *usart.rx_enable_port |= usart.rx_enable;
    *usart.ucsrb = AVR_STATE_LISTENING;
}

AVR_INLINE void avr_usart_talk(uint8_t port)
{
    struct avr_usart usart = avr_usart(port);

    *usart.rx_enable_port &= (uint8_t)~usart.rx_enable;
    *usart.tx_enable_port |= usart.tx_enable;
    *usart.ucsrb = AVR_STATE_TALKING;
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
    *usart.ucsrb = AVR_STATE_DRAINING;
}

#endif
