/* SPDX-License-Identifier: MIT */
/* READs of 2 bytes at the return delays 2, 4, ... 32 us, from servos 1, 2, ... 16 in turn, with 50
 * servos and their limits. Each READ runs between two overflows of the clock, so that no other
 * handler runs. */
#include "safe.h"

#define DELAYS 16

static volatile uint8_t address = CDS_REG_PRESENT_POSITION, length = 2;

BENCH_NOINLINE static void read(uint8_t id, uint8_t from, uint8_t count)
{
    request.servo_index = (uint8_t)(id - 1);
    mark(MARK_WHOLE);
    cds_servo_read(&bus, &request, id, from, count);
    while (cds_bus_poll(&bus)) {
    }
    unmark(MARK_WHOLE);
}

int main(void)
{
    uint8_t good = safe_open(), lap;

    for (uint8_t n = 1; n <= DELAYS; n++)
        cds_blocking_write_byte(&bus, &request, n, CDS_REG_RETURN_DELAY, n);
    lap = bench_new_lap();
    cds_blocking_ping(&bus, &request, SERVOS); // the servo before servo 1
    for (uint8_t n = 1; n <= DELAYS; n++) {
        uint16_t position = 0;

        read(n, address, length);
        if (cds_request_word(&request, 0, &position) == CDS_OK && position == MIDDLE)
            good++;
    }
    say("good", good);
    say("torn", bench_lap() != lap);
    say_end();
}
