/* Small code for structs of which a program has one. There the compiler knows the address, and an
 * AVR takes 4 bytes of code to reach a variable by that, but 2 to reach a field behind a pointer,
 * if it is among the first 64 bytes. So structs have what is used often in front, and who moves an
 * operation on hides where it is. For src/core and src/controller. */
#ifndef CDS_COMPILER_H
#define CDS_COMPILER_H

/* From here on nothing is known of this pointer. */
#define OPTIMIZER_BARRIER(pointer) __asm__("" : "+r"(pointer))

/* Not copied into its callers: seldom run, or called from several places; registers that it needs
 * are saved only where it is called. */
#define NOINLINE __attribute__((noinline))

/* The same of a function that a header has declared. */
#define DECLARED_NOINLINE(function) extern __typeof__(function) function NOINLINE

#endif
