/* Unknown values for the entry points of the analysis. Eva considers every value of the range. */
#ifndef EVA_ANY_H
#define EVA_ANY_H

#include <stdbool.h>
#include <stdint.h>

#include <__fc_builtin.h>

static volatile uint8_t eva_any_bit_; // Eva reads any value from a volatile variable

static inline uint8_t any_byte(void)
{
    return (uint8_t)Frama_C_unsigned_int_interval(0, UINT8_MAX);
}

static inline uint16_t any_word(void)
{
    return (uint16_t)Frama_C_unsigned_int_interval(0, UINT16_MAX);
}

static inline uint16_t any_in(uint16_t lowest, uint16_t highest)
{
    return (uint16_t)Frama_C_unsigned_int_interval(lowest, highest);
}

static inline bool any_bool(void)
{
    return eva_any_bit_ & 1;
}

#endif
