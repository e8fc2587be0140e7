/* SPDX-License-Identifier: MIT */
/* An interrupt without a handler. */
#include "chip.h"

int main(void)
{
    bus_talk();
    UCSR1B = (1 << TXEN1) | (1 << UDRIE1);
    sei();
    for (;;) {
    }
}
