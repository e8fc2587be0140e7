/* SPDX-License-Identifier: MIT */
/* The bridge handles the protocol packets of the host one after the other. device.h answers a
 * packet for the virtual device, and bulk_read.h a SYNC READ or BULK READ. The bridge sends every
 * other packet unchanged to the bus, and the reply of the servo unchanged to the host.
 *
 * On the bus a packet waits for its turn as any other request does. The host gets no answer if the
 * reply is missing or damaged, or if the bus refuses the packet. Two refusals are answered by the
 * bridge with a range error in place of the servo: a packet sets a return delay whose replies this
 * board cannot receive, or writes goal, ID or rate of a servo that a motion moves.
 *
 * Manual: 2.1 to 2.4. Main context.
 */
#ifndef CONTROLLER_BRIDGE_H
#define CONTROLLER_BRIDGE_H

#include <stdbool.h>
#include <stdint.h>

#include "host/status_packet.h" // struct status_packet
#include "cds55xx/bus.h"        // struct cds_request
#include "host/device.h"        // struct device
#include "host/bulk_read.h"     // struct bulk_read
#include "host/host_demux.h"    // struct host_demux

enum bridge_state {
    BRIDGE_IDLE,
    BRIDGE_WAITING,   // the packet is on the bus or in its queue
    BRIDGE_DEVICE,    // the device has not finished with the packet
    BRIDGE_BULK_READ, // a SYNC READ or BULK READ is under way
    BRIDGE_ANSWERING, // a status packet is being put into the ring to the host
} __attribute__((packed));

/* Each counts modulo 65536. */
struct bridge_counters {
    uint16_t passed;     // packets given to the bus
    uint16_t answered;   // passed packets whose reply went to the host
    uint16_t unanswered; // passed packets whose reply was due and did not come
    uint16_t refused;    // packets that the bus refused, and malformed BULK READs
};

/* All state of the bridge. Zero it, then bridge_open(). */
struct bridge {
    struct cds_bus *bus;
    struct host_demux *host;
    struct device *device;
    struct cds_ring *output;    // to the host
    struct cds_request request; // swaps its packet buffer with the demux
    struct status_packet status;
    uint32_t taken_us; // when the last byte of the packet came from the host
    uint8_t state;     // enum bridge_state
    struct bridge_counters counters;
    struct bulk_read bulk_read;
    uint8_t reply[STATUS_PACKET_HEAD + CDS_REPLY_ANY + 1]; // room for a whole status packet: head,
                                                           // parameters, checksum
};

/* Opens the bridge. `bytes`: a buffer of HOST_PACKET_MAX bytes; STATUS_PACKET_HEAD bytes before it,
 * and before the buffer of the demux, must be free for use. `output`: the ring to the host. */
void bridge_open(struct bridge *bridge, struct cds_bus *bus, struct host_demux *host,
                 struct device *device, struct cds_ring *output, uint8_t *bytes);

/* Moves the packet of the host on. Call it from the main loop after host_demux_poll() and
 * cds_bus_poll(). */
void bridge_poll(struct bridge *bridge);

/* Call it while an operation has the bus to itself, and bridge_poll() only if it returns true. The
 * next packet of the host waits. A SYNC READ or BULK READ waits, too; after HOST_SILENCE_US it is
 * dropped and counts as late. */
bool bridge_goes_on(struct bridge *bridge);

/* True while a status packet is partly in the ring or waits for room. No other byte may be put into
 * the ring then. */
bool bridge_talks(const struct bridge *bridge);

/* True during a SYNC READ or BULK READ. Calling bridge_poll() more often shortens it. */
static inline bool bridge_is_reading(const struct bridge *bridge)
{
    return bridge->state == BRIDGE_BULK_READ;
}

/* True while only cds_bus_poll() can move a SYNC READ or BULK READ on. */
static inline bool bridge_awaits_servo(const struct bridge *bridge)
{
    return bulk_read_is_awaiting(&bridge->bulk_read);
}

/* True if neither bridge nor demux has a packet. */
bool bridge_idle(const struct bridge *bridge);

#endif
