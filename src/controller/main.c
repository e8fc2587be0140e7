/* The firmware: a text console on the host link over one bus of servos. */
#include <stddef.h>

#include "cds55xx_avr.h"
#include "cmd_keeper.h"
#include "console.h"
#include "idle.h"
#include "keeper.h"
#include "memory.h"
#include "serial.h"
#include "watchdog.h"

#define PACKET_MAX (CDS_LENGTH_MAX + 4)

#ifndef BOARD_SERVOS // that are held, looked after and remembered
#define BOARD_SERVOS 30
#endif

/* Of so many turns of the main loop one does everything, while an exchange is on the bus. */
#define SELDOM 8

/* The longest that the host's USART may need for the last two bytes, at 7843 bit/s. */
#define HOST_QUIET_US 3000

static struct {
    struct cds_bus bus;
    struct serial serial;
    struct console console;
    uint8_t packet[PACKET_MAX];
    struct cds_request request;
    struct settings settings;
    struct settings_store store;
    struct keeper keeper;
    struct crew crew;
    struct cds_roster_servo servos[BOARD_SERVOS];
    uint8_t outcomes[BOARD_SERVOS];
    uint8_t told[BOARD_SERVOS];
    struct memory memory;
    uint32_t said_us;  // when there was last something to say to the host
    uint8_t host_baud; // as in settings, in force
    uint8_t heard;     // of the host: as serial.rx.head was
} controller;

CDS_AVR_BUS(controller.bus, 0)
CDS_AVR_CLOCK()
AVR_SERIAL(controller.serial)

static bool busy(const void *context)
{
    (void)context;
    return !console_idle(&controller.console) || controller.bus.request ||
           controller.serial.broken || controller.keeper.alarm || controller.console.writer.text ||
           keeper_is_stopping(&controller.keeper) || controller.store.result == SETTINGS_SAVING;
}

/* A new host baud rate counts when all that was said at the old one is out. */
static void follow_host_baud(void)
{
    if (controller.host_baud == controller.settings.host_baud)
        return;
    if (cds_ring_count(&controller.serial.tx) || !console_idle(&controller.console)) {
        controller.said_us = cds_port_now_us();
    } else if (cds_port_now_us() - controller.said_us > HOST_QUIET_US) {
        controller.host_baud = controller.settings.host_baud;
        serial_set_baud(controller.host_baud);
    }
}

/* What the settings say holds at once, or as soon as the bus is free. */
static void follow_settings(void)
{
    const struct settings *settings = &controller.settings;
    struct cds_bus *bus = &controller.bus;

    if (bus->baud != settings->bus_baud)
        cds_bus_set_baud(bus, settings->bus_baud);
    cds_bus_set_return_delay(bus, (uint16_t)(2u * settings->return_delay));
    cds_bus_set_repeats(bus, settings->repeats);
    follow_host_baud();
}

static void keep(void)
{
    struct keeper *keeper = &controller.keeper;

    if (controller.heard != controller.serial.rx.head) {
        controller.heard = controller.serial.rx.head;
        keeper_heard(keeper);
    }
    keeper_poll(keeper);
    settings_save_poll(&controller.store);
    if (!controller.bus.request) // it takes longer than all else here
        memory_poll(&controller.memory);
    keeper->spare_bytes = controller.memory.spare_bytes;
}

static void begin_keeper(void)
{
    struct keeper *keeper = &controller.keeper;

    keeper->settings = &controller.settings;
    keeper->store = &controller.store;
    keeper->crew = &controller.crew;
    keeper->outcomes = controller.outcomes;
    keeper->told = controller.told;
    keeper->room_bytes = memory_room_bytes();
    memory_count(&controller.memory);
    keeper_begin(keeper, avr_reset_cause);
    controller.console.keeper = keeper;
}

int main(void)
{
    watchdog_on();
    controller.request = (struct cds_request)CDS_REQUEST(controller.packet);
    settings_load(&controller.store, &controller.settings);
    cds_avr_clock_open();
    serial_open(&controller.serial);
    controller.host_baud = controller.settings.host_baud;
    serial_set_baud(controller.host_baud);
    sei();
    cds_bus_open(&controller.bus, 0, controller.settings.bus_baud);
    crew_begin(&controller.crew, &controller.bus, controller.servos, BOARD_SERVOS);
    console_open(&controller.console, &controller.bus, &controller.request, &controller.serial.rx,
                 &controller.serial.tx);
    begin_keeper();
    for (uint8_t turn = 0;; turn++) {
        watchdog_pet();
        if (!controller.bus.request || turn % SELDOM == 0) {
            follow_settings();
            keep();
        }
        cds_bus_poll(&controller.bus);
        console_poll(&controller.console);
        if (console_idle(&controller.console) && serial_broken(&controller.serial))
            console_input_lost(&controller.console);
        cmd_keeper_tell(&controller.console);
        serial_send(&controller.serial);
        avr_idle(busy, NULL);
    }
}
