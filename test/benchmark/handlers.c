/* SPDX-License-Identifier: MIT */
/* Runs every path of the handlers of a bus. Byte 0 of the EEPROM selects one of two runs. 0: good
 * transactions with packets and replies of all sizes, up to a SYNC WRITE of more than 256 bytes.
 * 1: the simulator makes a servo babble and adds noise. Bytes are damaged, the ring overflows, and
 * bytes are lost while the receive interrupt is off for three byte times. */
#include <cds55xx/sync_write.h>
#include <util/delay.h>

#include "benchmark.h"

#define BUS_CONTROL CDS_AVR_PASTE3(UCSR, BOARD_BUS0_USART, B)
#define BUS_RXCIE   (1 << 7)
#define SERVOS      50
#define BABBLE_US   200000ul
#define PERIOD_US   2000ul // between two polls: four rings are heard meanwhile

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_SYNC_WRITE_SIZE(SERVOS, 4)], reply[CDS_REPLY_MAX];
static struct cds_request request = CDS_REQUEST(packet, reply);
static uint8_t good;

static void transactions(void)
{
    for (uint8_t length = 1; length <= CDS_REPLY_MAX; length++) {
        cds_servo_read(&bus, &request, 1, CDS_REG_RESERVED_00, length);
        bench_wait(&bus);
        if (request.result == CDS_OK)
            good++;
    }
    for (uint8_t servos = 1; servos <= SERVOS; servos++) {
        cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4);
        for (uint8_t id = 1; id <= servos; id++)
            cds_sync_write_add_goal(&request, id, 512, 0);
        cds_sync_write_send(&bus, &request);
        bench_wait(&bus);
        if (request.result == CDS_OK)
            good++;
    }
}

/* Turns off only the receive interrupt: the run also measures the time with interrupts off. */
static void lose_bytes(void)
{
    BUS_CONTROL &= (uint8_t)~BUS_RXCIE;
    _delay_us(35);
    BUS_CONTROL |= BUS_RXCIE;
}

static void babble(void)
{
    for (uint32_t next_us = 0; next_us < BABBLE_US; next_us += PERIOD_US) {
        for (uint8_t i = 0; i < 4; i++) {
            cds_bus_poll(&bus);
            lose_bytes();
        }
        while (cds_port_now_us() < next_us) {
        }
    }
}

int main(void)
{
    struct cds_stats count;

    bench_open(&bus);
    if (bench_option(0) == 0)
        transactions();
    else
        babble();
    cds_bus_stats(&bus, &count);
    say("good", good);
    say("framing_errors", count.framing_errors);
    say("overruns", count.overruns);
    say("ring_overflows", count.ring_overflows);
    say_end();
}
