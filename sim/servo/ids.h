/* SPDX-License-Identifier: MIT */
/* Parses a list of servo IDs: 1-18 or 0,1,5-7. */
#ifndef SIM_IDS_H
#define SIM_IDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define IDS_MAX 254 // IDs are 0 to 253

/* Returns 0, or what is wrong with the text. */
const char *ids_parse(const char *text, bool allow_duplicates, uint8_t ids[IDS_MAX],
                      unsigned *count);

/* Parses a list in which an ID may occur twice. Sets the elements of its IDs to true, and changes
 * no other. Returns 0, or what is wrong with the text: then it changes none. */
const char *ids_parse_set(const char *text, bool set[IDS_MAX]);

/* Writes the set as a list, 1-3,7, or "none". A list that is too long ends in "..". */
const char *ids_print(const bool set[IDS_MAX], char *text, size_t capacity);

#endif
