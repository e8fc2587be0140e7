/* The parts of a packet that writes registers: the data that it has for each servo. */
#ifndef CDS_PART_H
#define CDS_PART_H

#include "safety/limits.h" // struct cds_span

/* Data for servo `id`, or for all servos if it is CDS_BROADCAST_ID. */
struct cds_part {
    struct cds_span span;
    uint8_t id, instruction;
};

/* Part `index` (from 0 on) of the packet `bytes`, a WRITE, REG WRITE or SYNC WRITE. False: the
 * packet has no such part. The rest of a SYNC WRITE that is shorter than a block is no part. */
bool cds_part_of(const uint8_t *bytes, uint8_t index, struct cds_part *part);

/* True if this write can drive a servo: a goal, a speed (0 too), an angle limit, or torque on. An
 * angle limit changes the mode, and in endless turn the speed register makes the servo turn. */
bool cds_span_drives(const struct cds_span *span);

/* True if this write can move a servo whose torque may be on: a write that drives, or one of a
 * compliance margin, a proportion or the punch, which decide how far from its goal the servo stands
 * still. */
bool cds_span_may_move(const struct cds_span *span);

#endif
