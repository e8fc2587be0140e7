/* The PC at the other end of the host USART, with a UART clock of its own. */
#ifndef SIM_HOST_H
#define SIM_HOST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "machine.h"
#include "net.h"
#include "uart.h"
#include "usart.h"

#define HOST_ROOM 4096 // bytes that wait to be sent to the firmware

struct host {
    struct schedule *schedule;
    struct usart usart; // the AVR's
    struct net to_avr;
    struct net from_avr;
    struct driver driver;
    struct talker talker;
    struct ear ear;
    uint32_t bit_256;
    uint8_t queue[HOST_ROOM]; // a ring
    size_t head, waiting;
    uint32_t framing_errors; // in what the firmware said
    void *owner;
    void (*on_byte)(void *owner, uint64_t now, uint8_t byte); // from the firmware; may be 0
};

/* False, with one line on stderr, when the chip has no such USART. */
bool host_init(struct host *host, struct machine *machine, unsigned usart, uint32_t baud,
               bool exact);

/* How many bytes may be said now. */
size_t host_room(const struct host *host);
void host_say(struct host *host, uint64_t now, const char *bytes, size_t size);

#endif
