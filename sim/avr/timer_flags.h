/* SPDX-License-Identifier: MIT */
/* Corrects the interrupt flags of timers. In silicon, writing 1 to a flag clears this flag. In
 * simavr it clears every flag of the register with its interrupt: a clock that counts overflows
 * loses one if the firmware clears a compare flag between an overflow and its handler. */
#ifndef SIM_TIMER_FLAGS_H
#define SIM_TIMER_FLAGS_H

#include <simavr/sim_avr.h>

/* Call it after simavr has made its chip. */
void timer_flags_init(avr_t *avr);

#endif
