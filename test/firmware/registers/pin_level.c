/* SPDX-License-Identifier: MIT */
/* What PIND says of RXD, asked by each instruction that can ask: high 0 to 5 times of five. With
 * the line idle, with the way from the wire to RXD shut (if there is one to shut), and in the
 * middle of a byte 00 of its own. */
#include "chip.h"

static inline uint8_t times_high(void)
{
    uint8_t high = 0, in, lds, ld;
    __asm__ volatile("in %0, %3\n\tlds %1, %4\n\tld %2, %a5"
                     : "=&r"(in), "=&r"(lds), "=&r"(ld)
                     : "I"(_SFR_IO_ADDR(PIND)), "n"(_SFR_MEM_ADDR(PIND)), "e"(&PIND));
    __asm__ volatile("sbic %1, 2\n\tinc %0\n\tsbis %1, 2\n\tdec %0\n\tinc %0"
                     : "+r"(high)
                     : "I"(_SFR_IO_ADDR(PIND)));
    high = (uint8_t)(high + ((in & RXD) != 0) + ((lds & RXD) != 0));
    return (uint8_t)(high + ((ld & RXD) != 0));
}

int main(void)
{
    PORTD = RXD | RX_ENABLE;
    DDRD = TX_ENABLE | RX_ENABLE;
    bus_rate_1M();
    wait(100);
    uint8_t idle = times_high();
    bus_talk();
    wait(100);
    uint8_t shut = times_high();
    UDR1 = 0;
    wait(16);
    uint8_t talk = times_high();
    wait(100);
    print_open();
    print("idle", idle);
    print("shut", shut);
    print("talk", talk);
    end();
}
