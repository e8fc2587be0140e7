/* SPDX-License-Identifier: MIT */
/* The parser as the bus knows it, for the analysis of the bus. Each function checks what parser.c
 * needs and returns anything that parser.c may return; eva_find() and eva_take() prove both. */
#include <stddef.h>

#include "eva.h"

static void leave_packet(struct cds_parser *parser)
{
    parser->found = CDS_FOUND_NOTHING;
    parser->position = any_byte();
}

void cds_parser_skip_damage(struct cds_parser *parser, struct cds_ring *ring, uint8_t position)
{
    (void)ring, (void)position;
    leave_packet(parser);
    parser->is_clean = false;
}

uint8_t cds_parser_find(struct cds_parser *parser, struct cds_ring *ring, uint8_t end)
{
    uint8_t parsed = (uint8_t)any_in(CDS_PARSED_MORE, CDS_PARSED_MALFORMED);

    eva_keep_apart();
    //@ assert parser->found != CDS_FOUND_HEAD;
    //@ assert parser->longest <= CDS_PARSER_LENGTH_MAX;
    if (parser->found == CDS_FOUND_LENGTH) {
        //@ assert CDS_LENGTH_MIN <= parser->length <= CDS_PARSER_LENGTH_MAX;
    }
    //@ split parsed;
    leave_packet(parser);
    parser->noise_bytes = any_word();
    parser->id = any_byte();
    if (parsed == CDS_PARSED_MALFORMED)
        cds_parser_skip_damage(parser, ring, end);
    parser->length = (uint8_t)any_in(CDS_LENGTH_MIN, CDS_PARSER_LENGTH_MAX);
    if (parsed == CDS_PARSED_MORE)
        parser->found = any_bool() ? CDS_FOUND_LENGTH : CDS_FOUND_NOTHING;
    if (parsed == CDS_PARSED_HEAD) {
        parser->found = CDS_FOUND_HEAD;
        parser->error = any_byte();
        parser->to = NULL;
        eva_remaining = (uint8_t)(parser->length - CDS_LENGTH_MIN);
    }
    return parsed == CDS_PARSED_PACKET ? CDS_PARSED_SOME : parsed;
}

uint8_t cds_parser_take_some(struct cds_parser *parser, struct cds_ring *ring, uint8_t end)
{
    uint8_t taken = (uint8_t)any_in(0, CDS_PARSER_TAKEN_MAX);

    eva_keep_apart();
    //@ assert parser->found == CDS_FOUND_HEAD;
    //@ split eva_remaining;
    //@ split taken;
    if (taken > eva_remaining)
        taken = eva_remaining;
    //@ loop unroll CDS_PARSER_TAKEN_MAX;
    for (uint8_t i = 0; i < taken; i++)
        if (parser->to)
            *parser->to++ = any_byte();
    eva_remaining = (uint8_t)(eva_remaining - taken);
    parser->position = any_byte();
    if (eva_remaining || any_bool())
        return CDS_PARSED_SOME;
    if (any_bool()) {
        cds_parser_skip_damage(parser, ring, end);
        return CDS_PARSED_MALFORMED;
    }
    leave_packet(parser);
    return CDS_PARSED_PACKET;
}
