/* SPDX-License-Identifier: MIT */
#include "host/host_link.h"

#include <stdio.h>

static void usart_has_event(void *context, enum usart_event event, uint64_t now)
{
    struct host_link *link = context;
    (void)now;
    link->overruns += event == USART_OVERRUN;
}

bool host_link_init(struct host_link *link, struct machine *machine, unsigned usart, uint32_t baud,
                    bool exact)
{
    *link = (struct host_link){0};
    net_init(&link->to_avr);
    net_init(&link->from_avr);
    if (!usart_init(&link->usart, machine->avr, usart, exact, machine->schedule, &link->from_avr,
                    &link->to_avr)) {
        fprintf(stderr, "%s: no USART%u: change BOARD_HOST_USART in board.h\n", machine->avr->mmcu,
                usart);
        return false;
    }
    link->usart.context = link;
    link->usart.on_event = usart_has_event;
    adapter_init(&link->adapter, machine->schedule, &link->to_avr, &link->from_avr,
                 machine->avr->frequency, baud);
    return true;
}

void host_link_send(struct host_link *link, uint64_t now, const char *bytes, size_t size)
{
    adapter_send(&link->adapter, now, (const uint8_t *)bytes, size);
}
