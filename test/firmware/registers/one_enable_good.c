/* One enable, right. */
#include "wiring.h"
