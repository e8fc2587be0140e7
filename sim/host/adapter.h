/* A PC's serial adapter: bytes from a program go out in order, at the rate that held when they were
 * given; what comes in is handed over.
 *
 * Full duplex it is the host link's end of two wires. Half duplex it is a USB2Dynamixel: it drives
 * the bus from the first start bit to the end of the last stop bit, and while it drives, the way to
 * its receiver is shut: it does not hear itself, nor who else talks then.
 */
#ifndef SIM_ADAPTER_H
#define SIM_ADAPTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "wire/net.h"
#include "wire/schedule.h"
#include "wire/uart.h"

#define ADAPTER_SIZE 4096 // bytes that wait to be sent

struct adapter_byte {
    uint32_t bit_256;
    uint8_t byte;
};

struct adapter {
    struct schedule *schedule;
    uint32_t clock_Hz;
    bool half_duplex;
    struct driver driver;
    struct uart_tx tx;
    struct net rxd; // behind the receive buffer
    struct driver to_rxd;
    struct listener listener;
    struct uart_rx rx;
    uint32_t baud, bit_256;
    struct adapter_byte queue[ADAPTER_SIZE]; // a ring
    size_t head, waiting;
    uint32_t framing_errors;
    void *context;
    void (*on_byte)(void *context, uint64_t now, uint8_t byte); // may be 0
    void (*on_start)(void *context, uint64_t now);              // of a byte it says; may be 0
    void (*on_drive)(void *context, uint64_t now,
                     bool talking); // half duplex: the driver; may be 0
};

/* Half duplex when `to` and `from` are one net. */
void adapter_init(struct adapter *adapter, struct schedule *schedule, struct net *to,
                  struct net *from, uint32_t clock_Hz, uint32_t baud);

/* For bytes given, and start bits heard, from now on. 0, a line that was hung up, changes nothing.
 */
void adapter_baud(struct adapter *adapter, uint32_t baud);

/* How many bytes may be said now; further ones are dropped. */
size_t adapter_space(const struct adapter *adapter);
void adapter_send(struct adapter *adapter, uint64_t now, const uint8_t *bytes, size_t size);

/* End of the last stop bit of all that was said; in the past when it is out. */
uint64_t adapter_end(const struct adapter *adapter);

#endif
