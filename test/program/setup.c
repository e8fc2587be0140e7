/* Set-up of servos on a bus of three, 1, 100 and 253: a scan at 1 Mbps, then servo 100 becomes 42,
 * and, whatever came of that, it is looked for at both. Says what it finds. */
#include <cds55xx/identity.h>
#include <cds55xx/scan.h>
#include <cds55xx_avr.h>

#include "say.h"

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

int main(void)
{
    static uint8_t packet[CDS_PACKET_SIZE(2)];
    static struct cds_request request = CDS_REQUEST(packet);
    static struct cds_scan_found found[4];
    static struct cds_scan scan;
    static struct cds_identity identity;
    uint32_t from_us;

    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);

    cds_scan_begin(&scan, &bus, &request, found, 4);
    cds_scan_set_bauds(&scan, &bus.baud, 1);
    from_us = cds_port_now_us();
    while (cds_scan_poll(&scan) == CDS_PENDING)
        cds_bus_poll(&bus);
    say("scan_us", cds_port_now_us() - from_us);
    say("asked", scan.asked);
    for (uint8_t i = 0; i < scan.count && i < 4; i++)
        say("found", found[i].id);

    cds_identity_change_id_begin(&identity, &bus, &request, 100, 42);
    from_us = cds_port_now_us();
    while (cds_identity_poll(&identity) == CDS_PENDING)
        cds_bus_poll(&bus);
    say("change_us", cds_port_now_us() - from_us);
    say("result", identity.result);
    say("state", identity.state);

    cds_scan_begin(&scan, &bus, &request, found, 4);
    cds_scan_set_bauds(&scan, &bus.baud, 1);
    while (cds_scan_poll(&scan) == CDS_PENDING)
        cds_bus_poll(&bus);
    for (uint8_t i = 0; i < scan.count && i < 4; i++)
        say("then", found[i].id);
    say_end();
}
