/* SPDX-License-Identifier: MIT */
/* The LED of servo 1 is on for half a second, then off for half a second: the shortest program that
 * waits for nothing. */
#include <cds55xx/avr.h>
#include <cds55xx/servo.h>

#define HALF_PERIOD_US 500000ul

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

int main(void)
{
    static uint8_t packet[CDS_PACKET_SIZE(2)];
    static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);
    uint32_t changed_us = 0;
    uint8_t led = 0;

    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    for (;;) {
        cds_bus_poll(&bus);
        if (cds_port_now_us() - changed_us >= HALF_PERIOD_US) {
            changed_us += HALF_PERIOD_US;
            led = !led;
            cds_servo_write_byte(&bus, &request, 1, CDS_REG_LED, led);
        }
    }
}
