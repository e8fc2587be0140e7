/* SPDX-License-Identifier: MIT */
/* Builds and sends a SYNC WRITE of position and speed, four times. Byte 0 of the EEPROM is the
 * number of servos. */
#include <cds55xx/sync_write.h>

#include "benchmark.h"

#define SERVOS_MAX 50

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_SYNC_WRITE_SIZE(SERVOS_MAX, 4)];
static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);
static volatile uint16_t goals[SERVOS_MAX];
static volatile uint16_t speed = 300;

BENCH_NOINLINE static void build(uint8_t servos)
{
    mark(MARK_BUILD);
    cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4);
    for (uint8_t i = 0; i < servos; i++)
        cds_sync_write_add_goal(&request, (uint8_t)(i + 1), goals[i], speed);
    unmark(MARK_BUILD);
}

BENCH_NOINLINE static enum cds_result send(void)
{
    enum cds_result result;

    mark(MARK_CALL);
    result = cds_sync_write_send(&bus, &request);
    unmark(MARK_CALL);
    return result;
}

int main(void)
{
    uint8_t servos = bench_option(0), good = 0;

    bench_open_bare(&bus);
    cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1);
    bench_wait(&bus);
    for (uint8_t turn = 0; turn < 4; turn++) {
        for (uint8_t i = 0; i < servos; i++)
            goals[i] = (uint16_t)(500 + i + turn);
        build(servos);
        if (send() == CDS_OK)
            good++;
        bench_wait(&bus);
    }
    say("good", good);
    say_end();
}
