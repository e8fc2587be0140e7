/* The PC at the other end of the host USART, with a UART clock of its own. */
#ifndef SIM_HOST_LINK_H
#define SIM_HOST_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/adapter.h"
#include "avr/machine.h"
#include "wire/net.h"
#include "avr/usart.h"

struct host {
    struct usart usart; // the AVR's
    struct net to_avr;
    struct net from_avr;
    struct adapter pc;
};

/* False, with one line on stderr, when the chip has no such USART. What the firmware says comes to
 * host->pc.on_byte. */
bool host_init(struct host *host, struct machine *machine, unsigned usart, uint32_t baud,
               bool exact);

/* How many bytes may be said now. */
size_t host_room(const struct host *host);
void host_say(struct host *host, uint64_t now, const char *bytes, size_t size);

#endif
