/* SPDX-License-Identifier: MIT */
/* A damaged line: framing errors from a servo at another rate, and bytes lost while interrupts are
 * off. Prints results and counters. */
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>
#include <util/delay.h>

#include "say.h"

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_PACKET_SIZE(2)], reply[40];
static struct cds_request request = CDS_REQUEST(packet, reply);

static void read_table_with_a_pause(uint8_t after_us)
{
    cds_servo_read(&bus, &request, 1, CDS_REG_MODEL_NUMBER, 40);
    _delay_us(150); // request and first bytes of the reply
    if (after_us) {
        cli();
        _delay_us(60);
        sei();
    }
    while (cds_bus_poll(&bus)) {
    }
}

int main(void)
{
    struct cds_stats counters;

    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    read_table_with_a_pause(0);
    say("whole", request.result);
    read_table_with_a_pause(1);
    say("paused", request.result);
    cds_bus_stats(&bus, &counters);
    say("overruns", counters.overruns);

    cds_servo_write_byte(&bus, &request, 1, CDS_REG_BAUD_RATE, 3); // 500 kbps from here on
    while (cds_bus_poll(&bus)) {
    }
    cds_bus_open(&bus, 0, 3);
    cds_servo_ping(&bus, &request, 1);
    while (cds_bus_poll(&bus)) {
    }
    say("slower", request.result);
    /* The servo sends its status packet at 500 kbps; the bus receives at 1 Mbps. */
    cds_servo_ping(&bus, &request, 1);
    while (bus.link.state != CDS_LINK_LISTENING) {
    }
    UBRR1L = 1;
    while (cds_bus_poll(&bus)) {
    }
    say("mismatch", request.result);
    cds_bus_stats(&bus, &counters);
    say("framing_errors", counters.framing_errors);
    say_end();
}
