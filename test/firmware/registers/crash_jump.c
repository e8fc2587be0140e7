/* SPDX-License-Identifier: MIT */
/* A call through a pointer that was never set. */
#include "chip.h"

static void (*volatile handler)(void);

int main(void)
{
    bus_talk();
    wait(100);
    handler();
    end();
}
