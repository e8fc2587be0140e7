/* SPDX-License-Identifier: MIT */
/* What the library asks of the compiler, each by its usual name. For src/core and src/controller.
 */
#ifndef CDS_COMPILER_H
#define CDS_COMPILER_H

/* The compiler forgets where `pointer` comes from. Where a program has one struct, its address is
 * known at link time, and an AVR needs 4 bytes of code to reach a field by that, but 2 behind a
 * pointer if the field is among the first 64 bytes. */
#define OPTIMIZER_BARRIER(pointer) __asm__("" : "+r"(pointer))

/* Not merged into its callers: the registers it needs are saved only where it is called. */
#define NOINLINE __attribute__((noinline))

/* NOINLINE for a function that a header has declared. */
#define DECLARED_NOINLINE(function) extern __typeof__(function) function NOINLINE

/* Neither merged nor copied for a bus that is known when the program is linked: saves flash. Where
 * the time of a byte counts, use NOINLINE: the compiler may then make that copy. */
#define NOCLONE __attribute__((noclone, noinline))

/* NOCLONE, and kept out of the way of what runs for every byte and every transaction. */
#define COLD __attribute__((noinline, noclone, cold))

/* Merged into each caller. */
#define ALWAYS_INLINE static inline __attribute__((always_inline))

#endif
