/* The firmware: on one host link a text console, and a bridge for protocol packets, over one bus of
 * servos. */
#include <stddef.h>

#include "bridge.h"
#include "cds55xx_avr.h"
#include "console.h"
#include "device.h"
#include "host.h"
#include "idle.h"
#include "robot.h"
#include "serial.h"
#include "values.h"

/* Until the last byte has left at the lowest rate, 2 000 000 / 256 bit/s, once the ring is empty:
 * two are with the transmitter. */
#define HOST_DRAIN_US 4000

/* So many times the bus is polled in a turn of the main loop while a READ of many servos goes on.
 */
#define SELDOM 16

static struct {
    struct cds_bus bus;
    struct serial serial;
    struct cds_ring text; // for the console
    struct host host;
    struct bridge bridge;
    struct device device;
    struct values values;
    struct robot robot;
    struct console console;
    uint8_t packets[3][HOST_PACKET_MAX]; // of the console, from the host, on the bridge
    struct cds_request request;
    uint32_t drained_us; // when the ring to the host was found empty, before a change of its rate
    uint8_t host_baud;   // as in the device's register
} controller;

CDS_AVR_BUS(controller.bus, 0)
CDS_AVR_CLOCK()
AVR_SERIAL(controller.serial)

static uint8_t host_baud_wanted(void)
{
    return (uint8_t)controller.values.kept[DEVICE_HOST_BAUD];
}

static bool busy(const void *context)
{
    (void)context;
    return !console_idle(&controller.console) || !host_idle(&controller.host) ||
           !bridge_idle(&controller.bridge) || controller.bus.request || controller.serial.broken ||
           controller.host_baud != host_baud_wanted() || !robot_idle(&controller.robot);
}

static void open_host(uint8_t baud)
{
    controller.host_baud = baud;
    serial_open(&controller.serial, baud == VALUES_HOST_BAUD_OWN
                                        ? SERIAL_DIVISOR(BOARD_HOST_BAUD)
                                        : baud); // with U2X at 16 MHz UBRR is n, as on the bus
}

/* The rate of the host link changes behind the answer that said so. */
static void follow_host_baud(void)
{
    bool quiet = !bridge_talks(&controller.bridge) && !cds_ring_count(&controller.serial.tx);

    if (controller.host_baud == host_baud_wanted() || !quiet)
        controller.drained_us = 0;
    else if (controller.drained_us == 0)
        controller.drained_us = cds_port_now_us() | 1;
    else if (cds_port_now_us() - controller.drained_us > HOST_DRAIN_US)
        open_host(host_baud_wanted());
}

static void open(void)
{
    controller.request = (struct cds_request)CDS_REQUEST(controller.packets[0]);
    cds_avr_clock_open();
    open_host(VALUES_HOST_BAUD_OWN);
    sei();
    cds_bus_open(&controller.bus, 0, CDS_BAUD_1M);
    host_open(&controller.host, &controller.serial.rx, &controller.text, controller.packets[1]);
    values_open(&controller.values, &controller.bus, &controller.host, &controller.bridge,
                &controller.serial.gaps);
    controller.device.world = &controller.values.world;
    bridge_open(&controller.bridge, &controller.bus, &controller.host, &controller.device,
                &controller.serial.tx, controller.packets[2]);
    robot_begin(&controller.robot, &controller.bus);
    console_open(&controller.console, &controller.robot, &controller.request, &controller.text,
                 &controller.serial.tx);
}

/* Packets wait while the bus may be at another rate. Whoever is in a scan or a diagnosis gives way
 * to them. */
static void poll_bridge(void)
{
    if (!robot_is_exclusive(&controller.robot))
        bridge_poll(&controller.bridge);
    else if (controller.host.whole)
        robot_abort(&controller.robot);
}

/* The main loop's body. Not inlined: a debugger finds it. */
__attribute__((noinline)) static void turn(void)
{
    uint8_t left = SELDOM;

    do {
        cds_bus_poll(&controller.bus);
        poll_bridge();
        serial_send(&controller.serial);
    } while (bridge_hurries(&controller.bridge) && --left);
    host_poll(&controller.host);
    if (controller.host.stop) {
        controller.host.stop = false;
        console_stop(&controller.console);
    }
    robot_poll(&controller.robot);
    if (!bridge_talks(&controller.bridge)) // a status packet must not be torn by text
        console_poll(&controller.console);
    if (serial_broken(&controller.serial))
        host_gap(&controller.host);
    serial_send(&controller.serial);
    follow_host_baud();
    avr_idle(busy, NULL);
}

int main(void)
{
    open();
    for (;;)
        turn();
}
