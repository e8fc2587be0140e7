/* SPDX-License-Identifier: MIT */
/* The smallest program with the five calls by which drivers are compared: init at 1 Mbps; PING;
 * READ of 2 bytes; WRITE of a goal; SYNC WRITE of 4 bytes to 18 servos. The packet holds its 90
 * bytes of goals. The written values are read values, so that the compiler cannot build packets. */
#include <cds55xx/sync_write.h>
#include <cds55xx/servo.h>
#include <cds55xx/avr.h>

#define SERVOS 18

static struct cds_bus bus;
CDS_AVR_BUS(bus, 0)
CDS_AVR_CLOCK()

static uint8_t packet[CDS_SYNC_WRITE_SIZE(SERVOS, 4)];
static uint8_t reply[2];
static struct cds_request request = CDS_REQUEST(packet, reply);

static void wait(void)
{
    while (cds_bus_poll(&bus)) {
    }
}

int main(void)
{
    uint16_t position = 0;

    cds_avr_clock_open();
    sei();
    cds_bus_open(&bus, 0, CDS_BAUD_1M);
    cds_servo_ping(&bus, &request, 1);
    wait();
    cds_servo_read(&bus, &request, 1, CDS_REG_PRESENT_POSITION, 2);
    wait();
    cds_request_word(&request, 0, &position);
    cds_servo_write_word(&bus, &request, 1, CDS_REG_GOAL_POSITION, position);
    wait();
    cds_sync_write_begin(&request, CDS_REG_GOAL_POSITION, 4);
    for (uint8_t id = 1; id <= SERVOS; id++)
        cds_sync_write_add_goal(&request, id, position, 300);
    cds_sync_write_send(&bus, &request);
    wait();
    for (;;) {
    }
}
