/* What the roster does as the bus's observer (bus.h), for one that takes its place and asks it:
 * `observer` is that of a struct cds_servos. Main context.
 */
#ifndef CORE_OBSERVE_H
#define CORE_OBSERVE_H

#include "cds55xx/bus.h" // struct cds_bus_observer

enum cds_result cds_servos_admit(struct cds_bus_observer *observer, struct cds_request *request);
enum cds_result cds_servos_admit_block(struct cds_bus_observer *observer, uint8_t id,
                                       uint8_t address, const uint8_t *data, uint8_t length);
void cds_servos_on_news(struct cds_bus_observer *observer, const struct cds_bus_news *news);

#endif
