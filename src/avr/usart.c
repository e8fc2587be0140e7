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

uint8_t cds_port_talk(uint8_t port, uint8_t byte)
{
    return avr_usart_talk(port, byte);
}

void cds_port_follow(uint8_t port)
{
    avr_usart_follow(port);
}

bool cds_port_line_is_high(uint8_t port)
{
    struct avr_usart usart = avr_usart(port);

    return *usart.rxd_level & usart.rxd.mask;
}

void cds_port_tx(uint8_t port, uint8_t byte)
{
    avr_usart_tx(port, byte);
}

void cds_port_tx_last(uint8_t port, uint8_t byte)
{
    avr_usart_tx_last(port, byte);
}

void enable_out_of_reach_of_sbi(void)
    __attribute__((error("choose enables on ports whose registers lie below 0x40")));

AVR_INLINE void pin_output(struct avr_pin pin)
{
    if (pin.mask)
        *pin.ddr |= pin.mask;
}

AVR_INLINE void pins_listen(uint8_t port)
{
    struct avr_usart usart = avr_usart(port);

    if ((uintptr_t)usart.tx_enable.port >= 0x40 || (uintptr_t)usart.rx_enable.port >= 0x40)
        enable_out_of_reach_of_sbi();
    avr_pin_high(usart.rx_enable);
    pin_output(usart.rx_enable);
    avr_pin_low(usart.tx_enable);
    pin_output(usart.tx_enable);
    avr_pin_high(usart.rxd); // pull-up: RXD floats while the receive buffer is off
    avr_pin_high(usart.txd); // an idle line is high, also while the transmitter is off
    if (!usart.tied)         // there an output would hold the servos' wire
        pin_output(usart.txd);
}

/* Runs before stack, .data and everything else: the first instructions after a reset leave no doubt
 * that the bus is the servos'. Only sbi, cbi and, for TXD and RXD on high ports, lds, ori and sts
 * come of it, so no stack and no r1 are needed. */
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
