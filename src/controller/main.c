/* The firmware: a text console on the host link over one bus of servos. */
#include <stddef.h>

#include "cds55xx_avr.h"
#include "console.h"
#include "idle.h"
#include "serial.h"

#define PACKET_MAX (CDS_LENGTH_MAX + 4)

static struct {
    struct cds_bus bus;
    struct robot robot;
    struct serial serial;
    struct console console;
    uint8_t packet[PACKET_MAX];
    struct cds_request request;
} controller;

CDS_AVR_BUS(controller.bus, 0)
CDS_AVR_CLOCK()
AVR_SERIAL(controller.serial)

static bool busy(const void *context)
{
    (void)context;
    return !console_idle(&controller.console) || controller.bus.request ||
           controller.serial.broken || controller.robot.operation != ROBOT_IDLE ||
           controller.robot.stopping || controller.robot.stop_waits;
}

int main(void)
{
    controller.request.packet.bytes = controller.packet; // not in flash, as all else is zero
    controller.request.packet.room = PACKET_MAX;
    cds_avr_clock_open();
    serial_open(&controller.serial);
    sei();
    cds_bus_open(&controller.bus, 0, CDS_BAUD_1M);
    robot_begin(&controller.robot, &controller.bus);
    console_open(&controller.console, &controller.robot, &controller.request, &controller.serial.rx,
                 &controller.serial.tx);
    for (;;) {
        cds_bus_poll(&controller.bus);
        robot_poll(&controller.robot);
        console_poll(&controller.console);
        if (console_idle(&controller.console) && serial_broken(&controller.serial))
            console_input_lost(&controller.console);
        serial_send(&controller.serial);
        avr_idle(busy, NULL);
    }
}
