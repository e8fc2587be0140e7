/* Link: packets of 3 to 20 and of 250 to 258 bytes, and the handlers in any order until the packet
 * has left.
 *
 * A handler is not interrupted, and the main context writes the pointers only while no event can
 * come. So `volatile` is left out here, or Eva would forget where the pointers point. */
#define volatile
#include "../../src/core/link.c"
#undef volatile

#include "port.h"

#define PACKET_MAX 258u
#define PORT       0

static uint8_t area[PACKET_MAX];
static struct cds_link link;

/* What the transmit handlers may do: on_tx_ready only while TALKING, on_tx_complete while DRAINING.
 */
static void transmit(void)
{
    if (link.state == CDS_LINK_TALKING)
        cds_link_on_tx_ready(&link, PORT);
    else if (link.state == CDS_LINK_DRAINING)
        cds_link_on_tx_complete(&link, PORT);
}

static void any_event(bool hears_itself)
{
    if (any_bool())
        transmit();
    else if (hears_itself)
        cds_link_on_rx_echo(&link, any_byte(), (uint8_t)any_in(0, 3));
    else
        cds_link_on_rx(&link, any_byte(), (uint8_t)any_in(0, 3));
}

void eva_link(void)
{
    uint16_t size = any_bool() ? any_in(3, 20) : any_in(PACKET_MAX - 8, PACKET_MAX);
    bool hears_itself = any_bool();
    const uint8_t *packet;

    //@ split size;
    //@ split hears_itself;
    packet = area + PACKET_MAX - size;
    link.rx.head = any_byte();
    link.rx.tail = any_byte();
    cds_link_open(&link, PORT);
    while (any_bool()) // nothing was sent yet
        hears_itself ? cds_link_on_rx_echo(&link, any_byte(), (uint8_t)any_in(0, 3))
                     : cds_link_on_rx(&link, any_byte(), (uint8_t)any_in(0, 3));
    cds_link_talk(&link, PORT, packet, size);
    while (any_bool())
        any_event(hears_itself);
    if (any_bool())
        cds_link_abort(&link, PORT);
    while (any_bool())
        any_event(hears_itself);
    cds_link_count(&link.echo_errors);
}
