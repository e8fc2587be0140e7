/* SPDX-License-Identifier: MIT */
/* A byte written to UDR while it is full is ignored; simavr sends it. The wire tells. */
#include "chip.h"

int main(void)
{
    bus_talk();
    UDR1 = 0x11;
    UDR1 = 0x22;
    UDR1 = 0x33;
    wait(400);
    end();
}
