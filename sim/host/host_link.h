/* SPDX-License-Identifier: MIT */
/* The host USART of the AVR, connected to a PC's serial adapter with its own clock. */
#ifndef SIM_HOST_LINK_H
#define SIM_HOST_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "avr/machine.h"
#include "avr/usart.h"
#include "host/adapter.h"
#include "wire/net.h"

struct host_link {
    struct usart usart; // of the AVR
    struct net to_avr;
    struct net from_avr;
    struct adapter adapter;
    uint32_t overruns; // bytes of the PC that the firmware did not read in time
};

/* Returns false, with one line on stderr, if the chip has no such USART. link->adapter.on_byte gets
 * the bytes of the firmware. */
bool host_link_init(struct host_link *link, struct machine *machine, unsigned usart, uint32_t baud,
                    bool exact);

void host_link_send(struct host_link *link, uint64_t now, const char *bytes, size_t size);

#endif
