/* Ring: every function, with any indices. The indices and bytes are volatile, so Eva assumes that
 * the other side may change them between any two reads. */
#include "cds55xx/ring.h"

#include "any.h"

static struct cds_ring ring;

void eva_ring(void)
{
    uint8_t sum = 0;

    while (any_bool()) {
        switch (any_in(0, 3)) {
        case 0: cds_ring_put(&ring, any_byte()); break;
        case 1: sum = (uint8_t)(sum + cds_ring_peek(&ring, any_byte())); break;
        case 2: cds_ring_drop(&ring, any_byte()); break;
        default: sum = cds_ring_count(&ring);
        }
    }
}
