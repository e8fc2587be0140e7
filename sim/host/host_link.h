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

struct host_link {
    struct usart usart; // the AVR's
    struct net to_avr;
    struct net from_avr;
    struct adapter adapter;
};

/* False, with one line on stderr, when the chip has no such USART. What the firmware says comes to
 * host->pc.on_byte. */
bool host_link_init(struct host_link *link, struct machine *machine, unsigned usart, uint32_t baud,
                    bool exact);

/* How many bytes may be said now. */
size_t host_link_space(const struct host_link *link);
void host_link_send(struct host_link *link, uint64_t now, const char *bytes, size_t size);

#endif
