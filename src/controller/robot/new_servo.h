/* SPDX-License-Identifier: MIT */
/* Sets up a new servo that is alone on the bus: finds it at whatever rate, then gives it the return
 * delay that this board needs, an ID, and the rate of the bus.
 *
 * A search at the six listed rates asks every ID. If no servo answers, or the replies are damaged
 * since the rate of the servo is a neighbour of the listed one, a PING to all is sent at each of
 * the 255 rates, and every ID is asked at the rate of the servo that answers. If more than one
 * servo answers, nothing is written; nor if the servo has an ID of the robot and the rate of the
 * bus: it may be one of the robot's. What may be retried is tried NEW_SERVO_TRIES times. At the end
 * the bus has its own rate back.
 *
 * Main context. */
#ifndef CONTROLLER_NEW_SERVO_H
#define CONTROLLER_NEW_SERVO_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/identity.h" // struct cds_identity
#include "cds55xx/scan.h"     // struct cds_scan
#include "cds55xx/servos.h"   // struct cds_servos
#include "cds55xx/setup.h"    // struct cds_setup

#define NEW_SERVO_TRIES 3
#define NEW_SERVO_FOUND 8 // servos that are remembered if the new one is not alone

/* What is being done. */
enum new_servo_step {
    NEW_SERVO_SEARCH_LISTED,
    NEW_SERVO_MEND_ALL, // only bytes without a packet came: writes the return delay without a reply
                        // at the six listed rates, then searches there again
    NEW_SERVO_SEARCH_ANY,   // a PING to all at each rate
    NEW_SERVO_SEARCH_THERE, // every ID at the rate at which a servo has answered
    NEW_SERVO_MEND_DELAY,   // its reply is damaged: writes the return delay without a reply
    NEW_SERVO_CHECK,        // reads the whole control table: in a long reply two servos differ
    NEW_SERVO_SET_DELAY,
    NEW_SERVO_SET_ID,
    NEW_SERVO_SET_RATE,
    NEW_SERVO_DONE,
} __attribute__((packed));

/* How it has ended, beside enum cds_result of the step that failed. */
enum new_servo_outcome {
    NEW_SERVO_OK,
    NEW_SERVO_NONE,      // no servo answers at any rate
    NEW_SERVO_NOT_ALONE, // several answer, in `found`: nothing was written
    NEW_SERVO_KNOWN,     // its ID and rate are those of a servo of the robot
    NEW_SERVO_DAMAGED,   // its replies stay damaged: two servos with one ID, or noise
    NEW_SERVO_LOST,      // the ID or rate was written, the servo answers at neither place
    NEW_SERVO_FAILED,    // `result` says why the step failed
    NEW_SERVO_ENDED,     // by a key or a stop
} __attribute__((packed));

/* Bus and request stay in place until the operation has ended. */
struct new_servo_config {
    struct cds_bus *bus;             // at the rate that the servo is to have
    struct cds_request *request;     // packet capacity: CDS_PACKET_SIZE(2), 9 at least; reply
                                     // capacity: CDS_TABLE_SIZE
    const struct cds_servos *servos; // of the robot; NULL: none is known
    uint8_t id;                      // that the servo is to have, 0 to 253
    uint8_t return_delay;            // register 0x05 that it is to have
};

/* One set-up: the caller reads the fields from `step` to `count`, and `found`. */
struct new_servo {
    struct new_servo_config config;
    uint8_t step;    // enum new_servo_step
    uint8_t outcome; // enum new_servo_outcome
    uint8_t result;  // enum cds_result of the step that failed last
    bool mended_all;
    bool searched_any;
    uint8_t id;       // where the servo was found
    uint8_t baud_reg; // its own rate; before NEW_SERVO_SET_DELAY the rate at which it was found
    uint8_t count;    // servos in `found`
    // private:
    uint8_t home_baud_reg;
    uint8_t first_baud_reg; // the servo's rate before the first write
    uint8_t known;          // servos of the robot before the search: replies may add others
    uint8_t tries;
    uint8_t any_baud; // rate of the PING to all
    uint8_t listed;   // index of the listed rate at which the return delay is written
    uint16_t noise;   // bytes without a packet, as the bus has counted them before the search
    bool begun;       // the present step
    bool asked_rate;  // the READ of the servo's own rate is on its way
    bool is_ending;
    // to be read:
    struct cds_scan_found found[NEW_SERVO_FOUND]; // `count` servos
    // private:
    union {
        struct cds_scan scan;
        struct cds_identity identity;
        struct cds_setup setup;
    } work;
};

/* Begins; nothing is sent before the first poll. Always CDS_OK. */
enum cds_result new_servo_begin(struct new_servo *servo, const struct new_servo_config *config);

/* Moves on by at most one transaction. CDS_PENDING; CDS_OK: it has ended, see `outcome`. */
enum cds_result new_servo_poll(struct new_servo *servo);

/* Ends the search; once the servo is found, the set-up goes on to its end. */
void new_servo_abort(struct new_servo *servo);

#endif
