/* SPDX-License-Identifier: MIT */
/* Noise on the line; see noise.h. */
#include "console/noise.h"

#include "cds55xx/port.h" // cds_port_now_us()

#define WINDOW_US 250000ul

/* Noise: so many polls of a window find new bytes while no reply is due. A stale reply of 17 bytes
 * is found by up to 17 polls: each good packet permits as many more. */
#define POLLS_LEAST      24u
#define POLLS_PER_PACKET 17u

/* Good packets that no request asked for, such as stale replies. */
static uint16_t good_packets(const struct cds_bus *bus)
{
    uint16_t packets = 0;

    for (uint8_t i = 0; i < sizeof bus->stats.not_due / sizeof bus->stats.not_due[0]; i++)
        packets = (uint16_t)(packets + bus->stats.not_due[i]);
    return packets;
}

static bool is_noise(const struct noise *noise, const struct cds_bus *bus)
{
    uint16_t packets = (uint16_t)(good_packets(bus) - noise->packets);

    return noise->polls >= POLLS_LEAST + POLLS_PER_PACKET * packets;
}

/* Bytes count only between two polls without a packet of the controller between them. */
static void look(struct noise *noise, const struct cds_bus *bus)
{
    uint8_t end = cds_ring_end(&bus->link.rx);

    if (noise->sent == bus->stats.sent && noise->end != end) {
        noise->polls++;
        if (is_noise(noise, bus))
            noise->is_there = true;
    }
    noise->sent = bus->stats.sent;
    noise->end = end;
}

void noise_poll(struct noise *noise, const struct cds_bus *bus)
{
    uint32_t now_us = cds_port_now_us();

    if (bus->state < CDS_BUS_SENDING)
        look(noise, bus);
    if (now_us - noise->begun_us < WINDOW_US)
        return;
    noise->is_there = is_noise(noise, bus);
    noise->polls = 0;
    noise->packets = good_packets(bus);
    noise->begun_us = now_us;
}
