/* The microsecond clock: a 16-bit timer at F_CPU / 8, two ticks a microsecond, and a count of its
 * overflows, every 32 768 us. Manual: nothing. */
#ifndef AVR_CLOCK_H
#define AVR_CLOCK_H

#include <stdint.h>

#define AVR_CLOCK_OVERFLOW_US 32768u

#ifdef __cplusplus
extern "C" {
#endif

/* What the clock knows besides its timer. */
struct cds_avr_clock {
    volatile uint8_t overflows[3]; // low byte first; written by the handler
};

/* The program's one clock; CDS_AVR_CLOCK() of cds55xx_avr.h defines it. The linker knows it by a
 * name with the chip, so it refuses a library that was built for another chip. */
#define AVR_TEXT_(word)       #word
#define AVR_CLOCK_NAME_(chip) "cds_avr_clock_for_" AVR_TEXT_(chip)
extern struct cds_avr_clock cds_avr_clock __asm__(AVR_CLOCK_NAME_(__AVR_DEVICE_NAME__));

/* Starts the clock, at 0 us if nobody had the timer run before. Main context, once, before the
 * first bus is opened. */
void cds_avr_clock_open(void);

/* Begins to count the overflows. Main context, by cds_avr_clock_open(). */
void cds_avr_clock_count_(void);

#ifdef __cplusplus
}
#endif

#endif
