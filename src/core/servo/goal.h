/* SPDX-License-Identifier: MIT */
/* A goal as GOAL_POSITION and MOVING_SPEED, which stand side by side: both words low byte first
 * (R28). */
#ifndef CDS_GOAL_H
#define CDS_GOAL_H

#include <stdint.h>

#define CDS_GOAL_SIZE 4 // bytes

static inline void cds_goal_put(uint8_t data[CDS_GOAL_SIZE], uint16_t position, uint16_t speed)
{
    data[0] = (uint8_t)position;
    data[1] = (uint8_t)(position >> 8);
    data[2] = (uint8_t)speed;
    data[3] = (uint8_t)(speed >> 8);
}

#endif
