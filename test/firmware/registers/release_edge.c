/* SPDX-License-Identifier: MIT */
/* Releases the driver so many cycles after the byte was written to UDR, from 165 down to 155: a
 * byte lasts 160, so just five of these are cut, the first of them by one cycle. */
#include "chip.h"

/* STS takes two cycles, and both writes take effect after the same time. */
#define RELEASE_AFTER(cycles)                                                                      \
    bus_talk();                                                                                    \
    wait(50);                                                                                      \
    __asm__ __volatile__("sts %0, %1" ::"n"(_SFR_MEM_ADDR(UDR1)), "r"(byte));                      \
    __builtin_avr_delay_cycles((cycles)-2);                                                        \
    __asm__ __volatile__("out %0, %1" ::"I"(_SFR_IO_ADDR(PORTD)), "r"(released));                  \
    wait(200)

int main(void)
{
    uint8_t byte = 0x55;
    uint8_t released = RXD;
    RELEASE_AFTER(165);
    RELEASE_AFTER(164);
    RELEASE_AFTER(163);
    RELEASE_AFTER(162);
    RELEASE_AFTER(161);
    RELEASE_AFTER(160);
    RELEASE_AFTER(159);
    RELEASE_AFTER(158);
    RELEASE_AFTER(157);
    RELEASE_AFTER(156);
    RELEASE_AFTER(155);
    print_open();
    end();
}
