/* One half-duplex bus, the exchange in flight on it and those that wait. An exchange is an
 * instruction packet and the status packet that answers it, if one is due. Manual: 2.1; status
 * return level and return delay: 3.1, registers 0x05 and 0x10.
 *
 * Nothing here waits: a call submits and returns, cds_bus_poll() moves things on, and the request
 * says how it ended. All functions: main context, interrupts on.
 *
 * Nothing is sent into a line that others use. If a byte came that nobody asked for, or the line is
 * low, the line must be high for two byte times first. If it does not become so in time, the
 * request ends as CDS_LINE_BUSY, and the bus recovers by itself.
 *
 * Counters: every packet sent ends as ok, timeout or corrupt, so sent = ok + timeouts + corrupt
 * once the bus is idle.
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

/* Baud register of the servos' factory setting: 1 Mbps. */
#define CDS_BAUD_1M 1

/* The highest baud register: 7843 bit/s. */
#define CDS_BAUD_MAX 254

/* Added to the time a reply may take: a servo renews its control loop and serves its own
 * interrupts; this is our estimate, in microseconds. */
#define CDS_REPLY_MARGIN_US 100

/* The longest return delay register 0x05 can ask for, in microseconds (254 x 2). */
#define CDS_RETURN_DELAY_MAX_US 508

/* A reply that begins up to so many microseconds behind the end of its packet is never taken for
 * the reply to a later packet: see cds_bus_rests(). Register 0x05 allows 508; the rest is for
 * servos that are slower than their register says. */
#define CDS_STALE_REPLY_US 2000

/* Parameters of a reply that one poll takes. What is looked for in it: CDS_PARSER_SKIPPED_MAX bytes
 * that begin no packet are passed over, or one packet that is none, or not due. */
#define CDS_BUS_BYTES_PER_POLL 12

/* State of the line. */
enum cds_bus_state {
    CDS_BUS_OK,    // quiet but for our exchanges
    CDS_BUS_BUSY,  // not known to be quiet: heard from unasked, or a reply came damaged, within the
                   // last two byte times; or just opened again. Nothing is sent
    CDS_BUS_FAULT, // low when looked at two byte times behind the last byte: short circuit, or a
                   // dead driver, if it lasts; one look may have met a start bit
};

/* How many parameters a reply must have; one that refuses the packet (CDS_ERRORS_OF_PACKET) may
 * also have none. */
#define CDS_REPLY_NONE 0xFF // no reply is due (broadcast, or the status return level)
#define CDS_REPLY_MAX  50   // a READ of the whole control table
#define CDS_REPLY_ANY                                                                              \
    (CDS_PARSER_LENGTH_MAX - CDS_LENGTH_MIN) // with any_length: `room` for so many

/* In `urgent` of a request: the request goes before urgent requests too. For torque off
 * (torque_off.h).
 */
#define CDS_URGENT_FIRST 2

/* One exchange: filled in by the typed calls of servo.h and sync_write.h, owned by the caller, who
 * leaves it and its buffer alone from submit until `result` is no longer CDS_PENDING. */
struct cds_request {
    struct cds_packet packet; // the instruction packet; then the reply's parameters in its buffer
    void (*on_end)(struct cds_request *); // called from cds_bus_poll() when it has ended, or NULL;
                                          // it may submit again, a READ built anew
    void *owner;                          // the caller's, for on_end
    struct cds_request *next;             // the bus's own
    uint16_t return_delay_us;             // the longest this servo waits; by whoever judges, or
                                          // set when it has begun
    uint8_t reply_parameters;             // due in the reply: 0 to CDS_REPLY_MAX, or CDS_REPLY_NONE
    uint8_t repeats; // how often it may still be sent again if no good reply comes: set by the
                     // calls of servo.h, where cds_bus_set_repeats() is used, and counted down
    uint8_t urgent;  // 0; 1: before requests with 0; CDS_URGENT_FIRST: before all others
    bool any_length; // a reply of up to CDS_REPLY_ANY parameters is taken; reply_parameters only
                     // says how long one may last
    uint8_t vetted;  // bit 0: skip the observer's check once; the observer clears it. Bits 1 to 7
                     // belong to the observer
    uint8_t result;  // enum cds_result; the fields below hold only if it is CDS_OK
    uint8_t id;      // who answered (of interest after a broadcast PING)
    uint8_t error;   // CDS_ERROR_* bits of the reply, 0 if none was due
    uint8_t length;  // parameters received; 0 if the servo refused
    /* True: sent in a rest too (cds_bus_rests()). For a request to which a stale reply does no
     * harm: a scan asks each ID once, so a stale reply has another ID. */
    bool skips_rest;
};

/* A request over `buffer`, an array of the caller's that holds the packet and the reply. All
 * fields, in their order and without names: good in C99 and in C++11. */
#define CDS_REQUEST(buffer)                                                                        \
    {                                                                                              \
        {(buffer), sizeof(buffer), 0}, 0, 0, 0, 0, 0, 0, 0, false, 0, 0, 0, 0, 0, false            \
    }

/* Counted modulo 65536 from cds_bus_open() on; what the line does to bytes, modulo 256 between two
 * polls. */
struct cds_counters {
    uint16_t sent;           // instruction packets, repeated ones too
    uint16_t repeated;       // ... of them, because no good reply had come
    uint16_t ok;             // exchanges that ended well, no reply due included
    uint16_t timeouts;       // ... without a reply by the deadline
    uint16_t corrupt;        // ... with nothing but damage by the deadline
    uint16_t unsent;         // requests that ended as CDS_LINE_BUSY: no packet was sent
    uint16_t refuted;        // LENGTH or checksum of a would-be packet wrong
    uint16_t stray;          // bytes, each with the FF before it, that began no packet: noise, or
                             // what is left of one: a second servo of that ID may be behind it
    uint16_t late;           // good packets that were not the reply due: of the servo that had just
                             // been given up
    uint16_t extra;          // ... of the one that had just answered: two have its ID
    uint16_t foreign;        // ... of another one, or of another length
    uint16_t framing_errors; // bytes damaged: noise, collision or another baud rate
    uint16_t overruns;       // bytes lost because a handler was held up: by others, for more than
                             // 285 cycles at 1 Mbps (cds55xx_avr.h)
    uint16_t ring_overflows; // bytes lost because nobody polled and the line babbled
    uint16_t echo_errors;    // own bytes that came back changed: another talked too
};

/* What is told to whoever watches a bus. */
enum cds_bus_event {
    CDS_BUS_ENDED,   // an exchange, or one try of several
    CDS_BUS_LATE,    // a packet was counted as `late`, ...
    CDS_BUS_EXTRA,   // ... `extra`
    CDS_BUS_FOREIGN, // ... or `foreign`
};

/* One piece of news. */
struct cds_bus_news {
    uint8_t event;       // enum cds_bus_event
    uint8_t id;          // who sent the packet; of ENDED: who was asked
    uint8_t error;       // CDS_ERROR_* bits of the packet, 0 if there was none
    uint8_t result;      // of ENDED: enum cds_result of this try
    uint8_t instruction; // of ENDED, CDS_PING and so on, with its first parameter: the
    uint8_t address;     // packet itself has given way to the reply by now
    const struct cds_request *request; // of ENDED; its result is not set yet
};

/* Whoever watches a bus: servos.h. Called from submit, poll and cds_bus_would_admit(). */
struct cds_bus_observer {
    /* May this be sent? CDS_OK, or why not. It may say that no reply is due (reply_parameters =
     * CDS_REPLY_NONE) and how long the servo waits (cds_bus_set_return_delay_of_()). Asked when a
     * request is submitted and, its result then being CDS_PENDING, when its turn has come that it
     * had to wait for, or to be sent once more. */
    enum cds_result (*admit)(struct cds_bus_observer *observer, struct cds_request *request);
    /* Would `admit` pass a SYNC WRITE of this block? A return delay is not judged here. */
    enum cds_result (*admit_block)(struct cds_bus_observer *observer, uint8_t id, uint8_t address,
                                   const uint8_t *data, uint8_t length);
    void (*on_news)(struct cds_bus_observer *observer, const struct cds_bus_news *news);
    uint16_t epoch;     // counts on whenever `admit` may say something else than before
    uint8_t changed_id; // whom the last count concerns, or CDS_BROADCAST_ID
};

/* How far the bus is with its first request. */
enum cds_bus_flight {
    CDS_BUS_CLOSED,
    CDS_BUS_WAITS, // it waits for its turn
    CDS_BUS_IDLE,  // there is none
    CDS_BUS_BEGUN, // its packet is on the wire; what is due was not looked at yet
    CDS_BUS_TELLS, // ... no reply is due
    CDS_BUS_ASKS,  // ... a reply is due, and what comes is searched for it
    CDS_BUS_TAKES, // ... and what begins as it should is taken as it comes
};

/* What an instruction packet asks for, where that must be known when the reply has taken its place.
 */
struct cds_bus_asked {
    uint8_t instruction;
    uint8_t first; // parameter: an address, if there is any; else anything
    uint8_t last;  // parameter: of READ the length
};

/* All state of one bus. Zero it (static storage is), then cds_bus_open(). */
struct cds_bus {
    struct cds_request *request; // in flight, then those that wait, in their order; or NULL
    struct cds_parser parser;
    uint8_t port;              // number of the bus on its board
    uint8_t flight;            // enum cds_bus_flight
    uint8_t line;              // enum cds_bus_state
    bool rests;                // until `rest_until_us`: a stale reply may come
    bool last_look;            // the request that waits ends unless the line is quiet when the
                               // timer expires
    bool closing;              // the deadline is over, and bytes up to this index of the
    uint8_t close_at;          // ring are still looked at
    bool has_ended;            // an exchange with a reply due, since the bus was opened at this
    uint8_t last_id;           // rate: ID of the last one,
    uint8_t last_result;       // and enum cds_result
    uint8_t looked_to;         // the ring was searched up to this index
    uint8_t at;                // of the reply that is taken: index of its next byte in the ring,
    uint8_t last;              // and of its checksum
    uint8_t sum;               // ... of its bytes from the ID on
    uint8_t *to;               // ... where its next parameter goes
    uint8_t laps;              // how often the timer expires before its time
    uint8_t asked;             // who was asked
    struct cds_bus_asked what; // and for what
    uint16_t return_delay_us;  // longest of any servo on this bus
    uint16_t byte_time_us;     // ten bits
    uint16_t begun_at;         // when the packet in flight began, by cds_port_ticks()
    uint16_t over_at;          // when all `laps` are over, in 2^16 us: for polls that miss one
    uint32_t quiet_from_us;    // when the line will be quiet, unless others use it meanwhile
    uint32_t rest_until_us;    // when the rest is over
    struct cds_link link;
    uint8_t baud;                 // register value of its rate
    uint8_t repeats;              // given to each request that bears repeating
    struct cds_counters counters; // `stray` and `echo_errors` stay elsewhere until asked for
    uint8_t overfull;             // how often the stream broke for want of room, modulo 256
    // what follows stays when a bus is opened again:
    struct cds_bus_observer *observer; // or NULL; by cds_bus_set_observer()
    bool has_queue;                    // by cds_bus_set_queue()
};

/* Opens the bus on `port` (0 to the board's number of buses - 1) at 2 000 000 / (baud + 1) bit/s
 * (`baud` 0 to 254) and listens. What went on on the line before is not known: who opens it amid
 * the talk of others should wait for two byte times before the first request. `port` is not
 * checked: it must be the number this very bus was bound to (on an AVR by CDS_AVR_BUS(bus, port)).
 * There a number the board does not have works the registers of port 0, one that no bus is bound to
 * restarts the program at the first interrupt, and one bound to another bus mixes up the two.
 * Counters start at 0. If the bus was open already, requests in flight or waiting end as
 * CDS_CANCELLED, without on_end, and the bus rests for CDS_STALE_REPLY_US (cds_bus_rests()). */
void cds_bus_open(struct cds_bus *bus, uint8_t port, uint8_t baud);

/* Goes on at 2 000 000 / (baud + 1) bit/s, `baud` 0 to 254 as in register 0x04; counters and
 * settings stay. CDS_OK; CDS_BUSY: a request is in flight or waits, nothing was touched;
 * CDS_BAD_ARGUMENT: no bus is open, or there is no such rate. */
enum cds_result cds_bus_set_baud(struct cds_bus *bus, uint8_t baud);

/* Tells how long the slowest servo of the bus waits before it replies, in microseconds: twice its
 * register 0x05. CDS_RETURN_DELAY_MAX_US from cds_bus_open() on, which is safe; the true value ends
 * a timeout sooner (manual, example 8). For what begins from now on. A timeout that comes sooner is
 * followed by a longer rest (cds_bus_rests()). */
void cds_bus_set_return_delay(struct cds_bus *bus, uint16_t return_delay_us);

/* The same for one request that was submitted: for the observer, in `admit`. */
void cds_bus_set_return_delay_of_(struct cds_request *request, uint16_t return_delay_us);

/* Sets how often a request is sent again when no good reply has come: `repeats`, 0 to 2; 0 from
 * cds_bus_open() on. Only what does the same when done twice is repeated: PING, READ, and WRITE but
 * of ID, baud rate and LOCK. What a servo has refused is never repeated. What is more urgent goes
 * before a repeat. */
void cds_bus_set_repeats(struct cds_bus *bus, uint8_t repeats);

/* Gives the bus a queue (true), in which requests wait behind the one in flight for their turn, or
 * takes it away: then, as from zeroed storage on, what is submitted meanwhile is refused as
 * CDS_BUSY. A program that never asks for a queue does not pay for one. What sends beside others
 * asks for it by itself: cycle.h, health.h, torque_off.h. What has steps of its own, as scan.h or
 * group_read.h, needs one if others submit too; without it a step may end it as CDS_BUSY. Before or
 * after cds_bus_open(), which leaves it as it is. */
void cds_bus_set_queue(struct cds_bus *bus, bool on);

/* Sends the packet of `request`, which cds_packet_end() has accepted: at once if the bus is free,
 * else in its turn, after those submitted before it that are as urgent, or more so.
 * CDS_OK: request->result is CDS_PENDING until it ends. CDS_BUSY: this very request is on its way
 * already, and nothing was touched; or another one is, and the bus has no queue
 * (cds_bus_set_queue()). CDS_BAD_ARGUMENT: no bus is open, the packet was never ended, or
 * reply_parameters is above CDS_REPLY_MAX. CDS_NO_ROOM: the reply would not fit the buffer.
 * CDS_NO_REPLY_DUE, CDS_LIMIT, CDS_INHIBITED, CDS_TOO_EARLY: the observer does not admit it
 * (servos.h). All but the first: nothing was sent.
 *
 * Any result but CDS_OK, of the call or of the request, and the fields of a reply mean nothing. Its
 * parameters take the packet's place as they come. So a request whose reply has some must be built
 * again before it is submitted again, however it has ended.
 *
 * How it ends: CDS_OK; CDS_TIMEOUT, CDS_CORRUPT: no good reply by the deadline, which is the time
 * its bytes and the reply's take, the return delay and CDS_REPLY_MARGIN_US, and again for each
 * repeat, counted exactly if a poll follows within 32 ms; CDS_LINE_BUSY: the line did not become
 * quiet within the time the longest reply takes with the longest return delay and that margin, nor
 * in the last two byte times, which begin with a poll of their own, and nothing was sent;
 * CDS_CANCELLED; CDS_NO_REPLY_DUE, CDS_LIMIT, CDS_INHIBITED, CDS_TOO_EARLY: the observer has
 * changed its mind since, and it was not sent, or not once more. */
enum cds_result cds_bus_submit(struct cds_bus *bus, struct cds_request *request);

/* The same in two steps, for the library's own calls, so that the header of a packet that was found
 * good, and whose reply has room, is on the wire before the rest of it is built. Has it begun, or
 * is it not its turn? The rest must follow at once: the packet, whole but for a checksum that will
 * be there within a few byte times; returns what cds_bus_submit() does. */
uint8_t cds_bus_begin_(struct cds_bus *bus);
uint8_t cds_bus_begin_judged_(struct cds_bus *bus); // ... of what the observer has admitted already
uint8_t cds_bus_follow_(struct cds_bus *bus, struct cds_request *request, uint8_t begun);

/* The first request, which was found good, is sent if the line is quiet and the bus does not rest,
 * else it waits. False: it has waited for too long. */
bool cds_bus_begin_turn_(struct cds_bus *bus);
void cds_bus_wait_for_turn_(struct cds_bus *bus); // from the next poll on

/* What is due for the packet that has begun, and by when: the first poll sees to that. */
void cds_bus_expect_(struct cds_bus *bus);

/* Is the first request on the wire, or its answer awaited? */
static inline bool cds_bus_is_in_flight_(const struct cds_bus *bus)
{
    return bus->flight > CDS_BUS_IDLE;
}

/* Hooks. A program has those of account.c if it reads counters by cds_bus_counters() or has an
 * observer, those of repeat.c if it calls cds_bus_set_repeats(), that of asked.c with either of the
 * two, and those of queue.c if it calls cds_bus_set_queue(); else they do nothing, and cost
 * nothing.
 */
bool cds_bus_is_watched_(const struct cds_bus *bus);                      // has it an observer?
uint8_t cds_bus_judge_(struct cds_bus *bus, struct cds_request *request); // admitted? or why not
void cds_bus_note_sent_(struct cds_bus *bus);                             // the first request
void cds_bus_note_packet_(struct cds_bus *bus);                           // ... while it is sent
void cds_bus_note_end_(struct cds_bus *bus, uint8_t result);              // ... of its exchange
void cds_bus_note_break_(struct cds_bus *bus); // the stream is broken: before it is mended
void cds_bus_note_undue_(struct cds_bus *bus); // the parser has a packet that is no reply due
void cds_bus_count_(uint16_t *counter);
const struct cds_bus_asked *cds_bus_asked_(const struct cds_bus *bus); // for account.c, repeat.c
bool cds_bus_repeat_(struct cds_bus *bus);       // is the first request sent once more?
bool cds_bus_queues_(const struct cds_bus *bus); // may a request wait behind another one?
struct cds_request *cds_bus_next_of_(const struct cds_request *request); // who waits behind it
bool cds_bus_insert_(struct cds_bus *bus, struct cds_request *request, uint8_t urgent); // first?
void cds_bus_begin_next_(struct cds_bus *bus, uint8_t result); // behind one that has ended so
uint8_t cds_bus_repeats_of_(const struct cds_bus *bus, const uint8_t *bytes); // of a packet

/* Has `observer`, which must stay, watch the bus; NULL: nobody. */
void cds_bus_set_observer(struct cds_bus *bus, struct cds_bus_observer *observer);

/* Would the observer of the bus admit a SYNC WRITE of the `length` bytes (1 to 50) of `data` from
 * register `address` on to servo `id` (0 to 253)? CDS_OK, also if there is none; CDS_LIMIT,
 * CDS_INHIBITED. Nothing is sent.
 */
enum cds_result cds_bus_would_admit(struct cds_bus *bus, uint8_t id, uint8_t address,
                                    const uint8_t *data, uint8_t length);

/* Takes back a request that waits for its turn, or for a quiet line: it ends as CDS_CANCELLED,
 * without on_end. CDS_OK; CDS_BUSY: it is in flight and will end by its deadline; CDS_BAD_ARGUMENT:
 * it is not on this bus.
 */
enum cds_result cds_bus_cancel(struct cds_bus *bus, struct cds_request *request);

/* Moves the exchange in flight on and begins the next; to be called from the main loop, as often as
 * it turns. Ends at most one exchange and calls its on_end. Returns true while there is work.
 * Called late it loses nothing: what came is parsed before the deadline is judged, in
 * each poll no more than CDS_BUS_BYTES_PER_POLL tells. */
bool cds_bus_poll(struct cds_bus *bus);

/* True while the bus rests. `now_us` as of cds_port_now_us().
 *
 * A transaction that ended without a good reply may be answered later, and a stale reply of the
 * right ID and LENGTH looks like the reply to the next READ. So the bus rests after such an end,
 * until a reply that begins CDS_STALE_REPLY_US behind its packet is over: it begins no transaction
 * that expects a reply, of any servo. Packets that expect none, as SYNC WRITE and all broadcasts
 * but PING, are sent at once. A servo that is slower than CDS_STALE_REPLY_US can still give a wrong
 * value: docs/faults.md, F17-again. */
bool cds_bus_rests(const struct cds_bus *bus, uint32_t now_us);

/* Returns CDS_BUS_OK, CDS_BUS_BUSY or CDS_BUS_FAULT: how the line is. Seen by cds_bus_poll() while
 * no exchange is in flight, so go on polling.
 */
static inline enum cds_bus_state cds_bus_state(const struct cds_bus *bus)
{
    return (enum cds_bus_state)bus->line;
}

/* Copies the counters. A program that never calls this, nor has an observer, does not count. */
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
