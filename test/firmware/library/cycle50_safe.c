/* SPDX-License-Identifier: MIT */
/* cycle50.c with the safety of examples/robot.c: limits of goal and speed, retries, and the health
 * check. */
#define SAFE
#define SPEED 512
#include "cycle50.c"
