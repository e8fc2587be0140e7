/* SPDX-License-Identifier: MIT */
/* The main loop continues while a servo does not answer. Prints the number of its turns, the
 * duration of submit and transaction in microseconds, and the outcome of the transaction. */
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>

#include "say.h"

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

int main(void)
{
    static uint8_t packet[CDS_PACKET_SIZE(2)], reply[2];
    static struct cds_request request = CDS_REQUEST(packet, reply);
    uint32_t turns = 0, from_us, submit_us;

    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_bus_set_return_delay(&bus, 2);

    from_us = cds_port_now_us();
    cds_servo_read(&bus, &request, 99, CDS_REG_PRESENT_POSITION, 2);
    submit_us = cds_port_now_us() - from_us;
    while (cds_bus_poll(&bus))
        turns++;
    say("us", cds_port_now_us() - from_us);
    say("submit_us", submit_us);
    say("turns", turns);
    say("result", request.result);
    say_end();
}
