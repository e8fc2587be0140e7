/* SPDX-License-Identifier: MIT */
/* Gives several servos another baud rate, one after the other, and takes the bus along.
 *
 * Each servo is changed by an identity operation (identity.h): what is reported is where the servo
 * is. A servo that answers at the new rate before has followed already. A change that the servo did
 * not take, or a servo that cannot be found, is tried up to BAUD_CHANGE_TRIES times. At the end the
 * bus has the new rate if any servo has it, else its old one.
 *
 * Main context. */
#ifndef CONTROLLER_BAUD_CHANGE_H
#define CONTROLLER_BAUD_CHANGE_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/identity.h" // struct cds_identity

#define BAUD_CHANGE_SERVOS 50
#define BAUD_CHANGE_TRIES  3

/* What to change. Bus and request stay in place until the operation has ended. */
struct baud_change_config {
    struct cds_bus *bus;         // at the rate of the servos
    struct cds_request *request; // packet capacity: CDS_PACKET_SIZE(2)
    const uint8_t *ids;          // copied
    uint8_t count;               // of ids: 1 to BAUD_CHANGE_SERVOS
    uint8_t baud_reg;            // the new rate, 0 to 254
};

/* One change of several servos: the caller reads `ids`, `states` and `results`. */
struct baud_change {
    struct cds_identity identity;
    struct cds_bus *bus;
    struct cds_request *request;
    uint8_t from_baud_reg, to_baud_reg;
    uint8_t count, index, tries;
    uint8_t phase;
    bool has_moved;                      // a servo is at the new rate
    uint8_t outcome;                     // enum cds_result of the whole
    uint8_t ids[BAUD_CHANGE_SERVOS];     // the servos
    uint8_t states[BAUD_CHANGE_SERVOS];  // enum cds_identity_state: CHANGED, the servo has followed
    uint8_t results[BAUD_CHANGE_SERVOS]; // enum cds_result: why it has not
};

/* Begins; nothing is sent before the first poll. CDS_OK; CDS_BAD_ARGUMENT: `count` is out of
 * range. */
enum cds_result baud_change_begin(struct baud_change *change,
                                  const struct baud_change_config *config);

/* Moves on by at most one transaction. CDS_PENDING; CDS_OK: every servo was tried, see `states`;
 * CDS_CANCELLED: a stop took the bus, and the servos behind that one were not tried. */
enum cds_result baud_change_poll(struct baud_change *change);

#endif
