/* The port's verbs for calls from the core, and the pins at reset; see port.h and usart.h. */
#include "usart.h"

#include "cds55xx/port.h" // what is implemented here

#if F_CPU != 16000000
#error "the servos' rates, 2 Mbps / (n + 1), need F_CPU = 16 MHz: then UBRR is n, with no error"
#endif

void cds_port_open(uint8_t port, uint8_t baud)
{
    struct avr_usart usart = avr_usart(port);

    avr_usart_high_z(port);
    *usart.ucsra = AVR_U2X;
    *usart.ucsrc = AVR_EIGHT_BITS;
    *usart.ubrrh = 0;
    *usart.ubrrl = baud;
}

void cds_port_high_z(uint8_t port)
{
    avr_usart_high_z(port);
}

void cds_port_listen(uint8_t port)
{
    avr_usart_listen(port);
}

void cds_port_talk(uint8_t port)
{
    avr_usart_talk(port);
}

void cds_port_tx(uint8_t port, uint8_t byte)
{
    avr_usart_tx(port, byte);
}

void cds_port_tx_last(uint8_t port, uint8_t byte)
{
    avr_usart_tx_last(port, byte);
}

AVR_INLINE void pins_listen(uint8_t port)
{
    struct avr_usart usart = avr_usart(port);

    *usart.rx_enable_port |= usart.rx_enable;
    *usart.rx_enable_ddr |= usart.rx_enable;
    *usart.tx_enable_port &= (uint8_t)~usart.tx_enable;
    *usart.tx_enable_ddr |= usart.tx_enable;
    *usart.rxd_port |= usart.rxd; // pull-up: RXD floats while the receive buffer is off
    *usart.txd_port |= usart.txd; // an idle line is high, also while the transmitter is off
    *usart.txd_ddr |= usart.txd;
}

/* Runs before stack, .data and everything else: the first instructions after a reset leave no doubt
 * that the bus is the servos'. Only sbi and cbi come of it, so no stack and no r1 are needed. */
__attribute__((naked, used, section(".init1"))) void cds_avr_pins_at_reset(void)
{
    pins_listen(0);
#if BOARD_BUS_COUNT > 1
    pins_listen(1);
#endif
#if BOARD_BUS_COUNT > 2
    pins_listen(2);
#endif
}
