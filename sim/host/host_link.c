#include "host/host_link.h"

#include <stdio.h>

bool host_init(struct host *host, struct machine *machine, unsigned usart, uint32_t baud,
               bool exact)
{
    *host = (struct host){0};
    net_init(&host->to_avr);
    net_init(&host->from_avr);
    if (!usart_init(&host->usart, machine->avr, usart, exact, machine->schedule, &host->from_avr,
                    &host->to_avr)) {
        fprintf(stderr, "%s: no USART%u: change BOARD_HOST_USART in board.h\n", machine->avr->mmcu,
                usart);
        return false;
    }
    adapter_init(&host->pc, machine->schedule, &host->to_avr, &host->from_avr,
                 machine->avr->frequency, baud);
    return true;
}

size_t host_room(const struct host *host)
{
    return adapter_room(&host->pc);
}

void host_say(struct host *host, uint64_t now, const char *bytes, size_t size)
{
    adapter_say(&host->pc, now, (const uint8_t *)bytes, size);
}
