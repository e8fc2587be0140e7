/* cycle50.c with a roster of all servos: what it costs. */
#define ROSTER
#include "cycle50.c"
