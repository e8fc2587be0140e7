/* What stands behind the registers of the virtual device (device.h). Main context. */
#ifndef CONTROLLER_DEVICE_REGISTERS_H
#define CONTROLLER_DEVICE_REGISTERS_H

#include <stdbool.h>
#include <stdint.h>

#include "host/bridge.h"     // struct bridge
#include "host/device.h"     // struct device_ops
#include "host/host_demux.h" // struct host_demux
#include "robot/failsafe.h"  // struct failsafe

struct device_registers {
    struct failsafe *failsafe;
    const struct host_demux *host;
    const struct bridge *bridge;
    const volatile uint16_t *gaps; // bytes of the host that the receive handler lost
    bool to_save;                  // was asked for, and could not be begun yet
};

/* For a device whose context is a struct device_registers. */
extern const CDS_FLASH struct device_ops device_registers_ops;

/* The settings, robot and bus are those of `failsafe`, which has begun. */
void device_registers_open(struct device_registers *registers, struct failsafe *failsafe,
                           const struct host_demux *host, const struct bridge *bridge,
                           const volatile uint16_t *gaps);

#endif
