/* SPDX-License-Identifier: MIT */
/* The parser over a request without data: a suite reads whole lines with read_line(). */
#ifndef LINE_RIG_H
#define LINE_RIG_H

#include <string.h>

#include "console/errors.h"
#include "console/parse.h"
#include "unity.h"

static uint8_t packet[258];
static struct cds_request request;
static struct command_line line;

/* setUp() */
static inline void begin_request(void)
{
    request = (struct cds_request)CDS_REQUEST_WITHOUT_DATA(packet);
    line.request = &request;
    parse_begin(&line);
}

/* Reads a line: its error, or 0. Bytes of the packet that it does not use are 0xEE. */
static inline uint8_t read_line(const char *text)
{
    struct token token = {0};

    parse_begin(&line);
    memset(packet, 0xEE, sizeof packet);
    for (;; text++) {
        bool block = parse_in_block(&line) && (*text == ':' || *text == ',');

        if (*text != '\0' && *text != ' ' && !block) {
            token_add(&token, *text);
            continue;
        }
        if (token.length || block)
            parse_word(&line, &token, block ? *text : ' ');
        token.length = 0; // its text stays
        if (*text == '\0')
            return parse_end(&line);
    }
}

#endif
