/* SPDX-License-Identifier: MIT */
/* Building and sending a request in two steps, for modules of the core; not installed. Main
 * context.
 */
#ifndef CDS_SERVO_INTERNAL_H
#define CDS_SERVO_INTERNAL_H

#include "cds55xx/bus.h" // struct cds_request

/* Begins a packet with its first `count` parameters. Changes nothing while the request is on its
 * way, since its packet is to be sent as it stands. */
void cds_servo_start(struct cds_request *request, const uint8_t *data, uint8_t count, uint8_t id,
                     uint8_t instruction);

/* Ends the packet and submits the request. Returns what cds_packet_end() and cds_bus_submit()
 * return, and CDS_BUSY while the request is on its way. A refusal is the request's result too. */
enum cds_result cds_servo_send(struct cds_bus *bus, struct cds_request *request);

#endif
