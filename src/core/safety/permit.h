/* The check of every packet before it is sent, for IDs that the roster knows and IDs that it does
 * not. The roster asks it before it looks up a servo. Main context. */
#ifndef CDS_PERMIT_H
#define CDS_PERMIT_H

#include "cds55xx/servos.h" // struct cds_servos

/* May the whole packet `bytes` leave? CDS_OK; CDS_INHIBITED: driving is inhibited, and the packet
 * can drive a servo; CDS_TOO_EARLY: it sets a return delay below roster->shortest_delay.
 *
 * PING, READ and writes for which cds_span_may_move() is false cannot drive a servo. Every other
 * instruction can, an unknown one too: a servo may know more than the manual tells. So can a SYNC
 * WRITE whose length is no whole number of blocks, and a PING or READ with more parameters than it
 * has: what a servo makes of the rest is not known. */
enum cds_result cds_gate_check(const struct cds_servos *roster, const uint8_t *bytes);

#endif
