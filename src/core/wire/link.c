/* SPDX-License-Identifier: MIT */
/* The half-duplex direction, seen from the main context; the events are in link.h. */
#include "cds55xx/link.h"

#include "compiler.h" // NOINLINE

void cds_link_open(struct cds_link *link, uint8_t port)
{
    cds_link_abort(link, port);
}

void cds_link_follow(struct cds_link *link, uint8_t port, const uint8_t *packet, uint16_t size,
                     uint8_t begun)
{
    cds_ring_release(&link->rx, cds_ring_end(&link->rx));
    link->broken = CDS_LINK_WHOLE;
    __asm__ __volatile__("" ::: "memory"); // the packet is in memory before a handler may read it
    link->cursor = packet + begun;
    link->last = packet + size - 1;
    link->echo = packet;
    link->state = CDS_LINK_TALKING; // before the verb: its first event may come at once
    cds_port_follow(port);
}

NOINLINE void cds_link_abort(struct cds_link *link, uint8_t port)
{
    cds_port_high_z(port); // no event from here on
    link->state = CDS_LINK_LISTENING;
    cds_port_listen(port);
}

uint16_t cds_link_count(const volatile uint16_t *counter)
{
    uint16_t first, second = *counter;

    do { // two bytes, and a handler may come between them: read until both agree
        first = second;
        second = *counter;
    } while (first != second);
    return first;
}
