/* SPDX-License-Identifier: MIT */
/* After a reset the transmitter is off; simavr turns it on. */
#include "chip.h"

int main(void)
{
    uint8_t control = UCSR1B;
    uint8_t status = UCSR1A;
    print_open();
    print("ucsrb", control);
    print("ucsra", status);
    end();
}
