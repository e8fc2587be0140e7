/* SPDX-License-Identifier: MIT */
/* Unknown values for the analysis. Eva considers every value of the range. */
#ifndef EVA_H
#define EVA_H

#include <__fc_builtin.h>
#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/parser.h" // struct cds_parser

static inline uint16_t any_in(uint16_t lowest, uint16_t highest)
{
    return (uint16_t)Frama_C_unsigned_int_interval(lowest, highest);
}

static inline uint8_t any_byte(void)
{
    return (uint8_t)any_in(0, UINT8_MAX);
}

static inline uint16_t any_word(void)
{
    return any_in(0, UINT16_MAX);
}

static inline bool any_bool(void)
{
    return any_in(0, 1);
}

/* Parameters of the packet in the parser that were not taken. For parser_contract.c. */
extern uint8_t eva_remaining;

void eva_keep_apart(void);

#endif
