/* What stands behind the registers of the virtual device (device.h). Main context. */
#ifndef CONTROLLER_VALUES_H
#define CONTROLLER_VALUES_H

#include <stdbool.h>
#include <stdint.h>

#include "bridge.h"      // struct bridge
#include "cds55xx/bus.h" // struct cds_bus
#include "device.h"      // struct device_world
#include "host.h"        // struct host

#define VALUES_HOST_BAUD_OWN 255 // in kept[DEVICE_HOST_BAUD]: the board's

struct values {
    struct cds_bus *bus;
    const struct host *host;
    const struct bridge *bridge;
    const volatile uint16_t *gaps; // bytes of the host, by the receive handler
    uint16_t kept[DEVICE_KEPT];    // the settings, by enum device_register
    uint8_t save;                  // 1: they are to be kept; who has done it clears it
    uint8_t reset_cause;
    uint8_t link_lost;
    uint8_t alarms, alarm_id;
    struct device_world world; // this, for the device
};

/* Factory values; `bus` is open. */
void values_open(struct values *values, struct cds_bus *bus, const struct host *host,
                 const struct bridge *bridge, const volatile uint16_t *gaps);

#endif
