/* What stands behind the registers of the virtual device (device.h). Main context. */
#ifndef CONTROLLER_VALUES_H
#define CONTROLLER_VALUES_H

#include <stdbool.h>
#include <stdint.h>

#include "host/bridge.h"     // struct bridge
#include "host/device.h"     // struct device_world
#include "host/host_demux.h" // struct host
#include "robot/failsafe.h"  // struct failsafe

struct values {
    struct failsafe *failsafe;
    const struct host *host;
    const struct bridge *bridge;
    const volatile uint16_t *gaps; // bytes of the host that the receive handler lost
    bool to_save;                  // was asked for, and could not be begun yet
};

/* For a device whose owner is a struct values. */
extern const CDS_FLASH struct device_world values_world;

/* The settings, robot and bus are those of `failsafe`, which has begun. */
void values_open(struct values *values, struct failsafe *failsafe, const struct host *host,
                 const struct bridge *bridge, const volatile uint16_t *gaps);

#endif
