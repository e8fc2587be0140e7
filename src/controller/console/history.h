/* SPDX-License-Identifier: MIT */
/* The latest lines typed, oldest first, each with a NUL behind it. The oldest lines make room for a
 * new one. Zero it (static storage is). Main context. */
#ifndef CONTROLLER_HISTORY_H
#define CONTROLLER_HISTORY_H

#include <stdint.h>

#if defined __AVR__
#include <avr/io.h> // RAMEND
#define HISTORY_SIZE (RAMEND > 0x1FFF ? 240 : 96)
#else
#define HISTORY_SIZE 96
#endif

struct history {
    uint8_t used; // bytes of `text` that hold lines
    uint8_t at;   // where the line begins that was fetched last; `used`: none was fetched
    char text[HISTORY_SIZE];
};

/* Adds a line of 0 to HISTORY_SIZE - 1 characters and ends the search. An empty line, and a line
 * equal to the newest one, are not added. */
void history_add(struct history *history, const char *line, uint8_t length);

/* Each copies a line to `line`, which has room for the longest line added, and returns its
 * length. history_older() returns 0 if there is no older line; history_newer() returns 0 behind the
 * newest line. */
uint8_t history_older(struct history *history, char *line);
uint8_t history_newer(struct history *history, char *line);

#endif
