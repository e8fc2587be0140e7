/* What no servo is sent, whether the roster knows the servo or not. The roster asks this before it
 * looks up a servo. */
#ifndef CDS_GATE_H
#define CDS_GATE_H

#include "cds55xx/roster.h" // struct cds_roster

/* May the packet `bytes` leave? CDS_OK; CDS_HELD: driving is inhibited, and the packet can drive a
 * servo; CDS_TOO_EARLY: it sets a return delay below roster->shortest_delay.
 *
 * PING, READ and a write that cannot drive a servo never drive. Every other instruction can, an
 * unknown one too: a servo may know more than the manual tells. */
enum cds_result cds_gate_check(const struct cds_roster *roster, const uint8_t *bytes);

#endif
