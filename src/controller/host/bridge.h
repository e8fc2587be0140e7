/* What becomes of the host's protocol packets, one after the other, in their order: they go out on
 * the bus as they are and their replies come back as they are, or the virtual device answers them
 * (device.h), or a SYNC READ or BULK READ is made of READs (bulk_read.h).
 *
 * A packet takes its turn on the bus like any other request. One whose reply does not come, or came
 * damaged, is not answered, as behind any adapter; nor is one that the bus refuses. If a packet
 * sets a return delay whose replies this board cannot receive, the bridge answers a range error for
 * the servo.
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
    BRIDGE_WAITING,   // the packet is on the bus, or in its queue
    BRIDGE_DEVICE,    // the device cannot do yet what was asked
    BRIDGE_BULK_READ, // servo after servo
    BRIDGE_ANSWERING,
} __attribute__((packed));

/* Counted modulo 65536. */
struct bridge_counters {
    uint16_t passed;     // packets given to the bus
    uint16_t answered;   // ... of them with a reply that went to the host
    uint16_t unanswered; // ... with none, where one was due
    uint16_t refused;    // packets that were not admitted to the bus, or made no sense
};

/* All state of the bridge. Zero it, then bridge_open(). */
struct bridge {
    struct host_demux *host;
    struct cds_request request; // its packet's buffer changes places with the host's
    struct bulk_read bulk_read; // it knows bus, device and output
    struct status_packet status;
    uint32_t taken_us; // when the packet was whole on the host link
    uint8_t state;     // enum bridge_state
    struct bridge_counters counters;
    uint8_t reply[STATUS_PACKET_HEAD + CDS_REPLY_ANY + 1]; // parameters of a servo, amid the answer
};

/* `bytes`: HOST_PACKET_MAX of them. STATUS_PACKET_HEAD more stand before these and before those
 * that the host was opened with. `output`: the ring to the host. */
void bridge_open(struct bridge *bridge, struct cds_bus *bus, struct host_demux *host,
                 struct device *device, struct cds_ring *output, uint8_t *bytes);

/* Moves on. To be called from the main loop, behind host_demux_poll() and cds_bus_poll(). */
void bridge_poll(struct bridge *bridge);

/* Is a status packet partly in the ring, or waits for room? Then nothing else may be put there. */
bool bridge_talks(const struct bridge *bridge);

/* Servo after servo is read: the sooner bridge_poll() is called again, the sooner it is over. */
static inline bool bridge_is_reading(const struct bridge *bridge)
{
    return bridge->state == BRIDGE_BULK_READ;
}

/* ... and now cds_bus_poll() alone. */
static inline bool bridge_awaits_servo(const struct bridge *bridge)
{
    return bulk_read_is_awaiting(&bridge->bulk_read);
}

/* Nothing to do but wait for a packet, or for the bus, which wakes the CPU by itself? */
bool bridge_idle(const struct bridge *bridge);

#endif
