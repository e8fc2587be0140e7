/* The microsecond clock, read with interrupts on and off all around the overflow of its timer: it
 * never goes back and never jumps. Says how often it did. */
#include <cds55xx/port.h>
#include <cds55xx_avr.h>

#include "say.h"

CDS_AVR_CLOCK()

#define LONGEST_STEP_US 20 // two readings and the handler between them

int main(void)
{
    uint32_t wrong = 0, readings = 0, before_us, now_us = 0;

    say_open();
    cds_avr_clock_open();
    sei();
    while (now_us < 10ul * AVR_CLOCK_OVERFLOW_US) {
        before_us = now_us;
        if (readings & 1) { // every other pair without interrupts: the overflow then waits for us
            cli();
            before_us = cds_port_now_us();
        }
        now_us = cds_port_now_us();
        sei();
        if (now_us - before_us > LONGEST_STEP_US)
            wrong++;
        readings++;
    }
    say("readings", readings);
    say("wrong", wrong);
    say_end();
}
