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

/* True if the bytes take more than a third of the time: a servo that babbles, of whose bytes the
 * receiver loses up to 60 %. 20000 flips a second take a fifth. */
static bool fills_line(const struct noise *noise, const struct cds_bus *bus)
{
    return (uint32_t)noise->bytes * bus->byte_time_us > noise->counted_us / 3;
}

/* Counts the bytes since the last poll. If polls are farther apart, the ring may have wrapped. */
static void count_bytes(struct noise *noise, const struct cds_bus *bus, uint8_t count)
{
    uint32_t now_us = cds_port_now_us(), elapsed_us = now_us - noise->polled_us;

    noise->polled_us = now_us;
    if (elapsed_us > (uint32_t)(CDS_RING_SIZE / 2) * bus->byte_time_us)
        return;
    noise->bytes = (uint16_t)(noise->bytes + count);
    noise->counted_us += elapsed_us;
}

static void begin_window(struct noise *noise, const struct cds_bus *bus)
{
    noise->polls = 0;
    noise->bytes = 0;
    noise->counted_us = 0;
    noise->packets = good_packets(bus);
    noise->begun_us = cds_port_now_us();
}

/* Noise begins: the window in which it gets its name begins, too. */
static void begin_noise(struct noise *noise, const struct cds_bus *bus)
{
    noise->is_there = true;
    noise->name = NOISE_UNNAMED;
    begin_window(noise, bus);
}

/* Bytes count only between two polls without a packet of the controller between them. */
static void look(struct noise *noise, const struct cds_bus *bus)
{
    uint8_t end = cds_ring_end(&bus->link.rx);

    if (noise->sent == bus->stats.sent && noise->end != end) {
        noise->polls++;
        if (!noise->is_there && is_noise(noise, bus))
            begin_noise(noise, bus);
    }
    if (noise->sent != bus->stats.sent && noise->name == NOISE_UNNAMED)
        noise->name = NOISE_RANDOM; // the line was quiet for the packet
    count_bytes(noise, bus, cds_ring_distance(noise->end, end));
    noise->sent = bus->stats.sent;
    noise->end = end;
}

void noise_poll(struct noise *noise, const struct cds_bus *bus)
{
    if (bus->state < CDS_BUS_SENDING)
        look(noise, bus);
    if (cds_port_now_us() - noise->begun_us < WINDOW_US)
        return;
    noise->is_there = is_noise(noise, bus);
    if (noise->name == NOISE_UNNAMED)
        noise->name = fills_line(noise, bus) ? NOISE_BABBLE : NOISE_RANDOM;
    begin_window(noise, bus);
}
