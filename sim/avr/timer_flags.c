/* SPDX-License-Identifier: MIT */
#include "avr/timer_flags.h"

#include <simavr/sim_interrupts.h>
#include <simavr/sim_regbit.h>

#include "avr/cpu.h"

/* Data addresses of TIFR0 to TIFR5, and of TIFR and ETIFR of an ATmega128, which has ports at the
 * other addresses. */
static const avr_io_addr_t registers[] = {0x35, 0x36, 0x37, 0x38, 0x39, 0x3A, 0x56, 0x7C};

static void flags_written(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    (void)param;
    for (unsigned i = 0; i < avr->interrupts.vector_count; i++) {
        avr_int_vector_t *vector = avr->interrupts.vector[i];
        if (vector->raised.reg == address && value >> vector->raised.bit & vector->raised.mask) {
            cpu_set_level_interrupt(avr, vector, false);
            avr_regbit_clear(avr, vector->raised);
        }
    }
}

static int holds_flags(const avr_t *avr, avr_io_addr_t address)
{
    for (unsigned i = 0; i < avr->interrupts.vector_count; i++) {
        if (avr->interrupts.vector[i]->raised.reg == address) {
            return 1;
        }
    }
    return 0;
}

void timer_flags_init(avr_t *avr)
{
    for (unsigned i = 0; i < sizeof(registers) / sizeof(registers[0]); i++) {
        if (holds_flags(avr, registers[i])) {
            avr->io[AVR_DATA_TO_IO(registers[i])].w.c = flags_written;
        }
    }
}
