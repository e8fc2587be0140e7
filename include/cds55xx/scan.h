/* Who is on the bus? PING of every ID at every baud rate asked for (manual 2.4.5; rates: 3.1,
 * register 0x04).
 *
 * At the listed rates an ID that is silent costs 0.79 ms at 1 Mbps and 6.9 ms at 19200: 254 IDs
 * take 0.20 s and 1.8 s, and all six rates 3.6 s. A rescue takes nine minutes for all IDs, and two
 * seconds for one. A lost PING is a servo not found: cds_bus_set_repeats() has each repeated.
 *
 * Keep other requests off the bus meanwhile: they would go out at the rate being tried, and a
 * change of rate waits until the bus is idle. Main context.
 */
#ifndef CDS_SCAN_H
#define CDS_SCAN_H

#include <stdbool.h>
#include <stddef.h> // NULL
#include <stdint.h>

#include "cds55xx/bus.h" // struct cds_bus, struct cds_request

#ifdef __cplusplus
extern "C" {
#endif

/* One that answered. */
struct cds_scan_found {
    uint8_t id;       // 0 to 253
    uint8_t baud;     // register value of the rate at which it answered
    uint8_t result;   // CDS_OK; CDS_CORRUPT: damaged, so perhaps two servos with this ID, or noise
    uint8_t details;  // enum cds_result of reading the fields below, which hold only if it is
                      // CDS_OK; CDS_PENDING: not asked
    uint8_t model;    // register 0x01
    uint8_t own_baud; // register 0x04: `baud` may be a neighbour that is near enough to be heard
};

/* One scan: the caller reads `asked`, `total`, `count` and `found`. Zero it (static storage is),
 * then cds_scan_begin(). */
struct cds_scan {
    struct cds_bus *bus;
    struct cds_request *request;
    struct cds_scan_found *found;
    const uint8_t *bauds; // NULL: all register values
    uint16_t asked;       // progress: PINGs that are over, of `total`
    uint16_t total;
    uint16_t count;                // who answered so far; of those the first `room` are in `found`
    uint8_t room;                  // of `found`
    uint8_t baud_count;            // of `bauds`
    uint8_t first_id, last_id;     // 0 to 253
    uint8_t with_details, aborted; // not 0: asked for
    uint8_t line_busy;             // not 0: nobody could be asked any more
    uint8_t id, baud_index;        // being asked
    uint8_t phase;                 // the scan's own, like all below
    uint8_t result;                // enum cds_result of the whole
    uint8_t took;                  // not 0: the two below were the bus's before an earlier begin
    uint8_t own_baud;              // the bus's, to return to
    uint16_t return_delay_us;
};

/* The six rates that a servo keeps at power-off, fastest first (manual 3.1, 0x04). */
#define CDS_SCAN_LISTED_BAUDS 6
extern const uint8_t cds_scan_listed_bauds[CDS_SCAN_LISTED_BAUDS];

/* Prepares a scan of IDs 0 to 253 at the six listed rates; nothing is sent before the first poll.
 * Whom it finds goes to `found`, an array of `room` (0 to 255; NULL if 0). The request's buffer
 * must be at least CDS_PACKET_SIZE(2) bytes; bus, request, array and scan stay in place until it
 * has ended. A scan under way is begun anew: the bus gets back what it had before the first. */
void cds_scan_begin(struct cds_scan *scan, struct cds_bus *bus, struct cds_request *request,
                    struct cds_scan_found *found, uint8_t room);

/* Before the first poll, each as wanted:
 * only IDs `first` to `last`, both 0 to 253; */
void cds_scan_set_ids(struct cds_scan *scan, uint8_t first, uint8_t last);

/* only these rates: `bauds`, `count` (1 to 255) register values of 0 to 254, the caller's array, in
 * that order (the bus's own is &bus->baud, 1); */
void cds_scan_set_bauds(struct cds_scan *scan, const uint8_t *bauds, uint8_t count);

/* all 255 rates there are, for a servo that was set to one of its unlisted ones (R24); a servo at a
 * slow one answers at its neighbours too, and appears once for each: details tell its own; */
void cds_scan_set_rescue(struct cds_scan *scan);

/* details of each that is found: one READ more (registers 0x01 to 0x04). A servo of status return
 * level 0 does not answer that: CDS_TIMEOUT, or, if a roster knows so, CDS_NO_REPLY_DUE. */
void cds_scan_set_details(struct cds_scan *scan);

/* Ends the scan with the exchange in flight: go on polling until it is over. */
void cds_scan_abort(struct cds_scan *scan);

/* Moves on by at most one exchange; call it and cds_bus_poll() from the main loop. When it ends,
 * the bus has its own rate and return delay back. CDS_PENDING: not over yet; asked, total, count
 * and found tell how far it is. CDS_OK: all were asked. CDS_CANCELLED: aborted, or its request
 * was cancelled; found holds whom it met. Or the bus was opened anew, or told another return delay:
 * then it is left as it is. CDS_LINE_BUSY: the line was not quiet, so no one more could be asked;
 * likewise. CDS_BAD_ARGUMENT: no bus is open, or IDs or rates are out of range; CDS_NO_ROOM: the
 * request's buffer is too small; in both nothing was sent. */
enum cds_result cds_scan_poll(struct cds_scan *scan);

#ifdef __cplusplus
}
#endif

#endif
