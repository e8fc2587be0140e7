/* SPDX-License-Identifier: MIT */
/* handlers.c with a receive handler that is 40 cycles slower. For a test that the benchmark notices
 * it. The slow handler has the name of the vector and jumps to the handler of the library, which
 * has another name in this program. */
#include <avr/io.h>

#define VECTOR __vector_30 // USART1_RX_vect of an ATmega128
#undef USART1_RX_vect
#define USART1_RX_vect __vector_of_the_library

#include "handlers.c"

void VECTOR(void) __attribute__((signal, naked, used, externally_visible)) CDS_AVR_NEAR;
void VECTOR(void)
{
    __asm__ volatile(".rept 40\n\tnop\n\t.endr\n\tjmp __vector_of_the_library");
}
