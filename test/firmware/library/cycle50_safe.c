/* cycle50.c with safety as examples/robot.c has it: limits of goal and speed, retries, and the
 * health check beside the cycle. */
#define SAFE
#define SPEED 512
#include "cycle50.c"
