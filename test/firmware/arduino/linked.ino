/* SPDX-License-Identifier: MIT */
/* A sketch that links the installed library in place of the ZIP: the LED of servo 1 changes each
 * 500 ms, and Serial prints the time of the core. */
#include <cds55xx/avr.h>
#include <cds55xx/servo.h>

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_PACKET_SIZE(2)];
static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);

void setup()
{
    Serial.begin(115200);
    cds_avr_clock_open();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
}

void loop()
{
    static uint32_t changed_us = 0;
    static uint8_t led = 0;

    cds_bus_poll(&bus);
    if (cds_port_now_us() - changed_us >= 500000ul) {
        changed_us += 500000ul;
        led = !led;
        cds_servo_write_byte(&bus, &request, 1, CDS_REG_LED, led);
        Serial.print(millis());
        Serial.println(" ms");
    }
}
