/* SPDX-License-Identifier: MIT */
/* READs of 50 bytes, with a handler of the program that is as long as avr.h allows, or
 * longer. It runs every 1000 cycles, at other phases of the bytes in each READ. Byte 0 of the
 * EEPROM is its number of loops of 3 cycles. Interrupts are off for 24 cycles plus the loops, from
 * its entry (4 cycles) to the end of reti. */
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>
#include <util/delay_basic.h>

#include "say.h"

#define READS 480 // a byte is 160 cycles, and the phase moves by 3 from READ to READ

#ifdef TCCR0A // all but the ATmega128
#define FOREIGN_VECTOR TIMER0_COMPA_vect
#define FOREIGN_PERIOD OCR0A
#define FOREIGN_ENABLE (TIMSK0 |= 1 << OCIE0A)
#define FOREIGN_START  (TCCR0A = 1 << WGM01, TCCR0B = 1 << CS01)
#else
#define FOREIGN_VECTOR TIMER0_COMP_vect
#define FOREIGN_PERIOD OCR0
#define FOREIGN_ENABLE (TIMSK |= 1 << OCIE0)
#define FOREIGN_START  (TCCR0 = 1 << WGM01 | 1 << CS01)
#endif

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_PACKET_SIZE(2)], reply[CDS_REPLY_MAX];
static struct cds_request request = CDS_REQUEST(packet, reply);
__attribute__((used)) static volatile uint8_t loops;

ISR(FOREIGN_VECTOR, ISR_NAKED CDS_AVR_NEAR) // reached by rjmp
{
    __asm__ volatile("push r24              \n\t" // 4 of the entry and 2 of the vector before it; 2
                     "in   r24, __SREG__    \n\t" // 1
                     "push r24              \n\t" // 2
                     "lds  r24, %[loops]    \n\t" // 2
                     "nop                   \n\t" // 1
                     "nop                   \n\t" // 1
                     "nop                   \n\t" // 1
                     "1: dec r24            \n\t" // 3 for each loop, the last one 2
                     "brne 1b               \n\t"
                     "pop  r24              \n\t" // 2
                     "out  __SREG__, r24    \n\t" // 1
                     "pop  r24              \n\t" // 2
                     "reti                  \n\t" // 4
                     :
                     : [loops] "i"(&loops));
}

static uint8_t read(uint16_t phase)
{
    _delay_loop_2(1000);
    while (phase--)
        _delay_loop_1(1); // 3 cycles, and those of the loop
    cds_servo_read(&bus, &request, 1, 0, CDS_REPLY_MAX);
    while (cds_bus_poll(&bus)) {
    }
    return request.result;
}

int main(void)
{
    uint16_t good = 0;
    struct cds_stats count;

    loops = eeprom_read_byte((const uint8_t *)0);
    say_open();
    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_servo_write_byte(&bus, &request, 1, CDS_REG_RETURN_DELAY, 50); // the turnaround may wait
    while (cds_bus_poll(&bus)) {
    }
    FOREIGN_PERIOD = 124; // of 8 cycles each
    FOREIGN_ENABLE;
    FOREIGN_START;
    for (uint16_t i = 0; i < READS; i++)
        if (read(i) == CDS_OK)
            good++;
    cds_bus_stats(&bus, &count);
    say("good", good);
    say("reads", READS);
    say("overruns", count.overruns);
    say_end();
}
