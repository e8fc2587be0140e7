/* SPDX-License-Identifier: MIT */
/* A program refuses a library that was built for another chip: the linker ends with
 * "undefined reference to cds55xx_library_is_for_atmega2560_but_program_is_for_atmega328p".
 *
 * Each library has the symbol of its own chip (src/avr/library.S), and for each other chip a symbol
 * in an archive member of its own that needs this symbol, which nothing defines. */
#ifndef CDS_AVR_LIBRARY_H
#define CDS_AVR_LIBRARY_H

#define CDS_AVR_LIBRARY_TEXT_(word) #word
#define CDS_AVR_LIBRARY_NAME_(chip) "cds55xx_library_for_" CDS_AVR_LIBRARY_TEXT_(chip)

#ifdef __cplusplus
extern "C" {
#endif
extern const char cds_avr_library __asm__(CDS_AVR_LIBRARY_NAME_(__AVR_DEVICE_NAME__));
#ifdef __cplusplus
}
#endif

/* Refers to the symbol by a relocation that changes no byte: takes no flash. */
#define CDS_AVR_REFER_TO_LIBRARY_()                                                                \
    __asm__ volatile(".reloc ., R_AVR_NONE, %0" ::"i"(&cds_avr_library))

#endif
