/* SPDX-License-Identifier: MIT */
/* Sets up a bus with servos 1, 100 and 253: scans at 1 Mbps, then changes ID 100 to 42. Then
 * searches the servo at both IDs, even if the change failed. Prints what it finds. */
#include <cds55xx/blocking.h>
#include <cds55xx/avr.h>

#include "say.h"

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

int main(void)
{
    static uint8_t packet[CDS_PACKET_SIZE(2)];
    static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);
    static struct cds_scan_found found[4];
    static struct cds_scan scan;
    static struct cds_scan_config config = {.bus = &bus,
                                            .request = &request,
                                            .found = found,
                                            .found_capacity = 4,
                                            .last_id = CDS_ID_MAX,
                                            .baud_regs = &bus.baud_reg,
                                            .baud_count = 1};
    static struct cds_identity identity;
    uint32_t from_us;

    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);

    from_us = cds_port_now_us();
    cds_blocking_scan(&scan, &config);
    say("scan_us", cds_port_now_us() - from_us);
    say("asked", scan.asked);
    for (uint8_t i = 0; i < scan.count && i < 4; i++)
        say("found", found[i].id);

    from_us = cds_port_now_us();
    cds_blocking_identity(
        &identity,
        &(struct cds_identity_config){
            .bus = &bus, .request = &request, .change = CDS_IDENTITY_ID, .id = 100, .new_id = 42});
    say("change_us", cds_port_now_us() - from_us);
    say("result", identity.steps.result);
    say("state", identity.state);

    cds_blocking_scan(&scan, &config);
    for (uint8_t i = 0; i < scan.count && i < 4; i++)
        say("then", found[i].id);
    say_end();
}
