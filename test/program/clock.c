/* The microsecond clock, read with interrupts on and off all around the overflow of its timer: it
 * never goes back and never jumps. Says how often it did, and how many alarms rang early or late.
 */
#include <cds55xx/port.h>
#include <cds55xx_avr.h>

#include "say.h"

CDS_AVR_CLOCK()

#define LONGEST_STEP_US 20 // two readings and the handler between them

#define LATEST_RING_US 30 // a look at the alarm, that at the clock, and its handler between them

/* How late the alarm rings that is set to `us` after now, `late_us` after now: it must never ring
 * early. Looked at all the time. */
static int32_t ringing_late_us(uint32_t us, uint16_t late_us)
{
    uint16_t from_us = cds_port_short_us();
    uint32_t from = cds_port_now_us();
    uint8_t laps;

    while (cds_port_now_us() - from < late_us) {
    }
    laps = cds_port_set_alarm(0, from_us, us);
    for (;;) {
        while (!cds_port_alarm_rings(0)) {
        }
        if (laps == 0)
            return (int32_t)(cds_port_now_us() - from - us);
        laps--;
        cds_port_silence_alarm(0);
    }
}

static uint32_t wrong_alarms(void)
{
    static const uint32_t lasts_us[] = {700, 20000, 32768, 40000, 81000, 98304};
    static const uint16_t late_us[] = {0, 100, 9000, 16000};
    uint32_t wrong = 0;

    for (uint8_t i = 0; i < sizeof lasts_us / sizeof *lasts_us; i++)
        for (uint8_t j = 0; j < sizeof late_us / sizeof *late_us; j++) {
            uint32_t us = lasts_us[i];
            int32_t late = ringing_late_us(us, late_us[j]);

            if (late_us[j] > us)
                late -= late_us[j] - (int32_t)us; // it cannot ring before it is set
            if (late < 0 || late > LATEST_RING_US)
                wrong++;
        }
    return wrong;
}

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
    say("alarms", wrong_alarms());
    say_end();
}
