/* One half-duplex bus, the exchange in flight on it and those that wait. An exchange is an
 * instruction packet and the status packet that answers it, if one is due. Manual: 2.1; status
 * return level and return delay: 3.1, registers 0x05 and 0x10.
 *
 * Nothing here waits: a call submits and returns, cds_bus_poll() moves things on, and the request
 * says how it ended. All functions: main context, interrupts on.
 *
 * Counters: every exchange ends as ok, timeout or corrupt, so sent = ok + timeouts + corrupt once
 * the bus is idle.
 */
#ifndef CDS_BUS_H
#define CDS_BUS_H

#include <stdbool.h>
#include <stdint.h>

#include "cds55xx/link.h"   // struct cds_link
#include "cds55xx/packet.h" // struct cds_packet
#include "cds55xx/parser.h" // struct cds_parser
#include "cds55xx/result.h" // enum cds_result

#ifdef __cplusplus
extern "C" {
#endif

/* Baud register of the servos' factory setting: 1 Mbps. */
#define CDS_BAUD_1M 1

/* The highest baud register: 7843 bit/s. */
#define CDS_BAUD_MAX 254

/* Added to the time a reply may take: a servo renews its control loop and serves its own
 * interrupts; this is our estimate, in microseconds. */
#define CDS_REPLY_MARGIN_US 100

/* The longest return delay register 0x05 can ask for, in microseconds (254 x 2). */
#define CDS_RETURN_DELAY_MAX_US 508

/* How many parameters a reply must have; one that refuses the packet (CDS_ERRORS_OF_PACKET) may
 * also have none. */
#define CDS_REPLY_NONE 0xFF // no reply is due (broadcast, or the status return level)
#define CDS_REPLY_MAX  50   // a READ of the whole control table

/* One exchange: filled in by the typed calls of servo.h and group.h, owned by the caller, who
 * leaves it and its buffer alone from submit until `result` is no longer CDS_PENDING. */
struct cds_request {
    struct cds_packet packet; // the instruction packet; then the reply's parameters in its buffer
    void (*on_end)(struct cds_request *); // called from cds_bus_poll() when it has ended, or NULL;
                                          // it may submit again
    void *owner;                          // the caller's, for on_end
    struct cds_request *next;             // the bus's own
    uint8_t reply_parameters;             // due in the reply: 0 to CDS_REPLY_MAX, or CDS_REPLY_NONE
    uint8_t repeats; // how often it may still be sent again if no good reply comes
    bool urgent;     // goes before all that are not
    uint8_t result;  // enum cds_result; the fields below hold only if it is CDS_OK
    uint8_t id;      // who answered (of interest after a broadcast PING)
    uint8_t error;   // CDS_ERROR_* bits of the reply, 0 if none was due
    uint8_t length;  // parameters received; 0 if the servo refused
};

/* A request over `buffer`, an array of the caller's that holds the packet and the reply. */
#define CDS_REQUEST(buffer)                                                                        \
    {                                                                                              \
        .packet = {.bytes = (buffer), .room = sizeof(buffer) }                                     \
    }

/* Counted modulo 65536 from cds_bus_open() on. */
struct cds_counters {
    uint16_t sent;           // instruction packets, repeated ones too
    uint16_t repeated;       // ... of them, because no good reply had come
    uint16_t ok;             // exchanges that ended well, no reply due included
    uint16_t timeouts;       // ... without a reply by the deadline
    uint16_t corrupt;        // ... with nothing but damage by the deadline
    uint16_t refuted;        // LENGTH or checksum of a would-be packet wrong
    uint16_t foreign;        // good packets that were not the reply due: other ID or length
    uint16_t framing_errors; // bytes damaged: noise, collision or another baud rate
    uint16_t overruns;       // bytes lost because a handler was held up for 320 cycles or more
    uint16_t ring_overflows; // bytes lost because nobody polled and the line babbled
    uint16_t echo_errors;    // own bytes that came back changed: another talked too (tied wiring)
};

/* All state of one bus. Zero it (static storage is), then cds_bus_open(). */
struct cds_bus {
    struct cds_link link;
    struct cds_parser parser;
    struct cds_request *request;  // in flight, then those that wait, in their order; or NULL
    uint32_t deadline_us;         // of the one in flight
    uint16_t byte_time_us;        // ten bits
    uint16_t return_delay_us;     // longest of any servo on this bus
    uint8_t port;                 // number of the bus on its board
    uint8_t baud;                 // register value of its rate
    uint8_t damaged;              // not 0: something of the reply came damaged
    uint8_t repeats;              // given to each request that bears repeating
    struct cds_counters counters; // the last four stay in `link` until asked for
};

/* Opens the bus on `port` (0 to the board's number of buses - 1) at 2 000 000 / (baud + 1) bit/s
 * (`baud` 0 to 254) and listens. Counters start at 0. Requests in flight or waiting, if the bus was
 * open already, end as CDS_CANCELLED, without on_end. */
void cds_bus_open(struct cds_bus *bus, uint8_t port, uint8_t baud);

/* Goes on at 2 000 000 / (baud + 1) bit/s, `baud` 0 to 254 as in register 0x04; counters and
 * settings stay. CDS_OK; CDS_BUSY: a request is in flight or waits, nothing was touched;
 * CDS_BAD_ARGUMENT: no bus is open, or there is no such rate. */
enum cds_result cds_bus_set_baud(struct cds_bus *bus, uint8_t baud);

/* Tells how long the slowest servo of the bus waits before it replies, in microseconds: twice its
 * register 0x05. CDS_RETURN_DELAY_MAX_US from cds_bus_open() on, which is safe; the true value ends
 * a timeout sooner (manual, example 8). */
void cds_bus_set_return_delay(struct cds_bus *bus, uint16_t return_delay_us);

/* Sets how often a request is sent again when no good reply has come: 0 (from cds_bus_open() on) to
 * 2. Only what does the same when done twice is repeated: PING, READ, and WRITE but of ID and baud
 * rate. What a servo has refused is never repeated. */
void cds_bus_set_repeats(struct cds_bus *bus, uint8_t repeats);

/* Sends the packet of `request`, which cds_packet_end() has accepted: at once if the bus is free,
 * else in its turn, after those submitted before it; an urgent one after the urgent ones only.
 * CDS_OK: request->result is CDS_PENDING until it ends. CDS_BUSY: this very request is on its way
 * already; nothing was touched. CDS_BAD_ARGUMENT: no bus is open, or reply_parameters is above
 * CDS_REPLY_MAX. CDS_NO_ROOM: the reply would not fit the buffer. */
enum cds_result cds_bus_submit(struct cds_bus *bus, struct cds_request *request);

/* Takes back a request that waits for its turn: it ends as CDS_CANCELLED, without on_end. CDS_OK;
 * CDS_BUSY: it is in flight and will end by its deadline; CDS_BAD_ARGUMENT: it is not on this bus.
 */
enum cds_result cds_bus_cancel(struct cds_bus *bus, struct cds_request *request);

/* Moves the exchange in flight on and begins the next; to be called from the main loop, as often as
 * it turns. Ends at most one exchange and calls its on_end. Returns true while there is work.
 * Called late it loses nothing: what came is parsed before the deadline is judged. */
bool cds_bus_poll(struct cds_bus *bus);

/* Copies the counters. */
void cds_bus_counters(const struct cds_bus *bus, struct cds_counters *out);

/* Parameter `index` of the reply as a byte, or as a word (low byte first, R28), into *out. CDS_OK
 * only if the exchange succeeded and that many parameters came; else *out is left as it was and
 * the reason is returned: request->result, or CDS_REFUSED if the servo answered without data. */
enum cds_result cds_request_byte(const struct cds_request *request, uint8_t index, uint8_t *out);
enum cds_result cds_request_word(const struct cds_request *request, uint8_t index, uint16_t *out);

#ifdef __cplusplus
}
#endif

#endif
