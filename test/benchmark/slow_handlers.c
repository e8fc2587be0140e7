/* handlers.c with a receive handler that is 40 cycles slower, for the test that this is noticed:
 * what stands in the vector table comes before the library's handler, which has another name. */
#include <avr/io.h>

#define VECTOR __vector_30 // USART1_RX_vect of an ATmega128
#undef USART1_RX_vect
#define USART1_RX_vect __vector_of_the_library

#include "handlers.c"

void VECTOR(void) __attribute__((signal, naked, used, externally_visible)) AVR_NEAR;
void VECTOR(void)
{
    __asm__ volatile(".rept 40\n\tnop\n\t.endr\n\tjmp __vector_of_the_library");
}
