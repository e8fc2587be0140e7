/* Parser: any bytes and indices in the ring, any end, any state that a search before has left. */
#include "cds55xx/parser.h"

#include "any.h"

static struct cds_ring ring;
static struct cds_parser parser;

void eva_parser(void)
{
    while (any_bool()) {
        parser.longest = any_byte();
        parser.id = any_byte();
        parser.length = any_byte();
        parser.error = any_byte();
        parser.is_clean = any_bool();
        parser.stray = any_word();
        switch (any_in(0, 3)) {
        case 0: cds_parser_step(&parser, &ring, any_byte()); break;
        case 1: cds_parser_is_whole(&parser, &ring, any_byte()); break;
        case 2: cds_parser_take(&parser, &ring); break;
        default: cds_parser_refute(&parser, &ring);
        }
    }
}
