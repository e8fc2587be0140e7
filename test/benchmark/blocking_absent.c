/* absent.c on a library whose poll would wait until all is over, for the test that this is noticed.
 */
#include "benchmark.h"

static bool wait_till_over(struct cds_bus *bus)
{
    bench_wait(bus);
    return false;
}

#define cds_bus_poll(bus) wait_till_over(bus)

#include "absent.c"
