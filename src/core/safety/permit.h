/* Checks every packet before it is sent, whether struct cds_servos knows its ID or not. Main
 * context. */
#ifndef CDS_PERMIT_H
#define CDS_PERMIT_H

#include "cds55xx/servos.h" // struct cds_servos

/* Checks the whole packet `bytes`. CDS_OK: it may leave; CDS_INHIBITED: driving is inhibited, and
 * the packet can drive a servo; CDS_TOO_EARLY: the packet sets a return delay below
 * roster->shortest_delay.
 *
 * PING, READ and writes for which cds_span_may_move() is false cannot drive a servo. Every other
 * instruction can, also one that the manual does not name. A SYNC WRITE whose length is no whole
 * number of blocks counts as one that can, and so does a PING or READ with too many parameters. */
enum cds_result cds_permit_check(const struct cds_servos *roster, const uint8_t *bytes);

#endif
