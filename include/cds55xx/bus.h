/* SPDX-License-Identifier: MIT */
/* One half-duplex bus and the transaction in flight on it: an instruction packet and the status
 * packet that answers it, if one is due. Manual: 2.1; registers 0x05 and 0x10 in 3.1.
 *
 * No call waits: cds_bus_submit() returns at once, cds_bus_poll() moves the transaction on, and
 * request->result says how it ended. All functions: main context, interrupts on.
 *
 *     static uint8_t packet[CDS_PACKET_SIZE(2)], reply[2];
 *     static struct cds_request request = CDS_REQUEST(packet, reply);
 *     cds_servo_read(&bus, &request, 1, CDS_REG_PRESENT_POSITION, 2);
 *     while (cds_bus_poll(&bus)) {
 *     }
 */
#ifndef CDS_BUS_H
#define CDS_BUS_H

#include <stdbool.h>
#include <stddef.h> // NULL
#include <stdint.h>

#include "cds55xx/link.h"   // struct cds_link
#include "cds55xx/packet.h" // struct cds_packet
#include "cds55xx/parser.h" // struct cds_parser
#include "cds55xx/result.h" // enum cds_result

#ifdef __cplusplus
extern "C" {
#endif

/* Register 0x04 for `bps` bit/s, 7843 to 2 000 000: 2 000 000 / bps - 1, rounded. */
#define CDS_BAUD(bps) ((uint8_t)((2000000ul + (bps) / 2u) / (bps)-1u))

/* Register 0x04 of the servos' factory setting, 1 Mbps. */
#define CDS_BAUD_1M 1

/* The highest value of register 0x04: 7843 bit/s. */
#define CDS_BAUD_MAX 254

/* Added to the time a reply may take, in microseconds: a servo renews its control loop and serves
 * its own interrupts. An estimate. */
#define CDS_REPLY_MARGIN_US 100

/* The longest return delay register 0x05 can ask for, in microseconds (254 x 2). */
#define CDS_RETURN_DELAY_MAX_US 508

/* A reply that begins within this time after the end of its packet, in microseconds, is never taken
 * for the reply to a later packet. Register 0x05 allows 508; the other 1492 are for servos that are
 * slower than their register says. A still slower servo can give a wrong value:
 * docs/internals/faults.md, F17-again. */
#define CDS_STALE_REPLY_US 2000

/* The states of the transaction, in this order:
 *
 *   CLOSED --open--> IDLE --submit--> SENDING --no reply is due--> SENDING_ONLY --complete--> IDLE
 *                     |                  ^  |
 *              line in use, or           |  +--a reply is due--> AWAITING_REPLY <--malformed--+
 *             check not ended            |                        |         |                 |
 *                     v                  |                     deadline  its head             |
 *              WAITING_FOR_LINE ---------+                        v         v                 |
 *                     |      line is quiet,                      IDLE    RECEIVING -----------+
 *                     |      permit agrees                                  |
 *                     +--too long, or refused--> IDLE            IDLE <-----+ whole, or deadline
 */
enum cds_bus_state {
    CDS_BUS_CLOSED,
    CDS_BUS_IDLE,             // no transaction
    CDS_BUS_WAITING_FOR_LINE, // until the line is quiet, no stale reply can come, and the permit
                              // agrees
    CDS_BUS_SENDING,          // the packet has begun; the next poll sets the deadline
    CDS_BUS_SENDING_ONLY,     // the packet is on the wire, and no reply is due
    CDS_BUS_AWAITING_REPLY,   // a reply is due: the bytes that come behind the packet are searched
    CDS_BUS_RECEIVING,        // the head of the reply was found; its parameters are taken
} __attribute__((packed));

/* State of the line. */
enum cds_bus_line {
    CDS_BUS_LINE_QUIET,   // nothing but our own transactions
    CDS_BUS_LINE_SUSPECT, // bytes came that no request asked for, or damage, or the line was low,
                          // or a reply failed, within the last two byte times. Nothing is sent
    CDS_BUS_LINE_FAULT,   // low when two byte times were over: a short circuit or a dead driver if
                          // it lasts; one look may have met a start bit
} __attribute__((packed));

/* Parameters a reply must have. A reply that refuses the packet (CDS_ERRORS_OF_PACKET) may also
 * have none. */
#define CDS_REPLY_NONE 0xFF                                     // no reply is due: broadcast
#define CDS_REPLY_MAX  50                                       // READ of the whole control table
#define CDS_REPLY_ANY  (CDS_PARSER_LENGTH_MAX - CDS_LENGTH_MIN) // capacity for `any_length`

/* Priorities of requests that wait in a queue (queue.h); of equal ones the first submitted wins. */
enum cds_priority {
    CDS_PRIORITY_NORMAL,
    CDS_PRIORITY_HIGH,       // goals of a cycle
    CDS_PRIORITY_TORQUE_OFF, // before every other request
} __attribute__((packed));

/* One transaction. The caller owns it, and leaves it, its packet and its reply buffer alone from
 * submit until `result` is no longer CDS_PENDING. The bus never changes the packet: a request that
 * has ended may be submitted again as it stands. */
struct cds_request {
    uint8_t result; // enum cds_result; the next three fields hold only if it is CDS_OK
    uint8_t id;     // ID that answered: of interest after a broadcast PING
    uint8_t error;  // CDS_ERROR_* bits of the reply, 0 if none was due
    uint8_t length; // parameters received; 0 if the servo refused

    struct cds_packet packet;     // the instruction packet
    uint8_t *reply;               // buffer for the parameters of the reply
    uint8_t reply_capacity;       // of `reply`, in bytes
    uint8_t reply_parameters;     // due in the reply: 0 to CDS_REPLY_MAX, or CDS_REPLY_NONE
    bool any_length;              // takes a reply of up to CDS_REPLY_ANY parameters;
                                  // reply_parameters then only sets the deadline
    bool ignores_stale : 1;       // does not wait for stale replies: for a request to which a stale
                                  // reply cannot be taken for the right one, as of a scan
    bool passes_lock : 1;         // is sent while an operation holds the bus: cds_bus_lock()
    bool no_retry : 1;            // is never sent again by the queue
    bool ignores_servo_state : 1; // READ or PING: the permit does not use the return delay and
                                  // status return level known of the servo. For diagnose.h
    uint8_t priority;             // enum cds_priority
    uint8_t servo_index;          // hint for the permit: index of the servo it is for

    void (*on_end)(struct cds_request *); // called from cds_bus_poll() at the end, or NULL; it may
                                          // submit again
    void *context;                        // the caller's, for on_end

    // set by bus, queue and permit:
    uint8_t retries;          // retries used; 0 while the request is not on its way
    bool is_muted;            // the servo's status return level lets it not answer this packet
    uint16_t return_delay_us; // the longest time this servo waits before it answers
    uint16_t permit_epoch;    // epoch in which the permit last found the packet good; 0: not asked
                              // yet. While the first check in parts goes on: the epoch at its
                              // begin, less one
    struct cds_request *next; // the queue's
};

/* A request over the arrays `packet_buffer` and `reply_buffer`. All fields of the first part in
 * their order: valid in C99 and in C++11. */
#define CDS_REQUEST(packet_buffer, reply_buffer)                                                   \
    {                                                                                              \
        0, 0, 0, 0, {(packet_buffer), sizeof(packet_buffer), 0}, (reply_buffer),                   \
            sizeof(reply_buffer), 0, false, false, false, false, false, 0, 0, NULL, NULL, 0,       \
            false, 0, 0, NULL                                                                      \
    }

/* A request over the array `packet_buffer` whose replies have no parameters: PING, WRITE, SYNC
 * WRITE and the like. */
#define CDS_REQUEST_WITHOUT_DATA(packet_buffer)                                                    \
    {                                                                                              \
        0, 0, 0, 0, {(packet_buffer), sizeof(packet_buffer), 0}, NULL, 0, 0, false, false, false,  \
            false, false, 0, 0, NULL, NULL, 0, false, 0, 0, NULL                                   \
    }

/* Counted modulo 65536 from cds_bus_open() on. After the end of each transaction
 * sent = ok + timeouts + corrupt. */
struct cds_stats {
    uint16_t sent;          // instruction packets, retries among them
    uint16_t retried;       // packets sent again because no good reply had come
    uint16_t ok;            // transactions that ended well, those without a reply among them
    uint16_t timeouts;      // transactions without a good reply, and without damage
    uint16_t corrupt;       // transactions without a good reply, but with damage
    uint16_t line_busy;     // requests that ended as CDS_LINE_BUSY: no packet was sent
    uint16_t malformed;     // would-be packets with a wrong LENGTH or checksum
    uint16_t noise_bytes;   // bytes that begin no packet; an FF and the byte after it count once
    uint16_t stale_replies; // good packets of the servo whose transaction had just failed
    uint16_t duplicate_replies; // good packets of the servo that had just answered: two have its ID
    uint16_t unexpected_packets; // good packets of another servo or of another length
    uint16_t framing_errors;     // bytes damaged: noise, collision or another baud rate
    uint16_t overruns;           // bytes lost because other handlers held up the receive handler
                                 // for more than 285 cycles at 1 Mbps (avr.h)
    uint16_t ring_overflows;     // bytes lost because no poll took them in time
    uint16_t echo_errors;        // own bytes that came back changed: another station talked too
};

/* A good packet that was not the reply due. */
enum cds_bus_event {
    CDS_EVENT_STALE_REPLY,
    CDS_EVENT_DUPLICATE_REPLY,
    CDS_EVENT_UNEXPECTED_PACKET,
} __attribute__((packed));

/* What an upper layer adds to a bus: a queue (queue.h), or the servos with their permit (servos.h).
 * Each function gets `context`, and must be there unless its comment allows NULL. The bus calls
 * them from cds_bus_submit(), cds_bus_cancel(), cds_bus_open() and cds_bus_poll(); the cycle calls
 * permit_goal and changed_since, and the registered move calls set_move. */
struct cds_bus_hooks {
    void *context; // passed to each function

    /* May the packet leave? CDS_OK; CDS_PENDING: the check goes on, ask again at the next poll;
     * else why not. Asked at the submit, and at each later attempt to send the
     * packet. Sets request->return_delay_us and request->is_muted. NULL: every packet may leave;
     * on_sending and on_packet are not called. */
    enum cds_result (*permit)(void *context, struct cds_request *request);

    /* The bus has another request. Takes `request` over, its result then being CDS_PENDING. CDS_OK,
     * or why not. */
    enum cds_result (*submit)(void *context, struct cds_request *request);

    /* Takes back a request that was taken over. NULL: cds_bus_open() begins; takes all requests
     * back. False: the hook does not have the request. */
    bool (*cancel)(void *context, struct cds_request *request);

    /* Called from polls while a packet that expects no reply is on the wire. True while it has
     * more to do before the transaction may end. */
    bool (*on_sending)(void *context, struct cds_request *request);

    /* A request has ended as `result`, its packet sent or not. The bus is free: the next request
     * may be given to cds_bus_start(). Returns the final result, `result` as a rule; CDS_PENDING:
     * the request is kept, to be sent again. From cds_bus_cancel() the answer is not used. */
    enum cds_result (*request_ended)(void *context, struct cds_request *request,
                                     enum cds_result result);

    /* A good packet that was not due came from servo `id` with `error` bits. */
    void (*on_packet)(void *context, enum cds_bus_event event, uint8_t id, uint8_t error);

    /* For goals of a cycle (cycle.h), which are checked when they are set. May servo `id` be sent
     * the goal and speed `goal` (4 bytes, as registers 0x1E to 0x21)? `*index`: hint, index of the
     * servo; set to the index found. NULL: it may. */
    enum cds_result (*permit_goal)(void *context, uint8_t id, uint8_t *index, const uint8_t *goal);

    /* Which servo's answers of the permit may have changed since `*epoch`: CDS_NO_ID, none; its ID;
     * or CDS_BROADCAST_ID, more than one. Sets `*epoch` to now. NULL: none. */
    uint8_t (*changed_since)(void *context, uint16_t *epoch);

    /* For registered_move.c: `request` carries the registered move that begins; NULL: none of its
     * REG WRITE or ACTION follows. The permit lets REG WRITE and ACTION of this request reach
     * servos with limits, as far as its rules for a move allow (docs/internals/permit.md). NULL: no
     * permit.
     */
    void (*set_move)(void *context, const struct cds_request *request);
};

/* Of the operation that holds the bus: cds_bus_lock(). After abort() the operation sends nothing
 * more. It has restored rate and return delay and ended the lock, or does so from within
 * cds_bus_poll() when its packet on the wire has been answered. Until then a request for the
 * servos' own rate can be submitted only if baud_reg is the rate of the bus. */
struct cds_bus_lock {
    void (*abort)(void *context); // ends the operation; torque off calls it
    void *context;                // for abort
    uint8_t baud_reg;             // the rate that the operation will restore, as register 0x04
};

/* What the bus itself counts of struct cds_stats, under the same names. The fields are internal. */
struct cds_bus_counts {
    uint16_t sent, retried, timeouts, corrupt, line_busy, malformed;
    uint16_t not_due[3]; // good packets, by enum cds_bus_event
    uint16_t framing_errors, overruns, ring_overflows;
};

/* All state of one bus. Zero it (static storage is), then cds_bus_open(). The fields are internal.
 */
struct cds_bus {
    uint8_t state;               // enum cds_bus_state
    uint8_t gate;                // GATE_* bits (line_internal.h): what the bus must check before a
                                 // packet leaves
    uint8_t phase;               // WAIT_* value or reception bits (bus.c), by `state`
    uint8_t closing_end;         // end of the ring at the poll that found the deadline over: later
                                 // bytes are not in time
    uint8_t port;                // number of the bus on its board
    uint8_t timer_wraps;         // expiries of the timer that come before the deadline
    uint8_t last_id;             // of the last transaction with a reply due, or CDS_NO_ID
    uint8_t last_result;         // of that transaction, enum cds_result
    uint8_t baud_reg;            // register 0x04 of its rate
    uint8_t ring_overflows;      // times the ring was full, modulo 256
    struct cds_request *request; // the transaction, or NULL
    struct cds_parser parser;
    uint16_t byte_time_us;    // ten bits
    uint16_t return_delay_us; // longest of any servo on this bus
    uint16_t begun_ticks;     // when the packet in flight began, of cds_port_ticks()
    uint16_t deadline_65ms;   // time of the clock, in units of 2^16 us, from which on the deadline
                              // is over, however many expiries a late poll has missed
    uint16_t rest_us;         // length of the rest, a pause: packets that expect a reply wait for
                              // its end
    uint32_t rest_from_us;    // time at which the rest began: the line was last seen in use
    const struct cds_bus_hooks *hooks; // or NULL; stays when the bus is opened again
    const struct cds_bus_lock *lock;   // of the operation that holds the bus, or NULL
    struct cds_link link;
    struct cds_bus_counts stats; // last: an AVR reaches the first 64 bytes with less code
};

/* Opens the bus on `port` (0 to the board's number of buses - 1) at 2 000 000 / (baud_reg + 1)
 * bit/s (`baud_reg` 0 to 254) and listens. A program that opens the bus while other stations talk
 * should wait for two byte times before the first request. `port` is not checked: it must be the
 * number this very bus was bound to (on an AVR by CDS_AVR_BUS(bus, port)). Stats start at 0. If the
 * bus was open already, requests in flight or waiting end as CDS_CANCELLED, without on_end, a lock
 * ends, and packets that expect a reply wait for CDS_STALE_REPLY_US. Hooks stay. */
void cds_bus_open(struct cds_bus *bus, uint8_t port, uint8_t baud_reg);

/* Changes the rate to 2 000 000 / (baud_reg + 1) bit/s, `baud_reg` 0 to 254 as in register 0x04;
 * stats and settings stay. CDS_OK; CDS_BUSY: a request is in flight or waits, nothing was changed;
 * CDS_BAD_ARGUMENT: the bus is not open, or there is no such rate. */
enum cds_result cds_bus_set_baud(struct cds_bus *bus, uint8_t baud_reg);

/* Sets how long the slowest servo of the bus waits before it replies, in microseconds: twice its
 * register 0x05. CDS_RETURN_DELAY_MAX_US from cds_bus_open() on, which is safe; the true value ends
 * a timeout sooner (manual, example 8). For packets that begin from now on. */
void cds_bus_set_return_delay(struct cds_bus *bus, uint16_t return_delay_us);

/* Sends the packet of `request`, which cds_packet_end() has accepted: at once if the bus is free,
 * else, with a queue (queue.h), in its turn. A request that was built and has ended may be
 * submitted again as it stands: the fastest way to ask the same again.
 *
 *   CDS_OK            accepted: request->result is CDS_PENDING until it ends
 *   CDS_BUSY          this very request is on its way already; or another one is, and the bus has
 *                     no queue; or an operation holds the bus (cds_bus_lock())
 *   CDS_BAD_ARGUMENT  the bus is not open, the packet was never ended, or reply_parameters is
 *                     above CDS_REPLY_MAX
 *   CDS_NO_ROOM       the reply would not fit reply_capacity
 *   CDS_NO_REPLY_DUE, CDS_LIMIT, CDS_INHIBITED, CDS_TOO_EARLY, CDS_RESERVED
 *                     the permit refuses it (servos.h)
 *
 * With any result but CDS_OK nothing was sent, and request->result is that result, unless the
 * request is on its way. How it ends (request->result):
 *
 *   CDS_OK            the servo has answered, or no reply was due. A servo that refuses answers
 *                     too, as a rule without parameters: look at request->error and ->length
 *   CDS_TIMEOUT       no good reply by the deadline, and no damage: no reply, or one cut short
 *   CDS_CORRUPT       no good reply by the deadline, and a byte or a packet was damaged
 *   CDS_LINE_BUSY     the line did not become quiet in time, nothing was sent
 *   CDS_CANCELLED     see cds_bus_cancel(), cds_bus_open()
 *   CDS_NO_REPLY_DUE, CDS_LIMIT, CDS_INHIBITED, CDS_TOO_EARLY, CDS_RESERVED
 *                     the permit refuses it since something has changed; nothing was sent
 *
 * The deadline is the time of packet and reply, the return delay and CDS_REPLY_MARGIN_US. */
enum cds_result cds_bus_submit(struct cds_bus *bus, struct cds_request *request);

/* For a queue: begins the transaction of `request`, whose result is CDS_PENDING, on a bus without a
 * transaction; its packet leaves now or, as soon as line and permit agree, from cds_bus_poll(). */
void cds_bus_start(struct cds_bus *bus, struct cds_request *request);

/* For a queue: takes back the request that waits for the line, to start another one first. Returns
 * it, its result still CDS_PENDING; NULL: the packet has left already, or there is none. */
struct cds_request *cds_bus_take_back(struct cds_bus *bus);

/* Takes back a request that waits for its turn or for the line: it ends as CDS_CANCELLED, and its
 * on_end is not called. CDS_OK; CDS_BUSY: its packet has left, and it will end by its deadline;
 * CDS_BAD_ARGUMENT: it is not on this bus. */
enum cds_result cds_bus_cancel(struct cds_bus *bus, struct cds_request *request);

/* Moves the transaction on; to be called from the main loop, as often as it turns. Each call does
 * one thing of bounded length, and ends at most one transaction. Returns true while there is one.
 * Called late it loses nothing that fits the ring (CDS_RING_SIZE bytes): what came is examined
 * before the deadline is judged. */
bool cds_bus_poll(struct cds_bus *bus);

/* Attaches `hooks`, which stay in place. CDS_OK; CDS_BUSY: others are attached, or a request is in
 * flight. The same ones again: CDS_OK. */
enum cds_result cds_bus_attach(struct cds_bus *bus, const struct cds_bus_hooks *hooks);

/* Gives the bus to one operation: until cds_bus_unlock() requests without `passes_lock` are
 * answered by CDS_BUSY. Requests that were accepted before are still sent, retries too, and the
 * rate cannot be changed before they have ended. The operation gives its requests
 * CDS_PRIORITY_NORMAL: they leave behind all of these, and then only requests with `passes_lock`
 * leave. Torque off passes the lock, and leaves first. `lock` stays in place. CDS_OK, also if
 * `lock` holds the bus already; CDS_BUSY: another operation holds it; CDS_BAD_ARGUMENT: the bus is
 * not open. */
enum cds_result cds_bus_lock(struct cds_bus *bus, const struct cds_bus_lock *lock);

/* Ends the lock if `lock` holds the bus. */
void cds_bus_unlock(struct cds_bus *bus, const struct cds_bus_lock *lock);

/* True while a transaction is in flight or waits. */
static inline bool cds_bus_is_busy(const struct cds_bus *bus)
{
    return bus->request;
}

/* True while a stale reply may come, as last seen by cds_bus_poll(): packets that expect a reply
 * wait. */
bool cds_bus_is_resting(const struct cds_bus *bus);

/* Returns how the line is (CDS_BUS_LINE_*), as last seen by cds_bus_poll() while no packet was in
 * flight. */
enum cds_bus_line cds_bus_line(const struct cds_bus *bus);

/* Copies the stats. */
void cds_bus_stats(const struct cds_bus *bus, struct cds_stats *out);

/* Parameter `index` of the reply as a byte, or as a word (low byte first, R28), into *out. CDS_OK
 * only if the transaction succeeded and that many parameters came; else *out is left as it was and
 * the reason is returned: request->result, or CDS_REFUSED if the servo answered without data. */
enum cds_result cds_request_byte(const struct cds_request *request, uint8_t index, uint8_t *out);
enum cds_result cds_request_word(const struct cds_request *request, uint8_t index, uint16_t *out);

#ifdef __cplusplus
}
#endif

#endif
