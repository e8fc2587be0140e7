/* SPDX-License-Identifier: MIT */
// A robot in C++11: both macros of the AVR port, requests with and without a reply; built and run
// by test/runs/test_cpp.py.
#include <cds55xx/cds55xx.h>
#include <cds55xx/avr.h>

namespace
{
cds_bus bus;
uint8_t packet[CDS_SYNC_WRITE_SIZE(2, 4)];
uint8_t reply[2];
cds_request request = CDS_REQUEST(packet, reply);
} // namespace

CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

int main()
{
    uint8_t id = 0;

    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    if (cds_blocking_read_byte(&bus, &request, 2, CDS_REG_ID, &id) != CDS_OK)
        id = CDS_BROADCAST_ID;
    cds_blocking_write_byte(&bus, &request, id, CDS_REG_LED, 1);
    cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4);
    cds_sync_write_add_goal(&request, 1, 700, 512);
    cds_sync_write_add_goal(&request, id, 300, 512);
    cds_blocking_sync_write(&bus, &request);
    for (;;)
        cds_bus_poll(&bus);
}
