/* SPDX-License-Identifier: MIT */
/* A robot with a handler that takes 25 us. Packets have gaps between their bytes; the driver must
 * be released at the last stop bit, not at a stale transmit complete. The program sends only
 * broadcasts, because such a handler is too long to receive replies. */
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>
#include <util/delay.h>

#include "say.h"

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

ISR(TIMER0_COMP_vect)
{
    _delay_us(25);
}

int main(void)
{
    static uint8_t packet[CDS_PACKET_SIZE(3)];
    static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);

    say_open();
    cds_avr_clock_open();
    TCCR0 = 1 << WGM01 | 1 << CS01; // clear on compare, F_CPU / 8
    OCR0 = 66;                      // every 33.5 us, which is no multiple of a byte time
    TIMSK |= 1 << OCIE0;
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    for (uint16_t goal = 0; goal < 500; goal++) {
        cds_servo_write_word(&bus, &request, CDS_BROADCAST_ID, CDS_REG_GOAL_POSITION, goal);
        while (cds_bus_poll(&bus)) {
        }
    }
    say("result", request.result);
    say_end();
}
