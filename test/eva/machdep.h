/* SPDX-License-Identifier: MIT */
/* The types of avr-gcc for Frama-C's headers; see machdep.ml. */
#define __FC_MACHDEP_GCC_X86_16
#include <__fc_machdep.h>
#undef __PTRDIFF_T
#define __PTRDIFF_T int
#undef __FC_PTRDIFF_MIN
#define __FC_PTRDIFF_MIN __FC_INT_MIN
#undef __FC_PTRDIFF_MAX
#define __FC_PTRDIFF_MAX __FC_INT_MAX
#undef __INTPTR_T
#define __INTPTR_T int
#undef __UINTPTR_T
#define __UINTPTR_T unsigned int
