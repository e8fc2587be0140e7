/* SPDX-License-Identifier: MIT */
/* Checks what malloc(), calloc() and realloc() return. */
#ifndef SIM_MEMORY_H
#define SIM_MEMORY_H

/* Returns `memory`. Aborts with a message on stderr if it is 0. */
void *memory_checked(void *memory);

#endif
