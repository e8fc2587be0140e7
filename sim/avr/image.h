/* SPDX-License-Identifier: MIT */
/* The firmware's ELF file: loads code, initialised data and EEPROM into the simulated chip. */
#ifndef SIM_IMAGE_H
#define SIM_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <simavr/sim_avr.h>

struct image {
    const char *path;
    uint8_t *file;
    size_t size;
    uint32_t code_end; // flash address after the last byte of code
};

/* Returns false, with one line on stderr, if the file cannot be read or is no AVR program. */
bool image_open(struct image *image, const char *path);
void image_close(struct image *image);

/* Returns false, with one line on stderr, if the program was linked for another chip or does not
 * fit. */
bool image_load(struct image *image, avr_t *avr, const char *mcu);

#endif
