/* Interrupt flags of timers: in silicon a 1 that is written clears its own flag. In simavr every
 * flag of the register is gone, with its interrupt: a clock that counts overflows loses one when a
 * compare flag is cleared between an overflow and its handler. */
#ifndef SIM_TIMER_FLAGS_H
#define SIM_TIMER_FLAGS_H

#include <simavr/sim_avr.h>

/* Takes the registers over; after simavr has made its chip. */
void timer_flags_init(avr_t *avr);

#endif
