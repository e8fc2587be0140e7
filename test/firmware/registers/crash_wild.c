/* SPDX-License-Identifier: MIT */
/* A call to where there is no code. */
#include "chip.h"

static void (*volatile handler)(void) = (void (*)(void))0x4000;

int main(void)
{
    bus_talk();
    wait(100);
    handler();
    end();
}
