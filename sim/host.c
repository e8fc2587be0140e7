#include "host.h"

#include <stdio.h>

static void say_next(struct host *host, uint64_t now)
{
    uint8_t byte = host->queue[host->head];
    host->head = (host->head + 1) % HOST_ROOM;
    host->waiting--;
    talker_say(&host->talker, now, host->bit_256, byte);
}

static void byte_said(void *owner, uint64_t now)
{
    struct host *host = owner;
    if (host->waiting) {
        say_next(host, now);
    }
}

static void byte_heard(void *owner, uint64_t now, const struct heard *heard)
{
    struct host *host = owner;
    host->framing_errors += heard->framing_error;
    if (host->on_byte) {
        host->on_byte(host->owner, now, heard->byte);
    }
}

bool host_init(struct host *host, struct machine *machine, unsigned usart, uint32_t baud,
               bool exact)
{
    *host = (struct host){.schedule = machine->schedule};
    host->bit_256 = uart_bit_256(machine->avr->frequency, baud);
    net_init(&host->to_avr);
    net_init(&host->from_avr);
    if (!usart_init(&host->usart, machine->avr, usart, exact, machine->schedule, &host->from_avr,
                    &host->to_avr)) {
        fprintf(stderr, "%s: no USART%u\n", machine->avr->mmcu, usart);
        return false;
    }
    driver_init(&host->driver, &host->to_avr);
    driver_enable(&host->driver, 0, true);
    talker_init(&host->talker, machine->schedule, &host->driver, host);
    host->talker.on_end = byte_said;
    ear_init(&host->ear, machine->schedule, &host->from_avr, host);
    host->ear.bit_256 = host->bit_256;
    host->ear.on_byte = byte_heard;
    ear_enable(&host->ear, true);
    return true;
}

size_t host_room(const struct host *host)
{
    return HOST_ROOM - host->waiting;
}

void host_say(struct host *host, uint64_t now, const char *bytes, size_t size)
{
    for (size_t i = 0; i < size && host->waiting < HOST_ROOM; i++) {
        host->queue[(host->head + host->waiting) % HOST_ROOM] = (uint8_t)bytes[i];
        host->waiting++;
    }
    if (host->waiting && !host->talker.busy) {
        say_next(host, now);
    }
}
