/* SPDX-License-Identifier: MIT */
/* Connects the registers of the virtual device (device.h) with settings, failsafe, bus, host link
 * and bridge. Main context. */
#ifndef CONTROLLER_DEVICE_REGISTERS_H
#define CONTROLLER_DEVICE_REGISTERS_H

#include <stdbool.h>
#include <stdint.h>

#include "host/bridge.h"     // struct bridge
#include "host/device.h"     // struct device_ops
#include "host/host_demux.h" // struct host_demux
#include "robot/failsafe.h"  // struct failsafe

struct device_registers {
    struct failsafe *failsafe; // holds settings, robot and bus
    const struct host_demux *host;
    const struct bridge *bridge;
    const volatile uint16_t *gaps; // times that the receive handler of the host link lost bytes
    bool to_save;                  // a save was asked for and has not begun
};

/* For a device whose context is a struct device_registers. */
extern const CDS_FLASH struct device_ops device_registers_ops;

/* `failsafe` has begun. */
void device_registers_open(struct device_registers *registers, struct failsafe *failsafe,
                           const struct host_demux *host, const struct bridge *bridge,
                           const volatile uint16_t *gaps);

#endif
