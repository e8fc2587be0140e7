/* SPDX-License-Identifier: MIT */
/* An ATmega2560 that pings servo 1 on three buses at once, eight times, and prints how many replies
 * came in whole. The buses are driven in step, one byte of each after the other. It polls: three
 * receive handlers of 60 cycles do not fit into the 160 of a byte. */
#include "chip.h"

#define BUSES 3
#define SIZE  6

/* Registers of an USART, from its UCSRnA on. */
enum { A = 0, B = 1, C = 2, DATA = 6 };

static volatile uint8_t *const usart[BUSES] = {&UCSR1A, &UCSR2A, &UCSR3A};
static const uint8_t tx_enable[BUSES] = {1 << 0, 1 << 2, 1 << 4};
static const uint8_t rx_enable[BUSES] = {1 << 1, 1 << 3, 1 << 5};

static void talk(const uint8_t *packet, uint8_t size)
{
    for (uint8_t bus = 0; bus < BUSES; bus++) {
        usart[bus][B] = 1 << TXEN1;
        PORTA &= (uint8_t)~rx_enable[bus];
        PORTA |= tx_enable[bus];
    }
    for (uint8_t i = 0; i < size; i++) {
        for (uint8_t bus = 0; bus < BUSES; bus++) {
            while (!(usart[bus][A] & (1 << UDRE1))) {
            }
            usart[bus][A] = 1 << TXC1;
            usart[bus][DATA] = packet[i];
        }
    }
    for (uint8_t bus = 0; bus < BUSES; bus++) {
        while (!(usart[bus][A] & (1 << TXC1))) {
        }
        PORTA &= (uint8_t)~tx_enable[bus];
        PORTA |= rx_enable[bus];
        usart[bus][B] = 1 << RXEN1;
    }
}

/* Six bytes with the sum FFh + FFh + FFh are the answer: servo 1, no errors. */
static void listen(uint8_t whole[BUSES])
{
    uint8_t count[BUSES] = {0};
    uint8_t sum[BUSES] = {0};
    for (uint16_t patience = 400; patience; patience--) {
        if (UCSR1A & (1 << RXC1)) {
            sum[0] = (uint8_t)(sum[0] + UDR1);
            count[0]++;
        }
        if (UCSR2A & (1 << RXC2)) {
            sum[1] = (uint8_t)(sum[1] + UDR2);
            count[1]++;
        }
        if (UCSR3A & (1 << RXC3)) {
            sum[2] = (uint8_t)(sum[2] + UDR3);
            count[2]++;
        }
    }
    for (uint8_t bus = 0; bus < BUSES; bus++) {
        if (count[bus] == SIZE && sum[bus] == 0xFD) {
            whole[bus]++;
        }
    }
}

int main(void)
{
    /* a return delay of 16 us: the three turn around one after the other */
    static const uint8_t delay[] = {0xFF, 0xFF, 0xFE, 0x04, 0x03, 0x05, 0x08, 0xED};
    static const uint8_t ping[SIZE] = {0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB};
    uint8_t whole[BUSES] = {0};
    PORTD = 1 << PD2;
    PORTH = 1 << PH0;
    PORTJ = 1 << PJ0;
    PORTA = 0x2A;
    DDRA = 0x3F;
    talk(delay, sizeof(delay));
    wait(4000);
    for (uint8_t i = 0; i < 8; i++) {
        talk(ping, sizeof(ping));
        listen(whole);
    }
    print_open();
    print("bus0", whole[0]);
    print("bus1", whole[1]);
    print("bus2", whole[2]);
    end();
}
