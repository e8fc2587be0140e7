/* SPDX-License-Identifier: MIT */
/* The registers of the virtual device (device.h) that start and steer motions, beside all others
 * (device_registers.h). Only a firmware with motions links them; in others they read 0 and refuse
 * writes. Main context. */
#ifndef CONTROLLER_MOTION_REGISTERS_H
#define CONTROLLER_MOTION_REGISTERS_H

#include "host/device.h" // struct device_ops

/* For a device whose context is a struct device_registers. Its robot has moves (robot->moves), and
 * moves_open() has been called. */
extern const CDS_FLASH struct device_ops motion_registers_ops;

#endif
