/* SPDX-License-Identifier: MIT */
/* absent.c with a poll that waits until the transaction is over. For a test that `absent_blocked`
 * shows such a poll. */
#include "benchmark.h"

static bool wait_till_over(struct cds_bus *bus)
{
    bench_wait(bus);
    return false;
}

#define cds_bus_poll(bus) wait_till_over(bus)

#include "absent.c"
