/* SPDX-License-Identifier: MIT */
/* Two servos, IDs 1 and 2, to and fro in step: the shortest program, without any check. */
#include <cds55xx/sync_write.h>
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>
#include <util/delay.h>

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

int main(void)
{
    static uint8_t packet[CDS_SYNC_WRITE_SIZE(2, 4)];
    static struct cds_request request = CDS_REQUEST_WITHOUT_DATA(packet);

    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    _delay_ms(1000); // the servos start up
    cds_servo_write_byte(&bus, &request, CDS_BROADCAST_ID, CDS_REG_TORQUE_ENABLE, 1);
    for (uint16_t goal = 200;; goal = 1000 - goal) {
        while (cds_bus_poll(&bus)) {
        }
        cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4);
        cds_sync_write_add_goal(&request, 1, goal, 512);
        cds_sync_write_add_goal(&request, 2, 1000 - goal, 512);
        cds_sync_write_send(&bus, &request);
        _delay_ms(1000);
    }
}
