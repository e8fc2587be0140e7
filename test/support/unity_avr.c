/* SPDX-License-Identifier: MIT */
/* Output of Unity on the simulated AVR: the host USART, polled. At the end the program sleeps with
 * interrupts off, which ends the simulation. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

#include "unity_config.h"

void unity_avr_open(void)
{
    UCSR0A = 1 << U2X0;
    UBRR0H = 0;
    UBRR0L = 16; // 115200 bit/s, the simulator's PC
    UCSR0C = 3 << UCSZ00;
    UCSR0B = 1 << TXEN0;
}

void unity_avr_put(int c)
{
    while (!(UCSR0A & 1 << UDRE0)) {
    }
    UCSR0A = 1 << TXC0 | 1 << U2X0;
    UDR0 = (uint8_t)c;
}

void unity_avr_end(void)
{
    while (!(UCSR0A & 1 << TXC0)) {
    }
    cli();
    sleep_enable();
    sleep_cpu();
}
