/* SPDX-License-Identifier: MIT */
/* Entry points of the analysis, one for each row of ANALYSES in scripts/eva.py. Each makes a state
 * that an invariant allows, makes one call with unknown arguments, and checks the invariant again.
 * So the invariant holds after any number of calls. */
#include <string.h>

#include "bus/bus_internal.h"
#include "bus/line_internal.h"
#include "bus/steps_internal.h"
#include "cds55xx/queue.h"
#include "eva.h"
#include "wire/packet_internal.h"

#define PORT 0

uint8_t eva_remaining;
static struct cds_bus bus;

/* From here on, also in the callers, Eva analyses these states of the bus separately. */
void eva_keep_apart(void)
{
    //@ dynamic_split bus.state;
    //@ dynamic_split bus.request == \null;
}

/* ---- port: each function returns any value that port.h allows ---- */

void cds_port_open(uint8_t port, uint8_t baud)
{
    (void)port, (void)baud;
}

void cds_port_high_z(uint8_t port)
{
    eva_keep_apart();
    (void)port;
}

void cds_port_listen(uint8_t port)
{
    eva_keep_apart();
    (void)port;
}

uint8_t cds_port_talk(uint8_t port, uint8_t byte)
{
    eva_keep_apart();
    (void)port, (void)byte;
    return (uint8_t)any_in(1, 2);
}

void cds_port_follow(uint8_t port)
{
    (void)port;
}

void cds_port_tx(uint8_t port, uint8_t byte)
{
    (void)port, (void)byte;
}

void cds_port_tx_last(uint8_t port, uint8_t byte)
{
    (void)port, (void)byte;
}

bool cds_port_line_is_high(uint8_t port)
{
    eva_keep_apart();
    (void)port;
    return any_bool();
}

uint32_t cds_port_now_us(void)
{
    eva_keep_apart();
    return (uint32_t)any_word() << 16 | any_word();
}

uint16_t cds_port_ticks(void)
{
    eva_keep_apart();
    return any_word();
}

uint8_t cds_port_set_timer(uint8_t port, uint16_t from, uint16_t count, uint16_t each_us,
                           uint16_t more_us)
{
    eva_keep_apart();
    (void)port, (void)from, (void)count, (void)each_us, (void)more_us;
    return (uint8_t)any_in(0, 31);
}

bool cds_port_timer_expired(uint8_t port)
{
    eva_keep_apart();
    (void)port;
    return any_bool();
}

void cds_port_restart_timer(uint8_t port)
{
    (void)port;
}

/* ---- ring: any indices, which the other side may change between any two reads (volatile) ---- */

static struct cds_ring ring;

void eva_ring(void)
{
    uint8_t sum = 0;

    while (any_bool()) {
        switch (any_in(0, 4)) {
        case 0: cds_ring_put(&ring, any_byte()); break;
        case 1: sum ^= cds_ring_at(&ring, any_byte()); break;
        case 2: cds_ring_release(&ring, any_byte()); break;
        case 3: sum ^= cds_ring_after(cds_ring_begin(&ring), any_byte()); break;
        default: sum ^= cds_ring_distance(cds_ring_count(&ring), cds_ring_end(&ring));
        }
    }
}

/* ---- parser: any bytes in the ring, any position ----
 *
 * Analysed without `volatile`: handlers write neither the tail nor the bytes before `end`. */

#define REPLY_MAX (CDS_PARSER_LENGTH_MAX - CDS_LENGTH_MIN)

static struct cds_parser parser;
static uint8_t reply[REPLY_MAX];

static void any_ring(void)
{
    Frama_C_make_unknown((char *)ring.bytes, CDS_RING_SIZE);
    ring.head = any_byte();
    ring.tail = any_byte();
}

/* A search. If it finds the whole head, eva_find_error() analyses its last step. check_invariants()
 * of test/core/bus/bus_random.c checks that LENGTH is in range then. */
void eva_find(void)
{
    any_ring();
    parser.position = any_byte();
    parser.longest = (uint8_t)any_in(0, CDS_PARSER_LENGTH_MAX);
    cds_parser_find(&parser, &ring, any_byte());
    //@ assert parser.found != CDS_FOUND_HEAD || parser.to == \null;
}

/* A search after an earlier call has found the head without ERROR. */
void eva_find_error(void)
{
    uint8_t parsed;

    any_ring();
    ring.tail = any_bool() ? 0 : 230;
    parser.found = CDS_FOUND_LENGTH;
    parser.length = (uint8_t)any_in(CDS_LENGTH_MIN, CDS_PARSER_LENGTH_MAX);
    //@ split ring.tail;
    //@ split parser.length;
    //@ dynamic_split parser.found;
    parsed = cds_parser_find(&parser, &ring, any_byte());
    eva_remaining = cds_ring_distance(parser.position, parser.end);
    if (parsed == CDS_PARSED_HEAD) {
        //@ assert parser.found == CDS_FOUND_HEAD && parser.to == \null;
        //@ assert eva_remaining == parser.length - CDS_LENGTH_MIN;
    } else {
        //@ assert parser.found == CDS_FOUND_LENGTH;
    }
}

/* `remaining` parameters are not yet taken, and the buffer has room for exactly these. One call
 * takes at most CDS_PARSER_TAKEN_MAX, so a few sizes represent all. Positions wrap at 256, and the
 * code only adds and subtracts them, so one position represents all. */
void eva_take(void)
{
    uint8_t remaining = any_bool() ? (uint8_t)any_in(0, CDS_PARSER_TAKEN_MAX + 1) : REPLY_MAX, left;

    any_ring();
    parser.position = 230;
    parser.found = CDS_FOUND_HEAD;
    //@ dynamic_split parser.position;
    //@ split remaining;
    //@ dynamic_split parser.found;
    parser.end = cds_ring_after(parser.position, remaining);
    parser.sum = any_byte();
    parser.to = any_bool() ? reply + REPLY_MAX - remaining : NULL;
    //@ split parser.to == \null;
    if (cds_parser_take(&parser, &ring, any_byte()) == CDS_PARSED_SOME) {
        left = cds_ring_distance(parser.position, parser.end);
        //@ assert parser.found == CDS_FOUND_HEAD;
        //@ assert left <= remaining;
        //@ assert parser.to == \null || parser.to == reply + REPLY_MAX - left;
    }
    //@ assert parser.found != CDS_FOUND_LENGTH;
}

/* ---- packet: any arguments, any data, buffers of every size from 0 to 258 bytes ---- */

#define PACKET_MAX     (CDS_LENGTH_MAX + 4u)
#define CAPACITY_MAX   0xBFFFu
#define SMALL_CAPACITY 60u // a larger buffer no longer matters to a packet for one servo

static uint8_t packet_bytes[PACKET_MAX];

static uint8_t data[CDS_TABLE_SIZE + 1];

static void fill_data(void)
{
    for (uint8_t i = 0; i < sizeof data; i++)
        data[i] = any_byte();
}

/* A buffer of `capacity` bytes, at the end of `packet_bytes`: Eva reports each access beyond it. */
static uint8_t *buffer_of(uint16_t capacity)
{
    return packet_bytes + PACKET_MAX - capacity;
}

/* A length of data bytes: 0, 1 to 50, or more. Eva does not derive these ranges from
 * (uint8_t)(length - 1u) < CDS_TABLE_SIZE. */
static uint8_t any_length(void)
{
    if (any_bool())
        return 0;
    return any_bool() ? (uint8_t)any_in(1, CDS_TABLE_SIZE)
                      : (uint8_t)any_in(CDS_TABLE_SIZE + 1, 255);
}

static struct cds_packet packet;

/* Each instruction as one call. */
void eva_packet_whole(void)
{
    uint16_t capacity = any_in(0, CAPACITY_MAX);
    uint8_t id, address, length;

    fill_data();
    packet.bytes = packet_bytes;
    if (capacity <= SMALL_CAPACITY) {
        //@ split capacity;
        packet.bytes = buffer_of(capacity);
    }
    packet.capacity = capacity;
    id = any_byte();
    address = any_byte();
    length = any_length();
    //@ split length == 0;
    //@ split length > CDS_TABLE_SIZE;
    //@ dynamic_split packet.size >= CDS_PACKET_REFUSED;
    switch (any_in(0, 6)) {
    case 0: cds_packet_ping(&packet, id); break;
    case 1: cds_packet_action(&packet, id); break;
    case 2: cds_packet_reset(&packet, id); break;
    case 3: cds_packet_read(&packet, id, address, length); break;
    case 4: cds_packet_write(&packet, id, address, data, length); break;
    case 5: cds_packet_reg_write(&packet, id, address, data, length); break;
    default: cds_packet_sync_begin(&packet, address, length);
    }
}

/* A packet of any size being built, was refused, was never begun or has ended, in `capacity` bytes.
 */
static void any_packet(uint16_t kind, uint16_t capacity, uint16_t put)
{
    packet.bytes = buffer_of(capacity);
    packet.capacity = capacity;
    if (kind == 0)
        packet.size = CDS_PACKET_BUILDING + put;
    else if (kind == 1)
        packet.size = any_in(CDS_PACKET_REFUSED, UINT16_MAX);
    else
        packet.size = any_in(0, capacity);
}

/* Checks that what any_packet() assumes still holds; so it holds after any number of steps. */
static void check_packet(uint16_t capacity)
{
    if (cds_packet_is_building(&packet)) {
        //@ assert packet.size < CDS_PACKET_BUILDING + capacity;
        //@ assert packet.size < 0x4100;
    } else {
        //@ assert packet.size >= CDS_PACKET_REFUSED || packet.size <= capacity;
    }
}

static void fill_buffer(void)
{
    for (uint16_t i = 0; i < PACKET_MAX; i++)
        packet_bytes[i] = any_byte();
}

/* One step: a parameter or a word is put, or the packet ends. Buffers of 6 to 258 bytes. */
void eva_packet_step(void)
{
    uint16_t capacity = any_in(CDS_PACKET_SIZE(0), PACKET_MAX), put, kind = any_in(0, 2);

    fill_buffer();
    //@ split capacity;
    put = any_in(CDS_AT_PARAMETERS, capacity - 1);
    //@ split kind;
    any_packet(kind, capacity, put);
    switch (any_in(0, 2)) {
    case 0: cds_packet_put(&packet, any_byte()); break;
    case 1: cds_packet_put_word(&packet, any_word()); break;
    default: cds_packet_end(&packet);
    }
    check_packet(capacity);
}

/* One block of a SYNC WRITE. Eva must know both sizes here, and that takes long: so it considers
 * buffers in which nearly no block fits, in which the longest one just fits, and the largest one.
 * Not a larger `capacity`: Eva learns nothing about `end` from !(end & 0x100). */
void eva_packet_sync_add(void)
{
    uint16_t capacity = PACKET_MAX;
    uint16_t put, kind = any_in(0, 2);

    fill_data();
    fill_buffer();
    switch (any_in(0, 2)) {
    case 0: capacity = any_in(CDS_PACKET_SIZE(0), 12); break;
    case 1: capacity = any_in(SMALL_CAPACITY - 4, SMALL_CAPACITY);
    }
    //@ split capacity;
    put = any_in(CDS_AT_PARAMETERS, capacity - 1);
    //@ split kind;
    if (kind)
        put = 0; // without meaning
    //@ split put;
    //@ dynamic_split packet.size >= CDS_PACKET_REFUSED;
    any_packet(kind, capacity, put);
    if (capacity > CDS_AT_SYNC_LENGTH)
        packet.bytes[CDS_AT_SYNC_LENGTH] =
            (uint8_t)any_in(1, CDS_TABLE_SIZE); // cds_packet_sync_begin()
    cds_packet_sync_add(&packet, any_byte(), data);
    check_packet(capacity);
}

/* ---- link: packets of 3 to 20 and of 250 to 258 bytes; the handlers in any order ----
 *
 * Analysed without `volatile`, or Eva would forget where the pointers point: a handler is not
 * interrupted, and the main context writes the pointers only while no event can come. */

static struct cds_link link;

/* What the transmit handlers may do: on_tx_ready only while TALKING, on_tx_complete while DRAINING.
 */
static void transmit(void)
{
    if (link.state == CDS_LINK_TALKING)
        cds_link_on_tx_ready(&link, PORT);
    else if (link.state == CDS_LINK_DRAINING)
        cds_link_on_tx_complete(&link, PORT);
}

static void any_event(bool hears_itself)
{
    if (any_bool())
        transmit();
    else if (hears_itself)
        cds_link_on_rx_echo(&link, any_byte(), (uint8_t)any_in(0, 3));
    else
        cds_link_on_rx(&link, any_byte(), (uint8_t)any_in(0, 3));
}

void eva_link(void)
{
    uint16_t size = any_bool() ? any_in(3, 20) : any_in(PACKET_MAX - 8, PACKET_MAX);
    bool hears_itself = any_bool();
    const uint8_t *packet;

    //@ split size;
    //@ split hears_itself;
    packet = packet_bytes + PACKET_MAX - size;
    link.rx.head = any_byte();
    link.rx.tail = any_byte();
    cds_link_open(&link, PORT);
    while (any_bool()) // nothing was sent yet
        hears_itself ? cds_link_on_rx_echo(&link, any_byte(), (uint8_t)any_in(0, 3))
                     : cds_link_on_rx(&link, any_byte(), (uint8_t)any_in(0, 3));
    cds_link_talk(&link, PORT, packet, size);
    while (any_bool())
        any_event(hears_itself);
    if (any_bool())
        cds_link_abort(&link, PORT);
    while (any_bool())
        any_event(hears_itself);
    cds_link_count(&link.echo_errors);
}

/* ---- bus ----
 *
 * What handlers share with the bus is volatile: Eva assumes that it changes between any two reads.
 * parser_contract.c stands for the parser. `request` is in flight, if any is; `other` and `third`
 * wait in the queue. */

static struct cds_queue queue;
static struct cds_steps steps;
static struct cds_request request, other, third, wrong;

/* Hooks of an upper layer: they return any allowed value. */
static enum cds_result permit(void *context, struct cds_request *asked)
{
    eva_keep_apart();
    (void)context;
    asked->return_delay_us = any_word();
    asked->is_muted = any_bool();
    return (enum cds_result)any_in(CDS_OK, CDS_TOO_EARLY);
}

static enum cds_result hold(void *context, struct cds_request *asked)
{
    (void)context;
    if (!bus.request && any_bool())
        cds_bus_start(&bus, asked);
    return (enum cds_result)any_in(CDS_OK, CDS_TOO_EARLY);
}

static bool cancel(void *context, struct cds_request *asked)
{
    (void)context, (void)asked;
    return any_bool();
}

static bool on_sending(void *context, struct cds_request *asked)
{
    eva_keep_apart();
    (void)context, (void)asked;
    return any_bool();
}

static enum cds_result on_hook_end(void *context, struct cds_request *asked, enum cds_result result)
{
    eva_keep_apart();
    (void)context, (void)asked;
    if (any_bool())
        cds_bus_start(&bus, &other);
    return any_bool() ? CDS_PENDING : result;
}

static void on_packet(void *context, enum cds_bus_event event, uint8_t id, uint8_t error)
{
    eva_keep_apart();
    (void)context, (void)event, (void)id, (void)error;
}

static const struct cds_bus_hooks hooks = {
    .permit = permit,
    .submit = hold,
    .cancel = cancel,
    .on_sending = on_sending,
    .request_ended = on_hook_end,
    .on_packet = on_packet,
};

static void on_end(struct cds_request *ended)
{
    eva_keep_apart();
    if (any_bool())
        cds_bus_submit(&bus, ended);
}

/* A request that cds_request_check() accepts, without its reply. */
static void any_request(struct cds_request *of)
{
    of->result = any_byte();
    of->id = any_byte();
    of->packet.bytes = packet_bytes;
    of->packet.capacity = any_word();
    of->packet.size = any_in(CDS_PACKET_SIZE(0), PACKET_MAX);
    of->reply_parameters = CDS_REPLY_NONE;
    of->ignores_stale = any_bool();
    of->passes_lock = any_bool();
    of->no_retry = any_bool();
    of->priority = any_byte();
    of->on_end = any_bool() ? on_end : NULL;
    of->retries = any_byte();
    of->is_muted = any_bool();
    of->return_delay_us = any_word();
    of->permit_epoch = any_word();
}

/* Gives the request a reply of `due` parameters, and a buffer with place for just so many. */
static void expect(struct cds_request *of, uint8_t due)
{
    of->reply = reply + REPLY_MAX - due;
    of->reply_capacity = of->reply_parameters = due;
}

/* 0 to 2 requests wait. */
static void any_queue(void)
{
    uint8_t waiting = (uint8_t)any_in(0, 2);

    cds_queue_begin(&queue, &bus);
    queue.retries = any_byte();
    any_request(&other);
    any_request(&third);
    expect(&other, 2);
    //@ split waiting;
    if (waiting) {
        queue.first = &other;
        if (waiting == 2)
            other.next = &third;
    }
}

/* A bus in any state that a call may leave; check_bus() checks the same. */
static void any_bus(uint8_t state)
{
    uint8_t remaining = any_bool() ? (uint8_t)any_in(0, CDS_PARSER_TAKEN_MAX + 1) : REPLY_MAX;
    uint8_t due = any_bool() ? (uint8_t)any_in(0, 2) : CDS_REPLY_MAX, way = (uint8_t)any_in(0, 2);
    bool in_packet = state == CDS_BUS_RECEIVING || any_bool();

    any_request(&request);
    Frama_C_make_unknown((char *)packet_bytes, PACKET_MAX);
    Frama_C_make_unknown((char *)&bus.stats, sizeof bus.stats);
    bus.state = state;
    bus.request = state >= CDS_BUS_WAITING_FOR_LINE ? &request : NULL;
    bus.gate = (uint8_t)(any_in(0, GATE_LOCKED | GATE_STALE | GATE_FAULT | GATE_SUSPECT) |
                         (any_bool() ? GATE_LOW : 0));
    bus.phase = (uint8_t)any_in(0, 7);
    if (state != CDS_BUS_RECEIVING && bus.phase == 6)
        bus.phase = 0;
    bus.closing_end = any_byte();
    bus.timer_wraps = any_byte();
    bus.last_id = any_byte();
    bus.last_result = any_byte();
    bus.baud_reg = any_byte();
    bus.ring_overflows = any_byte();
    bus.byte_time_us = any_in(5, 1280);
    bus.return_delay_us = any_word();
    bus.begun_ticks = any_word();
    bus.deadline_65ms = any_word();
    bus.rest_us = any_word();
    bus.rest_from_us = cds_port_now_us();
    bus.parser.position = any_byte();
    bus.parser.longest = (uint8_t)any_in(0, CDS_PARSER_LENGTH_MAX);
    bus.parser.id = any_byte();
    bus.parser.error = any_byte();
    bus.parser.length = (uint8_t)any_in(CDS_LENGTH_MIN, CDS_PARSER_LENGTH_MAX);
    bus.parser.found = any_bool() ? CDS_FOUND_LENGTH : CDS_FOUND_NOTHING;
    if (in_packet)
        bus.parser.found = CDS_FOUND_HEAD;
    bus.parser.is_clean = any_bool();
    bus.parser.to = NULL;
    eva_remaining = (uint8_t)any_in(0, REPLY_MAX);
    //@ split way;
    if (way == 1) {
        any_queue();
        bus.hooks = &queue.hooks;
    } else if (way == 2) {
        any_request(&other);
        bus.hooks = &hooks;
        bus.gate |= GATE_PERMIT;
    }
    if (state == CDS_BUS_RECEIVING) {
        //@ split remaining;
        eva_remaining = remaining;
        bus.parser.to = reply + REPLY_MAX - eva_remaining;
    } else if (state == CDS_BUS_AWAITING_REPLY && any_bool()) {
        request.any_length = true;
        expect(&request, REPLY_MAX);
    } else if (state == CDS_BUS_AWAITING_REPLY) {
        //@ split due;
        expect(&request, due);
    } else if (any_bool()) {
        expect(&request, 2);
    }
}

/* Checks that what any_bus() assumes of numbers still holds. Eva cannot follow `request`, `phase`
 * and `to` where paths join; check_invariants() of test/core/bus/bus_random.c checks those. */
static void check_bus(void)
{
    //@ assert bus.state <= CDS_BUS_RECEIVING;
    //@ assert bus.parser.longest <= CDS_PARSER_LENGTH_MAX;
    if (bus.parser.found == CDS_FOUND_LENGTH) {
        //@ assert CDS_LENGTH_MIN <= bus.parser.length <= CDS_PARSER_LENGTH_MAX;
    }
}

/* Polls, by the state of the bus. */
static void poll(uint8_t state)
{
    any_bus(state);
    eva_keep_apart();
    cds_bus_poll(&bus);
    check_bus();
}

void eva_idle(void)
{
    uint8_t state = (uint8_t)any_in(CDS_BUS_CLOSED, CDS_BUS_SENDING_ONLY);

    //@ split state;
    poll(state);
}

void eva_awaiting(void)
{
    poll(CDS_BUS_AWAITING_REPLY);
}

void eva_receiving(void)
{
    poll(CDS_BUS_RECEIVING);
    if (bus.state == CDS_BUS_RECEIVING) {
        //@ assert bus.parser.to + eva_remaining <= reply + REPLY_MAX;
    }
}

/* Every other call, in any state. */
static void call(void)
{
    struct cds_stats stats;
    uint8_t byte;
    uint16_t word;

    //@ dynamic_split bus.parser.found;
    switch (any_in(0, 14)) {
    case 0: cds_bus_open(&bus, PORT, any_byte()); break;
    case 1: cds_bus_set_baud(&bus, any_byte()); break;
    case 2: cds_bus_set_return_delay(&bus, any_word()); break;
    case 3: cds_bus_submit(&bus, &other); break;
    case 4: cds_bus_submit_prechecked(&bus, &request, any_word()); break;
    case 5: cds_bus_cancel(&bus, any_bool() ? &request : &other); break;
    case 6: cds_bus_attach(&bus, &hooks); break;
    case 7: cds_queue_attach(&queue, &bus); break;
    case 8: cds_bus_lock(&bus, &steps.lock); break;
    case 9: cds_bus_unlock(&bus, &steps.lock); break;
    case 10: cds_bus_stats(&bus, &stats); break;
    case 11: cds_bus_line(&bus), cds_bus_is_resting(&bus); break;
    case 12:
        request.reply = reply;
        request.length = (uint8_t)any_in(0, REPLY_MAX);
        cds_request_byte(&request, any_byte(), &byte);
        cds_request_word(&request, any_byte(), &word);
        break;
    case 13: cds_bus_submit(&bus, &wrong); break;
    default: cds_queue_set_retries(&queue, any_byte());
    }
}

void eva_calls(void)
{
    uint8_t state = (uint8_t)any_in(CDS_BUS_CLOSED, CDS_BUS_AWAITING_REPLY);

    //@ split state;
    any_bus(state);
    wrong.result = any_byte();
    wrong.packet.size =
        any_bool() ? any_in(0, CDS_PACKET_SIZE(0) - 1) : any_in(PACKET_MAX + 1, UINT16_MAX);
    //@ split wrong.packet.size > PACKET_MAX;
    wrong.reply_parameters = any_byte();
    wrong.any_length = any_bool();
    bus.lock = any_bool() ? &steps.lock : NULL;
    eva_keep_apart();
    call();
    check_bus();
}

/* ---- steps ---- */

static enum cds_result send(void *operation)
{
    (void)operation;
    return any_bool() ? cds_bus_submit(&bus, &request) : (enum cds_result)any_in(0, CDS_TOO_EARLY);
}

static void ended(void *operation, enum cds_result result)
{
    (void)operation;
    if (any_bool())
        cds_steps_end(&steps, result);
}

void eva_steps(void)
{
    uint8_t state = (uint8_t)any_in(CDS_BUS_CLOSED, CDS_BUS_SENDING_ONLY);
    bool is_exclusive = any_bool();

    //@ split state;
    //@ split is_exclusive;
    any_bus(state);
    if (any_bool())
        cds_steps_check_exclusive(&bus, &request, any_word(), any_byte());
    is_exclusive ? cds_steps_begin_exclusive(&steps, &bus, &request)
                 : cds_steps_begin(&steps, &bus, &request);
    steps.result = any_byte();
    steps.outcome = any_byte();
    steps.is_submitted = any_bool();
    steps.return_delay_us = any_word();
    steps.lock.baud_reg = any_byte();
    if (any_bool())
        bus.lock = NULL;
    eva_keep_apart();
    switch (any_in(0, 2)) {
    case 0: cds_steps_poll(&steps, &steps, send, ended); break;
    case 1:
        steps.lock.abort ? steps.lock.abort(steps.lock.context) : cds_steps_abort(&steps);
        break;
    default:
        if (request.on_end)
            request.on_end(&request);
    }
    check_bus();
}
