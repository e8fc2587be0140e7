/* SPDX-License-Identifier: MIT */
/* Finds the servos on the bus: PING of every ID at every baud rate asked for (manual 2.4.5; rates:
 * 3.1, register 0x04).
 *
 * In the controller's firmware a silent ID costs 1.1 ms at 1 Mbps and 8 ms at 19200 bit/s: 254 IDs
 * take 0.28 s and 2.0 s, and all six listed rates 4.2 s. All 255 rates take 10.5 minutes for all
 * IDs, and 2.5 s for one. A servo whose reply is lost is not found, unless the queue retries
 * (cds_queue_set_retries()).
 *
 * The scan holds the bus from begin to end (cds_bus_lock()). Main context.
 */
#ifndef CDS_SCAN_H
#define CDS_SCAN_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/steps.h" // struct cds_steps

#ifdef __cplusplus
extern "C" {
#endif

/* Capacities of the request: packet always, reply if details are read. */
#define CDS_SCAN_PACKET_SIZE CDS_PACKET_SIZE(2)
#define CDS_SCAN_REPLY_SIZE  4

/* A servo that answered. */
struct cds_scan_found {
    uint8_t id;       // 0 to 253
    uint8_t baud_reg; // rate at which it answered
    uint8_t result;   // CDS_OK; CDS_CORRUPT: damage, so perhaps two servos with this ID, or noise
    uint8_t details;  // enum cds_result of reading the fields below, which hold only if it is
                      // CDS_OK; CDS_PENDING: not read
    uint8_t model;    // register 0x01
    uint8_t own_baud_reg; // register 0x04; baud_reg may be a neighbour that is near enough
};

/* The six rates that a servo keeps at power-off, fastest first (manual 3.1, register 0x04). */
#define CDS_SCAN_LISTED_BAUDS 6
extern const uint8_t cds_scan_listed_baud_regs[CDS_SCAN_LISTED_BAUDS];

/* What to scan. Bus, request and arrays stay in place until the scan has ended. */
struct cds_scan_config {
    struct cds_bus *bus;          // open
    struct cds_request *request;  // capacities: CDS_SCAN_PACKET_SIZE, CDS_SCAN_REPLY_SIZE
    struct cds_scan_found *found; // for the servos that answer; NULL if found_capacity is 0
    uint8_t found_capacity;       // entries of `found`, 0 to 255
    uint8_t first_id, last_id;    // 0 to 253
    const uint8_t *baud_regs;     // rates in their order, each 0 to 254; NULL: the six listed ones
    uint8_t baud_count;           // of baud_regs: 1 to 255; 0 if baud_regs is NULL
    bool tries_every_rate;        // all 255 rates instead, for a servo at an unlisted one (R24). A
                                  // servo at a slow rate also answers at neighbours of that rate,
                                  // and is found at each
    bool reads_details;           // READ of registers 0x01 to 0x04 of each servo that is found
};

/* One scan: the caller reads the first three fields and steps.result. */
struct cds_scan {
    uint16_t asked; // progress: PINGs that are over
    uint16_t total; // PINGs of the whole scan
    uint16_t count; // servos that answered so far; the first found_capacity of them are in `found`
    uint8_t id;     // asked now
    uint8_t baud_index; // rate: index in config.baud_regs, or the rate itself
    bool is_reading;    // details of the servo found last
    // internal:
    struct cds_scan_config config;
    // to be read:
    struct cds_steps steps; // steps.result: enum cds_result of the whole
};

/* Prepares a scan and locks the bus; nothing is sent before the first poll. `config` is copied.
 * CDS_OK; CDS_BAD_ARGUMENT: the bus is not open, or IDs or rates are out of range; CDS_NO_ROOM: a
 * buffer of the request is too small; CDS_BUSY: the request is on its way, or an operation holds
 * the bus. Unless it is CDS_OK, nothing was changed. */
enum cds_result cds_scan_begin(struct cds_scan *scan, const struct cds_scan_config *config);

/* Moves on by at most one transaction; call it and cds_bus_poll() from the main loop. At the end
 * the bus has its own rate and return delay back.
 *   CDS_PENDING    under way
 *   CDS_OK         every ID was asked at every rate
 *   CDS_CANCELLED  aborted, its request was cancelled, or the bus was opened again (and is left as
 *                  it is); `found` has the servos that answered before
 *   CDS_LINE_BUSY  the line was not quiet, so the scan has ended early */
enum cds_result cds_scan_poll(struct cds_scan *scan);

/* Sends nothing more. Poll until the transaction in flight is over: the result is CDS_CANCELLED. */
void cds_scan_abort(struct cds_scan *scan);

#ifdef __cplusplus
}
#endif

#endif
