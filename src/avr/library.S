/* SPDX-License-Identifier: MIT */
/* The symbol by which a program finds out that this library is for its chip: cds55xx/avr/library.h.
 * With PROGRAM_MCU defined: the member of the archive that a program for another chip gets. */
#define PASTE_(a, b) a##b
#define PASTE(a, b)  PASTE_(a, b)

#ifndef PROGRAM_MCU
#define SYMBOL PASTE(cds55xx_library_for_, __AVR_DEVICE_NAME__)
    .global SYMBOL
    .set    SYMBOL, 0
#else
#define SYMBOL PASTE(cds55xx_library_for_, PROGRAM_MCU)
#define ERROR  PASTE(PASTE(cds55xx_library_is_for_, __AVR_DEVICE_NAME__), PASTE(_but_program_is_for_, PROGRAM_MCU))
    .global SYMBOL
SYMBOL:
    .word   ERROR
#endif
