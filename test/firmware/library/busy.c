/* SPDX-License-Identifier: MIT */
/* Keeps the bus busy, for `make sim-speed`: sends goals to all servos and reads the present values
 * of each, without a pause. The servos have IDs from 1 on without a gap, at most 50. */
#include <cds55xx/sync_write.h>
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>

#define SERVOS_MAX 50

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static void wait(void)
{
    while (cds_bus_poll(&bus)) {
    }
}

int main(void)
{
    static uint8_t packet[CDS_SYNC_WRITE_SIZE(SERVOS_MAX, 4)], reply[8];
    static struct cds_request request = CDS_REQUEST(packet, reply);
    uint8_t servos = 0;

    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    for (;;) {
        cds_servo_ping(&bus, &request, (uint8_t)(servos + 1));
        wait();
        if (request.result != CDS_OK || servos == SERVOS_MAX) {
            break;
        }
        servos++;
    }
    cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1);
    wait();
    for (uint16_t goal = 0;; goal = (uint16_t)((goal + 1) & 0x3FF)) {
        cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4);
        for (uint8_t id = 1; id <= servos; id++) {
            cds_sync_write_add_goal(&request, id, goal, 0);
        }
        cds_sync_write_send(&bus, &request);
        wait();
        for (uint8_t id = 1; id <= servos; id++) {
            cds_servo_read(&bus, &request, id, CDS_REG_PRESENT_POSITION, 8);
            wait();
        }
    }
}
